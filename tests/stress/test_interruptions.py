"""A cache or results that alone cannot be written: what is done then, and what is left."""

from __future__ import annotations

import random
from functools import partial

import pytest

from tests.stress import children, interruptions

#: What they look at is no part of kousoku.
pytestmark = [
    pytest.mark.release,
    pytest.mark.skipif(not children.CAN_FORK, reason="this system cannot fork"),
]


@pytest.mark.parametrize("mishap", ["none", "read-only-cache", "read-only-out"])
def test_results_come_without_a_cache_and_the_cache_without_results(mishap: str) -> None:
    work = interruptions.WORKS["simulate"]
    with interruptions._prepared(work) as place:
        before, prepare = interruptions._state(work, place), None
        if mishap != "none":
            prepare, _ = interruptions._mishap(mishap, random.Random(1), 0, place, 0)
        end = children.alone(partial(work.do, place), prepare)
        assert (end.how, end.said) == ("refused" if mishap == "read-only-out" else "good", "")
        assert len(end.text.splitlines()) == 1
        assert (interruptions._state(work, place) == before) == (mishap == "read-only-out")
        assert any((place / "cache").rglob("*")) == (mishap != "read-only-cache")
