"""Rotations on the component level: δ and d/dt, found by differentiating alone.

No rule that an entry states is used here. A(p) is the quadratic form over p·p, a rotation for all
Euler parameters; it changes along ½ p∘(0, δθ′), and everything else is the chain rule.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.symbolic.components import Flow, compose, dot, half_turn
from kousoku.symbolic.matrices import elements, quadratic_form

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.files.quantity import Quantity
    from kousoku.symbolic.sympy_types import Scalar


def orientation(p: Quantity) -> list[list[Scalar]]:
    """Elements of A(p) / (p·p)."""
    e = elements(p)
    square = dot(e, e)
    return [[cell / square for cell in row] for row in quadratic_form(e)]


def turned(p: Quantity, v: Sequence[Scalar]) -> list[Scalar]:
    """Elements of A v, with A(p) / (p·p)."""
    return [dot(row, v) for row in orientation(p)]


def along(*changes: tuple[Quantity, Quantity]) -> Flow:
    """Derivative along changes of quantities.

    Parameters
    ----------
    *changes : tuple of Quantity
        A quantity and its change: of Euler parameters (4,) a rotation (3,) in the body frame, of
        anything else an array of the same shape.
    """
    direction: dict[Scalar, Scalar] = {}
    small: list[Scalar] = []
    for quantity, change in changes:
        old, new = elements(quantity), elements(change)
        if quantity.shape == (4,):
            direction.update(zip(old, half_turn(old, new), strict=True))
            small.extend((*old, *new))
        else:
            direction.update(zip(old, new, strict=True))
    return Flow(direction, small)


def spatial(p: Quantity, theta: Quantity) -> list[Scalar]:
    """Elements of 2 δp∘p̄ / (p·p): the rotation δθ in frame O, by quaternions alone."""
    e = elements(p)
    conjugate = [e[0], -e[1], -e[2], -e[3]]
    product = compose(half_turn(e, elements(theta)), conjugate)
    return [2 * x / dot(e, e) for x in product[1:]]


def flat(rows: Sequence[Sequence[Scalar]]) -> list[Scalar]:
    """Elements of a matrix, row-major."""
    return [cell for row in rows for cell in row]
