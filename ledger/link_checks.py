"""What is checked of the link element beyond that sides are equal: remainders, ranks, the code."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any

import sympy
from sympy import S, Symbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.ledger.entry import Check
from kousoku.ledger.link_words import (
    PLACE,
    U,
    angle,
    at,
    code,
    column,
    derived,
    displaced,
    length,
    reference,
    span,
    turned,
    words,
)
from kousoku.ledger.proof import equality, value_of
from kousoku.ledger.vocabulary import Vocabulary
from kousoku.model.errors import LedgerError
from kousoku.model.quantity import Quantity
from kousoku.symbolic.link_element import LENGTH, OFFSET, X
from kousoku.symbolic.matrices import elements

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

#: (5) to (7) as printed, from which all else is differentiated.
DEFORMATIONS = (
    r"\epsilon_{i1} = l_i - l_i^0 \quad (\text{リンクの伸び})",
    r"\epsilon_{i2} = \{(\beta_i^0 + \psi_{i1}) - \beta_i\} l_i^0 = (\beta_{i1} - \beta_i) l_i^0",
    r"\epsilon_{i3} = \{(\beta_i - (\beta_i^0 + \psi_{i2}))\} l_i^0"
    r" = (\beta_i - \beta_{i2}) l_i^0",
)
#: (15) as printed.
MATRIX = (
    r"[D_i^0] = \begin{bmatrix} -\cos \beta_i^0 & -\sin \beta_i^0 & 0"
    r" & \cos \beta_i^0 & \sin \beta_i^0 & 0 \\"
    r" -\sin \beta_i^0 & \cos \beta_i^0 & l_i^0 & \sin \beta_i^0 & -\cos \beta_i^0 & 0 \\"
    r" \sin \beta_i^0 & -\cos \beta_i^0 & 0 & -\sin \beta_i^0 & \cos \beta_i^0 & -l_i^0"
    r" \end{bmatrix}"
)
TURN = Quantity("turn", (3,), "m, rad", "an infinitesimal rigid motion: of end 1 along x and y, θ")
THETA = Quantity("θ", (), "rad", "a rotation of any size")
#: A link of length 5 along (3, 4), and a displacement: for these all is rational.
NUMBERS = dict(zip(elements(PLACE), (0, 0, 3, 4), strict=True))

Scalar = Any


@cache
def epsilon() -> tuple[Scalar, ...]:
    """Return (5) to (7) as functions of the displacement."""
    return tuple(value_of(formula, words()) for formula in DEFORMATIONS)


def matrix() -> ImmutableDenseMatrix:
    """Return (15) as printed."""
    return value_of(MATRIX, words())


def still(x: Scalar) -> Scalar:
    """Return a function of the displacement where there is none."""
    return x.xreplace(dict.fromkeys(elements(U), S.Zero))


@cache
def expanded() -> Vocabulary:
    """Return the words of (14): ε is its own first-order term, by differentiating (5) to (7)."""
    size = Symbol("size")
    along = {u: size * u for u in elements(U)}
    terms = [sympy.diff(e.xreplace(along), size).xreplace({size: S.Zero}) for e in epsilon()]
    return words().knowing({"ε_i": column(terms), "D_i^0": matrix()})


@cache
def differentiated() -> Vocabulary:
    """Return the words of (15): the derivatives of (5) to (7) where u = 0."""
    rows = [[still(sympy.diff(e, u)) for u in elements(U)] for e in epsilon()]
    return words().knowing({"D_i^0": ImmutableDenseMatrix(rows)})


@cache
def rigid() -> Vocabulary:
    """Return the words of (16): u is any infinitesimal motion of a rigid link."""
    a, b, theta = elements(TURN)
    dx, dy = span(reference())
    u = column([a, b, theta, a - theta * dy, b + theta * dx, theta])
    meanings = {**words().meanings, "u_i": u, "D_i^0": matrix()}
    return Vocabulary((PLACE, TURN), meanings)


def numbers(statement: str, seen: Callable[[], Mapping[str, bool]]) -> Check:
    """Return the check that all of some statements about numbers are true."""

    def run() -> str:
        wrong = [name for name, is_true in seen().items() if not is_true]
        if wrong:
            raise LedgerError(f"it is not true that {', '.join(wrong)}")
        return "; ".join(seen())

    return Check(statement, run)


# -- one angle in place of three -----------------------------------------------------------------


def one_angle_is_too_few() -> dict[str, bool]:
    """Turn end 1 of a link alone, by 1: the two angles differ, and with one angle ε2 is zero."""
    u = dict.fromkeys(elements(U), S.Zero) | {elements(U)[2]: S.One}
    known = words().meanings
    end, link = (known[name].xreplace(u).xreplace(NUMBERS) for name in ("β_i1", "β_i"))
    deformation = value_of(DEFORMATIONS[1], words()).xreplace(u).xreplace(NUMBERS)
    printed = value_of(DEFORMATIONS[1], words().knowing({"β_i1": known["β_i"]}))
    return {
        "an end that is turned by 1 has β_i1 = β_i + 1": sympy.expand(end - link) == 1,
        "a link of length 5 has ε2 = 5 then": sympy.expand(deformation) == 5,
        "with β_i in its place ε2 = 0 for every displacement": printed == 0,
    }


# -- remainders ----------------------------------------------------------------------------------


def second_order() -> dict[str, bool]:
    """Look at the second derivatives of ε along one displacement of a link of length 5."""
    size = Symbol("size")
    along = dict(zip(elements(U), (0, 0, 0, size, 0, 0), strict=True))
    path = [e.xreplace(along).xreplace(NUMBERS) for e in epsilon()]
    seen = {}
    for k, e in enumerate(path, 1):
        value, first, second = (sympy.diff(e, size, n).subs(size, 0) for n in range(3))
        linear = sympy.expand((expanded().meanings["ε_i"][k - 1, 0]).xreplace(along))
        slope = sympy.diff(linear, size).xreplace(NUMBERS)
        seen[f"ε{k} = 0 + {first} u_i2 + {second / 2} u_i2² + … for l0 = 5 along (3, 4)"] = bool(
            value == 0 and first == slope and second != 0
        )
    return seen


def finite_turn() -> str:
    """Turn a rigid link by a finite angle: ε is zero, and D u is not, from the second order on."""
    theta = Symbol("θ")
    l0 = length(reference())
    left = matrix() * column(turned(theta))
    rest = [l0 * (sympy.cos(theta) - 1), l0 * (theta - sympy.sin(theta))]
    seen = equality(Vocabulary((PLACE, THETA), {}), left, column([*rest, -rest[1]]))
    orders = [sympy.series(e / l0, theta, 0, 4).removeO() for e in rest]
    if orders != [-(theta**2) / 2, theta**3 / 6]:
        raise LedgerError(f"the remainders begin with {orders}")
    return f"D u = l0 (cos θ − 1, θ − sin θ, sin θ − θ) = l0 (−θ²/2, θ³/6, −θ³/6) + …: {seen}"


# -- rigid and deformed --------------------------------------------------------------------------


def turn_is_rigid() -> str:
    """Turn a link by any angle: its length stays, and its own angle grows by as much."""
    theta = Symbol("θ")
    x = displaced(turned(theta))
    grown = [sympy.expand_trig(f(reference()[2] + theta)) for f in (sympy.cos, sympy.sin)]
    seen = [
        (length(x), length(reference())),
        *zip(span(x), [length(x) * g for g in grown], strict=True),
    ]
    words = Vocabulary((PLACE, THETA), {})
    return equality(words, *(column(side) for side in zip(*seen, strict=True)))


def undeformed_is_turned() -> str:
    """With ψ = β − β0 at both ends, turn the link by ψ: it points as it does, up to its length."""
    x0, x = reference(), displaced(elements(U))
    psi = angle(x) - x0[2]
    c, s = (sympy.expand_trig(f(psi)) for f in (sympy.cos, sympy.sin))
    (a, b), (dx, dy) = span(x0), span(x)
    stretch = length(x0) / length(x)
    left, right = [c * a - s * b, s * a + c * b], [stretch * dx, stretch * dy]
    return equality(Vocabulary((PLACE, U), {}), column(left), column(right))


def rank() -> str:
    """Look at two minors of (15): their squares add up to l0⁴, so that one of them is not zero."""
    d, l0 = matrix(), length(reference())
    if d.shape != (3, 6):
        raise LedgerError(f"the matrix has shape {d.shape}")
    minors = [d.extract([0, 1, 2], [k, 2, 5]).det() for k in (3, 4)]
    seen = equality(Vocabulary((PLACE,), {}), sum(m**2 for m in minors), l0**4)
    return f"3 rows, 6 columns; the squares of two minors of size 3 have the sum l0⁴: {seen}"


# -- the code ------------------------------------------------------------------------------------


def is_position() -> str:
    """Compare the code's x = x0 + u with the words' own."""
    given = {"x_0": reference(), "u": elements(U)}
    words_of_code = Vocabulary((PLACE, U), {}, given)
    return equality(words_of_code, derived("x"), words().meanings["x_i"])


def at_reference(name: str) -> Scalar:
    """Return what the code derives of the reference position."""
    x = sympy.MatrixSymbol("x_0", 6, 1)
    values = {x[k, 0]: value for k, value in enumerate(reference())}
    return derived(name).xreplace(values)


def length_in_code() -> Scalar:
    """Return the length that the code's step for ε1 takes the design length from."""
    return derived("epsilon_1") + length(reference())


