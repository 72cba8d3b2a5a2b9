"""Bodies that are joined rigidly become one, and nothing else changes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.dynamics.recording.counts import operations
from kousoku.codegen.dynamics.simplification.lump import lump
from kousoku.codegen.generate import write_tree
from kousoku.model.elements.load import Load
from kousoku.model.elements.spring_damper import PointSpring
from kousoku.model.mechanics.multibody import GROUND_INDEX, Instance, RelativeCoordinate, System
from kousoku.model.reading.builder import SceneBuilder
from kousoku.runtime.dynamics import load_dynamics
from tests.analysed import all_rows

if TYPE_CHECKING:
    from pathlib import Path
    from types import SimpleNamespace

    from kousoku.model.records.scene import Scene
    from kousoku.runtime.integrate.motion import Motion

MOVABLE = ("revolute", "spherical", "universal", "cylindrical")
#: Of the last one a torque acts on a body that stands still: its work is told, and it stays a body.
SEEDS = (1, 2, 6, 9, 12)


def random_tree(seed: int) -> Scene:
    """Bodies on each other and on the ground, half of them by fixed joints."""
    rng = np.random.default_rng(seed)
    builder = SceneBuilder(f"tree_{seed}", unit="cm").gravity(30, -500, -800)
    names = ["ground"]
    for k in range(6):
        before, name = names[int(rng.integers(max(0, k - 2), k + 1))], f"b{k}"
        at = rng.uniform(-30, 30, 3).round(3).tolist()
        turn = rng.normal(size=4).round(3).tolist()
        builder.body(
            name,
            position=at,
            orientation={"quaternion": turn, "order": "wxyz"},
            angular_velocity=rng.normal(size=3).round(2).tolist(),
            boxes=[{"mass": 1 + k, "size": (5, 8, 11), "at": (2, -3, 4)}],
        )
        kind = {0: "revolute", 1: "fixed", 2: "fixed", 3: "revolute", 4: "fixed"}.get(k, "")
        kind = kind or MOVABLE[int(rng.integers(len(MOVABLE)))]
        axes: dict[str, Any] = {} if kind in {"fixed", "spherical"} else {"axis": (0, 0, 1)}
        if kind == "universal":
            axes["second_axis"] = (1, 0, 0)
        builder.joint(f"j{k}", type=kind, bodies=(before, name), at=at, **axes)
        names.append(name)
    builder.force("push", type="force", body="b2", point=(1, 2, 3), force=(50, -80, 20))
    builder.force("jet", type="force", body="b4", force_b=(9, 40, -30))
    builder.force("brake", type="torque", body="b4", torque_b=(200, -100, 300))
    builder.force(
        "spring",
        type="spring_damper",
        bodies=("b1", "b5"),
        points=((1, 2, 3), (-1, 0, 2)),
        stiffness=200,
        damping=3,
    )
    builder.force("coil", type="rotational_spring_damper", coordinate="theta", stiffness=20000)
    return (
        builder.coordinate("theta", joint="j0").driver("motor", joint="j3", value="0.5*t^2").build()
    )


def moved(scene: Scene, outputs: list[str], folder: Path) -> Motion:
    write_tree(folder, generate_dynamics(scene, outputs))
    solver = load_dynamics(folder, target="numpy")
    return solver.simulate(0.06, samples=4, tolerance=1e-11)


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize(
    "seed", [*SEEDS[:3], *(pytest.param(x, marks=pytest.mark.release) for x in SEEDS[3:])]
)
def test_the_motion_of_a_tree_is_that_of_all_its_bodies(seed: int, tmp_path: Path) -> None:
    scene = random_tree(seed)
    outputs = ["accelerations", "coordinates", "energies"]
    one = moved(scene, outputs, tmp_path / "one")
    each = moved(scene, [*outputs, "reactions"], tmp_path / "each")

    assert list(one.position) == list(each.position) == list(scene.bodies)
    for name in (
        *("position", "orientation", "velocity", "angular_velocity"),
        *("acceleration", "angular_acceleration", "energy", "work"),
        *("coordinate", "coordinate_rate", "coordinate_acceleration"),
    ):
        a, b = getattr(one, name), getattr(each, name)
        assert a.keys() == b.keys()
        size = max(float(np.abs(x).max()) for x in b.values())
        for body, values in a.items():
            sign = np.sign(np.sum(values * b[body])) if name == "orientation" else 1.0
            np.testing.assert_allclose(sign * values, b[body], rtol=0, atol=1e-8 * size)
    assert "j1" in each.ledger.violations
    assert "j1" not in one.ledger.violations


@pytest.mark.usefixtures("numpy_solver")
def test_momentum_is_told_of_all_bodies_that_have_it(tmp_path: Path) -> None:
    builder = SceneBuilder("floating", unit="m").outputs("energies")
    for k, name in enumerate("abc"):
        builder.body(name, position=(k, 0, 0), boxes=[{"mass": 1, "size": (1, 2, 3)}])
    builder.joint("weld", type="fixed", bodies=("a", "b"), at=(0, 0, 0))
    builder.joint("ball", type="spherical", bodies=("b", "c"), at=(1.5, 0, 0))
    (found,) = moved(builder.build(), ["energies"], tmp_path / "floating").ledger.momenta

    assert found.bodies == ("a", "b", "c")


def fixed(mechanisms: SimpleNamespace, name: str, i: int, j: int, s_i: Any, s_j: Any) -> list[Any]:
    keep = (("a_i_b", (1.0, 0.0, 0.0)), ("a_j_b", (0.0, 1.0, 0.0)))
    return [
        mechanisms.point(name, i, j, s_i, s_j),
        mechanisms.parallel(name, i, j, (0.0, 0.0, 1.0)),
        Instance(name, "n1", i, j, keep),
    ]


def row_of(mechanisms: SimpleNamespace, height: float = 0.0) -> System:
    """Pendulum of three rods, the second fixed to the first, ``height`` above it."""
    system: System = mechanisms.planar_pendulum(3, height)
    hinge = [one for one in system.constraints if one.joint != "j1"]
    ends = (0.5, 0.0, 0.5 * height), (-0.5, 0.0, -0.5 * height)
    return replace(system, constraints=(*hinge, *fixed(mechanisms, "weld", 0, 1, *ends)))


def test_mass_center_and_moments_are_those_of_both(mechanisms: SimpleNamespace) -> None:
    found = lump(row_of(mechanisms))
    first, last = found.system.bodies

    assert found.joints == ("weld",)
    assert (first.mass, first.r) == (2.6, (1.0, 0.0, 0.0))
    assert first.inertia == pytest.approx((0.4, 0.6 + 2.6 * 0.25, 0.5 + 2.6 * 0.25), rel=1e-15)
    assert last == row_of(mechanisms).bodies[2]
    assert [one.carrier for one in found.system.carried] == [0, 0, 1]
    assert found.system.carried[1].origin_b == (0.5, 0.0, 0.0)


@pytest.mark.parametrize("height", [0.0, 0.25])
def test_bodies_at_any_height_stay_in_their_plane(
    mechanisms: SimpleNamespace, height: float
) -> None:
    system = row_of(mechanisms, height)
    one = lump(system).system

    assert compose(all_rows(one)).is_planar
    assert operations(compose(all_rows(one))) < operations(compose(all_rows(system)))
    assert compose(all_rows(one)).region("v").size == 6


def test_what_is_fixed_to_the_ground_has_no_columns_and_keeps_its_energy(
    mechanisms: SimpleNamespace,
) -> None:
    system = mechanisms.chain(3)
    hinge = [one for one in system.constraints if one.joint != "j0"]
    base = fixed(mechanisms, "base", GROUND_INDEX, 0, (0.0, 0.0, 0.0), (-0.5, 0.0, 0.0))
    constants = (("s_j_b", (0.5, 0.0, 0.0)), ("force", (2.0, 0.0, 0.0)))
    pull = Load("pull", "force", GROUND_INDEX, 0, constants)
    found = lump(replace(system, constraints=(*base, *hinge), forces=(pull,))).system

    assert [body.name for body in found.bodies] == ["b1", "b2"]
    assert found.carried[0].carrier == GROUND_INDEX
    assert found.carried[0].origin_b == system.bodies[0].r
    assert found.forces == ()
    assert found.static_potential == -2.0
    joint = next(one for one in found.constraints if one.joint == "j1")
    assert (joint.i, dict(joint.constants)["s_i_b"]) == (GROUND_INDEX, (1.0, 0.0, 0.0))


@pytest.mark.parametrize("damping", [0.0, 1.0])
def test_a_spring_in_one_body_is_energy_only_where_no_work_is_told(
    mechanisms: SimpleNamespace, damping: float
) -> None:
    constants = (
        *(("s_i_b", (0.0, 0.0, 0.0)), ("s_j_b", (0.0, 0.0, 0.0))),
        *(("stiffness", (8.0,)), ("damping", (damping,)), ("free_length", (0.5,))),
    )
    spring = PointSpring("spring", 0, 1, constants)
    system = replace(row_of(mechanisms), forces=(spring,))
    found = lump(system).system

    if damping:
        assert found == system
    else:
        assert (found.forces, found.static_potential) == ((), 1.0)


def test_a_fixed_joint_whose_reactions_are_wanted_stays(mechanisms: SimpleNamespace) -> None:
    system = row_of(mechanisms)

    assert lump(system, ["reactions"]).system == system
    assert len(lump(system, ["energies"]).system.bodies) == 2


def test_gravity_that_a_parameter_changes_keeps_what_rests(mechanisms: SimpleNamespace) -> None:
    """The energy of what stands still is no number then."""
    base = fixed(mechanisms, "base", GROUND_INDEX, 0, (0.0, 0.0, 0.0), (-0.5, 0.0, 0.0))
    rest = [one for one in mechanisms.chain(2).constraints if one.joint != "j0"]
    system = replace(mechanisms.chain(2), constraints=(*base, *rest))

    assert len(lump(system).system.bodies) == 1
    changed = replace(system, gravity_law=("", "", "g"))
    assert lump(changed).system == changed


def test_a_coordinate_between_two_bodies_keeps_them_two(mechanisms: SimpleNamespace) -> None:
    points = (("s_i_b", (0.0, 0.0, 0.0)), ("s_j_b", (0.0, 0.0, 0.0)))
    system = replace(
        row_of(mechanisms), coordinates=(RelativeCoordinate("l", "length", 0, 1, points),)
    )

    assert lump(system).system == system


def test_only_the_bodies_between_which_a_damper_works_stay_apart(
    mechanisms: SimpleNamespace,
) -> None:
    system = mechanisms.chain(5)
    ends = (0.5, 0.0, 0.0), (-0.5, 0.0, 0.0)
    welds = [one for k in range(1, 4) for one in fixed(mechanisms, f"w{k}", k - 1, k, *ends)]
    kept = [one for one in system.constraints if one.joint in {"j0", "j4"}]
    system = replace(system, constraints=(*kept, *welds))
    torque = Load("motor", "torque_b", GROUND_INDEX, 4, (("torque", (0.0, 0.0, 1.0)),))
    constants = (
        *(("s_i_b", (0.0, 0.0, 0.0)), ("s_j_b", (0.0, 0.0, 0.0))),
        *(("stiffness", (8.0,)), ("damping", (1.0,)), ("free_length", (0.5,))),
    )
    damper = PointSpring("damper", 0, 1, constants)

    assert lump(replace(system, forces=(torque,))).joints == ("w1", "w2", "w3")
    assert lump(replace(system, forces=(damper,))).joints == ("w3",)


def test_bodies_with_many_joints_are_not_made_one(mechanisms: SimpleNamespace) -> None:
    """Three arms on each of two bodies cost less than six on one."""
    few, many = (two_hubs(mechanisms, arms) for arms in (2, 3))

    assert lump(few).joints == ("weld",)
    assert lump(many).joints == ()
    assert operations(compose(all_rows(lump(few).system))) < operations(compose(all_rows(few)))


def two_hubs(mechanisms: SimpleNamespace, arms: int) -> System:
    one: System = mechanisms.star(arms)
    count = len(one.bodies)
    far = tuple(replace(b, name=f"{b.name}_far", r=(b.r[0], 3.0, b.r[2])) for b in one.bodies)
    other = [
        replace(c, joint=f"{c.joint}_far", i=c.i + count, j=c.j + count) for c in one.constraints
    ]
    weld = fixed(mechanisms, "weld", 0, count, (0.0, 1.5, 0.0), (0.0, -1.5, 0.0))
    return replace(one, bodies=one.bodies + far, constraints=(*one.constraints, *other, *weld))


def test_a_loop_of_fixed_joints_is_one_body(mechanisms: SimpleNamespace) -> None:
    system = mechanisms.chain(4)
    ends = (0.5, 0.0, 0.0), (-0.5, 0.0, 0.0)
    loop = [
        *fixed(mechanisms, "w1", 0, 1, *ends),
        *fixed(mechanisms, "w2", 1, 2, *ends),
        *fixed(mechanisms, "w3", 0, 2, (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)),
    ]
    kept = [one for one in system.constraints if one.joint in {"j0", "j3"}]
    found = lump(replace(system, constraints=(*kept, *loop)))

    assert found.joints == ("w1", "w2", "w3")
    assert len(found.system.bodies) == 2
    assert {one.joint for one in found.system.constraints} == {"j0", "j3"}


def test_a_scene_in_which_nothing_moves_stays_as_it_is(mechanisms: SimpleNamespace) -> None:
    system = mechanisms.chain(1)
    base = fixed(mechanisms, "base", GROUND_INDEX, 0, (0.0, 0.0, 0.0), (-0.5, 0.0, 0.0))
    system = replace(system, constraints=tuple(base))

    assert lump(system).system == system
