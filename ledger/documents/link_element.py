"""Yamada and Tatsumi 1981, section 2: the meaning of the symbols of one link, and proofs.

The link is at any reference position, displaced by any **u**. Angles are those of the direction
from end to end, so that their sines and cosines are quotients of lengths, and all is exact.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any

import sympy
from sympy import S, Symbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.ledger import find
from kousoku.ledger.documents import link_mechanisms
from kousoku.ledger.proof import equality, value_of
from kousoku.ledger.registry import Names
from kousoku.ledger.vocabulary import Vocabulary
from kousoku.model.errors import LedgerError
from kousoku.model.files.quantity import Quantity
from kousoku.symbolic import derive
from kousoku.symbolic.link_element import LENGTH, OFFSET, X
from kousoku.symbolic.matrices import elements
from kousoku.symbolic.sympy_types import as_scalar

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.ledger.proof import Side
    from kousoku.symbolic.derivation import Derivation
    from kousoku.symbolic.sympy_types import Scalar

NAMES = Names(link_mechanisms.NAMES)

#: Where the ends are at the reference, and how far they and their rotations are displaced.
PLACE = Quantity("place", (4,), "m", "x1 y1 x2 y2 at the reference position")
U = Quantity("displacement", (6,), "m, rad", "u1 v1 ψ1 u2 v2 ψ2")
TURN = Quantity("turn", (3,), "m, rad", "an infinitesimal rigid motion: of end 1 along x and y, θ")
THETA = Quantity("θ", (), "rad", "a rotation of any size")
#: A link of length 5 along (3, 4), and a displacement: for these all is rational.
NUMBERS = dict(zip(elements(PLACE), (0, 0, 3, 4), strict=True))
COORDINATES = ("x_i1", "y_i1", "β_i1", "x_i2", "y_i2", "β_i2")
DISPLACEMENTS = ("u_i1", "v_i1", "ψ_i1", "u_i2", "v_i2", "ψ_i2")


def column(cells: Sequence[Scalar]) -> ImmutableDenseMatrix:
    """Numbers as a vector."""
    return ImmutableDenseMatrix([[cell] for cell in cells])


def span(x: Sequence[Scalar]) -> tuple[Scalar, Scalar]:
    """Components of the vector from end 1 to end 2."""
    return x[3] - x[0], x[4] - x[1]


def length(x: Sequence[Scalar]) -> Scalar:
    """Distance of the ends."""
    dx, dy = span(x)
    return as_scalar(sympy.sqrt(dx**2 + dy**2))


def angle(x: Sequence[Scalar]) -> Scalar:
    """Angle of the link from the x axis."""
    dx, dy = span(x)
    return as_scalar(sympy.atan2(dy, dx))


def reference() -> list[Scalar]:
    """Coordinates x1 y1 β1 x2 y2 β2 where no end is turned against the link."""
    x1, y1, x2, y2 = elements(PLACE)
    beta = angle([x1, y1, S.Zero, x2, y2, S.Zero])
    return [x1, y1, beta, x2, y2, beta]


def displaced(u: Sequence[Scalar]) -> list[Scalar]:
    """Coordinates x1 y1 β1 x2 y2 β2 after a displacement."""
    return [a + b for a, b in zip(reference(), u, strict=True)]


def turned(theta: Scalar) -> list[Scalar]:
    """Displacement of a rigid link that turns about its end 1."""
    dx, dy = span(reference())
    c, s = sympy.cos(theta), sympy.sin(theta)
    return [S.Zero, S.Zero, theta, c * dx - s * dy - dx, s * dx + c * dy - dy, theta]


def at(x: Sequence[Scalar]) -> dict[str, Sequence[Scalar]]:
    """Arrays of the code's link at a position: no end is offset."""
    return {"x": x, "offset": [S.Zero, S.Zero]}


@cache
def code() -> Derivation:
    """Derivation of the link by the code."""
    return derive("link")


def derived(left: str) -> Any:
    """Last step of the code's derivation that is about ``left``: its right side."""
    symbols = {Symbol("length"): length(reference()), Symbol("beta"): angle(elements_of_x())}
    found = {str(step.left): step.right for step in code().steps}
    return found[left].xreplace(symbols)


def elements_of_x() -> list[Scalar]:
    """Elements of the position of the ends in the code's derivation."""
    x = sympy.MatrixSymbol("x", 6, 1)
    return [x[k, 0] for k in range(6)]


@NAMES.words
@cache
def words() -> Vocabulary:
    """Vocabulary of (1) to (13): ε as the code derives it."""
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


