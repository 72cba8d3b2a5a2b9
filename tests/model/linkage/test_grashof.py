"""Closure before solving: what is refused certainly cannot close, and nothing else is."""

from __future__ import annotations

from math import acos, asin, cos, hypot, pi, sin, tau
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from kousoku.model.errors import SceneError
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import scene_from_dict
from kousoku.model.validation.validate import check

Tree = dict[str, Any]
LENGTHS = st.floats(0.1, 10)
ANGLES = st.floats(-7, 7)


def four_bar(l1: float, l2: float, l3: float, l4: float, **way: Any) -> SceneBuilder:
    """Four-bar with frame l4 along x and an input of l1."""
    return (
        SceneBuilder("four_bar", unit="m", divisions=way.pop("divisions", 60))
        .node("A", at=(0, 0), fixed=True)
        .node("B", at=(l1, 0.1))
        .node("C", at=(l4 + 1, l3 + 1))
        .node("D", at=(l4, 0), fixed=True)
        .link("l1", "A", "B", length=l1)
        .link("l2", "B", "C", length=l2)
        .link("l3", "C", "D", length=l3)
        .link("l4", "D", "A", length=l4)
        .input("alpha", link="l1", about="A", **way)
    )


def closes(l1: float, l2: float, l3: float, l4: float, angles: list[float]) -> list[float]:
    """Gap of the dyad of a four-bar at each angle; negative where it closes."""
    distances = [hypot(l4 - l1 * cos(angle), -l1 * sin(angle)) for angle in angles]
    return [max(distance - l2 - l3, abs(l2 - l3) - distance) for distance in distances]


def test_the_paper_lever_crank_closes(lever: Tree) -> None:
    assert check(scene_from_dict(lever)) == ()


def test_a_rod_may_lie_on_the_line_of_its_slider(piston: Tree) -> None:
    assert check(scene_from_dict(piston)) == ()


def test_a_slider_that_just_reaches_is_taken_with_a_note(piston: Tree) -> None:
    piston["sliders"]["piston"]["through"] = [0, 1]
    (note,) = check(scene_from_dict(piston))
    assert note.startswith("at division 45 (alpha = 4.71239) links.l2 and sliders.piston at O3 are")


def test_the_message_names_crank_inequality_and_angles(lever: Tree) -> None:
    lever["links"]["l4"] = {"nodes": ["O4", "O1"], "length": 100}
    lever["links"]["l2"]["length"] = 45
    lever["links"]["l3"]["length"] = 70
    stop = acos((30**2 + 100**2 - 115**2) / (2 * 30 * 100))
    with pytest.raises(SceneError) as caught:
        scene_from_dict(lever)
    assert caught.value.key == "inputs.alpha"
    assert caught.value.problem.startswith(
        "the crank 'l1' cannot make the motion: Grashof's condition (34) l1 + l4 <= l2 + l3 does "
        f"not hold (30 + 100 > 45 + 70), stops it at alpha = {stop:.6g} and {tau - stop:.6g} rad; "
        "links.l2 and links.l3 cannot close at division 19 (alpha = 1.98968): "
    )


def test_the_folded_side_of_the_condition_is_stated_too() -> None:
    """l1 + l3 <= l2 + l4 fails: the crank stops on its way to the frame, not away from it."""
    with pytest.raises(SceneError) as caught:
        four_bar(3, 2, 7, 6, **{"start": pi}).build()
    assert "(34) l1 + l3 <= l2 + l4 does not hold (3 + 7 > 2 + 6)" in caught.value.problem


def test_a_crank_longer_than_the_frame_is_a_drag_link() -> None:
    with pytest.raises(SceneError) as caught:
        four_bar(6, 2, 7, 3, **{"start": pi}).build()
    assert "(34) l4 + l3 <= l2 + l1 does not hold (3 + 7 > 2 + 6)" in caught.value.problem


def test_a_crank_that_closes_at_no_angle_is_said_so(piston: Tree) -> None:
    piston["sliders"]["piston"]["through"] = [0, 9]
    with pytest.raises(SceneError, match=r"does not hold .1 . 9 > 2., closes at no angle; "):
        scene_from_dict(piston)


def test_a_crank_that_stops_may_rock_where_it_closes() -> None:
    four_bar(3, 4.5, 7, 10, start=-1, to=1).build()
    with pytest.raises(SceneError, match="cannot close at division 50"):
        four_bar(3, 4.5, 7, 10, start=0, to=2.4, divisions=60).build()


@pytest.mark.parametrize("divisions", [1, 61])
@pytest.mark.parametrize("way", [{}, {"turns": -1}, {"start": 3, "to": 4}])
def test_a_crank_that_is_stopped_between_two_divisions_is_refused(
    divisions: int, way: dict[str, float]
) -> None:
    with pytest.raises(SceneError, match=r"between divisions \d+ and \d+ \(alpha = 3.14159\)"):
        four_bar(3, 3, 9.999999, 10, divisions=divisions, **way).build()


