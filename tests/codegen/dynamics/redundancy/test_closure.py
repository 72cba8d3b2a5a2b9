"""Rows that others imply but for the closure tolerance are redundant, and what they miss is told.

Below the tolerance they are left out, above ten times that they count as independent, and what lies
between is refused. What is exact in tests is a planar four-bar of hinges, a door on two hinges in
line, and the linkage of Bricard; each is spoiled by so much.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.generate import compose_scene
from kousoku.codegen.dynamics.redundancy.freedom import mobility_of
from kousoku.codegen.dynamics.redundancy.nearly import nearly_implied, with_consistent_start
from kousoku.model.errors import SceneError
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.read import scene_from_toml
from tests.analysed import all_rows

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.generate import Composed
    from kousoku.codegen.dynamics.redundancy.freedom import Mobility

TURN = np.linalg.qr(np.array([[1.0, 0.4, 0.2], [0.3, -1.0, 0.7], [0.1, 0.5, 1.0]]))[0]
#: Corners and axes of the linkage of Bricard, along edges of a cube.
CORNERS = ((1, 0, 0), (1, 1, 0), (1, 1, 1), (0, 1, 1), (0, 0, 1), (0, 0, 0))
AXES = ((0, 0, 1), (1, 0, 0), (0, 1, 0)) * 2


def scene(name: str, more: str, bodies: Sequence[str], joints: Sequence[str]) -> str:
    head = (f'name = "{name}"', 'unit = "m"', "gravity = [0, -9.81, 0]", more)
    return "\n".join((*head, "[bodies]", *bodies, "[joints]", *joints))


def body(name: str, at: Sequence[float]) -> str:
    moments = "{ xx = 1, yy = 1, zz = 1 }"
    return f"{name} = {{ position = {[*at]}, mass = 1, inertia = {moments} }}"


def hinge(name: str, i: str, j: str, at: Sequence[float], axis: Sequence[float] = (0, 0, 1)) -> str:
    bodies = f'type = "hinge", bodies = ["{i}", "{j}"]'
    return f"{name} = {{ {bodies}, at = {[*at]}, axis = {[*axis]} }}"


def four_bar(lean: float, more: str = "") -> str:
    corners = [(0, 0, 0), (0.3, 0.9, 0), (1.7, 1.2, 0), (2, 0, 0)]
    bodies = [body(f"link_{k}", at) for k, at in enumerate(corners[:3])]
    joints = [
        hinge("A", "ground", "link_0", corners[0]),
        hinge("B", "link_0", "link_1", corners[1]),
        hinge("C", "link_1", "link_2", corners[2]),
        hinge("D", "ground", "link_2", corners[3], (lean, 0, 1)),
    ]
    return scene("four_bar", more, bodies, joints)


def door(by: float) -> str:
    joints = [
        hinge("h", "ground", "d", (0, 0, 0)),
        hinge("g", "ground", "d", (by, 0, 1), (0, by, 1)),
    ]
    return scene("door", "", [body("d", (0.5, 0, 0.5))], joints)


def bricard(digits: int) -> str:
    """Linkage of Bricard, turned, as one types it with so many digits."""

    def typed(x: Any) -> str:
        return f"[{', '.join(f'{component:.{digits}f}' for component in TURN @ np.array(x))}]"

    names = ["ground", *(f"rod_{k}" for k in range(5)), "ground"]
    bodies = [
        f"{name} = {{ position = {typed(a)}, cylinders = [{{ mass = 1, radius = 0.05,"
        f" ends = [[0, 0, 0], {typed(np.subtract(b, a))}] }}] }}"
        for name, (a, b) in zip(names[1:], pairwise(CORNERS), strict=False)
    ]
    joints = [
        f'{name} = {{ type = "revolute", bodies = ["{i}", "{j}"], at = {typed(at)},'
        f" axis = {typed(axis)} }}"
        for name, (i, j), at, axis in zip("abcdef", pairwise(names), CORNERS, AXES, strict=True)
    ]
    return scene("bricard", "", bodies, joints)


@cache
def made(text: str, *wanted: str) -> Composed:
    return compose_scene(scene_from_toml(text), wanted)


def freedom(text: str) -> Mobility:
    system = with_consistent_start(system_of(scene_from_toml(text), ()))
    return mobility_of(system, all_rows(system).outline)


@pytest.mark.parametrize("lean", [1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5])
def test_axis_that_leans_by_less_than_the_tolerance_is_parallel(lean: float) -> None:
    found = freedom(four_bar(lean))

    assert found.degrees == 1
    assert {one.row.joint for one in found.closed} == {"D"}
    assert lean < max(one.missed for one in found.closed) < 3 * lean
    (note,) = made(four_bar(lean)).about.notes
    assert "redundant within closure_tolerance, 0.0001" in note
    assert "joints.D but for" in note


def test_the_masses_of_what_is_told_may_be_parameters() -> None:
    text = four_bar(1e-6).replace("mass = 1", 'mass = "m"') + "\n[parameters]\nm = 1"
    notes = [
        note.replace(", with the parameters of the scene", "") for note in made(text).about.notes
    ]
    assert notes == [*made(four_bar(1e-6)).about.notes]


@pytest.mark.parametrize("lean", [5e-4, 1e-3, 2e-3])
def test_axis_that_leans_by_neither_much_nor_little_is_refused(lean: float) -> None:
    with pytest.raises(SceneError, match=rf"the axis of joints\.D leans by {lean:.3g} rad"):
        made(four_bar(lean))


@pytest.mark.parametrize("lean", [1e-2, 3e-2, 1e-1])
def test_axis_that_leans_holds_all(lean: float) -> None:
    found = made(four_bar(lean))

    assert found.degrees == 0
    assert found.about.notes == ("nothing can move: joints hold all bodies where they are",)


def test_axes_that_are_parallel_need_no_note() -> None:
    assert made(four_bar(0.0)).about.notes == ()
    assert nearly_implied(system_of(scene_from_toml(four_bar(0.0)), ())) == ()


@pytest.mark.parametrize(("tolerance", "degrees"), [(1e-2, 1), (1e-5, 0)])
def test_scene_may_say_what_is_redundant(tolerance: float, degrees: int) -> None:
    text = four_bar(1e-3, f"closure_tolerance = {tolerance}")

    assert made(text).degrees == degrees


@pytest.mark.parametrize("by", [1e-16, 1e-12, 1e-10, 1e-8, 1e-7, 1e-6, 1e-5])
def test_door_on_hinges_that_are_nearly_in_line_turns(by: float) -> None:
    found = made(door(by), "reactions")

    assert found.degrees == 1
    assert len(found.program.left_out) == 5


def on_pins(places: tuple[float, float], own: tuple[float, float]) -> str:
    """Door on two hinges in line, each at a place of the ground and at one of its own."""
    joints = [
        f'{name} = {{ type = "hinge", bodies = ["ground", "d"], axis = [0, 0, 1],'
        f" points = [[0, 0, {z!r}], [0, 0, {z_d!r}]] }}"
        for name, z, z_d in zip("hg", places, own, strict=True)
    ]
    return scene("door", "", [body("d", (0, 0.01, 0.01))], joints)


@pytest.mark.parametrize("arm", [0.25, 0.5, 2.0])
@pytest.mark.parametrize("by", [1e-14, 1e-13, 1e-12, 3e-12, 5e-12, 1e-11, 3e-11, 1e-10])
def test_door_whose_hinges_are_too_far_apart_by_any_little_turns(by: float, arm: float) -> None:
    """Assembly refuses what is open by 1e-12 lengths; up to 1e-11 that was rounding of the rows."""
    assert freedom(on_pins((-arm, arm + by), (-arm, arm))).degrees == 1


def test_door_whose_hinges_are_too_far_apart_by_digits_of_their_place_turns() -> None:
    """In 1e6 m doubles do not tell 1e-10 m: what rows miss is looked at near the origin."""
    far, axis = 40000000.0, [0.008296231623858286, -0.7999724685425992, 0.5999793514069494]
    own = [0.1659246324771657, -15.999449370851984, 11.999587028138986]
    joints = [
        f'{name} = {{ type = "hinge", bodies = ["ground", "d"], axes = [[1, 0, 0], {axis}],'
        f" points = [[{far + x!r}, -10, -40], {[side * a for a in own]}] }}"
        for name, x, side in (("h", 10.0, -1.0), ("g", 50.0, 1.0))
    ]
    turned = "orientation = { axis = [0, 3, 4], angle = 1.5625 }"
    mass = "mass = 1, inertia = { xx = 1, yy = 1, zz = 1 }"
    door = f"d = {{ position = [{far + 30.4!r}, -10, -40], {turned}, {mass} }}"
    text = scene("door", "", [door], joints).replace('"m"', '"in"')
    assert freedom(text).degrees == 1


@pytest.mark.parametrize("by", [2e-4, 3e-4, 7e-4, 8e-4, 1e-3, 1.1e-3])
def test_door_on_hinges_that_may_be_in_line_is_refused(by: float) -> None:
    with pytest.raises(SceneError, match=r"joints\.g: .* beyond joints\.h .* rad apart"):
        made(door(by))


@pytest.mark.parametrize("by", [1.2e-3, 1e-2])
def test_door_on_hinges_out_of_line_is_shut(by: float) -> None:
    assert made(door(by)).degrees == 0


@pytest.mark.parametrize(("digits", "most"), [(4, 1e-3), (6, 1e-5), (9, 1e-8)])
def test_linkage_of_bricard_may_be_typed(digits: int, most: float) -> None:
    found = freedom(bricard(digits))

    assert found.degrees == 1
    (one,) = found.closed
    assert most / 1e3 < one.missed < most
    assert found.worst > 0.05


def test_linkage_of_bricard_with_three_digits_is_refused() -> None:
    with pytest.raises(SceneError, match=r"independent above 0\.001 only"):
        made(bricard(3))


@pytest.mark.parametrize("by", [1e-8, 1e-5])
def test_door_on_hinges_that_are_nearly_in_line_keeps_its_speed(by: float) -> None:
    """All rows together hold it: where they did, assembly would stop it or refuse it."""
    text = door(by).replace(
        "mass = 1", "mass = 1, velocity = [0, 1, 0], angular_velocity = [0, 0, 2]"
    )
    placed = with_consistent_start(system_of(scene_from_toml(text), ()))

    assert placed.bodies[0].omega_b == pytest.approx((0, 0, 2), abs=10 * by)


def test_bodies_stay_where_they_are_typed() -> None:
    """Where all rows hold the linkage is stiff: assembly must not look for that place."""
    given = system_of(scene_from_toml(bricard(4)), ())
    placed = with_consistent_start(given)

    moved = [np.subtract(a.r, b.r) for a, b in zip(given.bodies, placed.bodies, strict=True)]
    assert np.abs(moved).max() < 1e-3


def test_small_cranks_of_a_large_machine_are_no_small_pivots() -> None:
    """Pivots compare turns with the arms of a body: cranks of 1 mm lead a bar of 10 m."""
    bodies = [body("a", (0, 0, 0)), body("b", (10, 0, 0)), body("bar", (0, 0.001, 0))]
    joints = [
        hinge("A", "ground", "a", (0, 0, 0)),
        hinge("B", "ground", "b", (10, 0, 0)),
        hinge("C", "a", "bar", (0, 0.001, 0)),
        hinge("D", "b", "bar", (10, 0.001, 0)),
    ]
    found = made(scene("sieve", "", bodies, joints))

    assert found.degrees == 1
    assert found.about.notes == ()
    assert found.program.left_out == ()


@pytest.mark.parametrize("lean", [0.0, 1e-8, 1e-5])
def test_forces_in_the_plane_of_a_four_bar_of_hinges_are_unique(lean: float) -> None:
    found = made(four_bar(lean), "reactions")

    assert found.program.not_unique == ()
    assert found.program.unique_in_plane == ("A", "B", "C", "D")
    assert any("only what leads out of the plane" in note for note in found.about.notes)
