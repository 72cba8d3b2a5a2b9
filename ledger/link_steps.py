"""What is checked of the method beyond that sides are equal: the code, remainders, ranks."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import sympy
from sympy import S, Symbol
from sympy.matrices.expressions import MatrixSymbol
from sympy.polys.matrices import DomainMatrix

from kousoku.ledger.entry import Check
from kousoku.ledger.link_mechanisms import LEVER_CRANK, PISTON_CRANK
from kousoku.ledger.link_motion import (
    BY_ALPHA,
    KNOWN,
    L1,
    L2,
    SLOPE,
    T,
    motion,
    picking,
    reference_matrix,
    words,
)
from kousoku.ledger.link_words import code
from kousoku.ledger.proof import equality, value_of
from kousoku.ledger.vocabulary import Value, Vocabulary
from kousoku.model.errors import LedgerError
from kousoku.model.quantity import Quantity

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.ledger.link_mechanisms import Mechanism

#: Sizes in place of the letters of the code's steps: equations, coordinates, known coordinates.
SIZES = {
    Symbol(letter, integer=True, positive=True): n
    for letter, n in zip("mnk", (6, 10, 4), strict=True)
}
#: A crank and a rod of lengths 3 and 13/2: sin α = 12/13 … all rational.
NUMBERS = {L1: S(3), T: S(2) / 3, SLOPE: S(1) / 3}

Scalar = Any


def _sized(x: Value) -> Value:
    return x.xreplace(SIZES)


@cache
def symbols() -> Vocabulary:
    """Return the symbols of the code's steps on assembled systems, by the paper's names."""
    m, n, k = 6, 10, 4
    shapes = {
        **{"D^0": ("D", m, n), "L^1": ("L_1", n, m), "L^2": ("L_2", n, k)},
        **{"u": ("u", n, 1), "u^1": ("u_1", m, 1), "u^2": ("u_2", k, 1)},
        **{"x'": ("x′", n, 1), "x'^1": ("x′_1", m, 1), "x'^2": ("x′_2", k, 1)},
        **{"x''": ("x″", n, 1), "x_ref.": ("x_ref", n, 1)},
        **{"ζ": ("zeta", m, 1), "u^*": ("u^*", m, 1)},
    }
    meanings: dict[str, Value] = {name: MatrixSymbol(*args) for name, args in shapes.items()}
    meanings |= {
        "d/dt α": Symbol("alpha_dot"),
        "d²/dt² α": Symbol("alpha_ddot"),
        "Δα": Symbol("Δα"),
    }
    return Vocabulary((), meanings, derivatives={"α": lambda _: MatrixSymbol("D′", m, n)})


def in_code(left: str, formula: str) -> Check:
    """Return the check that the code's step is the formula, symbol by symbol."""

    def run() -> str:
        (right,) = (s.right for s in code().steps if str(s.left) == left)
        if _sized(right) != value_of(formula, symbols()):
            raise LedgerError(f"the code says {right}")
        return "the same, symbol by symbol"

    return Check(f"the code's step for {left}", run)


def is_substituted(formula: str) -> Callable[[], str]:
    """Return the check that the code's step (20) is the formula, both multiplied out."""

    def run() -> str:
        (left,) = (s.left for s in code().steps if s.source == "20")
        sizes = dict(zip(SIZES, (2, 3, 1), strict=True))
        step = left.xreplace(sizes)
        arrays = sorted(step.atoms(MatrixSymbol), key=str)
        quantities = tuple(Quantity(a.name, tuple(map(int, a.shape)), "", "") for a in arrays)
        by_name = {a.name: a for a in arrays}
        named = {"D^0": "D", "L^1": "L_1", "L^2": "L_2", "u^1": "u_1", "u^2": "u_2"}
        meanings = {name: by_name[code] for name, code in named.items()}
        known = Vocabulary(quantities, meanings)
        return equality(known, step, value_of(formula, known, side=0))

    return run


# -- one degree of freedom -----------------------------------------------------------------------


def determinant(mechanism: Mechanism) -> Scalar:
    """Return the determinant of the columns of the unknowns, with sines and cosines as letters."""
    letters = {k: sympy.symbols(f"c{k} s{k} l{k}") for k in range(1, len(mechanism.links) + 1)}

    def element(link: int) -> list[list[Scalar]]:
        c, s, l0 = letters[link]
        return [[-c, -s, 0, c, s, 0], [-s, c, l0, s, -c, 0], [s, -c, 0, -s, c, -l0]]

    rows = mechanism.assembled(element)
    square = sympy.Matrix([[row[k] for k in mechanism.unknown] for row in rows])
    if square.rows != square.cols:
        raise LedgerError(f"{square.rows} equations for {square.cols} unknowns")
    matrix = DomainMatrix.from_Matrix(square).to_field()
    return matrix.domain.to_sympy(matrix.det())


