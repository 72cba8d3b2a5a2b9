"""Three mass points: Newton's law summed over the points, for forces and for moments."""

from __future__ import annotations

from functools import partial

from sympy.matrices.expressions import Transpose, ZeroMatrix

from kousoku.ledger.checks import different, equal
from kousoku.ledger.entry import MASS_POINTS, Check, Entry
from kousoku.ledger.mass_words import (
    ACCELERATION,
    any_vectors,
    in_code,
    in_step,
    one_point,
    over_points,
    unreadable,
    words,
)
from kousoku.symbolic.matrices import Skew

_entry = partial(Entry, MASS_POINTS)

TOTAL_FORCE = r"F_A^O &=& f_1^O + f_2^O + f_3^O"
PRINTED_TORQUE = (
    r"cross(r_{A1}^A) C_{OA} f_1^O + cross(r_{A2}^A) C_{OA} f_2^O + cross(r_{A3}^A) C_{OA} f_3^O"
)
TORQUE = PRINTED_TORQUE.replace("C_{OA}", "C_{OA}^T")
TOTAL_MASS = r"M_A &=& m_1+m_2+m_3"
CENTRE = r"M_A r_{AG}^A &=& m_1 r_{A1}^A + m_2 r_{A2}^A + m_3 r_{A3}^A"
INERTIA = (
    r"m_1 cross(r_{A1}^A)^T  cross(r_{A1}^A) +m_2cross(r_{A2}^A)^T  cross(r_{A2}^A)"
    r"  + m_3cross(r_{A3}^A)^T  cross(r_{A3}^A)"
)
TURNING = (
    r"\{ m_1 cross(r_{A1}^A) cross(\omega_{A}^A) cross(r_{A1}^A)"
    r" +m_2cross(r_{A2}^A) cross(\omega_{A}^A) cross(r_{A2}^A) "
    r" + m_3cross(r_{A3}^A) cross(\omega_{A}^A) cross(r_{A3}^A) \}"
)
MOMENT_LEFT = (
    r"M_A cross(r_{AG}^A) C_{OA}^T a_{OA}^O + cross(\omega_{A}^A) I_A^A \omega_{A}^A"
    r" + I_A^A \{\frac{d}{dt}\omega_{A}^A\}"
)
MOMENT_SUM = (
    r"\{m_1 cross(r_{A1}^A) + m_2 cross(r_{A2}^A) +m_3 cross(r_{A3}^A) \}"
    r"C_{OA}^T a_{OA}^O\\"
    rf" - {TURNING} \omega_{{A}}^A \\"
    r" - \{ m_1 cross(r_{A1}^A)  cross(r_{A1}^A) +m_2cross(r_{A2}^A)  cross(r_{A2}^A)"
    r"  + m_3cross(r_{A3}^A) cross(r_{A3}^A) \}  \{\frac{d}{dt}\omega_{A}^A\}"
)
NEEDS_TORQUE = (
    "N_A^A is the corrected one, three mass points, (torque-definition); with the printed one it"
    " does not hold."
)


def not_as_printed(left: str) -> Check:
    """Return the check that a balance of moments fails with N_A as it is printed."""
    statement = "with N_A as printed, C_OA in place of its transpose, it does not hold"
    return different(statement, words, left, PRINTED_TORQUE)


def collected(first: str, second: str) -> str:
    """Return the balance of forces, r_AG being given as ``first`` and ``second``."""
    return (
        rf"\begin{{eqnarray}} M_A  a_{{OA}}^O"
        rf" - C_{{OA}}cross(\omega_{{A}}^A) M_A {first} \omega_{{A}}^A"
        rf" - C_{{OA}} M_A {second} \{{\frac{{d}}{{dt}}\omega_{{A}}^A\}}"
        rf" = f_1^O + f_2^O + f_3^O \end{{eqnarray}}"
    )


