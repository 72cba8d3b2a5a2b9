"""Mistakes that beginners make, each answered with what to write instead."""

from __future__ import annotations

import re

import pytest

from kousoku.model.elements.joints import COUPLINGS, JOINTS, keys_of
from kousoku.model.errors import SceneError
from kousoku.model.reading.lines import twice_given
from kousoku.model.reading.read import scene_from_toml
from kousoku.model.records.spatial import Joint

HEAD = 'name = "arm"\nunit = "m"\n'
BAR = "[bodies.bar]\nposition = [0, 0, 0]\nmass = 1\n"
HINGE = '[joints.a]\ntype = "pin"\nbodies = ["ground", "bar"]\nat = [0, 0, 0]\naxis = [0, 0, 1]\n'
ROUND = "inertia = { xx = 1, yy = 1, zz = 1 }\n"
QUATERNION = '{ quaternion = [1, 0, 0, 0], order = "wxyz" }'


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (BAR + "orientation = [1, 0, 0, 0]\n", f"a list of 4 stands .* such as {QUATERNION}"),
        (BAR + "inertia = [1, 1, 1]\n", "a list of 3 stands .* such as { xx = 1, yy = 1, zz = 1 }"),
        ('[drivers]\nm = { joint = "a", value = speed*t }', 'stands in quotes: "speed*t"'),
        ('[drivers]\nm = { joint = "a", value = 2*t }', 'stands in quotes: "2*t"'),
        ("[drivers.m]\nvalue = -(2 - t)", 'stands in quotes: "-(2 - t)"'),
        ("[drivers.m]\nvalue = " + "(" * 9000, f'stands in quotes: "{"(" * 60}…"'),
        ("[joints.a]\naxis = [r, 0, 1]", 'stands in quotes: "r"'),
        ("[bodies.bar]\npoint = True", "wanted true, in small letters"),
        (BAR + "mass = 2\n", "line 6: bodies.bar.mass: stands in line 5, too; give each key once"),
        (BAR + BAR, "line 6: bodies.bar: stands in line 3, too"),
        ("[bodies]\nbar = { mass = 1, mass = 2 }", "bodies.bar.mass: stands twice in this line"),
        (BAR + "com = [.1, 0, 0]\n", "; write 0.1: a number has a digit before its point"),
        (BAR + "mass = -.5e3\n", "; write -0.5e3: a number has a digit before its point"),
        (
            BAR + 'orientation = { angles = [1, 0, 0], order = "xyz" }\n',
            "'wxyz', 'xyzw' is wanted; it belongs to quaternion: angles have 'sequence'",
        ),
        (
            BAR + "boxes = [{ mass = 1, size = [1, 1, -1] }]\n",
            "an edge of -1.0; wanted",
        ),
        (
            BAR + ROUND + HINGE + '[forces.f]\ntype = "along"\nfoo = 3\n',
            "an along has type",
        ),
        (
            '[bodies."棒"]\nposition = [0, 0, 0]\n',
            "a Latin letter (a-z, A-Z) followed by such letters",
        ),
        ("", "has no mechanism: wanted nodes and links, .* or bodies and joints, .*kousoku new"),
        (
            BAR + ROUND + HINGE + "limits = [0, 1]\n",
            "joints.a.limits: unknown key: joints have no limits and no stops; a pin has type,"
            " bodies, points, at, axes, axis, zero",
        ),
        (
            BAR + ROUND + HINGE + '[forces.rub]\ntype = "friction"\njoint = "a"\nmu = 0.3',
            "forces.rub.mu: unknown key: there is no Coulomb friction; .*sqrt(s_dot^2 + 1e-6)'; a"
            " friction has type, joint, of, damping",
        ),
        (BAR + "colour = 3\n", "unknown key; known here: position, .*, cylinders, spheres$"),
    ],
)
def test_the_message_says_what_to_write(text: str, says: str) -> None:
    pattern = re.escape(says).replace(r"\.\*", ".*").replace(r"\$", "$")
    with pytest.raises(SceneError, match=pattern):
        scene_from_toml(HEAD + text)


@pytest.mark.parametrize("text", ['a = "x', "a = 1.2.3", "= 3", "[a", "a = [[1]"])
def test_what_is_no_formula_gets_no_hint_and_is_refused(text: str) -> None:
    with pytest.raises(SceneError, match="is not valid TOML") as caught:
        scene_from_toml(text)
    assert "quotes" not in str(caught.value)


@pytest.mark.parametrize("text", ["a", "a = {", "[[", "a.b = [", '"', "a = 1\nb = {c = 1, \n"])
def test_a_key_is_looked_for_in_any_text(text: str) -> None:
    assert twice_given(text) is None


def test_the_keys_of_a_joint_are_keys_of_the_record() -> None:
    fields = set(Joint.__struct_fields__) - {Joint.FLAT}
    named: set[str] = set()
    for kind in (*JOINTS, *COUPLINGS):
        assert set(keys_of(kind)) <= fields, kind
        named |= set(keys_of(kind))
    assert named == fields
    assert keys_of("hook") == ()