def test_a_crank_that_is_stopped_beyond_its_way_is_not_refused() -> None:
    four_bar(3, 3, 9.999999, 10, divisions=1, start=-3, to=3).build()


def test_a_driven_slider_beyond_its_rods_names_its_input() -> None:
    builder = (
        SceneBuilder("press", unit="m")
        .node("A", at=(0, 0), fixed=True)
        .node("B", at=(1, 1))
        .node("C", at=(2, 0))
        .link("l1", "A", "B", length=2)
        .link("l2", "B", "C", length=2)
        .slider("ram", node="C", through=(0, 0), direction=(1, 0))
        .input("s", slider="ram", start=2, to=5)
    )
    with pytest.raises(SceneError, match="cannot close at division 41") as caught:
        builder.build()
    assert caught.value.key == "inputs.s"


def test_a_parallelogram_is_taken_with_a_note() -> None:
    notes = check(four_bar(1, 3, 1, 3).build())
    assert notes == (
        "at division 0 (alpha = 0) links.l2 and links.l3 at C are stretched or folded: the motion "
        "is not determined there",
    )


def test_a_change_point_between_divisions_is_noted_too() -> None:
    notes = check(four_bar(1, 3, 1, 3, start=0.01).build())
    places = [note.partition(" links")[0] for note in notes]
    assert places == ["between divisions 59 and 60 (alpha = 6.28319)"]


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_boundary_cases_are_not_refused_at_any_scale(scale: float) -> None:
    """l1 + l4 = l2 + l3 in decimals that are no exact doubles."""
    four_bar(0.1 * scale, 0.7 * scale, 0.2 * scale, 0.8 * scale).build()


@settings(max_examples=200, deadline=None)
@given(LENGTHS, LENGTHS, LENGTHS, LENGTHS, ANGLES, st.integers(1, 90))
def test_a_four_bar_is_refused_exactly_when_its_turn_does_not_close(
    l1: float, l2: float, l3: float, l4: float, start: float, divisions: int
) -> None:
    angles = [start + tau * k / divisions for k in range(divisions + 1)] + [0, pi]
    worst = max(closes(l1, l2, l3, l4, angles))
    assume(abs(worst) > 1e-9)
    builder = four_bar(l1, l2, l3, l4, start=start, divisions=divisions)
    if worst < 0:
        builder.build()
    else:
        with pytest.raises(SceneError):
            builder.build()


@settings(max_examples=100, deadline=None)
@given(LENGTHS, LENGTHS, LENGTHS, LENGTHS)
def test_the_stop_angles_are_where_the_dyad_is_straight(
    l1: float, l2: float, l3: float, l4: float
) -> None:
    try:
        four_bar(l1, l2, l3, l4).build()
    except SceneError as error:
        _, stopped, rest = error.problem.partition("stops it at alpha = ")
        assume(stopped)
        angles = [float(angle) for angle in rest.partition(" rad")[0].split(" and ")]
        assert all(abs(miss) < 1e-4 for miss in closes(l1, l2, l3, l4, angles))


@settings(max_examples=200, deadline=None)
@given(LENGTHS, LENGTHS, st.floats(-8, 8), ANGLES, st.integers(1, 90))
def test_a_slider_crank_is_refused_exactly_when_its_rod_is_too_short(
    crank: float, rod: float, offset: float, line: float, divisions: int
) -> None:
    """The line stands at any angle and at any side of the crank's centre."""
    angles = [tau * k / divisions for k in range(divisions + 1)] + [line - pi / 2, line + pi / 2]
    worst = max(abs(crank * sin(angle - line) - offset) for angle in angles) - rod
    assume(abs(worst) > 1e-9)
    through = (3 - offset * sin(line), 2 + offset * cos(line))
    builder = (
        SceneBuilder("slider_crank", unit="m", divisions=divisions)
        .node("A", at=(3, 2), fixed=True)
        .node("B", at=(3 + crank, 2))
        .node("C", at=(30, 40))
        .link("crank", "A", "B", length=crank)
        .link("rod", "B", "C", length=rod)
        .slider("piston", node="C", through=through, direction=(2 * cos(line), 2 * sin(line)))
        .input("alpha", link="crank", about="A")
    )
    if worst < 0:
        builder.build()
        return
    with pytest.raises(SceneError) as caught:
        builder.build()
    problem = caught.value.problem
    assert "crank + offset <= rod does not hold" in problem
    numbers = problem.partition("does not hold (")[2].partition(")")[0].replace(">", "+")
    assert [float(number) for number in numbers.split(" + ")] == pytest.approx(
        [crank, abs(offset), rod], abs=1e-9
    )
    _, stopped, rest = problem.partition("stops it at alpha = ")
    stops = [float(angle) for angle in rest.partition(" rad")[0].split(" and ")] if stopped else []
    for stop in stops:
        assert abs(abs(crank * sin(stop - line) - offset) - rod) < 1e-4 * (1 + crank)


