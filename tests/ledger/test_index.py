"""The index and the entries are about the same statements, and both about what the documents say.

The second half reads the documents themselves, where they are: beside the repository, or in the
folder that ``KOUSOKU_SEEDS`` names. It finds what they display without looking at the entries.
"""

from __future__ import annotations

import json
import os
import re
from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest

from kousoku.ledger import entries, index, keys
from kousoku.ledger.entry import DOCUMENTS, Document
from kousoku.ledger.index import PATH, digest, index_of, normalised, print_index

ROOT = Path(__file__).parents[2]
SEEDS = Path(os.environ.get("KOUSOKU_SEEDS", ROOT.parent / "shared" / "seeds"))
#: Lines of the documents, joined by single spaces: what is printed is found whatever its breaks.
JAPANESE = re.compile(r"[\u3040-\u30ff\u4e00-\u9fff]")

documents = pytest.mark.parametrize("document", DOCUMENTS, ids=lambda document: document.title)


def test_every_indexed_statement_has_exactly_one_entry_that_prints_it() -> None:
    found = Counter((e.document.file, e.equation, digest(e.printed)) for e in entries())
    for row in json.loads(PATH.read_text(encoding="utf-8")):
        assert found[row["document"], row["equation"], row["digest"]] == 1, row


def test_every_entry_is_in_the_index_and_the_index_is_in_its_order() -> None:
    wanted = print_index(index_of(entries()))
    assert PATH.read_text(encoding="utf-8") == wanted, "run python -m kousoku.ledger.index"


def test_the_index_can_be_written_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(index, "PATH", tmp_path / "index.json")
    index.main()
    assert index.PATH.read_text(encoding="utf-8") == PATH.read_text(encoding="utf-8")


def test_no_two_entries_share_a_key() -> None:
    assert len(keys()) == sum(1 + len(entry.aliases) for entry in entries())


def test_a_digest_does_not_depend_on_line_breaks_but_on_every_letter() -> None:
    assert digest("a =\n  b") == digest(" a = b ") != digest("a = b'")


def test_every_document_has_entries() -> None:
    assert {entry.document for entry in entries()} == set(DOCUMENTS)


# -- against the documents -----------------------------------------------------------------------


def text_of(document: Document) -> str:
    """Text of a document as one line; the test is skipped where the documents are not."""
    path = SEEDS / document.file
    if not path.is_file():
        pytest.skip("the documents are not here; KOUSOKU_SEEDS names their folder")
    return path.read_text(encoding="utf-8")


def displays(text: str) -> list[str]:
    """Displays of a document: between double dollars, or paragraphs without prose."""
    if "$$" in text:
        return [normalised(shown) for shown in re.findall(r"\$\$(.*?)\$\$", text, re.DOTALL)]
    paragraphs = (normalised(part) for part in re.split(r"\n\s*\n", text))
    return [part for part in paragraphs if is_formula(part)]


def is_formula(paragraph: str) -> bool:
    """Whether a paragraph is a formula: TeX or a relation, and no Japanese."""
    return bool(re.search(r"[\\=]", paragraph)) and not JAPANESE.search(paragraph)


def covered(text: str, document: Document) -> list[bool]:
    """Whether each letter of a document stands in what some entry prints."""
    seen = [False] * len(text)
    for entry in entries():
        if entry.document == document:
            printed = normalised(entry.printed)
            at = text.find(printed)
            while at >= 0:
                seen[at : at + len(printed)] = [True] * len(printed)
                at = text.find(printed, at + 1)
    return seen


#: What a display holds beside its formulas.
LAYOUT = re.compile(
    r"\\begin\{(?:aligned|eqnarray|cases)\}|\\end\{(?:aligned|eqnarray|cases)\}"
    r"|\\tag\{\d+\}|\\quad \([\d.]+\)|\\\\|[&,\s]|\\quad"
)


@documents
def test_every_printed_form_stands_in_its_document_letter_by_letter(document: Document) -> None:
    text = normalised(text_of(document))
    own = [entry for entry in entries() if entry.document == document]
    assert not [e.equation for e in own if normalised(e.printed) not in text]


@documents
def test_everything_that_a_document_displays_has_an_entry(document: Document) -> None:
    raw = text_of(document)
    text = normalised(raw)
    seen, at, left_over = covered(text, document), 0, []
    for shown in displays(raw):
        at = text.index(shown, at)
        rest = "".join("" if seen[at + k] else letter for k, letter in enumerate(shown))
        if LAYOUT.sub("", rest):
            left_over.append(f"{rest!r} of {shown!r}")
        at += len(shown)
    assert not left_over, "\n".join(left_over)


#: Words by which the prose states a condition; each sentence with one of them has an entry.
CONDITION = re.compile(
    "独立|ならない|成り立|成立し|一致して|一致は|未知|既知|一定の|反復回数|最大値|不変|逆になる|反転|固定されて|必要である"
    "|対応し"
)


def sentences(text: str) -> list[tuple[int, str]]:
    """Sentences of a text with the places where they begin."""
    ends = [0, *(m.end() for m in re.finditer(r"。|．|(?<=[\u3040-\u9fff])\.", text)), len(text)]
    return [(start, text[start:end]) for start, end in pairwise(ends)]


@documents
def test_every_sentence_that_states_a_condition_has_an_entry(document: Document) -> None:
    text = normalised(text_of(document))
    seen = covered(text, document)
    found = [(at, said) for at, said in sentences(text) if CONDITION.search(said)]
    assert found
    assert not [said for at, said in found if not any(seen[at : at + len(said)])]


@documents
def test_every_equality_inside_of_the_prose_has_an_entry(document: Document) -> None:
    text = normalised(text_of(document))
    seen = covered(text, document)
    for formula in re.finditer(r"(?<!\$)\$([^$]+)\$(?!\$)", text):
        sides = formula[1].split("=")
        is_value = bool(re.fullmatch(r"[\d., ]+(\\text.*)?", sides[-1].strip()))
        if len(sides) > 1 and not is_value:
            assert all(seen[formula.start(1) + 1 : formula.end(1) - 1]), formula[1]


def numbers(text: str) -> list[str]:
    """Numbers that stand beside the displays of a document."""
    shown = " ".join(displays(text))
    return [m[1] or m[2] for m in re.finditer(r"\\tag\{(\d+)\}|\\quad \(([\d.]+)\)", shown)]


@documents
def test_every_number_of_an_equation_is_the_key_of_an_entry(document: Document) -> None:
    known = {entry.equation for entry in entries() if entry.document == document}
    wanted = numbers(text_of(document))
    assert not [number for number in wanted if number not in known]
    assert len(wanted) == len(set(wanted))


def test_what_the_documents_display_is_found() -> None:
    """The search itself: how much it finds, so that it cannot pass by finding nothing."""
    found = {d.title: len(displays(text_of(d))) for d in DOCUMENTS}
    tagged = {d.title: len(numbers(text_of(d))) for d in DOCUMENTS}
    assert found == {
        "lecture 7.1": 14,
        "lecture 8.2": 11,
        "Yamada and Tatsumi 1981": 35,  # (33) is displayed in two parts
        "three mass points": 28,
    }
    assert tagged == {
        "lecture 7.1": 13,
        "lecture 8.2": 11,
        "Yamada and Tatsumi 1981": 34,
        "three mass points": 0,
    }
