"""What the symbols of (30) to (32) and (34) mean: the slider's place, and when a crank can turn.

The slider is where the rod closes: (x − l1 cos α)² + (l1 sin α)² = l2², on the side x > 0. Its
velocity and acceleration follow by differentiating that condition, not the formula for x.
"""

from __future__ import annotations

import re
from functools import cache
from typing import TYPE_CHECKING, Any

import sympy
from sympy import S, Symbol

from kousoku.ledger.link_iteration import DIVISIONS, MP, RESIDUAL, run
from kousoku.ledger.link_mechanisms import LEVER_CRANK, PISTON_CRANK
from kousoku.ledger.link_motion import ACCELERATION as ACCELERATION_OF_ALPHA
from kousoku.ledger.link_motion import RATE
from kousoku.ledger.link_motion import words as motion_words
from kousoku.ledger.parser import parse
from kousoku.ledger.proof import equality, value_of
from kousoku.ledger.vocabulary import Vocabulary
from kousoku.model.errors import LedgerError
from kousoku.model.quantity import Quantity

if TYPE_CHECKING:
    from collections.abc import Callable

POSITION = r"(x \text{ 座標}) = l_1 \cos \alpha + \sqrt{l_2^2 - l_1^2 \sin^2 \alpha}"
VELOCITY = (
    r"(x \text{ 座標方向の速度}) = -l_1 \sin \alpha"
    r" - l_1^2 \sin \alpha \cos \alpha / \sqrt{l_2^2 - l_1^2 \sin^2 \alpha}"
)
ACCELERATION = (
    r"(x \text{ 座標方向の加速度}) = -l_1 \cos \alpha"
    r" - l_1^2 (l_1^2 \sin^4 \alpha + l_2^2 \cos 2\alpha)"
    r" / (l_2^2 - l_1^2 \sin^2 \alpha) / \sqrt{l_2^2 - l_1^2 \sin^2 \alpha}"
)
FORMULAS = (POSITION, VELOCITY, ACCELERATION)
#: (34) as printed.
GRASHOF = (
    r"\begin{cases} l_1 + l_2 \leq l_3 + l_4 \\ l_1 + l_3 \leq l_2 + l_4 \\"
    r" l_1 + l_4 \leq l_2 + l_3 \end{cases}"
)
L1, L2, L3, L4, ALPHA, X = sympy.symbols("l_1 l_2 l_3 l_4 α x")
LENGTHS = tuple(Quantity(f"l_{k}", (), "m", f"length of link {k}") for k in (1, 2, 3, 4))
ANGLE = Quantity("α", (), "rad", "the crank's angle")
#: By how much the right sides of (34) are larger.
SPARE = tuple(Quantity(f"d_{k}", (), "m", f"spare length of inequality {k}") for k in (1, 2, 3))

Scalar = Any


def _closure(x: Scalar) -> Scalar:
    """Return by how much the rod's length squared is missed."""
    c, s = sympy.cos(ALPHA), sympy.sin(ALPHA)
    return (x - L1 * c) ** 2 + (L1 * s) ** 2 - L2**2


def slider() -> tuple[Scalar, Scalar, Scalar]:
    """Return place, velocity and acceleration of the slider for dα/dt = 1, d²α/dt² = 0."""
    missed = sympy.Poly(sympy.expand(_closure(X)), X)
    square, linear, constant = missed.all_coeffs()
    half = -linear / (2 * square)
    place = half + sympy.sqrt(half**2 - constant / square)  # the larger root
    closure = _closure(X)
    slope = -closure.diff(ALPHA) / closure.diff(X)
    curve = slope.diff(ALPHA) + slope.diff(X) * slope
    at = {X: place}
    return place, slope.xreplace(at), curve.xreplace(at)


@cache
def words() -> Vocabulary:
    """Return the words of (30) to (32)."""
    names = ("x座標", "x座標方向の速度", "x座標方向の加速度")
    meanings = dict(zip(names, slider(), strict=True))
    meanings |= {"l_1": L1, "l_2": L2, "α": ALPHA}
    return Vocabulary((*LENGTHS[:2], ANGLE), meanings)


def closes() -> str:
    """Put (30) into the condition that the rod closes."""
    seen = equality(words(), _closure(value_of(POSITION, words())), S.Zero)
    other = L1 * sympy.cos(ALPHA) - sympy.sqrt(L2**2 - L1**2 * sympy.sin(ALPHA) ** 2)
    product = equality(words(), value_of(POSITION, words()) * other, L1**2 - L2**2)
    return f"{seen}; with l1 < l2 the two roots have different signs, their product {product}"


# -- the computed motion -------------------------------------------------------------------------


def steps_end_small(name: str) -> Callable[[], dict[str, bool]]:
    """Return what is seen of the residuals of a turn."""

    def seen() -> dict[str, bool]:
        done = run(name)
        text = f"{len(done.corrections)} steps end with at most {done.residual:.1e} cm"
        return {text: len(done.corrections) == DIVISIONS and done.residual <= float(RESIDUAL)}

    return seen


def counted_in(sentence: str) -> tuple[int, int]:
    """Return the numbers of iterations that a sentence states: ``6回~7回``, or ``10回``."""
    numbers = [int(number) for number in re.findall(r"(\d+)回", sentence)]
    return numbers[0], numbers[-1]


