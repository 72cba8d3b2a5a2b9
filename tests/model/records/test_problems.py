"""All problems of a scene at once: each with its line, and none that only follows from another."""

from __future__ import annotations

import json
from typing import Any, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kousoku.model.errors import MOST_FOUND, MOST_SHOWN, Problem, SceneError
from kousoku.model.reading.read import scene_from_dict, scene_from_toml
from kousoku.model.records.problems import Problems

GOOD = """\
name = "five_bar"
unit = "cm"
title = "Two cranks"
divisions = 60

[nodes]
A = { at = [0, 0], fixed = true }
B = { at = [0, 20] }
C = { at = [35, 40] }
D = { at = [60, 30] }
E = { at = [60, 0], fixed = true }
P = { at = [10, 45] }

[links.ab] # a crank
nodes = ["A", "B"]
[links.bc]
nodes = ["B", "C"]
length = 45
[links.cd]
nodes = [
    "C",
    "D",
]
length = 40
[links]
de = { nodes = ["D", "E"] }
bp = { nodes = ["B", "P"], length = 26 }
cp = { nodes = ["C", "P"], length = 26 }

[inputs]
alpha = { link = "ab", about = "A", turns = 0.1 }
beta = { link = "de", about = "E", turns = 0.1 }
"""


class Fault(NamedTuple):
    """A mistake in GOOD: what is written instead, and the problem that it is."""

    old: str
    new: str
    line: int
    key: str
    breaks: str = ""
    uses: tuple[str, ...] = ()


FAULTS = [
    Fault('"five_bar"', '"five bar"', 1, "name"),
    Fault('"cm"', '"cubit"', 2, "unit"),
    Fault('"Two cranks"', '"\\u202e"', 3, "title"),
    Fault("60\n\n", "0\n\n", 4, "divisions"),
    Fault("divisions = 60", "divisons = 60", 4, "divisons"),
    Fault("[0, 20]", "[0, nan]", 8, "nodes.B.at[1]", "B"),
    Fault("P = { at", "P = { att", 12, "nodes.P.att", "P"),
    Fault('["A", "B"]', '["A", "X"]', 15, "links.ab.nodes", "ab", ()),
    Fault("length = 45", 'length = "45"', 18, "links.bc.length", "bc"),
    Fault('    "D",\n', '    "C",\n', 19, "links.cd", "cd", ("C",)),
    Fault("length = 40", "length = -40", 24, "links.cd.length", "cd"),
    Fault("26 }\ncp", "26, color = 1 }\ncp", 27, "links.bp.color", "bp"),
    Fault("cp =", "int =", 28, "links", "int"),
    Fault('about = "A"', 'about = "C"', 31, "inputs.alpha.about", "alpha", ("ab", "B")),
    Fault('link = "de"', 'link = "ed"', 32, "inputs.beta.link", "beta"),
    Fault('about = "E", turns = 0.1', 'about = "E", turns = 1e9', 32, "inputs.beta.turns", "beta"),
]


def with_faults(faults: list[Fault]) -> str:
    text = GOOD
    for fault in faults:
        assert text.count(fault.old) == 1, fault
        text = text.replace(fault.old, fault.new)
    return text


def problems_of(text: str) -> list[tuple[int, str]]:
    with pytest.raises(SceneError) as caught:
        scene_from_toml(text, file="five_bar.toml")
    return [(problem.line, problem.key) for problem in caught.value.problems]


def test_without_faults_the_scene_is_valid() -> None:
    assert scene_from_toml(GOOD).divisions == 60


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.key)
def test_one_mistake_is_one_problem(fault: Fault) -> None:
    assert problems_of(with_faults([fault])) == [(fault.line, fault.key)]


