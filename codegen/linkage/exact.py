"""Reference values of the kernels of a linkage, element by element, without their graphs.

Each link element is evaluated on its own and its numbers are put together by the formulas of the
paper, so that a mistake in composing, binding or printing shows.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from kousoku.codegen.linkage.assemble import Role
from kousoku.codegen.linkage.blocks import DEPENDS
from kousoku.codegen.linkage.kernels import link_kernels
from kousoku.codegen.linkage.layout import SUFFIXES
from kousoku.model.operations.interpret import evaluate
from kousoku.runtime.kinematics.rows import OF_LINKS, OF_NODES

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.codegen.linkage.assemble import Affine, LinkElement
    from kousoku.codegen.linkage.layout import WorkspaceLayout
    from kousoku.model.operations.arithmetic import Arithmetic

    #: For ``alpha``, ``x``, ``alpha_dot`` … their elements.
    Motion = Mapping[str, Sequence[Any]]

_ZERO = Fraction(0)


class Exact:
    """Blocks and outputs of a linkage at one motion: D ẋ = ν, D ẍ = γ.

    Equations are those of Yamada and Tatsumi (1981). Lengths are in the unit of the scene, angles
    in rad, nodes in frame O.

    Parameters
    ----------
    layout : WorkspaceLayout
        The linkage.
    arithmetic : Arithmetic
        The numbers that ``motion`` holds.
    motion : mapping of str to sequence
        The inputs of the kernels whose outputs are needed.
    constant : callable
        Number of a constant of the scene, from its name and its value.
    """

    def __init__(
        self,
        layout: WorkspaceLayout,
        arithmetic: Arithmetic[Any],
        motion: Motion,
        constant: Callable[[object, Fraction], Any],
    ) -> None:
        self.layout = layout
        self.arithmetic = arithmetic
        self.motion = motion
        self.constant = constant

    def block(self, number: int, order: int) -> dict[str, list[Any]]:
        """Outputs of a block by the order: ε (n,), (5)–(7), and D (n, n); ν (n,), (22); γ, (23)."""
        block = self.layout.blocks[number]
        rows = [(self.layout.assembly.elements[element], row) for element, row in block.rows]
        if order == 0:
            values = [self._deformation(element, row) for element, row in rows]
            zero = self.arithmetic.number(_ZERO)
            return {
                "epsilon": [epsilon for epsilon, _ in values],
                "D": [slope.get(u, zero) for _, slope in values for u in block.unknowns],
            }
        if order == 1:
            return {"nu": [-self._known_term(element, row, number, 1) for element, row in rows]}
        curvatures = [self._curvature(element, row) for element, row in rows]
        known_terms = [self._known_term(element, row, number, 2) for element, row in rows]
        return {"gamma": [-(c + b) for c, b in zip(known_terms, curvatures, strict=True)]}

    def nodes(self) -> dict[str, list[Any]]:
        """Outputs of the kernel ``nodes``, (2 nodes,): positions, and (24), (25)."""
        terms = [term for _, x, y in self.layout.assembly.nodes for term in (x, y)]
        return {name: [self.term(term, k) for term in terms] for k, name in enumerate(OF_NODES)}

    def angles(self) -> dict[str, list[Any]]:
        """Outputs of the kernel ``angles``, (links,): β of (12) and (13), β̇ and β̈."""
        columns = [self._angle(link) for link in self.layout.assembly.scene.links]
        return {name: [column[k] for column in columns] for k, name in enumerate(OF_LINKS)}

    def term(self, term: Affine, order: int) -> Any:
        """Term offset + factor · coordinate, a number, or a time derivative of it."""
        coordinate = self.layout.assembly.coordinates[term.coordinate]
        if not self.layout.is_moving(term):
            fixed = term.factor * coordinate.start if coordinate.role is Role.FIXED else _ZERO
            return self.constant(("fixed", term), term.offset + fixed if order == 0 else _ZERO)
        name, index = self.layout.locations[term.coordinate]
        moving = self.motion[name + SUFFIXES[order]][index]
        if term.factor != 1:
            moving = moving * self.constant(("factor", term), term.factor)
        if order or not term.offset:
            return moving
        return moving + self.constant(("offset", term), term.offset)

    def _element(self, element: LinkElement, row: int, order: int) -> dict[str, tuple[Any, ...]]:
        """Outputs of the link element alone, with the ends that one of its rows needs."""
        zero = self.arithmetic.number(_ZERO)
        inputs = {"length": [self.constant(("length", element.name), element.length)]}
        for name, k in (("x", 0), ("x_dot", 1))[: order + 1]:
            inputs[name] = [
                self.term(term, k) if index in DEPENDS[row] else zero
                for index, term in enumerate(element.ends)
            ]
        if order == 0:
            inputs["offset"] = [zero, zero]
        kernel = link_kernels()["rate" if order else "deformation"]
        return evaluate(kernel, inputs, self.arithmetic)

    def _deformation(self, element: LinkElement, row: int) -> tuple[Any, dict[int, Any]]:
        """Deformation ε of a row and its derivatives by coordinates."""
        values = self._element(element, row, 0)
        slope: dict[int, Any] = {}
        for index in DEPENDS[row]:
            term = element.ends[index]
            derivative = values["D"][6 * row + index]
            if term.factor != 1:
                derivative = derivative * self.constant(("factor", term), term.factor)
            total = slope.get(term.coordinate)
            slope[term.coordinate] = derivative if total is None else total + derivative
        return values["epsilon"][row], slope

    def _known_term(self, element: LinkElement, row: int, number: int, order: int) -> Any:
        """Product of D and the derivatives of the coordinates that earlier blocks solved."""
        unknowns = self.layout.blocks[number].unknowns
        values = self._element(element, row, 0)
        total = self.arithmetic.number(_ZERO)
        for index in DEPENDS[row]:
            term = element.ends[index]
            if term.coordinate not in unknowns:
                total = total + values["D"][6 * row + index] * self.term(term, order)
        return total

    def _curvature(self, element: LinkElement, row: int) -> Any:
        return self._element(element, row, 1)["D_dot_x_dot"][row]

    def _angle(self, link: str) -> tuple[Any, Any, Any]:
        """Angle β, β̇ = t · ḋ / l and β̈ = (t · d̈ − 2 l̇ β̇) / l."""
        terms = {name: (x, y) for name, x, y in self.layout.assembly.nodes}
        first, second = (terms[node] for node in self.layout.assembly.scene.links[link].nodes)
        (dx, dy), (vx, vy), (ax, ay) = (
            [self.term(b, k) - self.term(a, k) for a, b in zip(first, second, strict=True)]
            for k in range(3)
        )
        length = self.arithmetic.sqrt(dx * dx + dy * dy)
        c, s = dx / length, dy / length
        rate, stretch = (c * vy - s * vx) / length, c * vx + s * vy
        acceleration = (c * ay - s * ax - (rate + rate) * stretch) / length
        return self.arithmetic.atan2(dy, dx), rate, acceleration
