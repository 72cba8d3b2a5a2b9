"""Saved runs that strangers changed: marks, numbers, and what is said of them."""

from __future__ import annotations

import io
import json
import pickle
import tempfile
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from hypothesis import strategies as st

import kousoku as ks
from kousoku.runtime.integrate.result import _write_arrays
from kousoku.runtime.saved import digest_of
from kousoku.saved import OWN
from tests.stress.kit import ROOT
from tests.stress.strange_inputs import places, values

if TYPE_CHECKING:
    from collections.abc import Callable

    from hypothesis.strategies import SearchStrategy

ALL = ("accelerations", "coordinates", "reactions", "energies")
ABOUT = "kousoku/about"


@cache
def kept() -> dict[str, bytes]:
    """Runs as they are saved: of bodies, and of a linkage."""
    found = {}
    with tempfile.TemporaryDirectory(prefix="kousoku-stress-") as place:
        path = Path(place, "run.npz")
        for name, end in (("bouncing_ball", 0.5), ("lever_crank", 0.0), ("loop_free", 0.05)):
            outputs: Any = ALL if name == "loop_free" else None
            scene = ks.load(ROOT / "scenes" / f"{name}.toml", outputs=outputs, target="numpy")
            how: dict[str, Any] = {"samples": 3, "tolerance": 1e-4}
            run = scene.simulate(end, **how) if end else scene.solve(divisions=4)
            run.save(path)
            found[name] = path.read_bytes()
    return found


def edits() -> SearchStrategy[tuple[Any, ...]]:
    """Edits of saved runs, as :func:`edited` takes them."""
    names = st.sampled_from([*kept()])
    number, how = st.integers(0, 10**6), st.integers(0, 4)
    bad = st.sampled_from([np.nan, np.inf, -1.0, 1e308, 0.0, 7.0, -1e9, 5e-324])
    marks = st.lists(st.tuples(number, st.integers(0, 255)), min_size=1, max_size=5)
    return (
        st.tuples(st.just("about"), names, number, values(), how)
        | st.tuples(st.just("array"), names, number, number, bad, how)
        | st.tuples(st.just("bytes"), names, marks)
    )


def edited(sort: str, *how: Any) -> bytes:
    """Saved run after an edit."""
    edits_of: dict[str, Callable[..., bytes]] = {
        "about": about_edited,
        "array": array_edited,
        "bytes": bytes_edited,
    }
    return edits_of[sort](*how)


def bytes_edited(name: str, marks: list[tuple[int, int]]) -> bytes:
    """Saved run with other bytes in some places."""
    data = bytearray(kept()[name])
    for place, value in marks:
        data[place % len(data)] = value
    return bytes(data)


def about_edited(name: str, number: int, value: Any, how: int) -> bytes:
    """Saved run of which something else is said, or something is not."""
    arrays = _arrays(name)
    tree = json.loads(str(arrays[ABOUT]))
    every = places(tree)
    *path, last = every[number % len(every)]
    table: Any = tree
    for key in path:
        table = table[key]
    if how:
        table[last] = value
    else:
        del table[last]
    try:
        text = json.dumps(tree)
    except (ValueError, TypeError):
        text = "{"
    return _written(arrays | {ABOUT: np.array(text)})


def array_edited(name: str, which: int, place: int, value: float, how: int) -> bytes:
    """Saved run without an array, or with another number, type or size of it."""
    arrays = _arrays(name)
    key = [*arrays][which % len(arrays)]
    array = arrays[key]
    if how == 0:
        del arrays[key]
    elif how == 1 or array.dtype.kind not in "fi" or not array.size:
        arrays[key] = array[..., :-1] if array.ndim else array.astype(str)
    else:
        changed = array.astype(np.float64)
        changed.flat[place % changed.size] = value
        with np.errstate(invalid="ignore"):
            arrays[key] = changed if how == 2 else changed.astype(array.dtype)
    return _written(arrays)


#: What is asked of a run that was opened.
QUESTIONS: tuple[Callable[[Any, Path], object], ...] = (
    lambda run, _: run.columns(),
    lambda run, _: (repr(run), str(run.ledger), run.notes, run.units),
    lambda run, _: run.summary(),
    lambda run, _: run._repr_html_(),
    lambda run, _: [run.state(k) for k in range(len(run))],
    lambda run, place: run.save(place / "again.csv"),
    lambda run, place: run.save(place / "again.npz"),
    lambda run, place: run.animate(place / "run.html"),
    lambda run, _: pickle.dumps(run),
)


def _arrays(name: str) -> dict[str, Any]:
    with np.load(io.BytesIO(kept()[name])) as found:
        return dict(found)


def _written(arrays: dict[str, Any]) -> bytes:
    own = {name.removeprefix(OWN): arrays[name] for name in arrays if name.startswith(OWN)}
    own.pop("digest", None)
    buffer = io.BytesIO()
    _write_arrays(buffer, arrays | {f"{OWN}digest": np.array(digest_of(own))})
    return buffer.getvalue()
