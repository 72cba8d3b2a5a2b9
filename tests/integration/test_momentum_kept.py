"""Momentum of bodies that nothing connects with the ground, in the ledger of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.reading.read import scene_from_dict
from kousoku.runtime.dynamics import DynamicsSolver, load_dynamics

if TYPE_CHECKING:
    from pathlib import Path

    from kousoku.runtime.toolchain import Toolchain

INERTIA = {"xx": 0.04, "yy": 0.1, "zz": 0.12}


def thrown() -> dict[str, Any]:
    """Two bodies on a ball joint that turn and fall, with a third one on a damper."""
    start = {"velocity": [1, 2, 3], "mass": 1, "inertia": INERTIA}
    damper = {"type": "spring_damper", "bodies": ["arm", "stone"], "stiffness": 10, "damping": 1}
    return {
        "name": "thrown",
        "unit": "m",
        "gravity": [0, 0, -9.81],
        "bodies": {
            "rod": start | {"position": [0, 0, 0], "angular_velocity": [1, 2, 0.5]},
            "arm": start | {"position": [1, 0, 0], "center": [0.1, 0.2, 0]},
            "stone": {"position": [3, 0, 0], "mass": 2, "point": True},
        },
        "joints": {"ball": {"type": "ball", "bodies": ["rod", "arm"], "at": [0.5, 0, 0]}},
        "forces": {"rope": damper | {"points": [[0, 0.1, 0], [0, 0, 0]]}},
    }


@pytest.fixture(scope="module")
def solvers(
    compiler: Toolchain, tmp_path_factory: pytest.TempPathFactory
) -> tuple[DynamicsSolver, DynamicsSolver]:
    """Solvers in C and in NumPy."""
    folder: Path = tmp_path_factory.mktemp("thrown")
    write_tree(folder, generate_dynamics(scene_from_dict(thrown()), ("energies",)))
    return load_dynamics(folder, target="c"), load_dynamics(folder, target="numpy")


def test_momentum_stays_and_tells_how_good_a_run_is(
    solvers: tuple[DynamicsSolver, DynamicsSolver],
) -> None:
    sizes = []
    for tolerance in (1e-5, 1e-11):
        ledger = solvers[0].simulate(2.0, samples=21, tolerance=tolerance).ledger
        (found,) = ledger.momenta
        assert found.bodies == ("rod", "arm", "stone")
        assert found.linear is not None
        assert found.linear < 1e-13
        assert found.angular is not None
        sizes.append(found.angular)
        assert str(found) in str(ledger)
    assert 1e-8 < sizes[0] < 1e-3
    assert sizes[1] < 1e-10


@pytest.mark.usefixtures("numpy_solver", "shipped_flags")
def test_both_targets_tell_the_same_change(
    solvers: tuple[DynamicsSolver, DynamicsSolver],
) -> None:
    first, second = (one.simulate(1.0, samples=6, tolerance=1e-7).ledger for one in solvers)
    assert first.momenta == second.momenta


def test_a_run_that_goes_on_knows_the_momentum_of_its_start(
    solvers: tuple[DynamicsSolver, DynamicsSolver],
) -> None:
    times = np.linspace(0.0, 1.0, 11)
    whole = solvers[0].begin(times, tolerance=1e-7).finish().ledger
    run = solvers[0].begin(times, tolerance=1e-7)
    run.advance(max_steps=3)
    assert solvers[0].resume(run.save()).finish().ledger.momenta == whole.momenta


def test_rows_that_are_not_checked_have_none(
    solvers: tuple[DynamicsSolver, DynamicsSolver],
) -> None:
    assert solvers[0].simulate(0.1, samples=3, checks=False).ledger.momenta == ()


def cart() -> dict[str, Any]:
    """Cart on rails along x, and a pendulum that swings and turns below it."""
    solid = {"mass": 1, "inertia": INERTIA}
    bodies = {
        "cart": {"position": [0, 0, 0], "velocity": [1, 0, 0], **solid},
        "bob": {"position": [0.3, 0, -1], "angular_velocity": [1, 2, 3], **solid},
    }
    rails = {"type": "slider", "bodies": ["ground", "cart"], "at": [0, 0, 0], "axis": [1, 0, 0]}
    joints = {"rails": rails, "ball": {"type": "ball", "bodies": ["cart", "bob"], "at": [0, 0, 0]}}
    return {"name": "cart", "unit": "m", "gravity": [0, 0, -9.81], "bodies": bodies} | {
        "joints": joints
    }


def top() -> dict[str, Any]:
    """Top on a fixed point."""
    start = {"orientation": {"axis": [1, 0, 0], "angle": 0.5}, "angular_velocity_b": [0, 1, 30]}
    body = {"position": [0, 0, 0], "center": [0, 0, 1], "mass": 1, "inertia": INERTIA, **start}
    joints = {"tip": {"type": "ball", "bodies": ["ground", "top"], "at": [0, 0, 0]}}
    tree = {"name": "top", "unit": "m", "gravity": [0, 0, -9.81], "bodies": {"top": body}}
    return tree | {"joints": joints}


@pytest.mark.parametrize(
    ("tree", "which", "text"), [(cart, "linear", "kg m/s"), (top, "angular", "about a point of")]
)
def test_bodies_on_the_ground_keep_what_their_joints_leave(
    compiler: Toolchain, tmp_path: Path, tree: Any, which: str, text: str
) -> None:
    write_tree(tmp_path, generate_dynamics(scene_from_dict(tree()), ("energies",)))
    solver = load_dynamics(tmp_path, target="c")
    sizes = []
    for tolerance in (1e-5, 1e-11):
        ledger = solver.simulate(0.5, samples=3, tolerance=tolerance).ledger
        (found,) = ledger.momenta
        assert {"linear", "angular"} - {which} == {
            name for name in ("linear", "angular") if getattr(found, name) is None
        }
        sizes.append(getattr(found, which))
        assert text in str(ledger)
    # Steps keep what is linear in the velocities to rounding; the rest shows their error.
    assert (sizes[0] > 1e-10) == (which == "angular")
    assert sizes[0] < 1e-2
    assert sizes[1] < 1e-10
