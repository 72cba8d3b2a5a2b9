"""Yamada and Tatsumi 1981, section 3: the motion of the piston crank, and proofs along it.

Its crank stands at the angle α, its rod at −β. With t = tan(α/2) and s = tan(β/2) every coordinate
is a rational function of l1, t and s or one of the two angles, and l2 = l1 sin α / sin β. The
transfer functions are found by differentiating these along α, never by an equation of the paper.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import sympy
from sympy import S, Symbol
from sympy.matrices.expressions import MatrixSymbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.ledger import find
from kousoku.ledger.documents.link_element import U, code, column
from kousoku.ledger.documents.link_mechanisms import PISTON_CRANK
from kousoku.ledger.proof import GENERAL, equality, value_of
from kousoku.ledger.registry import Names
from kousoku.ledger.vocabulary import Vocabulary, explicit
from kousoku.model.errors import LedgerError
from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.components import Flow
from kousoku.symbolic.matrices import elements
from kousoku.symbolic.sympy_types import as_scalar, as_value

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.symbolic.sympy_types import Scalar, SymbolicMatrix, Value

NAMES = Names(GENERAL)

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


def sine(half: Scalar) -> Scalar:
    """Sine of an angle from the tangent of its half."""
    return 2 * half / (1 + half**2)


def cosine(half: Scalar) -> Scalar:
    """Cosine of an angle from the tangent of its half."""
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
        return as_value(explicit(value).applyfunc(cell) if is_matrix else cell(value))

    return derivative


#: The derivatives by α and by time.
BY_ALPHA, BY_TIME = _derivative(_ALONG), _derivative(_IN_TIME)


@cache
def motion(order: int) -> ImmutableDenseMatrix:
    """Position, or its first, second, third derivative by α."""
    return BY_ALPHA(motion(order - 1)) if order else column(POSITION)


@cache
def reference_matrix() -> ImmutableDenseMatrix:
    """Matrix D at the reference, assembled from (15) for both links."""
    angles = {1: (2 * sympy.atan(T), L1), 2: (-2 * sympy.atan(SLOPE), L2)}

    def element(link: int) -> list[list[Scalar]]:
        beta, length = angles[link]
        words = Vocabulary((), {"β_i^0": beta, "l_i^0": length})
        cells = value_of(find("15").printed, words).applyfunc(sympy.cancel)
        return [list(row) for row in cells.tolist()]

    return ImmutableDenseMatrix(PISTON_CRANK.assembled(element))


def picking(places: Sequence[int], size: int) -> ImmutableDenseMatrix:
    """Matrix that puts numbers at places of a vector."""
    return ImmutableDenseMatrix([[int(place == row) for place in places] for row in range(size)])


def part(x: Value, places: Sequence[int]) -> Value:
    """Numbers at places of a vector."""
    return as_value(column([x[k, 0] for k in places]))


UNKNOWN, KNOWN = PISTON_CRANK.unknown, PISTON_CRANK.prescribed


def _parts(name: str, value: Value) -> dict[str, Scalar | SymbolicMatrix]:
    return {name: value, f"{name}^1": part(value, UNKNOWN), f"{name}^2": part(value, KNOWN)}


@NAMES.words
@cache
def words() -> Vocabulary:
    """Vocabulary of the way of the piston crank; u is x′ Δα."""
    x, first, second = (motion(order) for order in range(3))
    velocity, matrix = BY_TIME(x), reference_matrix()
    pick = picking(UNKNOWN, len(POSITION))
    correction = column(elements(CORRECTION))
    predicted = x + STEP * first + STEP**2 / 2 * second
    meanings: dict[str, Scalar | SymbolicMatrix] = {
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


@NAMES.words
@cache
def definitions() -> Vocabulary:
    """Words of x′ = dx/dα and x″ = d²x/dα²: α alone changes, and evenly."""
    x = words().meaning("x")
    dx = RATE * DT * BY_ALPHA(x)
    twice = RATE * DT * BY_ALPHA(dx)
    return words().knowing({"dx": dx, "d^2 x": twice, "x": x})


@NAMES.words
@cache
def parted() -> Vocabulary:
    """Words of (18) and (19): any displacement of the rod, and of the whole."""
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


# -- the code ------------------------------------------------------------------------------------

#: Sizes in place of the letters of the code's steps: equations, coordinates, known coordinates.
SIZES = {
    Symbol(letter, integer=True, positive=True): n
    for letter, n in zip("mnk", (6, 10, 4), strict=True)
}
#: A crank and a rod of lengths 3 and 13/2: sin α = 12/13 … all rational.
NUMBERS = {L1: S(3), T: S(2) / 3, SLOPE: S(1) / 3}


def _sized(x: Value) -> Value:
    return as_value(x.xreplace(SIZES))


@cache
def symbols() -> Vocabulary:
    """Symbols of the code's steps on assembled systems, by the paper's names."""
    m, n, k = 6, 10, 4
    shapes = {
        **{"D^0": ("D", m, n), "L^1": ("L_1", n, m), "L^2": ("L_2", n, k)},
        **{"u": ("u", n, 1), "u^1": ("u_1", m, 1), "u^2": ("u_2", k, 1)},
        **{"x'": ("x′", n, 1), "x'^1": ("x′_1", m, 1), "x'^2": ("x′_2", k, 1)},
        **{"x''": ("x″", n, 1), "x_ref.": ("x_ref", n, 1)},
        **{"ζ": ("zeta", m, 1), "u^*": ("u^*", m, 1)},
    }
    meanings: dict[str, Scalar | SymbolicMatrix] = {
        name: MatrixSymbol(*args) for name, args in shapes.items()
    }
    meanings |= {
        "d/dt α": Symbol("alpha_dot"),
        "d²/dt² α": Symbol("alpha_ddot"),
        "Δα": Symbol("Δα"),
    }
    return Vocabulary((), meanings, derivatives={"α": lambda _: MatrixSymbol("D′", m, n)})


@NAMES.proof("the code's step for {step}")
def in_code(step: str, formula: str) -> str:
    """Prove that the code's step is the formula, symbol by symbol."""
    (right,) = (s.right for s in code().steps if str(s.left) == step)
    if _sized(right) != value_of(formula, symbols()):
        raise LedgerError(f"the code says {right}")
    return "the same, symbol by symbol"


