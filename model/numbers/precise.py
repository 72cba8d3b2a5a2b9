"""Vectors and rotations in 50 digits: constants of a scene are rounded only once.

Quaternions are Euler parameters with the scalar first and of any length but zero: a rotation
divides by their square, so that the numbers of a scene stay exact as long as they can.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from kousoku.model.angles import Angle
from kousoku.model.numbers.digits import CONTEXT, HIGH
from kousoku.model.numbers.real import Real
from kousoku.model.numbers.traced import NOISE, Traced, applied, at_scene
from kousoku.model.numbers.varying import Varying
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

High = Real  # a number of the context, a fraction, or a traced one
_high: Callable[[Any], High] = CONTEXT.mpf
Triple = tuple[High, High, High]
Quadruple = tuple[High, High, High, High]
Square = tuple[Triple, Triple, Triple]

ZERO: Triple = (CONTEXT.mpf(0),) * 3
IDENTITY: Quadruple = (CONTEXT.mpf(1), *ZERO)


def number(value: float | Fraction | High) -> High:
    """Number of a double without rounding, or of a fraction in 50 digits; 50 digits as they are.

    Of an angle in degrees it is the exact angle: 90 degrees are a right angle.

    Of a double that depends on parameters it is the number with its formula.
    """
    if type(value) is float:
        return _high(value)
    if isinstance(value, Angle):
        value = value.exact
    if isinstance(value, Varying):
        return value.traced
    if isinstance(value, Traced):
        return value
    if isinstance(value, Fraction):
        return HIGH.number(value)
    return _high(value)


def double(value: High) -> float:
    """Number rounded to a double, with its formula if it has one."""
    return Varying(value) if isinstance(value, Traced) else float(value)


def sqrt(value: High) -> High:
    """Square root √value."""
    return applied(Op.SQRT, value) if isinstance(value, Traced) else HIGH.sqrt(value)


def atan2(y: High, x: High) -> High:
    """Angle of the vector (x, y) from the axis x, in (−π, π] [rad]."""
    is_traced = isinstance(y, Traced) or isinstance(x, Traced)
    return applied(Op.ATAN2, y, x) if is_traced else HIGH.atan2(y, x)


def cleaned(value: High, size: High) -> High:
    """Value, or zero where it is only rounding of numbers of that size."""
    if isinstance(value, Traced):
        return value
    return ZERO[0] if abs(value) <= NOISE * size else value


def total(values: Sequence[High]) -> High:
    """Sum Σ values (n,), a scalar in their unit, rounded once where no number is traced."""
    if any(isinstance(value, Traced) for value in values):
        return sum(values, ZERO[0])
    rounded_sum: High = CONTEXT.fsum(values)
    return rounded_sum


def triple(values: Iterable[float]) -> Triple:
    """Vector (3,) of 50 digits, of three doubles in its unit."""
    x, y, z = values
    return number(x), number(y), number(z)


def quadruple(values: Iterable[float]) -> Quadruple:
    """Euler parameters (4,) [-] of 50 digits, scalar first, of four doubles."""
    w, x, y, z = values
    return number(w), number(x), number(y), number(z)


def add(a: Triple, b: Triple) -> Triple:
    """Sum a + b (3,) of vectors (3,) in one frame, of one unit."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def subtract(a: Triple, b: Triple) -> Triple:
    """Difference a − b (3,) of vectors (3,) in one frame, of one unit."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scale(factor: High, a: Triple) -> Triple:
    """Multiple factor · a (3,) of a vector a (3,), in its frame and in the product of the units."""
    return factor * a[0], factor * a[1], factor * a[2]


def dot(a: Triple, b: Triple) -> High:
    """Scalar product a·b of vectors (3,) in one frame, in the product of their units."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Triple, b: Triple) -> Triple:
    """Vector product a × b (3,) of vectors (3,) in one frame, in the product of their units."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def length(a: Sequence[High]) -> High:
    """Norm |a| of a vector (3,), in its unit, or of Euler parameters (4,) [-]."""
    return sqrt(sum(x * x for x in a))


def unit(a: Triple) -> Triple:
    """Unit vector a/|a| (3,) [-] of a vector a (3,) that is not zero, in its frame."""
    size = length(a)
    return a[0] / size, a[1] / size, a[2] / size


def across(axis: Triple) -> Triple:
    """Unit vector (3,) [-] that is perpendicular to a unit vector (3,) [-], in its frame.

    It lies near the coordinate axis that is furthest from ``axis``, the first of equals, and on it
    where it can: zeros of the axis stay zeros.
    """
    k = min(range(3), key=lambda index: abs(axis[index]))
    along = tuple(CONTEXT.mpf(int(index == k)) for index in range(3))
    return unit(without((along[0], along[1], along[2]), axis))


def without(a: Triple, axis: Triple) -> Triple:
    """Part a − (a·axis) axis (3,) of a vector a (3,), perpendicular to the axis (3,) [-].

    The axis has norm one. Both are in one frame; the result has the unit of a.
    """
    return subtract(a, scale(dot(a, axis), axis))


def rotate(p: Quadruple, a: Triple) -> Triple:
    """Vector A(p) a / (p·p) = a + 2 e × (e₀ a + e × a) / (p·p), p = (e₀, e): lecture 7.1, (4.3).

    Parameters
    ----------
    p : (4,) [-]
        Euler parameters of a rotated frame, scalar first, of any norm but zero.
    a : (3,)
        Components of a vector in the rotated frame, in any unit.

    Returns
    -------
    (3,)
        Components of the vector in the reference frame, frame O for a body; in the unit of a.
    """
    scalar, e = p[0], (p[1], p[2], p[3])
    if not any(e):
        return a
    square = scalar * scalar + dot(e, e)
    turned = cross(e, add(scale(scalar, a), cross(e, a)))
    return add(a, scale(2 / square, turned))


def rotate_back(p: Quadruple, a: Triple) -> Triple:
    """Vector A(p)ᵀ a / (p·p), the inverse of :func:`rotate`: lecture 7.1, (4.3).

    Parameters
    ----------
    p : (4,) [-]
        Euler parameters of a rotated frame, scalar first, of any norm but zero.
    a : (3,)
        Components of a vector in the reference frame, frame O for a body; in any unit.

    Returns
    -------
    (3,)
        Components of the vector in the rotated frame, in the unit of a.
    """
    return rotate(conjugate(p), a)


def conjugate(p: Quadruple) -> Quadruple:
    """Conjugate (e₀, −e) (4,) [-] of p = (e₀, e), of the inverse rotation: A(e₀, −e) = A(p)ᵀ."""
    return p[0], -p[1], -p[2], -p[3]


def compose(p: Quadruple, q: Quadruple) -> Quadruple:
    """Quaternion product p ∘ q (4,) [-], A(p ∘ q) = A(p) A(q): the rotation q, then p.

    It is (p₀ q₀ − e·f, p₀ f + q₀ e + e × f), with the vector parts e of p and f of q.

    Parameters
    ----------
    p, q : (4,) [-]
        Euler parameters, scalar first, of any norm; q is relative to the frame that p rotates.
    """
    e, f = (p[1], p[2], p[3]), (q[1], q[2], q[3])
    vector = add(add(scale(p[0], f), scale(q[0], e)), cross(e, f))
    return (p[0] * q[0] - dot(e, f), *vector)


def quaternion_of(matrix: Square) -> Quadruple:
    """Euler parameters (4,) [-] of a rotation matrix, scalar first, of any norm but zero.

    They solve lecture 7.1, (4.3), for p: candidate k is 4 pₖ p, with p of norm one, and the one
    with the largest |pₖ| is taken.

    Parameters
    ----------
    matrix : (3, 3) [-]
        A by rows: components in the rotated frame to the reference frame.
    """
    (a, b, c), (d, e, f), (g, h, i) = matrix
    candidates = (
        (1 + a + e + i, h - f, c - g, d - b),
        (h - f, 1 + a - e - i, b + d, c + g),
        (c - g, b + d, 1 - a + e - i, f + h),
        (d - b, c + g, f + h, 1 - a - e + i),
    )
    return max(
        enumerate(candidates), key=lambda numbered: (abs(numbered[1][numbered[0]]), -numbered[0])
    )[1]


def rounded(values: Sequence[High], size: High = 0, noise: High = NOISE) -> tuple[float, ...]:
    """Numbers (n,) rounded to doubles, in their unit, with rounded zeros as zeros.

    Parameters
    ----------
    values : (n,) sequence
        Components of a vector, or Euler parameters [-].
    size : number
        The largest of the numbers that they came from, in their unit; their own largest when that
        is more.
    noise : number [-]
        The part of it below which a component is a rounded zero.
    """
    limit = noise * at_scene(max(size, *(abs(value) for value in values)))
    return tuple(
        0.0 if not isinstance(value, Traced) and abs(value) <= limit else double(value)
        for value in values
    )
