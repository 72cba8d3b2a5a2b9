"""The ledger as a LaTeX document and as a Markdown page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.ledger.entry import DOCUMENTS
from kousoku.ledger.printing import VERDICTS, counts
from kousoku.ledger.typesetting import in_words, sentence, typeset, verbatim

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.ledger.entry import Document, Entry
    from kousoku.ledger.proof import Proof

PREAMBLE = r"""% The page that `kousoku ledger --latex` prints; lualatex typesets it.
\documentclass[a4paper,10pt]{article}
\usepackage[margin=22mm]{geometry}
\usepackage{luatexja}
\usepackage{amsmath,amssymb,graphicx,xcolor,booktabs}
\usepackage[hidelinks]{hyperref}
\setcounter{MaxMatrixCols}{20}
\setlength{\parindent}{0pt}
\newsavebox{\formula}
\newlength{\room}
\newcommand{\shown}[1]{\sbox{\formula}{$\displaystyle #1$}\setlength{\room}{\linewidth}%
  \addtolength{\room}{-2em}\par\smallskip\hspace*{1.5em}%
  \ifdim\wd\formula>\room\resizebox{\room}{!}{\usebox{\formula}}\else\usebox{\formula}\fi
  \par\smallskip}
\newcommand{\said}[1]{\par\smallskip\hspace*{1.5em}\parbox{.92\linewidth}{#1}\par\smallskip}
\newcommand{\holds}{\textcolor{green!45!black}{holds}}
\newcommand{\notation}{\textcolor{orange!75!black}{notation}}
\newcommand{\misprint}{\textcolor{red!70!black}{misprint}}
\newcommand{\entry}[2]{\pagebreak[2]\bigskip\textbf{(#1)}\quad #2\par}
\newcommand{\tested}[1]{\par{\footnotesize\begin{itemize}\raggedright\setlength{\itemsep}{0pt}#1\end{itemize}}}
\title{The ledger}
\date{}
\begin{document}
\maketitle
"""
OPENING = (
    "Each equation of the four documents, and each sentence that states a condition, as it is"
    " printed and what is true of it. It holds; or it holds once lost notation is restored (primes,"
    " brackets, vector arrows, placement of superscripts); or it is a misprint, and the corrected"
    " form stands below it. Under each entry stands what was proved, and what was seen."
)


def latex_page(entries: Sequence[Entry], proofs: Mapping[str, Proof]) -> str:
    """Complete LaTeX document.

    Parameters
    ----------
    entries : sequence of Entry
        What it lists, in this order.
    proofs : Mapping
        Proofs by key; an entry without one says that its proof failed.
    """
    parts = [PREAMBLE + OPENING, *([_latex_counts(entries)] if len(entries) > 1 else [])]
    for document in DOCUMENTS:
        selected = [entry for entry in entries if entry.document == document]
        if selected:
            parts.append(f"\\section*{{{in_words(document.title)}}}")
            parts += [_latex_entry(entry, proofs.get(entry.equation)) for entry in selected]
    return "\n".join([*parts, "\\end{document}", ""])


def _latex_counts(entries: Sequence[Entry]) -> str:
    rows = [
        " & ".join([name, *(str(n) for n in numbers.values())]) + r" \\"
        for name, numbers in _count_rows(entries)
    ]
    head = " & ".join(["", *(f"\\{verdict}" for verdict in VERDICTS)]) + r" \\ \midrule"
    lines = ["\\begin{center}\\begin{tabular}{lrrr}", head, *rows, "\\end{tabular}\\end{center}"]
    return "\n".join(lines)


def _count_rows(entries: Sequence[Entry]) -> list[tuple[str, dict[str, int]]]:
    documents: list[tuple[str, Document | None]] = [(d.title, d) for d in DOCUMENTS]
    return [(name, counts(entries, d)) for name, d in [*documents, ("in all", None)]]


def _latex_entry(entry: Entry, proof: Proof | None) -> str:
    also = f"\\quad also {', '.join(entry.aliases)}" if entry.aliases else ""
    parts = [
        f"\\entry{{{entry.equation}}}{{\\{entry.verdict}{also}}}",
        _latex_form(entry, entry.printed),
    ]
    if entry.corrected:
        parts += ["should read", _latex_form(entry, entry.corrected)]
    if entry.reason:
        parts.append(sentence(entry.reason))
    lines = proof.lines if proof else ()
    items = [f"\\item {in_words(line.statement)}: {in_words(line.result)}" for line in lines]
    parts.append("\\tested{%\n" + "\n".join(items) + "}" if items else "The proof failed.")
    return "\n".join(parts)


def _latex_form(entry: Entry, text: str) -> str:
    if entry.is_sentence:
        return f"\\said{{{sentence(text)}}}"
    body = typeset(text)
    if body:
        return f"\\shown{{{body}}}"
    return f"\\begin{{verbatim}}\n{verbatim(text)}\n\\end{{verbatim}}"


def markdown_page(entries: Sequence[Entry], proofs: Mapping[str, Proof]) -> str:
    """Page as Markdown, with formulas as sites that show LaTeX take them."""
    note = "`kousoku ledger --markdown` prints this page."
    parts = ["# The ledger", "", OPENING, note]
    parts += ["", *_markdown_counts(entries)] if len(entries) > 1 else []
    for document in DOCUMENTS:
        selected = [entry for entry in entries if entry.document == document]
        if selected:
            parts += ["", f"## {document.title}"]
        for entry in selected:
            parts += ["", *_markdown_entry(entry, proofs.get(entry.equation))]
    return "\n".join([*parts, ""])


def _markdown_counts(entries: Sequence[Entry]) -> list[str]:
    rows = [["", *VERDICTS], ["---"] * (len(VERDICTS) + 1)]
    rows += [[name, *(str(n) for n in numbers.values())] for name, numbers in _count_rows(entries)]
    return [f"| {' | '.join(row)} |" for row in rows]


def _markdown_entry(entry: Entry, proof: Proof | None) -> list[str]:
    also = f", also {', '.join(entry.aliases)}" if entry.aliases else ""
    parts = [
        f"### ({entry.equation}) {entry.verdict}{also}",
        "",
        *_markdown_form(entry, entry.printed),
    ]
    if entry.corrected:
        parts += ["", "should read", "", *_markdown_form(entry, entry.corrected)]
    if entry.reason:
        parts += ["", entry.reason]
    lines = proof.lines if proof else ()
    items = [f"- {line.statement}: {line.result}" for line in lines] or ["The proof failed."]
    return [*parts, "", *items]


def _markdown_form(entry: Entry, text: str) -> list[str]:
    if entry.is_sentence:
        return [f"> {' '.join(text.split())}"]
    body = typeset(text)
    return ["```math", body, "```"] if body else ["```text", verbatim(text), "```"]


def notebook_entry(entry: Entry) -> str:
    """Both forms of an entry as a notebook takes them: words, with formulas as LaTeX."""
    forms = {"printed": entry.printed, "corrected": entry.corrected}
    return " ".join(f"{name}: {_shown(entry, form)}" for name, form in forms.items() if form)


def _shown(entry: Entry, text: str) -> str:
    if entry.is_sentence:
        return sentence(text)
    body = typeset(text)
    return f"$${body}$$" if body else verbatim(text)
