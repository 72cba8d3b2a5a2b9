"""Formulas are read as they are printed: strictly, and without guessing what was meant."""

from __future__ import annotations

from dataclasses import replace

import pytest
from sympy import Symbol
from sympy.matrices.expressions import MatrixSymbol

from kousoku.ledger.formula import Cross, Derivative, Power, Product, SymbolName, Tilde, Transposed
from kousoku.ledger.parser import parse
from kousoku.ledger.proof import proved, refuted
from kousoku.ledger.tokens import differ_in_notation_only
from kousoku.ledger.vocabulary import Vocabulary
from kousoku.model.errors import FormulaError, LedgerError
from kousoku.model.files.quantity import Quantity

U, V = (Quantity(name, (3,), "", "") for name in "uv")
WORDS = Vocabulary(
    (U, V, Quantity("k", (), "", "")),
    {"u": MatrixSymbol("u", 3, 1), "v": MatrixSymbol("v", 3, 1), "k": Symbol("k")},
)


@pytest.mark.parametrize(
    ("latex", "name"),
    [
        (r"\mathbf{s}'^{P}", "s'^P"),
        (r"\mathbf{s}^{P'}", "s^P'"),
        (r"\mathbf{s}_i^{IB}", "s_i^IB"),
        (r"\delta\boldsymbol{\theta}'^{OB}", "δθ'^OB"),
        (r"\delta \mathbf{C}^{(n1)}(\mathbf{a}^i, \mathbf{a}^j)", "δC^(n1)"),
        (r"\dot{\mathbf{A}}^{OB}", "d/dt A^OB"),
        (r"\frac{d}{dt}C_{OA}", "d/dt C_OA"),
        (r"\vec f_{12}", "vec f_12"),
        (r"x_{i1}^0", "x_i1^0"),
        (r"d^2\mathbf{x}", "d^2 x"),
        (r"d\mathbf{x}^2", "dx^2"),
        (r"(x \text{ 座標})", "x座標"),
    ],
)
def test_a_symbol_keeps_its_marks_primes_and_scripts(latex: str, name: str) -> None:
    ((side,),) = (statement.sides for statement in parse(latex))
    assert str(side) == name


def test_a_T_at_the_end_of_a_superscript_transposes() -> None:
    ((side,),) = (statement.sides for statement in parse(r"\mathbf{d}^{ijT}"))
    assert side == Transposed(SymbolName("d", sup="ij"))


def test_tilde_cross_and_times_are_told_apart() -> None:
    ((side,),) = (s.sides for s in parse(r"\tilde{\mathbf{a}}^i \left( b c \right) \sim"))
    assert side == Product(
        (Tilde(SymbolName("a", sup="i")), Tilde(Product((SymbolName("b"), SymbolName("c")))))
    )
    ((side,),) = (s.sides for s in parse(r"cross(\omega_{A}^A)"))
    assert side == Tilde(SymbolName("ω", sub="A", sup="A"))
    ((side,),) = (s.sides for s in parse(r"\vec a \times \vec b"))
    assert side == Cross(SymbolName("vec a"), SymbolName("vec b"))


def test_minus_one_above_is_the_inverse() -> None:
    ((side,),) = (s.sides for s in parse(r"([D^0][L^1])^{-1}"))
    assert side == Power(Product((SymbolName("D", sup="0"), SymbolName("L", sup="1"))), -1)


def test_d_by_dt_differentiates_what_follows() -> None:
    ((side,),) = (s.sides for s in parse(r"((d/d\alpha)[D^0])_{ref.} b"))
    assert side == Product((Derivative("α", SymbolName("D", sup="0")), SymbolName("b")))
    words = replace(WORDS, derivatives={"t": lambda x: 2 * x})
    assert proved(r"(d/dt)(k + k) = 4k", words)
    with pytest.raises(FormulaError, match="nothing is differentiated by s"):
        proved(r"(d/ds) k = 0", words)


def test_a_matrix_of_formulas_has_an_inverse_unless_it_is_singular() -> None:
    regular = r"\begin{bmatrix} k & 1 \\ 0 & 2 \end{bmatrix}"
    singular = r"\begin{bmatrix} k & k \\ 2 & 2 \end{bmatrix}"
    one = r"\begin{bmatrix} 1 & 0 \\ 0 & 1 \end{bmatrix}"
    assert proved(rf"({regular})^{{-1}} {regular} = {one}", WORDS)
    with pytest.raises(FormulaError, match="singular"):
        proved(rf"({singular})^{{-1}} = {regular}", WORDS)


