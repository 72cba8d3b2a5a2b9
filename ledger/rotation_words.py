"""What the symbols of lecture 7.1 mean, and what ties them to the code's derivation."""

from __future__ import annotations

from functools import cache
from typing import Any

from sympy.matrices.expressions import Identity, MatrixSymbol

from kousoku.ledger.entry import Check
from kousoku.ledger.proof import equal, equality, value_of
from kousoku.ledger.turning import along, flat, orientation, spatial, turned
from kousoku.ledger.vocabulary import Vocabulary
from kousoku.model.errors import LedgerError
from kousoku.model.quantity import Quantity
from kousoku.symbolic import derive
from kousoku.symbolic.components import plus
from kousoku.symbolic.matrices import Orientation, elements, symbol

R = Quantity("r", (3,), "m", "position of frame B's origin, frame O")
P = Quantity("p", (4,), "-", "Euler parameters of frame B")
S_B = Quantity("s_b", (3,), "m", "point P, frame B")
DR = Quantity("dr", (3,), "m", "virtual displacement of frame B's origin, frame O")
DTHETA_B = Quantity("dtheta_b", (3,), "rad", "virtual rotation, frame B")
OMEGA_B = Quantity("omega_b", (3,), "rad/s", "angular velocity, frame B")


@cache
def words() -> Vocabulary:
    """Return what the lecture's symbols mean; δA, δs, δr and δθ are differentiated, not stated."""
    delta, rate = along((R, DR), (P, DTHETA_B)), along((P, OMEGA_B))
    arm = turned(P, elements(S_B))
    a = Orientation(symbol(P))
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


def derived(function: str, output: str) -> Any:
    """Return what the code's derivation of the rotation says an output is."""
    functions = {f.name: f for f in derive("rotation").functions}
    found = {o.quantity.name: o.expression for o in functions[function].outputs}
    return found[output]


def in_code(function: str, output: str, formula: str) -> Check:
    """Return the check that an output of the code's rotation is what a formula says."""
    statement = f"the code's rotation.{function} gives this as {output}"
    return equal(statement, words, lambda: derived(function, output), formula)


def in_steps(key: str, formula: str) -> Check:
    """Return the check that the code's steps from an equation are about what a formula says.

    Of steps on the virtual rotation alone, both sides of each are compared with the formula.
    """

    def run() -> str:
        sources = [step.source.split(", ") for step in derive("rotation").steps]
        of_motion = next(k for k, keys in enumerate(sources) if "5.16" in keys)
        steps = derive("rotation").steps[:of_motion]
        own = [step for step, keys in zip(steps, sources, strict=False) if key in keys]
        if not own:
            raise LedgerError(f"the code has no step from {key}")
        wanted = value_of(formula, words())
        seen = [equality(words(), s, wanted) for step in own for s in (step.left, step.right)]
        return f"{len(own)}, both sides: {seen[0]}"

    return Check("the code's steps that cite this", run)
