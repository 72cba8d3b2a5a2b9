"""What is told of a scene of bodies when its solver is generated."""

from __future__ import annotations

import pytest

from kousoku.codegen.dynamics.generate import compose_scene
from kousoku.model.reading.read import scene_from_toml

SPRING = """
name = "pushed_apart"
unit = "mm"
[bodies.block]
mass = 1
position = [PLACE, 0, 0]
inertia = { xx = 1, yy = 1, zz = 1 }
[coordinates]
way = { bodies = ["ground", "block"], points = [[0, 0, 0], [0, 0, 0]] }
[forces.pusher]
"""
POINTS = 'type = "spring_damper"\nbodies = ["ground", "block"]\npoints = [[0, 0, 0], [0, 0, 0]]\n'
LAWS = {
    "a spring": POINTS + "stiffness = 10\nfree_length = 1\n",
    "a law": POINTS + 'tension = "10*x"\nfree_length = 1\n',
    "a coordinate": 'type = "along"\ncoordinate = "way"\nforce = "10*(1 - way)"\n',
}


def notes(force: str, place: str = "0") -> list[str]:
    scene = scene_from_toml(SPRING.replace("PLACE", place) + force)
    return [note for note in compose_scene(scene, ()).about.notes if "no direction" in note]


@pytest.mark.parametrize("force", LAWS.values(), ids=LAWS)
def test_force_between_points_in_one_place_is_told(force: str) -> None:
    (note,) = notes(force)

    assert note.startswith("forces.pusher: its ends are in one place at the start")
    assert not notes(force, "1e-3")


@pytest.mark.parametrize(("reach", "count"), [(0, 1), (1, 0)])
def test_ends_that_depend_on_parameters_are_those_of_the_scene(reach: int, count: int) -> None:
    points = POINTS.replace("[0, 0, 0]]", '["reach", 0, 0]]')
    law = f"{points}stiffness = 10\nfree_length = 1\n[parameters]\nreach = {reach}\n"

    assert len(notes(law)) == count


def test_spring_that_pulls_its_ends_together_is_at_rest_there() -> None:
    assert not notes(POINTS + "stiffness = 10\nfree_length = 0\n")
