"""Derivations as text and as LaTeX, in the lecture's letters.

Text writes ``a'_i`` for body components, ``^T`` for the transpose and ``x~`` for the skew matrix of
x. LaTeX writes what the lecture prints. Both keep the order in which the derivation was written.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import sympy
from sympy.matrices.expressions import (
    BlockMatrix,
    Identity,
    Inverse,
    MatAdd,
    MatMul,
    MatrixSymbol,
    Transpose,
    ZeroMatrix,
)
from sympy.matrices.expressions.matexpr import MatrixElement
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.errors import DerivationError
from kousoku.symbolic.matrices import (
    Divisor,
    Dot,
    NamedMatrix,
    NamedScalar,
    OrientationMatrix,
    Skew,
    coefficient_and_factors,
    description,
)
from kousoku.symbolic.notation import Latex, Piece, PlainText, at_least, in_lines, in_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.symbolic.derivation import Derivation, Step


class _Printer:
    """Walks over an expression; the style says how each node is written."""

    def __init__(self, style: PlainText) -> None:
        self._style = style

    def piece(self, x: Any) -> Piece:
        style = self._style
        match x:
            case MatrixSymbol() | NamedMatrix():
                return style.name(str(x.name), bold=True), 2
            case OrientationMatrix():
                return style.orientation(str(x.p.name)), 2
            case Transpose():
                return style.transpose(at_least(self.piece(x.arg), 2)), 2
            case Skew():
                return style.skew(at_least(self.piece(x.v), 2)), 2
            case MatAdd():
                return self._sum(x.args), 0
            case MatMul():
                scalar, factors = coefficient_and_factors(x)
                if factors == (Identity(1),):
                    return self.piece(scalar)
                return self._product(scalar, [self.piece(factor) for factor in factors])
            case Identity():
                return ("1" if x.shape[0] == 1 else "I"), 2
            case ZeroMatrix():
                return "0", 2
            case ImmutableDenseMatrix():
                return style.rows([[self.piece(c)[0] for c in row] for row in x.tolist()]), 2
            case Inverse():
                return style.power(at_least(self.piece(x.arg), 2), f"{style.minus}1"), 2
            case BlockMatrix():
                rows, columns = x.blockshape
                return style.rows(
                    [[self.piece(x.blocks[i, j])[0] for j in range(columns)] for i in range(rows)]
                ), 2
        return self._scalar(x)

    def _scalar(self, x: Any) -> Piece:
        style = self._style
        match x:
            case sympy.Symbol() | NamedScalar():
                return style.name(str(x.name), bold=False), 2
            case Divisor():
                return self.piece(x.args[0])
            case MatrixElement():
                is_vector = x.parent.shape[1] == 1
                name = style.name(str(x.parent.name), bold=False)
                if x.parent.shape == (1, 1):
                    return name, 2
                if x.parent.shape == (4, 1):  # Euler parameters are e0, e1, e2, e3
                    euler = str(x.parent.name).replace("p", f"e{x.i}", 1)
                    return style.name(euler, bold=False), 2
                return style.element(name, int(x.i), int(x.j), is_vector), 2
            case Dot():
                return style.dot(*(self.piece(arg)[0] for arg in x.args)), 2
            case sympy.Integer():
                return str(x), 2 if x >= 0 else 0
            case sympy.Add():
                return self._sum(sorted(x.args, key=_positive_first)), 0
            case sympy.Mul() | sympy.Rational():
                return self._quotient(x)
            case sympy.Pow():
                return self._power(x)
        return style.call(type(x).__name__, [self.piece(arg)[0] for arg in x.args]), 2

    def _quotient(self, x: Any) -> Piece:
        style = self._style
        numerator, denominator = sympy.fraction(x)
        if numerator.could_extract_minus_sign() and not numerator.is_Add:
            return style.minus + at_least(self.piece(-x), 1), 0
        if denominator != 1:
            return style.ratio(self.piece(numerator), self.piece(denominator)), 1
        factors = sorted(x.args, key=description)
        return style.beside([at_least(self.piece(factor), 1) for factor in factors]), 1

    def _power(self, x: Any) -> Piece:
        base, exponent = x.args
        if exponent.could_extract_minus_sign():
            return self._style.ratio(("1", 2), self.piece(1 / x)), 1
        if exponent == sympy.Rational(1, 2):
            return self._style.root(self.piece(base)[0]), 2
        return self._style.power(at_least(self.piece(base), 2), str(exponent)), 2

    def _sum(self, terms: Sequence[Any]) -> str:
        text, minus = "", self._style.minus
        for term in terms:
            piece = at_least(self.piece(term), 0)
            if text and piece.startswith(minus):
                text += f" {minus} " + piece[1:]
            else:
                text += (" + " if text else "") + piece
        return text

    def _product(self, scalar: Any, factors: Sequence[Piece]) -> Piece:
        body = self._style.beside([at_least(factor, 1) for factor in factors])
        if len(factors) > 1:
            parts = [at_least(factor, 2 if factor[1] == 0 else 1) for factor in factors]
            body = self._style.beside(parts)
        if scalar == 1:
            return body, 1
        is_negative = scalar.could_extract_minus_sign() and not scalar.is_Add
        sign = self._style.minus if is_negative else ""
        size = -scalar if sign else scalar
        if size == 1:
            return sign + body, 0
        product = self._style.beside([at_least(self.piece(size), 1), body])
        return sign + product, 0 if sign else 1


def _positive_first(term: Any) -> tuple[bool, str]:
    return bool(term.could_extract_minus_sign()), description(term)


STYLES = {"text": PlainText(), "latex": Latex()}


def show(x: Any, style: Literal["text", "latex"] = "text") -> str:
    """Expression of the matrix level as text or LaTeX."""
    return _Printer(_style(style)).piece(x)[0]


def _style(name: str) -> PlainText:
    if name not in STYLES:
        raise DerivationError(f"unknown style {name!r}; use one of {', '.join(STYLES)}")
    return STYLES[name]


def print_steps(derivation: Derivation, style: Literal["text", "latex"] = "text") -> str:
    """Steps of a derivation, each with its rule and equation number.

    Parameters
    ----------
    derivation : Derivation
        What ``kousoku.symbolic.derive`` gives.
    style : {"text", "latex"}
        Plain text for a terminal, or an ``align*`` environment for a notebook.

    Returns
    -------
    str
        Ends in one newline.
    """
    printer = _Printer(_style(style))
    if style == "latex":
        return latex_of(derivation.steps)
    lines = []
    for number, step in zip(derivation.step_numbers, derivation.steps, strict=True):
        left, right = printer.piece(step.left)[0], printer.piece(step.right)[0]
        lines.append(f"{number:3d}. {step.rule}{_source(step)}\n       {left} = {right}")
    title = f"{derivation.title}\n{derivation.source}\n"
    return title + "\n" + "\n".join(lines) + "\n"


def latex_of(steps: Sequence[Step]) -> str:
    """Steps as one ``align*`` environment, each line with its rule and equation number."""
    printer = _Printer(STYLES["latex"])
    lines = []
    for step in steps:
        left, right = printer.piece(step.left)[0], printer.piece(step.right)[0]
        first, *more = in_lines(right)
        lines.append(f"{left} &= {first} && \\text{{{in_text(step.rule + _source(step))}}}")
        lines += [f"&\\qquad {part}" for part in more]
    body = " \\\\\n".join(lines)
    return f"\\begin{{align*}}\n{body}\n\\end{{align*}}\n"


def _source(step: Step) -> str:
    return f" ({step.source})" if step.source else ""
