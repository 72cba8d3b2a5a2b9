"""What the symbols of (17) to (28) mean: the motion of the piston crank, in closed form.

Its crank stands at the angle α, its rod at −β. With t = tan(α/2) and s = tan(β/2) every coordinate
is a rational function of l1, t and s or one of the two angles, and l2 = l1 sin α / sin β. The
transfer functions are found by differentiating these along α, never by an equation of the paper.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import sympy
from sympy import S
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.ledger.link_checks import MATRIX
from kousoku.ledger.link_mechanisms import PISTON_CRANK
from kousoku.ledger.link_words import U, column
from kousoku.ledger.proof import value_of
from kousoku.ledger.vocabulary import Vocabulary, explicit
from kousoku.model.quantity import Quantity
from kousoku.symbolic.components import Flow
from kousoku.symbolic.matrices import elements

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.ledger.vocabulary import Value

L1, T, SLOPE, ALPHA, BETA = sympy.symbols("l_1 t s α β")
RATE, ACCELERATION, STEP, DT = sympy.symbols("α_dot α_ddot Δα dt")
QUANTITIES = tuple(
    Quantity(str(symbol), (), "", meaning)
    for symbol, meaning in (
        (L1, "length of the crank"),
        (T, "tan of half the crank's angle"),
        (SLOPE, "tan of half the rod's angle, downwards"),
        (ALPHA, "the crank's angle"),
        (BETA, "the rod's angle, downwards"),
        (RATE, "dα/dt"),
        (ACCELERATION, "d²α/dt²"),
        (STEP, "how far the crank is turned on"),
        (DT, "an infinitesimal time"),
    )
)
#: A correction of the unknown coordinates, of any size.
CORRECTION = Quantity("correction", (6,), "m, rad", "of the unknown coordinates")

Scalar = Any


def sine(half: Scalar) -> Scalar:
    """Return the sine of an angle from the tangent of its half."""
    return 2 * half / (1 + half**2)


def cosine(half: Scalar) -> Scalar:
    """Return the cosine of an angle from the tangent of its half."""
    return (1 - half**2) / (1 + half**2)


L2 = L1 * sine(T) / sine(SLOPE)
#: dβ/dα, of l1 sin α = l2 sin β.
BETA_SLOPE = L1 * cosine(T) / (L2 * cosine(SLOPE))
POSITION = (
    *(S.Zero, S.Zero, L1 * cosine(T), L1 * sine(T)),
    *(L1 * cosine(T) + L2 * cosine(SLOPE), S.Zero),
    *(ALPHA, ALPHA, -BETA, -BETA),
)
_ALONG = {
    ALPHA: S.One,
    BETA: BETA_SLOPE,
    T: (1 + T**2) / 2,
    SLOPE: BETA_SLOPE * (1 + SLOPE**2) / 2,
}
_IN_TIME = {symbol: RATE * change for symbol, change in _ALONG.items()} | {RATE: ACCELERATION}


def _derivative(direction: dict[Scalar, Scalar]) -> Callable[[Value], Value]:
    flow = Flow(direction, ())

    def cell(x: Scalar) -> Scalar:
        return sympy.cancel(change) if (change := flow(x)) != 0 else change

    @cache
    def derivative(value: Value) -> Value:
        is_matrix = getattr(value, "is_Matrix", False)
        return explicit(value).applyfunc(cell) if is_matrix else cell(value)

    return derivative


#: The derivatives by α and by time.
BY_ALPHA, BY_TIME = _derivative(_ALONG), _derivative(_IN_TIME)


@cache
def motion(order: int) -> ImmutableDenseMatrix:
    """Return the position, or its first, second, third derivative by α."""
    return BY_ALPHA(motion(order - 1)) if order else column(POSITION)


@cache
def reference_matrix() -> ImmutableDenseMatrix:
    """Return D at the reference, assembled from (15) for both links."""
    angles = {1: (2 * sympy.atan(T), L1), 2: (-2 * sympy.atan(SLOPE), L2)}

    def element(link: int) -> list[list[Scalar]]:
        beta, length = angles[link]
        words = Vocabulary((), {"β_i^0": beta, "l_i^0": length})
        cells = value_of(MATRIX, words).applyfunc(sympy.cancel)
        return [list(row) for row in cells.tolist()]

    return ImmutableDenseMatrix(PISTON_CRANK.assembled(element))


def picking(places: Sequence[int], size: int) -> ImmutableDenseMatrix:
    """Return the matrix that puts numbers at places of a vector."""
    return ImmutableDenseMatrix([[int(place == row) for place in places] for row in range(size)])


def part(x: Value, places: Sequence[int]) -> Value:
    """Return the numbers at places of a vector."""
    return column([x[k, 0] for k in places])


UNKNOWN, KNOWN = PISTON_CRANK.unknown, PISTON_CRANK.prescribed


def _parts(name: str, value: Value) -> dict[str, Value]:
    return {name: value, f"{name}^1": part(value, UNKNOWN), f"{name}^2": part(value, KNOWN)}


@cache
def words() -> Vocabulary:
    """Return what the symbols mean on the way of the piston crank; u is x′ Δα."""
    x, first, second = (motion(order) for order in range(3))
    velocity, matrix = BY_TIME(x), reference_matrix()
    pick = picking(UNKNOWN, len(POSITION))
    correction = column(elements(CORRECTION))
    predicted = x + STEP * first + STEP**2 / 2 * second
    meanings: dict[str, Value] = {
        "D^0": matrix,
        "L^1": pick,
        "L^2": picking(KNOWN, len(POSITION)),
        "x": x,
        **_parts("u", STEP * first),
        **_parts("x'", first),
        **_parts("x''", second),
        **_parts("dx", DT * velocity),
        **_parts("du", DT * velocity),
        "dx'": DT * BY_TIME(first),
        "d^2 x": DT**2 * BY_TIME(velocity),
        "d/dt x": velocity,
        "d²/dt² x": BY_TIME(velocity),
        "d/dt α": RATE,
        "d²/dt² α": ACCELERATION,
        "dα": RATE * DT,
        "dt": DT,
        "Δα": STEP,
        "x_ref.": x,
        "x_adj.": predicted,
        "u^*": correction,
        "ζ": -matrix * pick * correction,
        "new x'": (predicted + pick * correction - x) / STEP - STEP / 2 * second,
        "x''_2": part(second, PISTON_CRANK.ends(2)),
    }
    derivatives = {"α": BY_ALPHA, "t": BY_TIME}
    return Vocabulary((*QUANTITIES, CORRECTION), meanings, derivatives=derivatives)


@cache
def definitions() -> Vocabulary:
    """Return the words of x′ = dx/dα and x″ = d²x/dα²: α alone changes, and evenly."""
    known = words().meanings
    x, dx = known["x"], RATE * DT * BY_ALPHA(known["x"])
    twice = RATE * DT * BY_ALPHA(dx)
    return words().knowing({"dx": dx, "d^2 x": twice, "x": x})


@cache
def parted() -> Vocabulary:
    """Return the words of (18) and (19): any displacement of the rod, and of the whole."""
    whole = Quantity("u", (10,), "m, rad", "displacement of the mechanism")
    ends = PISTON_CRANK.ends(2)
    known = [k for k, place in enumerate(ends) if place in KNOWN]
    unknown = [k for k in range(6) if k not in known]
    u, rod = column(elements(whole)), column(elements(U))
    meanings = {
        **_parts("u", u),
        "L^1": words().meanings["L^1"],
        "L^2": words().meanings["L^2"],
        "u_i": rod,
        "u_i^1": part(rod, unknown),
        "u_i^2": part(rod, known),
        "L_i^1": picking(unknown, 6),
        "L_i^2": picking(known, 6),
    }
    return Vocabulary((whole, U), meanings)
