"""Vectors, rotations and poses of random scenes: the same numbers wherever they are made."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.numbers.real import Array

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]

DIRECTIONS: tuple[Vector, ...] = (
    *((0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 3, 4), (1, 1, 0), (2, -1, 2), (1, 2, -3), (-1, 0, 5)),
)
TURNS = ((1, 0, 0, 0), (1, 0, 0, 1), (2, 1, 0, 0), (3, 1, 0, -1), (2, 1, -2, 1), (5, -3, 1, 2))
"""Euler parameters of any norm: the simplest first."""


def dot(a: Vector, b: Vector) -> float:
    """a·b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product a × b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def across(a: Vector) -> Vector:
    """Direction across another one."""
    least = min(range(3), key=lambda k: abs(a[k]))
    return cross(a, (float(least == 0), float(least == 1), float(least == 2)))


def times(A: Matrix, x: Vector) -> Vector:
    """A x."""
    return (dot(A[0], x), dot(A[1], x), dot(A[2], x))


def transposed(A: Matrix) -> Matrix:
    """Aᵀ."""
    (a, b, c), (d, e, f), (g, h, i) = A
    return ((a, d, g), (b, e, h), (c, f, i))


def rotation(e0: float, e: Vector) -> Matrix:
    """A of Euler parameters of any norm but zero."""
    size = e0 * e0 + dot(e, e)
    rows = []
    for k in range(3):
        unit = (float(k == 0), float(k == 1), float(k == 2))
        turned = cross(e, unit)
        twice = cross(e, turned)
        rows.append([unit[m] + 2 * (e0 * turned[m] + twice[m]) / size for m in range(3)])
    first, second, third = ((row[0], row[1], row[2]) for row in rows)
    return transposed((first, second, third))


def orientation_of(p: Sequence[float]) -> Array:
    """A of Euler parameters, scalar first, as an array."""
    w, x, y, z = p
    return np.array(rotation(w, (x, y, z)))


def turn(axis: Vector, angle: float) -> Matrix:
    """A of a turn about an axis."""
    size = math.sqrt(dot(axis, axis))
    x, y, z = (math.sin(angle / 2) * x / size for x in axis)
    return rotation(math.cos(angle / 2), (x, y, z))


def product(A: Matrix, B: Matrix) -> Matrix:
    """A B."""
    first, second, third = (times(A, column) for column in transposed(B))
    return transposed((first, second, third))


@dataclass(frozen=True)
class Pose:
    """Where a body is: its origin in the unit of the scene, and A."""

    r: Vector = (0.0, 0.0, 0.0)
    A: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

    def place(self, s_b: Vector) -> Vector:
        """Point of the body in frame O."""
        x, y, z = times(self.A, s_b)
        return (self.r[0] + x, self.r[1] + y, self.r[2] + z)

    def point(self, s: Vector) -> Vector:
        """Point of frame O in the body."""
        return self.vector((s[0] - self.r[0], s[1] - self.r[1], s[2] - self.r[2]))

    def vector(self, a: Vector) -> Vector:
        """Vector of frame O in the body."""
        return times(transposed(self.A), a)
