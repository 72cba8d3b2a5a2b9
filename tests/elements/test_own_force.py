"""A force that is not shipped takes two files and two lines, from its scene to a run's ledger."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.analyse import analyse
from kousoku.codegen.dynamics.checking import newton_euler
from kousoku.codegen.dynamics.elements.force_facets import FORCE_FACETS
from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.elements.forces import FORCES
from kousoku.model.errors import SceneError
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.read import scene_from_dict, scene_from_toml
from kousoku.model.reading.schema import scene_schema
from kousoku.model.reading.write import to_toml
from kousoku.runtime import verify
from kousoku.runtime.dynamics import load_dynamics
from tests.elements.quadratic_drag import Drag, QuadraticDrag
from tests.elements.quadratic_drag_facets import DragFacets

if TYPE_CHECKING:
    from pathlib import Path

    from kousoku.model.records.scene import Scene

Tree = dict[str, Any]

GRAVITY, MASS, COEFFICIENT = 9.81, 2.0, 0.5


@pytest.fixture(autouse=True)
def drag(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let scenes have it: a line in each of the two tables."""
    monkeypatch.setitem(FORCES, "quadratic_drag", QuadraticDrag())
    monkeypatch.setitem(FORCE_FACETS, Drag, DragFacets)


def falling(**force: Any) -> Tree:
    """Point that falls, in mm; the coefficient is a parameter in kg/mm."""
    given = {"type": "quadratic_drag", "body": "ball", "coefficient": "c"} | force
    return {
        "name": "falling",
        "unit": "mm",
        "gravity": [0, 0, -1000 * GRAVITY],
        "parameters": {"c": COEFFICIENT / 1000},
        "bodies": {"ball": {"position": [0, 0, 0], "point": True, "mass": MASS}},
        "forces": {"air": given},
        "outputs": ["positions", "velocities", "accelerations", "energies"],
    }


def swinging() -> Tree:
    """Pendulum that is braked at a point beside its axis and beside its plane."""
    inertia = {"xx": 0.3, "yy": 0.4, "zz": 0.5}
    blade = {"position": [0.8, 0, 0], "mass": 0.5, "inertia": inertia}
    hub = {"position": [0, 0, 0], "mass": MASS, "center": [0.5, 0, 0], "inertia": inertia}
    return {
        "name": "swinging",
        "unit": "m",
        "gravity": [0, -GRAVITY, 0],
        "bodies": {"hub": hub | {"angular_velocity": [0, 0, 2]}, "blade": blade},
        "joints": {
            "pin": {
                **{"type": "revolute", "bodies": ["ground", "hub"]},
                **{"at": [0, 0, 0], "axis": [0, 0, 1]},
            },
            "weld": {"type": "fixed", "bodies": ["hub", "blade"], "at": [0.8, 0, 0]},
        },
        "forces": {
            "air": {
                **{"type": "quadratic_drag", "body": "blade"},
                **{"centre": [0.1, 0.2, 0], "coefficient": COEFFICIENT},
            }
        },
        "outputs": ["positions", "velocities", "accelerations", "energies"],
    }


def folder_of(scene: Scene, path: Path) -> Path:
    write_tree(path / scene.name, generate_dynamics(scene, references=True))
    return path / scene.name


def test_a_scene_with_it_is_written_and_read_again() -> None:
    scene = scene_from_dict(swinging())
    assert scene.forces["air"].inputs == {"centre": (0.1, 0.2, 0.0), "coefficient": COEFFICIENT}
    assert scene_from_toml(to_toml(scene)) == scene


