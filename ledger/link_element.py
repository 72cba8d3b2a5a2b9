"""Yamada and Tatsumi 1981, section 2: the link element, (1) to (16)."""

from __future__ import annotations

from functools import partial

from kousoku.ledger import link_checks as checks
from kousoku.ledger import link_steps as steps
from kousoku.ledger.checks import equal
from kousoku.ledger.entry import LINK_PAPER, Check, Entry
from kousoku.ledger.link_words import derived, words
from kousoku.symbolic.matrices import elements

_entry = partial(Entry, LINK_PAPER)


def _in_code(left: str, formula: str) -> Check:
    """Return the check that a step of the code's derivation says what a formula says."""
    return equal(f"the code's step for {left}", words, lambda: derived(left), formula)


def _at_reference(left: str, formula: str) -> Check:
    said = f"the code's step for {left}"
    return equal(said, words, lambda: checks.at_reference(left), formula)


def _components_of_u() -> dict[str, bool]:
    """Move a link along x and y and turn it: four components depend on where it goes."""
    u = checks.rigid().meanings["u_i"]
    a, b, theta = elements(checks.TURN)
    moved = [k for k in range(6) if u[k, 0].free_symbols & {a, b}]
    return {
        "four components of a rigid motion depend on its translation": moved == [0, 1, 3, 4],
        "the other two are its rotation, whatever its translation": u[2, 0] == u[5, 0] == theta,
    }


def _reference_has_no_deformation() -> dict[str, bool]:
    values = [checks.still(e) for e in checks.epsilon()]
    return {f"ε{k} = 0 at x0": value == 0 for k, value in enumerate(values, 1)}


