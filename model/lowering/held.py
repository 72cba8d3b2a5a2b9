"""Values that assembly may not change, as constraints between a body and the ground."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from kousoku.model.errors import SceneError
from kousoku.model.lowering.moved import moved_by_parameters
from kousoku.model.mechanics.constraints import COMBINATION
from kousoku.model.mechanics.frames import DIRECTIONS, GROUND_FRAME, joint_vectors, to_vector
from kousoku.model.mechanics.multibody import GROUND_INDEX, Instance, Term
from kousoku.model.mechanics.parallel_rows import variant
from kousoku.model.numbers import precise
from kousoku.model.numbers.precise import ZERO
from kousoku.model.numbers.traced import at_scene

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.mechanics.frames import BodyFrame
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.precise import High
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Body


def held_of(
    name: str, body: Body, frame: BodyFrame, unit: High
) -> tuple[list[Instance], list[Instance]]:
    """Numbers that a body holds of its position, and of its velocity.

    A coordinate of its origin is n2 with an axis of frame O, the orientation is p1 and n1 as in a
    fixed joint; their rates hold velocities too.
    """
    if not body.hold:
        return [], []
    key = f"bodies.{name}.hold"
    places = {axis: _coordinate(key, axis, frame, unit) for axis in DIRECTIONS}
    turning = _orientation(key, frame) if TURNS & set(body.hold) else []
    positions = [places[held] for held in body.hold if held in places]
    rates: list[Instance] = []
    if "orientation" in body.hold:
        positions += turning
    if "velocity" in body.hold:
        rates += places.values()
    if "angular_velocity" in body.hold:
        rates += turning
    return positions, rates


TURNS = {"orientation", "angular_velocity"}


def _coordinate(key: str, axis: str, frame: BodyFrame, unit: High) -> Instance:
    constants = (
        ("a_i_b", DIRECTIONS[axis]),
        ("s_i_b", to_vector(precise.scale(unit, frame.position))),
        ("s_j_b", frame.point(ZERO, unit)),
    )
    return Instance(key, "n2", GROUND_INDEX, frame.index, constants)


def _orientation(key: str, frame: BodyFrame) -> list[Instance]:
    i, j = (
        {name: precise.rounded(vector) for name, vector in vectors.items()}
        for vectors in joint_vectors((GROUND_FRAME, frame))
    )
    axes = (("a_i_b", i["axis"]), ("a_j_b", j["axis"]))
    across = (("a_i_b", i["across"]), ("a_j_b", j["third"]))
    kind = variant("p1", i["axis"])
    return [
        Instance(key, kind, GROUND_INDEX, frame.index, axes),
        Instance(key, "n1", GROUND_INDEX, frame.index, across),
    ]


def held_coordinates(scene: Scene, coordinates: CoordinateList) -> Iterator[Instance]:
    """Coordinates that assembly may not change, as combinations of one of them."""
    for name, given in scene.coordinates.items():
        if not given.hold:
            continue
        place = coordinates.place(name)
        unit, scale = coordinates.unit_of(place)
        near = coordinates.value(place) if given.near is None else scale * given.near
        held = coordinates.record(place)
        yield Instance(
            f"coordinates.{name}.hold",
            COMBINATION,
            held.i,
            held.j,
            terms=(Term(place, 1.0),),
            offset=0.0 - float(at_scene(near)),
            unit=unit,
        )


def require_kept(system: System) -> None:
    """Refuse to hold what parameters move.

    Raises
    ------
    SceneError
        Assembly takes the numbers of the scene; a run with others could not keep what is held.
    """
    held = (*system.held, *system.held_rates)
    moving = [one.joint for one in system.constraints if held and moved_by_parameters(system, one)]
    if moving:
        raise SceneError(
            "is kept by assembly with the parameters of the scene only, and parameters move what"
            f" {moving[0]} connects; leave it out, or drive the coordinate",
            key=held[0].joint,
        )


def without_held(system: System) -> System:
    """Assembled system as it moves: without what only assembly keeps."""
    needed = len(system.coordinates) - system.only_held
    return replace(
        system, held=(), held_rates=(), coordinates=system.coordinates[:needed], only_held=0
    )
