"""Where the coordinates of a linkage stand in the arguments of its kernels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.model.assemble import Role
from kousoku.model.errors import EmitError
from kousoku.model.quantity import Quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.graph import Graph
    from kousoku.codegen.linkage_blocks import Block
    from kousoku.codegen.linkage_link import LinkRow
    from kousoku.model.assemble import System, Term


@dataclass(frozen=True, slots=True)
class Layout:
    """Where each coordinate stands in the arguments of the kernels.

    Parameters
    ----------
    system : System
        What is solved.
    blocks : tuple of Block
        In the order of solving; their unknowns, one after the other, are ``x``.
    link : tuple of LinkRow
        ε1, ε2, ε3 of the link element.
    """

    system: System
    blocks: tuple[Block, ...]
    link: tuple[LinkRow, LinkRow, LinkRow]

    @property
    def unknowns(self) -> tuple[int, ...]:
        """The coordinates of ``x``."""
        return tuple(unknown for block in self.blocks for unknown in block.unknowns)

    def arguments(self, order: int) -> tuple[Quantity, Quantity]:
        """Return ``alpha`` and ``x``, or their derivatives of the given order."""
        suffix, per, what = (
            ("", "", ""),
            ("_dot", "/s", "velocities of "),
            ("_ddot", "/s^2", "accelerations of "),
        )[order]
        return (
            self._quantity(f"alpha{suffix}", self.system.inputs, per, f"{what}the inputs"),
            self._quantity(f"x{suffix}", self.unknowns, per, f"{what}the unknowns"),
        )

    def _quantity(self, name: str, members: Sequence[int], per: str, what: str) -> Quantity:
        coordinates = [self.system.coordinates[member] for member in members]
        units = dict.fromkeys(f"{coordinate.unit}{per}" for coordinate in coordinates)
        names = [coordinate.name for coordinate in coordinates]
        listed = ", ".join(names) if len(names) < 5 else f"{names[0]} ... {names[-1]}"
        return Quantity(name, (len(members),), ", ".join(units), f"{what} {listed}")

    def node(self, graph: Graph, term: Term, order: int) -> int:
        """Return the graph node of offset + factor · coordinate, or of a time derivative of it."""
        coordinate = self.system.coordinates[term.coordinate]
        if coordinate.role is Role.FIXED:
            value = term.offset + term.factor * coordinate.start if order == 0 else 0
            return graph.const(value)
        name, members = ("x", self.unknowns)
        if coordinate.role is Role.INPUT:
            name, members = ("alpha", self.system.inputs)
        if not term.factor:
            return graph.const(term.offset if order == 0 else 0)
        if term.coordinate not in members:
            raise EmitError(f"{coordinate.name} is needed, but no block computes it")
        suffix = ("", "_dot", "_ddot")[order]
        moving = graph.input(name + suffix, members.index(term.coordinate))
        scaled = graph.mul(graph.const(term.factor), moving)
        return graph.add(scaled, graph.const(term.offset)) if order == 0 else scaled
