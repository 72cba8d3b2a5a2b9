"""The component level: scalar formulas in Euler parameters, differentiated as polynomials.

Nothing here knows a rule of the matrix level. A virtual rotation is δp = ½ p∘(0, δθ′), an angular
velocity ṗ = ½ p∘(0, ω′), and everything else is the chain rule on the polynomial C(r, p).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import sympy
from sympy import Rational, S

from kousoku.symbolic.matrices import quadratic_form
from kousoku.symbolic.sympy_types import as_scalar

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.symbolic.sympy_types import Scalar


def rotate(p: Sequence[Scalar], v: Sequence[Scalar]) -> list[Scalar]:
    """Elements of A(p) v, frame O: lecture 7.1, (4.3).

    Parameters
    ----------
    p : (4,) [-]
        Euler parameters, scalar first, of any norm.
    v : (3,)
        A vector in the body frame; the result has its unit, times (p·p).
    """
    return [dot(row, v) for row in quadratic_form(p)]


def rotate_back(p: Sequence[Scalar], v: Sequence[Scalar]) -> list[Scalar]:
    """Elements of A(p)ᵀ v, body frame: lecture 7.1, (4.3).

    Parameters
    ----------
    p : (4,) [-]
        Euler parameters, scalar first, of any norm.
    v : (3,)
        A vector in frame O; the result has its unit, times (p·p).
    """
    return [dot(column, v) for column in zip(*quadratic_form(p), strict=True)]


def dot(u: Sequence[Scalar], v: Sequence[Scalar]) -> Scalar:
    """Scalar product uᵀv of two columns (n,) in one frame, in the product of their units."""
    return sum((a * b for a, b in zip(u, v, strict=True)), S.Zero)


def cross(u: Sequence[Scalar], v: Sequence[Scalar]) -> list[Scalar]:
    """Vector product ũ v = u × v (3,) of vectors (3,) in one frame; its unit is that of u v."""
    return [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ]


def subtract(u: Sequence[Scalar], v: Sequence[Scalar]) -> list[Scalar]:
    """Difference u − v (n,) of columns (n,) in one frame, of the same unit."""
    return [a - b for a, b in zip(u, v, strict=True)]


def plus(u: Sequence[Scalar], v: Sequence[Scalar]) -> list[Scalar]:
    """Sum u + v (n,) of columns (n,) in one frame, of the same unit."""
    return [a + b for a, b in zip(u, v, strict=True)]


def compose(p: Sequence[Scalar], q: Sequence[Scalar]) -> list[Scalar]:
    """Elements of the quaternion product p∘q: the turn q, then p.

    It is (p0 q0 − p·q, p0 q + q0 p + p × q), with the vector parts p and q.

    Parameters
    ----------
    p, q : (4,) [-]
        Quaternions, scalar first, of any norm; the vector part of q is in the frame that p turns.
    """
    vector = plus(plus([p[0] * c for c in q[1:]], [q[0] * c for c in p[1:]]), cross(p[1:], q[1:]))
    return [p[0] * q[0] - dot(p[1:], q[1:]), *vector]


def half_turn(p: Sequence[Scalar], theta: Sequence[Scalar]) -> list[Scalar]:
    """Elements of ½ p∘(0, θ′): how p changes with a rotation; lecture 7.1, (5.16).

    Parameters
    ----------
    p : (4,) [-]
        Euler parameters, scalar first, of any norm.
    theta : (3,) [rad]
        A small rotation in the body frame; of an angular velocity ω′ [rad/s] it is ṗ [1/s].
    """
    return [Rational(1, 2) * c for c in compose(p, [S.Zero, *theta])]


class Flow:
    """The derivative along a direction: of r along δr, of p along ½ p∘(0, δθ′), by (7.16).

    Parameters
    ----------
    direction : Mapping
        The derivative of each symbol that changes: of r (3,) [m] in frame O, of p (4,) by δθ′ [rad]
        in the body frame; or rates, by v [m/s] and ω′ [rad/s].
    expand_in : Sequence
        Symbols; a sum that holds no others is multiplied out, which keeps the elements of A short.
    """

    def __init__(self, direction: Mapping[Scalar, Scalar], expand_in: Sequence[Scalar]) -> None:
        self._direction = direction
        self._small = frozenset(expand_in)
        self._memo: dict[Scalar, Scalar] = {}

    def __call__(self, x: Scalar) -> Scalar:
        """Derivative of ``x``."""
        known = self._memo.get(x)
        if known is None:
            known = self._memo[x] = self._derivative(x)
        return known

    def _derivative(self, x: Scalar) -> Scalar:
        if not x.args:
            return self._direction.get(x, S.Zero)
        if x.is_Add:
            total = sympy.Add(*(self(arg) for arg in x.args))
            return as_scalar(sympy.expand(total) if x.free_symbols <= self._small else total)
        if x.is_Mul:
            terms = []
            for k, arg in enumerate(x.args):
                change = self(arg)
                if change != 0:
                    terms.append(sympy.Mul(*x.args[:k], change, *x.args[k + 1 :]))
            return as_scalar(sympy.Add(*terms))
        if x.is_Pow and not x.exp.free_symbols:
            change = self(x.base)
            return as_scalar(S.Zero if change == 0 else x.exp * x.base ** (x.exp - 1) * change)
        if isinstance(x, sympy.atan2):
            v, u = x.args
            numerator = u * self(v) - v * self(u)
            return as_scalar(numerator / (v**2 + u**2))
        return as_scalar(sympy.Add(*(x.diff(s) * change for s, change in self._direction.items())))
