"""Assembly with drivers, combinations of coordinates and counted turns."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import pytest

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.assembly.driver_laws import law_at_start
from kousoku.codegen.dynamics.assembly.residuals import Residuals
from kousoku.model.errors import AssemblyError
from kousoku.model.lowering.system import system_of
from kousoku.model.mechanics.constraints import COMBINATION
from kousoku.model.mechanics.multibody import Instance
from kousoku.model.reading.read import scene_from_dict

if TYPE_CHECKING:
    from kousoku.model.mechanics.multibody import System

Tree = dict[str, Any]
ULP = 2.0**-52
Z = [0, 0, 1]


def built(bodies: Tree, joints: Tree, **tables: Any) -> System:
    """System of a scene in metres."""
    scene = {"name": "s", "unit": "m", "bodies": bodies, "joints": joints, **tables}
    return system_of(scene_from_dict(scene))


def hinge(i: str, j: str, at: Any) -> Tree:
    return {"type": "revolute", "bodies": [i, j], "at": at, "axis": Z}


def arm(value: Any, **tables: Any) -> System:
    """Arm of a metre along x on a hinge about z, driven."""
    bodies = {"arm": {"position": [0, 0, 0], "mass": 1, "center": [1, 0, 0]}}
    drivers = {"motor": {"joint": "hinge", "value": value}}
    return built(bodies, {"hinge": hinge("ground", "arm", [0, 0, 0])}, drivers=drivers, **tables)


def angle(system: System, body: int) -> float:
    """Angle of a body about z, from −π to π."""
    p = system.bodies[body].p
    turned = 2 * math.atan2(p[3], p[0])
    return math.remainder(turned, math.tau)


#: Crank of 1 m upright, coupler from its end to the rocker, 3 m away.
CORNERS = {"a": (0.0, 0.0), "b": (0.0, 1.0), "c": (3.0, 2.0), "d": (3.0, 0.0)}


def four_bar(**tables: Any) -> System:
    """Crank, coupler and rocker as they stand in :data:`CORNERS`, in that order."""
    bodies, joints = {}, {}
    ends = ["ground", "crank", "coupler", "rocker", "ground"]
    for name, (start, end) in zip(ends[1:4], pairwise(CORNERS), strict=True):
        (x, y), (u, v) = CORNERS[start], CORNERS[end]
        middle = [(u - x) / 2, (v - y) / 2, 0]
        bodies[name] = {
            "position": [x, y, 0],
            **{"mass": 1, "center": middle, "inertia": {"xx": 1, "yy": 1, "zz": 1}},
        }
    for k, (name, (x, y)) in enumerate(CORNERS.items()):
        joints[name] = hinge(ends[k], ends[k + 1], [x, y, 0])
    return built(bodies, joints, **tables)


def violated(system: System) -> tuple[float, float]:
    """Largest |C| and |C_q v − ν| at the start."""
    c, rates = Residuals.of(system, system.constraints).at_start(system.bodies)
    return max(map(abs, c)), max(map(abs, rates))


def test_a_driver_sets_position_and_velocity_at_the_start() -> None:
    system = assemble(arm("0.3 + 2*t + 5*t^2"))

    assert angle(system, 0) == pytest.approx(0.3, abs=ULP)
    assert system.bodies[0].omega_b == (0, 0, 2)
    assert system.bodies[0].v == pytest.approx((-2 * math.sin(0.3), 2 * math.cos(0.3), 0))
    assert violated(system) < (2 * ULP, 2 * ULP)


@pytest.mark.parametrize("turns", [-3, 1, 40])
def test_a_driver_starts_on_any_turn(turns: int) -> None:
    system = assemble(arm(f"0.3 + {turns}*2*pi + t"))

    assert angle(system, 0) == pytest.approx(0.3, abs=abs(turns) * 8 * ULP)
    (coordinate,) = system.coordinates
    assert coordinate.near == pytest.approx(0.3 + turns * math.tau, rel=ULP)


def test_what_a_driver_fits_already_stays_as_it_is() -> None:
    system = assemble(arm("0.3 + t"))

    assert assemble(system) is system


def test_parameters_of_a_driver_have_their_values() -> None:
    system = assemble(arm("start + rate*t", parameters={"start": 0.25, "rate": -4.0}))

    assert angle(system, 0) == pytest.approx(0.25, abs=ULP)
    assert system.bodies[0].omega_b == (0, 0, -4)


@pytest.mark.parametrize("away", [0.2, 1.5, 2.9, -2.9])
def test_a_driver_far_from_the_scene_keeps_the_branch(away: float) -> None:
    """Turned by nearly half a turn the rocker stays on its side of the line through its pins."""
    system = assemble(four_bar(drivers={"motor": {"joint": "a", "value": f"{away} + 3*t"}}))

    assert angle(system, 0) == pytest.approx(away, abs=4 * ULP)
    assert violated(system) < (16 * ULP, 32 * ULP)
    end = complex(0, 1) * complex(math.cos(away), math.sin(away))
    pin = complex(system.bodies[2].r[0], system.bodies[2].r[1]) * 2 - 3
    across = (pin - end) / (3 - end)
    assert across.imag > 0


def test_a_driver_turns_on_what_its_angle_is_geared_to() -> None:
    """The angle counts as it is written, and the driver starts two turns further on."""
    bodies = {name: {"position": [x, 0, 0], "mass": 1} for name, x in (("one", 0), ("two", 1))}
    joints = {"a": hinge("ground", "one", [0, 0, 0]), "b": hinge("ground", "two", [1, 0, 0])}
    gear = {"type": "linear", "coordinates": ["alpha", "beta"], "factors": [1, 2.5]}
    written = built(
        bodies,
        {**joints, "gear": gear},
        coordinates={"alpha": {"joint": "a"}, "beta": {"joint": "b"}},
        drivers={"motor": {"coordinate": "alpha", "value": "4*pi + 0.5"}},
    )
    coordinates = tuple(replace(one, near=0.0) for one in written.coordinates)
    constraints = tuple(replace(one, offset=0.0) for one in written.constraints)
    system = assemble(replace(written, coordinates=coordinates, constraints=constraints))

    turned = 4 * math.pi + 0.5
    near = {one.name: one.near for one in system.coordinates}
    assert near == pytest.approx({"alpha": turned, "beta": -turned / 2.5}, abs=8 * ULP)
    assert angle(system, 1) == pytest.approx(math.remainder(-turned / 2.5, math.tau), abs=8 * ULP)
    assert violated(system)[0] < 32 * ULP


def test_a_driver_beyond_what_a_rocker_can_reach_is_named_with_radians() -> None:
    system = four_bar(drivers={"motor": {"joint": "d", "value": "2"}})

    with pytest.raises(AssemblyError, match=r"drivers\.motor by .* rad.*leave out drivers"):
        assemble(system)


def test_drivers_that_contradict_each_other_are_both_named() -> None:
    drivers = {"one": {"joint": "a", "value": "0.1*t"}, "two": {"joint": "d", "value": "0.2"}}

    with pytest.raises(AssemblyError, match="leave out drivers of what others move") as caught:
        assemble(four_bar(drivers=drivers))
    assert "drivers.one by 0.0" in str(caught.value)
    assert "drivers.two by 0.0" in str(caught.value)


def test_drivers_whose_speeds_contradict_each_other_are_both_named() -> None:
    """The rocker turns by −½ of the crank here, and is asked to stand still."""
    drivers = {"one": {"joint": "a", "value": "t"}, "two": {"joint": "d", "value": "0"}}

    with pytest.raises(AssemblyError) as caught:
        assemble(four_bar(drivers=drivers))
    assert "drivers.one by" in str(caught.value)
    assert "drivers.two by" in str(caught.value)
    assert "rad/s" in str(caught.value)


@pytest.mark.parametrize("value", ["sqrt(t)", "log(t)", "1/t", "t^1.5", "sqrt(t - 1)"])
def test_a_formula_that_is_no_number_at_the_start_is_named(value: str) -> None:
    driver = Instance("motor", COMBINATION, -1, 0, law=value)

    with pytest.raises(
        AssemblyError, match=r"drivers\.motor: the .* is no number at t = 0"
    ) as caught:
        law_at_start(driver, ())
    assert caught.value.keys == ("drivers.motor",)


def test_a_law_and_its_derivatives_have_fifty_digits() -> None:
    law = law_at_start(Instance("m", COMBINATION, -1, 0, law="exp(w*t)", law_unit=0.5), [("w", 3)])

    assert (law.value, law.rate, law.second) == (0.5, 1.5, 4.5)
    assert law_at_start(Instance("m", COMBINATION, -1, 0, law="sin(pi + t)"), ()).value == 0


def test_a_held_coordinate_is_kept_and_the_others_move() -> None:
    names = {"theta": {"joint": "a", "hold": True}}
    system = four_bar(coordinates=names)
    moved = replace(system.bodies[2], r=(3.1, 0.9, 0.0))
    system = assemble(replace(system, bodies=(*system.bodies[:2], moved)))

    assert angle(system, 0) == pytest.approx(0, abs=ULP)
    assert violated(system)[0] < 16 * ULP


def test_a_distance_of_points_that_coincide_gives_no_direction_to_move_them() -> None:
    bodies = {"p": {"position": [0, 0, 0], "point": True, "mass": 1}}
    names = {"l": {"bodies": ["ground", "p"], "points": [[0, 0, 0], [0, 0, 0]]}}
    drivers = {"push": {"coordinate": "l", "value": "1 + t"}}

    with pytest.raises(AssemblyError, match=r"stay open: drivers\.push by 1 m"):
        assemble(built(bodies, {}, coordinates=names, drivers=drivers))


def test_a_held_coordinate_is_made_what_it_is_near() -> None:
    system = assemble(four_bar(coordinates={"theta": {"joint": "a", "near": -0.5, "hold": True}}))

    assert angle(system, 0) == pytest.approx(-0.5, abs=2 * ULP)
    assert system.coordinates[0].near == pytest.approx(-0.5, abs=2 * ULP)
    assert violated(system)[0] < 16 * ULP


def test_a_held_coordinate_that_a_driver_moves_is_named_with_it() -> None:
    names = {"theta": {"joint": "a", "hold": True}}
    system = four_bar(coordinates=names, drivers={"motor": {"joint": "d", "value": "0.2 + t"}})

    with pytest.raises(AssemblyError, match="does not fit together") as caught:
        assemble(system)
    assert "coordinates.theta.hold by" in str(caught.value)
    assert "drivers.motor by" in str(caught.value)


@pytest.mark.parametrize(("law", "torn"), [("0.1*t", "0.1 m/s"), ("0.1 + t", "0.1 m")])
def test_a_driver_of_the_distance_of_points_that_coincide_is_refused(law: str, torn: str) -> None:
    solid = {"position": [0, 0, 0], "mass": 1, "inertia": {"xx": 1, "yy": 1, "zz": 1}}
    gap = {"bodies": ["a", "b"], "points": [[0, 0, 0], [0, 0, 0]]}
    tree = {"name": "gap", "unit": "m", "bodies": {"a": solid, "b": solid}}
    tree |= {"coordinates": {"gap": gap}, "drivers": {"d": {"coordinate": "gap", "value": law}}}
    with pytest.raises(AssemblyError, match=rf"drivers\.d by {torn}; the joints, or other drivers"):
        assemble(system_of(scene_from_dict(tree)))