ENTRIES: tuple[Entry, ...] = (
    _entry(
        "link-one-degree-of-freedom",
        "holds",
        r"リンク機構の基本構成要素である1自由度を有するピストンクランク機構と、"
        r"テークラック機構の2つを例にとり",
        reason="Where the crank stands, all else is determined: as many equations as unknowns, and"
        " their matrix is regular for every angle of the crank.",
        checks=(
            checks.numbers("the piston crank", steps.pistons_freedom),
            checks.numbers("the lever crank", steps.levers_freedom),
        ),
        is_sentence=True,
    ),
    _entry(
        "link-displacement",
        "holds",
        r"両者の差を表す変位ベクトル \mathbf{u}_i ($=\mathbf{x}_i-\mathbf{x}_i^0$)",
        reason="The displacement is the difference of the adjacent and the reference position.",
        checks=(
            equal(
                "u = x − x0, with x as corrected in (2)",
                words,
                r"\mathbf{u}_i",
                r"\mathbf{x}_i-\mathbf{x}_i^0",
            ),
            Check("the code's step x = x0 + u", checks.is_position),
        ),
        is_sentence=True,
    ),
    _entry(
        "link-six-components",
        "holds",
        r"\mathbf{u}_i は4個の並進状態を表す成分と、2個の回転状態を表す成分を有し",
        reason="u1, v1, u2, v2 are displacements of the ends; ψ1 and ψ2 are their rotations.",
        checks=(checks.numbers("translations and rotations", _components_of_u),),
        is_sentence=True,
    ),
    _entry(
        "1",
        "holds",
        r"\mathbf{x}_i^{0T} = [x_{i1}^0 \ y_{i1}^0 \ \beta_i^0 \ x_{i2}^0 \ y_{i2}^0 \ \beta_i^0]",
        reason="At the reference both ends have the link's own angle, so that no end is turned"
        " against the link.",
        vocabulary=words,
        checks=(checks.numbers("no deformation there", _reference_has_no_deformation),),
    ),
    _entry(
        "2",
        "misprint",
        r"\mathbf{x}_i^T = [x_{i1} \ y_{i1} \ \beta_i \ x_{i2} \ y_{i2} \ \beta_i]",
        r"\mathbf{x}_i^T = [x_{i1} \ y_{i1} \ \beta_{i1} \ x_{i2} \ y_{i2} \ \beta_{i2}]",
        "After a displacement the ends have angles of their own, β_i1 and β_i2 of (6) and (7); β_i"
        " is the link's angle, (12) and (13), with which ε2 and ε3 would always vanish.",
        vocabulary=words,
        refutation=(checks.numbers("one end is turned alone", checks.one_angle_is_too_few),),
    ),
    _entry(
        "3",
        "holds",
        r"\mathbf{u}_i^T = [u_{i1} \ v_{i1} \ \psi_{i1} \ u_{i2} \ v_{i2} \ \psi_{i2}]",
        vocabulary=words,
    ),
    _entry(
        "4",
        "holds",
        r"\boldsymbol{\epsilon}_i^T = [\epsilon_{i1} \ \epsilon_{i2} \ \epsilon_{i3}]",
        vocabulary=words,
    ),
    _entry(
        "5",
        "holds",
        checks.DEFORMATIONS[0],
        reason="The definition of the elongation; the code derives the same.",
        vocabulary=words,
    ),
    _entry(
        "6",
        "holds",
        checks.DEFORMATIONS[1],
        reason="The definition of the turn of end 1 against the link; the code derives the same.",
        vocabulary=words,
        checks=(
            Check("l times sine and cosine of the code's wrapped angle", checks.are_wrapped(1)),
        ),
    ),
    _entry(
        "7",
        "holds",
        checks.DEFORMATIONS[2],
        reason="The definition at end 2; one pair of its brackets is idle.",
        vocabulary=words,
        checks=(
            Check("l times sine and cosine of the code's wrapped angle", checks.are_wrapped(2)),
        ),
    ),
    _entry(
        "8",
        "holds",
        r"l_i^0 = \sqrt{(x_{i2}^0 - x_{i1}^0)^2 + (y_{i2}^0 - y_{i1}^0)^2}",
        vocabulary=words,
        checks=(_at_reference("length", "l_i^0"),),
    ),
    _entry(
        "9",
        "notation",
        r"l_i = \sqrt{\{(x_{i2}^0 + u_{i2}\} - (x_{i1}^0 + u_{i1}))^2"
        r" + \{(y_{i2}^0 + v_{i2}\} - (y_{i1}^0 + v_{i1}))^2}",
        r"l_i = \sqrt{\{(x_{i2}^0 + u_{i2}) - (x_{i1}^0 + u_{i1})\}^2"
        r" + \{(y_{i2}^0 + v_{i2}) - (y_{i1}^0 + v_{i1})\}^2}",
        "A brace and a parenthesis close in the wrong order.",
        vocabulary=words,
        checks=(equal("the code's length l", words, checks.length_in_code, "l_i"),),
    ),
    _entry(
        "10",
        "holds",
        r"\cos \beta_i^0 = (x_{i2}^0 - x_{i1}^0) / l_i^0",
        vocabulary=words,
        checks=(_at_reference("beta_0", r"\beta_i^0"),),
    ),
    _entry(
        "11",
        "holds",
        r"\sin \beta_i^0 = (y_{i2}^0 - y_{i1}^0) / l_i^0",
        vocabulary=words,
        checks=(_at_reference("beta_0", r"\beta_i^0"),),
    ),
    _entry(
        "12",
        "notation",
        r"\cos \beta_i = \{(x_{i2}^0 + u_{i2}\} - (x_{i1}^0 + u_{i1})) / l_i",
        r"\cos \beta_i = \{(x_{i2}^0 + u_{i2}) - (x_{i1}^0 + u_{i1})\} / l_i",
        "A brace and a parenthesis close in the wrong order.",
        vocabulary=words,
        checks=(_in_code("beta", r"\beta_i"),),
    ),
    _entry(
        "13",
        "notation",
        r"\sin \beta_i = \{(y_{i2}^0 + v_{i2}\} - (y_{i1}^0 + v_{i1})) / l_i",
        r"\sin \beta_i = \{(y_{i2}^0 + v_{i2}) - (y_{i1}^0 + v_{i1})\} / l_i",
        "A brace and a parenthesis close in the wrong order.",
        vocabulary=words,
        checks=(_in_code("beta", r"\beta_i"),),
    ),
    _entry(
        "14",
        "holds",
        r"\boldsymbol{\epsilon}_i = [D_i^0] \mathbf{u}_i",
        reason="To the first order, as the paper says; what is left out is of the second order.",
        vocabulary=checks.expanded,
        checks=(
            checks.numbers("the remainder is of order 2 exactly", checks.second_order),
            Check("the code's δε", checks.is_variation),
        ),
    ),
    _entry(
        "15",
        "holds",
        checks.MATRIX,
        reason="Each element is the derivative of (5), (6) or (7) by a displacement, at u = 0.",
        vocabulary=checks.differentiated,
        checks=(Check("the code's D", checks.is_jacobian),),
    ),
    _entry(
        "link-rigid",
        "holds",
        r"各リンクは剛体として定義されているので、"
        r" $\epsilon_i = \mathbf{0}$ の条件が満足されなければならない",
        reason="A link is rigid if and only if all three deformations vanish, angles counted"
        " modulo a full turn.",
        checks=(
            Check("turned by any θ it keeps its length, and β = β0 + θ", checks.turn_is_rigid),
            Check(
                "with ε2 = ε3 = 0 both ends turn by β − β0, and so does the link but for its"
                " length, which ε1 = 0 keeps",
                checks.undeformed_is_turned,
            ),
        ),
        is_sentence=True,
    ),
    _entry(
        "16",
        "holds",
        r"[D_i^0] \mathbf{u}_i = \mathbf{0}",
        reason="To the first order: exact for an infinitesimal rigid motion. A finite turn leaves a"
        " remainder of the second order.",
        vocabulary=checks.rigid,
        checks=(Check("a finite turn", checks.finite_turn),),
    ),
    _entry(
        "link-three-equations",
        "holds",
        r"式(16)は6個の未知数を持つ3個の線形方程式となっている",
        reason="The three equations are independent: the rank is 3 wherever the link has a length.",
        checks=(Check("shape and rank of (15)", checks.rank),),
        is_sentence=True,
    ),
)
