"""Statuses and tolerances: the same in C and in Python."""

from __future__ import annotations

import ctypes
import re
from pathlib import Path
from typing import TYPE_CHECKING

import kousoku.runtime
from kousoku.runtime.kinematics import status
from kousoku.runtime.kinematics.status import MESSAGES, AnalysisStatus

if TYPE_CHECKING:
    from collections.abc import Callable

HEADER = Path(kousoku.runtime.__path__[0]) / "kinematics" / "status.h"
TOLERANCES = ("SETTLED", "ROUNDING", "SINGULAR", "SMALLEST_STEP")


def test_tolerances_of_the_header_are_those_of_the_module() -> None:
    text = HEADER.read_text(encoding="utf-8")
    for name in TOLERANCES:
        (value,) = re.findall(rf"^#define {name} (\S+)$", text, re.MULTILINE)
        number = float.fromhex(value) if value.startswith("0x") else float(value)
        assert number == getattr(status, name), name


def test_statuses_of_the_header_are_those_of_the_module() -> None:
    (names,) = re.findall(r"enum \{(.*?)\}", HEADER.read_text(encoding="utf-8"), re.DOTALL)
    assert re.findall(r"\w+", names) == [one.name for one in AnalysisStatus]
    assert [one.value for one in AnalysisStatus] == list(range(len(MESSAGES)))


def test_each_status_has_its_sentence_in_both_languages(
    compiled: Callable[[], ctypes.CDLL],
) -> None:
    message = compiled().test_message
    message.restype = ctypes.c_char_p
    assert [message(one).decode() for one in AnalysisStatus] == [
        one.message for one in AnalysisStatus
    ]
    assert [message(k) for k in (-1, len(AnalysisStatus))] == [b"unknown status"] * 2
