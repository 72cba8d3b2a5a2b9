"""Reactions of the ground on a part of a system in any position: which way it can push.

A row between the ground and a body has a force and a moment whose directions follow from its kind
and from what is fixed in the ground. What holds at some positions only does not count; that rows
are met does, so that a point on a line is there.
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
"""Vectors whose angle is smaller count as parallel [rad]; points that are so near, as one."""


def ground_reactions_of(system: System) -> Iterator[tuple[int, GroundReaction]]:
    """Reactions of the ground on bodies: on which body, and all possible ones, −C_qᵀλ.

    Points (3,) [m] and directions (3,) are in frame O.
    """
    parallel = {
        (row.i, given["a_i_b"]): given["a_j_b"]
        for row in system.constraints
        if row.j == GROUND_INDEX and RelativeMotion.TILT in held_by(row.kind)
        for given in [dict(row.constants)]
    }
    for one in _acting(system):
        if is_own(one.kind):  # it may know places and directions of frame O
            yield from ((body, ANYTHING) for body in {one.i, one.j} - {GROUND_INDEX})
            continue
        if GROUND_INDEX in (one.i, one.j) and one.i != one.j:
            body = one.j if one.i == GROUND_INDEX else one.i
            yield body, _ground_reaction(one, parallel)


def _acting(system: System) -> Iterator[Source]:
    """Rows, coordinates of rows and forces, and springs."""
    for row in system.constraints:
        if row.is_combination:
            yield from (system.coordinates[term.coordinate] for term in row.terms)
        else:
            yield row
    for force in system.forces:
        if (source := facets_of(force).source(system)) is not None:
            yield source


def _ground_reaction(
    one: Source, parallel: Mapping[tuple[int, Numbers], Numbers]
) -> GroundReaction:
    """Reaction of the ground through a row or coordinate of a kind.

    Parameters
    ----------
    one : Instance or Coordinate
        Between the ground and a body.
    parallel : mapping
        By body i and one of its axes the axis of the ground that a joint keeps parallel to it.
    """
    given = dict(one.constants)
    letter = "i" if one.i == GROUND_INDEX else "j"
    axis, point = (given.get(f"{name}_{letter}_b") for name in ("a", "s"))
    kind = base_of(one.kind)
    if letter == "j" and "a_j_b" not in kind_of(kind).inputs:
        axis = parallel.get((one.i, given.get("a_i_b", ())))
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
        The point of the ground that it is taken about; the centre of mass unless given.
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
        What the ground does to it.
    loads : iterable of (3,)
        Gravity, and constant forces.
    """
    pushes = [precise.triple(load) for load in loads]
    for one in reactions:
        if one.through is not None:
            return ()
        if one.push is not None:
            pushes.append(one.push)
        if one.line is not None:
            first = precise.across(one.line[0])
            pushes += [first, precise.cross(one.line[0], first)]
    return across(pushes)


def free_of_moment(
    reactions: Iterable[GroundReaction],
    pushes: Iterable[Vector],
    gravity: Iterable[Vector],
    torques: Iterable[Vector],
) -> Axes:
    """Directions n (3,) [-] about which no moment acts on a part: n·((r − o) × F + N) = 0, frame O.

    The moment about an axis vanishes of forces along it, and of those that meet it. About the
    centre of mass gravity has none.

    Parameters
    ----------
    reactions : iterable of GroundReaction
        What the ground does to it.
    pushes, gravity, torques : iterable of (3,)
        Constant forces at points of bodies, those at centres of mass, and constant torques.
    """
    along = [precise.triple(push) for push in pushes]
    points: list[Triple] = []
    for one in reactions:
        if one.any_moment:
            return Axes()
        points += [one.through] if one.through is not None else []
        points += [one.line[1]] if one.line is not None else []
        along += [vector for vector in (one.push, one.about) if vector is not None]
        along += [one.line[0]] if one.line is not None else []
    if points:
        along += [precise.triple(pull) for pull in gravity]
        along += [precise.subtract(other, points[0]) for other in _apart(points)]
    twists = [precise.triple(torque) for torque in torques]
    return Axes(_parallel(along, twists), _rounded(points[0]) if points else None)


def _apart(points: list[Triple]) -> Iterator[Triple]:
    """Points that are not where the first one is."""
    first = points[0]
    for other in points[1:]:
        size = precise.length(first) + precise.length(other)
        if precise.length(precise.subtract(other, first)) > COINCIDENCE_TOLERANCE * size:
            yield other


def _parallel(along: list[Triple], twists: list[Triple]) -> tuple[Vector, ...]:
    """Unit vectors parallel to some vectors, and perpendicular to others."""
    given = [precise.unit(vector) for vector in along if precise.length(vector)]
    if not given:
        return across(twists)
    first, *others = given
    if any(precise.length(precise.cross(first, other)) > COINCIDENCE_TOLERANCE for other in others):
        return ()
    if any(abs(precise.dot(first, x)) > COINCIDENCE_TOLERANCE * precise.length(x) for x in twists):
        return ()
    return (_rounded(first),)


AXES: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def across(vectors: Iterable[Triple]) -> tuple[Vector, ...]:
    """Unit vectors n (3,) [-], n·a = 0 with all of some vectors and each other, in one frame."""
    span: list[Triple] = []
    for vector in vectors:
        rest = vector
        size = precise.length(rest)
        for one in span:
            rest = precise.without(rest, one)
        if size and precise.length(rest) > COINCIDENCE_TOLERANCE * size:
            span.append(precise.unit(rest))
    if not span:
        return AXES
    if len(span) == 1:
        first = precise.across(span[0])
        return tuple(_rounded(one) for one in (first, precise.cross(span[0], first)))
    return (_rounded(precise.cross(*span)),) if len(span) == 2 else ()


def _rounded(vector: Triple) -> Vector:
    x, y, z = precise.rounded(vector)
    return x, y, z
