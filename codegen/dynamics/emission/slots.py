"""Slots of the workspace by the names of their regions."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from kousoku.codegen.dynamics.recording.program import Program

#: What is passed from function to function, behind all regions.
SCRATCH = "scratch"


@dataclass(frozen=True, slots=True)
class Slots:
    """The regions of a workspace, in order.

    Parameters
    ----------
    bases : tuple of int
        Where they begin.
    names : tuple of str
        As in ``REGIONS``, at last ``scratch``.
    """

    bases: tuple[int, ...]
    names: tuple[str, ...]

    def name(self, slot: int) -> tuple[str, int]:
        """Region of a slot, and its place there."""
        k = bisect_right(self.bases, slot) - 1
        return self.names[k], slot - self.bases[k]

    def text(self, slot: int) -> str:
        """Slot as C names it."""
        return "{}[{}]".format(*self.name(slot))


def slots_of(program: Program) -> Slots:
    """Regions of a program; those that are empty have no slots."""
    regions = sorted((one.base, one.name) for one in program.regions if one.size)
    end = max((one.base + one.size for one in program.regions if one.size), default=0)
    bases, names = zip(*regions, (end, SCRATCH), strict=True)
    return Slots(bases, names)
