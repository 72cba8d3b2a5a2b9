"""Runs that were saved, opened again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kousoku as ks

SCENES = Path(__file__).parents[2] / "scenes"


def test_a_run_of_bodies_is_opened_as_it_was(tmp_path: Path, compiler: object) -> None:
    loop = ks.load(SCENES / "loop_free.toml")
    run = loop.simulate(0.2, samples=3, parameters={"mass": 2}, initial={"crank_angle": "30 deg"})
    run.save(tmp_path / "run.npz")
    opened = ks.open_run(tmp_path / "run.npz")
    assert repr(opened) == repr(run) and opened.units == run.units
    for name, values in run.columns().items():
        np.testing.assert_array_equal(opened[name], values)
    for own, other in zip(run.state(-1), opened.state(-1), strict=True):
        np.testing.assert_array_equal(own, other)
    assert dict(opened.parameters) == dict(run.parameters) == {"mass": 2.0}
    assert str(opened.ledger) == str(run.ledger)
    assert opened.animate(tmp_path / "run.html") is not None


def test_a_run_of_a_linkage_is_opened_as_it_was(tmp_path: Path) -> None:
    run = ks.load(SCENES / "lever_crank.toml", target="numpy").solve(divisions=4)
    run.save(tmp_path / "run.npz")
    opened = ks.open_run(tmp_path / "run.npz")
    assert repr(opened) == repr(run)
    np.testing.assert_array_equal(opened["O3.x"], run["O3.x"])


def test_what_holds_no_run_is_refused(tmp_path: Path) -> None:
    for name, data in (("a.npz", b"abc"), ("b.csv", b"time,x\n0,1\n")):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(ks.SolveError, match=rf"{name}: holds no run; wanted") as error:
            ks.open_run(tmp_path / name)
        assert "pickle" not in str(error.value)  # NumPy's advice to load unsafely helps nobody
    with pytest.raises(ks.SolveError, match="cannot be read"):
        ks.open_run(tmp_path / "none.npz")
