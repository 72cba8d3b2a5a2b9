"""Equations are cited by keys of the ledger: each number that stands in parentheses exists there.

A citation is a key in parentheses, ``(8.11)``, and a range names its ends, ``(5)–(7)``. A key that
is a word stands after the title of its document: ``three mass points, (inertia)``. In a step, the
source is a list of keys: ``12, 13``.
"""

from __future__ import annotations

import io
import json
import re
import tokenize
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest

from kousoku.ledger import entries, find, keys
from kousoku.ledger.entry import DOCUMENTS
from kousoku.model.errors import LedgerError
from kousoku.symbolic import KINDS, derive

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).parents[2]
FOLDERS = (
    "kousoku",
    "model",
    "symbolic",
    "ledger",
    "codegen",
    "runtime",
    "tests/benchmarks",
    "docs",
    "notebooks",
    "scenes",
)
SUFFIXES = {".py", ".jinja", ".c", ".md", ".ipynb", ".toml", ".json"}
NUMBER = r"[1-9]\d{0,2}(?:\.\d{1,3}){0,2}"
#: Not a call or an index, and not the count of terms that stands in emitted code.
CITED = re.compile(rf"(?<![\w\])}}.$^])(?<!shared terms )\(({NUMBER})\)")
RANGE = re.compile(r"\((\d{1,3})\)\s*[-–]\s*\((\d{1,3})\)")
TITLE = r"lecture 7\.1|lecture 8\.2|Yamada and Tatsumi \(?1981\)?|three mass points"
KEYS = r"\(([\w.-]+)\)(?:(?:, |–|-| and | to )\(([\w.-]+)\))*"
OF_DOCUMENT = re.compile(rf"({TITLE}),? ({KEYS})")
#: A key that a reader is asked to look up, or that a notebook looks up.
LOOKED_UP = re.compile(
    r"kousoku ledger ((?=[\w.-]*[\d-])\w[\w.-]*\w)|ledger\.find\(\\?[\"']([\w.-]+)\\?[\"']"
)
#: An equation that is cited in a way that the search above would not see.
UNSEEN = re.compile(rf"(?:\b[Ee]quations?|\b[Ee]qs?\.|{TITLE},) (?:{NUMBER})(?![\w\d])")


class Text(NamedTuple):
    """Something that was written by hand, and where."""

    where: str
    text: str


def written(folder: str) -> list[Path]:
    """Hand-written files of a folder, links left out."""
    return sorted(
        path
        for path in (ROOT / folder).rglob("*")
        if path.suffix in SUFFIXES
        and not any(parent.is_symlink() for parent in path.parents)
        and (path.parent.name, path.stem) != ("docs", "ledger")  # it quotes the documents
    )


@cache
def texts() -> tuple[Text, ...]:
    """Text that was written by hand: of Python the strings and comments, else all."""
    return tuple(_texts())


def _texts() -> Iterator[Text]:
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]
    for path in [*pages, *(p for folder in FOLDERS for p in written(folder))]:
        text, where = path.read_text(encoding="utf-8"), str(path.relative_to(ROOT))
        if path.suffix == ".py":
            yield from (Text(where, part) for part in of_python(text, path.parent.name))
        elif path.parent == ROOT / "ledger" / "documents":  # quotations; all else is below
            yield Text(where, "\n".join(x for x in text.splitlines() if x.startswith("#")))
        else:
            yield Text(where, text)
    for entry in entries():
        statements = [check.statement for check in (*entry.refutation, *entry.checks)]
        yield Text(f"the ledger, {entry.equation}", "\n".join([entry.reason, *statements]))


def of_python(text: str, folder: str) -> Iterator[str]:
    """Strings and comments of a source; the ledger's raw strings quote the documents."""
    kinds = {tokenize.COMMENT, tokenize.STRING, getattr(tokenize, "FSTRING_MIDDLE", -1)}
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type in kinds and not (folder == "ledger" and token.string.startswith("r")):
            yield token.string


