"""Symbols of lecture 8.2 and their meaning; variations are differentiated, not stated.

A letter without a prime is read as the lecture defines it: components in frame O. A letter with a
prime has components in the frame of its body.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

from sympy import Integer, S
from sympy.matrices.expressions import Identity, MatrixSymbol, ZeroMatrix
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.ledger.formula import SymbolName
from kousoku.ledger.proof import GENERAL
from kousoku.ledger.registry import Names
from kousoku.ledger.turning import along, flat, orientation, spatial, turned
from kousoku.ledger.vocabulary import Vocabulary
from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.bodies import BODIES, CONFIGURATION, SYMBOLS, A
from kousoku.symbolic.components import cross, dot, plus, subtract
from kousoku.symbolic.matrices import OrientationMatrix, elements, mul, symbol, transpose
from kousoku.symbolic.sympy_types import Value, as_value

if TYPE_CHECKING:
    from kousoku.symbolic.sympy_types import Scalar, SymbolicMatrix

NAMES = Names(GENERAL)

QUANTITIES = {q.name: q for q in CONFIGURATION if q.shape}
#: δr in frame O and δθ′ in the body frame, by body.
DR = {b: Quantity(f"δr_{b}", (3,), "m", f"virtual displacement of body {b}") for b in BODIES}
DTHETA_B = {b: Quantity(f"δθ_{b}_b", (3,), "rad", f"virtual rotation of {b}") for b in BODIES}
#: How the frames at the points B_i and B_j are turned against those of their bodies.
TURNED = {b: Quantity(f"p_B{b}", (4,), "-", f"frame B_{b} against frame {b}") for b in BODIES}


def _in_frame_o(letter: str, body: str) -> list[Scalar]:
    """Elements of a vector that is fixed in a body."""
    return turned(QUANTITIES[f"p_{body}"], elements(QUANTITIES[f"{letter}_{body}_b"]))


def _varying() -> dict[str, list[Scalar]]:
    """Derivatives of all that varies, frame O, on the component level."""
    r = {b: elements(QUANTITIES[f"r_{b}"]) for b in BODIES}
    a, arm = ({b: _in_frame_o(letter, b) for b in BODIES} for letter in "as")
    d = subtract(plus(r["j"], arm["j"]), plus(r["i"], arm["i"]))
    return {
        **{f"A_{b}": flat(orientation(QUANTITIES[f"p_{b}"])) for b in BODIES},
        **{f"a_{b}": a[b] for b in BODIES},
        **{f"s_{b}": arm[b] for b in BODIES},
        "d": d,
        "C_n1": [dot(a["i"], a["j"])],
        "C_n2": [dot(a["i"], d)],
        "C_p1": cross(a["i"], a["j"]),
        "C_p2": cross(a["i"], d),
    }


def _array(name: str, size: int) -> Value:
    return as_value(MatrixSymbol(name, *((3, 3) if size == 9 else (size, 1))))


@NAMES.words
@cache
def words() -> Vocabulary:
    """Meanings of the symbols of the lecture's equations."""
    varying = _varying()
    delta = along(
        *((QUANTITIES[f"r_{b}"], DR[b]) for b in BODIES),
        *((QUANTITIES[f"p_{b}"], DTHETA_B[b]) for b in BODIES),
    )
    given = {
        **varying,
        **{f"δ{name}": [delta(x) for x in value] for name, value in varying.items()},
        **{f"δθ_{b}": spatial(QUANTITIES[f"p_{b}"], DTHETA_B[b]) for b in BODIES},
    }
    known = {name: _array(name, len(value)) for name, value in given.items()}
    meanings: dict[str, Scalar | SymbolicMatrix] = {
        "d^ij": known["d"],
        "δd^ij": known["δd"],
        "vec d^ij": known["d"],
        "A^ij": mul(transpose(A["i"]), A["j"]),
    }
    for kind in ("n1", "n2", "p1", "p2"):
        meanings |= {f"{mark}C^({kind})": known[f"{mark}C_{kind}"] for mark in ("", "δ")}
    for body in BODIES:
        meanings |= _of_body(body, known)
    quantities = (*QUANTITIES.values(), *DR.values(), *DTHETA_B.values())
    return Vocabulary(quantities, meanings, given)


