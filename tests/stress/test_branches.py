"""The question of branches that come near: none of its motions takes minutes."""

from __future__ import annotations

import pytest

from tests.stress import branches

#: What it looks at is no part of kousoku.
pytestmark = pytest.mark.release


@pytest.mark.usefixtures("compiler")
def test_a_motion_that_takes_millions_of_steps_is_stopped() -> None:
    """Three of twelve did, and took 300 s."""
    outcome = branches.run("near 78 1")
    assert outcome.findings == []
    told = {name: number for name, number in outcome.counts.items() if "steps are made" in name}
    assert [*told.values()] == [3]
