"""Bodies that hang on the ground by one joint: the same motion with fewer rows."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.analyse import PRESCRIBED
from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.choose import cheaper
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.generate import LEDGER_OUTPUTS
from kousoku.codegen.dynamics.recording.counts import operations
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.recording.program import reads
from kousoku.codegen.dynamics.simplification.reduced_mass import inverse_of
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.families import n_four_bar
from tests.analysed import all_rows, independent, jointed

if TYPE_CHECKING:
    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanics.multibody import System

WANTED = ("checks", "energies", "reactions", "accelerations")
TIME = 0.3
#: How many velocities each joint leaves.
FREE = {"revolute": 1, "prismatic": 1, "cylindrical": 2, "spherical": 3}
LAWS = {"angle": "0.4*sin(3*t) + t", "displacement": "0.2*cos(2*t) - 0.2"}
LEAVES = {
    "revolute": ("angle",),
    "prismatic": ("displacement",),
    "cylindrical": ("angle", "displacement"),
    "spherical": (),
}
EVERY = [
    (kind, is_swapped, driven)
    for kind, is_swapped in product(FREE, (False, True))
    for count in range(3)
    for driven in {LEAVES[kind][:count], LEAVES[kind][:count][::-1][:1]}
    if len(driven) == count
]


def numbers(rng: np.random.Generator, count: int = 3) -> list[float]:
    return [float(x) for x in rng.uniform(-1.0, 1.0, count)]


def hung(
    kind: str, seed: int = 1, *, is_swapped: bool = False, driven: tuple[str, ...] = ()
) -> Any:
    """Arm on a joint with the ground, a tip on a ball of it, and a strut from there."""
    rng = np.random.default_rng(seed)
    builder = SceneBuilder("hung", unit="m").gravity(*numbers(rng))
    for name in ("arm", "tip"):
        builder.body(
            name,
            position=numbers(rng),
            orientation={"axis": numbers(rng), "angle": numbers(rng, 1)[0]},
            boxes=[{"mass": 1.5, "size": [0.3, 0.4, 0.6], "at": numbers(rng)}],
        )
    ends = ("arm", "ground") if is_swapped else ("ground", "arm")
    axis: dict[str, Any] = {} if kind == "spherical" else {"axis": numbers(rng)}
    builder.joint("hold", type=kind, bodies=ends, at=numbers(rng), **axis)
    builder.joint("ball", type="spherical", bodies=("arm", "tip"), at=numbers(rng))
    points = [numbers(rng), numbers(rng)]
    builder.joint("strut", type="rod", bodies=("ground", "tip"), points=points)
    builder.force("push", type="force", body="arm", point=numbers(rng), force=numbers(rng))
    builder.force("twist", type="torque", body="tip", torque_b=numbers(rng))
    for of in driven:
        of_joint: dict[str, Any] = {"of": of} if kind == "cylindrical" else {}
        builder.driver(f"motor_{of}", joint="hold", value=LAWS[of], **of_joint)
    return builder.build()


def system(scene: Any) -> System:
    return assemble(system_of(scene, ("accelerations", "reactions", "energies")))


def run_at(program: Program, state: Any, *segments: str) -> ProgramInterpreter:
    work = ProgramInterpreter(program)
    work["t"] = [TIME]
    for name in ("q", "v"):
        work[name] = list(state[name])
    work.run(*segments)
    return work


def placed(program: Program) -> ProgramInterpreter:
    """Workspace with a state that meets all constraints, not far from the start."""
    rng, work = np.random.default_rng(2), ProgramInterpreter(program)
    work["t"] = [TIME]
    for name, scale, each in (("q", 0.05, 7), ("v", 1.0, 6)):
        count = len(work[name]) // each * each
        moved = np.array(work[name][:count]) + scale * rng.normal(size=count)
        work[name] = [*moved, *work[name][count:]]
    work["dq"] = [0.0] * len(work["dq"])
    work.run("move")
    work["q"] = work["q_moved"]
    for _ in range(12):
        work.run("geometry", "position", "move")
        work["q"] = work["q_moved"]
    work.run("geometry", "velocity")
    work["v"] = [a + b for a, b in zip(work["v"], work["dv"], strict=True)]
    return work


@pytest.mark.parametrize(("kind", "is_swapped", "driven"), EVERY)
def test_all_that_is_computed_is_what_all_rows_give(
    kind: str, is_swapped: bool, driven: tuple[str, ...]
) -> None:
    given = system(hung(kind, is_swapped=is_swapped, driven=driven))
    whole, program = compose(all_rows(given), WANTED), compose(jointed(given), WANTED)
    assert len(program.satisfied) == 6 - FREE[kind] + len(driven)
    assert len(program.rows) == len(whole.rows) - len(program.satisfied) == 4

    state = placed(program)
    segments = ("geometry", "velocity", "acceleration", "reaction", "check", "energy")
    found, wanted = run_at(program, state, *segments), run_at(whole, state, *segments)
    assert np.abs(wanted["C"]).max() < 1e-14
    assert np.abs(wanted["dv"]).max() < 1e-13
    assert np.abs([*found["C"], *found["C_left_out"], *found["dv"]]).max() < 1e-13
    assert np.abs([*found["C_dot"], *found["C_ddot"]]).max() < 1e-12
    for name in ("v_dot", "q_dot", "reactions", "energies"):
        size = np.abs(wanted[name]).max()
        np.testing.assert_allclose(found[name], wanted[name], rtol=0, atol=1e-13 * size)
    assert operations(program) < operations(whole)


@pytest.mark.parametrize(("kind", "is_swapped", "driven"), EVERY[::3])
def test_a_position_is_put_onto_the_joint_and_keeps_its_norm(
    kind: str, is_swapped: bool, driven: tuple[str, ...]
) -> None:
    given = system(hung(kind, seed=5, is_swapped=is_swapped, driven=driven))
    program = compose(jointed(given), WANTED)
    rng, work = np.random.default_rng(3), ProgramInterpreter(program)
    work["t"] = [TIME]
    work["q"] = [*rng.normal(size=14), *work["q"][14:]]
    work["dq"] = list(rng.normal(size=12))
    work.run("move")
    work["q"] = work["q_moved"]
    work.run("geometry", "velocity", "check")
    assert np.abs(work["C_left_out"]).max() < 1e-14
    assert np.linalg.norm(work["q"][3:7]) == pytest.approx(1.0, abs=1e-15)
    before = work["q"]
    work["dq"] = [0.0] * 12
    work.run("move")
    np.testing.assert_allclose(work["q_moved"], before, rtol=0, atol=4e-16)


@pytest.mark.parametrize("torque", ["5", "k"])
@pytest.mark.parametrize("kind", ["revolute", "free"])
def test_only_rows_and_other_parameters_correct_positions(kind: str, torque: str) -> None:
    """With others a run looks aside, whether the rows that hold by themselves still do."""
    builder = SceneBuilder("swing", unit="m")
    builder.body("arm", position=(0, 0, -1), boxes=[{"mass": 2, "size": (1, 2, 3)}])
    if kind != "free":
        builder.joint("hold", type=kind, bodies=("ground", "arm"), at=(0, 0, 0), axis=(0, 1, 0))
    if torque == "k":
        builder.parameter("k", 5.0)
    builder.force("twist", type="torque", body="arm", torque=(0, torque, 0))
    program = compose(jointed(system(builder.build())), WANTED)
    assert not program.rows
    dq = program.region("dq")
    moves = program.segment("move").tasks
    read = {base for task in moves for base, _ in reads(program, task)}
    is_read = not read.isdisjoint(range(dq.base, dq.base + dq.size))
    assert is_read == (kind != "free" and torque == "k")
    work = ProgramInterpreter(program)
    work["q"] = [2 * x for x in work["q"]]
    work.run("move")
    moved = work["q_moved"]
    work["q"] = moved
    work.run("move")
    np.testing.assert_allclose(work["q_moved"], moved, rtol=0, atol=4e-16)


def test_turns_and_slides_are_neither_faster_nor_slower_after_many_fits() -> None:
    program = compose(jointed(system(hung("cylindrical", seed=7))), WANTED)
    work = placed(program)
    first = np.array(work["v"][:6])
    for _ in range(2000):
        work.run("velocity")
        work["v"] = [a + b for a, b in zip(work["v"], work["dv"], strict=True)]
    np.testing.assert_allclose(work["v"][:6], first, rtol=0, atol=2e-15)


def test_other_joints_to_the_ground_are_rows_as_before() -> None:
    universal = SceneBuilder("cross", unit="m").body(
        "b", position=(0, 0, 0), boxes=[{"mass": 1, "size": [1, 2, 3]}]
    )
    universal.joint(
        "hold", type="universal", bodies=("ground", "b"), at=(0, 0, 1), axes=[[1, 0, 0], [0, 1, 0]]
    )
    screw = SceneBuilder("nut", unit="m").body(
        "b", position=(0, 0, 0), boxes=[{"mass": 1, "size": [1, 2, 3]}]
    )
    screw.joint(
        "hold", type="screw", bodies=("ground", "b"), at=(0, 0, 1), axis=(0, 1, 1), pitch=0.1
    )
    twice = SceneBuilder("beam", unit="m").body(
        "b", position=(0, 0, 0), boxes=[{"mass": 1, "size": [1, 2, 3]}]
    )
    twice.joint("left", type="spherical", bodies=("ground", "b"), at=(-1, 0, 1))
    twice.joint("right", type="point_on_line", bodies=("ground", "b"), at=(1, 0, 1), axis=(1, 0, 0))
    point = SceneBuilder("bead", unit="m").body("b", point=True, mass=1, position=(1, 1, 1))
    point.joint("hold", type="rod", bodies=("ground", "b"), points=[[0, 0, 0], [0, 0, 0]])
    for builder in (universal, screw, twice, point):
        program = compose(jointed(system(builder.build())), WANTED)
        assert program.satisfied == ()
        assert program.rows


def test_bodies_whose_numbers_depend_on_parameters_are_not_reduced() -> None:
    for mass, count in ((1.0, 5), ("m", 0)):
        builder = SceneBuilder("pendulum", unit="m")
        if mass == "m":
            builder.parameter("m", 2.0)
        builder.body(
            "b", position=(0, 0, 0), boxes=[{"mass": mass, "size": [1, 2, 3], "at": [0, 0, 1]}]
        )
        builder.joint("hold", type="revolute", bodies=("ground", "b"), at=(0, 0, 2), axis=(1, 1, 0))
        assert len(compose(jointed(system(builder.build())), WANTED).satisfied) == count


def test_only_bodies_that_drivers_lead_are_reduced_where_that_is_asked() -> None:
    led = system(hung("revolute", driven=("angle",)))
    assert len(compose(jointed(led, PRESCRIBED), WANTED).satisfied) == 6
    free = system(hung("revolute"))
    assert compose(jointed(free, PRESCRIBED), WANTED).satisfied == ()


def test_no_body_is_reduced_where_rows_depend_on_others() -> None:
    builder = SceneBuilder("door", unit="m")
    builder.body(
        "leaf", position=(0, 0, 0), boxes=[{"mass": 1, "size": [1, 0.1, 2], "at": [0.5, 0, 0]}]
    )
    builder.body("bolt", position=(1, 0, 0), boxes=[{"mass": 1, "size": [1, 0.1, 2]}])
    builder.joint("hinge", type="revolute", bodies=("ground", "leaf"), at=(0, 0, 0), axis=(0, 0, 1))
    for name, z in (("upper", 1), ("lower", -1)):
        builder.joint(name, type="revolute", bodies=("leaf", "bolt"), at=(1, 0, z), axis=(0, 0, 1))
    given = system(builder.build())
    found = independent(given, may_be_planar=False)
    program = compose(found, WANTED)
    assert program.left_out
    assert cheaper(found, WANTED, program) is program


def test_one_body_of_many_is_reduced_only_where_a_driver_leads_it() -> None:
    for law, count in ((None, 0), ("2*t", 6)):
        builder = SceneBuilder("chain", unit="m").gravity(0, 0, -9.81)
        for k in range(9):
            builder.body(f"b{k}", position=(k, 0, 0), boxes=[{"mass": 1, "size": [1, 0.1, 0.2]}])
            ends, axis = ("ground" if k == 0 else f"b{k - 1}", f"b{k}"), (0, k % 2, 1 - k % 2)
            builder.joint(f"j{k}", type="revolute", bodies=ends, at=(k - 0.5, 0, 0), axis=axis)
        if law:
            builder.driver("motor", joint="j0", value=law)
        given = system(builder.build())
        found = independent(given)
        assert len(cheaper(found, WANTED, compose(found, WANTED)).satisfied) == count


def test_the_four_bars_of_a02_keep_the_rows_of_their_couplers() -> None:
    given = assemble(system_of(n_four_bar(4), ()))
    found = independent(given)
    whole = compose(found, LEDGER_OUTPUTS)
    program = cheaper(found, LEDGER_OUTPUTS, whole)
    assert (len(whole.rows), len(program.rows), len(program.satisfied)) == (26, 16, 10)
    assert program.placed == tuple(range(5))
    assert operations(program) < 0.8 * operations(whole)


def test_inverses_of_masses_are_exact() -> None:
    matrix = [[Fraction(4), Fraction(1, 3)], [Fraction(1, 3), Fraction(2)]]
    (a, b), (c, d) = inverse_of(matrix)
    assert [4 * a + c / 3, a / 3 + 2 * c, 4 * b + d / 3, b / 3 + 2 * d] == [1, 0, 0, 1]
    assert math.isclose(a, 18 / 71)
