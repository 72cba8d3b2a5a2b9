"""Rows that are kept and lose rank on the way: those that were left out take over.

One row of the linkage of Bricard depends on the others. About half of the choices which one to
leave out fail somewhere on its way; here such a choice is made on purpose.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly import assemble
from kousoku.codegen.dynamics.compose import compose
from kousoku.codegen.dynamics.emit import emit_dynamics
from kousoku.codegen.dynamics.inline import inline
from kousoku.model.read import read_scene
from kousoku.model.system import system_of
from kousoku.runtime.dynamics import load_dynamics

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.mechanism import System
    from kousoku.runtime.dynamics import DynamicsSolver

OUTPUTS = ("accelerations", "reactions", "energies")
#: The place of the row that is left out among all rows: good everywhere, and bad at times.
GOOD, BAD = 3, 1
END = 2.0


@pytest.fixture(scope="module")
def system() -> System:
    return assemble(system_of(read_scene(Path(__file__).parents[2] / "scenes" / "bricard.toml")))


@pytest.fixture(scope="module")
def folder(system: System, tmp_path_factory: pytest.TempPathFactory) -> Callable[[int], Path]:
    known: dict[int, Path] = {}

    def make(left_out: int) -> Path:
        if left_out not in known:
            rows = compose(system).rows
            row = rows[left_out]
            kept = [one.row for one in rows if one.instance == row.instance and one != row]
            program = compose(system, ("checks", *OUTPUTS), rows={row.instance: kept})
            known[left_out] = tmp_path_factory.mktemp("choice") / system.name
            known[left_out].mkdir()
            for name, text in emit_dynamics(inline(program), system, OUTPUTS).items():
                (known[left_out] / name).write_text(text, encoding="utf-8", newline="\n")
        return known[left_out]

    return make


@pytest.fixture
def load(backend: str, folder: Callable[[int], Path]) -> Callable[[int], DynamicsSolver]:
    target: Any = backend
    return lambda left_out: load_dynamics(folder(left_out), target=target)


def test_motion_does_not_depend_on_the_row_that_is_left_out(
    load: Callable[[int], DynamicsSolver],
) -> None:
    good, bad = (load(row).simulate(END, samples=21, tolerance=1e-11) for row in (GOOD, BAD))
    assert (good.ledger.fallbacks, good.ledger.fallback_time) == (0, None)
    assert good.ledger.growth > 1e-4
    ledger = bad.ledger
    assert 0 < ledger.fallbacks < ledger.factorisations / 5
    assert ledger.fallback_time is not None
    assert 0.0 < ledger.fallback_time < END
    assert f"{ledger.fallbacks} factorisations of all rows" in str(ledger)
    assert ledger.avoided == 0
    assert ledger.steps <= good.ledger.steps + 1
    assert ledger.energy_error is not None
    assert ledger.energy_error < 1e-9
    assert max(ledger.worst("position")) < 1e-13
    for name in ("position", "velocity", "acceleration"):
        for body, values in getattr(good, name).items():
            np.testing.assert_allclose(getattr(bad, name)[body], values, rtol=0, atol=1e-8)


def test_rows_where_the_others_fail_have_accelerations_and_no_reactions(
    load: Callable[[int], DynamicsSolver],
) -> None:
    solver = load(BAD)
    at = solver.simulate(END, samples=3, tolerance=1e-11).ledger.fallback_time
    assert at is not None
    times = [0.0, at - 1e-7, at + 1e-7, END]
    good, bad = (load(row).simulate(times=times, tolerance=1e-11) for row in (GOOD, BAD))
    for body, values in good.acceleration.items():
        np.testing.assert_allclose(bad.acceleration[body], values, rtol=0, atol=1e-7)
    is_unknown = np.isnan(bad.force["a"]).any(axis=1)
    assert is_unknown.tolist() == [False, True, True, False]
    assert np.isfinite(good.force["a"]).all()


def test_both_targets_take_the_same_steps_with_all_rows(
    compiler: object, folder: Callable[[int], Path]
) -> None:
    one, other = (
        load_dynamics(folder(BAD), target=target).begin([0.0, END], tolerance=1e-9)
        for target in ("c", "numpy")
    )
    for run in (one, other):
        run.finish()
    np.testing.assert_array_equal(one.state, other.state)


def test_run_in_pieces_gives_the_bits_of_a_run_in_one(
    load: Callable[[int], DynamicsSolver],
) -> None:
    solver = load(BAD)
    whole = solver.begin([0.0, END], tolerance=1e-9)
    whole.finish()
    run = solver.begin([0.0, END], tolerance=1e-9)
    while run.advance(3) > 0:
        run._memory.work[:] = np.nan
    np.testing.assert_array_equal(run.state, whole.state)
    assert run.motion().ledger.fallbacks > 0


def test_scenes_without_rows_that_are_left_out_have_no_such_text(tmp_path: Path) -> None:
    scene = read_scene(Path(__file__).parents[2] / "scenes" / "pendulum.toml")
    pendulum = system_of(scene)
    files = emit_dynamics(compose(pendulum, ("checks", "energies")), pendulum, ())
    assert "factorise" not in files["solver.c"] + files["solver.py"]
