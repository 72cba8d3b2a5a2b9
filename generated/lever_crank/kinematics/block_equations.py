"""Equations of the blocks: residuals, Jacobians, and the motion that they determine.

Numbers in parentheses are equations of M. Yamada and S. Tatsumi (1981).
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..integrate.tasks import TaskKernel, run_tasks, segment_of
from .lu import LU

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from ..integrate.tasks import Function
    from .tables import Array, LinkageTables, Segment


def segments_of(
    kernels: Sequence[tuple[Function, int, str, str]], tasks: Mapping[str, str]
) -> dict[str, Segment]:
    """Segments of a mechanism, each a function of the workspace.

    Parameters
    ----------
    kernels : sequence of (callable, int, str, str)
        What tasks call, as :meth:`integrate.tasks.TaskKernel.read` takes it.
    tasks : mapping of str to str
        The table of each segment, as :func:`integrate.tasks.segment_of` reads it.
    """
    read = [TaskKernel.read(*kernel) for kernel in kernels]
    return {
        name: partial(run_tasks, segment=segment_of(read, text)) for name, text in tasks.items()
    }


class LinkageCoordinates(NamedTuple):
    """Coordinates of a mechanism, or their first or second derivatives.

    Parameters
    ----------
    alpha : (inputs,) array
        Of the inputs, in their units: the unit of the mechanism or rad.
    x : (unknowns,) array
        Of the unknowns: x and y of nodes in frame O, in the unit of the mechanism, and angles of
        links from +x [rad].
    """

    alpha: Array
    x: Array


class Equations:
    """The workspace of a mechanism, and the equations of its blocks on it.

    Parameters
    ----------
    mechanism : LinkageTables
        The tables and segments.
    """

    def __init__(self, mechanism: LinkageTables) -> None:
        self.mechanism = mechanism
        self.slots = np.zeros(mechanism.work_size)
        self.blocks = tuple(BlockEquations(self, k) for k in range(len(mechanism.blocks)))

    def region(self, name: str) -> Array:
        """Region (size,) of the workspace, to read and to write: a view."""
        base, size = self.mechanism.regions[name]
        return self.slots[base : base + size]

    def place(self, coordinates: LinkageCoordinates, suffix: str = "") -> None:
        """Put a position, or with ``_dot`` or ``_ddot`` its derivatives, where segments look."""
        self.region(f"alpha{suffix}")[:] = coordinates.alpha
        self.region(f"x{suffix}")[:] = coordinates.x

    def run(self, segment: str) -> None:
        """Run a segment."""
        self.mechanism.segments[segment](self.slots)

    def differentiate(
        self, position: LinkageCoordinates, alpha_dot: Array, alpha_ddot: Array
    ) -> tuple[Array, Array]:
        """Derivatives of x along given ones of the inputs, with the factors at hand.

        D ẋ = ν and D ẍ = γ, block after block. All are derivatives by the same variable: by time,
        or by the part of a division.

        Parameters
        ----------
        position : LinkageCoordinates
            Where the mechanism is.
        alpha_dot, alpha_ddot : (inputs,) array
            Of the inputs, in their units per s and per s², or per division.

        Returns
        -------
        x_dot, x_ddot : (unknowns,) array
            First and second derivatives, (22)-(25), in the units of the unknowns, likewise.
        """
        none = np.zeros_like(position.x)
        self.place(position)
        self.place(LinkageCoordinates(alpha_dot, none), "_dot")
        self.place(LinkageCoordinates(alpha_ddot, none), "_ddot")
        x_dot, x_ddot = self.region("x_dot"), self.region("x_ddot")
        for block in self.blocks:
            x_dot[block.part] = block.solve(block.velocity_side())
            x_ddot[block.part] = block.solve(block.acceleration_side())
        return x_dot.copy(), x_ddot.copy()


class BlockEquations:
    """The equations of one block where it is looked at, and the LU factors of its Jacobian.

    Parameters
    ----------
    equations : Equations
        The equations of the mechanism.
    number : int
        The block, counted from 0.
    """

    def __init__(self, equations: Equations, number: int) -> None:
        mechanism = equations.mechanism
        self.part = mechanism.blocks[number].unknowns
        self.scale = np.array([unknown.scale for unknown in mechanism.unknowns[self.part]])
        self.x = equations.region("x")[self.part]
        self._position, self._velocity, self._acceleration = (
            partial(mechanism.segments[f"{order}_{number + 1}"], equations.slots)
            for order in ("position", "velocity", "acceleration")
        )
        n = len(self.scale)
        self._epsilon, self._nu, self._gamma = (
            equations.region(name)[:n] for name in ("epsilon", "nu", "gamma")
        )
        self._jacobian = equations.region("D")[: n * n].reshape(n, n)
        self._factors = LU(np.eye(n), self.scale)

    def residuals(self) -> Array:
        """Residuals ε (n,) [unit of the mechanism]."""
        self._position()
        return self._epsilon.copy()

    def jacobian(self) -> Array:
        """Jacobian D = ∂ε/∂x (n, n) [unit of the mechanism per unit of each unknown]."""
        self._position()
        return self._jacobian.copy()

    def evaluate(self) -> tuple[Array, float]:
        """Residuals ε (n,) [unit of the mechanism] and the smallest pivot [-].

        The LU factors of the Jacobian are kept; pivots are those of unknowns as lengths.
        """
        self._factors = LU(self.jacobian(), self.scale)
        return self._epsilon.copy(), self._factors.pivot

    def solve(self, right: Array) -> Array:
        """Solution D⁻¹ right (n,), in the units of the unknowns, of a right-hand side (n,).

        With the factors that :meth:`evaluate` kept, and right in the unit of the mechanism.
        """
        return self._factors.solve(right)

    def velocity_side(self) -> Array:
        """Right-hand side ν (n,) of the velocities, D ẋ = ν, (22) and (24).

        In the unit of the mechanism per s, or per division.
        """
        self._velocity()
        return self._nu.copy()

    def acceleration_side(self) -> Array:
        """Right-hand side γ (n,) of the accelerations, D ẍ = γ, (23) and (25).

        In the unit of the mechanism per s², or per division twice.
        """
        self._acceleration()
        return self._gamma.copy()
