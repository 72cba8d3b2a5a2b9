r"""Formulas and texts of a document, made ready for a LaTeX page.

A printed form may be broken: brackets that do not pair, an environment that never ends. Such a form
is shown letter by letter instead of typeset.
"""

from __future__ import annotations

import re
import textwrap
import unicodedata

ENVIRONMENTS = ("aligned", "gathered", "array", "bmatrix", "pmatrix", "cases")
#: Signs of plain text that a text font may lack.
SIGNS = {
    "′": "{}'",
    "″": "{}''",
    "ᵀ": "{}^T",
    "⁾": "{}^)",
    "⁻": "{}^-",
    "⁰": "{}^0",
    "¹": "{}^1",
    "²": "{}^2",
    "³": "{}^3",
    "₀": "{}_0",
    "₁": "{}_1",
    "₂": "{}_2",
    "₃": "{}_3",
    "ᵢ": "{}_i",
    "ⱼ": "{}_j",
    "−": "-",
    "½": "\\tfrac12",
    "×": "\\times",
    "·": "\\cdot",
    "∘": "\\circ",
    "±": "\\pm",
    "√": "\\surd",
    "∂": "\\partial",
    "≤": "\\leq",
    "≥": "\\geq",
    "≠": "\\neq",
    "≡": "\\equiv",
    "≈": "\\approx",
    "∈": "\\in",
    "ϵ": "\\epsilon",
    "∥": "\\|",
    "⟂": "\\perp",
    "→": "\\to",
    "←": "\\leftarrow",
    "⇒": "\\Rightarrow",
    "…": "\\dots",
}
_SPECIAL = {c: f"\\{c}" for c in "%&#_{}$"} | {
    "\\": "\\textbackslash{}",
    "^": "\\textasciicircum{}",
    "~": "\\textasciitilde{}",
}
_ACCENTS = {"\u0303": "\\tilde", "\u0307": "\\dot", "\u0308": "\\ddot", "\u20d7": "\\vec"}
#: A letter with an accent, a letter with an index, a long number that may be broken, or a sign.
_PIECE = re.compile(
    f"(?P<accented>\\S[{''.join(_ACCENTS)}])"
    r"|(?P<indexed>(?<![\w.])[A-Za-zα-ωΑ-Ω]_[A-Za-z0-9]+)|(?P<digits>\d{16,})|.",
    re.DOTALL,
)


def typeset(printed: str) -> str:
    """Printed formula for math mode, or nothing where it cannot be typeset."""
    body = " ".join(printed.replace("$$", " ").split())
    body = re.sub(r"\\(begin|end)\{eqnarray\*?\}", r"\\\1{aligned}", body).replace("&=&", "&=")
    body = re.sub(r"\\tag\{(\w+)\}", r"\\quad (\1)", body)
    body = re.sub(r"(?<![a-z])cross\b", r"\\operatorname{cross}", body)
    body = re.sub(r"(\\\\\s*)+(?=\\end\b|$)", "", body)
    if not is_balanced(body):
        return ""
    body = body.strip()
    rows, _ = re.subn(r"\\begin\{(\w+)\}.*\\end\{\1\}", "", body)
    if "\\\\" in rows or "&" in rows:
        name = "aligned" if "&" in rows else "gathered"
        body = f"\\begin{{{name}}} {body} \\end{{{name}}}"
    return body


def is_balanced(body: str) -> bool:
    r"""Whether braces, ``\left`` and environments pair, and no index stands twice."""
    braces = re.findall(r"(?<!\\)[{}]", body.replace("\\\\", " "))
    open_environments: list[str] = []
    for word, name in re.findall(r"\\(begin|end)\{(\w+)\}", body):
        if word == "begin":
            open_environments.append(name)
        elif not open_environments or open_environments.pop() != name:
            return False
        if name not in ENVIRONMENTS:
            return False
    return (
        not open_environments
        and _closes(braces)
        and _closes(["{" if w == "left" else "}" for w in re.findall(r"\\(left|right)\b", body)])
        and not re.search(r"\^(\{[^{}]*\}|\w)\s*\^|_(\{[^{}]*\}|\w)\s*_", body)
    )


def _closes(braces: list[str]) -> bool:
    depth = 0
    for brace in braces:
        depth += 1 if brace == "{" else -1
        if depth < 0:
            return False
    return depth == 0


def in_words(text: str) -> str:
    """Plain text for LaTeX: special characters escaped, letters and signs in math mode."""
    return _PIECE.sub(_piece, re.sub(r"\w", _decomposed, text))


def _decomposed(match: re.Match[str]) -> str:
    """Letter that holds its accent, such as ṽ, as letter and accent."""
    parts = unicodedata.normalize("NFD", match[0])
    return parts if parts[1:] in _ACCENTS else match[0]


def _piece(match: re.Match[str]) -> str:
    piece = match[0]
    if match["accented"]:
        return f"${_ACCENTS[piece[1]]}{{{_math(piece[0])}}}$"
    if match["indexed"]:
        letter, _, index = piece.partition("_")
        return f"${_math(letter)}_{{{index}}}$"
    if match["digits"]:
        return "\\allowbreak ".join(re.findall(r"\d{1,8}", piece))
    math = _math(piece)
    return _SPECIAL.get(piece, piece) if math == piece else f"${math}$"


def _math(letter: str) -> str:
    """Letter for math mode: a Greek one by its name, a sign by its command."""
    if letter in SIGNS:
        return SIGNS[letter]
    match unicodedata.name(letter, "").split():
        case ["GREEK", size, "LETTER", name]:
            name = name.lower().replace("lamda", "lambda")
            return f"\\{name.capitalize() if size == 'CAPITAL' else name}"
    return letter


def sentence(printed: str) -> str:
    """Sentence of the prose for LaTeX, its formulas in math mode."""
    parts = " ".join(printed.split()).split("$")
    return "".join(
        _inline(part) if number % 2 else "".join(_bare(run) for run in _runs(part))
        for number, part in enumerate(parts)
    )


def _runs(text: str) -> list[str]:
    """Text cut where letters of ASCII begin and end."""
    return re.findall(r"[\x20-\x7e]+|[^\x20-\x7e]+", text)


def _bare(run: str) -> str:
    """Run of text; text that spells a formula without dollar signs becomes one."""
    plain = re.sub(r"</?sup>", "", run)
    if re.search(r"(?<![\\\w])[A-Za-z]{4,}", plain):  # words, so that formulas end at blanks
        return " ".join(_formula_or_words(word, r"[\\{]") for word in plain.split(" "))
    core = plain.strip()
    return plain.replace(core, _formula_or_words(core, r"[\\{_^]")) if core else plain


def _formula_or_words(text: str, signs: str) -> str:
    """Text in math mode where it holds one of the signs of a formula."""
    is_formula = re.search(signs, text) and is_balanced(text)
    return f"${text}$" if is_formula else in_words(text)


def _inline(formula: str) -> str:
    body = typeset(formula)
    return f"${body}$" if body else f"\\texttt{{{in_words(formula)}}}"


def verbatim(printed: str, width: int = 88) -> str:
    """Printed form letter by letter, long lines cut between words."""
    lines = [
        part
        for line in printed.strip().splitlines()
        for part in textwrap.wrap(line, width, break_on_hyphens=False) or [""]
    ]
    return "\n".join(lines)