def _of_body(b: str, known: dict[str, Value]) -> dict[str, Scalar | SymbolicMatrix]:
    """Meanings of one body's symbols; its virtual rotation has two names."""
    return {
        f"r^{b}": SYMBOLS[f"r_{b}"],
        f"vec r^{b}": SYMBOLS[f"r_{b}"],
        f"δr^{b}": symbol(DR[b]),
        f"A^O{b}": A[b],
        f"δA^O{b}": known[f"δA_{b}"],
        f"a^{b}": known[f"a_{b}"],
        f"vec a^{b}": known[f"a_{b}"],
        f"a'^{b}": SYMBOLS[f"a_{b}_b"],
        f"δa^{b}": known[f"δa_{b}"],
        f"δa'^{b}": ZeroMatrix(3, 1),
        f"s_{b}^B": known[f"s_{b}"],
        f"vec s_{b}^B": known[f"s_{b}"],
        f"δs_{b}^B": known[f"δs_{b}"],
        f"s'_{b}^B": SYMBOLS[f"s_{b}_b"],
        f"δs'_{b}^B": ZeroMatrix(3, 1),
        **{f"δθ^{index}": known[f"δθ_{b}"] for index in (b, f"O{b}")},
        **{f"δθ'^{index}": symbol(DTHETA_B[b]) for index in (b, f"O{b}")},
    }


@NAMES.words
@cache
def offset() -> Vocabulary:
    """Vocabulary with d and δd as quantities in place of r^j and δr^j.

    r^j = d + r^i + s_i − s_j takes every value as d does, and δr^j as δd does: what holds
    identically for one holds for the other, and is shorter here.
    """
    known = words()
    d = Quantity("d", (3,), "m", "vector between the points, frame O")
    change = Quantity("δd", (3,), "m", "its variation")
    a = _in_frame_o("a", "i")
    values = {"C_n2": [dot(a, elements(d))], "C_p2": cross(a, elements(d))}
    delta = along((d, change), (QUANTITIES["p_i"], DTHETA_B["i"]))
    given = {name: x for name, x in known.given.items() if name not in {"d", "δd"}}
    given |= values
    given |= {f"δ{name}": [delta(x) for x in value] for name, value in values.items()}
    for mark, origin, free in (("", QUANTITIES["r_i"], d), ("δ", DR["i"], change)):
        arms = [known.given[f"{mark}s_{b}"] for b in BODIES]
        from_i = plus(elements(origin), arms[0])
        given[f"{mark}r_j"] = subtract(plus(elements(free), from_i), arms[1])
    instead = {"r_j": d, "δr_j": change}
    quantities = tuple(instead.get(q.name, q) for q in known.quantities)
    return replace(known, quantities=quantities, given=given)


@NAMES.words
@cache
def together() -> Vocabulary:
    """Words with both points in one place: r^j = r^i + s_i − s_j, and d = 0."""
    known = offset()
    d = elements(next(q for q in known.quantities if q.name == "d"))
    zero = dict.fromkeys(d, S.Zero)
    given = {name: [x.xreplace(zero) for x in value] for name, value in known.given.items()}
    return replace(known, given={**given, "d": [S.Zero] * 3})


@NAMES.words
@cache
def frames() -> Vocabulary:
    """Meanings of the base vectors: their components in frame O, and rows of them."""
    known = words()
    given: dict[str, list[Scalar]] = {}
    meanings: dict[str, Scalar | SymbolicMatrix] = {"e^(O)": Identity(3)}
    unit = {x: [Integer(k == n) for k in range(3)] for n, x in enumerate("xyz")}
    for x, e in unit.items():
        meanings[f"vec e_{x}^(O)"] = ImmutableDenseMatrix(3, 1, e)
    for body in BODIES:
        at_point = OrientationMatrix(symbol(TURNED[body]))
        meanings[f"e^({body})"] = transpose(A[body])
        meanings[f"b^({body})"] = transpose(mul(A[body], at_point))
        for x, e in unit.items():
            p = QUANTITIES[f"p_{body}"]
            for letter, base in (("e", e), ("b", turned(TURNED[body], e))):
                given[f"{letter}_{x}_{body}"] = turned(p, base)
                meanings[f"vec {letter}_{x}^({body})"] = _array(f"{letter}_{x}_{body}", 3)
    return Vocabulary(
        (*known.quantities, *TURNED.values()),
        {**known.meanings, **meanings},
        {**known.given, **given},
    )


def primed(name: SymbolName) -> tuple[SymbolName, ...]:
    """Readings of a printed symbol: without a prime, and with one if that is known.

    A capital I in front of the superscript is a prime that was misread.
    """
    bare = SymbolName(name.letter, "", name.sub, name.sup.removeprefix("I"))
    ways = (bare, SymbolName(name.letter, "'", name.sub, bare.sup))
    known = words().meanings
    return tuple(way for way in ways if str(way) in known) or (name,)
