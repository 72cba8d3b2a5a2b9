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
    """Constraints that hold components of the position of a body, and of its velocity.

    A coordinate of its origin is n2 with an axis of frame O, the orientation is p1 and n1 as in a
    fixed joint; their rates hold velocities too.
    """
    if not body.hold:
        return [], []
    key = f"bodies.{name}.hold"
    rows = {axis: _coordinate(key, axis, frame, unit) for axis in DIRECTIONS}
    turns = _orientation(key, frame) if TURNS & set(body.hold) else []
    positions = [rows[quantity] for quantity in body.hold if quantity in rows]
    rates: list[Instance] = []
    if "orientation" in body.hold:
        positions += turns
    if "velocity" in body.hold:
        rates += rows.values()
    if "angular_velocity" in body.hold:
        rates += turns
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
    """Coordinates that assembly may not change, as combinations of one term."""
    for name, coordinate in scene.coordinates.items():
        if not coordinate.hold:
            continue
        index = coordinates.index_of(name)
        unit, scale = coordinates.unit_of(index)
        near = coordinates.value(index) if coordinate.near is None else scale * coordinate.near
        held = coordinates.record(index)
        yield Instance(
            f"coordinates.{name}.hold",
            COMBINATION,
            held.i,
            held.j,
            terms=(Term(index, 1.0),),
            offset=0.0 - float(at_scene(near)),
            unit=unit,
        )


def require_kept(system: System) -> None:
    """Refuse held values where parameters move a constraint.

    Raises
    ------
    SceneError
        Assembly takes the numbers of the scene; a run with others could not keep what is held.
    """
    held = (*system.held, *system.held_rates)
    moving = [c.joint for c in system.constraints if held and moved_by_parameters(system, c)]
    if moving:
        raise SceneError(
            "is kept by assembly with the parameters of the scene only, and parameters move what"
            f" {moving[0]} connects; leave it out, or drive the coordinate",
            key=held[0].joint,
        )


def without_held(system: System) -> System:
    """Assembled system as it moves: without values that only assembly holds."""
    needed = len(system.coordinates) - system.only_held
    return replace(
        system, held=(), held_rates=(), coordinates=system.coordinates[:needed], only_held=0
    )
