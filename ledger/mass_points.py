"""Three mass points: points that are fixed in a frame, and Newton's law of each of them."""

from __future__ import annotations

from functools import cache, partial
from typing import Any

from sympy import S
from sympy.matrices.expressions import MatrixSymbol, ZeroMatrix

from kousoku.ledger import mass_matrix, mass_sums
from kousoku.ledger.checks import different, equal
from kousoku.ledger.entry import MASS_POINTS, Check, Entry
from kousoku.ledger.mass_words import (
    ACCELERATION,
    MOTION,
    K,
    M,
    added,
    any_vectors,
    carried,
    centred,
    free,
    in_step,
    one_point,
    over_points,
    rate,
    scaled,
    words,
)
from kousoku.ledger.proof import difference, equality
from kousoku.ledger.vocabulary import Vocabulary
from kousoku.model.errors import LedgerError
from kousoku.model.quantity import Quantity
from kousoku.symbolic.components import Flow, cross, dot, plus, subtract
from kousoku.symbolic.matrices import elements, neg, symbol

_entry = partial(Entry, MASS_POINTS)

MOMENTS = r"\vec r_{A1} \times \vec f_{12} + \vec r_{A2} \times \vec f_{21}"
ABOUT_THE_LINE = r"\begin{array}{c} C_{OA} cross(r_{A0}^A) t \\ t \end{array}"

ZERO = ZeroMatrix(3, 1)
ARMS = tuple(Quantity(f"r_{k}", (3,), "m", f"point {k}") for k in (1, 2))
SPEEDS = tuple(Quantity(f"v_{k}", (3,), "m/s", f"velocity of point {k}") for k in (1, 2))
INNER = Quantity("f_12", (3,), "N", "force on point 1 from point 2, in any direction")


@cache
def opposite() -> Vocabulary:
    """Return two points and internal forces that are opposite, and no more than that."""
    words = free({"vec r_A1": ARMS[0], "vec r_A2": ARMS[1], "vec f_12": INNER})
    return words.knowing({"vec f_21": neg(symbol(INNER))})


@cache
def newton() -> Vocabulary:
    """Return one point with its mass m, its acceleration a, and f, the change of m v."""
    known, change = one_point(), rate()
    momentum = scaled(elements(M)[0], known.given["v_Oi^O"])
    given = {**known.given, "f": change(momentum)}
    meanings = {"m": elements(M)[0], "a": known.meanings["a_Oi^O"], "f": MatrixSymbol("f", 3, 1)}
    return Vocabulary(known.quantities, {**known.meanings, **meanings}, given)


@cache
def on_one_line() -> Vocabulary:
    """Return what the symbols mean for points on a line: through point 0, in direction t."""
    start, line = Quantity("s_0", (3,), "m", "point 0"), Quantity("t", (3,), "-", "direction")
    along_line = Quantity("x", (3,), "-", "where on the line each point is")
    places = [plus(elements(start), scaled(x, elements(line))) for x in elements(along_line)]
    known = carried("123", places, (*MOTION, M, start, line, along_line, K))
    return known.knowing({"r_A0^A": symbol(start), "t": symbol(line)})


def _fixed_distances() -> str:
    change, given = rate(), words().given
    for one, other in (("1", "2"), ("1", "3"), ("2", "3")):
        apart = subtract(given[f"r_O{one}^O"], given[f"r_O{other}^O"])
        seen = equality(words(), change([dot(apart, apart)])[0], S.Zero)
    return f"for all three pairs: {seen}"


def _spin_up() -> str:
    """Let two points move by their internal forces alone: Σ r × m v changes by the moment."""
    masses, force = Quantity("m", (2,), "kg", "masses"), elements(INNER)
    direction: dict[Any, Any] = {}
    for k, sign in enumerate((1, -1)):
        direction |= dict(zip(elements(ARMS[k]), elements(SPEEDS[k]), strict=True))
        pulled = [sign * x / elements(masses)[k] for x in force]
        direction |= dict(zip(elements(SPEEDS[k]), pulled, strict=True))
    flow = Flow(direction, ())
    turning = added(
        [
            scaled(m, cross(elements(r), elements(v)))
            for m, r, v in zip(elements(masses), ARMS, SPEEDS, strict=True)
        ]
    )
    moment = added([cross(elements(ARMS[0]), force), cross(elements(ARMS[1]), scaled(-1, force))])
    given = {"change": [flow(x) for x in turning], "moment": moment}
    known = Vocabulary((*ARMS, *SPEEDS, INNER, masses), {}, given)
    change = MatrixSymbol("change", 3, 1)
    seen = equality(known, change, MatrixSymbol("moment", 3, 1))
    witness = difference(known, change, ZERO)
    if not witness:
        raise LedgerError("opposite forces never turn the points")
    return f"{seen}; not zero: {witness}"


