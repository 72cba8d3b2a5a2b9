"""Entries of q that belong to no body: angles that count turns, and work that is done.

They stand after the coordinates of all bodies, and no column of v belongs to them. A run integrates
them with the rest of q, keeps them in its state and interpolates them between steps. ``move`` sets
those that positions determine, and leaves the others; no error is estimated of them.

To add one:

1. :func:`entries_of` lists it: what it is, its name, where it starts.
2. While ``acceleration`` is recorded, the composer writes its rate
   ``into=(self.auxiliary.of(self.q_dot, WORK, name),)``; its own value is
   ``self.auxiliary.of(self.q, WORK, name)``. ``move`` leaves what :meth:`Auxiliaries.kept` lists.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.program import Auxiliary, CoordinatePlace
from kousoku.codegen.dynamics.recording.recorder import slot_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.matrix import Matrix
    from kousoku.codegen.dynamics.recording.recorder import SlotMatrix
    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.model.mechanics.multibody import System

#: An angle with its turns [rad], which positions determine up to whole turns.
TURNS = "turns"
#: The work that a force or a driver has done since the start [J].
WORK = "work"


def entries_of(system: System) -> tuple[Auxiliary, ...]:
    """Entries that a system needs, in their order."""
    turns = (angle for angle in system.coordinates if angle.counts_turns)
    working = dict.fromkeys(force.name for force in system.forces if force.is_nonconservative)
    working |= dict.fromkeys(drivers_of(system))
    return (
        *(Auxiliary(TURNS, angle.name, CoordinatePlace(-1, angle.near)) for angle in turns),
        *(Auxiliary(WORK, name, CoordinatePlace(-1, 0.0)) for name in working),
    )


def drivers_of(system: System) -> tuple[str, ...]:
    """Names of the drivers."""
    return tuple(dict.fromkeys(driver.joint for driver in system.constraints if driver.is_driver))


class Auxiliaries:
    """Indices of the entries in q.

    Parameters
    ----------
    entries : sequence of Auxiliary
        In their order.
    first : int
        How many entries q has before them.
    """

    def __init__(self, entries: Sequence[Auxiliary], first: int) -> None:
        self.entries = tuple(entries)
        self.first = first
        self._indices = {(x.kind, x.name): first + k for k, x in enumerate(self.entries)}

    def of(self, region: SlotMatrix, kind: str, name: str) -> SlotMatrix:
        """Entry of a region that is ordered as q."""
        return region.part(self._indices[kind, name], 1)

    def kept(self, region: SlotMatrix) -> list[SlotMatrix]:
        """Entries of a region that positions do not determine."""
        kinds = ((entry.kind, entry.name) for entry in self.entries)
        return [self.of(region, kind, name) for kind, name in kinds if kind != TURNS]

    def placed(self, q: SlotMatrix) -> tuple[Auxiliary, ...]:
        """Entries with their slots, for a run of the program."""
        return tuple(
            replace(entry, place=replace(entry.place, slot=slot_of(q.entries[self.first + k])))
            for k, entry in enumerate(self.entries)
        )


@dataclass(frozen=True, slots=True)
class Copy:
    """Leave a value as it is. Blocks: the value."""

    title: str = "copy"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """The value as it is."""
        return blocks
