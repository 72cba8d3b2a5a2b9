"""Directions from which angles and displacements count, beside an axis that is given in frame O."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.errors import Problem, SceneError
from kousoku.model.mechanics.frames import joint_axes
from kousoku.model.numbers import precise
from kousoku.model.validation.spatial import PARALLEL

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.mechanics.frames import BodyFrame
    from kousoku.model.records.scene import Scene


def check_zero_directions(scene: Scene, frames: Mapping[str, BodyFrame]) -> None:
    """Refuse zero directions along the axis, which is in the bodies as they are written.

    Parameters
    ----------
    scene : Scene
        A checked scene.
    frames : mapping of str to BodyFrame
        Of all bodies and the ground.

    Raises
    ------
    SceneError
        Directions are parallel to the axes of their joints: all of them.
    """
    problems = []
    for name, joint in scene.joints.items():
        if joint.zero is None or joint.axis is None:
            continue
        ends = frames[joint.ends[0]], frames[joint.ends[1]]
        axes = joint_axes(ends, joint)
        for k, (end, direction, axis) in enumerate(zip(ends, joint.zero, axes, strict=True)):
            zero = precise.unit(precise.triple(direction))
            if not precise.length(precise.cross(end.principal(zero), axis)) > PARALLEL:
                problem = "is parallel to the axis; wanted a direction across it"
                problems.append(Problem(problem, f"joints.{name}.zero[{k}]"))
    if problems:
        raise SceneError.of(problems)