@pytest.mark.parametrize(
    ("force", "message"),
    [
        ({"body": None}, r"forces\.air\.body is missing; wanted the body that it brakes"),
        ({"body": "bal"}, r"forces\.air\.body.*did you mean 'ball'"),
        ({"coefficient": None}, r"forces\.air\.coefficient is missing; wanted one number"),
        ({"coefficient": [1, 2]}, r"forces\.air\.coefficient"),
        ({"coefficient": "c*t"}, r"forces\.air\.coefficient.*'t'"),
        ({"coeficient": 1}, r"forces\.air\.coeficient.*did you mean 'coefficient'"),
        ({"stiffness": 1}, r"forces\.air\.stiffness a quadratic_drag has none; leave it out"),
        ({"type": "torque"}, r"forces\.air\.coefficient unknown key"),
    ],
)
def test_what_is_wrong_with_it_is_told(force: Tree, message: str) -> None:
    tree = falling(**force)
    tree["forces"]["air"] = {k: x for k, x in tree["forces"]["air"].items() if x is not None}
    with pytest.raises(SceneError) as caught:
        scene_from_dict(tree)
    assert re.search(message, str(caught.value).replace(": ", " "))


def test_editors_know_its_keys() -> None:
    known = scene_schema()["$defs"]["Force"]["properties"]
    assert "quadratic_drag" in known["type"]["enum"]
    assert known["coefficient"]["description"].startswith("c of F")


def test_it_is_lumped_and_stays_in_its_plane() -> None:
    found = analyse(system_of(scene_from_dict(swinging())), ())
    (force,) = found.system.forces
    assert isinstance(force, Drag)
    assert len(found.system.bodies) == 1
    assert found.outline.is_planar


def test_no_momentum_is_said_to_be_kept_of_what_it_brakes() -> None:
    tree = falling() | {"gravity": [0, 0, 0]}
    kept = [analyse(system_of(scene_from_dict(one)), ()).momenta for one in (tree, _free(tree))]
    assert [bool(one) for one in kept] == [False, True]


def _free(tree: Tree) -> Tree:
    return {key: value for key, value in tree.items() if key not in ("forces", "parameters")}


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("tree", [falling(), swinging()], ids=["falling", "swinging"])
def test_its_solver_is_verified_against_its_definition(tree: Tree, tmp_path: Path) -> None:
    report = verify(folder_of(scene_from_dict(tree), tmp_path), target="numpy")
    assert report.problems == ()
    outputs = {row.output for row in report.rows if row.kernel == "newton_euler"}
    assert {"acceleration", "power"} <= outputs


@pytest.mark.usefixtures("numpy_solver")
def test_what_differs_from_its_definition_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    right = newton_euler.NewtonEulerEquations.apply_force

    def wrong(equations: Any, body: int, at: Any, arm: Any, force: Any, found: Any) -> None:
        right(equations, body, at, arm, [2 * x for x in force], found)

    monkeypatch.setattr(newton_euler.NewtonEulerEquations, "apply_force", wrong)
    report = verify(folder_of(scene_from_dict(swinging()), tmp_path), target="numpy")
    assert any("newton_euler" in problem for problem in report.problems)


@pytest.mark.usefixtures("compiler")
def test_a_fall_is_that_of_the_closed_form_and_its_energy_is_balanced(tmp_path: Path) -> None:
    """V = w tanh(g t/w), with w = √(m g/c), and z = −(w²/g) ln cosh(g t/w)."""
    solver = load_dynamics(folder_of(scene_from_dict(falling()), tmp_path), target="c")
    times = np.linspace(0, 3, 7)
    motion = solver.simulate(times=times, tolerance=1e-11)
    last = math.sqrt(MASS * GRAVITY / COEFFICIENT)
    fall = 1000 * last**2 / GRAVITY * np.log(np.cosh(GRAVITY * times / last))
    np.testing.assert_allclose(motion.position["ball"][:, 2], -fall, rtol=0, atol=1e-5)
    speed = 1000 * last * np.tanh(GRAVITY * times / last)
    np.testing.assert_allclose(motion.velocity["ball"][:, 2], -speed, rtol=0, atol=1e-5)
    lost = MASS * (speed**2 / 2 - 1000 * GRAVITY * fall)
    np.testing.assert_allclose(motion.work["air"], lost, rtol=1e-9, atol=1e-3)
    assert motion.ledger.energy_error is not None
    assert motion.ledger.energy_error < 1e-9 * abs(lost[-1]) / 1000**2
    np.testing.assert_allclose(motion.energy["total"] - motion.work["air"], 0, atol=1e-3)
