"""Disjoint sets, against the sets that are joined one by one."""

from __future__ import annotations

import numpy as np

from kousoku.codegen.dynamics.disjoint_sets import DisjointSets


def test_sets_are_those_that_pairs_connect() -> None:
    rng = np.random.default_rng(7)
    members = range(-1, 40)
    sets = DisjointSets(members)
    expected = [{member} for member in members]
    for a, b in rng.integers(-1, 40, (30, 2)).tolist():
        own, other = (next(s for s in expected if x in s) for x in (a, b))
        assert sets.join(a, b) is (own is not other)
        if own is not other:
            expected.remove(other)
            own |= other
    assert sets.sets() == sorted(map(sorted, expected))
    assert [sets.of(member) for member in members] == [
        min(next(s for s in expected if member in s)) for member in members
    ]
