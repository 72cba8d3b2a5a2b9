"""Heights of points, and values of coordinates, at the start."""

from __future__ import annotations

import pytest

from kousoku.codegen.dynamics.operations.heights import at_start
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.read import scene_from_toml

SCENE = """
name = "point"
unit = "m"
bodies.b = { point = true, position = [2, 3, 5], mass = 1 }
coordinates.u = { body = "b", along = ALONG }
forces.f = { type = "along", coordinate = "u", force = "-u" }
"""


@pytest.mark.parametrize(("along", "value"), [([1, 0, 0], 2), ([0, 1, 0], 3), ([0, 0, 1], 5)])
def test_a_place_is_measured_from_where_the_ground_is(along: list[int], value: float) -> None:
    system = system_of(scene_from_toml(SCENE.replace("ALONG", str(along))))
    assert at_start(system, system.coordinates[0]) == value