def takes(name: str, sentence: str, *, is_true: bool) -> Callable[[], str]:
    """Return the check that a sentence states how many corrections a turn takes, or does not."""

    def seen() -> str:
        least, most = run(name).range
        if ((least, most) == counted_in(sentence)) is not is_true:
            raise LedgerError(f"it takes {least} to {most}")
        return _counted(least, most)

    return seen


def takes_when_renewed(name: str, passes: tuple[int, int]) -> Callable[[], str]:
    """Return what counts the passes of an iteration that renews x″ as well."""

    def seen() -> str:
        least, most = run(name, renews=True).range
        if (least + 1, most + 1) != passes:
            raise LedgerError(f"it takes {least} to {most} corrections")
        return f"corrections {_counted(least, most)}, passes {_counted(*passes)}"

    return seen


def _counted(least: int, most: int) -> str:
    return f"{least} to {most}" if least < most else f"{least} at every step"


def agrees() -> dict[str, bool]:
    """Compare the computed slider with (30) to (32) at all 61 positions."""
    lengths = {L1: S(PISTON_CRANK.lengths[0]), L2: S(PISTON_CRANK.lengths[1])}
    formulas = [value_of(formula, words()).xreplace(lengths) for formula in FORMULAS]
    column = PISTON_CRANK.names.index("u_3")
    worst = [0.0, 0.0, 0.0]
    for k, state in enumerate(run("piston").states):
        angle = sympy.Float(str(2 * MP.pi * k / DIVISIONS), MP.dps)
        for order, (formula, motion) in enumerate(zip(formulas, state, strict=True)):
            exact = formula.evalf(MP.dps, subs={ALPHA: angle})
            apart = abs(float(exact - sympy.Float(str(motion[column]), MP.dps)))
            worst[order] = max(worst[order], apart)
    names = ("place", "velocity", "acceleration")
    return {
        f"{name} within {error:.0e}": error < 1e-12
        for name, error in zip(names, worst, strict=True)
    }


def rates_are_slopes() -> str:
    """Put dα/dt = 1 and d²α/dt² = 0 into velocity and acceleration."""
    known = motion_words()
    unit = {RATE: S.One, ACCELERATION_OF_ALPHA: S.Zero}
    pairs = (("d/dt x", "x'"), ("d²/dt² x", "x''"))
    seen = [equality(known, known.meanings[a].xreplace(unit), known.meanings[b]) for a, b in pairs]
    return f"velocity is x′, {seen[0]}; acceleration is x″, {seen[1]}"


# -- when a crank can turn -----------------------------------------------------------------------


@cache
def turning() -> Vocabulary:
    """Return the words of (34): lengths by how much shorter the left sides are, none negative."""
    first, second, third = (Symbol(q.name) for q in SPARE)
    meanings = {
        "l_1": L1,
        "l_2": L1 + (second + third) / 2,
        "l_3": L1 + (first + third) / 2,
        "l_4": L1 + (first + second) / 2,
    }
    return Vocabulary((LENGTHS[0], *SPARE), meanings)


def _spare() -> list[Scalar]:
    """Return the right sides of (34) less the left ones, for any lengths."""
    meanings = {"l_1": L1, "l_2": L2, "l_3": L3, "l_4": L4}
    known = Vocabulary(LENGTHS, meanings)
    return [
        known.value(right) - known.value(left)
        for left, right in (statement.sides for statement in parse(GRASHOF))
    ]


def full_turn() -> dict[str, bool]:
    """Follow the distance of O2 from O4, between which coupler and lever must reach."""
    first, second, third = _spare()
    farthest = (L2 + L3) ** 2 - (L1 + L4) ** 2
    nearest = (L1 - L4) ** 2 - (L2 - L3) ** 2
    whole = L1 + L2 + L3 + L4
    sums = (
        (first + second, 2 * (L4 - L1)),
        (first + third, 2 * (L3 - L1)),
        (second + third, 2 * (L2 - L1)),
    )
    return {
        "farthest, at α = π: (l2 + l3)² − (l1 + l4)² is the spare length of the third inequality"
        " times the sum of all lengths": sympy.expand(farthest - third * whole) == 0,
        "nearest, at α = 0: (l4 − l1)² − (l2 − l3)² is the product of the other two, which are"
        " both positive where l1 < l4": sympy.expand(nearest - first * second) == 0,
        "the sums of any two are twice l4 − l1, l3 − l1, l2 − l1: l1 is the shortest link": all(
            sympy.expand(one - other) == 0 for one, other in sums
        ),
    }


def without_it() -> dict[str, bool]:
    """Look at a mechanism whose frame is shorter than its crank: it turns, and (34) fails."""
    lengths = {L1: S(60), L2: S(80), L3: S(100), L4: S(30)}
    turns = abs(80 - 100) <= abs(60 - 30) and 60 + 30 <= 80 + 100
    failing = [spare.xreplace(lengths) < 0 for spare in _spare()]
    return {
        "60, 80, 100 and a frame of 30: both cranks turn, the first two fail": turns
        and failing == [True, True, False]
    }


def is_strict() -> dict[str, bool]:
    """Put in the lengths of the example: the links are never all in line."""
    lengths = dict(zip((L1, L2, L3, L4), map(S, LEVER_CRANK.lengths), strict=True))
    spare = [int(s.xreplace(lengths)) for s in _spare()]
    shown = ", ".join(str(s) for s in spare)
    return {f"30, 60, 80, 100 leave {shown} cm to spare": spare == [90, 50, 10]}
