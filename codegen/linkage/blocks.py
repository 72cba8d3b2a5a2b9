"""Blocks of the equations of a linkage, which are solved one after the other.

The finest block-triangular form of the residuals ε = 0 (Dulmage and Mendelsohn 1958): a perfect
matching of equations and unknowns, then the strongly connected components in the order of their
dependence. A lever crank falls apart into two blocks of two and a rotation at each hinge; a
rotation that nothing else needs and nobody asked for is never computed.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.linkage.assemble import Role

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.linkage.assemble import Assembly, LinkElement

#: Indices in x1 y1 β1 x2 y2 β2 of the coordinates that ε1, ε2, ε3 depend on, (5)–(7).
DEPENDS = ((0, 1, 3, 4), (0, 1, 2, 3, 4), (0, 1, 3, 4, 5))

Equation = tuple[int, int]


@dataclass(frozen=True, slots=True)
class DiagonalBlock:
    """Unknowns that are solved together, and their equations.

    Parameters
    ----------
    unknowns : tuple of int
        Coordinates of the assembly, ascending.
    rows : tuple of (int, int)
        As many equations: element of the assembly, and 0, 1 or 2 for ε1, ε2 or ε3.
    """

    unknowns: tuple[int, ...]
    rows: tuple[Equation, ...]


def triangular_blocks(assembly: Assembly) -> tuple[DiagonalBlock, ...]:
    """Blocks of an assembly, each after those that it depends on."""
    unknowns_of = {
        (number, row): _unknowns(assembly, element, row)
        for number, element in enumerate(assembly.elements)
        for row in element.rows
    }
    row_of = _match(unknowns_of)
    count = sum(coordinate.role is Role.UNKNOWN for coordinate in assembly.coordinates)
    # as many rows as unknowns, and independent ones: model/linkage/mobility.py has refused other
    # scenes
    assert len(row_of) == len(unknowns_of) == count
    return _components(unknowns_of, row_of)


def live_blocks(
    assembly: Assembly, blocks: Sequence[DiagonalBlock], wanted: Sequence[int]
) -> tuple[DiagonalBlock, ...]:
    """Blocks that the wanted coordinates depend on, in the same order."""
    needed = set(wanted)
    kept: list[DiagonalBlock] = []
    for block in reversed(blocks):
        if needed.isdisjoint(block.unknowns):
            continue
        kept.append(block)
        for number, row in block.rows:
            needed.update(_unknowns(assembly, assembly.elements[number], row))
    return tuple(reversed(kept))


def _unknowns(assembly: Assembly, element: LinkElement, row: int) -> tuple[int, ...]:
    """Unknown coordinates that an equation depends on."""
    terms = (element.ends[index] for index in DEPENDS[row])
    coordinates = {term.coordinate: None for term in terms if term.factor}
    return tuple(c for c in coordinates if assembly.coordinates[c].role is Role.UNKNOWN)


def _match(unknowns_of: Mapping[Equation, tuple[int, ...]]) -> dict[int, Equation]:
    """Equation of each matched unknown, by a maximum matching."""
    row_of: dict[int, Equation] = {}
    unknown_of: dict[Equation, int] = {}
    for start in unknowns_of:
        reached_from: dict[int, Equation] = {}
        queue = deque([start])
        while queue:
            row = queue.popleft()
            for unknown in unknowns_of[row]:
                if unknown in reached_from:
                    continue
                reached_from[unknown] = row
                if unknown in row_of:
                    queue.append(row_of[unknown])
                    continue
                _exchange(row_of, unknown_of, reached_from, unknown)
                queue.clear()
                break
    return row_of


def _exchange(
    row_of: dict[int, Equation],
    unknown_of: dict[Equation, int],
    reached_from: Mapping[int, Equation],
    free: int,
) -> None:
    """Match a free unknown: exchange matched and unmatched pairs along the path that led to it."""
    unknown: int | None = free
    while unknown is not None:
        row = reached_from[unknown]
        previous = unknown_of.get(row)
        row_of[unknown], unknown_of[row] = row, unknown
        unknown = previous


def _components(
    unknowns_of: Mapping[Equation, tuple[int, ...]], row_of: Mapping[int, Equation]
) -> tuple[DiagonalBlock, ...]:
    """Strongly connected components (Tarjan 1972), dependencies first."""
    index: dict[int, int] = {}
    low: dict[int, int] = {}
    stack: dict[int, None] = {}
    blocks: list[DiagonalBlock] = []
    for root in sorted(row_of):
        if root in index:
            continue
        work = [(root, iter(unknowns_of[row_of[root]]))]
        index[root] = low[root] = len(index)
        stack[root] = None
        while work:
            unknown, remaining = work[-1]
            successor = next(remaining, None)
            if successor is None:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[unknown])
                if low[unknown] == index[unknown]:
                    blocks.append(_pop_component(stack, unknown, row_of))
            elif successor not in index:
                index[successor] = low[successor] = len(index)
                stack[successor] = None
                work.append((successor, iter(unknowns_of[row_of[successor]])))
            elif successor in stack:
                low[unknown] = min(low[unknown], index[successor])
    return tuple(blocks)


def _pop_component(
    stack: dict[int, None], root: int, row_of: Mapping[int, Equation]
) -> DiagonalBlock:
    members = [stack.popitem()[0]]
    while members[-1] != root:
        members.append(stack.popitem()[0])
    rows = sorted(row_of[unknown] for unknown in members)
    return DiagonalBlock(tuple(sorted(members)), tuple(rows))