def pistons_freedom() -> dict[str, bool]:
    """Look at the determinant of the piston crank, and at the rod's angle."""
    c1, s1, l1, c2, l2 = sympy.symbols("c1 s1 l1 c2 l2")
    crank, rod = PISTON_CRANK.lengths
    apart = determinant(PISTON_CRANK) - l1 * l2**2 * c2 * (c1**2 + s1**2)
    return {
        "6 equations, 6 unknowns, determinant l1 l2² cos β2": sympy.cancel(apart) == 0,
        f"cos β2 is never 0, as l1 = {crank} < l2 = {rod}": crank < rod,
        "one known displacement, of the crank, is not 0": _moved(PISTON_CRANK) == ["ψ_11"],
    }


def levers_freedom() -> dict[str, bool]:
    """Look at the determinant of the lever crank, and at where coupler and lever are in line."""
    c1, s1, l1, c2, s2, l2 = sympy.symbols("c1 s1 l1 c2 s2 l2")
    c3, s3, l3, c4, s4, l4 = sympy.symbols("c3 s3 l3 c4 s4 l4")
    want = -l1 * l2**2 * l3**2 * l4 * (s2 * c3 - c2 * s3)
    apart = determinant(LEVER_CRANK) - want * (c1**2 + s1**2) * (c4**2 + s4**2)
    a, b, c, d = LEVER_CRANK.lengths
    counted = "12 equations, 12 unknowns, determinant −l1 l2² l3² l4 sin(β2 − β3)"
    return {
        counted: sympy.cancel(apart) == 0,
        f"sin(β2 − β3) is never 0: O2 and O4 are {d - a} to {d + a} apart, "
        f"in line {abs(b - c)} or {b + c}": abs(b - c) < d - a and d + a < b + c,
        "one known displacement, of the crank, is not 0": _moved(LEVER_CRANK) == ["ψ_11"],
    }


def _moved(mechanism: Mechanism) -> list[str]:
    return [name for name, value in mechanism.known.items() if value != "0"]


def rod_keeps_its_length() -> str:
    """Differentiate the rod's length l1 sin α / sin β along the motion."""
    if BY_ALPHA(L2) != 0 or BY_ALPHA(L1) != 0:
        raise LedgerError("the links change their lengths")
    if len([k for k in KNOWN if motion(1)[k, 0] != 0]) != 1:
        raise LedgerError("more than the crank's angle is prescribed")
    return "both lengths are constant; of the known coordinates the crank's angle alone changes"


def parts_are_complementary() -> dict[str, bool]:
    """Look at L1 and L2 of the piston crank."""
    first, second = (words().meanings[name] for name in ("L^1", "L^2"))
    whole = first * first.T + second * second.T
    return {
        "L1 L1ᵀ + L2 L2ᵀ = I": whole == sympy.eye(10),
        "6 unknown coordinates and 4 known": (first.shape, second.shape) == ((10, 6), (10, 4)),
    }


# -- the second transfer function ----------------------------------------------------------------


def is_derivative_of_first(formula: str) -> Callable[[], str]:
    """Return the check that a formula for x′ of the unknowns gives x″ when differentiated."""

    def run() -> str:
        by_alpha = BY_ALPHA(value_of(formula, words()))
        return equality(words(), by_alpha, words().meanings["x''^1"])

    return run


def without_unknowns() -> dict[str, bool]:
    """Leave out what (23) as printed leaves out: the unknown part of x′."""
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


def slope_changes() -> dict[str, bool]:
    """Look at what the slope that leads to the true position by (26) has beside x′."""
    third = [value.xreplace(NUMBERS) for value in motion(3)]
    changed = [name for name, value in zip(PISTON_CRANK.names, third, strict=True) if value != 0]
    return {
        f"the third derivative is not zero in {', '.join(changed)}": changed
        == ["u_2", "v_2", "u_3", "ψ_21", "ψ_22"]
    }


def _crank_residual(x: Scalar, y: Scalar, psi: Scalar, terms: int) -> list[Scalar]:
    """Return the series of ε of a crank of length 1 that is turned by h, its far end at (x, y)."""
    h = Symbol("h")

    def short(value: Scalar) -> Scalar:
        return sympy.series(value, h, 0, terms).removeO()

    beta = short(sympy.atan(short(y / x)))
    stretched = short(sympy.sqrt(sympy.expand(x**2 + y**2)))
    return [sympy.expand(e) for e in (stretched - 1, h - beta, beta - psi)]


@cache
def crank_orders(corrections: int) -> tuple[int, ...]:
    """Return the order of ε of the crank at (26), and after each correction by (27) and (28)."""
    h = Symbol("h")
    x, y, psi = 1 - h**2 / 2, h, h
    orders = []
    for k in range(corrections + 1):
        first, second, third = _crank_residual(x, y, psi, 5 + k)
        orders.append(min(sympy.Poly(e, h).monoms()[-1][0] for e in (first, second, third) if e))
        x, y, psi = (sympy.expand(v) for v in (x - first, y + second, psi + second + third))
    return tuple(orders)


def leaves_a_residual() -> dict[str, bool]:
    """Expand ε of the crank at the position that (26) gives."""
    orders = crank_orders(3)
    return {"ε of the crank begins with the third power of Δα": orders[0] == 3}


def gains_one_order() -> dict[str, bool]:
    """Expand ε of the crank after each of three corrections."""
    orders = crank_orders(3)
    shown = ", ".join(str(n) for n in orders)
    return {f"ε of the crank is of order {shown} in Δα": orders == (3, 4, 5, 6)}
