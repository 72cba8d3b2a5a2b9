"""Entries as data: what a table may say, and what is refused, by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from kousoku.ledger.documents import lecture_7_1
from kousoku.ledger.entry import LECTURE_7_1
from kousoku.ledger.proof import GENERAL, prove
from kousoku.ledger.reading import entry_of, read
from kousoku.ledger.registry import Names
from kousoku.model.errors import LedgerError

if TYPE_CHECKING:
    from pathlib import Path

    from kousoku.ledger.entry import Entry

NAMES = Names(lecture_7_1.NAMES)
A, TRANSPOSED = r"\mathbf{A}^{OB}", r"(\mathbf{A}^{OB})^T"
TRUE = {
    "equation": "true",
    "verdict": "holds",
    "printed": rf"{A} {TRANSPOSED} = \mathbf{{I}}_3",
    "words": "words",
}
CHECK = {"proof": "equal", "statement": "it is orthogonal", "left": A, "right": A}


@NAMES.proof("side {side} is {formula}")
def shown(side: int, formula: str) -> str:
    """Show what it was given."""
    return f"{side}, {formula}"


@NAMES.proof("some statements")
def claims(is_true: bool) -> dict[str, bool]:
    """Claim two things, the second of which may be false."""
    return {"one": True, "two": is_true}


def entry(**changes: Any) -> Entry:
    return entry_of(TRUE | changes, LECTURE_7_1, NAMES, "words")


def test_an_entry_with_words_is_a_formula_and_one_without_a_sentence() -> None:
    assert not entry().is_sentence and entry().vocabulary is lecture_7_1.words
    table = {key: value for key, value in TRUE.items() if key != "words"}
    said = entry_of(table | {"checks": [CHECK]}, LECTURE_7_1, NAMES, "words")
    assert said.is_sentence
    assert str(prove(said)) == "it is orthogonal: all 9 elements equal, identically"


def test_a_formula_is_by_default_the_entry_s_own_true_form() -> None:
    for more, formula in (
        ({}, "b = c"),
        ({"of": "printed"}, "a = c"),
        ({"of": "corrected"}, "b = c"),
        ({"formula": "d"}, "d"),
    ):
        table = {"proof": "shown", "side": 1, **more}
        (check,) = entry(printed="a = c", corrected="b = c", checks=[table]).checks
        assert (check.statement, check.run()) == (f"side 1 is {formula}", f"1, {formula}")


def test_a_side_of_it_is_counted_from_one() -> None:
    table = {"proof": "in_code", "function": "orientation", "output": "A", "side": 2}
    (check,) = entry(printed=rf"{TRANSPOSED} = {A}", checks=[table]).checks
    assert check.statement == "the code's rotation.orientation gives this as A"
    assert check.run() == "all 9 elements equal, identically"
    (check,) = entry(printed=rf"{TRANSPOSED} = {A}", checks=[table | {"side": 1}]).checks
    with pytest.raises(LedgerError, match="element 2 of 9"):
        check.run()


def test_statements_must_all_be_true() -> None:
    right, wrong = entry(checks=[{"proof": "claims", "is_true": x} for x in (True, False)]).checks
    assert right.run() == "one; two"
    with pytest.raises(LedgerError, match="it is not true that two"):
        wrong.run()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"verdict": "hold"}, "no verdict 'hold'"),
        ({"printd": "a"}, "printd"),
        ({"words": "wrods"}, "no words 'wrods'; did you mean 'words'"),
        ({"checks": [CHECK | {"proof": "eqaul"}]}, "no proof 'eqaul'; did you mean 'equal'"),
        ({"checks": [{"statement": "nothing"}]}, "no proof ''"),
        ({"checks": [CHECK | {"words": "wrods"}]}, "no words 'wrods'"),
        ({"checks": [CHECK | {"statement": ""}]}, "the proof 'equal' has no statement"),
        ({"checks": [CHECK | {"middle": A}]}, "middle"),
        ({"checks": [CHECK | {"of": "printed"}]}, "of"),
        ({"refutation": [{"proof": "in_steps"}]}, "key"),
        ({"checks": [{"proof": "shown", "of": "print", "side": 1}]}, "no form 'print'"),
        ({"checks": [{"proof": "shown", "of": "corrected", "side": 1}]}, "no form 'corrected'"),
    ],
)
def test_what_there_is_not_is_refused_with_the_entry_s_name(
    changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(LedgerError, match=message) as caught:
        entry(**changes)
    assert str(caught.value).startswith("true (lecture 7.1): ")


def test_a_proof_of_one_document_is_not_known_to_another() -> None:
    assert NAMES.method("shown").function is shown
    for other in (GENERAL, lecture_7_1.NAMES):
        with pytest.raises(LedgerError, match="no proof 'shown'"):
            other.method("shown")


def part(folder: Path, text: str) -> Any:
    """Module that stands beside a file."""
    (folder / "part.toml").write_text(text, encoding="utf-8")
    module = type(lecture_7_1)("part")
    module.__file__ = str(folder / "part.py")
    module.__dict__["NAMES"] = NAMES
    return module


def test_a_text_goes_on_in_an_indented_line(tmp_path: Path) -> None:
    text = """
document = "lecture 7.1"
words = "words"
[[entry]]
equation = "folded"
verdict = "holds"
printed = '''
  a  b
  = \\\\ c'''
reason = '''
first
second'''
"""
    (folded,) = read(part(tmp_path, text))
    assert folded.printed == "a  b = \\\\ c"
    assert folded.reason == "first\nsecond"


def test_a_file_that_is_no_toml_is_named(tmp_path: Path) -> None:
    with pytest.raises(LedgerError, match=r"part\.toml: .*line 1"):
        read(part(tmp_path, "document = lecture"))
