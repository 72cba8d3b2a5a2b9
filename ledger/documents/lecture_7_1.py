"""Lecture 7.1: the meaning of its symbols, and how its equations meet the code's derivation."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any

from sympy.matrices.expressions import Identity, MatrixSymbol, ZeroMatrix

from kousoku.ledger import entries, find
from kousoku.ledger.parser import parse
from kousoku.ledger.proof import GENERAL, derived, difference, equality, value_of
from kousoku.ledger.registry import Names
from kousoku.ledger.turning import along, flat, orientation, spatial, turned
from kousoku.ledger.vocabulary import Vocabulary
from kousoku.model.errors import LedgerError
from kousoku.model.files.quantity import Quantity
from kousoku.symbolic import derive
from kousoku.symbolic.components import Flow, cross, half_turn, plus
from kousoku.symbolic.matrices import OrientationMatrix, elements, symbol

if TYPE_CHECKING:
    from kousoku.ledger.proof import Side

NAMES = Names(GENERAL)

R = Quantity("r", (3,), "m", "position of frame B's origin, frame O")
P = Quantity("p", (4,), "-", "Euler parameters of frame B")
S_B = Quantity("s_b", (3,), "m", "point P, frame B")
DR = Quantity("dr", (3,), "m", "virtual displacement of frame B's origin, frame O")
DTHETA_B = Quantity("dtheta_b", (3,), "rad", "virtual rotation, frame B")
OMEGA_B = Quantity("omega_b", (3,), "rad/s", "angular velocity, frame B")


@NAMES.words
@cache
def words() -> Vocabulary:
    """Vocabulary of the lecture; δA, δs, δr and δθ are differentiated, not stated."""
    delta, rate = along((R, DR), (P, DTHETA_B)), along((P, OMEGA_B))
    arm = turned(P, elements(S_B))
    a = OrientationMatrix(symbol(P))
    given: dict[str, list[Any]] = {
        "r_P": plus(elements(R), arm),
        "δA": [delta(x) for x in flat(orientation(P))],
        "s": arm,
        "δs": [delta(x) for x in arm],
        "δr_P": [delta(x) for x in plus(elements(R), arm)],
        "δθ": spatial(P, DTHETA_B),
        "A_dot": [rate(x) for x in flat(orientation(P))],
        "ω": spatial(P, OMEGA_B),
    }
    meanings = {
        "A^OB": a,
        "I_3": Identity(3),
        "r^B": symbol(R),
        "r^P": MatrixSymbol("r_P", 3, 1),
        "s'^P": symbol(S_B),
        "s^P": MatrixSymbol("s", 3, 1),
        "δr^B": symbol(DR),
        "δr^P": MatrixSymbol("δr_P", 3, 1),
        "δs^P": MatrixSymbol("δs", 3, 1),
        "δA^OB": MatrixSymbol("δA", 3, 3),
        "δθ^OB": MatrixSymbol("δθ", 3, 1),
        "δθ'^OB": symbol(DTHETA_B),
        "d/dt A^OB": MatrixSymbol("A_dot", 3, 3),
        "ω^OB": MatrixSymbol("ω", 3, 1),
        "ω'^OB": symbol(OMEGA_B),
    }
    return Vocabulary((R, P, S_B, DR, DTHETA_B, OMEGA_B), meanings, given)


@NAMES.proof("the code's rotation.{function} gives this as {output}")
def in_code(function: str, output: str, formula: str | Side) -> str:
    """Prove that an output of the code's rotation is that of a formula."""
    return equality(words(), derived("rotation", function, output), value_of(formula, words()))


@NAMES.proof("the code's steps that cite this")
def in_steps(key: str, formula: str | Side) -> str:
    """Prove that the code's steps from an equation are about a formula.

    Of steps on the virtual rotation alone, both sides of each are compared with the formula.
    """
    sources = [step.source.split(", ") for step in derive("rotation").steps]
    of_motion = next(k for k, keys in enumerate(sources) if "5.16" in keys)
    steps = derive("rotation").steps[:of_motion]
    own = [step for step, keys in zip(steps, sources, strict=False) if key in keys]
    if not own:
        raise LedgerError(f"the code has no step from {key}")
    wanted = value_of(formula, words())
    seen = [equality(words(), s, wanted) for step in own for s in (step.left, step.right)]
    return f"{len(own)}, both sides: {seen[0]}"


# -- the number that is missing ------------------------------------------------------------------


def missing_number() -> str:
    """Number that is free where 7.1.9 stands.

    Raises
    ------
    LedgerError
        The numbers around are others, or none is free there.
    """
    numbers = [e.equation for e in entries() if e.equation.startswith("7.")]
    place = numbers.index("7.1.9")
    around = numbers[place - 1], numbers[place + 1]
    if around != ("7.12", "7.14") or "7.13" in numbers:
        raise LedgerError(f"7.1.9 stands between {around}")
    return "7.13"


@NAMES.proof()
def is_out_of_order() -> str:
    """Prove that the number as printed is not the one that its place asks for."""
    free = missing_number()
    return f"7.1.9 stands between 7.12 and 7.14; no equation is printed as ({free}), which is cited"


@NAMES.proof()
def is_missing_number(formula: str) -> str:
    """Prove that the number of a formula is the one that is missing."""
    if not formula.endswith(rf"\quad ({missing_number()})"):
        raise LedgerError("the number is another one")
    return f"({missing_number()}), the one that is missing between 7.12 and 7.14"


# -- rotation and angular velocity ---------------------------------------------------------------


@NAMES.proof()
def rotations_do_not_commute() -> str:
    """Turn by a, then by b, and the other way round: the two differ by a turn about a × b."""
    a = Quantity("a", (3,), "rad", "first rotation")
    b = Quantity("b", (3,), "rad", "second rotation")
    p = elements(P)
    first, second = (Flow(dict(zip(p, half_turn(p, elements(x)), strict=True)), ()) for x in (a, b))
    apart = [first(second(e)) - second(first(e)) for e in p]
    about = half_turn(p, cross(elements(a), elements(b)))
    known = Vocabulary((P, a, b), {}, {"apart": apart, "about": about})
    seen = equality(known, MatrixSymbol("apart", 4, 1), MatrixSymbol("about", 4, 1))
    witness = difference(known, MatrixSymbol("about", 4, 1), ZeroMatrix(4, 1))
    if not witness:
        raise LedgerError("any two rotations commute")
    return f"{seen}; not zero: {witness}"


def _moving() -> Vocabulary:
    """Words with ω′ in place of δθ′."""
    swap = dict(zip(elements(DTHETA_B), elements(OMEGA_B), strict=True))
    known = words()
    given = {name: [x.xreplace(swap) for x in cells] for name, cells in known.given.items()}
    return replace(known, given=given).knowing({"δθ'^OB": symbol(OMEGA_B)})


@NAMES.proof()
def rate_is_variation() -> str:
    """Put ω′ in place of δθ′ in δA: it is dA/dt."""
    return equality(_moving(), MatrixSymbol("δA", 3, 3), words().meanings["d/dt A^OB"])


@NAMES.proof()
def sides_correspond(variation: str, rate: str) -> str:
    """Put ω′ in place of δθ′ in one entry: its sides are those of another, the last two swapped."""
    known = _moving()
    (varied,), (moved,) = (parse(find(key).true_form) for key in (variation, rate))
    left, in_body, in_space = moved.sides
    pairs = zip(varied.sides, (left, in_space, in_body), strict=True)
    return "; ".join(
        f"side {k}, {equality(known, known.value(one), known.value(other))}"
        for k, (one, other) in enumerate(pairs, 1)
    )
