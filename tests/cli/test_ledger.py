"""``kousoku ledger``: the table, one entry, JSON, LaTeX, and what happens when a proof fails."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

import kousoku.ledger
from kousoku.ledger import entries, find
from kousoku.ledger.entry import DOCUMENTS
from kousoku.ledger.proof import Line, Proof
from kousoku.model.errors import LedgerError

if TYPE_CHECKING:
    from collections.abc import Callable

    Run = Callable[..., tuple[int, str, str]]

FIELDS = {"document", "equation", "verdict", "printed", "corrected", "proof"}


def test_the_table_has_a_row_for_every_entry_and_counts(run: Run) -> None:
    code, out, err = run("ledger")
    rows, counts = out.split("\n\n")
    assert (code, err) == (0, "")
    for line, entry in zip(rows.splitlines()[1:], entries(), strict=True):
        assert line.startswith(entry.document.title)
        assert f" {entry.equation} " in line and f" {entry.verdict} " in line
    assert len(counts.splitlines()) == len(DOCUMENTS) + 1
    assert f"in all: {len(entries())} entries" in counts


def test_the_table_runs_no_proof(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: object) -> None:
        raise AssertionError

    monkeypatch.setattr(kousoku.ledger, "prove", refuse)
    assert run("ledger")[0] == 0


@pytest.mark.parametrize("key", ["7.1.9", "7.13", "(7.13)"])
def test_an_entry_is_found_by_its_number_and_by_another(run: Run, key: str) -> None:
    code, out, err = run("ledger", key)
    assert (code, err) == (0, "")
    assert out.startswith("lecture 7.1, (7.1.9): misprint")
    assert out.index("printed") < out.index("corrected") < out.index("proof")
    assert "equal, identically" in out


def test_an_unknown_key_is_one_message_with_near_ones(run: Run) -> None:
    code, out, err = run("ledger", "8.111")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1 and "'8.111'" in err and "8.11" in err.partition("near")[2]


def test_json_of_a_key_is_a_list_of_one(run: Run) -> None:
    code, out, _ = run("ledger", "7.19", "--json")
    (answer,) = json.loads(out)["entries"]
    assert code == 0
    assert answer.keys() >= FIELDS
    assert (answer["equation"], answer["verdict"]) == ("7.19", "misprint")
    assert answer["corrected"] and "cannot be formed" in answer["proof"]


def test_json_of_all_holds_every_entry_with_its_proof(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    proof = Proof((Line("what was tested", "what was seen"),))  # the real ones take half a minute
    monkeypatch.setattr(kousoku.ledger, "prove", lambda _: proof)
    code, out, err = run("ledger", "--json")
    answers = json.loads(out)["entries"]
    assert (code, err) == (0, "")
    assert [answer["equation"] for answer in answers] == [e.equation for e in entries()]
    assert {answer["document"] for answer in answers} == {d.file for d in DOCUMENTS}
    assert all(answer.keys() >= FIELDS and answer["proof"] == str(proof) for answer in answers)
    assert {a["verdict"] for a in answers} == {"holds", "notation", "misprint"}


def test_latex_of_a_key_is_a_whole_document(run: Run) -> None:
    code, out, _ = run("ledger", "7.19", "--latex")
    assert code == 0
    assert "\\documentclass" in out and out.rstrip().endswith("\\end{document}")
    assert "\\entry{7.19}" in out


def test_markdown_of_a_key_shows_its_formulas(run: Run) -> None:
    code, out, _ = run("ledger", "7.19", "--markdown")
    assert code == 0
    assert "### (7.19) misprint" in out and "```math" in out


@pytest.mark.parametrize("option", [(), ("--json",), ("--latex",), ("--markdown",)])
def test_a_proof_that_fails_is_named_with_its_statement(
    run: Run, monkeypatch: pytest.MonkeyPatch, option: tuple[str, ...]
) -> None:
    wrong = replace(find("7.19"), verdict="notation")
    monkeypatch.setattr(kousoku.ledger, "find", lambda _: wrong)
    code, out, err = run("ledger", "7.19", *option)
    assert code == 1
    assert err.count("\n") == 1 and "7.19" in err and "notation" in err
    proof = json.loads(out)["entries"][0]["proof"] if out.startswith("{") else out
    assert "FAILED" in out or "The proof failed" in out or proof == ""


def test_all_proofs_that_fail_are_named(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(entry: object) -> None:
        raise LedgerError(f"{getattr(entry, 'equation', '')}: refused")

    monkeypatch.setattr(kousoku.ledger, "prove", fail)
    code, _, err = run("ledger", "--json")
    assert code == 1
    assert err.count("refused") == len(entries())
