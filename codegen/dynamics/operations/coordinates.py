"""Coordinates of a system as operations: values, derivatives, and turns that are counted.

A coordinate has the frozen kernels of its kind: the residual of ``constraint`` is its value u, C_q
its Jacobian J, and ü = J v̇ − γ with γ of ``rates``. An angle is known to them up to whole turns;
the counted angle Θ = φ + wrap(θ − φ) follows from an entry φ of q that is less than half a turn
away; see :mod:`kousoku.codegen.dynamics.composition.auxiliary`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.mechanics import COLUMNS, frozen, inputs_of_body
from kousoku.codegen.dynamics.recording.matrix import Matrix

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.traces import Trace

#: Index of φ among the blocks.
TURNED = 6


@dataclass(frozen=True, slots=True)
class CoordinateValue:
    """Value u of a coordinate. Blocks: r, p and A of body i, those of body j, φ, the constants.

    r (3,) [m] and A (3, 3) [-] are of frame O, p (4,), φ (1,) [rad], points and axes of the
    principal frames. A may be without entries: then it is computed from p. u is C of its kind:
    lecture 8.2, (8.9) of n1 and the angle, (8.12) of n2, |d| of (8.8). An angle is counted, Θ = φ +
    wrap(θ − φ).

    Parameters
    ----------
    kind : str
        The package.
    constants : tuple of str
        Names of the inputs that are fixed.
    counts_turns : bool
        Whether the value is counted from φ; else φ has no entry.
    """

    kind: str
    constants: tuple[str, ...]
    counts_turns: bool

    @property
    def title(self) -> str:
        """Name the kind."""
        return f"value of {self.kind}"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Value u (1,) [m or rad]."""
        outputs = _inline(trace, "constraint", self, blocks)
        (value,) = outputs["C"]
        if self.counts_turns:
            (phi,), graph = blocks[TURNED].flat, trace.graph
            difference = graph.sub(value, phi)
            value = graph.add(phi, graph.atan2(graph.sin(difference), graph.cos(difference)))
        return (Matrix.of(trace.graph, [value]),)


@dataclass(frozen=True, slots=True)
class CoordinateJacobian:
    """Jacobian J of a coordinate, u̇ = J v. Blocks: as of :class:`CoordinateValue`, φ left empty.

    Parameters
    ----------
    kind, constants
        As of :class:`CoordinateValue`.
    columns_i, columns_j : tuple of int
        Columns of each body, δr in frame O and δθ′ in the principal frame, that are coordinates:
        none of the ground.
    """

    kind: str
    constants: tuple[str, ...]
    columns_i: tuple[int, ...]
    columns_j: tuple[int, ...]

    @property
    def title(self) -> str:
        """Name the kind."""
        return f"Jacobian of {self.kind}"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """J of i and of j, each one row (1, c) [unit of u per m or rad]."""
        outputs = _inline(trace, "constraint", self, blocks)
        row = Matrix.of(trace.graph, outputs["C_q"], 2 * COLUMNS)
        right = [COLUMNS + k for k in self.columns_j]
        return row.columns(self.columns_i), row.columns(right)


@dataclass(frozen=True, slots=True)
class CoordinateGamma:
    """γ of a coordinate. Blocks: as of :class:`CoordinateJacobian`, then v and ω′ of i and of j.

    v (3,) [m/s] is in frame O, ω′ (3,) [rad/s] in the principal frame.

    Parameters
    ----------
    kind, constants
        As of :class:`CoordinateValue`.
    """

    kind: str
    constants: tuple[str, ...]

    @property
    def title(self) -> str:
        """Name the kind."""
        return f"gamma of {self.kind}"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Right-hand side γ (1,) [m/s² or rad/s²] of ü = J v̇ − γ."""
        names = ("v_i", "omega_i_b", "v_j", "omega_j_b")
        motion = dict(zip(names, blocks[-len(names) :], strict=True))
        outputs = _inline(trace, "rates", self, blocks[: -len(names)], motion)
        return (Matrix.of(trace.graph, [outputs["gamma"][0]]),)


@dataclass(frozen=True, slots=True)
class CoordinateRate:
    """Rate of a coordinate. Blocks: J and x of each body in turn, the subtrahend last.

    J (1, c) and x (c,) have the columns δr in frame O, δθ′ in the principal frame: x is v [m/s,
    rad/s], or v̇ and the last block γ.
    """

    title: str = "rate"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Rate Σ J x minus the last block, (1,): u̇ = J v or ü = J v̇ − γ."""
        *pairs, subtrahend = blocks
        total = -subtrahend
        for row, x in zip(pairs[::2], pairs[1::2], strict=True):
            total = row @ x + total
        return (total,)


def _inline(
    trace: Trace,
    kernel: str,
    operation: CoordinateValue | CoordinateJacobian | CoordinateGamma,
    blocks: Sequence[Matrix],
    motion: dict[str, Matrix] | None = None,
) -> dict[str, list[int]]:
    """Rebuild a kernel of a coordinate; return its outputs."""
    i, j, constants = blocks[:3], blocks[3:TURNED], blocks[TURNED + 1 :]
    named = inputs_of_body(trace, "i", *i) | inputs_of_body(trace, "j", *j) | (motion or {})
    named |= dict(zip(operation.constants, constants, strict=True))
    inputs = {name: block.flat for name, block in named.items()}
    return trace.inline(frozen(operation.kind, kernel), inputs)
