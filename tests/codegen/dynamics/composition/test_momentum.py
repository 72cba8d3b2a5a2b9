"""Which momenta a system keeps, and that they are those of vector algebra."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.simplification.conserved_momenta import conserved_momenta
from kousoku.model.elements.along import CoordinateForce
from kousoku.model.elements.load import Load
from kousoku.model.elements.spring_damper import PointSpring
from kousoku.model.mechanics.multibody import GROUND_INDEX, ForceElement, RelativeCoordinate, System
from tests.analysed import all_rows
from tests.workspaces import put

if TYPE_CHECKING:
    from types import SimpleNamespace

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
NOWHERE = (("s_i_b", (0.1, 0.2, 0.3)), ("s_j_b", (0.3, 0.2, -0.1)))
LAW = (("stiffness", (70.0,)), ("damping", (6.0,)), ("free_length", (0.8,)))


def spring(i: int, j: int) -> ForceElement:
    return PointSpring("s", i, j, (*NOWHERE, *LAW))


def load(kind: str, j: int, *vectors: Any) -> ForceElement:
    name = kind.removesuffix("_b")
    given = [(f"{name}_{k}", vector) for k, vector in enumerate(vectors)]
    place = (("s_j_b", (0.3, 0.2, -0.1)),) if name == "force" else ()
    return Load("load", kind, GROUND_INDEX, j, (*place, *given))


@pytest.fixture
def flying(mechanisms: SimpleNamespace) -> System:
    """Two bodies on a joint, and a third one, with a spring between the parts."""
    bodies = tuple(mechanisms.body(f"b{k}", (k, 0.3 * k, 0.1)) for k in range(3))
    joint = mechanisms.point("ball", 0, 1, (0.5, 0.1, 0.0), (-0.5, -0.2, 0.0))
    gravity = (0.0, 0.0, -9.81)
    return System("flying", 1.0, bodies, (joint,), gravity, forces=(spring(1, 2),))


def counts(system: System) -> list[tuple[int, int, int]]:
    found = conserved_momenta(system, is_planar=False)
    return [(len(one.bodies), len(one.linear), len(one.angular)) for one in found]


def test_gravity_leaves_momentum_across_it_and_all_angular_momentum(flying: System) -> None:
    assert counts(flying) == [(3, 2, 3)]
    (found,) = conserved_momenta(flying, is_planar=False)
    assert found.linear == (X, (0.0, -1.0, 0.0))
    assert counts(replace(flying, gravity=(0.0, 0.0, 0.0))) == [(3, 3, 3)]
    law = replace(flying, gravity=(0.0, 0.0, 0.0), gravity_law=("", "g", ""))
    assert counts(law) == [(3, 2, 3)]


def test_parts_that_nothing_connects_are_told_apart(flying: System) -> None:
    assert counts(replace(flying, forces=())) == [(2, 2, 3), (1, 2, 3)]


@pytest.mark.parametrize("body", [0, 2])
def test_forces_of_the_ground_keep_what_is_across_them_or_about_their_point(
    flying: System, body: int
) -> None:
    tied = replace(flying, forces=(spring(1, 2), spring(GROUND_INDEX, body)))
    (found,) = conserved_momenta(tied, is_planar=False)
    assert (found.linear, found.angular, found.about) == ((), ((0.0, 0.0, -1.0),), (0.1, 0.2, 0.3))
    one = RelativeCoordinate("h", "n2", GROUND_INDEX, body, (("a_i_b", X), *NOWHERE))
    push = CoordinateForce("p", GROUND_INDEX, body, (("force", (1.0,)),), coordinate=0)
    pushed = replace(flying, coordinates=(one,), forces=(spring(1, 2), push))
    (found,) = conserved_momenta(pushed, is_planar=False)
    assert (found.linear, found.angular, found.about) == (((0.0, -1.0, 0.0),), (X,), None)


@pytest.mark.parametrize(
    ("forces", "wanted"),
    [
        ((load("force", 0, X),), [(3, 1, 1)]),
        ((load("force", 0, Z),), [(3, 2, 1)]),
        ((load("force", 0, X, Y),), []),
        ((load("force_b", 0, Z),), []),
        ((load("torque", 0, X),), [(3, 2, 2)]),
        ((load("torque", 0, X, (1.0, 1.0, 0.0)),), [(3, 2, 1)]),
        ((load("torque_b", 0, X),), [(3, 2, 0)]),
    ],
)
def test_loads_take_away_what_they_change(flying: System, forces: Any, wanted: Any) -> None:
    assert counts(replace(flying, forces=(spring(1, 2), *forces))) == wanted


def test_a_single_point_does_not_turn(mechanisms: SimpleNamespace) -> None:
    point = mechanisms.body("p", X, is_point=True, inertia=(0.0, 0.0, 0.0))
    assert counts(System("p", 1.0, (point,), (), (0.0, 0.0, -9.81))) == [(1, 2, 0)]


def test_momenta_are_those_of_vector_algebra(
    mechanisms: SimpleNamespace, flying: System, rng: np.random.Generator
) -> None:
    workspace = ProgramInterpreter(compose(all_rows(flying), ["energies", "checks"]))
    state = mechanisms.random_state(flying, rng)
    put(workspace, state)
    workspace.run("geometry", "momentum")
    masses = np.array([one.mass for one in flying.bodies])
    centre, drift = (masses @ np.array(state[name]) / masses.sum() for name in ("r", "v"))
    angular = np.zeros(3)
    for k, moving in enumerate(flying.bodies):
        e0, e = state["p"][k][0], state["p"][k][1:]
        skew = np.array([[0.0, -e[2], e[1]], [e[2], 0.0, -e[0]], [-e[1], e[0], 0.0]])
        turn = np.eye(3) + 2 * e0 * skew + 2 * skew @ skew
        angular += turn @ (np.array(moving.inertia) * state["omega_b"][k])
        angular += masses[k] * np.cross(state["r"][k] - centre, state["v"][k] - drift)
    linear = masses.sum() * drift
    wanted = [linear[0], -linear[1], *angular]
    np.testing.assert_allclose(workspace["momenta"], wanted, rtol=0, atol=1e-13)


def test_a_scene_in_a_plane_keeps_what_is_in_the_plane(mechanisms: SimpleNamespace) -> None:
    pendulum = mechanisms.planar_pendulum(2)
    flying = replace(pendulum, constraints=tuple(x for x in pendulum.constraints if x.i >= 0))
    program = compose(all_rows(flying), ["checks", "energies"])
    assert program.is_planar
    (found,) = program.conserved
    assert found.linear == (X,)
    assert found.angular == (Z,)


def test_a_scene_that_stands_on_the_ground_has_no_momenta(mechanisms: SimpleNamespace) -> None:
    program = compose(all_rows(mechanisms.chain(2)), ["checks", "energies"])
    assert program.conserved == ()
    assert "momentum" not in [segment.name for segment in program.segments]