POINTS: tuple[Entry, ...] = (
    _entry(
        "points-fixed",
        "holds",
        r"質点1,2,3は座標系Aに固定されている(逆に,点1,2,3に座標系Aを固定している,ともいえる)",
        reason="The components r_Ai^A do not change. The other way round, the points fix a frame"
        " where they are not on one line.",
        checks=(
            Check("what frame A carries keeps its distances", _fixed_distances),
            equal(
                "a turn about a line that holds all points asks for no force and no moment",
                on_one_line,
                f"{mass_matrix.MATRIX} {ABOUT_THE_LINE}",
                lambda: ZeroMatrix(6, 1),
            ),
        ),
        is_sentence=True,
    ),
    _entry(
        "action-reaction",
        "holds",
        r"\vec f_{12} = -1 * \vec f_{21}",
        reason="Newton's third law.",
        vocabulary=words,
    ),
    _entry(
        "cancelling-moments",
        "misprint",
        r"打ち消しあう内力に同士によるモーメントも打ち消しあうので",
        r"2点を結ぶ直線に沿って打ち消しあう内力に同士によるモーメントも打ち消しあうので",
        "That two forces cancel is not enough for their moments to cancel: they must also act along"
        " the line between the two points.",
        refutation=(
            different(
                "the moments of opposite forces in any direction do not cancel",
                opposite,
                MOMENTS,
                lambda: ZERO,
            ),
        ),
        checks=(
            equal(
                "the moments of opposite forces are (r_A1 − r_A2) × f_12",
                opposite,
                MOMENTS,
                r"(\vec r_{A1} - \vec r_{A2}) \times \vec f_{12}",
            ),
            equal("those of forces along the line cancel", words, MOMENTS, lambda: ZERO),
        ),
        is_sentence=True,
    ),
    _entry(
        "internal-moments",
        "holds",
        MOMENTS + r" = 0",
        reason="It holds for internal forces along the line between the two points.",
        vocabulary=words,
    ),
    _entry(
        "internal-spin",
        "holds",
        r"打ち消されないとすると,内力によって回転することになってしまう",
        reason="The moment of the internal forces would change the angular momentum of the points"
        " on which nothing else acts.",
        checks=(Check("d/dt Σ r × m v = r_1 × f_12 + r_2 × f_21", _spin_up),),
        is_sentence=True,
    ),
    _entry(
        "position",
        "holds",
        r"r_{Oi}^O = r_{OA}^O + C_{OA} r_{Ai}^A",
        vocabulary=one_point,
        checks=(
            equal(
                "r_Ai^A are the components of r_Oi − r_OA in frame A",
                one_point,
                r"C_{OA}^T (r_{Oi}^O - r_{OA}^O)",
                r"r_{Ai}^A",
            ),
            in_step("mass_points", "r_1", r"r_{OA}^O + C_{OA} r_{A1}^A"),
        ),
    ),
    _entry(
        "velocity",
        "holds",
        r"v_{Oi}^O = v_{OA}^O + C_{OA} cross(\omega_{A}^A) r_{Ai}^A",
        reason="The position, differentiated; r_Ai^A is constant.",
        vocabulary=one_point,
        checks=(in_step("mass_points", "v_1", r"v_{OA}^O + C_{OA} cross(\omega_{A}^A) r_{A1}^A"),),
    ),
    _entry(
        "swapped-sign",
        "holds",
        r"入れ替えると符号が逆になるので",
        checks=(equal("cross(a) b = −cross(b) a", any_vectors, "cross(a) b", "-cross(b) a"),),
        is_sentence=True,
    ),
    _entry(
        "swapped-velocity",
        "holds",
        r"v_{Oi}^O = v_{OA}^O - C_{OA} cross(r_{Ai}^A) \omega_{A}^A",
        vocabulary=one_point,
    ),
    _entry(
        "acceleration",
        "holds",
        r"\begin{eqnarray} a_{Oi}^O &=& a_{OA}^O"
        r" - (\frac{d}{dt}C_{OA}) cross(r_{Ai}^A) \omega_{A}^A"
        r" - C_{OA} cross(r_{Ai}^A)  \{\frac{d}{dt}\omega_{A}^A \}\\"
        r" &=& a_{OA}^O - \{C_{OA} cross(\omega_{A}^A)  \} cross(r_{Ai}^A) \omega_{A}^A"
        r" - C_{OA} cross(r_{Ai}^A)  \{\frac{d}{dt}\omega_{A}^A \}\\ \end{eqnarray}",
        reason="The position, differentiated twice.",
        vocabulary=one_point,
        checks=(
            equal(
                "dC_OA/dt = C_OA cross(ω)",
                one_point,
                r"\frac{d}{dt}C_{OA}",
                r"C_{OA} cross(\omega_{A}^A)",
            ),
            in_step("mass_points", "a_1", ACCELERATION.replace("Ai", "A1")),
        ),
    ),
    _entry(
        "newton",
        "holds",
        r"ma = f",
        reason="Newton's second law, for a point whose mass is constant: f is the change of m v.",
        vocabulary=newton,
    ),
    _entry(
        "point-equation",
        "misprint",
        rf"m_i \langle {ACCELERATION}\rangle = f_i^O + f_{{ij}}^O",
        rf"m_i \langle {ACCELERATION}\rangle = f_i^O + f_{{ij}}^O + f_{{ik}}^O",
        "The index j is free: the internal forces of both other points, j and k, belong there.",
        vocabulary=one_point,
    ),
    _entry(
        "first-term",
        "misprint",
        r"第1項 : 重心の慣性力",
        r"第1項 : 重心の慣性力(座標系Aの原点が重心と一致する場合)",
        "The first term, summed over the points, is M_A times the acceleration of the origin of"
        " frame A. That is the inertial force of the centre of mass only where the two coincide.",
        refutation=(
            different(
                "Σ m_i a_OA is not M_A a_OG",
                words,
                r"\{m_1 + m_2 + m_3\} a_{OA}^O",
                r"M_A a_{OG}^O",
            ),
        ),
        checks=(
            equal(
                "it is where the centre of mass is the origin",
                centred,
                r"\{m_1 + m_2 + m_3\} a_{OA}^O",
                r"M_A a_{OG}^O",
            ),
        ),
        is_sentence=True,
    ),
    _entry(
        "second-term",
        "holds",
        r"第2項 : ジャイロ効果",
        reason="Its moment about the origin of frame A, summed over the points, is the gyroscopic"
        " one. The term itself is the centripetal force, which a plane has too.",
        checks=(
            equal(
                "its moment is cross(ω) I_A ω",
                words,
                over_points(
                    r"- cross(r_{A#}^A) C_{OA}^T m_# \{C_{OA} cross(\omega_{A}^A) \}"
                    r" cross(r_{A#}^A) \omega_{A}^A"
                ),
                r"cross(\omega_{A}^A) I_A^A \omega_{A}^A",
            ),
        ),
        is_sentence=True,
    ),
    _entry(
        "third-term",
        "holds",
        r"第3項 : 回転の慣性力",
        reason="Its moment about the origin of frame A, summed over the points, is I_A dω/dt.",
        checks=(
            equal(
                "its moment is I_A dω/dt",
                words,
                over_points(
                    r"- cross(r_{A#}^A) C_{OA}^T m_# C_{OA} cross(r_{A#}^A)"
                    r" \{\frac{d}{dt}\omega_{A}^A \}"
                ),
                r"I_A^A \{\frac{d}{dt}\omega_{A}^A \}",
            ),
        ),
        is_sentence=True,
    ),
)

#: All entries of the document, in the order of reading.
ENTRIES: tuple[Entry, ...] = (*POINTS, *mass_sums.ENTRIES, *mass_matrix.ENTRIES)
