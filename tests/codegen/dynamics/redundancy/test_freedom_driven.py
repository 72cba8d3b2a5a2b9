"""Drivers take freedoms; what they take twice is refused by name, and gears close loops."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.assembly.residuals import Residuals
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.explanation.structure import structure_of
from kousoku.codegen.dynamics.redundancy.branch import Branch
from kousoku.codegen.dynamics.redundancy.constant_rows import require_constant_rows_hold
from kousoku.codegen.dynamics.redundancy.freedom import Mobility, mobility_of
from kousoku.codegen.dynamics.redundancy.loops import loops_of
from kousoku.model.errors import AssemblyError, SceneError
from kousoku.model.lowering.system import system_of
from kousoku.model.mechanics.constraints import COMBINATION
from kousoku.model.mechanics.multibody import Instance, RelativeCoordinate, System, Term
from kousoku.model.reading.read import scene_from_dict
from tests.analysed import all_rows

if TYPE_CHECKING:
    from types import SimpleNamespace

Tree = dict[str, Any]
SCENES = Path(__file__).parents[4] / "scenes"
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
SOLID = {"mass": 1, "inertia": {"xx": 1, "yy": 1, "zz": 1}}


def of(system: System, *, may_be_planar: bool = True) -> Mobility:
    system = assemble(system)
    return mobility_of(system, all_rows(system, may_be_planar=may_be_planar).outline)


def hinge(i: str, j: str, x: float, y: float) -> Tree:
    return {"type": "revolute", "bodies": [i, j], "at": [x, y, 0], "axis": [0, 0, 1]}


def built(bodies: Tree, joints: Tree, **tables: Any) -> System:
    tree = {"name": "s", "unit": "m", "bodies": bodies, "joints": joints, **tables}
    return system_of(scene_from_dict(tree))


def slider_crank(pin: tuple[float, float], **tables: Any) -> System:
    """Crank from the origin to a point at 1 m, a rod of 2 m and a slider on the x-axis."""
    x, y = pin
    end = x + (4 - y * y) ** 0.5
    bodies = {
        "crank": {"position": [0, 0, 0], **SOLID},
        "rod": {"position": [x, y, 0], **SOLID},
        "slider": {"position": [end, 0, 0], **SOLID},
    }
    joints = {
        "a": hinge("ground", "crank", 0, 0),
        "b": hinge("crank", "rod", x, y),
        "c": hinge("rod", "slider", end, 0),
        "d": {
            "type": "prismatic",
            "bodies": ["ground", "slider"],
            "points": [[0, 0, 0], [0, 0, 0]],
            "axis": [1, 0, 0],
        },
    }
    return built(bodies, joints, **tables)


def driven(**values: str) -> Tree:
    return {joint: {"joint": joint[0], "value": value} for joint, value in values.items()}


def bricard(drivers: Tree) -> System:
    tree = tomllib.loads((SCENES / "bricard.toml").read_text())
    return system_of(scene_from_dict({**tree, "drivers": drivers}))


def test_a_driver_takes_the_freedom_of_a_mechanism() -> None:
    free = of(slider_crank((0.6, 0.8)))
    moved = of(slider_crank((0.6, 0.8), drivers=driven(a_motor="t")))

    assert (free.degrees, free.drivers) == (1, 0)
    assert (moved.degrees, moved.rows, moved.drivers) == (0, 9, 1)


def test_two_drivers_of_one_freedom_are_refused_although_they_agree() -> None:
    system = slider_crank((0.6, 0.8), drivers=driven(a_motor="0", b_motor="0"))

    with pytest.raises(SceneError, match="leave out 1 of them") as caught:
        of(system)
    assert "drivers.a_motor, drivers.b_motor prescribe more than is free" in str(caught.value)
    assert "joints.a, joints.b, joints.c, joints.d" in str(caught.value)


def test_a_driver_of_a_structure_is_refused() -> None:
    """An arm on a hinge, whose end cannot leave a plane."""
    bodies = {"arm": {"position": [0, 0, 0], **SOLID}}
    stop = {"type": "inplane", "bodies": ["ground", "arm"], "at": [1, 0, 0], "axis": [0, 1, 0]}
    joints = {"a": hinge("ground", "arm", 0, 0), "stop": stop}
    system = built(bodies, joints, drivers=driven(a_motor="0"))

    with pytest.raises(SceneError, match=r"^drivers\.a_motor: prescribes 1 more than") as caught:
        of(system)
    assert "joints.a, joints.stop leave free" in str(caught.value)


def test_a_start_at_a_dead_centre_names_the_driver() -> None:
    """A piston cannot tell the crank where to go when both are on one line."""
    at_end = slider_crank((1.0, 0.0), drivers=driven(d_push="3 - 0.1*t^2"))
    inside = slider_crank((0.6, 0.8), drivers=driven(d_push="2.5 - 0.1*t^2"))

    with pytest.raises(SceneError, match=r"dead centre of drivers\.d_push: there joints\."):
        of(at_end)
    assert of(inside).degrees == 0


def parallelogram(angle: float, drivers: Tree) -> System:
    """Cranks of 1 m, 2 m apart, at an angle from the line of their pins."""
    x, y = math.cos(angle), math.sin(angle)
    turned = {"orientation": {"axis": [0, 0, 1], "angle": angle}}
    bodies = {
        "left": {"position": [0, 0, 0], **turned, **SOLID},
        "coupler": {"position": [x, y, 0], **SOLID},
        "right": {"position": [2, 0, 0], **turned, **SOLID},
    }
    joints = {
        "a": hinge("ground", "left", 0, 0),
        "b": hinge("left", "coupler", x, y),
        "c": hinge("coupler", "right", 2 + x, y),
        "d": hinge("right", "ground", 2, 0),
    }
    return built(bodies, joints, drivers=drivers)


def test_a_start_where_motions_branch_off_is_refused_by_the_driver() -> None:
    """A parallelogram that lies flat can become an antiparallelogram."""
    drivers = driven(a_motor="t")

    assert of(parallelogram(0.5, drivers)).degrees == 0
    with pytest.raises(SceneError, match=r"repeat each other .* and drivers\.a_motor cannot tell"):
        of(parallelogram(0.0, drivers))


def test_two_drivers_are_refused_also_where_the_start_hides_it() -> None:
    """Flat, the joints lose a rank, and there the second driver seems to take a freedom."""
    with pytest.raises(SceneError, match="leave out 1 of them"):
        of(parallelogram(0.0, driven(a_motor="t", b_motor="-t")))


def test_a_driven_linkage_of_bricard_leaves_out_a_row_of_its_joints() -> None:
    freedom = of(bricard(driven(a_motor="t")))

    assert (freedom.degrees, freedom.rows, freedom.positions) == (0, 31, 24)
    (row,) = freedom.dropped
    assert row.joint in "abcdef"
    assert freedom.dependent[0].joints == ("a", "b", "c", "d", "e", "f")


def test_two_drivers_of_a_linkage_of_bricard_are_refused() -> None:
    with pytest.raises(SceneError, match=r"drivers\.a_motor, drivers\.c_motor prescribe more"):
        of(bricard(driven(a_motor="0", c_motor="0")))


def test_a_point_that_is_driven_in_its_plane_repeats_the_plane() -> None:
    bodies = {"tip": {"position": [0, 0, 0], **SOLID}}
    plane = {"type": "planar", "bodies": ["ground", "tip"], "at": [0, 0, 0], "axis": [0, 0, 1]}
    hand = {"body": "tip", "point": [0.1, 0, 0], "path": ["0.1 + t", "t^2", "0"]}
    system = built(bodies, {"plane": plane}, drivers={"hand": hand})

    assert of(system).degrees == 1
    freedom = of(system, may_be_planar=False)
    assert (freedom.degrees, freedom.rows, freedom.drivers) == (1, 6, 2)
    assert len(freedom.dropped) == 1


def geared(made: SimpleNamespace, *, is_grounded: bool) -> System:
    """Two wheels on hinges, each of the ground or of a frame, and a gear between them."""
    bodies = [made.body("a", (0, 0, 0)), made.body("b", (1, 0, 0))]
    frames = [-1, -1]
    if not is_grounded:
        frames = [2, 3]
        bodies += [made.body("c", (0, 0, 0)), made.body("d", (1, 0, 0))]
    joints = [
        *made.revolute("one", frames[0], 0, (0, 0, 0), (0, 0, 0), Z),
        *made.revolute("two", frames[1], 1, (1, 0, 0) if is_grounded else (0, 0, 0), (0, 0, 0), Z),
    ]
    axes = (("a_i_b", X), ("b_i_b", Y), ("a_j_b", X))
    angles = tuple(
        RelativeCoordinate(f"{name}.angle", "angle", frame, body, axes)
        for name, frame, body in zip(("one", "two"), frames, (0, 1), strict=True)
    )
    others = tuple(body for body in (frames[1], 1) if body != frames[0])
    terms = (Term(0, 1.0), Term(1, 2.0))
    gear = Instance("gear", COMBINATION, frames[0], 0, terms=terms, others=others, unit="rad")
    return System("geared", 1.0, tuple(bodies), (*joints, gear), coordinates=angles)


def test_a_gear_closes_a_loop_through_its_two_joints(mechanisms: SimpleNamespace) -> None:
    system = geared(mechanisms, is_grounded=True)
    (part,) = loops_of(system)

    assert (part.bodies, part.is_grounded, part.instances) == ((0, 1), True, (0, 1, 2, 3, 4))
    freedom = of(system, may_be_planar=False)
    assert (freedom.degrees, freedom.rows, freedom.dropped) == (1, 11, ())


def test_a_gear_between_mechanisms_apart_makes_one_part_of_them(
    mechanisms: SimpleNamespace,
) -> None:
    system = geared(mechanisms, is_grounded=False)
    (part,) = loops_of(system)

    assert (part.bodies, part.is_grounded) == ((0, 1, 2, 3), False)
    assert of(system, may_be_planar=False).degrees == 24 - 11
    assert structure_of(system, compose(all_rows(system, may_be_planar=False))).parts == 1


def test_angles_count_turns_along_the_branch(mechanisms: SimpleNamespace) -> None:
    system = geared(mechanisms, is_grounded=True)
    rows = Residuals.of(system, system.constraints)
    branch = Branch(rows, range(11), range(12), 1.0)
    counted = [one.near for one in islice(branch.positions(system.bodies), 40)]

    assert max(abs(one + 2 * two) for one, two in counted) < 1e-10
    assert abs(counted[-1][0]) > 2 * math.pi


def test_a_gear_that_repeats_another_is_found_along_the_branch(
    mechanisms: SimpleNamespace,
) -> None:
    """Angles run through several turns there, and the second gear holds all the way."""
    system = geared(mechanisms, is_grounded=True)
    again = replace(system.constraints[-1], joint="again")
    freedom = of(replace(system, constraints=(*system.constraints, again)), may_be_planar=False)

    assert (freedom.degrees, freedom.positions) == (1, 24)
    assert [row.joint for row in freedom.dropped] == ["gear"]
    assert freedom.dependent[0].joints == ("gear", "again")


def test_a_gear_of_another_ratio_beside_one_stops_both(mechanisms: SimpleNamespace) -> None:
    system = geared(mechanisms, is_grounded=True)
    other = replace(system.constraints[-1], joint="other", terms=(Term(0, 1.0), Term(1, 3.0)))
    freedom = of(replace(system, constraints=(*system.constraints, other)), may_be_planar=False)

    assert (freedom.degrees, freedom.dropped) == (0, ())


def gears(ratio: float, joint: str, value: str) -> System:
    """Two shafts, of which the second turns so many times as fast, and a motor at one of them."""
    bodies = {"one": {"position": [0, 0, 0], **SOLID}, "two": {"position": [1, 0, 0], **SOLID}}
    joints: Tree = {"a": hinge("ground", "one", 0, 0), "b": hinge("ground", "two", 1, 0)}
    joints["gear"] = {"type": "gear", "joints": ["a", "b"], "ratio": ratio}
    return built(bodies, joints, drivers={"motor": {"joint": joint, "value": value}})


@pytest.mark.parametrize("joint", ["a", "b"])
@pytest.mark.parametrize("ratio", [1.0, -1e4, 1e5, -1e-4, 1e-5])
@pytest.mark.parametrize("value", ["t^2", "t", "1e-5 + t"])
def test_either_shaft_of_a_gear_may_be_driven_whatever_its_ratio(
    value: str, ratio: float, joint: str
) -> None:
    freedom = of(gears(ratio, joint, value))

    assert (freedom.degrees, freedom.drivers, freedom.dropped) == (0, 1, ())


def test_a_ratio_beside_which_a_shaft_counts_as_at_rest_is_told() -> None:
    for value, error in (("t^2", SceneError), ("t", AssemblyError)):
        with pytest.raises(error, match=r"joints\.gear has a ratio of 1e\+10: what moves"):
            of(gears(1e10, "a", value))
        assert of(gears(1e10, "b", value)).degrees == 0


def test_a_row_that_nothing_changes_is_refused_with_its_amount(
    mechanisms: SimpleNamespace,
) -> None:
    """Axes of the ground and of a point: no body can turn them."""
    system = mechanisms.point_on_rod()
    axes = (("a_i_b", X), ("a_j_b", (0.6, 0.8, 0.0)))
    square = Instance("square", "n1", -1, 0, axes)
    system = replace(system, constraints=(*system.constraints, square))

    with pytest.raises(SceneError, match=r"^joints\.square: is violated by 0\.6 rad, and no body"):
        require_constant_rows_hold(system, all_rows(system).outline)
