"""The record of one statement of the documents: as printed, its verdict, and the proof."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.ledger.vocabulary import Vocabulary

#: ``holds`` as printed; once lost ``notation`` (primes, brackets, vector arrows, placement of
#: superscripts) is restored; or not without another correction: a ``misprint``.
Verdict = Literal["holds", "notation", "misprint"]


@dataclass(frozen=True, slots=True)
class Document:
    """One of the documents whose statements are checked.

    Parameters
    ----------
    file : str
        Its file name.
    title : str
        By what the code and the docs cite it, e.g. ``lecture 7.1``.
    """

    file: str
    title: str


@dataclass(frozen=True, slots=True)
class Check:
    """A statement that can be tested.

    Parameters
    ----------
    statement : str
        What is claimed, in one line.
    run : callable
        Returns what was seen, in one line.

    Raises
    ------
    LedgerError
        By ``run``: the statement is false.
    """

    statement: str
    run: Callable[[], str]


@dataclass(frozen=True, slots=True, repr=False)
class Entry:
    """A displayed equation, or a sentence that states a condition; a notebook shows it typeset.

    Parameters
    ----------
    document : Document
        Where it stands.
    equation : str
        Its number as printed, or a short slug. No two entries share one.
    verdict : {"holds", "notation", "misprint"}
        What is true of the printed form.
    printed : str
        Verbatim.
    corrected : str
        What it should read; empty where it holds as printed.
    reason : str
        What is wrong, or what the statement rests on, in one or two sentences.
    aliases : tuple of str
        Other keys: the number that should have been printed, the source's own number.
    vocabulary : callable, optional
        What the symbols mean. With it, the formulas themselves are read and compared, side by
        side; without it, ``refutation`` and ``checks`` say all.
    refutation : tuple of Check
        That the printed form fails or cannot be formed, where reading it does not show that.
    checks : tuple of Check
        What proves the corrected form, beyond comparing its sides; ties to the code's derivations.
    is_sentence : bool
        A sentence of the prose, not a formula.
    """

    document: Document
    equation: str
    verdict: Verdict
    printed: str
    corrected: str = ""
    reason: str = ""
    aliases: tuple[str, ...] = ()
    vocabulary: Callable[[], Vocabulary] | None = None
    refutation: tuple[Check, ...] = ()
    checks: tuple[Check, ...] = ()
    is_sentence: bool = False

    @property
    def true_form(self) -> str:
        """The form that is true: the corrected one, or the printed one where that holds."""
        return self.corrected or self.printed

    def __repr__(self) -> str:
        return f"<({self.equation}) of {self.document.title}: {self.verdict}>"

    def _repr_latex_(self) -> str:
        from kousoku.ledger.page import notebook_entry

        return notebook_entry(self)


LECTURE_7_1 = Document("001_9db7d55c2f1b4aef.txt", "lecture 7.1")
LECTURE_8_2 = Document("000_9061ecd424bff861.txt", "lecture 8.2")
LINK_PAPER = Document("002_e489f4c33b1a7114.txt", "Yamada and Tatsumi 1981")
MASS_POINTS = Document("004_37d9de8b67d4827d.txt", "three mass points")
#: In the order of reading.
DOCUMENTS = (LECTURE_7_1, LECTURE_8_2, LINK_PAPER, MASS_POINTS)
