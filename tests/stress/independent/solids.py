"""Orientations of all forms, and mass, first moment and inertia tensor of all that bodies are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tests.stress.independent.numbers import (
    IDENTITY,
    about,
    back,
    cross,
    dot,
    minus,
    plus,
    product,
    rotation,
    times,
    transposed,
    turned,
    unit,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tests.stress.independent.formulas import Reader
    from tests.stress.independent.numbers import Matrix, Number, Vector

    Tree = dict[str, Any]
    Part = tuple[Number, Vector, Matrix]


def orientation_of(read: Reader, given: Tree | None) -> Matrix:
    """Matrix A of an orientation of a scene."""
    match given or {}:
        case {"quaternion": p, "order": order}:
            p = read.vector(p)
            return rotation(p if order == "wxyz" else [p[3], *p[:3]])
        case {"rotation_vector": vector}:
            axis = read.vector(vector)
            return about(axis, dot(unit(axis), axis)) if any(axis) else IDENTITY
        case {"axis": axis, "angle": angle}:
            return about(read.vector(axis), read.number(angle))
        case {"angles": angles, "sequence": sequence, "about": whose}:
            A: Matrix = IDENTITY
            for letter, angle in zip(sequence, read.vector(angles), strict=True):
                one = about([int(letter == name) for name in "xyz"], angle)
                A = product(A, one) if whose == "body" else product(one, A)
            return A
        case {"matrix": matrix}:
            return nearest_rotation([read.vector(row) for row in matrix])
        case _:
            return [[read.real(x) for x in row] for row in IDENTITY]


def nearest_rotation(A: Matrix) -> Matrix:
    """Rotation next to a matrix that is nearly one, by A ← (A + A⁻ᵀ)/2.

    The cofactors of a rotation are its elements, so that A⁻ᵀ is found without a division.
    """
    for _ in range(8):
        a, b, c = A
        size = dot(a, cross(b, c))
        inverse = [times(1 / size, cross(*pair)) for pair in ((b, c), (c, a), (a, b))]
        A = [times(0.5, plus(x, y)) for x, y in zip(A, inverse, strict=True)]
    return A


@dataclass(frozen=True, slots=True)
class Mass:
    """What of its mass the motion of a body depends on, about the origin of its frame.

    Parameters
    ----------
    mass : number [kg]
        Mass.
    first : (3,)
        Mass times the centre of mass.
    tensor : (3, 3)
        Inertia tensor about the origin of the body frame.
    """

    mass: Number
    first: Vector
    tensor: Matrix


def mass_of(read: Reader, body: Tree) -> Mass | None:
    """Mass of a body; None where it has none."""
    parts = [*_parts(read, body)]
    if not parts:
        return None
    tensor: Matrix = [[0, 0, 0]] * 3
    first: Vector = [0, 0, 0]
    for mass, at, own in parts:
        first = plus(first, times(mass, at))
        tensor = _sum(tensor, _sum(own, steiner(mass, at)))
    return Mass(sum(part[0] for part in parts), first, tensor)


def steiner(mass: Number, d: Vector) -> Matrix:
    """Tensor mass (|d|² I − d dᵀ)."""
    return [[mass * (dot(d, d) * (i == j) - d[i] * d[j]) for j in range(3)] for i in range(3)]


def _sum(A: Matrix, B: Matrix) -> Matrix:
    return [plus(a, b) for a, b in zip(A, B, strict=True)]


def _parts(read: Reader, body: Tree) -> Iterator[Part]:
    """Mass, centre and tensor about this centre of all parts."""
    none: Matrix = [[read.real(0)] * 3] * 3
    if "mass" in body:
        mass, center = read.number(body["mass"]), read.vector(body.get("center", [0, 0, 0]))
        yield mass, center, _given(read, mass, center, body.get("inertia"))
    for one in body.get("mass_points", ()):
        yield read.number(one["mass"]), read.vector(one["at"]), none
    for one in body.get("boxes", ()):
        mass, size = read.number(one["mass"]), read.vector(one["size"])
        squares = [x * x for x in size]
        own = [mass / 12 * (sum(squares) - x) for x in squares]
        A = orientation_of(read, one.get("orientation"))
        rows = [times(moment, axis) for moment, axis in zip(own, transposed(A), strict=True)]
        yield mass, read.vector(one.get("at", [0, 0, 0])), product(A, rows)
    for one in body.get("rods", ()):
        start, end = (read.vector(x) for x in one["ends"])
        mass = read.number(one["mass"])
        yield mass, times(0.5, plus(start, end)), steiner(mass / 12, minus(end, start))
    for one in body.get("cylinders", ()):
        start, end = (read.vector(x) for x in one["ends"])
        mass, square = read.number(one["mass"]), read.number(one["radius"]) ** 2
        # A disk has m R²/4 in all directions and as much again about its axis.
        u = unit(minus(end, start))
        disk = [[mass * square / 4 * ((i == j) + u[i] * u[j]) for j in range(3)] for i in range(3)]
        along = steiner(mass / 12, minus(end, start))
        yield mass, times(0.5, plus(start, end)), _sum(disk, along)
    for one in body.get("spheres", ()):
        mass = read.number(one["mass"])
        moment = 2 * mass * read.number(one["radius"]) ** 2 / 5
        tensor = [times(moment, row) for row in IDENTITY]
        yield mass, read.vector(one.get("at", [0, 0, 0])), tensor


def _given(read: Reader, mass: Number, center: Vector, inertia: Tree | None) -> Matrix:
    """Tensor as it is given, about the centre of mass."""
    own = {key: read.number(x) for key, x in (inertia or {}).items() if key != "about"}
    letters = (("xx", "xy", "zx"), ("xy", "yy", "yz"), ("zx", "yz", "zz"))
    tensor: Matrix = [[own.get(key, read.real(0)) for key in row] for row in letters]
    if inertia is None or "about" not in inertia:
        return tensor
    return _sum(tensor, steiner(-mass, minus(center, read.vector(inertia["about"]))))


@dataclass(frozen=True, slots=True)
class Pose:
    """Where a body frame is.

    Parameters
    ----------
    r : (3,)
        Its origin, in frame O.
    A : (3, 3)
        Takes components in the body to components in frame O.
    """

    r: Vector
    A: Matrix

    def place(self, s: Vector) -> Vector:
        """Point of the body in frame O."""
        return plus(self.r, turned(self.A, s))

    def point(self, s: Vector) -> Vector:
        """Point of frame O in the body."""
        return back(self.A, minus(s, self.r))


GROUND = Pose([0, 0, 0], IDENTITY)
