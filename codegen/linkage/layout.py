"""Layout of the coordinates of a linkage in the workspace of its program.

Inputs are ``alpha`` and unknowns, block after block, ``x``: the parts of (18) and (19). Their first
and second derivatives follow, then residuals, matrix and right-hand sides of a block, and results.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.program import Region
from kousoku.codegen.linkage.assemble import Role
from kousoku.model.files.quantity import Quantity
from kousoku.runtime.kinematics.rows import OF_LINKS, OF_NODES

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.codegen.linkage.assemble import Affine, Assembly
    from kousoku.codegen.linkage.blocks import DiagonalBlock
    from kousoku.model.operations.graph import Graph

SUFFIXES = ("", "_dot", "_ddot")
#: Regions of the results of a block beside its matrix.
OF_BLOCKS = ("epsilon", "nu", "gamma")
#: Contents of the regions; regions of blocks hold those of the block that ran last.
REGIONS = {
    "alpha": "inputs, in the order of the scene",
    "x": "unknowns, block after block",
    "alpha_dot": "first derivatives of the inputs",
    "x_dot": "those of the unknowns",
    "alpha_ddot": "second derivatives of the inputs",
    "x_ddot": "those of the unknowns",
    "epsilon": "residuals of a block",
    "D": "their derivatives by the unknowns of the block, row after row",
    "nu": "right-hand side of the velocities of a block",
    "gamma": "right-hand side of the accelerations of a block",
    "position": "x and y of each node in frame O",
    "velocity": "their first time derivatives",
    "acceleration": "their second time derivatives",
    "angle": "angle of each link from +x, from its first node to its second, rad",
    "angle_dot": "its first time derivative",
    "angle_ddot": "its second time derivative",
}


@dataclass(frozen=True, slots=True)
class WorkspaceLayout:
    """Layout of blocks, unknowns and regions.

    Parameters
    ----------
    assembly : Assembly
        Linkage that is solved.
    blocks : tuple of DiagonalBlock
        In the order of solving.
    unknowns : tuple of int
        The unknown coordinates, block after block.
    locations : mapping of int to (str, int)
        Array, ``alpha`` or ``x``, and index of each coordinate.
    regions : mapping of str to Region
        The parts of the workspace, in order: those of :data:`REGIONS` that the scene needs.
    """

    assembly: Assembly
    blocks: tuple[DiagonalBlock, ...]
    unknowns: tuple[int, ...] = field(init=False)
    locations: Mapping[int, tuple[str, int]] = field(init=False)
    regions: Mapping[str, Region] = field(init=False)

    def __post_init__(self) -> None:
        unknowns = tuple(unknown for block in self.blocks for unknown in block.unknowns)
        regions = (("alpha", self.assembly.inputs), ("x", unknowns))
        locations = {c: (name, k) for name, members in regions for k, c in enumerate(members)}
        object.__setattr__(self, "unknowns", unknowns)
        object.__setattr__(self, "locations", locations)
        object.__setattr__(self, "regions", self._regions())

    def _regions(self) -> dict[str, Region]:
        largest = max(len(block.unknowns) for block in self.blocks)
        sizes = dict.fromkeys(REGIONS, 0) | dict.fromkeys(OF_BLOCKS, largest) | {"D": largest**2}
        for suffix in SUFFIXES:
            sizes |= {f"alpha{suffix}": len(self.assembly.inputs), f"x{suffix}": len(self.unknowns)}
        sizes |= dict.fromkeys(OF_NODES, 2 * len(self.assembly.nodes))
        if self.wants_angles:
            sizes |= dict.fromkeys(OF_LINKS, len(self.assembly.scene.links))
        regions, base = {}, 0
        for name, size in sizes.items():
            if size:
                regions[name] = Region(name, base, size)
                base += size
        return regions

    @property
    def wants_angles(self) -> bool:
        """Whether the angles of links are wanted."""
        return "angles" in self.assembly.scene.outputs

    @property
    def left_out(self) -> tuple[int, ...]:
        """Unknown coordinates of no block, as no output needs them."""
        numbered = enumerate(self.assembly.coordinates)
        unknown = (number for number, coordinate in numbered if coordinate.role is Role.UNKNOWN)
        return tuple(number for number in unknown if number not in self.locations)

    @property
    def size(self) -> int:
        """Count of slots."""
        return sum(region.size for region in self.regions.values())

    @property
    def workspace(self) -> Quantity:
        """Workspace, which every kernel takes."""
        return Quantity("x0", (self.size,), "", "the workspace")

    def is_moving(self, term: Affine) -> bool:
        """Whether a term depends on a coordinate that is not fixed."""
        role = self.assembly.coordinates[term.coordinate].role
        return bool(term.factor) and role is not Role.FIXED

    def place_of(self, coordinate: int) -> int:
        """Index of a coordinate among the inputs and, after them, the unknowns."""
        name, index = self.locations[coordinate]
        return index if name == "alpha" else len(self.assembly.inputs) + index

    def node(self, graph: Graph, term: Affine, order: int) -> int:
        """Graph node of offset + factor · coordinate, or of a time derivative of it."""
        coordinate = self.assembly.coordinates[term.coordinate]
        if not self.is_moving(term):
            fixed = term.factor * coordinate.start if coordinate.role is Role.FIXED else 0
            return graph.const(term.offset + fixed if order == 0 else 0)
        name, index = self.locations[term.coordinate]
        moving = graph.input("x0", self.regions[name + SUFFIXES[order]].base + index)
        scaled = graph.mul(graph.const(term.factor), moving)
        return graph.add(scaled, graph.const(term.offset)) if order == 0 else scaled