def test_what_is_replaced_has_a_new_value() -> None:
    words = WORDS.knowing({"new u": MatrixSymbol("v", 3, 1)})
    assert proved(r"u \leftarrow v", words)
    with pytest.raises(LedgerError):
        proved(r"u \leftarrow u", words)


def test_a_side_is_never_greater_where_all_coefficients_of_the_difference_are_positive() -> None:
    assert len(proved(r"\begin{cases} k \leq 2k \\ k \leq k k + k \end{cases}", WORDS)) == 2
    with pytest.raises(LedgerError, match="may be greater"):
        proved(r"2k \leq k", WORDS)


def test_prose_behind_a_formula_is_passed_over() -> None:
    assert proved(r"k = k \quad (\text{リンクの伸び})", WORDS)
    with pytest.raises(FormulaError, match="stand behind something that is no symbol"):
        proved(r"(k + k) \text{座標} = k", WORDS)


def test_a_formula_has_its_statements_sides_and_relations() -> None:
    first, second = parse(r"a \stackrel{(7.16)}{=} b \equiv c, \quad d \underset{(4.20)}{=} e")
    assert first.relations == ("=", "\\equiv") and len(first.sides) == 3
    assert second.relations == ("=",)


@pytest.mark.parametrize(
    ("latex", "message"),
    [
        (r"\{a + b) - c", "closes the bracket"),
        (r"\begin{bmatrix} a & b \\ c \end{bmatrix}", "2, 1 cells"),
        (r"a +", "ends too early|symbol is wanted"),
        (r"a ) b", "formula should end"),
        (r"\begin{picture} a \end{picture}", "unknown environment"),
        (r"(a b)^{xy}", "means nothing"),
    ],
)
def test_what_cannot_be_read_is_refused(latex: str, message: str) -> None:
    with pytest.raises(FormulaError, match=message):
        parse(latex)


@pytest.mark.parametrize(
    ("latex", "message"),
    [
        (r"u v", r"product of shapes \(3, 1\) and \(3, 1\)"),
        (r"u + \tilde{v}", r"shapes \(3, 1\), \(3, 3\)"),
        (r"\tilde{u}^T + w", "nothing is called w"),
        (r"u / v", "number is wanted"),
        (r"\left(\begin{array}{cc} u & 1 \end{array}\right)", "block of a matrix belongs"),
    ],
)
def test_what_cannot_be_formed_is_refused(latex: str, message: str) -> None:
    (statement,) = parse(latex)
    with pytest.raises(FormulaError, match=message):
        WORDS.value(statement.sides[0])


def test_a_column_is_not_compared_with_a_matrix() -> None:
    with pytest.raises(FormulaError, match="one side has shape"):
        proved(r"u = \tilde{v}", WORDS)


def test_a_zero_is_as_large_as_what_it_equals() -> None:
    assert proved(r"\tilde{u} u = 0", WORDS) == [
        "sides 1 and 2 of 2: all 3 elements equal, identically"
    ]
    assert "element 1 of 3" in refuted(r"\tilde{u} v = 0", WORDS)


def test_a_true_formula_is_proved_and_a_false_one_refuted() -> None:
    assert proved(r"\tilde{u} v = -\tilde{v} u", WORDS) == [
        "sides 1 and 2 of 2: all 3 elements equal, identically"
    ]
    with pytest.raises(LedgerError, match="element 1 of 3"):
        proved(r"\tilde{u} v = \tilde{v} u", WORDS)
    assert "element 1 of 3" in refuted(r"\tilde{u} v = \tilde{v} u", WORDS)
    with pytest.raises(LedgerError, match="the printed form holds"):
        refuted(r"\tilde{u} v = -\tilde{v} u", WORDS)


@pytest.mark.parametrize(
    ("one", "other", "is_notation"),
    [
        (r"\mathbf{a}^i b", r"\mathbf{a}'^i \left(b\right)", True),
        (r"\vec{a}^{IP}", r"a'^{P}", True),
        (r"dx^2/dt", r"d^2x/dt", True),
        (r"\tilde{a} b", r"a b", False),
        (r"a^{Oi} b", r"a^{Oj} b", False),
        (r"a^i b + a^j c", r"a^j b + a^i c", False),
        (r"a - b", r"a + b", False),
        (r"a^T b", r"a b", False),
    ],
)
def test_notation_is_primes_brackets_arrows_and_places(
    one: str, other: str, is_notation: bool
) -> None:
    assert differ_in_notation_only(one, other) is is_notation
