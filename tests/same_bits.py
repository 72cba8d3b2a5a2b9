"""A program that tells whether two versions of kousoku compute the same bits.

``python tests/same_bits.py --write FILE`` writes what this version computes for every committed
scene and for the random ones: rows, states, ledgers, refusals, with both targets.
``python tests/same_bits.py --compare FILE`` computes it again and tells where it differs. It runs
the version that its Python imports: take another one's Python to compare with that.
"""

from __future__ import annotations

import argparse
import base64
import hashlib
import json
import logging
import multiprocessing
import os
import sys
import tempfile
import time
import zlib
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import kousoku
from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.codegen.linkage.generate import generate_linkage
from kousoku.model.errors import KousokuError
from kousoku.model.reading.read import read_scene, scene_from_dict
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.linkage import load_linkage

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from kousoku.model.records.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.run import Run

    Items = dict[str, Any]

ROOT = Path(__file__).parents[1]
SCENES = ROOT / "scenes"
TOO_LARGE = ("families/chain_1000", "families/n_four_bar_40")
"""Scenes that take minutes."""

SLOW_FROM = 30
"""Bodies from which on the NumPy solver is left out: it takes 100 times as long."""

TARGETS: dict[str, tuple[float, int, int]] = {"c": (2.0, 21, 600), "numpy": (0.1, 3, 6)}
"""The last time [s], rows, and most steps with each target."""

WANTED = ("accelerations", "coordinates", "reactions", "energies")
"""What is computed for committed scenes, where they have it."""


@cache
def scenes() -> dict[str, Callable[[], Scene]]:
    """Scenes by name, as functions that read them."""
    # At the end, and after kousoku: that of another checkout stays the one that is measured.
    sys.path.append(str(ROOT))
    from tests.random_scenes import numbered_scenes

    paths = sorted(SCENES.rglob("*.toml"))
    files = {path.relative_to(SCENES).with_suffix("").as_posix(): path for path in paths}
    committed = {name: partial(read_scene, path) for name, path in files.items()}
    random = {tree["name"]: partial(scene_from_dict, tree) for tree in numbered_scenes()}
    return {name: read for name, read in (committed | random).items() if name not in TOO_LARGE}


def array(values: Any) -> Items:
    """Array for the file: its digest and its numbers; all that is NaN is the same."""
    numbers = np.array(values, dtype=np.float64)
    numbers[np.isnan(numbers)] = np.nan
    data = numbers.tobytes()
    packed = base64.b64encode(zlib.compress(data)).decode()
    return {"sha256": hashlib.sha256(data).hexdigest(), "shape": numbers.shape, "data": packed}


def numbers_of(item: Items) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Array of an item of the file."""
    return np.frombuffer(zlib.decompress(base64.b64decode(item["data"]))).reshape(item["shape"])


def flat(data: Any, key: str) -> Iterator[tuple[str, Any]]:
    """Leaves of nested tables and lists, and empty ones, by dotted keys."""
    if isinstance(data, dict | list | tuple) and data:
        for name, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from flat(value, f"{key}.{name}")
    else:
        yield key, data


def told(error: Exception, folder: Path) -> str:
    """Error as text; one that is none of kousoku's own is marked."""
    mark = "" if isinstance(error, KousokuError) else "FOREIGN "
    return f"{mark}{type(error).__name__}: {error}".replace(str(folder), "FOLDER")


def computed(name: str, scene: Scene, folder: Path) -> Items:
    """Results that are computed for a scene."""
    if not scene.is_spatial:
        return _of_linkage(scene, folder)
    items: Items = {}
    wanted: list[str] | None = None
    if not name.startswith("random"):
        wanted = [one for one in WANTED if one != "coordinates" or scene.coordinates]
        wanted = [one for one in wanted if one != "reactions" or scene.joints or scene.drivers]
    try:
        tree = generate_dynamics(scene, wanted)
    except KousokuError as error:
        items["refused"] = told(error, folder)
        if wanted is None:
            return items
        tree = generate_dynamics(scene, None)
    write_tree(folder / scene.name, tree)
    for target in ("c", "numpy") if len(scene.bodies) < SLOW_FROM else ("c",):
        solver = load_dynamics(folder / scene.name, target=target)
        items |= {f"{target}/{key}": value for key, value in _of_solver(solver, folder).items()}
    return items


