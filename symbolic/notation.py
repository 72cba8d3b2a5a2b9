"""How names and operators are written: as text, and in the lecture's LaTeX."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

#: A printed expression and how tightly it binds: 0 a sum, 1 a product, 2 an atom.
Piece = tuple[str, int]

GREEK = {
    "alpha": "α",
    "beta": "β",
    "gamma": "γ",
    "epsilon": "ε",
    "theta": "θ",
    "lam": "λ",
    "nu": "ν",
    "rho": "ρ",
    "omega": "ω",
    "Omega": "Ω",
    "zeta": "ζ",
}
GREEK_LETTERS = tuple(GREEK.values())
LATEX_GREEK = {
    **{letter: f"\\{'lambda' if name == 'lam' else name} " for name, letter in GREEK.items()},
    "δ": "\\delta ",
    "Δ": "\\Delta ",
}

#: Indices that LaTeX writes above, as the lecture does.
BODY_INDICES = ("i", "j")
SIGNS = {
    "′": "'",
    "ᵀ": "^T",
    "²": "^2",
    "½": "\\tfrac12 ",
    "·": "\\cdot ",
    "×": "\\times ",
    "∘": "\\circ ",
    "→": "\\to ",
    "−": "-",
    "Σ": "\\sum ",
}


@dataclass(frozen=True, slots=True)
class NameParts:
    """A symbol's name taken apart: ``omega_i_b_dot`` is ω with index i, a prime and a dot."""

    letters: str
    index: str
    is_body: bool
    dots: int

    @classmethod
    def parse(cls, name: str) -> NameParts:
        base, *parts = name.split("_")
        dots = sum({"dot": 1, "ddot": 2}.get(part, 0) for part in parts)
        index = "_".join(GREEK.get(x, x) for x in parts if x not in {"b", "dot", "ddot"})
        for word, letter in GREEK.items():
            base = base.replace(word, letter) if base.removeprefix("d") == word else base
        if base in {"dr", "dA"} or (base[:1] == "d" and base[1:2] in GREEK_LETTERS):
            base = "δ" + base[1:]
        return cls(base, index, "b" in parts, dots)


class PlainText:
    """Plain text."""

    minus = "−"

    def name(self, name: str, *, bold: bool) -> str:
        del bold
        n = NameParts.parse(name)
        dots = "\u0307" * (n.dots == 1) + "\u0308" * (n.dots == 2)
        return n.letters + dots + "'" * n.is_body + f"_{n.index}" * bool(n.index)

    def orientation(self, p: str) -> str:
        return "A" + p.removeprefix("p")

    def transpose(self, x: str) -> str:
        return f"{x}^T"

    def skew(self, x: str) -> str:
        return f"{x}~"

    def beside(self, factors: Sequence[str]) -> str:
        return " ".join(factors)

    def power(self, x: str, n: str) -> str:
        return f"{x}^{n}"

    def dot(self, u: str, v: str) -> str:
        return f"({u}·{v})"

    def root(self, x: str) -> str:
        return f"sqrt({x})"

    def call(self, name: str, args: Sequence[str]) -> str:
        return f"{name}({', '.join(args)})"

    def ratio(self, n: Piece, d: Piece) -> str:
        return f"{at_least(n, 1)}/{at_least(d, 2)}"

    def element(self, x: str, i: int, j: int, is_vector: bool) -> str:
        return f"{x}[{i + 1}]" if is_vector else f"{x}[{i + 1},{j + 1}]"

    def rows(self, rows: Sequence[Sequence[str]]) -> str:
        return "[" + "; ".join(", ".join(row) for row in rows) + "]"


