"""Forces and gravity of a scene as those of a system."""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING

from kousoku.model.elements.force import Lowering
from kousoku.model.elements.forces import FORCES
from kousoku.model.expressions.formulas import used_coordinates
from kousoku.model.mechanics.frames import to_vector
from kousoku.model.numbers import precise

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.mechanics.frames import BodyFrame
    from kousoku.model.mechanics.multibody import ForceElement
    from kousoku.model.numbers.precise import High
    from kousoku.model.records.orientation import Vector
    from kousoku.model.records.scene import Scene


def force_elements(
    scene: Scene, frames: Mapping[str, BodyFrame], coordinates: CoordinateList, unit: High
) -> tuple[ForceElement, ...]:
    """Forces of a checked scene as elements; a bushing is several.

    Parameters
    ----------
    scene : Scene
        A checked scene.
    frames : mapping of str to BodyFrame
        Of all bodies and the ground.
    coordinates : CoordinateList
        Coordinates that the forces need are added to it.
    unit : number [m]
        The unit of the scene.
    """
    lowering = Lowering(scene, frames, coordinates, unit)
    elements = [
        element
        for name, force in scene.forces.items()
        for element in FORCES[force.type].elements(name, force, lowering)
    ]
    texts = chain.from_iterable(element.formulas for element in elements)
    for name in used_coordinates(scene, (text for _, text in texts)):
        coordinates.index_of(name)
    return tuple(elements)


def gravity_of(scene: Scene, unit: High) -> Vector:
    """Acceleration of free fall (3,) [m/s²], frame O; zero where it is a formula."""
    x, y, z = (0.0 if isinstance(value, str) else value for value in scene.gravity)
    return to_vector(precise.scale(unit, precise.triple((x, y, z))))


def gravity_law(scene: Scene) -> tuple[str, str, str]:
    """Components of gravity that are formulas; the others are empty."""
    x, y, z = (value if isinstance(value, str) else "" for value in scene.gravity)
    return x, y, z