def is_variation() -> str:
    """Compare the code's δε at the reference, with δx = u, with (15) times u."""
    given = {**at(reference()), "δx": elements(U)}
    rows = [derived(f"δε_{k}") for k in (1, 2, 3)]
    linear = expanded().meanings["ε_i"]
    words_of_code = replace(words(), given=given)
    seen = [equality(words_of_code, row, linear[k : k + 1, :]) for k, row in enumerate(rows)]
    return "; ".join(f"δε{k}: {text}" for k, text in enumerate(seen, 1))


def is_jacobian() -> str:
    """Compare the code's D with (15), at the reference, and its D anywhere with ∂ε/∂u."""
    words_of_code = replace(words(), given=at(reference()))
    (output,) = (o for f in code().functions for o in f.outputs if o.quantity.name == "D")
    names = {Symbol("length"): length(reference())}
    seen = equality(words_of_code, output.expression.xreplace(names), matrix())
    rows = ImmutableDenseMatrix([[sympy.diff(e, u) for u in elements(U)] for e in epsilon()])
    anywhere = equality(words(), output.expression.xreplace(names), rows)
    return f"at the reference (15), {seen}; displaced ∂ε/∂u, {anywhere}"


def are_wrapped(k: int) -> Callable[[], str]:
    """Return the check that the code's angle, found by atan2, is that of end k from the link."""

    def run() -> str:
        functions = {f.name: f for f in code().functions}
        cell = functions["deformation"].outputs[0].components[k]
        x = displaced(elements(U))
        values = dict(zip(elements(X), x, strict=True)) | dict.fromkeys(elements(OFFSET), S.Zero)
        values |= {elements(LENGTH)[0]: length(reference())}
        ((s, c),) = (a.args for a in cell.atoms(sympy.atan2))
        relative = x[3 * k - 1] - angle(x)
        want = [length(x) * f(relative) for f in (sympy.sin, sympy.cos)]
        got = [value.xreplace(values) for value in (s, c)]
        return equality(words(), *(column([sympy.expand_trig(e) for e in v]) for v in (got, want)))

    return run