@cache
def epsilon() -> tuple[Scalar, ...]:
    """Deformations (5)–(7) as functions of the displacement: all else is differentiated."""
    return tuple(value_of(find(key).printed, words()) for key in "567")


def matrix() -> ImmutableDenseMatrix:
    """Matrix (15) as printed."""
    return value_of(find("15").printed, words())


def still(x: Scalar) -> Scalar:
    """Function of the displacement where there is none."""
    return as_scalar(x.xreplace(dict.fromkeys(elements(U), S.Zero)))


@NAMES.words
@cache
def expanded() -> Vocabulary:
    """Words of (14): ε is its own first-order term, by differentiating (5) to (7)."""
    size = Symbol("size")
    along = {u: size * u for u in elements(U)}
    terms = [sympy.diff(e.xreplace(along), size).xreplace({size: S.Zero}) for e in epsilon()]
    return words().knowing({"ε_i": column(terms), "D_i^0": matrix()})


@NAMES.words
@cache
def differentiated() -> Vocabulary:
    """Words of (15): the derivatives of (5) to (7) where u = 0."""
    rows = [[still(sympy.diff(e, u)) for u in elements(U)] for e in epsilon()]
    return words().knowing({"D_i^0": ImmutableDenseMatrix(rows)})


@NAMES.words
@cache
def rigid() -> Vocabulary:
    """Words of (16): u is any infinitesimal motion of a rigid link."""
    a, b, theta = elements(TURN)
    dx, dy = span(reference())
    u = column([a, b, theta, a - theta * dy, b + theta * dx, theta])
    meanings = {**words().meanings, "u_i": u, "D_i^0": matrix()}
    return Vocabulary((PLACE, TURN), meanings)


# -- positions and displacements -----------------------------------------------------------------


@NAMES.proof()
def components_of_u() -> dict[str, bool]:
    """Move a link along x and y and turn it: four components depend on where it goes."""
    u = rigid().meaning("u_i")
    a, b, theta = elements(TURN)
    moved = [k for k in range(6) if u[k, 0].free_symbols & {a, b}]
    return {
        "four components of a rigid motion depend on its translation": moved == [0, 1, 3, 4],
        "the other two are its rotation, whatever its translation": u[2, 0] == u[5, 0] == theta,
    }


@NAMES.proof()
def reference_has_no_deformation() -> dict[str, bool]:
    """Look at (5) to (7) where there is no displacement."""
    values = [still(e) for e in epsilon()]
    return {f"ε{k} = 0 at x0": value == 0 for k, value in enumerate(values, 1)}


@NAMES.proof()
def one_angle_is_too_few() -> dict[str, bool]:
    """Turn end 1 of a link alone, by 1: the two angles differ, and with one angle ε2 is zero."""
    u = dict.fromkeys(elements(U), S.Zero) | {elements(U)[2]: S.One}
    known = words().meanings
    end, link = (known[name].xreplace(u).xreplace(NUMBERS) for name in ("β_i1", "β_i"))
    deformation = value_of(find("6").printed, words()).xreplace(u).xreplace(NUMBERS)
    printed = value_of(find("6").printed, words().knowing({"β_i1": known["β_i"]}))
    return {
        "an end that is turned by 1 has β_i1 = β_i + 1": sympy.expand(end - link) == 1,
        "a link of length 5 has ε2 = 5 then": sympy.expand(deformation) == 5,
        "with β_i in its place ε2 = 0 for every displacement": printed == 0,
    }


# -- remainders ----------------------------------------------------------------------------------


@NAMES.proof()
def second_order() -> dict[str, bool]:
    """Look at the second derivatives of ε along one displacement of a link of length 5."""
    size = Symbol("size")
    along = dict(zip(elements(U), (0, 0, 0, size, 0, 0), strict=True))
    path = [e.xreplace(along).xreplace(NUMBERS) for e in epsilon()]
    seen = {}
    for k, e in enumerate(path, 1):
        value, first, second = (sympy.diff(e, size, n).subs(size, 0) for n in range(3))
        linear = sympy.expand(expanded().meaning("ε_i")[k - 1, 0].xreplace(along))
        slope = sympy.diff(linear, size).xreplace(NUMBERS)
        seen[f"ε{k} = 0 + {first} u_i2 + {second / 2} u_i2² + … for l0 = 5 along (3, 4)"] = bool(
            value == 0 and first == slope and second != 0
        )
    return seen


@NAMES.proof()
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


@NAMES.proof()
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


