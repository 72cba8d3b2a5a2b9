"""Rows that are kept and lose rank on the way: those that were left out take over.

One row of the linkage of Bricard depends on the others. About half of the choices which one to
leave out fail somewhere on its way; here such a choice is made on purpose. A driver never depends
on other rows, so that what it does is unique whichever of them are solved for.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.emission.emit import emit_dynamics
from kousoku.codegen.dynamics.recording.inline import inline
from kousoku.codegen.generate import write_tree
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.read import read_scene, scene_from_toml
from kousoku.runtime.dynamics import load_dynamics
from tests.analysed import all_rows, without

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.mechanics.multibody import System
    from kousoku.runtime.dynamics import DynamicsSolver

OUTPUTS = ("accelerations", "reactions", "energies")
#: The place of the row that is left out among all rows: good everywhere, and bad at times.
GOOD, BAD = 3, 1
END = 2.0
SCENE = Path(__file__).parents[2] / "scenes" / "bricard.toml"
#: Steadily over the bad position of the row; or nearly to the dead centre of the hinge, at a
#: twelfth of a turn.
DRIVER = """
[parameters]
rate = -1.5
swing = 0
[drivers]
motor = { joint = "a", value = "rate*t + swing*sin(t)" }
"""
TO_DEAD_CENTRE = {"rate": 0.0, "swing": 0.5235}
DRIVEN_BAD = 2


@pytest.fixture(scope="module")
def system() -> System:
    return assemble(system_of(read_scene(SCENE)))


def write_without(left_out: int, system: System, folder: Path) -> Path:
    """Write the solver without one of all rows, and return where it is."""
    whole = all_rows(system)
    rows = [whole.outline.rows[left_out]]
    program = compose(without(whole, rows, list("abcdef")), ("checks", *OUTPUTS))
    folder /= system.name
    folder.mkdir()
    write_tree(folder, emit_dynamics(inline(program), system, OUTPUTS))
    return folder


@pytest.fixture(scope="module")
def folder(system: System, tmp_path_factory: pytest.TempPathFactory) -> Callable[[int], Path]:
    return cache(lambda row: write_without(row, system, tmp_path_factory.mktemp("choice")))


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Callable[[int], Path]:
    scene = scene_from_toml(f"{SCENE.read_text(encoding='utf-8')}{DRIVER}")
    system = assemble(system_of(scene))
    return cache(lambda row: write_without(row, system, tmp_path_factory.mktemp("driven")))


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


def test_forces_of_joints_where_rows_fail_are_those_of_a_good_choice(
    load: Callable[[int], DynamicsSolver],
) -> None:
    solver = load(BAD)
    at = solver.simulate(END, samples=3, tolerance=1e-11).ledger.fallback_time
    assert at is not None
    times = [0.0, at - 1e-3, at - 1e-7, at + 1e-7, END]
    good, bad = (load(row).simulate(times=times, tolerance=1e-11) for row in (GOOD, BAD))
    for body, values in good.acceleration.items():
        np.testing.assert_allclose(bad.acceleration[body], values, rtol=0, atol=1e-7)
    for name in ("force", "torque"):
        for joint, values in getattr(good, name).items():
            size = np.abs(values).max()
            assert size > 0.1
            np.testing.assert_allclose(getattr(bad, name)[joint], values, rtol=0, atol=1e-9 * size)


@pytest.mark.usefixtures("numpy_solver", "shipped_flags")
def test_both_targets_take_the_same_steps_with_all_rows(
    compiler: object, folder: Callable[[int], Path]
) -> None:
    times = np.linspace(0.0, END, 101)
    one, other = (
        load_dynamics(folder(BAD), target=target).begin(times, tolerance=1e-6)
        for target in ("c", "numpy")
    )
    for run in (one, other):
        run.finish()
    np.testing.assert_array_equal(one.state, other.state)
    np.testing.assert_array_equal(one.save().rows, other.save().rows)


@pytest.mark.parametrize("method", ["kinematics", "dopri5"])
def test_what_a_driver_does_is_the_same_with_all_rows(
    compiler: object, driven: Callable[[int], Path], method: str
) -> None:
    good, bad = (
        load_dynamics(driven(row), target="c").simulate(
            1.3, samples=14, tolerance=1e-10, method=method
        )
        for row in (GOOD, DRIVEN_BAD)
    )
    assert good.ledger.fallbacks == 0
    assert 0 < bad.ledger.fallbacks < bad.ledger.factorisations / 3
    assert bad.ledger.fallback_time is not None
    assert bad.ledger.fallback_time > 0.9
    assert max(bad.ledger.worst("velocity")) < 1e-12
    for name in ("position", "velocity", "acceleration"):
        for body, values in getattr(good, name).items():
            np.testing.assert_allclose(getattr(bad, name)[body], values, rtol=0, atol=1e-9)
    assert np.ptp(good.work["motor"]) > 10.0
    np.testing.assert_allclose(bad.work["motor"], good.work["motor"], rtol=0, atol=1e-8)
    for joint, torque in good.torque.items():
        np.testing.assert_allclose(bad.force[joint], good.force[joint], rtol=0, atol=1e-8)
        np.testing.assert_allclose(bad.torque[joint], torque, rtol=0, atol=1e-8)
    assert np.abs(good.torque["motor"]).max() > 1.0


def test_all_rows_do_not_take_over_where_they_are_as_weak(
    driven: Callable[[int], Path], backend: str
) -> None:
    target: Any = backend
    solver = load_dynamics(driven(GOOD), target=target)
    motion = solver.simulate(3.0, samples=31, tolerance=1e-9, parameters=TO_DEAD_CENTRE)
    assert motion.ledger.growth < 1e-6
    assert motion.ledger.fallbacks == 0
    assert np.isfinite(motion.force["a"]).all()


@pytest.mark.usefixtures("numpy_solver", "shipped_flags")
@pytest.mark.parametrize("method", ["kinematics", "dopri5"])
def test_both_targets_give_a_driver_the_same_work_with_all_rows(
    compiler: object, driven: Callable[[int], Path], method: str
) -> None:
    one, other = (
        load_dynamics(driven(DRIVEN_BAD), target=target).simulate(
            1.2, samples=7, tolerance=1e-6, method=method
        )
        for target in ("c", "numpy")
    )
    assert one.ledger.fallbacks == other.ledger.fallbacks > 0
    np.testing.assert_array_equal(one.work["motor"], other.work["motor"])
    np.testing.assert_array_equal(one.torque["motor"], other.torque["motor"])
    np.testing.assert_array_equal(one.acceleration["rod_3"], other.acceleration["rod_3"])


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
    files = emit_dynamics(compose(all_rows(pendulum), ("checks", "energies")), pendulum, ())
    assert "factorise" not in files["solver.c"] + files["solver.py"]
