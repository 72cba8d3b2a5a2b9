"""Directions of the reactions of the ground on a part of a system, in any position.

A row between the ground and a body has a force and a moment whose directions follow from its kind
and from points and axes of the ground. Directions at some positions only do not count, but all rows
are met: a point on a line is there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.elements.constraints import (
    ANYTHING,
    CONSTRAINT_FACETS,
    GroundReaction,
    RelativeMotion,
    held_by,
)
from kousoku.codegen.dynamics.elements.force_facets import facets_of
from kousoku.model.mechanics.constraints import base_of, kind_of
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.numbers import precise
from kousoku.model.numbers.varying import is_varying
from kousoku.model.records.own_kind import is_own

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from kousoku.codegen.dynamics.elements.facets import Source
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.precise import Triple
    from kousoku.model.records.orientation import Vector

    Numbers = tuple[float, ...]

COINCIDENCE_TOLERANCE = 1e-9
"""Angle [rad] below which vectors are parallel, relative distance below which points coincide."""


def ground_reactions_of(system: System) -> Iterator[tuple[int, GroundReaction]]:
    """Reactions −C_qᵀλ that the ground can exert, each with the index of its body.

    Points (3,) [m] and directions (3,) are in frame O.
    """
    parallel = {
        (row.i, constants["a_i_b"]): constants["a_j_b"]
        for row in system.constraints
        if row.j == GROUND_INDEX and RelativeMotion.TILT in held_by(row.kind)
        for constants in [dict(row.constants)]
    }
    for source in _sources(system):
        if is_own(source.kind):  # it may know places and directions of frame O
            yield from ((body, ANYTHING) for body in {source.i, source.j} - {GROUND_INDEX})
            continue
        if GROUND_INDEX in (source.i, source.j) and source.i != source.j:
            body = source.j if source.i == GROUND_INDEX else source.i
            yield body, _ground_reaction(source, parallel)


def _sources(system: System) -> Iterator[Source]:
    """Rows and springs, and coordinates of combinations and forces."""
    for row in system.constraints:
        if row.is_combination:
            yield from (system.coordinates[term.coordinate] for term in row.terms)
        else:
            yield row
    for force in system.forces:
        if (source := facets_of(force).source(system)) is not None:
            yield source


def _ground_reaction(
    source: Source, parallel: Mapping[tuple[int, Numbers], Numbers]
) -> GroundReaction:
    """Reaction of the ground through a row or coordinate of a kind.

    Parameters
    ----------
    source : Instance or Coordinate
        Row or coordinate between the ground and a body.
    parallel : mapping
        Axis of the ground that a joint keeps parallel to an axis of body i, by both of these.
    """
    constants = dict(source.constants)
    end = "i" if source.i == GROUND_INDEX else "j"
    axis, point = (constants.get(f"{name}_{end}_b") for name in ("a", "s"))
    kind = base_of(source.kind)
    if end == "j" and "a_j_b" not in kind_of(kind).inputs:
        axis = parallel.get((source.i, constants.get("a_i_b", ())))
    if is_varying((axis, point)):
        return ANYTHING
    fixed = (None if x is None else precise.triple(x) for x in (axis, point))
    return CONSTRAINT_FACETS[kind].ground_reaction(*fixed)


@dataclass(frozen=True, slots=True)
class Axes:
    """Directions along which the angular momentum of a part is constant, L·n = const.

    Parameters
    ----------
    directions : tuple of (3,) [-]
        Of norm one, frame O.
    about : (3,) [m], optional
        Point of the ground about which L is taken; the centre of mass unless given.
    """

    directions: tuple[Vector, ...] = ()
    about: Vector | None = None


def free_of_force(
    reactions: Iterable[GroundReaction], loads: Iterable[Vector]
) -> tuple[Vector, ...]:
    """Directions n (3,) [-] along which no force acts on a part: F·n = 0, frame O.

    Parameters
    ----------
    reactions : iterable of GroundReaction
        Reactions of the ground on the part.
    loads : iterable of (3,)
        Gravity, and constant forces.
    """
    pushes = [precise.triple(load) for load in loads]
    for reaction in reactions:
        if reaction.through is not None:
            return ()
        if reaction.push is not None:
            pushes.append(reaction.push)
        if reaction.line is not None:
            first = precise.across(reaction.line[0])
            pushes += [first, precise.cross(reaction.line[0], first)]
    return across(pushes)


def free_of_moment(
    reactions: Iterable[GroundReaction],
    pushes: Iterable[Vector],
    gravity: Iterable[Vector],
    torques: Iterable[Vector],
) -> Axes:
    """Directions n (3,) [-] about which no moment acts on a part: n·((r − o) × F + N) = 0, frame O.

    Forces along an axis, and forces that meet it, have no moment about it. About the centre of mass
    gravity has none.

    Parameters
    ----------
    reactions : iterable of GroundReaction
        Reactions of the ground on the part.
    pushes, gravity, torques : iterable of (3,)
        Constant forces at points of bodies, those at centres of mass, and constant torques.
    """
    along = [precise.triple(push) for push in pushes]
    points: list[Triple] = []
    for reaction in reactions:
        if reaction.any_moment:
            return Axes()
        points += [reaction.through] if reaction.through is not None else []
        points += [reaction.line[1]] if reaction.line is not None else []
        along += [vector for vector in (reaction.push, reaction.about) if vector is not None]
        along += [reaction.line[0]] if reaction.line is not None else []
    if points:
        along += [precise.triple(pull) for pull in gravity]
        along += [precise.subtract(other, points[0]) for other in _apart(points)]
    twists = [precise.triple(torque) for torque in torques]
    return Axes(_parallel(along, twists), _rounded(points[0]) if points else None)


def _apart(points: list[Triple]) -> Iterator[Triple]:
    """Points that do not coincide with the first one."""
    first = points[0]
    for other in points[1:]:
        size = precise.length(first) + precise.length(other)
        if precise.length(precise.subtract(other, first)) > COINCIDENCE_TOLERANCE * size:
            yield other


def _parallel(along: list[Triple], twists: list[Triple]) -> tuple[Vector, ...]:
    """Unit vectors parallel to some vectors, and perpendicular to others."""
    units = [precise.unit(vector) for vector in along if precise.length(vector)]
    if not units:
        return across(twists)
    first, *others = units
    if any(precise.length(precise.cross(first, other)) > COINCIDENCE_TOLERANCE for other in others):
        return ()
    if any(abs(precise.dot(first, x)) > COINCIDENCE_TOLERANCE * precise.length(x) for x in twists):
        return ()
    return (_rounded(first),)


AXES: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def across(vectors: Iterable[Triple]) -> tuple[Vector, ...]:
    """Unit vectors n (3,) [-] perpendicular to some vectors and to each other, in one frame."""
    span: list[Triple] = []
    for vector in vectors:
        remainder = vector
        size = precise.length(remainder)
        for axis in span:
            remainder = precise.without(remainder, axis)
        if size and precise.length(remainder) > COINCIDENCE_TOLERANCE * size:
            span.append(precise.unit(remainder))
    if not span:
        return AXES
    if len(span) == 1:
        first = precise.across(span[0])
        return tuple(_rounded(axis) for axis in (first, precise.cross(span[0], first)))
    return (_rounded(precise.cross(*span)),) if len(span) == 2 else ()


def _rounded(vector: Triple) -> Vector:
    x, y, z = precise.rounded(vector)
    return x, y, z