def cited(text: str) -> list[str]:
    """Numbers of all equations that a text cites, those inside of ranges too."""
    inside = [
        str(number)
        for first, last in RANGE.findall(text)
        for number in range(int(first), int(last) + 1)
    ]
    return CITED.findall(text) + inside


def misplaced(text: str) -> list[str]:
    """Citations of a document's equations that it does not have."""
    wrong = []
    for match in OF_DOCUMENT.finditer(text):
        title = re.sub(r"[()]", "", match[1])
        for key in re.findall(r"\(([\w.-]+)\)", match[2]):
            if key not in keys() or keys()[key].document.title != title:
                wrong.append(f"{match[1]}, ({key})")
    return wrong


def test_every_citation_names_an_entry() -> None:
    unknown = [f"{t.where}: ({key})" for t in texts() for key in cited(t.text) if key not in keys()]
    assert not unknown


def test_every_citation_with_a_document_names_an_entry_of_that_document() -> None:
    assert not [f"{t.where}: {wrong}" for t in texts() for wrong in misplaced(t.text)]


def test_every_key_that_is_looked_up_names_an_entry() -> None:
    found = [(t.where, m[1] or m[2]) for t in texts() for m in LOOKED_UP.finditer(t.text)]
    assert ("README.md", "7.19") in found
    assert not [f"{where}: {key}" for where, key in found if key not in keys()]


def test_no_equation_is_cited_without_parentheses() -> None:
    assert not [f"{t.where}: {m[0]}" for t in texts() for m in UNSEEN.finditer(t.text)]


def test_the_search_sees_the_citations_of_every_folder() -> None:
    """The search itself, so that it cannot pass by finding nothing."""
    found = {t.where.split("/")[0] for t in texts() if cited(t.text)}
    wanted = {"model", "symbolic", "codegen", "runtime", "docs", "notebooks"}
    assert found >= wanted | {"kousoku", "tests"}


@pytest.mark.parametrize(
    ("text", "keys_of_it"),
    [
        ("by (8.11), (15) and (7.1.9)", ["8.11", "15", "7.1.9"]),
        ("(5)–(7) of the paper", ["5", "7", "5", "6", "7"]),
        ("range(3), A(2), x[0](1), (3,), (0) and in 1981 (1981)", []),
    ],
)
def test_a_citation_is_a_number_in_parentheses(text: str, keys_of_it: list[str]) -> None:
    assert cited(text) == keys_of_it


@pytest.mark.parametrize(
    "text", ["lecture 8.2, (7.16)", "three mass points, (8.9)", "lecture 7.1, (7.16) and (8.9)"]
)
def test_an_equation_of_another_document_is_misplaced(text: str) -> None:
    assert misplaced(text)


@pytest.mark.parametrize("kind", KINDS)
def test_every_step_and_kernel_of_every_kind_cites_entries(kind: str) -> None:
    for package in KINDS[kind].packages:
        derivation = derive(package)
        for step in derivation.steps:
            for key in filter(None, step.source.split(", ")):
                assert key in keys(), f"{package}, {step.rule}: {key}"
        for source in [derivation.source, *(f.source for f in derivation.functions)]:
            assert_cites(source)


def assert_cites(source: str) -> None:
    """Check that a source is a document's title with keys of the document, and nothing more."""
    assert re.fullmatch(rf"({TITLE})(, {KEYS})?", source), source
    assert not misplaced(source), source


def test_every_committed_kernel_cites_entries() -> None:
    manifests = sorted((ROOT / "generated").rglob("manifest.json"))
    assert manifests
    for path in manifests:
        for kernel in json.loads(path.read_text(encoding="utf-8"))["kernels"]:
            assert_cites(kernel["source"])


def test_a_key_that_does_not_exist_is_refused_with_near_ones() -> None:
    with pytest.raises(LedgerError, match=r"no equation '7\.33' .* near it are .*7\.13"):
        find("7.33")


def test_every_document_can_be_cited_by_its_title() -> None:
    for document in DOCUMENTS:
        assert re.fullmatch(TITLE, document.title)
