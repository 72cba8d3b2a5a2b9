"""Runs of scenes with bodies that are put onto joints with the ground, and led by drivers there."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.emission.emit import emit_dynamics
from kousoku.codegen.dynamics.generate import LEDGER_OUTPUTS
from kousoku.codegen.dynamics.recording.inline import inline
from kousoku.codegen.generate import write_tree
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.builder import SceneBuilder
from kousoku.runtime.dynamics import load_dynamics
from tests.analysed import independent

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from kousoku.model.records.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver

OUTPUTS = ("accelerations", "reactions", "energies", "coordinates")
MOMENT = 2.0 * (3.0**2 + 3.0**2) / 12


def led(law: str = "2*t - 0.5*sin(t)", *, has_rod: bool = True) -> Scene:
    """Crank that a motor leads, and a rod that swings on its end in space."""
    builder = SceneBuilder("led", unit="m").gravity(0, 0, -9.81)
    builder.body(
        "crank", position=(0, 0, 0), boxes=[{"mass": 3, "size": [2, 0.2, 0.3], "at": [1, 0, 0]}]
    )
    if has_rod:
        builder.body(
            "rod",
            position=(2, 0, 0),
            boxes=[{"mass": 1, "size": [0.2, 0.3, 1.5], "at": [0, 0, -0.7]}],
        )
        builder.joint(
            "end",
            type="universal",
            bodies=("crank", "rod"),
            at=(2, 0, 0),
            axes=[[1, 0, 0], [0, 1, 0]],
        )
    builder.joint(
        "base", type="revolute", bodies=("ground", "crank"), at=(0, 0, 0), axis=(0, 0.6, 0.8)
    )
    builder.driver("motor", joint="base", value=law)
    builder.coordinate("turn", joint="base")
    return builder.outputs("coordinates").build()


def slider() -> Scene:
    """Carriage on a rail and a pendulum on it, a top beside them: no drivers."""
    builder = SceneBuilder("slider", unit="m").gravity(0, 0, -9.81)
    builder.body("carriage", position=(0, 0, 0), boxes=[{"mass": 2, "size": [1, 1, 1]}])
    builder.body(
        "weight", position=(0, 0, 0), boxes=[{"mass": 1, "size": [0.2, 0.3, 1], "at": [0, 0, -1]}]
    )
    builder.body(
        "top",
        position=(3, 0, 0),
        angular_velocity=(1, 0, 9),
        boxes=[{"mass": 1, "size": [1, 1, 0.3], "at": [0.1, 0, 1]}],
    )
    builder.joint(
        "rail", type="prismatic", bodies=("ground", "carriage"), at=(0, 0, 0), axis=(3, 4, 0)
    )
    builder.joint(
        "pin", type="revolute", bodies=("carriage", "weight"), at=(0, 0, 0), axis=(0.3, 1, 0)
    )
    builder.joint("tip", type="spherical", bodies=("ground", "top"), at=(3, 0, 0))
    return builder.build()


@pytest.fixture(scope="module")
def with_all_rows(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Scene], DynamicsSolver]:
    def load(scene: Scene) -> DynamicsSolver:
        system = assemble(system_of(scene, OUTPUTS))
        program = compose(independent(system), (*LEDGER_OUTPUTS, *OUTPUTS))
        folder = tmp_path_factory.mktemp("rows") / scene.name
        folder.mkdir()
        write_tree(folder, emit_dynamics(inline(program), system, OUTPUTS))
        return load_dynamics(folder)

    return load


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("scene", [led(), slider()], ids=lambda scene: scene.name)
def test_the_motion_is_that_with_all_rows(
    scene: Scene, with_all_rows: Any, bodies_folder: Callable[..., Path]
) -> None:
    solver, other = load_dynamics(bodies_folder(scene, OUTPUTS)), with_all_rows(scene)
    assert solver.satisfied
    assert not other.satisfied
    assert len(solver.rows) + len(solver.satisfied) == len(other.rows)
    found, wanted = (one.simulate(2.0, samples=21, tolerance=1e-12) for one in (solver, other))
    for name, values in wanted.columns().items():
        size = max(1.0, np.abs(values).max())
        np.testing.assert_allclose(found.columns()[name], values, rtol=0, atol=1e-9 * size)
    assert list(found.ledger.violations) == list(wanted.ledger.violations)
    assert max(found.ledger.worst("position")) < 1e-14
    assert max(found.ledger.worst("velocity")) < 1e-13
    assert max(found.ledger.worst("acceleration")) < 1e-11
    assert found.ledger.energy_error is not None
    assert found.ledger.energy_error < 1e-9


@pytest.mark.usefixtures("numpy_solver", "shipped_flags")
@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("scene", [led(), slider()], ids=lambda scene: scene.name)
def test_both_targets_make_the_same_run(scene: Scene, bodies_folder: Callable[..., Path]) -> None:
    runs = []
    for target in ("c", "numpy"):
        folder = bodies_folder(scene, OUTPUTS)
        run = load_dynamics(folder, target=target).begin([0.0, 0.05, 0.1], tolerance=1e-9)
        run.finish()
        runs.append(run)
    np.testing.assert_array_equal(runs[0].state, runs[1].state)
    np.testing.assert_array_equal(runs[0].save().rows, runs[1].save().rows)


@pytest.mark.usefixtures("compiler", "numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_where_no_rows_are_solved_for_nothing_is_corrected_whatever_the_workspace_held(
    target: Any, bodies_folder: Callable[..., Path]
) -> None:
    folder = bodies_folder(led(has_rod=False), OUTPUTS)
    assert "position" not in (folder / "solver.c").read_text(encoding="utf-8")
    solver = load_dynamics(folder, target=target)
    base, size = json.loads((folder / "motion.json").read_text(encoding="utf-8"))["places"]["dq"]
    work, none = np.full(solver.target.work_size, 7.0), np.empty(0)
    assert solver.target.evaluate(0.0, np.array(solver.q), np.array(solver.v), none, work) == 0
    np.testing.assert_array_equal(work[base : base + size], 0.0)


@pytest.mark.parametrize("law", ["40*t", "20*t^2"])
def test_a_body_that_is_led_alone_counts_all_its_turns_and_the_work(
    backend: Any, law: str, bodies_folder: Callable[..., Path]
) -> None:
    scene = led(law, has_rod=False)
    solver = load_dynamics(bodies_folder(scene, OUTPUTS), target=backend)
    assert solver.is_driven
    assert solver.rows == ()
    motion = solver.simulate(times=[0.0, 1.0, 2.5], tolerance=1e-9)
    t = motion.time
    turn, rate = (40 * t, 40 + 0 * t) if law == "40*t" else (20 * t**2, 40 * t)
    np.testing.assert_allclose(motion.coordinate["turn"], turn, rtol=0, atol=1e-12)
    np.testing.assert_allclose(motion.coordinate_rate["turn"], rate, rtol=0, atol=1e-12)
    assert motion.ledger.energy_error < 1e-7 * motion.energy["kinetic"].max()
    assert motion.ledger.violations["drivers.motor"].radians[0] < 1e-12


@pytest.mark.usefixtures("compiler")
def test_a_motor_does_the_work_that_turns_a_wheel(bodies_folder: Callable[..., Path]) -> None:
    builder = SceneBuilder("wheel", unit="m").gravity(0, 0, -9.81)
    builder.body("wheel", position=(0, 0, 0), boxes=[{"mass": 2, "size": [3, 3, 1]}])
    builder.joint("axle", type="revolute", bodies=("wheel", "ground"), at=(0, 0, 0), axis=(0, 0, 1))
    builder.driver("motor", joint="axle", value="-3*t^2")
    solver = load_dynamics(bodies_folder(builder.build(), OUTPUTS))
    motion = solver.simulate(1.0, samples=3, tolerance=1e-9)
    assert motion.ledger.works["motor"] == pytest.approx(MOMENT * 36.0 / 2, rel=1e-8)
    np.testing.assert_allclose(motion.torque["motor"][-1], (0, 0, -6 * MOMENT), atol=1e-12)
    np.testing.assert_allclose(motion.force["axle"][-1], (0, 0, -19.62), atol=1e-12)


@pytest.mark.usefixtures("compiler")
def test_turns_of_a_motor_are_counted_by_its_formula_however_long_steps_are(
    bodies_folder: Callable[..., Path],
) -> None:
    builder = SceneBuilder("apart", unit="m").gravity(0, 0, -9.81)
    for name, x in (("wheel", 0), ("ball", 9)):
        builder.body(name, position=(x, 0, 0), boxes=[{"mass": 2, "size": [3, 3, 1]}])
    builder.joint("axle", type="revolute", bodies=("ground", "wheel"), at=(0, 0, 0), axis=(0, 0, 1))
    builder.driver("motor", joint="axle", value="3000*sin(t)").coordinate("turn", joint="axle")
    scene = builder.outputs("coordinates").build()
    solver = load_dynamics(bodies_folder(scene, ("coordinates",)))
    motion = solver.simulate(10.0, samples=7, tolerance=0.1)
    assert motion.ledger.steps < 20
    wanted = 3000 * np.sin(motion.time)
    np.testing.assert_allclose(motion.coordinate["turn"], wanted, rtol=0, atol=1e-11)


def test_a_single_row_tells_that_it_is_nearly_lost(
    backend: str, bodies_folder: Callable[..., Path]
) -> None:
    """The pivot of x = cos θ grows with sin² θ; there is no other one beside it."""
    builder = SceneBuilder("reach", unit="m")
    builder.body(
        "arm",
        position=(0, 0, 0),
        orientation={"axis": [0, 0, 1], "angle": math.acos(0.5)},
        boxes=[{"mass": 1, "size": [1, 0.1, 0.1], "at": [0.5, 0, 0]}],
    )
    builder.joint("base", type="revolute", bodies=("ground", "arm"), at=(0, 0, 0), axis=(0, 0, 1))
    builder.coordinate("x", body="arm", point=(1, 0, 0), along=(1, 0, 0))
    builder.driver("reach", coordinate="x", value="0.5 + t")
    target: Any = backend
    solver = load_dynamics(bodies_folder(builder.build(), ()), target=target)
    for method in ("kinematics", "dopri5"):
        ledger = solver.simulate(times=[0.0, 0.4999], tolerance=1e-8, method=method).ledger
        assert ledger.growth == pytest.approx((1 - 0.9999**2) / (1 - 0.5**2), rel=1e-6)