@NAMES.proof()
def is_substituted(formula: str) -> str:
    """Prove that the code's step (20) is the formula, both multiplied out."""
    (left,) = (s.left for s in code().steps if s.source == "20")
    sizes = dict(zip(SIZES, (2, 3, 1), strict=True))
    step = left.xreplace(sizes)
    arrays = sorted(step.atoms(MatrixSymbol), key=str)
    quantities = tuple(Quantity(a.name, tuple(map(int, a.shape)), "", "") for a in arrays)
    by_name = {a.name: a for a in arrays}
    named = {"D^0": "D", "L^1": "L_1", "L^2": "L_2", "u^1": "u_1", "u^2": "u_2"}
    known = Vocabulary(quantities, {name: by_name[code] for name, code in named.items()})
    return equality(known, step, value_of(formula, known, side=0))


# -- one degree of freedom -----------------------------------------------------------------------


@NAMES.proof()
def rod_keeps_its_length() -> str:
    """Differentiate the rod's length l1 sin α / sin β along the motion."""
    if BY_ALPHA(L2) != 0 or BY_ALPHA(L1) != 0:
        raise LedgerError("the links change their lengths")
    if len([k for k in KNOWN if motion(1)[k, 0] != 0]) != 1:
        raise LedgerError("more than the crank's angle is prescribed")
    return "both lengths are constant; of the known coordinates the crank's angle alone changes"


@NAMES.proof()
def parts_are_complementary() -> dict[str, bool]:
    """Look at L1 and L2 of the piston crank."""
    first, second = (words().meaning(name) for name in ("L^1", "L^2"))
    whole = first * first.T + second * second.T
    return {
        "L1 L1ᵀ + L2 L2ᵀ = I": whole == sympy.eye(10),
        "6 unknown coordinates and 4 known": (first.shape, second.shape) == ((10, 6), (10, 4)),
    }


