"""A question for the tests of the kit: cases that end, last, fail and are missing."""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING

from tests.benchmarks.kit import Call, Case, Judged, PeerMissingError, Question, required

if TYPE_CHECKING:
    from tests.benchmarks.kit import Size


def quick() -> Call:
    return Call(lambda: sum(range(100)), lambda: Judged(1e-7, {"steps": 3.0}), count=10)


def unending() -> Call:
    return Call(lambda: time.sleep(3600))


def wrong() -> Call:
    return Call(lambda: 1 / 0)


def deadly() -> Call:
    return Call(lambda: os._exit(7))


def absent() -> Call:
    required("no_such_peer")
    raise PeerMissingError("not reached")


def cases(contest: str, size: Size) -> list[Case]:
    """Cases, one for each fate; the contest names which."""
    made = {
        "quick": [("a", "line", quick), ("b", "line", quick)],
        "unending": [("a", "slow", unending), ("a", "slow", quick), ("a", "line", quick)],
        "failing": [("a", "wrong", wrong), ("b", "deadly", deadly), ("b", "line", quick)],
        "missing": [("absent", "x", absent), ("absent", "y", absent), ("a", "line", quick)],
    }
    return [Case(tool, line, "1", "scene", prepare) for tool, line, prepare in made[contest]]


QUESTION = Question(
    title="A question",
    asks="What is asked.",
    contests=lambda size: ["quick", "missing"] if size.is_full else ["quick"],
    cases=cases,
    body=lambda records, figures: f"{len(records)} records",
    words=lambda records: "It wins.",
)
