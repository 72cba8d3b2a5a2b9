"""Drivers of coordinates that joints or other drivers determine already: refused, never dropped.

Rows of joints may depend on each other, and some of them are left out. A driver says how the
mechanism shall move: where it takes part in a dependence there is one driver too many, also where
its formula agrees with the others, or the mechanism is at a position where it cannot move it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.assembly.residuals import remark_on_ratios
from kousoku.codegen.dynamics.assembly.violations import key_of
from kousoku.codegen.dynamics.redundancy.rank import DEPENDENT_REMAINDER, TAKES_PART
from kousoku.model.errors import SceneError
from kousoku.runtime.messages import listed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.program import RowIndex
    from kousoku.codegen.dynamics.redundancy.branch import Branch, BranchPosition
    from kousoku.codegen.dynamics.redundancy.rank import LQFactors
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.real import Array


class Drivers:
    """The rows of drivers in a part, beside those of its joints.

    Parameters
    ----------
    system : System
        The scene.
    branch : Branch
        Branch of the part, whose positions are those that joints allow.
    joints, drivers : sequence of (RowIndex, int)
        Rows, and their indices in the branch.
    """

    def __init__(
        self,
        system: System,
        branch: Branch,
        joints: Sequence[tuple[RowIndex, int]],
        drivers: Sequence[tuple[RowIndex, int]],
    ) -> None:
        self._system, self._branch = system, branch
        self._rows = [row for row, _ in (*joints, *drivers)]
        self._indices = [index for _, index in (*joints, *drivers)]
        self._count = len(drivers)
        self._first = len(joints)
        #: Rank of joints and factors of all rows, for each position that was looked at.
        self._ranks: list[tuple[int, LQFactors]] = []
        self._rank = 0

    def look(self, position: BranchPosition) -> bool:
        """Look at a position; return whether drivers are known to prescribe free coordinates."""
        self._rank = max(self._rank, position.factors.rank)
        if self._count and not self._are_free():
            factors = self._branch.factors_of(position, self._indices)
            self._ranks.append((position.factors.rank, factors))
        return self._are_free()

    def _extra(self, rank: int, factors: LQFactors) -> int:
        """Number of drivers of coordinates that joints of a rank, or other drivers, determine."""
        return rank + self._count - factors.rank

    def _are_free(self) -> bool:
        regular = [(rank, factors) for rank, factors in self._ranks if rank == self._rank]
        return not self._count or any(not self._extra(*pair) for pair in regular)

    def require_free(self) -> None:
        """Refuse drivers that depend on others, and scenes that start where they cannot move.

        Raises
        ------
        SceneError
            The message names the drivers and joints that depend on each other, and how many drivers
            to leave out.
        """
        if not self._count:
            return
        regular = [(rank, factors) for rank, factors in self._ranks if rank == self._rank]
        if not self._are_free():
            extras = ((self._extra(rank, factors), factors) for rank, factors in regular)
            self._refuse(*min(extras, key=lambda pair: pair[0]))
        rank, factors = self._ranks[0]
        if self._extra(rank, factors):
            names = self._taking_part(factors)
            drivers = listed([name for name in names if name in self._named()])
            joints = listed([name for name in names if name not in self._named()]) or "the bodies"
            where = f"at a dead centre of {drivers}: there {joints} may go on either way"
        elif rank < self._rank:
            where = (
                f"where rows of joints repeat each other that do not do so elsewhere, and"
                f" {listed([*self._named()])} cannot tell which of several motions follows"
            )
        else:
            return
        raise SceneError(
            f"the scene starts {where}; start it elsewhere, or drive another coordinate",
            key="drivers",
        )

    def _refuse(self, extra: int, factors: LQFactors) -> None:
        names = self._taking_part(factors)
        drivers = [name for name in names if name in self._named()]
        joints = [name for name in names if name not in self._named()]
        instances = [self._system.constraints[row.instance] for row in self._rows[: self._first]]
        remark = remark_on_ratios(instances, 1 / DEPENDENT_REMAINDER)
        held = f" determine already with {listed(joints)}" if joints else " prescribe already"
        if len(drivers) == 1:
            raise SceneError(
                f"prescribes {extra} more than {listed(joints) or 'bodies'} leave free, whatever"
                f" its formula is; drive another coordinate, leave it out, or free a joint{remark}",
                key=drivers[0],
            )
        raise SceneError(
            f"{listed(drivers)} prescribe more than is free: each of them drives what the others"
            f"{held}, also where their formulas agree; leave out {extra} of them{remark}",
            key="drivers",
        )

    def _named(self) -> dict[str, None]:
        return dict.fromkeys(self._key(row) for row in self._rows[self._first :])

    def _key(self, row: RowIndex) -> str:
        return key_of(self._system.constraints[row.instance])

    def _taking_part(self, factors: LQFactors) -> list[str]:
        """Keys of joints and drivers in dependences of drivers, in the order of the scene."""
        takes_part = np.zeros(len(self._rows), bool)
        for dependence in np.abs(_of_drivers(factors.dependences(), self._first)):
            takes_part |= dependence > TAKES_PART
        rows = sorted(
            (row for row, is_part in zip(self._rows, takes_part, strict=True) if is_part),
            key=lambda row: row.instance,
        )
        return list(dict.fromkeys(map(self._key, rows)))


def _of_drivers(dependences: Array, first: int) -> Array:
    """Dependences in which drivers take part, without those of joints among themselves.

    They span as many dimensions as there are drivers too many.
    """
    drivers = dependences[:, first:]
    vectors, sizes, _ = np.linalg.svd(drivers, full_matrices=False)
    combined: Array = vectors[:, sizes > TAKES_PART].T @ dependences
    return combined
