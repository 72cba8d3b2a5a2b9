"""A proof runs, says what it saw, and refuses an entry that claims something else."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import pytest

from kousoku.ledger import entries
from kousoku.ledger.documents.lecture_7_1 import words
from kousoku.ledger.entry import LECTURE_7_1, Check, Entry
from kousoku.ledger.proof import different, equal, prove
from kousoku.model.errors import LedgerError
from tests.ledger.changes import forms_near, with_form

ENTRIES = {e.equation: e for e in entries() if e.document == LECTURE_7_1}


def test_a_proof_tells_each_statement_and_what_was_seen() -> None:
    text = str(prove(ENTRIES["7.19"]))
    assert text.splitlines() == [
        "as printed: cannot be formed: a sum of terms of shapes (3, 1), (3, 3)",
        "corrected: sides 1 and 2 of 3: all 3 elements equal, identically",
        "corrected: sides 2 and 3 of 3: all 3 elements equal, identically",
        "the code's rotation.virtual_displacement gives this as dr_P: all 3 elements equal,"
        " identically",
        "the code's steps that cite this: 2, both sides: all 3 elements equal, identically",
    ]


@pytest.mark.parametrize(
    ("key", "change", "message"),
    [
        ("7.16", {"printed": r"\delta\mathbf{A}^{OB} = \mathbf{A}^{OB}"}, "element"),
        ("7.19", {"verdict": "notation"}, "differ in more than notation"),
        ("7.10", {"verdict": "misprint"}, "differ only in notation"),
        ("7.10", {"verdict": "holds"}, "yet the entry corrects"),
        ("7.10", {"corrected": ""}, "no corrected form"),
        ("7.16", {"verdict": "misprint", "corrected": "x"}, "the printed form holds"),
        ("skew-symmetric", {"checks": ()}, "nothing proves it"),
        ("s-constant", {"refutation": ()}, "nothing shows that the printed form fails"),
    ],
)
def test_an_entry_that_claims_something_else_is_refused(
    key: str, change: dict[str, Any], message: str
) -> None:
    entry: Entry = replace(ENTRIES[key], **change)  # a wrong entry is what is wanted
    with pytest.raises(LedgerError, match=message) as caught:
        prove(entry)
    assert str(caught.value).startswith(f"{key} (lecture 7.1): ")


@pytest.mark.parametrize(
    "entry", [e for e in ENTRIES.values() if e.vocabulary], ids=lambda e: e.equation
)
def test_no_sign_tilde_transpose_or_prime_can_change(entry: Entry) -> None:
    changes = (
        ("+", "-"),
        (" -", "+"),
        ("= -", "= "),
        ("^T", ""),
        (r"\tilde", r"\vec"),
        ("'", ""),
    )
    for text in forms_near(entry.true_form, changes):
        with pytest.raises(LedgerError):
            prove(with_form(entry, text))


def test_a_check_that_is_false_is_named() -> None:
    a, transposed = r"\mathbf{A}^{OB}", r"(\mathbf{A}^{OB})^T"
    same = Check("A differs from A", partial(different, words, a, a))
    other = Check("A is symmetric", partial(equal, words, a, transposed))
    for check, message in ((same, "A differs from A: no difference"), (other, "A is symmetric: ")):
        with pytest.raises(LedgerError, match=message):
            prove(replace(ENTRIES["skew-symmetric"], checks=(check,)))


def test_a_check_may_be_any_function() -> None:
    seen = Check("two and two", lambda: "four")
    assert str(prove(replace(ENTRIES["skew-symmetric"], checks=(seen,)))) == "two and two: four"
