"""Derivations as text and LaTeX."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import pytest
from sympy import Symbol, cos
from sympy.matrices.expressions import Identity, MatrixSymbol

from kousoku.model.errors import DerivationError
from kousoku.symbolic.bodies import SYMBOLS, A
from kousoku.symbolic.matrices import Dot, NamedMatrix, NamedScalar, add, mul, neg, skew, transpose
from kousoku.symbolic.notation import in_lines, in_text
from kousoku.symbolic.printing import print_steps, show

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.symbolic.derivation import Derivation


def test_text_of_n2(derived: Callable[[str], Derivation], golden: Callable[[str], None]) -> None:
    golden(print_steps(derived("n2")))


def test_latex_of_n2(derived: Callable[[str], Derivation], golden: Callable[[str], None]) -> None:
    golden(print_steps(derived("n2"), style="latex"))


@pytest.mark.parametrize(
    ("name", "text", "latex"),
    [
        ("r_i", "r_i", r"\mathbf{r}^{i}"),
        ("a_i_b", "a'_i", r"\mathbf{a}^{\prime i}"),
        ("omega_j_b", "ω'_j", r"\boldsymbol{\omega}^{\prime j}"),
        ("dtheta_b", "δθ'", r"\delta \boldsymbol{\theta}^{\prime }"),
        ("v_i_dot", "v̇_i", r"\dot{\mathbf{v}}^{i}"),
        ("C_ddot", "C̈", r"\ddot{\mathbf{C}}"),
        ("lam", "λ", r"\boldsymbol{\lambda}"),
        ("C_θ_j", "C_θ_j", r"\mathbf{C}_{\boldsymbol{\theta}^{\prime j}}"),
        ("L_1", "L_1", r"\mathbf{L}_{1}"),
        ("Omega_i", "Ω_i", r"\boldsymbol{\Omega}^{i}"),
    ],
)
def test_names_are_the_lecture_letters(name: str, text: str, latex: str) -> None:
    import unicodedata

    symbol = MatrixSymbol(name, 3, 1)
    assert unicodedata.normalize("NFC", show(symbol)) == unicodedata.normalize("NFC", text)
    assert show(symbol, "latex") == latex


def test_products_of_sums_have_parentheses_and_signs_join_the_sum() -> None:
    r, s, a = SYMBOLS["r_i"], SYMBOLS["s_i_b"], SYMBOLS["a_i_b"]
    x = neg(mul(transpose(a), add(r, neg(mul(A["i"], s)))))
    assert show(x) == "−a'_i^T (r_i − A_i s'_i)"
    assert show(skew(mul(A["i"], s))) == "(A_i s'_i)~"
    assert show(add(r, neg(r), mul(-2, s))) == "−2 s'_i"


def test_scalars_print_in_an_order_of_their_own() -> None:
    p, length = SYMBOLS["p_i"], Symbol("length")
    assert show(1 / (2 * length)) == "1/(2 length)"
    assert show(Dot(p, p) ** 2 * length) == "length (p_i·p_i)^2"
    assert show(p[0, 0] - length) == "e0_i − length"


def test_scalars_in_latex_are_letters_or_words() -> None:
    length = Symbol("length")
    assert show(2 * length, "latex") == r"2 \mathit{length}"
    assert show(mul(length, SYMBOLS["r_i"]), "latex") == r"\mathit{length} \, \mathbf{r}^{i}"
    cosine = NamedScalar("cos β", length)
    assert show(length * cosine, "latex") == r"\mathit{length} \, \cos \beta"
    assert show(mul(cos(length), SYMBOLS["r_i"]), "latex").startswith(r"\cos\left(")
    assert show(SYMBOLS["p_i"][0, 0], "latex") == r"e_{0}^{i}"
    assert show(NamedScalar("cos β", length), "latex") == r"\cos \beta"


def test_a_number_times_one_is_the_number_and_a_sum_keeps_its_sign() -> None:
    p = SYMBOLS["p_i"]
    assert show(mul(Symbol("length") ** 2, Identity(1))) == "length^2"
    assert show(mul(p[0, 0] ** 2 - Dot(p, p), Identity(3))) == "(e0_i^2 − (p_i·p_i)) I"


@pytest.mark.parametrize("package", ["n1", "n2", "p1_x", "p2_y", "point", "distance"])
def test_every_name_in_a_constraint_means_one_thing_and_is_written_out(
    package: str, derived: Callable[[str], Derivation]
) -> None:
    lines = derived(package).steps
    values: dict[str, Any] = {}
    for step in lines:
        for x in step.right.atoms(NamedMatrix):
            assert values.setdefault(x.name, x.value) == x.value
    defined = [step.left.name for step in lines]
    assert values
    for name in values:
        assert name in defined


def test_unknown_style_is_refused(derived: Callable[[str], Derivation]) -> None:
    with pytest.raises(DerivationError, match="unknown style 'html'; use one of text, latex"):
        print_steps(derived("norm"), style=cast(Any, "html"))


def test_every_kind_prints_every_step_in_both_styles(derived: Callable[[str], Derivation]) -> None:
    for package in ("rotation", "p1_z", "link", "mass_points"):
        derivation = derived(package)
        text, latex = print_steps(derivation), print_steps(derivation, style="latex")
        assert f"{len(derivation.steps):3d}. " in text
        assert latex.count("&=") >= len(derivation.steps)
        assert latex.count(r"\text{") == len(derivation.steps)
        assert latex.count("{") == latex.count("}")


@pytest.mark.parametrize(
    ("words", "latex"),
    [
        (
            "J_k = s′_k~ᵀ s′_k~: inertia",
            r"$J_k$ = $\widetilde{s'_k}^T$ $\widetilde{s'_k}$: inertia",
        ),
        ("(cos β, sin β)", r"(cos $\beta $, sin $\beta $)"),
        ("r_AG = 0, block of C_qᵀλ", r"$r_{AG}$ = 0, block of $C_q^T\lambda $"),
        ("A(p) obeys (5.16)", "A(p) obeys (5.16)"),
    ],
)
def test_formulas_in_a_rule_are_whole_and_its_stops_are_text(words: str, latex: str) -> None:
    assert in_text(words) == latex


def test_no_line_of_a_long_formula_is_much_wider_than_the_others(
    derived: Callable[[str], Derivation],
) -> None:
    x = SYMBOLS["r_i"]
    names = [MatrixSymbol(f"x_{n}", 3, 1) for n in range(40)]
    lines = in_lines(show(add(*names), "latex"))
    assert len(lines) > 1
    assert max(map(len, lines)) < 2 * min(map(len, lines))
    assert " ".join(lines) == show(add(*names), "latex")
    assert in_lines(show(add(x, x), "latex")) == [show(add(x, x), "latex")]
    steps = print_steps(derived("n1"), style="latex")
    for line in steps.splitlines():
        assert line.count(r"\left") == line.count(r"\right")
        assert line.count("{") == line.count("}")