@settings(max_examples=200, deadline=None)
@given(st.lists(st.sampled_from(FAULTS), min_size=2, unique_by=lambda fault: fault.line))
def test_several_mistakes_are_all_reported_and_nothing_else(faults: list[Fault]) -> None:
    """What is wrong with a part that depends on a broken one may wait."""
    text = GOOD
    taken: list[Fault] = []
    for fault in faults:
        if text.count(fault.old) == 1:
            text, taken = text.replace(fault.old, fault.new), [*taken, fault]
    broken = {fault.breaks for fault in taken}
    if any(fault.key in {"divisions", "divisons"} for fault in taken):
        taken = [fault for fault in taken if fault.key != "inputs.beta.turns"]
    certain = {(f.line, f.key) for f in taken if not broken & set(f.uses)}
    possible = {(f.line, f.key) for f in taken}
    found = problems_of(text)
    assert [line for line, _ in found] == sorted(line for line, _ in found)
    assert certain <= set(found) <= possible
    assert len(set(found)) == len(found)


def test_the_message_has_a_line_for_each_problem_in_the_order_of_the_file() -> None:
    faults = [FAULTS[k] for k in (13, 0, 8)]
    with pytest.raises(SceneError) as caught:
        scene_from_toml(with_faults(faults), file="five_bar.toml")
    first, second, third = str(caught.value).splitlines()
    assert first.startswith("five_bar.toml:1: name: 'five bar' is not a name")
    assert second.startswith("five_bar.toml:18: links.bc.length: the text '45' stands where")
    assert third.startswith("five_bar.toml:31: inputs.alpha.about: 'C' is no end of it")
    error = caught.value
    assert (error.file, error.key) == ("five_bar.toml", "name")
    assert error.problem == error.problems[0].problem


def test_without_a_file_lines_are_named_and_without_a_text_there_are_none() -> None:
    with pytest.raises(SceneError, match=r"\nline 2: unit: the text 'x' stands"):
        scene_from_toml('name = "a"\nunit = "x"')
    with pytest.raises(
        SceneError, match=r"^name: is missing.*\nunit: is missing.*\nhas no mechanism: "
    ):
        scene_from_dict({})


SPATIAL = """\
name = "chain"
unit = "m"

[bodies]
arm = { position = [0, 0, 0], mass = 1, inertia = { xx = 1, yy = 1, zz = 1 } }
hand = { position = [1, 0, 0], mass = 1, inertia = { xx = 1, yy = 1, zz = 1 } }

[joints]
shoulder = { type = "revolute", bodies = ["ground", "arm"], at = [0, 0, 0], axis = [0, 0, 1] }
wrist = { type = "revolute", bodies = ["arm", "hand"], at = [1, 0, 0], axis = [0, 1, 0] }
"""


@pytest.mark.parametrize(
    ("changes", "found"),
    [
        ({}, []),
        ({"position = [1, 0, 0]": "position = [1, 0]"}, [(6, "bodies.hand.position")]),
        ({'"arm", "hand"': '"arm", "hnad"'}, [(10, "joints.wrist.bodies[1]")]),
        ({"[bodies]": "[bodeis]"}, [(4, "bodeis")]),
        ({"[joints]": "[jonits]"}, [(8, "jonits")]),
        (
            {"arm = { position = [0, 0, 0], mass = 1": "arm = { position = [0, 0, 0], mass = -1"},
            [(5, "bodies.arm.mass")],
        ),
        (
            {"[1, 0, 0], mass = 1": "[1, 0, 0], mass = 0", "axis = [0, 0, 1]": "axis = [0, 0, 0]"},
            [(6, "bodies.hand.mass"), (9, "joints.shoulder.axis")],
        ),
        (
            {
                '"m"': '"ell"',
                "axis = [0, 0, 1]": "axis = 1",
                '"revolute", bodies = ["a': '"x", bodies = ["a',
            },
            [(2, "unit"), (9, "joints.shoulder.axis"), (10, "joints.wrist.type")],
        ),
        (
            {"[joints]": "[nodes]\nA = { at = [0, 0] }\n[joints]", "hand =": "ground ="},
            [(6, "bodies.ground"), (8, "nodes"), (12, "joints.wrist.bodies[1]")],
        ),
    ],
)
def test_problems_of_bodies_and_joints_are_all_reported(
    changes: dict[str, str], found: list[tuple[int, str]]
) -> None:
    text = SPATIAL
    for old, new in changes.items():
        assert text.count(old) == 1
        text = text.replace(old, new)
    if found:
        assert problems_of(text) == found
    else:
        assert scene_from_toml(text).is_spatial


