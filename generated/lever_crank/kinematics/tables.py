"""Records of the tables that describe a mechanism: its coordinates, links and blocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any, TypeAlias

    import numpy as np
    import numpy.typing as npt

    Array: TypeAlias = npt.NDArray[np.float64]
    Segment: TypeAlias = Callable[[Array], None]


class LinkRecord(NamedTuple):
    """A link: its name, its nodes, and its length in the unit of the mechanism."""

    name: str
    first: str
    second: str
    length: float


class InputRecord(NamedTuple):
    """A prescribed coordinate.

    Parameters
    ----------
    name, unit : str
        Its name and its unit.
    scale : float
        The length that a change by 1 moves.
    start : float
        Its value where the unknowns have theirs.
    """

    name: str
    unit: str
    scale: float
    start: float


class Unknown(NamedTuple):
    """An unknown coordinate.

    Parameters
    ----------
    name : str
        Node and direction, such as ``O2.x``.
    start : float
        Its value near the position of the scene.
    scale : float
        The length that a change by 1 moves.
    is_angle : bool
        Whether it counts in radians, and only next to zero.
    """

    name: str
    start: float
    scale: float
    is_angle: bool


class Curve(NamedTuple):
    """A link that bends an equation: all that a block has of second derivatives.

    With d from its first to its second node, places are among the inputs and, after them, all
    unknowns; what does not move is left out.

    Parameters
    ----------
    row : int
        The equation of the block, counted from 0.
    length : float
        In the unit of the mechanism.
    x, y : sequence of (int, float)
        Places and factors of the sums that are the x and the y of d.
    is_arm : bool
        Whether the equation is one of d = length (cos β, sin β), in any direction, or else
        |d| = length.
    angle : sequence of (int, float)
        Place and factor of β, where that moves.
    """

    row: int
    length: float
    x: Sequence[tuple[int, float]]
    y: Sequence[tuple[int, float]]
    is_arm: bool = False
    angle: Sequence[tuple[int, float]] = ()


class Block(NamedTuple):
    """A block of the block-triangular equations: unknowns that are solved together.

    Parameters
    ----------
    unknowns : slice
        Its coordinates among all unknowns.
    links : tuple of str
        The links and sliders whose equations determine them.
    curves : tuple of Curve
        What bends its equations.
    """

    unknowns: slice
    links: tuple[str, ...]
    curves: tuple[Curve, ...]


@dataclass(frozen=True, slots=True)
class LinkageTables:
    """A planar mechanism whose position equations are block-triangular.

    Parameters
    ----------
    unit : str
        Unit of length.
    length : float
        The largest length, in that unit: what corrections and residuals are small beside.
    outputs : tuple of str
        What is wanted beside positions: ``velocities``, ``accelerations``, ``angles``.
    nodes : tuple of str
        The nodes, in the order of the results.
    links : tuple of LinkRecord
        The links, in the order of the results.
    inputs, unknowns : tuple
        The prescribed and the unknown coordinates.
    blocks : tuple of Block
        The blocks, in the order of solving.
    work_size : int
        Count of slots of the workspace.
    regions : mapping of str to (int, int)
        First slot and size of each named part of it.
    segments : mapping of str to callable
        What is computed on it in Python: ``position_k``, ``velocity_k`` and ``acceleration_k``
        belong to block k, counted from 1; ``nodes`` and ``angles`` give the results.
    """

    unit: str
    length: float
    outputs: tuple[str, ...]
    nodes: tuple[str, ...]
    links: tuple[LinkRecord, ...]
    inputs: tuple[InputRecord, ...]
    unknowns: tuple[Unknown, ...]
    blocks: tuple[Block, ...]
    work_size: int
    regions: Mapping[str, tuple[int, int]]
    segments: Mapping[str, Segment]

    @classmethod
    def from_data(cls, data: Mapping[str, Any], segments: Mapping[str, Segment]) -> LinkageTables:
        """Mechanism from ``motion.json``, with the segments of ``solver.py``."""
        blocks, first = [], 0
        for block in data["blocks"]:
            unknowns = slice(first, first + len(block["unknowns"]))
            curves = tuple(Curve(**curve) for curve in block["curves"])
            blocks.append(Block(unknowns, tuple(block["links"]), curves))
            first = unknowns.stop
        return cls(
            unit=data["unit"],
            length=data["length"],
            outputs=tuple(data["outputs"]),
            nodes=tuple(data["nodes"]),
            links=tuple(LinkRecord(*link) for link in data["links"]),
            inputs=tuple(
                InputRecord(name, unit, scale, start)
                for (name, unit, scale), start in zip(
                    data["inputs"], data["run"]["origin"], strict=True
                )
            ),
            unknowns=tuple(Unknown(*unknown) for unknown in data["unknowns"]),
            blocks=tuple(blocks),
            work_size=data["work_size"],
            regions={name: (base, size) for name, (base, size) in data["places"].items()},
            segments=segments,
        )

    @property
    def wants_angles(self) -> bool:
        """Whether the angles of links are wanted."""
        return "angles" in self.outputs
