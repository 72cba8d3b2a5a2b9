"""What is left out is cheaper, and changes nothing that is left."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.explanation.explain import ALL, Explanation, explain
from kousoku.codegen.dynamics.explanation.structure import structure_of
from kousoku.codegen.dynamics.recording.counts import operations
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.model.mechanics.multibody import System
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.families import n_four_bar
from kousoku.model.reading.read import read_scene, scene_from_toml
from tests.analysed import all_rows, independent

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import SimpleNamespace

    from kousoku.codegen.dynamics.recording.program import Program

SCENES = Path(__file__).parents[4] / "scenes"
WELDED = (
    SceneBuilder("welded", unit="m")
    .gravity(0, 0, -9.81)
    .body("a", position=(0, 0, 0), boxes=[{"mass": 1, "size": (1, 2, 3), "at": (0.5, 0, 0)}])
    .body("b", position=(1, 1, 0), boxes=[{"mass": 2, "size": (2, 1, 1)}])
    .joint("hinge", type="revolute", bodies=("ground", "a"), at=(0, 0, 0), axis=(0, 1, 1))
    .joint("weld", type="fixed", bodies=("a", "b"), at=(1, 0, 0))
    .build()
)
SUBSETS = [names for n in range(len(ALL) + 1) for names in itertools.combinations(ALL, n)]


def accelerations(program: Program) -> dict[tuple[str, int], float]:
    """Accelerations at the start, by body and component; 0 of those left out."""
    workspace = ProgramInterpreter(program)
    for segment in ("geometry", "acceleration"):
        workspace.run(segment)
    v, v_dot = program.region("v"), workspace["v_dot"]
    return {
        (body.body, k): float(v_dot[place.slot - v.base]) if place.slot >= 0 else 0.0
        for body in program.bodies
        for k, place in enumerate((*body.v, *body.omega_b))
    }


def saved(found: Explanation, name: str) -> Any:
    return next(step for step in found.steps if step.name == name)


@pytest.mark.parametrize("wanted", SUBSETS, ids=" ".join)
def test_what_is_not_wanted_is_not_counted_and_changes_nothing(
    mechanisms: SimpleNamespace, wanted: Sequence[str]
) -> None:
    everything, some = (compose(all_rows(mechanisms.chain(3)), names) for names in (ALL, wanted))

    if len(wanted) < len(ALL):
        assert operations(some) < operations(everything)
    assert accelerations(some) == accelerations(everything)


@pytest.mark.parametrize("count", [1, 3])
def test_a_planar_scene_costs_less_than_half_and_moves_as_in_space(
    mechanisms: SimpleNamespace, count: int
) -> None:
    system = replace(mechanisms.four_bars(count), gravity=(5.0, -9.81, 0.0))
    flat = compose(all_rows(system))
    found = independent(system, may_be_planar=False)
    spatial, freedom = compose(found), found.mobility

    assert len(freedom.dropped) == 3 * count
    assert 2 * operations(flat) < operations(spatial)
    a, b = accelerations(flat), accelerations(spatial)
    assert a.keys() == b.keys()
    assert [a[key] for key in a] == pytest.approx([b[key] for key in a], abs=1e-9)
    assert max(map(abs, a.values())) > 1


def test_each_step_says_what_it_saves() -> None:
    found = explain(n_four_bar(2))

    assert found.is_planar
    assert saved(found, "planar").columns == 15
    assert saved(found, "planar").operations > 5000
    assert saved(found, "zeros and ones folded").operations > 1000
    assert saved(found, "redundant rows removed").rows == 0
    assert "reactions" in saved(found, "outputs not wanted").detail
    assert "2 of" in saved(found, "kinds not used").detail


def test_reactions_out_of_the_plane_are_told_to_cost_more() -> None:
    """The weight hangs beside the plane of its hinge, which therefore has a moment across."""
    scene = (
        SceneBuilder("beside", unit="m")
        .gravity(0, -9.81, 0)
        .body("a", position=(0, 0, 0), boxes=[{"mass": 1, "size": (1, 2, 3), "at": (1, 0, 0.5)}])
        .joint("hinge", type="revolute", bodies=("ground", "a"), at=(0, 0, 0), axis=(0, 0, 1))
        .build()
    )
    names = [step.name for step in explain(scene).steps]
    step = saved(explain(scene, ("reactions",)), "reactions out of the plane")

    assert "reactions out of the plane" not in names
    assert (step.rows, step.columns) == (-3, -3)
    assert step.operations < 0


def test_bodies_that_a_fixed_joint_holds_are_one_and_its_rows_are_gone() -> None:
    found, apart = explain(WELDED), explain(WELDED, ("reactions",))
    step = saved(found, "bodies joined rigidly")

    assert (step.rows, step.columns) == (6, 6)
    assert step.operations > 1000
    assert "weld left out: 2 bodies move as 1" in step.detail
    assert found.freedom.degrees == apart.freedom.degrees == 1
    assert "reactions are wanted" in saved(apart, "bodies joined rigidly").detail
    assert found.structure.rows + 6 == apart.structure.rows


@pytest.mark.parametrize(
    ("moments", "gone"), [((2.0, 2.0, 2.0), 3), ((1.0, 1.0, 1.5), 1), ((1.0, 1.5, 2.2), 0)]
)
def test_gyroscopic_terms_of_equal_moments_are_gone(
    mechanisms: SimpleNamespace, moments: tuple[float, ...], gone: int
) -> None:
    body = mechanisms.body("b", (0.0, 0.0, 0.0), inertia=moments)
    same = compose(all_rows(System("free", 1.0, (body,), (), (1.0, 2.0, 3.0)), may_be_planar=False))
    kernel = [one for one in same.kernels if one.title == "free acceleration"]

    assert sum(one.operations.total() for one in kernel) == 2 * (3 - gone)


def test_gyroscopic_terms_of_a_top_are_counted() -> None:
    step = saved(explain(read_scene(SCENES / "heavy_top.toml")), "gyroscopic terms")

    assert step.operations == 2
    assert "1 of 3 are zero" in step.detail


def test_the_steps_add_up_to_what_remains() -> None:
    """What is taken away and what is left is the same for all wanted outputs."""
    found, more = explain(n_four_bar(2)), explain(n_four_bar(2), ("reactions",))

    assert saved(found, "outputs not wanted").operations > 0
    assert saved(more, "outputs not wanted").operations == 0
    for name in ("zeros and ones folded", "planar"):
        assert saved(found, name) == saved(more, name)
    assert sum(n for _, n in more.segments) > sum(n for _, n in found.segments)


def test_bodies_on_joints_with_the_ground_save_rows_columns_and_operations() -> None:
    cranks = saved(explain(n_four_bar(2)), "dependent coordinates eliminated")
    assert (cranks.rows, cranks.columns) == (6, 6)
    assert cranks.operations > 300
    assert "crank_0, crank_1, crank_2: by what the ground leaves free" in cranks.detail

    gears = explain(read_scene(SCENES / "gear_train.toml"))
    pinion, others = (
        saved(gears, name)
        for name in ("prescribed bodies evaluated", "dependent coordinates eliminated")
    )
    assert (pinion.rows, pinion.columns) == (3, 3)
    assert (others.rows, others.columns) == (4, 4)
    assert min(pinion.operations, others.operations) > 0
    assert "motor: pinion" in pinion.detail
    assert gears.structure.dependent == 7


def test_the_row_of_bricard_that_is_left_out_is_named() -> None:
    found = explain(read_scene(SCENES / "bricard.toml"))
    assert "all are needed" in saved(found, "dependent coordinates eliminated").detail

    assert saved(found, "redundant rows removed").rows == 1
    assert saved(found, "redundant rows removed").operations > 0
    (row,) = found.removed
    joint, _, kind = row.partition(": row ")
    assert joint in found.freedom.dependent[0].joints
    assert kind.split()[-1].startswith(("point", "p1"))
    assert found.structure.rows == found.freedom.rank == 29


def test_the_structure_of_a_chain_grows_with_its_bodies_and_has_no_fill_in(
    mechanisms: SimpleNamespace,
) -> None:
    few, many = (structure_of(x, compose(all_rows(x))) for x in map(mechanisms.chain, (4, 8)))

    assert (few.positions, few.velocities, few.rows) == (28, 24, 20)
    assert few.schur == 4 * 15 + 3 * 25
    assert many.schur == 8 * 15 + 7 * 25
    assert few.fill_in == many.fill_in == 0
    assert (few.parts, many.parts) == (1, 1)
    assert few.dense == 5 * 6 + 3 * 5 * 12


def test_elements_that_are_counted_are_those_that_are_not_zero_somewhere(
    mechanisms: SimpleNamespace,
) -> None:
    """A pendulum in the plane: two rows of x and y, each with one of its own and one of θ."""
    system = mechanisms.planar_pendulum(1)
    found = structure_of(system, compose(all_rows(system)))

    assert (found.rows, found.velocities, found.elements) == (2, 3, 4)


def test_joints_on_the_ground_couple_no_bodies(mechanisms: SimpleNamespace) -> None:
    system = mechanisms.four_bars(1)
    kept = tuple(c for c in system.constraints if c.joint.startswith("ground"))
    apart = replace(system, constraints=kept)

    assert structure_of(apart, compose(all_rows(apart))).parts == 3
    assert structure_of(system, compose(all_rows(system))).parts == 1


def test_the_fill_in_of_a_ring_is_counted(mechanisms: SimpleNamespace) -> None:
    """Of four joints in a ring the first couples its two neighbours when it is eliminated."""
    corners = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.2), (0.0, 1.0, 0.1)]
    bodies = tuple(mechanisms.body(f"b{k}", corner) for k, corner in enumerate(corners))
    at = (0.5, 0.1, 0.2)
    joints = tuple(mechanisms.point(f"j{k}", k, (k + 1) % 4, at, at) for k in range(4))
    system = System("ring", 1.0, bodies, joints)
    found = structure_of(system, compose(all_rows(system)))

    assert (found.schur, found.fill_in) == (4 * 6 + 4 * 9, 9)


def test_a_scene_whose_couplings_depend_on_parameters_is_explained() -> None:
    text = """
        name = "train"
        unit = "m"
        [parameters]
        n = 2.0
        [bodies.a]
        position = [0, 0, 0]
        boxes = [{ mass = 1, size = [1, 1, 0.1] }]
        [bodies.b]
        position = [2, 0, 0]
        boxes = [{ mass = 1, size = [1, 1, 0.1] }]
        [joints]
        left = { type = "revolute", bodies = ["ground", "a"], at = [0, 0, 0], axis = [0, 0, 1] }
        right = { type = "revolute", bodies = ["ground", "b"], at = [2, 0, 0], axis = [0, 0, 1] }
        mesh = { type = "gear", joints = ["left", "right"], ratio = "-n" }
        [coordinates]
        turned = { joint = "left", near = 1.0 }
    """
    fixed = text.replace('"-n"', "-2.0")
    found, known = (explain(scene_from_toml(x)) for x in (text, fixed))
    assert found.structure == known.structure
    assert found.freedom.degrees == known.freedom.degrees == 1
