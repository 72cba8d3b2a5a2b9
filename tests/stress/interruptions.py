"""Processes at once, killed, and without room; runs that are cut, kept, and resumed elsewhere.

What goes wrong goes wrong in forked processes, :mod:`tests.stress.children`: killed before each
change of a file, just after one, or in the middle of writing one; no room from some change on, or
for files of some size; a cache that nobody may write. After each, files are old or new, never half,
and a process that is left alone does its work with the right result.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import pickle
import random
import shlex
import tempfile
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from unittest.mock import patch

import numpy as np

import kousoku as ks
from kousoku.cli.app import main
from kousoku.model.errors import KousokuError
from kousoku.model.reading.write import toml_of
from kousoku.runtime import toolchain
from kousoku.runtime.sources import Sources
from tests.random_scenes import random_scene
from tests.stress import children, workers
from tests.stress.kit import ROOT, Fault, Outcome, Question
from tests.stress.scenes import rounded_up, units_allowed
from tests.stress.watched import warm

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from contextlib import AbstractContextManager

    from kousoku.runtime.run import Run
    from tests.stress.kit import Size

SCENES = ("pendulum", "bouncing_ball", "lever_crank")
#: What the compiler does in these processes: bits are the same without optimising.
FLAGS = "-O0 -fno-sanitize=undefined"
MOST_BYTES = 400_000


def cases(size: Size) -> Iterator[str]:
    """Name the cases: processes at once, then each mishap in each work, then runs that are cut."""
    if size.is_full:
        for batch in range(3):
            yield f"together {size.seed} {batch} {size.examples(6, 50)}"
    else:
        yield f"together {size.seed} 0 {size.examples(6, 50)}"
    for mishap in MISHAPS:
        for work in works_of(mishap):
            if work == "load c" and not size.is_full:
                continue
            count = size.examples(3, 25 if work == "load c" else 200)
            yield f"{mishap} {size.seed} {work.replace(' ', '_')} {count}"
    for number in range(size.examples(2, 60)):
        yield f"resumed {size.seed} {number} 4"


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]


def _rows(scene: str, target: Any) -> str:
    """Load a scene, move it, and return the digest of its rows."""
    mechanism = ks.load(ROOT / "scenes" / f"{scene}.toml", target=target)
    if mechanism.scene.is_spatial:
        run: Any = mechanism.simulate(0.02, samples=3, tolerance=1e-4)
        return f"{mechanism.target} {_digest(run.rows.tobytes())}"
    found = mechanism.solve(divisions=3)
    return f"{mechanism.target} {_digest(np.stack([*found.columns().values()]).tobytes())}"


def _forget() -> None:
    """Let this process find its compiler anew."""
    for function in (toolchain._chosen, toolchain._first, toolchain.probe):
        function.cache_clear()


def _loading(place: Path, target: str, scene: str, compiler: str = "") -> str:
    os.environ |= {"KOUSOKU_CACHE": str(place / "cache"), "KOUSOKU_CFLAGS": FLAGS}
    if compiler:
        os.environ["KOUSOKU_CC"] = compiler
    _forget()
    return _rows(scene, target)


def _together(case: str) -> Outcome:
    """Let processes load the same and different scenes at once, with an empty cache."""
    count = case.rpartition(" ")[2]
    draw, outcome = random.Random(case), Outcome()
    has_compiler = workers.has_compiler()
    warm()
    with tempfile.TemporaryDirectory(prefix="kousoku-stress-") as place:
        log, compiler = Path(place, "log"), Path(place, "cc")
        if has_compiler:
            real = shlex.join(toolchain.find_toolchain().command)
            noted = f'for a in "$@"; do [ "$a" = -o ] && echo built >> {log}; done'
            compiler.write_text(f'#!/bin/sh\n{noted}\nexec {real} "$@"\n', encoding="utf-8")
            compiler.chmod(0o755)
        wanted = {scene: _reference(scene) for scene in SCENES}
        scenes = [SCENES[0] if k % 2 else draw.choice(SCENES) for k in range(int(count))]
        target, which = ("c", str(compiler)) if has_compiler else ("numpy", "none")
        works = [partial(_loading, Path(place), target, scene, which) for scene in scenes]
        outcome.measure("at once on an empty cache (processes)", len(works), case)
        for scene, end in zip(scenes, children.together(works), strict=True):
            if end.how != "good" or end.text.split()[1] != wanted[scene]:
                outcome.find(f"processes at once: {end.how}", f"{scene}: {end}", _command(case))
            elif end.said:
                outcome.find("processes at once: one complains", end.said, _command(case))
        if has_compiler:
            built = len(log.read_text(encoding="utf-8").splitlines())
            libraries = sum(path.is_dir() for path in Path(place, "cache", "lib").iterdir())
            outcome.measure(
                "compilations, processes at once (of a library)", built / libraries, case, limit=1.0
            )
        half = [path for path in Path(place, "cache").rglob(".*") if path.suffix != ".lock"]
        if half:
            outcome.find("processes at once leave unfinished files", f"{half[:3]}", _command(case))
    return outcome


@cache
def _reference(scene: str) -> str:
    """Digest of the rows of a scene, without a mishap."""
    with tempfile.TemporaryDirectory(prefix="kousoku-stress-") as place:
        end = children.alone(partial(_loading, Path(place), "numpy", scene))
    assert end.how == "good", end
    return end.text.split()[1]


class Work(NamedTuple):
    """What a process does with files.

    Parameters
    ----------
    do : callable
        Does it in a folder, and returns the digest of what came of it.
    begin : callable
        Puts what was there before.
    file : str
        What is written, a file or a folder beside the cache; empty where it is the cache alone.
    """

    do: Callable[[Path], str]
    begin: Callable[[Path], object] = lambda place: None
    file: str = ""


OLD = b"what was there before\n"


def _of_tree(folder: Path) -> str:
    """Digest of all files of a folder but those that begin with a dot."""
    names = sorted(p for p in folder.rglob("*") if p.is_file() and not p.name.startswith("."))
    return _digest(
        b"".join(p.relative_to(folder).as_posix().encode() + p.read_bytes() for p in names)
    )


def _command_line(*words: str) -> None:
    """Run a command; a refusal is raised as it was said."""
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
            main(words)
    except SystemExit as error:
        if error.code == 2 and said.getvalue().startswith("kousoku: "):
            raise KousokuError(said.getvalue()) from None
        if error.code:
            raise RuntimeError(f"exit status {error.code}: {said.getvalue()[-500:]}") from None


def _generate(place: Path, scene: str = "scene") -> str:
    os.environ["KOUSOKU_CACHE"] = str(place / "cache")
    _command_line("generate", str(place / f"{scene}.toml"), "--out", str(place / "out"))
    return _of_tree(place / "out")


def _begin_generate(place: Path) -> None:
    text = (ROOT / "scenes" / "pendulum.toml").read_text(encoding="utf-8")
    (place / "scene.toml").write_text(text.replace("mass = 1", "mass = 2"), encoding="utf-8")
    (place / "old.toml").write_text(text, encoding="utf-8")
    _generate(place, "old")


@cache
def _motion() -> Any:
    return ks.load(ROOT / "scenes" / "pendulum.toml", target="numpy").simulate(
        0.05, samples=20, tolerance=1e-4
    )


def _saved(name: str, place: Path) -> str:
    run = _motion()
    (run.animate if name.endswith((".html", ".svg")) else run.save)(place / name)
    return _digest((place / name).read_bytes())


def _begin_file(name: str, place: Path) -> None:
    (place / name).write_bytes(OLD)


def _of_file(name: str) -> Work:
    return Work(partial(_saved, name), partial(_begin_file, name), name)


def _simulate(place: Path) -> str:
    os.environ["KOUSOKU_CACHE"] = str(place / "cache")
    words = ("--end", "0.01", "--samples", "5", "--target", "numpy", "--tolerance", "1e-4")
    scene = str(ROOT / "scenes" / "pendulum.toml")
    _command_line("simulate", scene, *words, "--out", str(place / "run.csv"))
    return _digest((place / "run.csv").read_bytes())


WORKS: dict[str, Work] = {
    "load": Work(lambda place: _loading(place, "numpy", "pendulum")),
    "load c": Work(lambda place: _loading(place, "auto", "pendulum").split()[1]),
    "generate": Work(_generate, _begin_generate, "out"),
    "run.npz": _of_file("run.npz"),
    "run.csv": _of_file("run.csv"),
    "run.html": _of_file("run.html"),
    "run.svg": _of_file("run.svg"),
    "simulate": Work(_simulate, partial(_begin_file, "run.csv"), "run.csv"),
}
"""What processes do."""

MISHAPS = ("killed", "full", "read-only", "read-only-cache", "read-only-out")


def works_of(mishap: str) -> list[str]:
    """Works that a mishap may meet: one of the cache or of results alone those that write both."""
    is_of_one = mishap in {"read-only-cache", "read-only-out"}
    return ["generate", "simulate"] if is_of_one else [*WORKS]


def _mishap(kind: str, draw: random.Random, changes: int, place: Path, number: int) -> Any:
    """Mishap of a kind, and its description in words."""
    if kind == "read-only":
        return children.read_only(place), "nothing can be written"
    if kind == "read-only-cache":
        return children.read_only(place / "cache"), "only the cache cannot be written"
    if kind == "read-only-out":
        return children.read_only(place, place / "cache"), "only the cache can be written"
    if kind == "killed" and number % 3 == 2:
        at = draw.randrange(max(changes, 1))
        return children.killed_just_after(at), f"killed just after change {at} of {changes}"
    if number % 2:
        size = int(MOST_BYTES ** draw.random())
        by_size = children.killed_at_size if kind == "killed" else children.full_after
        return by_size(size), f"{kind} after {size} bytes of a file"
    at = draw.randrange(max(changes, 1))
    by_number = children.killed_before if kind == "killed" else children.full_from
    return by_number(at), f"{kind} at change {at} of {changes} of files"


def _broken(case: str) -> Outcome:
    """Let a process do its work while something goes wrong, again and again."""
    kind, _, name, count = case.split()
    work, draw, outcome = WORKS[name.replace("_", " ")], random.Random(case), Outcome()
    if name == "load_c" and not workers.has_compiler():
        outcome.count(workers.NOT_ASKED)
        return outcome
    warm()
    _motion()
    changes = [0]
    with _prepared(work) as place:
        before = _state(work, place)

        def counted() -> str:
            children.counting(changes)()
            return f"{work.do(place)} {changes[0]}"

        whole = children.alone(counted)
        if whole.how != "good":
            outcome.find(f"{name}: does not work alone", f"{whole}", _command(case))
            return outcome
        wanted, changes[0] = whole.text.rsplit(" ", 1)[0], int(whole.text.rsplit(" ", 1)[1])
        after = _state(work, place)
    for number in range(1 if kind.startswith("read-only") else int(count)):
        with _prepared(work) as place:
            mishap, words = _mishap(kind, draw, changes[0], place, number)
            end = children.alone(partial(work.do, place), mishap)
            outcome.count(f"{kind} while at work: {end.how}")
            where = f"{name}, {words}: {end.how} {end.text} {end.said}"[:900]
            if end.how == "foreign" or (end.how == "good" and end.text != wanted):
                outcome.find(
                    f"{name}: {kind}: {end.how}: {_short(end.text)}", where, _command(case)
                )
            if end.how != "killed":
                for path in _left_over(place):
                    outcome.find(f"{name}: {kind}: leaves a part of a file", f"{path}; {where}")
            if end.how == "killed":
                outcome.count(
                    "parts of files that killed processes leave", len([*_left_over(place)])
                )
            elif len(end.said) > 3000:
                outcome.find(f"{name}: {kind}: says too much", where, _command(case))
            elif kind.startswith("read-only") and len(end.text.splitlines()) > 1:
                outcome.find(f"{name}: {kind}: refuses in several lines", where, _command(case))
            if not _is_whole(work, place, before, after):
                outcome.find(
                    f"{name}: {kind}: leaves half of what it writes", where, _command(case)
                )
            again = children.alone(partial(work.do, place))
            if (again.how, again.text) != ("good", wanted):
                outcome.find(
                    f"{name}: {kind}: does not work ever after",
                    f"{again}; after {where}"[:900],
                    _command(case),
                )
    return outcome


@contextlib.contextmanager
def _prepared(work: Work) -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="kousoku-stress-") as name:
        place = Path(name)
        work.begin(place)
        yield place


def _left_over(place: Path) -> Iterator[Path]:
    """Files that a process that ended by itself should have removed."""
    for path in place.rglob(".*"):
        if path.exists() and path.suffix != ".lock":
            yield path


def _state(work: Work, place: Path) -> dict[str, bytes]:
    """Files that are written, without those that begin with a dot."""
    at = place / work.file
    files = [at] if at.is_file() else [path for path in at.rglob("*") if path.is_file()]
    return {
        path.relative_to(place).as_posix(): path.read_bytes()
        for path in files
        if work.file and not any(part.startswith(".") for part in path.relative_to(place).parts)
    }


def _is_whole(
    work: Work, place: Path, before: Mapping[str, bytes], after: Mapping[str, bytes]
) -> bool:
    """Whether each file is as before or as after; a mixed package is refused."""
    found = _state(work, place)
    if not all(data in (before.get(name), after.get(name)) for name, data in found.items()):
        return False
    if work.file != "out":
        return {*before} <= {*found}
    if found in (before, after):
        return True
    try:
        Sources.read(place / "out")
    except KousokuError:
        return True
    return False


def _short(text: str) -> str:
    return text.partition(":")[0][:60]


def _command(case: str) -> str:
    return f"python -m tests.stress interruptions --case '{case}'"


#: Scenes whose runs are cut, and how they run.
LONG: tuple[tuple[str, float, dict[str, Any]], ...] = (
    ("bouncing_ball", 1.5, {"tolerance": 1e-4}),
    ("loop_free", 0.2, {"tolerance": 1e-5}),
    ("gear_train", 0.3, {"method": "kinematics"}),
    ("heavy_top", 0.3, {"tolerance": 1e-6, "method": "dop853"}),
    ("pendulum", 1.0, {"step": 0.02}),
    ("bouncing_ball", 5.5, {"tolerance": 1e-3}),
)
ALL = ("accelerations", "reactions", "energies")


@cache
def _loaded(number: int) -> tuple[dict[str, Any], float, dict[str, Any], bool]:
    """Scene by each target, an end, options, and whether all targets have the same bits."""
    if number < len(LONG):
        name, end, options = LONG[number]
        scene: Any = ROOT / "scenes" / f"{name}.toml"
    else:
        draw = random.Random(number)
        scene, end, options = random_scene(draw), 0.05, {"tolerance": draw.choice([1e-4, 1e-7])}
    os.environ.setdefault("KOUSOKU_CFLAGS", FLAGS)
    targets = ("numpy", "c") if workers.has_compiler() else ("numpy",)
    made: dict[str, Any] = {}
    for target in targets:
        which: Any = target
        outputs: Any = (None, ALL, None, ALL, ALL, None)[number] if number < len(LONG) else None
        made[target] = ks.load(scene, outputs=outputs, target=which)
    text = scene.read_text(encoding="utf-8") if number < len(LONG) else toml_of(scene)
    return made, end, options, units_allowed(text) == 0.0


def _told(run: Run) -> dict[str, Any]:
    """All results that a run tells at its end, but how long it took."""
    motion = run.motion()
    ledger = motion.ledger.as_data()
    trust = motion.ledger.trust.as_data()
    return {
        "rows": motion.rows,
        "state": run.state.copy(),
        "events": motion.told.rows,
        "counts": motion.told.counts,
        "complete": motion.is_complete,
        "stopped by": motion.stopped_by,
        "ledger": {name: value for name, value in ledger.items() if name != "seconds"},
        "verdict": trust,
        "parameters": dict(motion.parameters),
    }


def _differs(a: Mapping[str, Any], b: Mapping[str, Any]) -> str:
    """First difference in what is told, empty if there is none."""
    for name, value in a.items():
        is_same = (
            np.array_equal(value, b[name], equal_nan=True)
            if isinstance(value, np.ndarray)
            else repr(value) == repr(b[name])
        )
        if not is_same:
            what = [
                f"{key}: {one!r} and {b[name].get(key)!r}"
                for key, one in (value.items() if isinstance(value, dict) else ())
                if repr(one) != repr(b[name].get(key))
            ]
            return f"{name} {'; '.join(what)[:300]}".strip()
    return ""


def _apart(a: Mapping[str, Any], b: Mapping[str, Any], tolerance: float) -> tuple[float, str]:
    """Distance of two runs that need not have the same bits.

    Returns
    -------
    tolerances : float
        How far numbers of their rows are apart, beside the largest of their column or 1.
    difference : str
        What they tell otherwise that is no number of a row; empty if nothing is.
    """
    told = ("complete", "stopped by", "parameters")
    difference = _differs({name: a[name] for name in told}, b)
    if a["rows"].shape != b["rows"].shape or a["events"].shape != b["events"].shape:
        return 0.0, f"{difference} rows {a['rows'].shape} and {b['rows'].shape}".strip()
    off = 0.0
    for one, other in ((a["rows"], b["rows"]), (a["events"], b["events"])):
        if not np.array_equal(np.isfinite(one), np.isfinite(other)):
            return 0.0, "rows that are not finite"
        size = np.maximum(np.max(np.abs(one), axis=0, initial=1.0, where=np.isfinite(one)), 1.0)
        away = np.where(np.isfinite(one), one - other, 0.0) / size
        off = max(off, float(np.max(np.abs(away), initial=0.0)))
    return off / tolerance, difference


def _finished(run: Run) -> Run:
    with contextlib.suppress(ks.MotionError):
        run.finish()
    return run


def _resumed(case: str) -> Outcome:
    """Cut a run at random places, keep it, and go on: in this target, and in the other."""
    _, _, number, count = case.split()
    draw, outcome = random.Random(case), Outcome()
    try:
        found = _loaded(int(number))
    except KousokuError:
        outcome.count("runs: a random scene is refused")
        return outcome
    made, end, options, has_same_bits = found
    times = np.sort(np.append(np.linspace(0.0, end, 12), draw.uniform(0.0, end)))
    try:
        whole = {name: _told(_finished(one.begin(times, **options))) for name, one in made.items()}
    except KousokuError:
        outcome.count("runs: a random scene cannot start")
        return outcome
    difference = _differs(whole["numpy"], whole[[*made][-1]])
    is_exact = not difference
    if difference and has_same_bits:
        where = f"scene {number}, {options}: {difference}"
        outcome.find(f"C and NumPy tell otherwise: {difference.split()[0]}", where, _command(case))
    for _ in range(int(count)):
        name = draw.choice([*made])
        moves = draw.random() < 0.5 and len(made) > 1
        run, wanted, cuts = made[name].begin(times, **options), whole[name], 0
        for _ in range(draw.randint(1, 6)):
            run.advance(draw.choice([1, 2, 7, 1000]), draw.choice([1, 2, 1000]))
            saved = pickle.loads(pickle.dumps(run.save()))
            if moves:
                name = draw.choice([*made])
            how = draw.random()
            run = pickle.loads(pickle.dumps(run)) if how < 0.3 else made[name].resume(saved)
            cuts += 1
        outcome.count("runs that were cut and resumed")
        outcome.count("cuts", cuts)
        told = _told(_finished(run))
        if is_exact or not moves:
            outcome.count("runs moved between C and NumPy", int(moves))
            difference = _differs(wanted, told)
        else:
            outcome.count("runs moved between C and NumPy, whose bits differ")
            off, difference = _apart(wanted, told, options.get("tolerance", 1e-6))
            figure = "moved between C and NumPy, whose bits differ: rows apart (tolerances)"
            outcome.measure(figure, off, f"scene {number}, {options}", limit=1.0)
        if difference:
            outcome.find(
                f"a run that is resumed tells otherwise: {difference.split()[0]}",
                f"scene {number}, {options}: {difference}",
                _command(case),
            )
    return outcome


def run(case: str) -> Outcome:
    """Run a case."""
    kind = case.partition(" ")[0]
    if kind == "resumed":
        return _resumed(case)
    if not children.CAN_FORK:
        outcome = Outcome()
        outcome.count("not asked: this system cannot fork")
        return outcome
    return _together(case) if kind == "together" else _broken(case)


def half_written() -> AbstractContextManager[object]:
    """Write results where they shall be, piece by piece."""
    from kousoku.runtime.integrate import result

    return patch.object(result, "_write", lambda path, data: path.write_bytes(data))


def in_place() -> AbstractContextManager[object]:
    """Write a whole copy beside a file, and then the file in its place."""

    def replace(path: Path, target: Path) -> Path:
        target.write_bytes(path.read_bytes())
        path.unlink()
        return target

    return patch.object(Path, "replace", replace)


def unlocked() -> AbstractContextManager[object]:
    """Let every process have the lock."""
    from kousoku.runtime import lock

    return patch.object(lock, "_try_lock", lambda _: True)


def forgetful() -> AbstractContextManager[object]:
    """Forget a count when a run is resumed."""
    from kousoku.runtime import dynamics, saved

    right = saved.checked_run

    def checked(solver: Any, given: object) -> Any:
        found = right(solver, given)
        solver.state["corrections"].view(found.state)[...] = 0.0
        solver.state["derivatives"].view(found.state)[...] = 0.0
        return found

    return patch.object(dynamics, "checked_run", checked)


def careless() -> AbstractContextManager[object]:
    """Let a cache that cannot be written end what is at work."""
    from kousoku import loading

    right = loading._written

    def written(*given: Any) -> Path:
        try:
            return right(*given)
        except OSError as error:
            raise RuntimeError(error) from None

    return patch.object(loading, "_written", written)


QUESTION = Question(
    asks="processes at once on an empty cache, killed while they write, without room, without"
    " rights; runs cut, resumed, moved between C and NumPy: is something wrong or lost?",
    cases=cases,
    run=run,
    faults=(
        Fault("a writer that writes piece by piece", half_written, "full 1 run.npz 10"),
        Fault("files written in place behind a whole copy", in_place, "killed 1 run.npz 24"),
        Fault("a lock that does not lock", unlocked, "together 1 0 6"),
        Fault("a run that forgets a count when resumed", forgetful, "resumed 1 0 4"),
        Fault("runs that NumPy alone rounds up", partial(rounded_up, 7), "resumed 1 0 1"),
        Fault("a cache that must be written", careless, "read-only-cache 1 simulate 1"),
    ),
)
