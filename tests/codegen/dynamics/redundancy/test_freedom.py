"""Degrees of freedom and dependent rows are found, and what is left out can be left out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.redundancy.freedom import Mobility, mobility_of
from kousoku.codegen.dynamics.redundancy.loops import loops_of
from kousoku.codegen.dynamics.redundancy.rank import damped_change, factorise, rows_to_leave
from kousoku.model.lowering.system import system_of
from kousoku.model.mechanics.multibody import Instance, System
from kousoku.model.reading.read import read_scene, scene_from_toml
from tests.analysed import all_rows, independent

if TYPE_CHECKING:
    from types import SimpleNamespace

GRAVITY = (0.0, 0.0, -9.81)
Y, Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
SCENES = Path(__file__).parents[4] / "scenes"
TURN = np.linalg.qr(np.array([[1.0, 0.4, 0.2], [0.3, -1.0, 0.7], [0.1, 0.5, 1.0]]))[0]


@pytest.fixture
def made(mechanisms: SimpleNamespace) -> SimpleNamespace:
    """Mechanisms that systems are made of."""
    return mechanisms


def of(system: System, *, may_be_planar: bool = False) -> Mobility:
    return mobility_of(system, all_rows(system, may_be_planar=may_be_planar).outline)


def bricard() -> System:
    return assemble(system_of(read_scene(SCENES / "bricard.toml")))


def turned_bar(made: SimpleNamespace) -> System:
    """Four-bar whose axes are parallel to a direction that is in no coordinate plane."""
    corners = [np.array(x) for x in ((0, 0, 0), (0.3, 1, 0), (2.3, 1.4, 0), (2, 0, 0))]
    rods = [(0, 1), (1, 2), (2, 3)]
    sign = np.sign(np.linalg.det(TURN))
    middles = [sign * TURN @ ((corners[a] + corners[b]) / 2) for a, b in rods]
    bodies = tuple(made.body(f"rod{k}", middle) for k, middle in enumerate(middles))
    axis = tuple(sign * TURN @ (0, 0, 1.0))
    constraints: list[Instance] = []
    for k, corner in enumerate(corners):
        i, j = k - 1, (k if k < len(rods) else -1)
        at = sign * TURN @ corner
        s_i, s_j = ((at if m < 0 else at - middles[m]) for m in (i, j))
        constraints += made.revolute(f"j{k}", i, j, s_i, s_j, axis)
    return System("turned", 1.0, bodies, tuple(constraints), GRAVITY)


def test_a_chain_has_a_degree_for_each_joint_and_no_loop(made: SimpleNamespace) -> None:
    freedom = of(made.chain(5))

    assert (freedom.degrees, freedom.dropped, freedom.positions) == (5, (), 0)
    assert loops_of(made.chain(5)) == ()


def test_loops_that_share_a_body_are_looked_at_apart(made: SimpleNamespace) -> None:
    one, other = turned_bar(made), turned_bar(made)
    shifted = [
        Instance(f"k{c.joint}", c.kind, c.i + 3 if c.i >= 0 else 1, c.j + 3 if c.j >= 0 else 1, ())
        for c in other.constraints
    ]
    both = System("both", 1.0, (*one.bodies, *other.bodies), (*one.constraints, *shifted), GRAVITY)

    first, second = loops_of(both)
    assert (first.bodies, first.is_grounded) == ((0, 1, 2), True)
    assert (second.bodies, second.is_grounded) == ((1, 3, 4, 5), False)


def test_a_four_bar_in_a_plane_has_no_dependent_row(made: SimpleNamespace) -> None:
    freedom = of(made.four_bars(2), may_be_planar=True)

    assert (freedom.degrees, freedom.dependent) == (1, ())


def test_a_four_bar_with_axes_in_no_coordinate_plane_has_three_dependent_rows(
    made: SimpleNamespace,
) -> None:
    freedom = of(turned_bar(made))

    assert (freedom.columns, freedom.rows, freedom.rank, freedom.degrees) == (18, 20, 17, 1)
    (found,) = freedom.dependent
    assert (found.joints, found.dimension) == (("j0", "j1", "j2", "j3"), 3)
    assert found.is_everywhere
    assert freedom.not_unique == ("j0", "j1", "j2", "j3")
    assert freedom.worst > 0.1


def test_the_linkage_of_bricard_moves_although_it_should_not_by_count() -> None:
    freedom = of(bricard())

    assert (freedom.columns, freedom.rows, freedom.degrees) == (30, 30, 1)
    assert len(freedom.dropped) == 1
    assert freedom.dependent[0].joints == ("a", "b", "c", "d", "e", "f")
    assert freedom.positions > 20
    assert freedom.worst > 0.1


def test_a_loop_of_revolutes_without_the_geometry_of_bricard_does_not_move(
    made: SimpleNamespace,
) -> None:
    system = bricard()
    moved = list(system.constraints)
    axis = (0.0, 0.6, 0.8)
    place = next(k for k, c in enumerate(moved) if c.joint == "f" and c.kind.startswith("p1"))
    moved[place] = made.parallel("f", moved[place].i, moved[place].j, Y, None)
    broken = of(System("x", 1.0, system.bodies, tuple(moved), GRAVITY))
    stiff = Instance("f", "n1", moved[place].i, -1, (("a_i_b", axis), ("a_j_b", Z)))
    held = of(System("x", 1.0, system.bodies, (*system.constraints, stiff), GRAVITY))

    assert broken.rank >= 29
    assert held.degrees == 0


def test_a_program_keeps_as_many_rows_as_the_rank(made: SimpleNamespace) -> None:
    found = independent(turned_bar(made))
    program, freedom = compose(found), found.mobility

    assert len(program.rows) == freedom.rank == 17
    kept = {(row.instance, row.row) for row in program.rows}
    assert not kept & {(row.instance, row.row) for row in freedom.dropped}


def test_two_equal_joints_are_one_joint_and_rows_to_leave_out(made: SimpleNamespace) -> None:
    link = made.revolute("one", -1, 0, (0, 0, 0), (-0.5, 0, 0), Z)
    again = [Instance("two", c.kind, c.i, c.j, c.constants) for c in link]
    freedom = of(System("twice", 1.0, (made.body("b", (0.5, 0, 0)),), (*link, *again), GRAVITY))

    assert (freedom.degrees, len(freedom.dropped)) == (1, 5)
    assert sum(found.dimension for found in freedom.dependent) == 5
    assert freedom.not_unique == ("one", "two")


def test_a_linkage_that_lies_flat_loses_rank_there_only(made: SimpleNamespace) -> None:
    """A parallelogram on one line: its rows are dependent there, and nowhere near."""
    bodies = tuple(
        made.body(f"rod{k}", r) for k, r in enumerate([(0.5, 0, 0), (2.0, 0, 0), (2.5, 0, 0)])
    )
    joints = [
        *made.revolute("a", -1, 0, (0, 0, 0), (-0.5, 0, 0), Z),
        *made.revolute("b", 0, 1, (0.5, 0, 0), (-1.0, 0, 0), Z),
        *made.revolute("c", 1, 2, (1.0, 0, 0), (0.5, 0, 0), Z),
        *made.revolute("d", 2, -1, (-0.5, 0, 0), (2.0, 0, 0), Z),
    ]
    flat = System("flat", 1.0, bodies, tuple(joints), (0.0, -9.81, 0.0))
    freedom = of(flat, may_be_planar=True)

    assert (freedom.degrees, freedom.dropped) == (1, ())
    (found,) = freedom.dependent
    assert (found.dimension, found.is_everywhere) == (1, False)
    assert freedom.not_unique == ()


def test_points_between_the_same_bodies_that_hold_too_much_cannot_move(
    made: SimpleNamespace,
) -> None:
    ends = ((0, 0, 0), (1, 0, 0), (0, 1, 0))
    joints = [made.point(f"p{k}", -1, 0, at, at) for k, at in enumerate(ends)]
    freedom = of(System("held", 1.0, (made.body("b", (0, 0, 0)),), tuple(joints), GRAVITY))

    assert (freedom.rows, freedom.rank, freedom.degrees) == (9, 6, 0)


@pytest.mark.parametrize("rank", [1, 3, 5])
def test_dependences_are_all_that_is_zero_times_the_matrix(rank: int) -> None:
    numbers = np.random.default_rng(rank)
    matrix: Any = numbers.normal(size=(8, rank)) @ numbers.normal(size=(rank, 6))
    factors = factorise(matrix)
    dependences = factors.dependences()

    assert factors.rank == rank
    assert dependences.shape == (8 - rank, 8)
    assert np.allclose(dependences @ matrix, 0, atol=1e-12)
    assert np.allclose(dependences @ dependences.T, np.eye(8 - rank))
    x = factors.least_change(matrix @ np.arange(6.0))
    assert np.allclose(matrix @ x, matrix @ np.arange(6.0))
    assert np.allclose(x, np.linalg.pinv(matrix) @ matrix @ np.arange(6.0))
    assert np.allclose(damped_change(matrix, matrix @ x, 1e-9), x, atol=1e-6)


def test_a_row_is_left_out_that_depends_on_others_at_all_positions() -> None:
    """At each of two positions another row would be best, and a third one is good at both."""
    here, there = np.array([[0.0, 0.8, 0.6]]), np.array([[0.8, 0.0, 0.6]])

    assert rows_to_leave([here]) == ((1,), 0.8)
    left, worst = rows_to_leave([here, there])
    assert left == (2,)
    assert worst == pytest.approx(0.6)


#: Two bars of 1 m in line between two points 2 m apart: they hold each other, though no row does
#: in first order: else one was left out, and a joint came open.
STRETCHED = """
name = "stretched"
unit = "m"
gravity = [0, -9.81, 0]
[bodies]
one = { position = [0, 0, 0], mass = 1, inertia = { xx = 1, yy = 1, zz = 1 } }
other = { position = [1, 0, 0], mass = 1, inertia = { xx = 1, yy = 1, zz = 1 } }
[joints]
a = { type = "hinge", bodies = ["ground", "one"], at = [0, 0, 0], axis = [0, 0, 1] }
b = { type = "hinge", bodies = ["one", "other"], at = [1, 0, 0], axis = [0, 0, 1] }
c = { type = "hinge", bodies = ["other", "ground"], at = [2, 0, 0], axis = [0, 0, 1] }
"""


@pytest.mark.parametrize(("may_be_planar", "dimension"), [(True, 1), (False, 4)])
def test_no_row_is_left_out_where_bars_in_line_hold_each_other(
    may_be_planar: bool, dimension: int
) -> None:
    system = assemble(system_of(scene_from_toml(STRETCHED)))
    freedom = of(system, may_be_planar=may_be_planar)

    assert (freedom.positions, freedom.degrees) == (1, 0)
    assert freedom.dropped == ()
    assert not any(one.is_everywhere for one in freedom.dependent)
    assert {one.joints for one in freedom.dependent} == {("a", "b", "c")}
    assert sum(one.dimension for one in freedom.dependent) == dimension


@pytest.mark.parametrize("far", [1e3, 1e6, 1e7])
def test_dependent_rows_are_found_wherever_a_loop_is(made: SimpleNamespace, far: float) -> None:
    """At a million lengths coordinates have lost the digits that tell which rows depend."""
    here = turned_bar(made)
    move = np.array([far, -far / 2, 0.0])
    bodies = tuple(replace(body, r=tuple(move + body.r)) for body in here.bodies)
    constraints = tuple(
        replace(
            one,
            constants=tuple(
                (name, tuple(move + value) if body < 0 and name[0] == "s" else value)
                for name, value in one.constants
                for body in [one.i if "_i_" in name else one.j]
            ),
        )
        for one in here.constraints
    )
    there = replace(here, bodies=bodies, constraints=constraints)
    assert len(of(there).dropped) == len(of(here).dropped) == 3
