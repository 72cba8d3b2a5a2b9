"""Every question of the stress suite finds the faults that are planted for it."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.stress.__main__ import questions
from tests.stress.kit import ROOT

FAULTS = [
    pytest.param(name, number, id=f"{name}-{fault.about}")
    for name, question in questions().items()
    for number, fault in enumerate(question.faults)
]


@pytest.mark.parametrize("name", [*questions()])
def test_every_question_has_a_planted_fault(name: str) -> None:
    assert questions()[name].faults


@pytest.mark.parametrize(("name", "number"), FAULTS)
def test_a_planted_fault_is_found(name: str, number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    # In a process and with a cache of its own: what the fault makes is found nowhere else.
    monkeypatch.delenv("KOUSOKU_CACHE", raising=False)
    command = [sys.executable, "-m", "tests.stress", name, "--plant", str(number)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    assert "FOUND" in done.stdout
