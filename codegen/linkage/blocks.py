"""Part the equations of a linkage into blocks that are solved one after the other.

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
from kousoku.model.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.linkage.assemble import Assembly, LinkElement

#: The places of x1 y1 β1 x2 y2 β2 that each of ε1, ε2, ε3 depends on, (5)–(7).
DEPENDS = ((0, 1, 3, 4), (0, 1, 2, 3, 4), (0, 1, 3, 4, 5))

Equation = tuple[int, int]


@dataclass(frozen=True, slots=True)
class DiagonalBlock:
    """Unknowns that are found together.

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
    """Blocks of an assembly, each after those that it depends on.

    Raises
    ------
    SceneError
        Equations and unknowns cannot be matched: some nodes are free to move, or some links hold
        what is held already.
    """
    unknowns_of = {
        (number, row): _unknowns(assembly, element, row)
        for number, element in enumerate(assembly.elements)
        for row in element.rows
    }
    row_of = _match(unknowns_of)
    free = [
        number
        for number, coordinate in enumerate(assembly.coordinates)
        if coordinate.role is Role.UNKNOWN and number not in row_of
    ]
    matched = set(row_of.values())
    extra = [row for row in unknowns_of if row not in matched]
    if free or extra:
        raise SceneError(_not_determined(assembly, unknowns_of, row_of, free, extra), key="links")
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
    terms = (element.ends[place] for place in DEPENDS[row])
    found = {term.coordinate: None for term in terms if term.factor}
    return tuple(c for c in found if assembly.coordinates[c].role is Role.UNKNOWN)


def _match(unknowns_of: Mapping[Equation, tuple[int, ...]]) -> dict[int, Equation]:
    """Equation of each matched unknown; as many are matched as can be."""
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
            unknown, rest = work[-1]
            following = next(rest, None)
            if following is None:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[unknown])
                if low[unknown] == index[unknown]:
                    blocks.append(_pop_component(stack, unknown, row_of))
            elif following not in index:
                index[following] = low[following] = len(index)
                stack[following] = None
                work.append((following, iter(unknowns_of[row_of[following]])))
            elif following in stack:
                low[unknown] = min(low[unknown], index[following])
    return tuple(blocks)


def _pop_component(
    stack: dict[int, None], root: int, row_of: Mapping[int, Equation]
) -> DiagonalBlock:
    members = [stack.popitem()[0]]
    while members[-1] != root:
        members.append(stack.popitem()[0])
    rows = sorted(row_of[unknown] for unknown in members)
    return DiagonalBlock(tuple(sorted(members)), tuple(rows))


def _not_determined(
    assembly: Assembly,
    unknowns_of: Mapping[Equation, tuple[int, ...]],
    row_of: Mapping[int, Equation],
    free: Sequence[int],
    extra: Sequence[Equation],
) -> str:
    """Say which nodes can still move and which links hold what is held already."""
    parts = []
    if free:
        reached = _underdetermined(unknowns_of, row_of, free)
        loose = [assembly.coordinates[number] for number in reached]
        moving = [c.name for c in loose if c.unit != "rad"] or [c.name for c in loose]
        nodes = ", ".join(dict.fromkeys(name.partition(".")[0] for name in moving))
        parts.append(
            f"{nodes} can still move; add {len(free)} more input{'s' * (len(free) > 1)},"
            " or links, that hold what is free"
        )
    if extra:
        held = _overdetermined(unknowns_of, row_of, extra)
        names = ", ".join(assembly.elements[number].name for number in held)
        parts.append(
            f"links {names} and the inputs hold their nodes more than once; remove"
            f" {len(extra)} of these links or inputs"
        )
    return "the linkage is not determined: " + "; and ".join(parts)


def _underdetermined(
    unknowns_of: Mapping[Equation, tuple[int, ...]],
    row_of: Mapping[int, Equation],
    free: Sequence[int],
) -> list[int]:
    """Unknowns of the under-determined part, reached from those left over."""
    unknown_of = {row: unknown for unknown, row in row_of.items()}
    seen = dict.fromkeys(free)
    queue = list(free)
    while queue:
        unknown = queue.pop(0)
        for row, unknowns in unknowns_of.items():
            if unknown in unknowns and unknown_of.get(row, unknown) not in seen:
                seen[unknown_of[row]] = None
                queue.append(unknown_of[row])
    return sorted(seen)


def _overdetermined(
    unknowns_of: Mapping[Equation, tuple[int, ...]],
    row_of: Mapping[int, Equation],
    extra: Sequence[Equation],
) -> list[int]:
    """Elements of the over-determined part, reached from the equations left over."""
    seen = dict.fromkeys(extra)
    queue = list(extra)
    while queue:
        for unknown in unknowns_of[queue.pop(0)]:
            row = row_of[unknown]
            if row not in seen:
                seen[row] = None
                queue.append(row)
    return sorted({number for number, _ in seen})
