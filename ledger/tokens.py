"""The documents' LaTeX as tokens, and a formula without its notation."""

from __future__ import annotations

import re
from collections import Counter
from typing import TYPE_CHECKING

from kousoku.model.errors import FormulaError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|cross(?![a-z])|\d+(?:\.\d+)?|[A-Za-z]|\S", re.DOTALL)
_ENVIRONMENT = re.compile(r"\\(begin|end)\{([a-z*]+)\}(?:\{[clr|]*\})?")
#: Environments that only lay out lines: their ``&`` and ``\\`` mean nothing.
_LAYOUT = {"aligned", "align", "align*", "eqnarray", "cases"}
_ARRAYS = {"array", "bmatrix", "pmatrix", "matrix"}
#: Commands that set a face, a size or a space.
_FACES = {"\\mathbf", "\\boldsymbol", "\\mathrm", "\\text", "\\left", "\\right", "\\,", "\\;"}
_FACES |= {"\\quad", "\\qquad", "\\hline", "\\displaystyle"}
_BRACKETS = {*"()[]", "\\{", "\\}", "\\langle", "\\rangle", "\\vec"}
#: Tokens between two terms.
_PARTING = {"+", "-", "=", "\\equiv", ","}
_GREEK = dict(
    zip(
        ("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "theta", "lambda", "psi", "omega"),
        "αβγδεζθλψω",
        strict=True,
    )
)
_GREEK |= {"Delta": "Δ", "Omega": "Ω"}


def tokens(latex: str) -> list[str]:
    r"""Tokens of a formula.

    Greek letters become letters. ``\begin`` and ``\end`` of an array become ``⟦`` and ``⟧``;
    environments that only lay out lines vanish, with their ``&`` and ``\\``; ``cases`` states one
    formula a line, and its ``\\`` become commas.
    """
    result: list[str] = []
    depth: list[str] = []
    position = 0
    for match in _ENVIRONMENT.finditer(latex):
        result.extend(_plain(latex[position : match.start()], depth))
        position = match.end()
        kind, name = match.groups()
        if name not in _LAYOUT | _ARRAYS:
            raise FormulaError(f"unknown environment {name!r}")
        if name in _ARRAYS:
            result.append("⟦" if kind == "begin" else "⟧")
        if kind == "begin":
            depth.append(name)
        elif not depth or depth.pop() != name:
            raise FormulaError(f"\\end{{{name}}} closes nothing")
    result.extend(_plain(latex[position:], depth))
    return result


def _plain(latex: str, depth: Sequence[str]) -> Iterator[str]:
    inside_layout = not depth or depth[-1] in _LAYOUT
    for match in _TOKEN.finditer(latex):
        token = match.group()
        if inside_layout and token in {"&", "\\\\"}:
            if token == "\\\\" and depth and depth[-1] == "cases":
                yield ","
            continue
        yield _GREEK.get(token[1:], token) if token[0] == "\\" else token


def essence(latex: str) -> tuple[list[str], list[Counter[str]]]:
    """Essence of a formula, beyond its notation.

    Returns
    -------
    list of str
        The tokens in order, without brackets, arrows, faces, primes and scripts.
    list of Counter of str
        The tokens of the scripts of each term, without primes: where in the term they are placed
        does not count.
    """
    body: list[str] = []
    scripts: list[Counter[str]] = [Counter()]
    stream = tokens(latex)
    position = 0
    while position < len(stream):
        token = stream[position]
        position += 1
        if token in {"\\stackrel", "\\underset"}:  # a remark above or below a relation
            position = _group_end(stream, position)
        elif token in {"^", "_"}:
            end = _group_end(stream, position)
            scripts[-1].update(t for t in stream[position:end] if t not in _FACES | {*"{}'"})
            position = end
        elif token not in _FACES | _BRACKETS | {*"{}'"}:
            body.append(token)
            if token in _PARTING:
                scripts.append(Counter())
    return body, scripts


def _group_end(stream: Sequence[str], start: int) -> int:
    """Position after the group, or the one token, that begins at ``start``."""
    depth = 0
    for end in range(start, len(stream)):
        depth += (stream[end] == "{") - (stream[end] == "}")
        if depth == 0:
            return end + 1
    raise FormulaError("a brace is not closed")


def differ_in_notation_only(first: str, second: str) -> bool:
    """Whether two formulas are the same but for their notation.

    A prime that is lost to a capital I, as in ``s^{IB}``, is a prime.
    """
    prime = re.compile(r"\^\{I(?=[A-Z]\})")
    return essence(prime.sub("^{'", first)) == essence(prime.sub("^{'", second))
