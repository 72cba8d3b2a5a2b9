"""Rows that combine coordinates: against differences in 50 digits, and dense equations."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly.driver_laws import fixed_law
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.operations.characteristic_length import characteristic_length
from kousoku.codegen.dynamics.recording.inline import inline
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.simplification.forces_plane import is_flat
from kousoku.model.lowering.system import system_of
from kousoku.model.mechanics.constraints import COMBINATION
from kousoku.model.mechanics.multibody import GROUND_INDEX, Instance, RelativeCoordinate, Term
from kousoku.model.numbers.digits import CONTEXT, HIGH
from kousoku.model.reading.read import scene_from_toml
from tests.analysed import all_rows

if TYPE_CHECKING:
    from types import SimpleNamespace

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanics.multibody import System

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
POINTS = (("s_i_b", (0.3, -0.2, 0.4)), ("s_j_b", (-0.1, 0.5, 0.2)))
COORDINATES = (
    RelativeCoordinate(
        "first", "angle", GROUND_INDEX, 0, (("a_i_b", Z), ("b_i_b", X), ("a_j_b", X))
    ),
    RelativeCoordinate("second", "angle", 1, 2, (("a_i_b", Y), ("b_i_b", Z), ("a_j_b", X))),
    RelativeCoordinate("rod", "length", 0, 2, POINTS),
    RelativeCoordinate("across", "n1", 0, 1, (("a_i_b", X), ("a_j_b", Y))),
    RelativeCoordinate("along", "n1", 0, 1, (("a_i_b", Y), ("a_j_b", X))),
    RelativeCoordinate("height", "n2", GROUND_INDEX, 1, (("a_i_b", Z), *POINTS)),
)
LAW = "1.5*t + k*sin(3*t)^2"
STEP = CONTEXT.mpf(10) ** -15


def combined(name: str, terms: tuple[tuple[int, float], ...], **given: Any) -> Instance:
    used = [COORDINATES[place] for place, _ in terms]
    i, j, *others = dict.fromkeys(body for one in used for body in (one.i, one.j))
    parts = tuple(Term(*pair) for pair in terms)
    unit = given.pop("unit", "rad")
    return Instance(name, COMBINATION, i, j, terms=parts, others=tuple(others), unit=unit, **given)


ROWS = {
    "driver": combined("motor", ((0, 1.0),), law=LAW),
    "driver of a length": combined("jack", ((2, 1.0),), law=LAW, law_unit=0.1, unit="m"),
    "gear": combined("gear", ((0, 2.7), (1, -1.3)), offset=0.4),
    "equal speeds": combined("joint", ((3, 1.0), (4, -1.0))),
    "screw": combined("screw", ((5, 1.0), (0, -0.02)), unit="m"),
    "driven sum": combined("sum", ((2, 0.5), (1, 1.0), (5, -2.0)), law=LAW, offset=-0.3),
}


def system_with(mechanisms: SimpleNamespace, *rows: Instance) -> System:
    """Three bodies, two of them in a chain, with further rows."""
    chain: System = mechanisms.chain(3)
    kept = tuple(one for one in chain.constraints if one.joint != "j2")
    return replace(
        chain,
        constraints=(*kept[:2], *rows, *kept[2:]),
        coordinates=COORDINATES,
        parameters=(("k", 0.25),),
    )


def program_of(system: System) -> Program:
    return compose(all_rows(system, may_be_planar=False), ["reactions", "checks"])


def anywhere(program: Program, rng: np.random.Generator) -> ProgramInterpreter:
    """State at some time, Euler parameters of norm one, in 50 digits."""
    workspace = ProgramInterpreter(program, HIGH)
    for name in ("q", "v"):
        workspace[name] = [CONTEXT.mpf(x) for x in rng.normal(size=len(workspace[name]))]
    assert workspace["parameters"] == [0.25]
    workspace["t"] = [CONTEXT.mpf(0.3)]
    workspace["dq"] = [CONTEXT.mpf(0)] * len(workspace["v"])
    workspace.run("move")
    workspace["q"] = workspace["q_moved"]
    workspace.run("geometry", "acceleration", "check")
    return workspace


def later(workspace: ProgramInterpreter, step: Any) -> tuple[list[Any], list[Any]]:
    """Constraints C and their rate a small time later on the motion."""
    kept = {name: workspace[name] for name in ("t", "q", "v", "v_dot")}
    workspace["t"] = [x + step for x in kept["t"]]
    workspace["dq"] = [step * x for x in kept["v"]]
    workspace.run("move")
    workspace["q"] = workspace["q_moved"]
    workspace["v"] = [x + step * a for x, a in zip(kept["v"], kept["v_dot"], strict=True)]
    workspace.run("geometry", "check")
    found = workspace["C"], workspace["C_dot"]
    for name, values in kept.items():
        workspace[name] = values
    return found


@pytest.mark.parametrize("name", ROWS)
def test_rates_of_rows_are_derivatives_of_their_residuals(
    mechanisms: SimpleNamespace, rng: np.random.Generator, name: str
) -> None:
    program = program_of(system_with(mechanisms, ROWS[name]))
    workspace = anywhere(program, rng)
    # with other accelerations than the right ones the second derivative is not zero
    workspace["v_dot"] = [CONTEXT.mpf(x) for x in rng.normal(size=len(workspace["v"]))]
    workspace.run("geometry", "check")
    here = workspace["C_dot"], workspace["C_ddot"]
    before, after = later(workspace, -STEP), later(workspace, STEP)
    for a_level, b_level, rates in zip(before, after, here, strict=True):
        pairs = zip(a_level, b_level, rates, strict=True)
        for row, (a, b, rate) in zip(program.rows, pairs, strict=True):
            slope = (b - a) / (2 * STEP)
            assert abs(rate) > 1e-3, row
            assert abs(slope - rate) < 1e-20 * (1 + abs(rate)), row


@pytest.mark.parametrize("name", ROWS)
@pytest.mark.parametrize("is_inline", [False, True])
def test_accelerations_and_multipliers_are_those_of_the_dense_equations(
    mechanisms: SimpleNamespace, rng: np.random.Generator, name: str, is_inline: bool
) -> None:
    system = system_with(mechanisms, ROWS[name])
    program = program_of(system)
    if is_inline:
        program = inline(program, limit=10**6)
    workspace = anywhere(program, rng)
    v_dot, lam = ([float(x) for x in workspace[part]] for part in ("v_dot", "lam"))
    free = anywhere(program_of(replace(system, constraints=())), rng)
    for part in ("q", "v"):
        free[part] = workspace[part][: len(free[part])]
    free.run("geometry", "acceleration")
    jacobian, gamma = dense(workspace)
    mass = np.diag([x for one in system.bodies for x in (*(one.mass,) * 3, *one.inertia)])
    force = mass @ np.array([float(x) for x in free["v_dot"]])
    zeros = np.zeros((len(gamma), len(gamma)))
    matrix = np.block([[mass, jacobian.T], [jacobian, zeros]])
    wanted = np.linalg.solve(matrix, np.hstack([force, gamma]))
    scale = np.abs(wanted).max()
    np.testing.assert_allclose(np.hstack([v_dot, lam]), wanted, rtol=0, atol=1e-11 * scale)


def dense(workspace: ProgramInterpreter) -> tuple[Any, Any]:
    """Jacobian C_q, from the rates of unit velocities, and γ."""
    v, v_dot = workspace["v"], workspace["v_dot"]
    base = np.array([float(x) for x in workspace["C_dot"]])
    columns = []
    for k in range(len(v)):
        workspace["v"] = [x + (n == k) for n, x in enumerate(v)]
        workspace.run("check")
        columns.append(np.array([float(x) for x in workspace["C_dot"]]) - base)
    workspace["v"], workspace["v_dot"] = v, [CONTEXT.mpf(0)] * len(v)
    workspace.run("check")
    gamma = -np.array([float(x) for x in workspace["C_ddot"]])
    workspace["v_dot"] = v_dot
    return np.array(columns).T, gamma


def test_a_joint_of_several_bodies_couples_to_those_of_each(mechanisms: SimpleNamespace) -> None:
    program = program_of(system_with(mechanisms, *ROWS.values()))
    rows = [row for row in program.rows if row.joint == "gear"]
    assert len(rows) == 1
    assert program.region("lam").size == len(program.rows) == 10 + len(ROWS)


@pytest.mark.parametrize(
    ("law", "value"),
    [("", 0.0), ("2*3 - 1", 2.5), ("t", np.inf), ("k", np.inf), ("0", 0.0)],
)
def test_a_law_is_fixed_if_neither_time_nor_parameters_change_it(law: str, value: float) -> None:
    one = combined("motor", ((0, 1.0),), law=law, law_unit=0.5)
    assert fixed_law(one, ["k"]) == value


def test_a_row_between_planes_is_left_out_only_while_its_law_is_fixed(
    mechanisms: SimpleNamespace,
) -> None:
    height = RelativeCoordinate(
        "height",
        "n2",
        GROUND_INDEX,
        0,
        (("a_i_b", Z), ("s_i_b", (0.0, 0.0, 0.0)), ("s_j_b", (0.0, 0.0, 0.0))),
    )
    free = replace(
        mechanisms.planar_pendulum(1), constraints=(), coordinates=(height,), parameters=()
    )

    def is_planar(**given: Any) -> bool:
        row = Instance("guide", COMBINATION, GROUND_INDEX, 0, terms=(Term(0, 1.0),), **given)
        return compose(all_rows(replace(free, constraints=(row,)))).is_planar

    assert is_planar()
    assert is_planar(law="0")
    assert not is_planar(law="sin(t)")
    assert not is_planar(offset=0.1)
    assert is_planar(law="0.1", offset=0.1)


@pytest.mark.parametrize("plane", [1, 2])
def test_a_driven_chain_is_planar_in_any_plane_and_moves_alike(
    mechanisms: SimpleNamespace, plane: int
) -> None:
    def turn(values: Any) -> Any:
        return tuple(np.roll(values, -plane).tolist()) if len(values) == 3 else values

    one = mechanisms.planar_pendulum(2)
    angle = RelativeCoordinate("angle", "angle", 0, 1, (("a_i_b", X), ("b_i_b", Y), ("a_j_b", X)))
    row = Instance("motor", COMBINATION, 0, 1, terms=(Term(0, 1.0),), law="t^2", unit="rad")
    one = replace(one, constraints=(*one.constraints, row), coordinates=(angle,))

    def constants(given: Any) -> Any:
        return tuple((name, turn(values)) for name, values in given)

    other = replace(
        one,
        bodies=tuple(
            replace(body, r=turn(body.r), inertia=turn(body.inertia)) for body in one.bodies
        ),
        constraints=tuple(
            replace(
                own,
                kind=own.kind.replace("p1_z", f"p1_{'zyx'[plane]}"),
                constants=constants(own.constants),
            )
            for own in one.constraints
        ),
        coordinates=(replace(angle, constants=constants(angle.constants)),),
        gravity=turn(one.gravity),
    )
    found = []
    for system in (one, other):
        program = compose(all_rows(system))
        assert program.is_planar
        workspace = ProgramInterpreter(program)
        workspace.run("geometry", "acceleration")
        found.append(workspace["v_dot"])
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-12)
    assert found[0][5] - found[0][2] == pytest.approx(2.0, abs=1e-12)


@pytest.mark.parametrize(("height", "flat"), [(0.0, True), (0.2, False)])
def test_a_driver_beside_the_plane_has_forces_that_lead_out_of_it(
    mechanisms: SimpleNamespace, height: float, flat: bool
) -> None:
    ends = (("s_i_b", (0.0, 2.0, 0.0)), ("s_j_b", (0.1, 0.0, height)))
    rod = RelativeCoordinate("rod", "length", GROUND_INDEX, 0, ends)
    jack = Instance("jack", COMBINATION, GROUND_INDEX, 0, terms=(Term(0, 1.0),), law="2+t")
    system = mechanisms.planar_pendulum(1)
    system = replace(system, constraints=(*system.constraints, jack), coordinates=(rod,))
    outline = all_rows(system).outline
    assert outline.is_planar
    assert is_flat(system, outline.normal) == flat
    assert characteristic_length(system) == 2.0


@pytest.mark.parametrize(("heights", "flat"), [((0.5, 0.5), True), ((-0.5, 0.5), False)])
def test_bodies_are_in_one_plane_at_one_height(
    mechanisms: SimpleNamespace, heights: tuple[float, float], flat: bool
) -> None:
    system = mechanisms.planar_pendulum(2)
    normal = all_rows(system).outline.normal
    assert normal is not None
    bodies = []
    for body, height in zip(system.bodies, heights, strict=True):
        r = list(body.r)
        r[normal] = height
        bodies.append(replace(body, r=tuple(r)))
    assert is_flat(replace(system, bodies=tuple(bodies), constraints=()), normal) == flat


@pytest.mark.parametrize("off", [0.0, 6e-17, 1e-10])
def test_places_that_differ_by_rounding_make_no_length(off: float) -> None:
    scene = f"""