def test_a_missing_key_is_reported_at_its_table() -> None:
    text = GOOD.replace("{ at = [35, 40] }", "{ fixed = false }")
    assert problems_of(text) == [(9, "nodes.C.at")]


def test_several_mistakes_in_one_element_are_all_reported() -> None:
    text = GOOD.replace('cp = { nodes = ["C", "P"], length = 26 }', "cp = { length = true, x = 1 }")
    keys = ["links.cp.x", "links.cp.nodes", "links.cp.length"]
    assert problems_of(text) == [(28, key) for key in keys]


def test_all_that_is_wrong_with_a_body_a_joint_and_a_driver_is_reported() -> None:
    text = SPATIAL.replace(
        "mass = 1, inertia = { xx = 1, yy = 1", "mass = -1, inertia = { xx = 1, yy = 9"
    )
    text = text.replace(
        "at = [0, 0, 0], axis = [0, 0, 1]",
        "points = [[0, 0, 0], [0, 0, 0]], axes = [[0, 0, 0], [0, 0, 0]]",
    )
    text += """
[bodies.rod]
position = [0, 0, 0]
rods = [{ mass = 0, ends = [[0, 0, 0], [0, 0, 0]] }, { mass = -1, ends = [[0, 0, 0], [1, 0, 0]] }]
[drivers.tip]
body = "hnad"
path = ["abs(t)", "t", "log(t)"]
"""
    bodies = [f"bodies.{name}.{key}" for name in ("arm", "hand") for key in ("mass", "inertia")]
    joint = [f"joints.shoulder.axes[{k}]" for k in (0, 1)]
    rods = [f"bodies.rod.rods[{place}" for place in ("0].mass", "0].ends", "1].mass")]
    driver = [f"drivers.tip.{key}" for key in ("body", "path[0]", "path[2]")]
    assert [key for _, key in problems_of(text)] == bodies + joint + rods + driver


def test_a_parameter_that_is_wrong_hides_no_driver_of_what_is_not_there() -> None:
    wrong = SPATIAL + '[parameters]\nk = true\n[drivers.d]\njoint = "shuolder"\nvalue = "k * t"\n'
    assert [key for _, key in problems_of(wrong)] == ["parameters.k", "drivers.d.joint"]


def test_a_table_that_is_misspelt_is_not_missing_too() -> None:
    assert problems_of(GOOD.replace("[nodes]", "[nods]")) == [(6, "nods")]


def test_a_name_that_is_none_stands_in_no_other_message(lever: dict[str, Any]) -> None:
    lever["nodes"]["a\nb"] = {"at": [1, 1]}
    lever["links"]["x"] = {"nodes": ["a\nb", "a\nb"]}
    with pytest.raises(SceneError) as caught:
        scene_from_dict(lever)
    assert [problem.key for problem in caught.value.problems] == ["nodes"]


def test_very_many_problems_are_counted(lever: dict[str, Any]) -> None:
    for k in range(100):
        lever["nodes"][f"n{k}"] = {"at": k}
    with pytest.raises(SceneError) as caught:
        scene_from_dict(lever, file="a.toml")
    lines = str(caught.value).splitlines()
    assert len(caught.value.problems) == 100
    assert len(lines) == MOST_SHOWN + 1
    assert lines[-1] == "a.toml: and 80 more problems"


def test_after_very_many_problems_no_more_are_looked_for(lever: dict[str, Any]) -> None:
    for k in range(10_000):
        lever["nodes"][f"n{k}"] = {"att": k, "aat": k}
    for k in range(1900):
        lever["links"][f"m{k}"] = {"nodes": ["X", "Y"]}
    with pytest.raises(SceneError) as caught:
        scene_from_dict(lever)
    count = len(caught.value.problems)
    assert MOST_FOUND <= count < MOST_FOUND + 10
    assert str(caught.value).endswith(f"\nand at least {count - MOST_SHOWN} more problems")


