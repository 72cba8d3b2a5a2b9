"""What the symbols of Yamada and Tatsumi (1981) mean for one link, section 2.

The link is at any reference position, displaced by any **u**. Angles are those of the direction
from end to end, so that their sines and cosines are quotients of lengths, and all is exact.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import sympy
from sympy import S, Symbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.ledger.vocabulary import Vocabulary
from kousoku.model.quantity import Quantity
from kousoku.symbolic import derive
from kousoku.symbolic.matrices import elements

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.symbolic.derivation import Derivation

#: Where the ends are at the reference, and how far they and their rotations are displaced.
PLACE = Quantity("place", (4,), "m", "x1 y1 x2 y2 at the reference position")
U = Quantity("displacement", (6,), "m, rad", "u1 v1 ψ1 u2 v2 ψ2")
COORDINATES = ("x_i1", "y_i1", "β_i1", "x_i2", "y_i2", "β_i2")
DISPLACEMENTS = ("u_i1", "v_i1", "ψ_i1", "u_i2", "v_i2", "ψ_i2")

Scalar = Any


def column(cells: Sequence[Scalar]) -> ImmutableDenseMatrix:
    """Return numbers as a vector."""
    return ImmutableDenseMatrix([[cell] for cell in cells])


def span(x: Sequence[Scalar]) -> tuple[Scalar, Scalar]:
    """Return the components of the vector from end 1 to end 2."""
    return x[3] - x[0], x[4] - x[1]


def length(x: Sequence[Scalar]) -> Scalar:
    """Return the distance of the ends."""
    dx, dy = span(x)
    return sympy.sqrt(dx**2 + dy**2)


def angle(x: Sequence[Scalar]) -> Scalar:
    """Return the angle of the link from the x axis."""
    dx, dy = span(x)
    return sympy.atan2(dy, dx)


def reference() -> list[Scalar]:
    """Return x1 y1 β1 x2 y2 β2 where no end is turned against the link."""
    x1, y1, x2, y2 = elements(PLACE)
    beta = angle([x1, y1, S.Zero, x2, y2, S.Zero])
    return [x1, y1, beta, x2, y2, beta]


def displaced(u: Sequence[Scalar]) -> list[Scalar]:
    """Return x1 y1 β1 x2 y2 β2 after a displacement."""
    return [a + b for a, b in zip(reference(), u, strict=True)]


def turned(theta: Scalar) -> list[Scalar]:
    """Return the displacement of a rigid link that turns about its end 1."""
    dx, dy = span(reference())
    c, s = sympy.cos(theta), sympy.sin(theta)
    return [S.Zero, S.Zero, theta, c * dx - s * dy - dx, s * dx + c * dy - dy, theta]


def at(x: Sequence[Scalar]) -> dict[str, Sequence[Scalar]]:
    """Return what the arrays of the code's link are at a position: no end is offset."""
    return {"x": x, "offset": [S.Zero, S.Zero]}


@cache
def code() -> Derivation:
    """Return the code's derivation of the link."""
    return derive("link")


def derived(left: str) -> Any:
    """Return what the last step of the code's derivation that is about ``left`` says it is."""
    symbols = {Symbol("length"): length(reference()), Symbol("beta"): angle(elements_of_x())}
    found = {str(step.left): step.right for step in code().steps}
    return found[left].xreplace(symbols)


def elements_of_x() -> list[Scalar]:
    """Return the elements of the position of the ends in the code's derivation."""
    x = sympy.MatrixSymbol("x", 6, 1)
    return [x[k, 0] for k in range(6)]


@cache
def words() -> Vocabulary:
    """Return what the symbols of (1) to (13) mean: ε as the code derives it."""
    u = elements(U)
    x0, x = reference(), displaced(u)
    epsilon = [derived(f"epsilon_{k}") for k in (1, 2, 3)]
    meanings: dict[str, Any] = {
        "x_i^0": column(x0),
        "x_i": column(x),
        "u_i": column(u),
        "ε_i": column(epsilon),
        "l_i^0": length(x0),
        "l_i": length(x),
        "β_i^0": x0[2],
        "β_i": angle(x),
        **{f"ε_i{k}": value for k, value in enumerate(epsilon, 1)},
        **{f"{name}^0": value for name, value in zip(COORDINATES, x0, strict=True)},
        **dict(zip(COORDINATES, x, strict=True)),
        **dict(zip(DISPLACEMENTS, u, strict=True)),
    }
    return Vocabulary((PLACE, U), meanings, at(x))