name = "rail"
unit = "m"
[bodies]
cart = {{ position = [{off}, 0, 0], boxes = [{{ mass = 1, size = [0.2, 0.2, 0.2] }}] }}
[joints.rail]
type = "prismatic"
bodies = ["ground", "cart"]
points = [[0, 0, 0], [{off}, 0, 0]]
axes = [[1, 0, 0], [1, 0, 0]]
"""
    length = characteristic_length(system_of(scene_from_toml(scene)))
    assert length == pytest.approx(0.1 * math.sqrt(2.0 / 3.0), rel=1e-9)


@pytest.mark.parametrize(("far", "length"), [(0.0, 2.0), (1e5, 2.0), (2.0**20, 4.0)])
def test_the_length_of_a_system_is_the_same_wherever_it_stands(
    mechanisms: SimpleNamespace, far: float, length: float
) -> None:
    """So far away that doubles know no positions it is what they do know, times a number."""
    system = mechanisms.planar_pendulum(1)
    ends = (("s_i_b", (far, 2.0, 0.0)), ("s_j_b", (0.1, 0.0, 0.0)))
    other = (("s_i_b", (far, 0.0, 0.0)), ("s_j_b", (0.1, 0.0, 0.0)))
    rods = tuple(RelativeCoordinate("rod", "length", GROUND_INDEX, 0, own) for own in (ends, other))
    assert characteristic_length(replace(system, constraints=(), coordinates=rods)) == length
