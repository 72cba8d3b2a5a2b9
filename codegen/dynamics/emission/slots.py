"""Slots of the workspace by the names of their regions."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from kousoku.codegen.dynamics.recording.program import Program

#: Region of the values that functions pass to each other, behind all others.
SCRATCH = "scratch"


@dataclass(frozen=True, slots=True)
class Slots:
    """Regions of a workspace, in order.

    Parameters
    ----------
    bases : tuple of int
        First slot of each.
    names : tuple of str
        Names as in ``REGIONS``, ``scratch`` last.
    """

    bases: tuple[int, ...]
    names: tuple[str, ...]

    def name(self, slot: int) -> tuple[str, int]:
        """Region of a slot, and its index in the region."""
        k = bisect_right(self.bases, slot) - 1
        return self.names[k], slot - self.bases[k]

    def text(self, slot: int) -> str:
        """Slot as C names it."""
        return "{}[{}]".format(*self.name(slot))


def slots_of(program: Program) -> Slots:
    """Regions of a program; those that are empty have no slots."""
    regions = sorted((region.base, region.name) for region in program.regions if region.size)
    end = max((region.base + region.size for region in program.regions if region.size), default=0)
    bases, names = zip(*regions, (end, SCRATCH), strict=True)
    return Slots(bases, names)