def _of_linkage(scene: Scene, folder: Path) -> Items:
    items: Items = {}
    write_tree(folder / scene.name, generate_linkage(scene))
    for target in ("c", "numpy"):
        solver = load_linkage(folder / scene.name, target=target)
        for method in ("newton", "paper"):
            key = f"{target}/{method}"
            try:
                turn = solver.solve(method=method, divisions=24)
            except KousokuError as error:
                items[f"{key}/stopped"] = told(error, folder)
                continue
            tables = ("positions", "velocities", "accelerations", "angles")
            for table in (*tables, "angular_velocities", "angular_accelerations", "inputs"):
                for name, values in getattr(turn, table).items():
                    items[f"{key}/{table}.{name}"] = array(values)
            items[f"{key}/iterations"] = array(turn.iterations)
            items[f"{key}/residual"] = array(turn.residual)
    return items


def _of_solver(solver: DynamicsSolver, folder: Path) -> Items:
    """Start of a solver and its runs."""
    items: Items = {}
    changed = {name: 1.01 * value + 1e-3 for name, value in solver.parameters}
    for name, given in (("evaluate", {}), ("evaluate changed", changed)):
        try:
            found = solver.evaluate(0.125, parameters=given)
        except KousokuError as error:
            items[name] = told(error, folder)
        else:
            items |= {f"{name}/{key}": array(values) for key, values in found.items()}
    last, rows, most = TARGETS[solver.target.name]
    times = np.linspace(0.0, last, rows)
    runs: dict[str, dict[str, Any]] = {
        "default": {},
        "dopri5": {"method": "dopri5", "tolerance": 1e-6},
        "dop853": {"method": "dop853", "tolerance": 1e-10, "checks": False},
        "fixed": {"method": "dopri5", "step": last / most},
        "fixed dop853": {"method": "dop853", "step": last / most * 3},
    }
    if solver.is_driven:
        runs["kinematics"] = {"method": "kinematics", "checks": False}
    if changed:
        runs["changed"] = {"parameters": changed}
    for name, options in runs.items():
        try:
            run = solver.begin(times, most_steps=most, **options)
        except KousokuError as error:
            items[f"{name}/refused"] = told(error, folder)
            continue
        pieces = most if name == "dopri5" else 0
        items |= {f"{name}/{key}": value for key, value in _of_run(run, pieces, folder).items()}
    return items


def _of_run(run: Run, pieces: int, folder: Path) -> Items:
    """Remains of a run: status, rows, state but for its key, tables, ledger.

    Parameters
    ----------
    run : Run
        A run at its start.
    pieces : int
        It is cut into so many calls of one step and one row at most; 0 for a run in one piece.
    folder : Path
        What messages may name, and records do not.
    """
    items: Items = {}
    for _ in range(pieces):
        items["status"] = run.advance(max_steps=1, max_rows=1)
        if items["status"] not in (1, 2):
            break
    try:
        motion = run.motion() if pieces else run.finish()
    except KousokuError as error:
        items["stopped"] = told(error, folder)
        motion = run.motion()
    items["rows"] = array(run.save().rows)
    items["state"] = array(run.state[1:])
    columns = motion.columns()
    items["columns"] = ", ".join(columns)
    items["tables"] = array(np.array([*columns.values()])) | {"data": ""}  # they are made of rows
    ledger = {key: value for key, value in motion.ledger.as_data().items() if key != "seconds"}
    return items | dict(flat(ledger, "ledger"))


def difference(was: Items, now: Items) -> str:
    """First difference of two records of a scene, empty if there is none.

    More numbers that the second one tells in a ledger or of a state are no difference.
    """
    found = [*differences(was, now)]
    if not found:
        return ""
    others = ", ".join(key for key, _ in found[1:5])
    more = f"; so do {len(found) - 1} more items: {others}" if others else ""
    return f"{found[0][0]}{found[0][1]}{more}"


def differences(was: Items, now: Items) -> Iterator[tuple[str, str]]:
    """Items that differ, and how."""
    for key, value in was.items():
        if key not in now:
            yield key, f": is not there any more, was {shown(value)}"
        elif is_array(value) and is_array(now[key]):
            if value["sha256"] != now[key]["sha256"] and (text := _first(key, value, now[key])):
                yield key, text
        elif json.dumps(value) != json.dumps(now[key]):
            yield key, f": {shown(now[key])}, was {shown(value)}"
    for key, value in now.items():
        if key not in was and "/ledger." not in key and "evaluate" not in key:
            yield key, f": is new, {shown(value)}"


