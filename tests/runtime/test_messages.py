"""Parts of messages that solvers and the door share."""

from __future__ import annotations

from kousoku.runtime.messages import MOST_NAMES_SHOWN, listed


def test_names_that_a_line_holds_are_all_told() -> None:
    names = [f"n{k}" for k in range(MOST_NAMES_SHOWN)]
    assert listed(names) == ", ".join(names)
    assert listed([*names, "last"]) == f"{', '.join(names)} and 1 more"
