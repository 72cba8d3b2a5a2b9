"""The two mechanisms of Yamada and Tatsumi (1981), section 4, and their assembly from links."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

Scalar = Any


@dataclass(frozen=True, slots=True)
class Mechanism:
    """Links between nodes, joined by hinges.

    Parameters
    ----------
    nodes : int
        How many.
    links : tuple of (int, int)
        The first and the second node of each link, counted from 1 as in the figures.
    lengths : tuple of int [cm]
        Of each link.
    known : Mapping
        The displacements that are known, by name, and their values as the paper writes them.
    """

    nodes: int
    links: tuple[tuple[int, int], ...]
    lengths: tuple[int, ...]
    known: Mapping[str, str]

    @property
    def names(self) -> list[str]:
        """The displacements of the nodes, then the rotations of the links at their ends."""
        places = [f"{letter}_{node}" for node in range(1, self.nodes + 1) for letter in "uv"]
        count = range(1, len(self.links) + 1)
        return places + [f"ψ_{link}{end}" for link in count for end in (1, 2)]

    @property
    def unknown(self) -> list[int]:
        """Where the unknown displacements stand among the names."""
        return [k for k, name in enumerate(self.names) if name not in self.known]

    @property
    def prescribed(self) -> list[int]:
        """Where the known displacements stand among the names."""
        return [k for k, name in enumerate(self.names) if name in self.known]

    def ends(self, link: int) -> list[int]:
        """Return where u1 v1 ψ1 u2 v2 ψ2 of a link stand among the names."""
        first, second = self.links[link - 1]
        turn = 2 * (self.nodes + link - 1)
        return [2 * first - 2, 2 * first - 1, turn, 2 * second - 2, 2 * second - 1, turn + 1]

    def assembled(self, element: Callable[[int], Sequence[Sequence[Scalar]]]) -> list[list[Scalar]]:
        """Return the rows of all links, (17), from the three rows of each, (16)."""
        rows = []
        for link in range(1, len(self.links) + 1):
            for row in element(link):
                whole: list[Scalar] = [0] * len(self.names)
                for place, cell in zip(self.ends(link), row, strict=True):
                    whole[place] += cell
                rows.append(whole)
        return rows


#: Crank and connecting rod; node 3 slides on the x axis, so that v3 is known.
PISTON_CRANK = Mechanism(
    3,
    ((1, 2), (2, 3)),
    (1, 2),
    MappingProxyType({"u_1": "0", "v_1": "0", "v_3": "0", "ψ_11": "Δα"}),
)
#: A closed loop; the fourth link is the frame, which does not turn at node 1.
LEVER_CRANK = Mechanism(
    4,
    ((1, 2), (2, 3), (3, 4), (4, 1)),
    (30, 60, 80, 100),
    MappingProxyType({"u_1": "0", "v_1": "0", "ψ_11": "Δα", "ψ_42": "0"}),
)