def shown(value: Any) -> str:
    """Value for a line."""
    return f"an array {value['shape']}" if is_array(value) else repr(value)[:400]


def is_array(value: Any) -> bool:
    """Whether an item of the file is an array; an empty table of a ledger is none."""
    return isinstance(value, dict) and "sha256" in value


def _first(key: str, was: Items, now: Items) -> str:
    """Say where two arrays differ first; a longer state by its numbers other than 0."""
    if not was["data"]:
        return ": differ, and the rows that they are made of do not"
    a, b = numbers_of(was), numbers_of(now)
    is_longer = a.shape != b.shape and key.endswith("/state")
    if is_longer and a[a != 0.0].tobytes() == b[b != 0.0].tobytes():
        return ""  # empty fields may take a place
    if a.shape != b.shape:
        return f": has the shape {b.shape}, was {a.shape}"
    places = np.argwhere(a.view(np.int64) != b.view(np.int64))
    place = tuple(int(k) for k in places[0]) if len(places) else ()
    count = f"{len(places)} of {a.size} differ"
    return f"{list(place)}: {float(b[place])!r}, was {float(a[place])!r}; {count}"


def _job(name: str) -> tuple[str, Items, float]:
    begin = time.perf_counter()
    logging.disable(logging.WARNING)  # that NumPy is slow
    with tempfile.TemporaryDirectory() as folder:
        try:
            items = computed(name, scenes()[name](), Path(folder))
        except Exception as error:  # any error is a result
            items = {"refused": told(error, Path(folder))}
    return name, items, time.perf_counter() - begin


def _results(names: Sequence[str]) -> Iterator[tuple[str, Items, float]]:
    """Results of scenes, each computed in a process of its own.

    What was generated before in a process shall change nothing, and if it does, two records are
    still of the same.
    """
    with tempfile.TemporaryDirectory() as cache:
        os.environ["KOUSOKU_CACHE"] = cache
        with multiprocessing.get_context("fork").Pool(2, maxtasksperchild=1) as pool:
            yield from pool.imap_unordered(_job, names)


def record(only: str) -> dict[str, Items]:
    """Results of this version; tells on stderr how far it is.

    Parameters
    ----------
    only : str
        A part of the names of the scenes that are computed.
    """
    names = [name for name in scenes() if only in name]
    results: dict[str, Items] = {}
    for name, items, seconds in _results(names):
        results[name] = items
        text = f"{len(results)}/{len(names)} {name}: {len(items)} items, {seconds:.1f} s"
        print(text, items.get("refused", "")[:300], file=sys.stderr, flush=True)
    return {name: results[name] for name in names}


def main() -> int:
    """Write a record, or compare with one; return 1 where something differs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--write", type=Path, metavar="FILE", help="write what is computed")
    parser.add_argument("--compare", type=Path, metavar="FILE", help="compare with what is written")
    parser.add_argument("--only", default="", help="a part of the names of scenes")
    given = parser.parse_args()
    if not (given.write or given.compare):
        parser.error("nothing to do: --write FILE, --compare FILE, or both")
    begin = time.perf_counter()
    print(f"kousoku of {Path(kousoku.__file__).parent}", file=sys.stderr)
    now = record(given.only)
    print(f"{time.perf_counter() - begin:.0f} s", file=sys.stderr)
    if given.write:
        given.write.write_text(json.dumps(now, separators=(",", ":")), encoding="utf-8")
    if not given.compare:
        return 0
    was = json.loads(given.compare.read_text(encoding="utf-8"))
    differ = 0
    for name in [name for name in was | now if given.only in name]:
        if name not in was or name not in now:
            text = "only in one of the two"
        else:
            text = difference(was[name], now[name])
            if text and not difference(was[name], next(_results([name]))[1]):
                text = f"differs, and not when it is computed again: {text}"
        differ += bool(text)
        print(f"{name}: {text or f'same, {len(was[name])} items'}")
    print(f"{differ} of {len(now)} scenes differ")
    return int(bool(differ))


if __name__ == "__main__":
    sys.exit(main())
