"""Runs whose motion is known, so that no solver is needed to see them."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku import generated
from kousoku.model.reading.read import read_scene, scene_from_dict
from kousoku.runtime.linkage import load_linkage

if TYPE_CHECKING:
    from kousoku.model.records.scene import Scene
    from kousoku.runtime.linkage import Trajectory

#: Of the crank of :func:`turning`, about z.
RATE = 2.0


def arm() -> Scene:
    """Bar of half a metre on a hinge about z, with a radius that is a parameter."""
    bar = {"mass": 1, "radius": "thick", "ends": [[0, 0, 0], [0.5, 0, 0]]}
    return scene_from_dict(
        {
            "name": "arm",
            "title": "An arm on a hinge",
            "unit": "m",
            "gravity": [0, -9.81, 0],
            "parameters": {"thick": 0.03},
            "bodies": {"bar": {"position": [0, 0, 0], "cylinders": [bar]}},
            "joints": {
                "hinge": {
                    "type": "revolute",
                    "bodies": ["ground", "bar"],
                    "at": [0, 0, 0],
                    "axis": [0, 0, 1],
                }
            },
        }
    )


def turning(rows: int = 41, end: float = 2.0, **also: Any) -> Any:
    """Motion of that arm: it turns evenly, and its hinge bears it."""
    time = np.linspace(0.0, end, rows)
    angle = RATE * time
    zero = np.zeros(rows)
    turn = np.stack([np.cos(angle / 2), zero, zero, np.sin(angle / 2)], axis=1)
    run = {
        "time": time,
        "position": {"bar": np.zeros((rows, 3))},
        "orientation": {"bar": turn},
        "velocity": {"bar": np.zeros((rows, 3))},
        "angular_velocity": {"bar": np.tile([0.0, 0.0, RATE], (rows, 1))},
        "force": {"hinge": np.stack([-np.cos(angle), 10.0 - np.sin(angle), zero], axis=1)},
    }
    return Rows(**run | also)


def lever_crank() -> tuple[Trajectory, Scene]:
    """Motion of the linkage that is committed, and its scene."""
    folder = Path(generated.__path__[0]) / "lever_crank"
    scene = Path(__file__).parents[2] / "scenes" / "lever_crank.toml"
    return load_linkage(folder, target="numpy").solve(), read_scene(scene)


class Rows(SimpleNamespace):
    """A run with as many rows as times."""

    def __len__(self) -> int:
        return len(self.time)
