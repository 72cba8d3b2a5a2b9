"""Assembly finds the nearest positions and velocities that fit, or says which joints stay open."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.assembly.changes import changes_of_assembly
from kousoku.codegen.dynamics.assembly.near_origin import brought_near
from kousoku.codegen.dynamics.assembly.pose import normalised
from kousoku.codegen.dynamics.assembly.residuals import Residuals
from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.dynamics.simplification.planarity import is_planar
from kousoku.model.errors import AssemblyError
from kousoku.model.lowering.system import system_of
from kousoku.model.numbers import precise
from kousoku.model.reading.families import chain, n_four_bar
from kousoku.model.reading.read import read_scene, scene_from_dict
from kousoku.runtime.integrate.assembled_start import notes_of

if TYPE_CHECKING:
    from kousoku.model.mechanics.multibody import System

ROOT = Path(__file__).parents[4]
Tree = dict[str, Any]
ULP = 2.0**-52

TILTED: Tree = {
    "position": [0.05, -0.1, 0.02],
    "orientation": {"rotation_vector": [0.3, -0.2, 0.7]},
    "mass": 2,
    "center": [0.4, 0.1, 0.2],
    "inertia": {"xx": 0.2, "yy": 0.3, "zz": 0.3},
}


def built(bodies: Tree, joints: Tree) -> System:
    """System of bodies and joints."""
    return system_of(
        scene_from_dict({"name": "s", "unit": "m", "bodies": bodies, "joints": joints})
    )


def disturbed(system: System, size: float, *, in_plane: bool = False) -> System:
    """System whose bodies stand, turn and move otherwise, each in its own way."""
    bodies = []
    for k, body in enumerate(system.bodies):
        x, y, z = (size * math.sin(3 * k + i) for i in range(3))
        a, b, c = (size * math.cos(5 * k + i) for i in range(3))
        if in_plane:
            z = a = b = 0.0
        r = (body.r[0] + x, body.r[1] + y, body.r[2] + z)
        w, e1, e2, e3 = body.p
        p = np.array([w - a * e1 - b * e2 - c * e3, e1 + a * w, e2 + b * w, e3 + c * w])
        w, e1, e2, e3 = (float(component) for component in p / np.linalg.norm(p))
        v = (math.sin(k), math.cos(k), 0.0 if in_plane else 0.5)
        omega = (a, b, 1.0)
        bodies.append(replace(body, r=r, p=(w, e1, e2, e3), v=v, omega_b=omega))
    return replace(system, bodies=tuple(bodies))


def residuals(system: System) -> tuple[float, float]:
    """Largest |C| and |C_q v| at the start."""
    c, rates = Residuals(system.constraints, system.bodies).at_start(system.bodies)
    return float(np.abs(c).max(initial=0)), float(np.abs(rates).max(initial=0))


#: Scenes that give the velocity of their crank only, and those with positions in a few digits.
NEAR, IN_DIGITS = {"lever_crank_bodies", "piston_crank_bodies"}, {"loop_free"}
SCENES = [path.stem for path in sorted((ROOT / "scenes").glob("*.toml"))]


@pytest.mark.parametrize("name", SCENES)
def test_what_fits_stays_as_it_is(name: str) -> None:
    scene = read_scene(ROOT / "scenes" / f"{name}.toml")
    if scene.is_spatial:
        system = system_of(msgspec.structs.replace(scene, inputs={}))
        found = assemble(system)
        if any(one.is_driver for one in system.constraints):  # velocities are those of the drivers
            places = [[(body.r, body.p) for body in one.bodies] for one in (system, found)]
            assert places[0] == places[1]
        else:
            assert (found is system) is (name not in NEAR | IN_DIGITS)


def test_it_is_no_matter_how_far_away_a_system_is_assembled() -> None:
    def assembled(far: float) -> np.ndarray[Any, Any]:
        bodies = {
            name: {**TILTED, "position": [far + x, 0.01, 0]} for name, x in (("a", 0.02), ("b", 1))
        }
        pin = {"type": "revolute", "axes": [[0, 0, 1]] * 2}
        joints = {
            "first": {**pin, "bodies": ["ground", "a"], "points": [[far, 0, 0], [0, 0, 0]]},
            "second": {**pin, "bodies": ["a", "b"], "points": [[1, 0.5, 0], [0, 0.25, 0]]},
        }
        return np.array([body.r for body in assemble(built(bodies, joints)).bodies])

    far = 2.0**20
    off = assembled(far) - assembled(0.0) - np.array([far, 0, 0])
    # what the positions of the scene are rounded by, and what is found
    assert np.abs(off).max() <= 2 * far * ULP


def test_what_is_spread_from_the_origin_to_far_away_keeps_its_digits() -> None:
    system = on_a_rod()
    bodies = tuple(replace(system.bodies[0], r=(x, 0.1, -0.3)) for x in (0.1, 2.0**30, 2.0**30))
    there, offset = brought_near(replace(system, bodies=bodies), 1.0)
    assert offset == (0.0, 0.0, 0.0)
    assert there.bodies == bodies


ON_A_ROD = {"rod": {"type": "rod", "bodies": ["ground", "b"], "points": [[0] * 3] * 2, "length": 1}}


def on_a_rod(**keys: Any) -> System:
    """Point on a rod of 1 m."""
    return built({"b": {"position": [0.6, 0.8, 0.5], "point": True, "mass": 2, **keys}}, ON_A_ROD)


def test_a_point_on_a_rod_goes_straight_to_the_sphere() -> None:
    start = np.array([0.6, 0.8, 0.5])
    (body,) = assemble(on_a_rod()).bodies
    assert body.r == pytest.approx(start / math.sqrt(1.25), abs=ULP / 2)


def test_a_solver_is_generated_for_the_assembled_positions() -> None:
    near, on = (
        scene_from_dict(
            {
                "name": "s",
                "unit": "m",
                "bodies": {"b": {"position": [0, 0, -z], "point": True, "mass": 2}},
                "joints": ON_A_ROD,
            }
        )
        for z in (1.5, 1)
    )
    moved, kept = generate_dynamics(near), generate_dynamics(on)
    assert {name for name in kept if moved[name] != kept[name]} == {"motion.json", "manifest.json"}
    told = [json.loads(tree["motion.json"]) for tree in (moved, kept)]
    notes = [data.pop("notes") for data in told]
    assert notes == [["assembly changed bodies.b: moved by 0.5 m"], []]
    assert [data.pop("moved") for data in told] == [[["b", 0.5, 0.0, 0.0, 0.0]], []]
    assert told[0] == told[1]


def test_a_velocity_loses_what_would_stretch_the_rod() -> None:
    system = assemble(on_a_rod(position=[0, 0, 2], velocity=[3, -4, 5]))
    assert system.bodies[0].r == (0, 0, 1)
    assert system.bodies[0].v == (3, -4, 0)


def test_the_nearest_positions_are_weighted_by_mass_and_inertia() -> None:
    """Of a body on a hinge, m (r − r₀)·r′(θ) + J (θ − θ₀) = 0 with r = l (cos θ, sin θ)."""
    bar = {"position": [0.9, 0.5, 0], "mass": 2, "inertia": {"xx": 1, "yy": 1, "zz": 0.75}}
    hinge = {
        "type": "revolute",
        "bodies": ["ground", "bar"],
        "points": [[0, 0, 0], [-1, 0, 0]],
        "axes": [[0, 0, 1], [0, 0, 1]],
    }
    (body,) = assemble(built({"bar": bar}, {"hinge": hinge})).bodies
    theta = 2 * math.atan2(body.p[3], body.p[0])
    assert body.r == pytest.approx((math.cos(theta), math.sin(theta), 0), abs=2 * ULP)
    along = -math.sin(theta) * (body.r[0] - 0.9) + math.cos(theta) * (body.r[1] - 0.5)
    assert 2 * along + 0.75 * theta == pytest.approx(0, abs=4 * ULP)
    assert 0.1 < theta < 0.5


def test_no_turn_that_a_joint_allows_brings_a_body_nearer_to_where_it_was_written() -> None:
    inertia = {"inertia": {"xx": 0.05, "yy": 0.4, "zz": 0.43}}
    joint = {"type": "parallel", "bodies": ["ground", "b"], "axes": [[0, 0, 1], [0.8, 0.6, 1]]}
    written = built({"b": TILTED | inertia}, {"j": joint})
    (start,), (b,) = written.bodies, assemble(written).bodies

    def distance(angle: float) -> float:
        p = precise.compose(normalised((1, 0, 0, math.tan(angle / 2))), normalised(b.p))
        w, *e = map(float, precise.compose(precise.conjugate(normalised(start.p)), p))
        turn = 2 * math.atan2(math.hypot(*e), w) / math.hypot(*e) * np.array(e)
        return float(turn @ (b.inertia * turn))

    assert distance(0) > 0.01
    assert distance(1e-4) - distance(-1e-4) == pytest.approx(0, abs=1e-12)
    assert distance(0.1) > distance(0) < distance(-0.1)


def test_parallel_cranks_far_away_are_the_nearest_ones_too() -> None:
    """Their rows depend on each other but for the digits of 1e6 m, and steps end in rounding."""

    def placed(far: float) -> np.ndarray[Any, Any]:
        moments = {"xx": 2.0, "yy": 2.5, "zz": 1.5, "xy": 0.2, "yz": -0.4, "zx": 0.1}
        tilted = {"quaternion": [5, -3, 1, 2], "order": "wxyz"}
        bodies: Tree = {
            "plate": {"position": [far - 0.22, 1.75, 0], "orientation": tilted},
            **{crank: {"position": [far - 0.47 + k, 0.75, 0]} for k, crank in enumerate("abc")},
        }
        for body in bodies.values():
            body |= {"mass": 1, "inertia": moments}
        shown = [-0.5641025641025641, -0.6666666666666666, 0.4871794871794872]
        across = [0.7435897435897436, -0.6666666666666666, -0.05128205128205128]
        joints: Tree = {}
        for k, crank in enumerate("abc"):
            foot = {"type": "revolute", "bodies": ["ground", crank], "axis": [0, 0, 1]}
            joints[f"foot_{k}"] = foot | {"points": [[far - 0.5 + k, 0.75, 0], [0, 0, 0]]}
            head = {"type": "revolute", "bodies": [crank, "plate"], "axes": [[0, 0, 1], shown]}
            joints[f"head_{k}"] = head | {"points": [[0.25, 1, 0], [k * x for x in across]]}
        places = [body.r for body in assemble(built(bodies, joints)).bodies]
        return np.array(places) - [far, 0, 0]

    assert np.abs(placed(1e6) - placed(0.0)).max() < 1e-9


@pytest.mark.parametrize("size", [1e-9, 1e-3, 0.1])
def test_closed_loops_close_though_their_rows_repeat_each_other(size: float) -> None:
    system = assemble(disturbed(system_of(n_four_bar(2)), size))
    c, rates = residuals(system)
    assert c < 4 * ULP
    assert rates < 16 * ULP


def test_a_plane_linkage_stays_in_its_plane_to_the_last_digit() -> None:
    system = assemble(disturbed(system_of(n_four_bar(2)), 0.05, in_plane=True))
    for body in system.bodies:
        assert (body.r[2], body.p[1], body.p[2]) == (0, 0, 0)
        assert (body.v[2], body.omega_b[0], body.omega_b[1]) == (0, 0, 0)
    assert residuals(system)[0] < 4 * ULP


@pytest.mark.parametrize("name", sorted(NEAR))
def test_a_mechanism_in_a_plane_gets_velocities_in_that_plane(name: str) -> None:
    """The piston stands at its dead centre: what iterations leave is compared with the crank."""
    system = assemble(system_of(read_scene(ROOT / "scenes" / f"{name}.toml")))
    assert is_planar(system)
    assert residuals(system) < (4 * ULP, 4 * ULP)
    assert name != "piston_crank_bodies" or system.bodies[-1].v == (0, 0, 0)


def test_a_chain_is_put_together() -> None:
    c, rates = residuals(assemble(disturbed(system_of(chain(4)), 0.2)))
    assert c < 8 * ULP
    assert rates < 8 * ULP


def test_the_order_of_the_joints_changes_no_digit() -> None:
    """What was solved in doubles on the way leaves no trace: the result is rounded once."""
    system = disturbed(system_of(chain(3)), 0.05)
    other = replace(system, constraints=system.constraints[::-1])
    assert assemble(system).bodies == assemble(other).bodies


def four_bar(crank: Tree, **coupler: Any) -> System:
    """Four-bar with cranks of 1 m and 2 m, 3 m apart, and a coupler of 2.5 m."""
    rod = {"mass": 1}
    bodies = {
        "crank": {"position": [0, 0, 0], "mass": 1, **crank},
        "pin": {"position": [2.5, 1.5, 0], "point": True, **rod, **coupler},
    }
    joints: Tree = {
        "a": {"type": "hinge", "bodies": ["ground", "crank"], "at": [0, 0, 0], "axis": [0, 0, 1]},
        "b": {
            "type": "rod",
            "bodies": ["crank", "pin"],
            "points": [[1, 0, 0], [0, 0, 0]],
            "length": 2.5,
        },
        "c": {
            "type": "rod",
            "bodies": ["ground", "pin"],
            "points": [[3, 0, 0], [0, 0, 0]],
            "length": 2,
        },
        "plane": {
            "type": "inplane",
            "bodies": ["ground", "pin"],
            "points": [[0, 0, 0], [0, 0, 0]],
            "axes": [[0, 0, 1], [0, 0, 1]],
        },
    }
    del joints["plane"]["axes"]
    joints["plane"]["axis"] = [0, 0, 1]
    return built(bodies, joints)


TURNED = {"orientation": {"quaternion": [2, 0, 0, 1], "order": "wxyz"}}
"""By 2 atan ½: the crank points to (3/5, 4/5)."""


@pytest.mark.parametrize("side", [1, -1])
def test_the_branch_that_the_scene_stands_on_is_kept(side: int) -> None:
    crank, pin = assemble(four_bar(TURNED, position=[2.5, side * 1.5, 0])).bodies
    assert side * pin.r[1] > 0.5
    end = (1 - 2 * crank.p[3] ** 2, 2 * crank.p[0] * crank.p[3])
    assert math.dist(end, pin.r[:2]) == pytest.approx(2.5, abs=4 * ULP)
    assert math.dist((3, 0), pin.r[:2]) == pytest.approx(2, abs=4 * ULP)


def test_what_is_held_is_not_moved() -> None:
    free = assemble(four_bar(TURNED)).bodies[0]
    held = four_bar(TURNED | {"hold": ["orientation"]})
    crank = assemble(held).bodies[0]
    assert free.p != held.bodies[0].p
    assert crank.p == pytest.approx(held.bodies[0].p, abs=ULP)
    assert residuals(assemble(held))[0] < 4 * ULP


def test_a_held_coordinate_stays_and_the_others_move() -> None:
    held = four_bar(TURNED, hold=["y"])
    pin = assemble(held).bodies[1]
    assert pin.r[1] == 1.5
    assert pin.r[0] == pytest.approx(3 - math.sqrt(4 - 2.25), abs=2 * ULP)


def test_a_held_angular_velocity_drives_the_rest() -> None:
    spin = {"angular_velocity": [0, 0, 2], "hold": ["angular_velocity"]}
    system = assemble(four_bar(TURNED | spin))
    assert system.bodies[0].omega_b == (0, 0, 2)
    assert math.hypot(*system.bodies[1].v) > 0.5
    assert residuals(system)[1] < 8 * ULP
    without = assemble(four_bar(TURNED | {"angular_velocity": [0, 0, 2]}))
    assert 0 < without.bodies[0].omega_b[2] < 2


@pytest.mark.parametrize("hold", [["angular_velocity"], []])
def test_an_angular_velocity_in_frame_o_stays_there_where_its_body_is_turned(
    hold: list[str],
) -> None:
    body = TILTED | {"center": [0.1, 0, 0.2], "angular_velocity": [0, 0, 2], "hold": hold}
    hinge = {"type": "hinge", "bodies": ["ground", "b"], "points": [[0, 0, 0], [0.1, 0, 0]]}
    (b,) = assemble(built({"b": body}, {"h": hinge | {"axes": [[0, 0, 1]] * 2}})).bodies
    omega = precise.rotate(normalised(b.p), precise.triple(b.omega_b))
    assert [float(x) for x in omega] == pytest.approx([0, 0, 2], abs=4 * ULP)


def test_a_held_velocity_is_that_of_the_origin_where_the_body_is_turned() -> None:
    held = {"velocity": [0, 0, 0.5], "angular_velocity_b": [0, 0, 3], "hold": ["velocity"]}
    slot = {"type": "cylindrical", "bodies": ["ground", "b"], "points": [[0, 0, 0]] * 2}
    (b,) = assemble(built({"b": TILTED | held}, {"c": slot | {"axes": [[0, 0, 1]] * 2}})).bodies
    arm = precise.cross(precise.triple(b.omega_b), precise.triple(b.origin_b))
    origin = precise.add(precise.triple(b.v), precise.rotate(normalised(b.p), arm))
    assert [float(x) for x in origin] == pytest.approx([0, 0, 0.5], abs=4 * ULP)


def test_joints_that_stay_open_are_named_with_metres() -> None:
    joints = {
        name: {"type": "rod", "bodies": ["ground", "p"], "points": [at, [0, 0, 0]], "length": 1}
        for name, at in (("left", [0, 0, 0]), ("right", [3, 0, 0]))
    }
    system = built({"p": {"position": [1.25, 0, 0], "point": True, "mass": 1}}, joints)
    with pytest.raises(AssemblyError, match=r"joints\.\w+ by 0\.5 m, joints\.\w+ by 0\.5 m; check"):
        assemble(system)


def test_joints_that_stay_open_are_named_with_radians() -> None:
    """Axes at 0.2 rad cannot both be those of a body that holds its orientation."""
    bodies = {"b": {"position": [0, 0, 0], "mass": 1, "hold": ["orientation"]}}
    axes = [[0, 0, 1], [math.sin(0.2), 0, math.cos(0.2)]]
    joints = {"guide": {"type": "parallel_axes", "bodies": ["ground", "b"], "axes": axes}}
    with pytest.raises(AssemblyError, match=r"joints\.guide by 0\.1 rad") as caught:
        assemble(built(bodies, joints))
    assert "bodies.b.hold by 0.1 rad" in str(caught.value)


def test_velocities_that_are_held_against_a_joint_are_named() -> None:
    system = on_a_rod(position=[1, 0, 0], velocity=[2, 0, 0], hold=["velocity"])
    with pytest.raises(AssemblyError, match=r"these are torn: .*by 1 m/s") as caught:
        assemble(system)
    assert "joints.rod by" in str(caught.value) and "bodies.b.hold by" in str(caught.value)
    assert sorted(caught.value.keys) == ["bodies.b.hold", "joints.rod"]


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_velocities_are_found_and_refused_by_turns_whatever_the_size(size: float) -> None:
    """Two parallel axes, and a spin that both allow but for 1e-6 of it."""
    bodies = {"b": {"position": [0, 0, 0], "mass": 1, "center": [size, 0, 0]}}
    bodies["b"]["angular_velocity"] = [0.1, 0.2, 1]
    guide = {"type": "revolute", "bodies": ["ground", "b"], "at": [0, 0, size], "axis": [1, 2, 9]}
    again = {**guide, "at": [size, 2 * size, 10 * size]}
    assemble(built(bodies, {"guide": guide, "again": again}))
    held: Tree = {"b": {**bodies["b"], "hold": ["angular_velocity"]}}
    held["b"]["angular_velocity"] = [1, 2, 9 + 1e-6]
    with pytest.raises(AssemblyError, match="rad/s"):
        assemble(built(held, {"guide": guide}))


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_turns_that_a_displacement_follows_are_put_together_whatever_the_size(size: float) -> None:
    """Counted in metres, the row of a coupling was far from those of other joints."""
    ball = {"mass": 1, "inertia": dict.fromkeys(("xx", "yy", "zz"), size**2)}
    bodies = {
        "wheel": {"position": [0.5 * size, 0.02 * size, 0], "angular_velocity": [0, 0, 1], **ball},
        "rack": {"position": [0.03 * size, 1.01 * size, 0], **ball},
    }
    pinion = {"type": "pin", "bodies": ["ground", "wheel"], "axis": [0, 0, 1]}
    slide = {"type": "prismatic", "bodies": ["ground", "rack"], "axis": [1, 0, 0]}
    arms = [[0, 0, 0], [-0.5 * size, 0, 0]], [[0, size, 0], [0, 0, 0.5 * size]]
    joints = {
        "pinion": {**pinion, "points": arms[0]},
        "slide": {**slide, "points": arms[1]},
        "mesh": {"type": "linear", "coordinates": ["turn", "way"], "factors": [size, -0.25]},
    }
    tree = {"name": "s", "unit": "m", "bodies": bodies, "joints": joints}
    tree["coordinates"] = {"turn": {"joint": "pinion"}, "way": {"joint": "slide"}}
    placed = assemble(system_of(scene_from_dict(tree)))
    rows = Residuals.of(placed, placed.constraints)
    c, rates = rows.at_start(placed.bodies)
    lengths = np.where(rows.in_metres, size, 1.0)
    assert np.abs(c / lengths).max() < 4 * ULP
    assert np.abs(rates / lengths).max() < 4 * ULP
    assert placed.bodies[0].omega_b[2] == pytest.approx(0.25 * placed.bodies[1].v[0] / size)


def test_a_large_system_that_does_not_fit_is_refused_at_once() -> None:
    system = system_of(chain(1300))
    moved = replace(system.bodies[7], r=(9.0, 9.0, 9.0))
    bodies = (*system.bodies[:7], moved, *system.bodies[8:])
    with pytest.raises(AssemblyError, match="has 6500 rows; assembly moves at most 6000"):
        assemble(replace(system, bodies=bodies))


def four_bar_with(*values: str) -> Tree:
    """Rectangle of 3 m by 1 m, its two cranks driven."""

    def bar(x: float, y: float, length: float, *, up: bool) -> Tree:
        turned = {"angles": ["90 deg" if up else 0, 0, 0], "sequence": "zyx", "about": "body"}
        rods = [{"mass": 1, "ends": [[0, 0, 0], [length, 0, 0]]}]
        return {"position": [x, y, 0], "orientation": turned, "rods": rods}

    ends = {"a": ("ground", "crank"), "b": ("crank", "coupler"), "c": ("coupler", "rocker")}
    at = {"a": [0, 0, 0], "b": [0, 1, 0], "c": [3, 1, 0], "d": [3, 0, 0]}
    joints = {
        name: {"type": "revolute", "bodies": [*pair], "at": at[name], "axis": [0, 0, 1]}
        for name, pair in {**ends, "d": ("ground", "rocker")}.items()
    }
    return {
        "name": "two",
        "unit": "m",
        "bodies": {
            "crank": bar(0, 0, 1, up=True),
            "coupler": bar(0, 1, 3, up=False),
            "rocker": bar(3, 0, 1, up=True),
        },
        "joints": joints,
        "drivers": {f"m{k}": {"joint": "ad"[k], "value": value} for k, value in enumerate(values)},
    }


@pytest.mark.parametrize("values", [("3*t", "-2*t"), ("1 + 3*t", "-2*t")])
def test_two_drivers_for_one_freedom_are_said_first(values: tuple[str, str]) -> None:
    system = system_of(scene_from_dict(four_bar_with(*values)))
    says = r"^two: 2 drivers for 1 degree of freedom, drivers\.m0, drivers\.m1: leave some out; "
    with pytest.raises(AssemblyError, match=says):
        assemble(system)


def test_one_driver_that_leads_out_of_reach_is_not_one_too_many() -> None:
    tree = four_bar_with("3*t")
    tree["bodies"]["rocker"]["rods"][0]["ends"] = [[0, 0, 0], [0.5, 0, 0]]
    points = {"bodies": ["coupler", "rocker"], "points": [[3, 0, 0], [9, 0, 0]]}
    tree["joints"]["c"] = {"type": "revolute", "axis": [0, 0, 1], **points}
    with pytest.raises(AssemblyError, match=r"^two: does not fit"):
        assemble(system_of(scene_from_dict(tree)))


def test_what_assembly_changed_is_told_in_the_unit_of_the_scene() -> None:
    bar: Tree = {
        "position": [400, 300, 200],
        "velocity": [1000, 2000, 3000],
        "rods": [{"mass": 1, "ends": [[0, 0, 0], [1000, 0, 0]]}],
    }
    hinge: Tree = {"type": "revolute", "bodies": ["ground", "bar"]}
    hinge |= {"points": [[0, 0, 0]] * 2, "axes": [[0, 1, 0]] * 2}
    tree: Tree = {"name": "s", "unit": "mm", "bodies": {"bar": bar}, "joints": {"a": hinge}}
    given = system_of(scene_from_dict(tree))
    assert notes_of(changes_of_assembly(given, assemble(given)), given.unit, "mm") == (
        "assembly changed bodies.bar: moved by 539 mm, turned by 10.6 deg,"
        " velocity by 3.74e+03 mm/s",
    )
    tree["bodies"]["bar"] = bar | {"position": [0, 0, 0], "velocity": [0, 0, 0]}
    tree["bodies"]["bar"]["angular_velocity"] = [0, 1, 2]
    given = system_of(scene_from_dict(tree))
    assert notes_of(changes_of_assembly(given, assemble(given)), given.unit, "mm") == (
        "assembly changed bodies.bar: angular velocity by 2 rad/s",
    )


def test_velocities_that_a_scene_leaves_to_its_drivers_are_not_told() -> None:
    given = system_of(read_scene(ROOT / "scenes" / "loop.toml"))
    assert notes_of(changes_of_assembly(given, assemble(given)), given.unit, "m") == ()