def test_a_check_of_what_is_broken_is_left_out_and_breaks_what_it_checks() -> None:
    def fail(key: str) -> None:
        raise SceneError("is wrong", key=key)

    problems = Problems()
    problems.check("links.a", ["links.a", "nodes.A"], fail, "links.a.length")
    problems.check("inputs.x", ["inputs.x", "links.a"], fail, "inputs.x")
    problems.check("inputs.y", ["inputs.x"], fail, "inputs.y")
    assert problems.found == [Problem("is wrong", "links.a.length")]
    assert problems.is_broken("inputs.y")
    assert problems.touches("inputs")
    assert not problems.is_broken("links.b")
    problems.break_("links")
    assert problems.is_broken("links.b")


def test_a_problem_is_one_line_whatever_marks_a_name_has() -> None:
    joint = {"type": "ball", "bodies": ["a\x1f\n", "a\x1f\n"], "at": [0, 0, 0]}
    tree = {"name": "x", "unit": "m", "bodies": {"b": {"position": [0, 0, 0]}}, "joints": {}}
    tree["joints"] = {"j": joint}
    with pytest.raises(SceneError) as caught:
        scene_from_dict(tree)
    first, *_ = str(caught.value).split("\n")
    assert first == "joints.j.bodies: connects a\\x1f\\n to itself; wanted two different bodies"
    assert len(str(caught.value).split("\n")) == len(caught.value.problems)


@pytest.mark.parametrize("table", ["joints", "forces", "coordinates"])
def test_a_name_that_is_nearly_that_of_a_broken_element_is_found(table: str) -> None:
    """The crank has two components of its place; it is there nevertheless, and not named twice."""
    tree: dict[str, Any] = {
        "name": "x",
        "unit": "m",
        "bodies": {"crank": {"position": [0, 0]}, "rod": {"position": [0, 0, 0]}},
    }
    uses: dict[str, dict[str, Any]] = {
        "joints": {"type": "ball", "bodies": ["{}", "rod"], "at": [0, 0, 0]},
        "forces": {"type": "force", "body": "{}", "force": [0, 0, 1]},
        "coordinates": {"body": "{}", "along": [0, 0, 1]},
    }
    text = json.dumps(uses[table])
    for name, found in (("crnk", 2), ("crank", 1)):
        with pytest.raises(SceneError) as caught:
            scene_from_dict(tree | {table: {"a": json.loads(text.replace("{}", name))}})
        problems = [one.problem for one in caught.value.problems]
        assert len(problems) == found
        assert problems[1:] in ([], ["unknown body 'crnk'; did you mean 'crank'?"])


def test_a_broken_body_hides_no_body_that_is_not_there() -> None:
    bodies = {"bar": {"position": [0, 0]}}
    joints = {"a": {"type": "ball", "bodies": ["groun", "bar"], "at": [0, 0, 0]}}
    tree = {"name": "x", "unit": "m", "bodies": bodies, "joints": joints}
    with pytest.raises(SceneError) as caught:
        scene_from_dict(tree)
    _, told = (one.problem for one in caught.value.problems)
    assert told == "unknown body 'groun'; did you mean 'ground'?"


def test_the_names_of_broken_elements_are_listed() -> None:
    nodes = {"A": {"at": [0, 0], "fixed": True}, "B": {"at": [0]}}
    tree = {"name": "x", "unit": "m", "nodes": nodes, "links": {"l": {"nodes": ["A", "Q"]}}}
    with pytest.raises(SceneError, match=r"links\.l\.nodes: unknown node 'Q'; known here: A, B$"):
        scene_from_dict(tree)


def test_a_type_is_no_name_of_a_broken_element() -> None:
    broken = {"type": "ball", "bodies": ["ground", "rod"], "at": [0, 0]}
    tree = {"name": "x", "unit": "m", "bodies": {"rod": {"position": [0, 0, 0]}}}
    joints = {"ballzz": broken, "a": broken | {"type": "ballz", "at": [0, 0, 0]}}
    with pytest.raises(SceneError) as caught:
        scene_from_dict(tree | {"joints": joints})
    (told,) = (one.problem for one in caught.value.problems if one.key == "joints.a.type")
    assert told == (
        "unknown joint 'ballz'; did you mean 'ball'? A kind of your own comes with kinds=[...], see"
        " docs/own_kind.md"
    )
