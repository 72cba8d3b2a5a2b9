"""The builder gives what a file gives, and checks as a file is checked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kousoku.model.builder import SceneBuilder
from kousoku.model.errors import SceneError
from kousoku.model.read import read_scene

SCENES = Path(__file__).parents[2] / "scenes"


def lever() -> SceneBuilder:
    """Return the lever crank of the paper, step by step."""
    return (
        SceneBuilder(
            "lever_crank", unit="cm", title="Lever crank, Yamada and Tatsumi 1981, figure 6"
        )
        .node("O1", at=(0, 0), fixed=True)
        .node("O2", at=(30, 0))
        .node("O3", at=(45, 58))
        .node("O4", at=(100, 0), fixed=True)
        .link("l1", "O1", "O2", length=30)
        .link("l2", "O2", "O3", length=60)
        .link("l3", "O3", "O4", length=80)
        .link("l4", "O4", "O1", length=100)
        .input("alpha", link="l1", about="O1", turns=1)
        .method(residual=1e-13)
    )


def test_the_paper_lever_crank_is_the_same_from_python() -> None:
    assert lever().build() == read_scene(SCENES / "lever_crank.toml")


def test_every_element_has_a_call() -> None:
    scene = (
        SceneBuilder("all", unit="in", divisions=12)
        .node("A", at=np.array([0.0, 0.0]), fixed=True)
        .node("B", at=(np.float64(1), 0))
        .node("C", at=(1, 1))
        .node("S", at=(3, 0))
        .link("ab", "A", "B")
        .link("bc", "B", "C")
        .link("bs", "B", "S", length=np.float64(2))
        .rigid("corner", at="B", links=("ab", "bc"), angle=-1)
        .slider("s", node="S", through=(0, 0), direction=(1, 0))
        .input("alpha", link="ab", about="A", start=0.5, turns=-1, rate=-2, acceleration=0.25)
        .outputs("velocities", "angles")
        .method(scheme="paper", iterations=9)
        .build()
    )
    assert scene.rigid["corner"].angle == -1
    assert scene.sliders["s"].direction == (1, 0)
    assert scene.inputs["alpha"].acceleration == 0.25
    assert scene.outputs == ("velocities", "angles")
    assert (scene.method.scheme, scene.method.iterations) == ("paper", 9)


def test_spatial_scenes_are_built_from_the_keys_of_the_records() -> None:
    scene = (
        SceneBuilder("pendulum", unit="m")
        .body("bar", position=(0, 0, 0), orientation={"quaternion": (1, 0, 0, 1), "order": "wxyz"})
        .joint(
            "a",
            type="revolute",
            bodies=("ground", "bar"),
            points=np.zeros((2, 3)),
            axes=np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]),
        )
        .input("alpha", joint="a")
        .build()
    )
    assert scene.joints["a"].axes == ((0, 0, 1), (0, 0, 1))


def test_gravity_may_come_out_of_an_array() -> None:
    scene = SceneBuilder("stone", unit="m").gravity(*np.array([0, 0.5, -9.81]))
    built = scene.body("stone", position=(0, 0, 0), point=True, mass=1).build()
    assert built.gravity == (0.0, 0.5, -9.81)


def test_a_name_given_twice_is_refused_at_once() -> None:
    with pytest.raises(SceneError, match=r"nodes\.O2: the name 'O2' is given twice"):
        lever().node("O2", at=(1, 1))


@pytest.mark.parametrize("length", ["30", "2*15", float("nan"), 0, -1, True])
def test_lengths_that_are_no_lengths_are_refused_as_in_a_file(length: float) -> None:
    with pytest.raises(SceneError, match=r"^links\.l5\.length: "):
        lever().link("l5", "O1", "O3", length=length).build()


def test_a_scene_that_was_built_does_not_change_with_its_builder() -> None:
    builder = lever()
    scene = builder.build()
    builder.node("P", at=(1, 1))
    assert "P" not in scene.nodes


def test_drivers_coordinates_and_parameters_have_a_call() -> None:
    nut = read_scene(SCENES / "falling_nut.toml")
    built = (
        SceneBuilder("falling_nut", unit="m", title=nut.title)
        .gravity(0, 0, -9.80665)
        .outputs("velocities", "coordinates", "reactions", "energies")
        .body(
            "nut",
            position=(0, 0, 0),
            mass=2,
            inertia={"xx": 0.0015, "yy": 0.0015, "zz": np.float64(0.001)},
        )
        .joint(
            "thread",
            type="screw",
            bodies=("ground", "nut"),
            at=(0, 0, 0),
            axis=(0, 0, 1),
            pitch=0.1,
        )
        .coordinate("height", body="nut", along=np.array([0, 0, 1]))
        .coordinate("turned", joint="thread", of="angle")
    )
    assert built.build() == nut
    driven = built.parameter("speed", np.float64(2)).driver(
        "motor", coordinate="turned", value="speed*t"
    )
    scene = driven.build()
    assert (scene.parameters, scene.drivers["motor"].value) == ({"speed": 2}, "speed*t")
    with pytest.raises(SceneError, match=r"parameters\.speed: the name 'speed' is given twice"):
        built.parameter("speed", 3)
