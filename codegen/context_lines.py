"""Lines of generated text that fit: calls of C, statements of Python, comments in ASCII."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

WIDTH = 100
#: Spellings of the lectures' letters in comments of C.
_ASCII = {
    "′": "'", "−": "-", "–": "-", "·": ".", "∘": " o ", "×": "x", "…": "...",
    "²": "^2", "³": "^3", "⁰": "^0", "ᵀ": "^T", "½": "1/2", "√": "sqrt", "∂": "d", "∞": "inf",
    "≤": "<=", "≥": ">=", "≠": "/=", "ü": "u''", "Σ": "sum", "Δ": "D", "Ω": "Omega",
    "α": "alpha", "β": "beta", "γ": "gamma", "δ": "d", "ε": "epsilon", "θ": "theta", "λ": "lam",
    "μ": "mu", "ν": "nu", "π": "pi", "ρ": "rho", "φ": "phi", "ω": "omega",
}  # fmt: skip


def ascii_of(text: str) -> str:
    """Comment with its letters spelled, as ``C_q^T lam`` of ``C_qᵀλ``.

    A letter without a spelling, of a user's title, stays.
    """
    spaced = re.sub(r"(?<=[ᵀ½])(?=\w)", " ", text)
    return "".join(_ASCII.get(letter, letter) for letter in spaced)


def plain(text: str) -> str:
    """``text`` on one line, harmless inside a comment of C and a docstring of Python."""
    line = " ".join(text.split())
    return line.replace("\\", "/").replace("*/", "* /").replace("/*", "/ *").replace('"""', "'''")


def c_call(indent: str, head: str, items: Sequence[str]) -> str:
    """``head(items)``, as a call or a declaration, in lines that fit."""
    one_line = f"{indent}{head}({', '.join(items) or 'void'})"
    if len(one_line) < WIDTH:
        return one_line
    inner = indent + "    "
    return f"{indent}{head}(\n{filled_lines(items, inner)})"


def filled_lines(items: Sequence[str], indent: str) -> str:
    """Items with commas between them, as many on a line as fit."""
    lines = [indent]
    for k, item in enumerate(items):
        text = item + ("," if k < len(items) - 1 else "")
        if len(lines[-1]) + 1 + len(text) > WIDTH - 2 and lines[-1] != indent:
            lines.append(indent)
        lines[-1] += text if lines[-1] == indent else f" {text}"
    return "\n".join(lines)


def python_lines(
    indent: str, head: str, items: Sequence[str], tail: str, *, is_call: bool = False
) -> str:
    """``head items tail`` as a formatter of Python leaves it.

    Parameters
    ----------
    indent : str
        Indent of the first line and the last.
    head, tail : str
        Text that ends in, and text that begins with, a bracket.
    items : sequence of str
        Items between the brackets.
    is_call : bool
        Whether the items may share one line of their own, as arguments and parameters do.
    """
    one_line = f"{indent}{head}{', '.join(items)}{tail}"
    if len(one_line) <= WIDTH:
        return one_line
    inner = indent + "    "
    line = f"{inner}{', '.join(items)}"
    rows = [line] if is_call and len(line) <= WIDTH else [f"{inner}{item}," for item in items]
    return "\n".join([f"{indent}{head}", *rows, f"{indent}{tail}"])
