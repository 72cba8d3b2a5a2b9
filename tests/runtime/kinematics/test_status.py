"""Statuses and numbers: the same in C and in Python."""

from __future__ import annotations

import ctypes
import re
from pathlib import Path
from typing import TYPE_CHECKING

import kousoku.runtime
from kousoku.runtime.kinematics import certificate, status
from kousoku.runtime.kinematics.status import MESSAGES, AnalysisStatus

if TYPE_CHECKING:
    from collections.abc import Callable

HEADER = Path(kousoku.runtime.__path__[0]) / "kinematics" / "status.h"


def number_of(text: str) -> float:
    """Number of a macro: decimal, hexadecimal, or a quotient in parentheses."""
    if text.startswith("0x"):
        return float.fromhex(text)
    above, _, below = text.strip("()").partition(" / ")
    return float(above) / float(below or 1)


def test_numbers_of_the_headers_are_those_of_the_modules() -> None:
    headers = [HEADER.with_name(name) for name in ("status.h", "certificate.h")]
    texts = [path.read_text(encoding="utf-8") for path in headers]
    macros = dict(re.findall(r"^#define (\w+) (.+)$", "\n".join(texts), re.MULTILINE))
    named = {name: value for one in (status, certificate) for name, value in vars(one).items()}
    numbers = {name: value for name, value in named.items() if type(value) in {int, float}}
    assert {name: number_of(value) for name, value in macros.items()} == numbers


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
