"""Coordinates in a program: values, rates and accelerations against differences in 50 digits."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.explanation.structure import structure_of
from kousoku.codegen.dynamics.recording.inline import inline
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.model.mechanics.multibody import GROUND_INDEX, RelativeCoordinate
from kousoku.model.numbers.digits import CONTEXT, HIGH
from tests.analysed import all_rows

if TYPE_CHECKING:
    from types import SimpleNamespace

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanics.multibody import System

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
POINTS = (("s_i_b", (0.3, -0.2, 0.4)), ("s_j_b", (-0.1, 0.5, 0.2)))
KINDS: dict[str, tuple[tuple[str, tuple[float, ...]], ...]] = {
    "angle": (("a_i_b", X), ("b_i_b", Y), ("a_j_b", Y)),
    "n1": (("a_i_b", X), ("a_j_b", Z)),
    "n2": (("a_i_b", Y), *POINTS),
    "length": POINTS,
}
STEP = CONTEXT.mpf(10) ** -15


def coordinate(kind: str, i: int, j: int, near: float = 0.0) -> RelativeCoordinate:
    return RelativeCoordinate(f"{kind}.{i}.{j}", kind, i, j, KINDS[kind], near)


def shown(system: System, *coordinates: RelativeCoordinate) -> System:
    return replace(system, coordinates=coordinates, shown=tuple(range(len(coordinates))))


@pytest.fixture(scope="module")
def all_kinds() -> list[RelativeCoordinate]:
    return [coordinate(kind, i, 1) for kind in KINDS for i in (GROUND_INDEX, 0)]


def moved(workspace: ProgramInterpreter, step: Any) -> list[Any]:
    """Run all with the state that is reached after a small time; return the coordinates."""
    q, v = workspace["q"], workspace["v"]
    workspace["dq"] = [step * x for x in v]
    workspace.run("move")
    workspace["q"] = workspace["q_moved"]
    workspace["v"] = [x + step * a for x, a in zip(v, workspace["v_dot"], strict=True)]
    v_dot = workspace["v_dot"]
    workspace.run("geometry", "coordinate")
    found = workspace["coordinates"]
    workspace["q"], workspace["v"], workspace["v_dot"] = q, v, v_dot
    return found


def anywhere(program: Program, rng: np.random.Generator) -> ProgramInterpreter:
    """State with Euler parameters of norm one, in 50 digits."""
    workspace = ProgramInterpreter(program, HIGH)
    for name in ("q", "v", "v_dot"):
        workspace[name] = [CONTEXT.mpf(x) for x in rng.normal(size=len(workspace[name]))]
    workspace["dq"] = [CONTEXT.mpf(0)] * len(workspace["v"])
    workspace.run("move")
    workspace["q"] = workspace["q_moved"]
    return workspace


@pytest.mark.parametrize("is_inline", [False, True])
def test_rates_and_accelerations_are_derivatives_of_the_values(
    mechanisms: SimpleNamespace,
    rng: np.random.Generator,
    all_kinds: list[RelativeCoordinate],
    is_inline: bool,
) -> None:
    system = shown(mechanisms.chain(2), *all_kinds)
    program = compose(all_rows(system, may_be_planar=False), ["coordinates", "accelerations"])
    if is_inline:
        program = inline(program, limit=10**6)
    workspace = anywhere(program, rng)
    workspace.run("geometry", "coordinate")
    here = workspace["coordinates"]
    before, after = moved(workspace, -STEP), moved(workspace, STEP)
    for k, one in enumerate(system.coordinates):
        value, rate, second = here[3 * k : 3 * k + 3]
        slopes = [(b - a) / (2 * STEP) for a, b in zip(before, after, strict=True)]
        assert abs(rate) > 0.01, one.name
        assert abs(slopes[3 * k] - rate) < 1e-20 * (1 + abs(rate)), (one.name, value)
        assert abs(slopes[3 * k + 1] - second) < 1e-20 * (1 + abs(second)), one.name


def test_values_are_those_of_vector_algebra(mechanisms: SimpleNamespace) -> None:
    (rod,) = mechanisms.chain(1).bodies
    turned = (math.cos(0.35), 0.0, 0.0, math.sin(0.35))
    system = replace(mechanisms.chain(1), bodies=(replace(rod, r=(1.0, 2.0, 3.0), p=turned),))
    system = shown(system, *(coordinate(kind, GROUND_INDEX, 0) for kind in KINDS))
    workspace = ProgramInterpreter(
        compose(all_rows(replace(system, constraints=())), ["coordinates"])
    )
    workspace.run("geometry", "coordinate")
    angle, cosine, height, length = workspace["coordinates"][::2]
    c, s = math.cos(0.7), math.sin(0.7)
    end = np.array([1 - 0.1 * c - 0.5 * s, 2 - 0.1 * s + 0.5 * c, 3.2]) - POINTS[0][1]
    assert angle == pytest.approx(math.pi / 2 + 0.7, abs=1e-15)
    assert cosine == 0.0
    assert height == pytest.approx(end[1], abs=1e-15)
    assert length == pytest.approx(np.linalg.norm(end), abs=1e-15)


@pytest.mark.parametrize("turns", [-3, 0, 1, 100])
def test_angle_is_counted_from_a_value_less_than_half_a_turn_away(
    mechanisms: SimpleNamespace, turns: int
) -> None:
    angle = math.pi / 2 + 2 * math.pi * turns
    for away in (-3.0, 0.0, 3.0):
        system = shown(
            mechanisms.planar_pendulum(1), coordinate("angle", GROUND_INDEX, 0, angle + away)
        )
        program = compose(all_rows(system), ["coordinates"])
        assert program.is_planar
        workspace = ProgramInterpreter(program)
        workspace.run("geometry", "coordinate", "move")
        assert workspace["coordinates"][0] == pytest.approx(angle, abs=1e-13)
        assert workspace["q_moved"][-1] == pytest.approx(angle, abs=1e-13)


def test_entry_of_an_angle_turns_as_fast_as_the_angle(mechanisms: SimpleNamespace) -> None:
    (rod,) = mechanisms.planar_pendulum(1).bodies
    turning = replace(rod, v=(0.0, 1.5, 0.0), omega_b=(0.0, 0.0, 3.0))
    system = shown(
        replace(mechanisms.planar_pendulum(1), bodies=(turning,)),
        coordinate("angle", GROUND_INDEX, 0),
    )
    program = compose(all_rows(system))
    assert [(one.kind, one.name) for one in program.auxiliary] == [("turns", "angle.-1.0")]
    workspace = ProgramInterpreter(program)
    workspace.run("geometry", "acceleration")
    assert len(workspace["q_dot"]) == 5
    assert workspace["q_dot"][-1] == pytest.approx(3.0, abs=1e-15)
    assert len(workspace["v"]) == 3
    assert structure_of(system, program).positions == 4


def test_coordinates_that_are_not_wanted_cost_nothing(mechanisms: SimpleNamespace) -> None:
    system = mechanisms.chain(2)
    lengths = shown(system, *(coordinate(kind, 0, 1) for kind in ("n1", "n2", "length")))
    plain, given = compose(all_rows(system)), compose(all_rows(lengths))
    assert given.kernels == plain.kernels
    assert given.segments == plain.segments
    assert given.regions == plain.regions