@pytest.mark.parametrize(
    "bell",
    [
        {"links": ["l1", "arm"], "angle": pi / 2},
        {"links": ["arm", "l1"], "angle": -pi / 2},
        {"links": ["arm", "l1"]},
    ],
)
def test_a_rigid_arm_of_a_crank_is_a_crank(lever: Tree, bell: Tree) -> None:
    """A bell crank: the input turns l1, and an arm fixed to it at right angles drives the dyad."""
    lever["nodes"]["B"] = {"at": [0, 30]}
    lever["links"] |= {
        "arm": {"nodes": ["B", "O1"], "length": 30},
        "l2": {"nodes": ["B", "O3"], "length": 45},
        "l3": {"nodes": ["O3", "O4"], "length": 70},
    }
    lever["rigid"] = {"bell": {"at": "O1"} | bell}
    stop = acos((30**2 + 100**2 - 115**2) / (2 * 30 * 100))
    with pytest.raises(SceneError) as caught:
        scene_from_dict(lever)
    assert "the crank 'arm' cannot make the motion" in caught.value.problem
    assert f"alpha = {stop - pi / 2:.6g} and {tau - stop - pi / 2:.6g} rad" in caught.value.problem


def test_two_cranks_of_a_five_bar_must_stay_in_reach() -> None:
    builder = (
        SceneBuilder("five_bar", unit="m", divisions=4)
        .node("A", at=(0, 0), fixed=True)
        .node("B", at=(1, 0))
        .node("C", at=(3, 4))
        .node("D", at=(5, 0))
        .node("E", at=(6, 0), fixed=True)
        .link("l1", "A", "B", length=1)
        .link("l2", "B", "C", length=3)
        .link("l3", "C", "D", length=3)
        .link("l4", "D", "E", length=1)
        .input("alpha", link="l1", about="A")
        .input("beta", link="l4", about="E", start=pi)
    )
    with pytest.raises(SceneError) as caught:
        builder.build()
    assert caught.value.key == "inputs.alpha"
    assert "cannot close at division 1 (alpha = 1.5708, beta = 4.71239): " in caught.value.problem
    assert "the distance from B to D is 6.32455532034 m, wanted 0 to 6 m" in caught.value.problem


def test_a_driven_slider_must_stay_in_reach_of_the_crank(piston: Tree) -> None:
    piston["inputs"] = {"s": {"slider": "piston", "from": 2, "to": 3.5}}
    with pytest.raises(SceneError) as caught:
        scene_from_dict(piston)
    assert "links.l1 and links.l2 cannot close at division 41 (s = 3.025)" in caught.value.problem


def test_a_triangle_on_fixed_nodes_that_is_too_flat_cannot_be_assembled(lever: Tree) -> None:
    lever["nodes"]["T"] = {"at": [50, 50]}
    lever["links"] |= {
        "a": {"nodes": ["O1", "T"], "length": 200},
        "b": {"nodes": ["O4", "T"], "length": 90},
    }
    with pytest.raises(SceneError, match="cannot be assembled: its length 200 cm exceeds the rest"):
        scene_from_dict(lever)


def test_a_hanger_on_a_slider_that_is_too_short_cannot_be_assembled(lever: Tree) -> None:
    lever["nodes"]["S"] = {"at": [5, 90]}
    lever["links"]["a"] = {"nodes": ["O1", "S"], "length": 80}
    lever["sliders"] = {"s": {"node": "S", "through": [0, 90], "direction": [1, 0]}}
    with pytest.raises(SceneError) as caught:
        scene_from_dict(lever)
    assert caught.value.key == "nodes.S"
    assert "cannot be assembled: links.a and sliders.s meet only where" in caught.value.problem


def test_a_million_divisions_are_checked_in_blocks() -> None:
    four_bar(3, 6, 8, 10, divisions=1_000_000, turns=0.5).build()
    with pytest.raises(SceneError, match="at division 9"):
        four_bar(3, 4.5, 7, 10, divisions=1_000_000, start=0, to=2.1).build()


def test_a_block_of_a_single_division_is_no_fixed_place() -> None:
    """The last division stands alone in its block, and is the only one that does not close."""
    builder = four_bar(3, 4.5, 7, 10, divisions=65536, start=0, to=1.9687)
    builder.build()
    with pytest.raises(SceneError) as caught:
        four_bar(3, 4.5, 7, 10, divisions=65536, start=0, to=1.968710 + 2e-5).build()
    assert "Grashof's condition (34)" in caught.value.problem
    assert "cannot close at division 65536 (alpha = 1.96873)" in caught.value.problem


def test_many_turns_are_checked_once() -> None:
    four_bar(3, 6, 8, 10, divisions=600_000, turns=10_000).build()


def test_the_slider_condition_is_that_of_the_formula() -> None:
    """asin((rod − offset)/crank) by hand, for the committed bad scene."""
    assert pi - asin((1.5 - 2) / 1) == pytest.approx(3.66519, abs=1e-5)