@NAMES.proof()
def undeformed_is_turned() -> str:
    """With ψ = β − β0 at both ends, turn the link by ψ: it points as it does, up to its length."""
    x0, x = reference(), displaced(elements(U))
    psi = angle(x) - x0[2]
    c, s = (sympy.expand_trig(f(psi)) for f in (sympy.cos, sympy.sin))
    (a, b), (dx, dy) = span(x0), span(x)
    stretch = length(x0) / length(x)
    left, right = [c * a - s * b, s * a + c * b], [stretch * dx, stretch * dy]
    return equality(Vocabulary((PLACE, U), {}), column(left), column(right))


@NAMES.proof()
def rank() -> str:
    """Look at two minors of (15): their squares add up to l0⁴, so that one of them is not zero."""
    d, l0 = matrix(), length(reference())
    if d.shape != (3, 6):
        raise LedgerError(f"the matrix has shape {d.shape}")
    minors = [d.extract([0, 1, 2], [k, 2, 5]).det() for k in (3, 4)]
    seen = equality(Vocabulary((PLACE,), {}), sum(m**2 for m in minors), l0**4)
    return f"3 rows, 6 columns; the squares of two minors of size 3 have the sum l0⁴: {seen}"


# -- the code ------------------------------------------------------------------------------------


@NAMES.proof()
def is_position() -> str:
    """Compare the code's x = x0 + u with the words' own."""
    given = {"x_0": reference(), "u": elements(U)}
    words_of_code = Vocabulary((PLACE, U), {}, given)
    return equality(words_of_code, derived("x"), words().meanings["x_i"])


@NAMES.proof("the code's step for {step}")
def in_code(step: str, formula: str | Side) -> str:
    """Prove that a step of the code's derivation is a formula."""
    return equality(words(), derived(step), value_of(formula, words()))


@NAMES.proof("the code's step for {step}")
def at_reference_in_code(step: str, formula: str | Side) -> str:
    """Prove that a step about the reference position is a formula."""
    x = sympy.MatrixSymbol("x_0", 6, 1)
    values = {x[k, 0]: value for k, value in enumerate(reference())}
    return equality(words(), derived(step).xreplace(values), value_of(formula, words()))


@NAMES.proof("the code's length l")
def length_in_code(formula: str | Side) -> str:
    """Prove that the length from which the code's step for ε1 takes the design length is this."""
    return equality(words(), derived("epsilon_1") + length(reference()), value_of(formula, words()))


@NAMES.proof()
def is_variation() -> str:
    """Compare the code's δε at the reference, with δx = u, with (15) times u."""
    given = {**at(reference()), "δx": elements(U)}
    rows = [derived(f"δε_{k}") for k in (1, 2, 3)]
    linear = expanded().meaning("ε_i")
    words_of_code = replace(words(), given=given)
    seen = [equality(words_of_code, row, linear[k : k + 1, :]) for k, row in enumerate(rows)]
    return "; ".join(f"δε{k}: {text}" for k, text in enumerate(seen, 1))


@NAMES.proof()
def is_jacobian() -> str:
    """Compare the code's D with (15), at the reference, and its D anywhere with ∂ε/∂u."""
    words_of_code = replace(words(), given=at(reference()))
    (output,) = (o for f in code().functions for o in f.outputs if o.quantity.name == "D")
    names = {Symbol("length"): length(reference())}
    seen = equality(words_of_code, output.expression.xreplace(names), matrix())
    rows = ImmutableDenseMatrix([[sympy.diff(e, u) for u in elements(U)] for e in epsilon()])
    anywhere = equality(words(), output.expression.xreplace(names), rows)
    return f"at the reference (15), {seen}; displaced ∂ε/∂u, {anywhere}"


@NAMES.proof()
def is_wrapped(end: int) -> str:
    """Prove that the code's angle, found by atan2, is that of an end from the link."""
    functions = {f.name: f for f in code().functions}
    cell = functions["deformation"].outputs[0].components[end]
    x = displaced(elements(U))
    values = dict(zip(elements(X), x, strict=True)) | dict.fromkeys(elements(OFFSET), S.Zero)
    values |= {elements(LENGTH)[0]: length(reference())}
    ((s, c),) = (a.args for a in cell.atoms(sympy.atan2))
    relative = x[3 * end - 1] - angle(x)
    want = [length(x) * f(relative) for f in (sympy.sin, sympy.cos)]
    got = [value.xreplace(values) for value in (s, c)]
    return equality(words(), *(column([sympy.expand_trig(e) for e in v]) for v in (got, want)))
