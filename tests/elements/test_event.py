"""Events of a scene: formulas that pass zero, and what is refused of them."""

from __future__ import annotations

from typing import Any, get_args

import pytest

from kousoku.model.elements.event import DIRECTIONS
from kousoku.model.errors import SceneError
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.lowering.about import About
from kousoku.model.lowering.root_functions import root_functions_of
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import scene_from_dict
from kousoku.model.records.spatial import Action, Direction
from kousoku.runtime.integrate.settings import ACTIONS

Tree = dict[str, Any]


@pytest.fixture
def bead(bead: Tree) -> Tree:
    """Tables of a bead on the x axis that stops at a place."""
    event = {"when": "x - at", "direction": "rising", "action": "stop"}
    return {**bead, "events": {"there": event}}


def test_an_event_comes_into_the_system_with_what_it_reads(bead: Tree) -> None:
    bead["coordinates"]["y"] = {"body": "bead", "along": [0, 1, 0]}
    system = system_of(scene_from_dict(bead), ())
    (event,) = system.events
    assert (event.name, event.when, event.direction, event.action) == ("there", "x - at", 1, "stop")
    assert [one.name for one in system.coordinates] == ["x"]
    assert system.parameters == (("at", 1.0),)


def test_the_builder_makes_the_same_events(bead: Tree) -> None:
    builder = SceneBuilder("bead", unit="cm").parameter("at", 1.0)
    builder.body("bead", position=(0, 0, 0), point=True, mass=1)
    builder.coordinate("x", body="bead", along=(1, 0, 0))
    built = builder.event("there", when="x - at", direction="rising", action="stop").build()
    assert built == scene_from_dict(bead)


@pytest.mark.parametrize(
    ("event", "problem"),
    [
        ({"when": "at - 2"}, r"events\.there\.when: never changes, so that it passes zero nowhere"),
        ({"when": "y - 2"}, r"events\.there\.when: column 1: unknown name 'y'"),
        ({"when": "x -"}, r"events\.there\.when: column 4: the formula ends"),
        ({"when": "x", "action": "halt"}, r"action: the text 'halt' stands where one of 'record'"),
        ({"when": "x", "direction": "up"}, r"direction: the text 'up' stands where one of 'both'"),
        ({"if": "x"}, r"events\.there\.when: is missing"),
        ("x - 1", r"a table is wanted, such as \{ when = "),
    ],
)
def test_what_is_no_event_is_refused(bead: Tree, event: object, problem: str) -> None:
    bead["events"]["there"] = event
    with pytest.raises(SceneError, match=problem):
        scene_from_dict(bead)


def test_a_linkage_of_nodes_has_no_events(bead: Tree) -> None:
    nodes = {"A": {"at": [0, 0], "fixed": True}, "B": {"at": [1, 0]}}
    links = {"a": {"nodes": ["A", "B"]}}
    turn = {"turn": {"link": "a", "about": "A"}}
    tree = {"name": "arm", "unit": "m", "nodes": nodes, "links": links, "inputs": turn}
    with pytest.raises(SceneError, match="events: belong to bodies"):
        scene_from_dict(tree | {"events": {"late": {"when": "t - 1"}}})


@pytest.mark.parametrize(
    ("when", "is_told"),
    [
        ("sign(x - 5)", True),
        ("1/x", True),
        ("tan(x)", True),
        ("x^(0-1)", True),
        ("1 + atan2(x_dot, x)", True),
        ("x - 5", False),
        ("sin(x)/at", False),
        ("at^(0-2)*x", False),
        ("tan(at)*x", False),
        ("x/(2 + sin(t))", False),
        ("atan2(sin(t), 2 + cos(t)) - x", False),
        ("max(x, 0) - abs(x)^3", False),
    ],
)
def test_an_event_that_may_jump_is_told(bead: Tree, when: str, *, is_told: bool) -> None:
    bead["events"] = {"other": {"when": "t - 1"}, "hit": {"when": when}}
    notes = About.of(scene_from_dict(bead)).notes
    assert [note.split(" over")[0] for note in notes] == ["events.hit may jump"] * is_told


def test_events_are_the_first_functions_whose_roots_are_looked_for(bead: Tree) -> None:
    bead["events"]["late"] = {"when": "max(t, 1) - sign(x)"}
    bead["forces"] = {"wall": {"type": "along", "coordinate": "x", "force": "max(0, -x)"}}
    functions = root_functions_of(system_of(scene_from_dict(bead), ()))
    formulas = [
        parse_expression(text, ("t", "x", "at")) for text in ("x - at", "max(t, 1) - sign(x)")
    ]
    assert [*functions.crossings[:2]] == formulas
    assert functions.jumps == (False, True)


def test_all_that_a_scene_may_say_of_an_event_is_known_to_runs() -> None:
    assert set(get_args(Direction)) == set(DIRECTIONS)
    assert set(get_args(Action)) == set(ACTIONS)
