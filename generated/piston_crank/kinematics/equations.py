"""The equations of the blocks: residuals, Jacobians, and the motion that they determine."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from .lu import LU

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import TypeAlias

    from .mechanism import Array, Mechanism

    #: A kernel: arrays in, arrays out; ``outputs`` names what is wanted.
    Kernel: TypeAlias = Callable[..., tuple[Array, ...]]


class Kernels(Protocol):
    """The kernels of a mechanism: a module ``kernels.py``, or a loaded library.

    ``position_k``, ``velocity_k`` and ``acceleration_k`` belong to block k, counted from 1;
    ``nodes`` and ``angles`` give the results.
    """

    def __getattr__(self, name: str) -> Kernel: ...


class Coordinates(NamedTuple):
    """All coordinates of a mechanism, inputs and unknowns, or their first or second derivatives."""

    alpha: Array
    x: Array


class BlockEquations:
    """The equations of one block, counted from 0, and the LU factors of its Jacobian."""

    def __init__(self, mechanism: Mechanism, kernels: Kernels, number: int) -> None:
        block = mechanism.blocks[number]
        self.part = block.unknowns
        self.scale = np.array([unknown.scale for unknown in mechanism.unknowns[self.part]])
        self._known = list(block.known)
        self._position: Kernel = getattr(kernels, f"position_{number + 1}")
        self._velocity: Kernel = getattr(kernels, f"velocity_{number + 1}")
        self._acceleration: Kernel = getattr(kernels, f"acceleration_{number + 1}")
        self._factors = LU(np.eye(len(self.scale)), self.scale)

    def known(self, all_: Coordinates) -> tuple[Array, ...]:
        """Return what the block depends on: one array, or none."""
        return (np.concatenate(all_)[self._known],) if self._known else ()

    def residuals(self, position: Coordinates) -> Array:
        """Return the residuals, (n,), as lengths."""
        own = position.x[self.part]
        (epsilon,) = self._position(*self.known(position), own, outputs=("epsilon",))
        return epsilon

    def evaluate(self, position: Coordinates) -> tuple[Array, float]:
        """Return the residuals, (n,), and the smallest pivot; keep the factors of the Jacobian."""
        epsilon, jacobian = self._position(*self.known(position), position.x[self.part])
        self._factors = LU(jacobian, self.scale)
        return epsilon, self._factors.pivot

    def solve(self, right: Array) -> Array:
        """Return the solution with the factors that :meth:`evaluate` kept, (n,)."""
        return self._factors.solve(right)

    def velocity_side(self, position: Coordinates, velocity: Coordinates) -> Array:
        """Return the right-hand side of the velocities, (22) and (24), (n,)."""
        here = (*self.known(position), position.x[self.part])
        (nu,) = self._velocity(*here, *self.known(velocity))
        return nu

    def acceleration_side(
        self, position: Coordinates, velocity: Coordinates, acceleration: Coordinates
    ) -> Array:
        """Return the right-hand side of the accelerations, (23) and (25), (n,)."""
        here = (*self.known(position), position.x[self.part])
        moving = (*self.known(velocity), velocity.x[self.part])
        (gamma,) = self._acceleration(*here, *moving, *self.known(acceleration))
        return gamma


def differentiate(
    blocks: tuple[BlockEquations, ...], position: Coordinates, alpha_dot: Array, alpha_ddot: Array
) -> tuple[Array, Array]:
    """Return the derivatives of x along given ones of the inputs, with the factors at hand.

    Returns
    -------
    x_dot, x_ddot : (unknowns,) array
        First and second derivatives, (22)-(25).
    """
    velocity = Coordinates(alpha_dot, np.zeros_like(position.x))
    acceleration = Coordinates(alpha_ddot, np.zeros_like(position.x))
    for block in blocks:
        side = block.velocity_side(position, velocity)
        velocity.x[block.part] = block.solve(side)
        side = block.acceleration_side(position, velocity, acceleration)
        acceleration.x[block.part] = block.solve(side)
    return velocity.x, acceleration.x
