"""Disjoint sets of bodies, joints or rows that belong together."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable


class DisjointSets:
    """Sets that are joined two at a time, each led by the lowest of its members.

    Parameters
    ----------
    members : iterable of int
        All members; each is a set at first. The ground, −1, may be one of them.

    References
    ----------
    Tarjan, "Efficiency of a good but not linear set union algorithm", J. ACM 22, 1975; paths are
    halved, as van Leeuwen proposed.
    """

    def __init__(self, members: Iterable[int]) -> None:
        self._above = {member: member for member in members}

    def of(self, member: int) -> int:
        """Leader of the set that a member is in."""
        above = self._above
        while above[member] != member:
            above[member] = above[above[member]]
            member = above[member]
        return member

    def join(self, a: int, b: int) -> bool:
        """Make the sets of two members one; return whether they were two."""
        low, high = sorted((self.of(a), self.of(b)))
        self._above[high] = low
        return low != high

    def sets(self) -> list[list[int]]:
        """Members of each set, all in the order in which they were given."""
        sets: dict[int, list[int]] = {}
        for member in self._above:
            sets.setdefault(self.of(member), []).append(member)
        return list(sets.values())
