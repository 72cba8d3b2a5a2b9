"""Where the coordinates of a linkage stand in the arguments of its kernels.

The kernels of a block take its own unknowns as ``x`` and what they depend on as ``known``: inputs,
and unknowns of earlier blocks, the parts of (18) and (19). The kernels of the outputs take all
inputs as ``alpha`` and all unknowns, block after block, as ``x``.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from kousoku.codegen.linkage_blocks import DEPENDS
from kousoku.model.assemble import Role
from kousoku.model.quantity import Quantity

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from kousoku.codegen.linkage_blocks import Block
    from kousoku.codegen.linkage_link import LinkRow
    from kousoku.model.assemble import System, Term
    from kousoku.model.graph import Graph

    #: For each coordinate the argument and the index where it stands.
    Places = Mapping[int, tuple[str, int]]

SUFFIXES = ("", "_dot", "_ddot")
_PER = ("", "/s", "/s^2")
_MOTIONS = ("", "velocities of ", "accelerations of ")


@dataclass(frozen=True, slots=True)
class Layout:
    """The order of everything.

    Parameters
    ----------
    system : System
        What is solved.
    blocks : tuple of Block
        In the order of solving.
    link : tuple of LinkRow
        ε1, ε2, ε3 of the link element.
    unknowns : tuple of int
        The unknown coordinates, block after block.
    known : tuple of tuple of int
        For each block the coordinates that it depends on and that are known by then.
    everywhere : mapping of int to (str, int)
        Where each coordinate stands in ``alpha`` or ``x`` of the outputs.
    """

    system: System
    blocks: tuple[Block, ...]
    link: tuple[LinkRow, LinkRow, LinkRow]
    unknowns: tuple[int, ...] = field(init=False)
    known: tuple[tuple[int, ...], ...] = field(init=False)
    everywhere: Places = field(init=False)

    def __post_init__(self) -> None:
        unknowns = tuple(unknown for block in self.blocks for unknown in block.unknowns)
        everywhere = _places((("alpha", self.system.inputs), ("x", unknowns)))
        order = {coordinate: k for k, coordinate in enumerate(everywhere)}
        known = tuple(
            tuple(sorted(self._needed(block) - set(block.unknowns), key=order.__getitem__))
            for block in self.blocks
        )
        object.__setattr__(self, "unknowns", unknowns)
        object.__setattr__(self, "everywhere", everywhere)
        object.__setattr__(self, "known", known)

    def _needed(self, block: Block) -> set[int]:
        terms = (
            self.system.elements[number].ends[place]
            for number, row in block.rows
            for place in DEPENDS[row]
        )
        return {term.coordinate for term in terms if self.is_moving(term)}

    def is_moving(self, term: Term) -> bool:
        """Whether a term depends on a coordinate that is not fixed."""
        role = self.system.coordinates[term.coordinate].role
        return bool(term.factor) and role is not Role.FIXED

    def place_of(self, coordinate: int) -> int:
        """Return where a coordinate stands among the inputs and, after them, the unknowns."""
        name, index = self.everywhere[coordinate]
        return index if name == "alpha" else len(self.system.inputs) + index

    def places_in(self, number: int) -> Places:
        """Return where coordinates stand in ``known`` or ``x`` of the kernels of a block."""
        return _places((("known", self.known[number]), ("x", self.blocks[number].unknowns)))

    def block_arguments(self, number: int, motion: int) -> tuple[Quantity, ...]:
        """Return the inputs of the kernel of a block: position, velocity or acceleration."""
        orders = ((0,), (0, 1), (0, 1, 2))[motion]
        members = (("known", self.known[number]), ("x", self.blocks[number].unknowns))
        return tuple(
            self._quantity(name, coordinates, order, "")
            for order in orders
            for name, coordinates in members
            # Velocities are found from those that are known, accelerations from all velocities.
            if coordinates and not (name == "x" and order == motion > 0)
        )

    def output_arguments(self) -> tuple[Quantity, ...]:
        """Return the inputs of the kernels of the outputs."""
        members = (("alpha", self.system.inputs, "inputs "), ("x", self.unknowns, "unknowns "))
        return tuple(
            self._quantity(name, coordinates, order, what)
            for order in range(3)
            for name, coordinates, what in members
        )

    def _quantity(self, name: str, members: Sequence[int], order: int, what: str) -> Quantity:
        coordinates = [self.system.coordinates[member] for member in members]
        units = dict.fromkeys(f"{coordinate.unit}{_PER[order]}" for coordinate in coordinates)
        names = [coordinate.name for coordinate in coordinates]
        listed = ", ".join(names) if len(names) < 5 else f"{names[0]} ... {names[-1]}"
        meaning = f"{_MOTIONS[order]}{what}{listed}"
        return Quantity(name + SUFFIXES[order], (len(members),), ", ".join(units), meaning)

    def node(self, graph: Graph, term: Term, order: int, places: Places) -> int:
        """Return the graph node of offset + factor · coordinate, or of a time derivative of it."""
        coordinate = self.system.coordinates[term.coordinate]
        if not self.is_moving(term):
            fixed = term.factor * coordinate.start if coordinate.role is Role.FIXED else 0
            return graph.const(term.offset + fixed if order == 0 else 0)
        name, index = places[term.coordinate]
        moving = graph.input(name + SUFFIXES[order], index)
        scaled = graph.mul(graph.const(term.factor), moving)
        return graph.add(scaled, graph.const(term.offset)) if order == 0 else scaled


def _places(arguments: Iterable[tuple[str, Sequence[int]]]) -> dict[int, tuple[str, int]]:
    return {c: (name, k) for name, members in arguments for k, c in enumerate(members)}