def again(internal: str) -> str:
    """Return the equation of one point, as it is repeated, with its internal forces."""
    return (
        rf"\begin{{eqnarray}} m_i \langle {ACCELERATION}\rangle"
        rf" = f_i^O + {internal} \end{{eqnarray}}"
    )


ENTRIES: tuple[Entry, ...] = (
    _entry(
        "force-sum",
        "holds",
        r"\begin{eqnarray} (m_1+m_2+m_3) a_{OA}^O \\"
        r" - C_{OA}cross(\omega_{A}^A) \{ m_1 cross(r_{A1}^A) + m_2 cross(r_{A2}^A)"
        r" +  m_3 cross(r_{A3}^A) \}\omega_{A}^A\\"
        r" - C_{OA} \{ m_1 cross(r_{A1}^A) + m_2 cross(r_{A2}^A) + m_3 cross(r_{A3}^A)  \}"
        r" \{\frac{d}{dt}\omega_{A}^A\}\\ = f_1^O + f_2^O + f_3^O \end{eqnarray}",
        reason="The internal forces cancel in pairs, which takes both of each point.",
        vocabulary=words,
        checks=(
            equal(
                "all internal forces cancel",
                words,
                r"(f_{12}^O + f_{13}^O) + (f_{21}^O + f_{23}^O) + (f_{31}^O + f_{32}^O)",
                lambda: ZeroMatrix(3, 1),
            ),
            different(
                "one of each point would not",
                words,
                r"f_{12}^O + f_{23}^O + f_{31}^O",
                lambda: ZeroMatrix(3, 1),
            ),
        ),
    ),
    _entry(
        "total-mass",
        "holds",
        TOTAL_MASS,
        reason="A definition.",
        vocabulary=words,
        checks=(
            in_code("mass_points", "inertia.mass", r"m_1+m_2+m_3"),
            in_step("mass_points", "mass", r"m_1+m_2+m_3"),
        ),
    ),
    _entry(
        "centre-of-mass",
        "holds",
        CENTRE,
        reason="A definition: r_AG leads from the origin of frame A to the centre of mass.",
        vocabulary=words,
        checks=(
            equal(
                "it leads there",
                words,
                r"C_{OA}^T (r_{OG}^O - r_{OA}^O)",
                r"r_{AG}^A",
            ),
            in_code("mass_points", "inertia.r_AG_b", r"r_{AG}^A"),
            in_step("mass_points", "c", r"M_A r_{AG}^A"),
        ),
    ),
    _entry(
        "collected-force-balance",
        "misprint",
        collected(r"r_{AG}^A", r"r_{AG}^A"),
        collected(r"cross(r_{AG}^A)", r"cross(r_{AG}^A)"),
        "In the second and in the third term cross() around r_AG is lost.",
        refutation=(
            unreadable("as printed", collected(r"r_{AG}^A", r"r_{AG}^A")),
            unreadable("with cross() in the second", collected(r"cross(r_{AG}^A)", r"r_{AG}^A")),
            unreadable("with cross() in the third", collected(r"r_{AG}^A", r"cross(r_{AG}^A)")),
        ),
        vocabulary=words,
    ),
    _entry(
        "total-force",
        "holds",
        TOTAL_FORCE,
        reason="A definition: the sum of the external forces.",
        vocabulary=words,
        checks=(
            in_code("mass_points", "resultant.F", r"f_1^O + f_2^O + f_3^O"),
            in_step("mass_points", "F", r"f_1^O + f_2^O + f_3^O"),
        ),
    ),
    _entry(
        "torque-definition",
        "misprint",
        rf"N_A^A &=& {PRINTED_TORQUE}",
        rf"N_A^A &=& {TORQUE}",
        "The torque has components in frame A, and C_OA leads from A to O: its transpose belongs"
        " there.",
        vocabulary=words,
        checks=(
            in_code("mass_points", "resultant.N_b", TORQUE),
            in_step("mass_points", "N_b", TORQUE),
        ),
    ),
    _entry(
        "resultants",
        "holds",
        r"$F_A^O$は質点1,2,3をまとめて考えた時の外力で,$N_A^A$は質点1,2,3をまとめて考えた時のトルクです",
        reason="The internal forces give no resultant. N_A^A is the corrected one, about the origin"
        " of frame A.",
        checks=(
            equal(
                "F_A^O is the force on all points, internal forces included",
                words,
                over_points(r"+ m_# a_{O#}^O"),
                r"F_A^O",
            ),
            equal(
                "N_A^A is its moment, internal forces included",
                words,
                "C_{OA}^T \\{" + over_points(r"+ m_# \vec r_{A#} \times a_{O#}^O") + "\\}",
                r"N_A^A",
            ),
        ),
        is_sentence=True,
    ),
    _entry(
        "point-equation-again",
        "misprint",
        again(r"f_{ij}^O"),
        again(r"f_{ij}^O + f_{ik}^O"),
        "As at first: the internal forces of both other points, j and k, belong there.",
        vocabulary=one_point,
    ),
    _entry(
        "moment-sum",
        "holds",
        rf"\begin{{eqnarray}} {MOMENT_SUM} \\ = N_A^A \end{{eqnarray}}",
        reason=f"{NEEDS_TORQUE} The internal forces drop out because they act along the lines"
        " between the points.",
        vocabulary=words,
        checks=(
            equal(
                "the moments of all internal forces cancel",
                words,
                r"cross(r_{A1}^A) C_{OA}^T (f_{12}^O + f_{13}^O)"
                r" + cross(r_{A2}^A) C_{OA}^T (f_{21}^O + f_{23}^O)"
                r" + cross(r_{A3}^A) C_{OA}^T (f_{31}^O + f_{32}^O)",
                lambda: ZeroMatrix(3, 1),
            ),
            not_as_printed(MOMENT_SUM),
            in_step("mass_points", "H_dot", MOMENT_SUM),
        ),
    ),
    _entry(
        "cross-identity",
        "holds",
        r"cross(a) cross(b) cross(a) b = cross(b) cross(a) cross(a) b",
        reason="Jacobi's identity for a, b and a × b.",
        vocabulary=any_vectors,
    ),
    _entry(
        "cross-identity-applied",
        "holds",
        r"m_1 cross(r_{A1}^A) cross(\omega_{A}^A) cross(r_{A1}^A)\omega_{A}^A"
        r" = m_1 cross(\omega_{A}^A) cross(r_{A1}^A)  cross(r_{A1}^A)\omega_{A}^A",
        reason="The identity for r_A1 and ω.",
        vocabulary=words,
    ),
    _entry(
        "second-term-collected",
        "holds",
        rf"- {TURNING} \omega_{{A}}^A \\"
        rf" = cross(\omega_{{A}}^A) \{{ {INERTIA} \}}\omega_{{A}}^A",
        reason="The identity at each point; the sign goes into the transpose.",
        vocabulary=words,
    ),
    _entry(
        "inertia",
        "holds",
        rf"I_A^A = {INERTIA}",
        reason="A definition: about the origin of frame A, Σ m (r·r E − r rᵀ).",
        vocabulary=words,
        checks=(
            in_code("mass_points", "inertia.I_A_b", INERTIA),
            in_step("mass_points", "I_A", INERTIA),
        ),
    ),
    _entry(
        "moment-balance",
        "holds",
        rf"{MOMENT_LEFT} = N_A^A",
        reason=NEEDS_TORQUE,
        vocabulary=words,
        checks=(not_as_printed(MOMENT_LEFT), in_step("mass_points", "H_dot", MOMENT_LEFT)),
    ),
    _entry(
        "transposed-sign",
        "holds",
        r"符号は転置する際に反転した",
        reason="A skew matrix is minus its own transpose.",
        checks=(
            equal(
                "cross(a), its elements transposed, is −cross(a)",
                any_vectors,
                lambda: Transpose(Skew(any_vectors().meanings["a"])),
                "-cross(a)",
            ),
        ),
        is_sentence=True,
    ),
)