class Latex(PlainText):
    """LaTeX in the lecture's type: bold for vectors and matrices, the body as an upper index."""

    minus = "-"

    def name(self, name: str, *, bold: bool) -> str:
        n = NameParts.parse(name)
        if n.letters in {"C", "f"} and n.index:
            lower = ", ".join(_coordinate(part) for part in n.index.split(","))
            return f"\\mathbf{{{n.letters}}}_{{{lower}}}"
        head, letters = "", n.letters
        while letters[:1] in {"δ", "Δ"} and len(letters) > 1:
            head, letters = head + LATEX_GREEK[letters[0]], letters[1:]
        letters = "".join(LATEX_GREEK.get(c, c) for c in letters).strip()
        if bold:
            face = "boldsymbol" if letters.startswith("\\") else "mathbf"
            letters = f"\\{face}{{{letters}}}"
        else:
            letters = _upright_or_word(letters)
        if n.dots:
            letters = f"\\{'d' * n.dots}ot{{{letters}}}"
        index = "".join(LATEX_GREEK.get(c, c) for c in n.index).strip()
        lower = f"_{{{index}}}" if index and n.index not in BODY_INDICES else ""
        body = "" if lower else index
        if body and n.letters in {"A", "δA"}:
            body = "O" + body
        upper = "\\prime " * n.is_body + body
        return head + letters + lower + (f"^{{{upper}}}" if upper else "")

    def orientation(self, p: str) -> str:
        body = p.removeprefix("p").removeprefix("_")
        return f"\\mathbf{{A}}^{{O{body}}}" if body else "\\mathbf{A}"

    def transpose(self, x: str) -> str:
        return f"{{{x}}}^{{T}}"

    def skew(self, x: str) -> str:
        return f"\\widetilde{{{x}}}"

    def beside(self, factors: Sequence[str]) -> str:
        trigonometric = ("\\cos ", "\\sin ")  # last: cos β length is no cosine of a product
        body = " ".join(sorted(factors, key=lambda factor: factor.startswith(trigonometric)))
        return re.sub(r"(\\mathit\{\w+\}) (?=[\w\\{(])", r"\1 \\, ", body)

    def power(self, x: str, n: str) -> str:
        return f"{{{x}}}^{{{n}}}"

    def dot(self, u: str, v: str) -> str:
        return f"\\left({u} \\cdot {v}\\right)"

    def root(self, x: str) -> str:
        return f"\\sqrt{{{x}}}"

    def call(self, name: str, args: Sequence[str]) -> str:
        if name in {"sin", "cos"}:
            return f"\\{name}\\left({args[0]}\\right)"
        return f"\\operatorname{{{name}}}\\left({', '.join(args)}\\right)"

    def ratio(self, n: Piece, d: Piece) -> str:
        return f"\\frac{{{n[0]}}}{{{d[0]}}}"

    def element(self, x: str, i: int, j: int, is_vector: bool) -> str:
        return f"{{{x}}}_{{{i + 1}}}" if is_vector else f"{{{x}}}_{{{i + 1}{j + 1}}}"

    def rows(self, rows: Sequence[Sequence[str]]) -> str:
        body = " \\\\ ".join(" & ".join(row) for row in rows)
        return f"\\begin{{bmatrix}} {body} \\end{{bmatrix}}"


def at_least(piece: Piece, level: int) -> str:
    """Text, in parentheses where it binds less tightly than ``level``."""
    return piece[0] if piece[1] >= level else f"({piece[0]})"


def _coordinate(name: str) -> str:
    """Coordinate r^i of δr^i or δθ′^i's θ′^i, as the index of a block."""
    kind, _, body = name.partition("_")
    if not body:
        return f"\\mathbf{{{kind}}}"
    if kind == "θ":
        return f"\\boldsymbol{{\\theta}}^{{\\prime {body}}}"
    return f"\\mathbf{{{kind}}}^{{{body}}}"


def _upright_or_word(letters: str) -> str:
    """Letters of a scalar: cos and sin upright, e0 with its index below, a word joined."""
    if letters.startswith(("cos ", "sin ")):
        return f"\\{letters}"
    if re.fullmatch(r"[a-z][0-9]", letters):
        return f"{letters[0]}_{{{letters[1]}}}"
    return f"\\mathit{{{letters}}}" if re.fullmatch(r"[A-Za-z]{2,}", letters) else letters


def in_text(words: str) -> str:
    r"""Rule for LaTeX's ``\text``, its formulas in math mode."""
    return " ".join(_word(word) for word in words.split(" "))


def _word(word: str) -> str:
    formula = word.rstrip(",;:")
    if formula.endswith(")") and "(" not in formula:
        formula = formula[:-1]
    math = re.sub(r"([^\W_]+′?(?:_[^\W_]+)?)~", r"\\widetilde{\1}", formula)
    math = re.sub(r"_([A-Za-z]{2,})", r"_{\1}", math)
    math = re.sub(r"(\w)\N{COMBINING MACRON}", r"\\bar{\1}", math)
    for sign, command in {**SIGNS, **LATEX_GREEK}.items():
        math = math.replace(sign, command)
    if math == formula and "_" not in formula:
        return word
    return f"${math}${word[len(formula) :]}"


#: The glyphs of a right-hand side that fit on one line of a notebook, beside its rule.
WIDEST = 56


def in_lines(formula: str) -> list[str]:
    """LaTeX cut before signs that stand in no group, in lines of about one width."""
    wanted = ceil(_glyphs(formula) / WIDEST)
    room = 1.1 * _glyphs(formula) / wanted
    depth, start = 0, 0
    lines = [""]
    for mark in re.finditer(r"\\(?:begin|left)\b|\\(?:end|right)\b|[{}]| (?=[+-] )|$", formula):
        token = mark.group()
        if token in {"{", "\\begin", "\\left"}:
            depth += 1
        elif token in {"}", "\\end", "\\right"}:
            depth -= 1
        elif depth == 0:
            term, start = formula[start : mark.start()], mark.start()
            if lines[-1] and _glyphs(lines[-1] + term) > room:
                lines.append(term.lstrip())
            else:
                lines[-1] += term
    return lines


def _glyphs(formula: str) -> int:
    """Number of letters and signs that LaTeX shows, about."""
    faces = r"\\(?:mathbf|boldsymbol|mathit|widetilde|d?dot|begin|end|left|right|[tf]?frac)\b"
    shown = re.sub(r"\\[A-Za-z]+", "x", re.sub(faces, "", formula))
    return len(re.sub(r"[{}^_&\\\s]", "", shown))
