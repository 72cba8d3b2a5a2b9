"""Degrees in scene files: each angle may be written in them, and is written back so."""

from __future__ import annotations

import math

import pytest

from kousoku.model.errors import SceneError
from kousoku.model.lowering.quaternions import quaternion
from kousoku.model.numbers.precise import number
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import scene_from_toml
from kousoku.model.reading.write import to_toml

ARM = """
name = "arm"
unit = "m"

[parameters]
lift = "20 deg"

[bodies.bar]
position = [0, 0, 0]
orientation = { angles = ["90 deg", 0, "-pi/4"], sequence = "zxz", about = "body" }
angular_velocity = [0, 0, "60 deg"]
mass = 1
inertia = { xx = 1, yy = 1, zz = 1 }

[joints.a]
type = "revolute"
bodies = ["ground", "bar"]
at = [0, 0, 0]
axis = ["sin(30 deg)", 0, "cos(30 deg)"]

[coordinates]
swing = { joint = "a", near = "15 deg" }

[forces.rubber]
type = "rotational_spring_damper"
coordinate = "swing"
stiffness = 3
free_angle = "10 deg + lift"
"""


def test_every_angle_may_be_in_degrees_and_is_written_back_as_it_was() -> None:
    scene = scene_from_toml(ARM)
    body = scene.bodies["bar"]
    assert body.orientation is not None
    assert body.orientation.angles == (math.pi / 2, 0, -math.pi / 4)
    assert list(body.angular_velocity or ()) == [0, 0, pytest.approx(math.pi / 3)]
    assert scene.parameters["lift"] == pytest.approx(math.pi / 9)
    assert scene.coordinates["swing"].near == pytest.approx(math.pi / 12)
    axis = scene.joints["a"].axis or ()
    assert [float(one) for one in axis] == pytest.approx([0.5, 0, math.sqrt(0.75)])
    text = to_toml(scene)
    assert scene_from_toml(text) == scene
    assert to_toml(scene_from_toml(text)) == text
    for written in ('"90 deg"', '"-pi/4"', '"60 deg"', 'lift = "20 deg"', 'near = "15 deg"'):
        assert written in text


def test_a_right_angle_in_degrees_is_one_in_fifty_digits() -> None:
    orientation = scene_from_toml(ARM.replace('"-pi/4"', "0")).bodies["bar"].orientation
    w, x, y, z = quaternion(orientation)
    assert (x, y) == (0, 0)
    assert abs(w - z) < 1e-49
    assert abs(number(math.pi / 2) / 2 - number(0.25) * number(math.pi)) == 0


def test_an_input_of_a_link_and_of_a_rigid_connection_take_degrees() -> None:
    scene = (
        SceneBuilder("crank", unit="m")
        .node("A", at=(0, 0), fixed=True)
        .node("B", at=(1, 0))
        .node("C", at=(1, 1))
        .link("ab", "A", "B")
        .link("bc", "B", "C")
        .rigid("corner", at="B", links=("ab", "bc"), angle="-90 deg")
        .input("alpha", link="ab", about="A", start="30 deg", to="90 deg", rate="6 deg")
        .build()
    )
    given = scene.inputs["alpha"]
    wanted = pytest.approx((math.pi / 6, math.pi / 2, math.pi / 30))
    assert (given.start, given.to, given.rate) == wanted
    assert scene.rigid["corner"].angle == -math.pi / 2
    assert scene_from_toml(to_toml(scene)) == scene


def test_a_displacement_is_no_angle() -> None:
    piston = (
        SceneBuilder("piston", unit="m")
        .node("A", at=(0, 0))
        .node("B", at=(1, 1))
        .link("ab", "A", "B")
        .slider("s", node="A", through=(0, 0), direction=(1, 0))
        .slider("r", node="B", through=(0, 1), direction=(1, 0))
        .input("x", slider="s", start="30 deg", to=2)
    )
    with pytest.raises(SceneError, match=r"inputs\.x\.from: is an angle; .* a displacement"):
        piston.build()
    with pytest.raises(SceneError, match=r"coordinates\.swing\.near: is an angle; .* distance"):
        scene_from_toml(
            ARM.replace('joint = "a", ', 'body = "bar", along = [1, 0, 0], hold = true, ')
        )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"90 deg"', '"90 degree"', r"angles\[0\]: the text '90 degree' is no number and no angle"),
        ('"60 deg"', '"60 deg/s"', r"angular_velocity\[2\]: .* per second is understood"),
        ('"15 deg"', '"lift"', r"near: the text 'lift' is no number and no angle.*no formula may"),
        ("mass = 1", 'mass = "5 degrees"', r"mass: column 3: 'degrees' stands where an operator"),
        ('lift = "20 deg"', 'lift = "1e60 deg"', r"parameters\.lift: .* is too large"),
    ],
)
def test_a_text_that_is_no_angle_is_refused_with_its_key(old: str, new: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        scene_from_toml(ARM.replace(old, new))
