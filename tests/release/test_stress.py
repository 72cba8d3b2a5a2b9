"""Every question of the stress suite finds the faults that are planted for it, and only those."""

from __future__ import annotations

import re
import subprocess
import sys
from functools import cache

import pytest

from tests.stress.__main__ import OPTIONS, questions
from tests.stress.kit import ROOT

FAULTS = [
    pytest.param(name, number, id=f"{name}-{fault.about}")
    for name, question in questions().items()
    for number, fault in enumerate(question.faults)
]


@pytest.fixture(autouse=True)
def no_options(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ask as if nobody had set options, and with a cache that no other process has.

    What a fault makes is found nowhere else.
    """
    for name in (*OPTIONS, "KOUSOKU_CACHE"):
        monkeypatch.delenv(name, raising=False)


def told(name: str, *words: str) -> tuple[int, list[str]]:
    """Ask a question in a process of its own; return the exit status and the titles found."""
    command = [sys.executable, "-m", "tests.stress", name, *words]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert "# What breaks it" in done.stdout, done.stderr  # the page: it came to its end
    return done.returncode, re.findall(rf"(?m)^FOUND {name}: (.*)", done.stdout)


@cache
def told_without_fault(name: str, case: str) -> tuple[int, list[str]]:
    """Answer of a case without a fault, once for all of its faults."""
    return told(name, "--case", case)


@pytest.mark.parametrize("name", [*questions()])
def test_every_question_has_a_planted_fault(name: str) -> None:
    assert questions()[name].faults


@pytest.mark.parametrize(("name", "number"), FAULTS)
def test_a_planted_fault_is_found_and_nothing_without_it(name: str, number: int) -> None:
    fault = questions()[name].faults[number]
    assert told_without_fault(name, fault.case) == (0, [])
    status, titles = told(name, "--plant", str(number))
    assert status == 1
    assert any(title.startswith(fault.finds) for title in titles), titles
