"""Three mass points: the summary, the 6×6 form, and what is left of it at the centre of mass."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING

import sympy
from sympy.matrices.expressions import BlockMatrix, MatrixSymbol, ZeroMatrix

from kousoku.ledger.checks import different, equal
from kousoku.ledger.entry import MASS_POINTS, Check, Entry
from kousoku.ledger.mass_sums import (
    CENTRE,
    INERTIA,
    MOMENT_LEFT,
    NEEDS_TORQUE,
    PRINTED_TORQUE,
    TORQUE,
    TOTAL_FORCE,
    TOTAL_MASS,
    not_as_printed,
)
from kousoku.ledger.mass_words import (
    MOTION,
    OMEGA_DOT,
    V_DOT,
    K,
    M,
    body,
    carried,
    centred,
    in_code,
    in_step,
    unreadable,
    words,
)
from kousoku.ledger.proof import equality, value_of
from kousoku.ledger.turning import along
from kousoku.model.quantity import Quantity
from kousoku.symbolic.mass import OMEGA_B
from kousoku.symbolic.matrices import elements, mul, symbol

if TYPE_CHECKING:
    from kousoku.ledger.vocabulary import Vocabulary

_entry = partial(Entry, MASS_POINTS)


def bracketed(*rows: str) -> str:
    """Return an array as the document writes it."""
    inside = r"\\ ".join(rows)
    return rf"\left( \begin{{array}}{{ccc}} {inside}\\ \end{{array}} \right)"


def system(matrix: str, right: str) -> str:
    """Return the equation of the accelerations."""
    return f"{matrix} {ACCELERATIONS} = {right}"


def blocks(mass: str, centre: str) -> str:
    """Return the matrix, with the total mass and r_AG of its first row as given."""
    return bracketed(
        rf"{mass} &- C_{{OA}} M_A {centre}",
        r"M_A cross(r_{AG}^A) C_{OA}^T &  I_A^A",
    )


ACCELERATIONS = bracketed(r"a_{OA}^O", r"\frac{d}{dt}\omega_{A}^A")
MATRIX = blocks("M_A E", "cross(r_{AG}^A)")
GYROSCOPIC = r"cross(\omega_{A}^A) I_A^A \omega_{A}^A"
RIGHT = bracketed(
    r"F_A^O +C_{OA}cross(\omega_{A}^A) M_A cross(r_{AG}^A) \omega_{A}^A",
    rf"N_A^A - {GYROSCOPIC} ",
)
REDUCED = bracketed("M_A E & 0", "0 &  I_A^A")
REDUCED_RIGHT = bracketed("F_A^O ", rf"N_A^A - {GYROSCOPIC} ")


def summary_force(last: str) -> str:
    """Return the balance of forces of the summary, r_AG of its last term as given."""
    return (
        r"M_A  a_{OA}^O - C_{OA}cross(\omega_{A}^A) M_A cross(r_{AG}^A) \omega_{A}^A"
        rf" - C_{{OA}} M_A {last} \{{\frac{{d}}{{dt}}\omega_{{A}}^A\}} = F_A^O"
    )


@cache
def in_a_plane() -> Vocabulary:
    """Return what the symbols mean for points in the plane of the motion: z = 0, ω along z."""
    x, y = (Quantity(f"{axis}_b", (3,), "m", f"{axis} of each point, frame A") for axis in "xy")
    places = [[*place, sympy.S.Zero] for place in zip(elements(x), elements(y), strict=True)]
    return _about_z(carried("123", places, (*MOTION, M, x, y, K)))


@cache
def off_the_plane() -> Vocabulary:
    """Return what they mean for points anywhere, and ω along z."""
    return _about_z(words())


def _about_z(known: Vocabulary) -> Vocabulary:
    spin = [sympy.S.Zero, sympy.S.Zero, elements(OMEGA_B)[2]]
    turning = replace(known, given={**known.given, "spin": spin})
    return turning.knowing({"ω_A^A": MatrixSymbol("spin", 3, 1)})


def _coefficients() -> str:
    """Change the accelerations alone: F and N change by the matrix times that, and linearly."""
    changes = [Quantity(f"d{q.name}", (3,), q.unit, "its change") for q in (V_DOT, OMEGA_DOT)]
    flow = along(*zip((V_DOT, OMEGA_DOT), changes, strict=True))
    known = words()
    first = [flow(x) for name in ("F_A^O", "N_A^A") for x in known.given[name]]
    given = {**known.given, "first": first, "second": [flow(x) for x in first]}
    changing = replace(known, quantities=(*known.quantities, *changes), given=given)
    matrix = value_of(MATRIX, changing)
    column = BlockMatrix([[symbol(q)] for q in changes])
    equality(changing, MatrixSymbol("second", 6, 1), ZeroMatrix(6, 1))
    return equality(changing, MatrixSymbol("first", 6, 1), mul(matrix, column))


ENTRIES: tuple[Entry, ...] = (
    _entry(
        "summary-force-balance",
        "misprint",
        summary_force(r"r_{AG}^A"),
        summary_force(r"cross(r_{AG}^A)"),
        "In the last term cross() around r_AG is lost.",
        vocabulary=words,
        checks=(
            in_step("mass_points", "P_dot", summary_force(r"cross(r_{AG}^A)").split(" = ")[0]),
        ),
    ),
    _entry(
        "summary-moment-balance",
        "holds",
        rf"{MOMENT_LEFT} = N_A^A",
        reason=NEEDS_TORQUE,
        vocabulary=words,
        checks=(not_as_printed(MOMENT_LEFT),),
    ),
    _entry("summary-total-force", "holds", TOTAL_FORCE, reason="A definition.", vocabulary=words),
    _entry(
        "summary-torque-definition",
        "misprint",
        rf"N_A^A &=& {PRINTED_TORQUE}",
        rf"N_A^A &=& {TORQUE}",
        "As at first: the transpose of C_OA belongs there, which leads from O to A.",
        vocabulary=words,
    ),
    _entry("summary-total-mass", "holds", TOTAL_MASS, reason="A definition.", vocabulary=words),
    _entry("summary-centre-of-mass", "holds", CENTRE, reason="A definition.", vocabulary=words),
    _entry(
        "summary-inertia",
        "holds",
        rf"I_A^A &=& {INERTIA}",
        reason="A definition.",
        vocabulary=words,
    ),
    _entry(
        "unknowns",
        "holds",
        r"力,モーメントの式で変数を$a_{OA}^O,\frac{d}{dt}\omega_{A}^A$ として行列形式でまとめると",
        reason="Both balances are linear in these two, and the corrected matrix holds what they are"
        " multiplied with.",
        checks=(Check("F and N change by the matrix times what these change by", _coefficients),),
        is_sentence=True,
    ),
    _entry(
        "matrix-form",
        "misprint",
        system(blocks("M_A", "r_{AG}^A"), RIGHT),
        system(MATRIX, RIGHT),
        "Two blocks of the matrix are wrong: the number M_A stands where the 3×3 matrix M_A E"
        " belongs, E being the unit matrix, and cross() around r_AG is lost in the first row.",
        refutation=(
            unreadable("as printed", system(blocks("M_A", "r_{AG}^A"), RIGHT)),
            unreadable("with M_A E alone", system(blocks("M_A E", "r_{AG}^A"), RIGHT)),
            unreadable("with cross() alone", system(blocks("M_A", "cross(r_{AG}^A)"), RIGHT)),
        ),
        vocabulary=words,
        checks=(
            in_code("mass_points", "newton_euler.M", MATRIX),
            in_code("mass_points", "newton_euler.h", RIGHT),
            in_code("rigid_body", "newton_euler.M", MATRIX, body),
            in_code("rigid_body", "newton_euler.h", RIGHT, body),
        ),
    ),
    _entry(
        "centre-at-origin",
        "holds",
        r"質点1,2,3を1つの剛体として見た時の重心位置$r_{AG}^A$が座標系Aの原点と一致していた場合",
        reason="The centre of mass is the origin of frame A where r_AG is zero, and only there.",
        checks=(
            equal(
                "from the origin to the centre of mass it is C_OA r_AG",
                words,
                r"r_{OG}^O - r_{OA}^O",
                r"C_{OA} r_{AG}^A",
            ),
            equal("for such points the two coincide", centred, r"r_{OG}^O", r"r_{OA}^O"),
        ),
        is_sentence=True,
    ),
    _entry(
        "centre-condition",
        "holds",
        r"r_{AG}^A = 0",
        reason="For points whose centre of mass is the origin of frame A.",
        vocabulary=centred,
    ),
    _entry(
        "reduced-matrix-form",
        "misprint",
        system(bracketed("M_A & 0", "0 &  I_A^A"), REDUCED_RIGHT),
        system(REDUCED, REDUCED_RIGHT),
        "The number M_A stands where the 3×3 matrix M_A E belongs, E being the unit matrix.",
        vocabulary=centred,
        checks=(
            *(
                in_code("mass_points", f"newton_euler.{name}", formula, centred)
                for name, formula in (("M", REDUCED), ("h", REDUCED_RIGHT))
            ),
            *(
                in_step(package, name, formula, vocabulary)
                for package, vocabulary in (("mass_points", centred), ("rigid_body", body))
                for name, formula in (("M_G", REDUCED), ("h_G", REDUCED_RIGHT))
            ),
        ),
    ),
    _entry(
        "newton-euler-force",
        "holds",
        r"M_A a_{OA}^O = F_A^O",
        reason="With the centre of mass as the origin of frame A.",
        vocabulary=centred,
        checks=(different("elsewhere it does not hold", words, r"M_A a_{OA}^O", r"F_A^O"),),
    ),
    _entry(
        "newton-euler-moment",
        "holds",
        rf"I_A^A \frac{{d}}{{dt}}\omega_{{A}}^A = N_A^A - {GYROSCOPIC}",
        reason=f"With the centre of mass as the origin of frame A. {NEEDS_TORQUE}",
        vocabulary=centred,
        checks=(
            different(
                "elsewhere it does not hold",
                words,
                r"I_A^A \frac{d}{dt}\omega_{A}^A",
                rf"N_A^A - {GYROSCOPIC}",
            ),
        ),
    ),
    _entry(
        "planar-term",
        "holds",
        rf"2次元では現れない項${GYROSCOPIC}$",
        reason="In two dimensions all points lie in the plane of the motion, and I_A ω is parallel"
        " to ω.",
        checks=(
            equal(
                "it is zero for points in the plane",
                in_a_plane,
                GYROSCOPIC,
                lambda: ZeroMatrix(3, 1),
            ),
            different(
                "it is not for points off the plane",
                off_the_plane,
                GYROSCOPIC,
                lambda: ZeroMatrix(3, 1),
            ),
        ),
        is_sentence=True,
    ),
)
