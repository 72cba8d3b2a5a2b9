"""Kernels of a linkage, composed from the frozen link element: no link is derived twice.

The kernels of a block take the workspace and read the block's unknowns there, and the coordinates
that earlier blocks solved; see :mod:`kousoku.codegen.linkage.layout`.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from kousoku.codegen.kernel_json import load_frozen
from kousoku.codegen.linkage.blocks import DEPENDS
from kousoku.codegen.passes.rebuild import drop_dead, substitute
from kousoku.model.files.quantity import Quantity
from kousoku.model.operations.graph import Graph
from kousoku.model.operations.kernel import Kernel

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.linkage.assemble import Affine, LinkElement
    from kousoku.codegen.linkage.layout import WorkspaceLayout

PAPER = "Yamada and Tatsumi 1981"


@cache
def link_kernels() -> Mapping[str, Kernel]:
    """Kernels of the frozen link element: ``deformation`` ε and D, (5) to (7), (15); ``rate``."""
    return {kernel.name: kernel for kernel in load_frozen("link").kernels}


def block_kernels(layout: WorkspaceLayout, number: int) -> tuple[Kernel, Kernel, Kernel]:
    """Kernels of one block: its residual and matrix, and its right-hand sides.

    Equations are those of Yamada and Tatsumi (1981), nodes in frame O, lengths in the unit of the
    scene.

    Parameters
    ----------
    layout : WorkspaceLayout
        The linkage.
    number : int
        The block, counted from 0; the names of its kernels count from 1.

    Returns
    -------
    position : Kernel
        ``epsilon`` (n,) and ``D`` (n, n), its derivatives by the block's own unknowns, (20).
    velocity : Kernel
        ``nu`` (n,) with D ẋ = nu: the contribution of the coordinates known by then, (22).
    acceleration : Kernel
        ``gamma`` (n,) with D ẍ = gamma: likewise, and −Ḋ ẋ of all coordinates, (23), (25).
    """
    return (
        _Composer(layout, number).position(),
        _Composer(layout, number).velocity(),
        _Composer(layout, number).acceleration(),
    )


def _slopes(element: LinkElement, row: int, derivatives: Sequence[int]) -> list[tuple[Affine, int]]:
    """End coordinates that one row depends on, each with the derivative by it."""
    return [(element.ends[index], derivatives[6 * row + index]) for index in DEPENDS[row]]


class _Composer:
    """Composer of one kernel of one block."""

    def __init__(self, layout: WorkspaceLayout, number: int) -> None:
        self.layout = layout
        self.number = number
        self.block = layout.blocks[number]
        self.suffix = f"_{number + 1}"
        self.graph = Graph()
        links = dict.fromkeys(layout.assembly.elements[e].name for e, _ in self.block.rows)
        names = ", ".join(layout.assembly.coordinates[u].name for u in self.block.unknowns)
        self.title = f"{names} from {', '.join(links)}"

    def position(self) -> Kernel:
        n = len(self.block.rows)
        epsilon, matrix = [], []
        for number, row in self.block.rows:
            element = self.layout.assembly.elements[number]
            link = self._inline("deformation", element, row)
            epsilon.append(link["epsilon"][row])
            gradient = self._gradient(_slopes(element, row, link["D"]))
            matrix += [gradient.get(u, self.graph.const(0)) for u in self.block.unknowns]
        unit = self.layout.assembly.scene.unit
        return self._kernel(
            "position",
            f"Residual of the equations for {self.title}",
            "epsilon = 0, D = d epsilon / d x",
            "(5)-(7), (15)",
            {
                Quantity("epsilon", (n,), unit, "residuals"): epsilon,
                Quantity("D", (n, n), f"1 or {unit}", "derivatives by the block's x"): matrix,
            },
        )

    def velocity(self) -> Kernel:
        rows = [self._known_term(number, row, 1) for number, row in self.block.rows]
        return self._kernel(
            "velocity",
            f"Right-hand side of the velocities of {self.title}",
            "D x_dot = nu",
            "(22), (24)",
            {self._right_hand_side("nu", "/s"): rows},
        )

    def acceleration(self) -> Kernel:
        rows = []
        for number, row in self.block.rows:
            element = self.layout.assembly.elements[number]
            link = self._inline("rate", element, row)
            carried = self._known_term(number, row, 2)
            rows.append(self.graph.sub(carried, link["D_dot_x_dot"][row]))
        return self._kernel(
            "acceleration",
            f"Right-hand side of the accelerations of {self.title}",
            "D x_ddot = gamma",
            "(23), (25)",
            {self._right_hand_side("gamma", "/s^2"): rows},
        )

    def _right_hand_side(self, name: str, per: str) -> Quantity:
        unit = self.layout.assembly.scene.unit + per
        return Quantity(name, (len(self.block.rows),), unit, "right-hand side")

    def _known_term(self, number: int, row: int, order: int) -> int:
        """Product of −D and the derivatives of the coordinates that are known by now."""
        element = self.layout.assembly.elements[number]
        link = self._inline("deformation", element, row)
        total = self.graph.const(0)
        for term, derivative in _slopes(element, row, link["D"]):
            if term.coordinate not in self.block.unknowns:
                motion = self.layout.node(self.graph, term, order)
                total = self.graph.sub(total, self.graph.mul(derivative, motion))
        return total

    def _gradient(self, terms: Sequence[tuple[Affine, int]]) -> dict[int, int]:
        """Derivatives by coordinates, from those by the ends of the link."""
        gradient: dict[int, int] = {}
        for term, derivative in terms:
            product = self.graph.mul(self.graph.const(term.factor), derivative)
            total = gradient.get(term.coordinate, self.graph.const(0))
            gradient[term.coordinate] = self.graph.add(total, product)
        return gradient

    def _inline(self, kernel: str, element: LinkElement, row: int) -> dict[str, list[int]]:
        """Outputs of a kernel of the link element in this graph, for the ends and length of a link.

        Ends that a row does not depend on are zero: the other rows leave nothing in the graph.
        """
        used = DEPENDS[row]
        zero = self.graph.const(0)
        inputs = {"length": [self.graph.const(element.length)], "offset": [zero, zero]}
        for name, order in (("x", 0), ("x_dot", 1)):
            inputs[name] = [
                self.layout.node(self.graph, term, order) if index in used else zero
                for index, term in enumerate(element.ends)
            ]
        return substitute(self.graph, link_kernels()[kernel], inputs)

    def _kernel(
        self,
        name: str,
        title: str,
        formula: str,
        source: str,
        outputs: Mapping[Quantity, Sequence[int]],
    ) -> Kernel:
        """Kernel of a graph that was composed."""
        return drop_dead(
            Kernel(
                name=name + self.suffix,
                title=title,
                formula=formula,
                source=f"{PAPER}, {source}",
                inputs=(self.layout.workspace,),
                outputs=tuple(outputs),
                nodes=tuple(self.graph.nodes),
                results=tuple(tuple(nodes) for nodes in outputs.values()),
            )
        )