# -- the second transfer function ----------------------------------------------------------------


@NAMES.proof()
def is_derivative_of(first: str) -> str:
    """Prove that the entry of x′ of the unknowns gives x″ when it is differentiated."""
    by_alpha = BY_ALPHA(value_of(find(first).printed, words()))
    return equality(words(), by_alpha, words().meanings["x''^1"])


@NAMES.proof()
def without_unknowns() -> dict[str, bool]:
    """Leave out the unknown part of x′, as (23) does as it is printed."""
    known = words().meanings
    matrix, pick = reference_matrix(), picking(KNOWN, 10)
    inverse = (matrix * known["L^1"]).xreplace(NUMBERS).inv()
    short = -inverse * (BY_ALPHA(matrix) * pick * known["x'^2"]).xreplace(NUMBERS)
    want = known["x''^1"].xreplace(NUMBERS)
    return {
        f"with L2 put in, its first element is {short[0, 0]}, not {want[0, 0]} = −l1 cos α": bool(
            short[0, 0] != want[0, 0] == -3 * sympy.S(5) / 13
        )
    }


# -- remainders ----------------------------------------------------------------------------------


@NAMES.proof()
def third_order() -> dict[str, bool]:
    """Differentiate (26) and the motion by Δα where that is zero, three times."""
    step = Symbol("Δα")
    predicted = words().meanings["x_adj."]
    seen = {}
    for order, name in enumerate(("value", "first derivative", "second derivative")):
        got = predicted.diff(step, order).subs(step, 0) if order else predicted.subs(step, 0)
        seen[f"same {name}"] = bool(equality(words(), got, motion(order)))
    third = motion(3)[4, 0].xreplace(NUMBERS)
    seen[f"third derivative of the slider {third} at a rational position, of (26) zero"] = bool(
        third != 0 and predicted.diff(step, 3) == sympy.zeros(10, 1)
    )
    return seen


@NAMES.proof()
def slope_changes() -> dict[str, bool]:
    """Look at the rest of the slope that leads to the true position by (26), beside x′."""
    third = [value.xreplace(NUMBERS) for value in motion(3)]
    changed = [name for name, value in zip(PISTON_CRANK.names, third, strict=True) if value != 0]
    return {
        f"the third derivative is not zero in {', '.join(changed)}": changed
        == ["u_2", "v_2", "u_3", "ψ_21", "ψ_22"]
    }


def _crank_residual(x: Scalar, y: Scalar, psi: Scalar, terms: int) -> list[Scalar]:
    """Series of ε of a crank of length 1 that is turned by h, its far end at (x, y)."""
    h = Symbol("h")

    def short(value: Scalar) -> Scalar:
        return as_scalar(sympy.series(value, h, 0, terms).removeO())

    beta = short(sympy.atan(short(y / x)))
    stretched = short(sympy.sqrt(sympy.expand(x**2 + y**2)))
    return [sympy.expand(e) for e in (stretched - 1, h - beta, beta - psi)]


@cache
def crank_orders(corrections: int) -> tuple[int, ...]:
    """Order of ε of the crank at (26), and after each correction by (27) and (28)."""
    h = Symbol("h")
    x, y, psi = 1 - h**2 / 2, h, h
    orders = []
    for k in range(corrections + 1):
        first, second, third = _crank_residual(x, y, psi, 5 + k)
        orders.append(min(sympy.Poly(e, h).monoms()[-1][0] for e in (first, second, third) if e))
        x, y, psi = (sympy.expand(v) for v in (x - first, y + second, psi + second + third))
    return tuple(orders)


@NAMES.proof()
def leaves_a_residual() -> dict[str, bool]:
    """Expand ε of the crank at the position that (26) gives."""
    orders = crank_orders(3)
    return {"ε of the crank begins with the third power of Δα": orders[0] == 3}


@NAMES.proof()
def gains_one_order() -> dict[str, bool]:
    """Expand ε of the crank after each of three corrections."""
    orders = crank_orders(3)
    shown = ", ".join(str(n) for n in orders)
    return {f"ε of the crank is of order {shown} in Δα": orders == (3, 4, 5, 6)}
