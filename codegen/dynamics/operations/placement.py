"""Placement of a body in the frame of its carrier: its points and vectors as seen there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.model.numbers import precise
from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.precise import IDENTITY, ZERO, High, Quadruple, Triple

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.records.orientation import Quaternion, Vector

    Constants = tuple[tuple[str, tuple[float, ...]], ...]

#: Components below this part of their operands are zeros but for rounding of positions.
ROUNDING = CONTEXT.mpf(2) ** -51


@dataclass(frozen=True, slots=True)
class Placement:
    """Placement of the principal frame of a body in that of its carrier: s = at + A(turn) s′.

    A is that of lecture 7.1, (4.3), divided by the square of the norm of turn.

    Parameters
    ----------
    carrier : int
        The body that carries it, or the ground.
    at : (3,) [m]
        Its centre of mass.
    turn : (4,) [-]
        Euler parameters, of any length, that take its components to those of the carrier.
    """

    carrier: int
    at: Triple = ZERO
    turn: Quadruple = IDENTITY

    def point(self, s: Sequence[float]) -> Vector:
        """Point at + A s′ (3,) [m] in the frame of the carrier, of s′ in that of the body."""
        s_body = precise.triple(s)
        size = precise.length(self.at) + precise.length(s_body)
        return rounded_vector(precise.add(self.at, precise.rotate(self.turn, s_body)), size)

    def vector(self, a: Sequence[float]) -> Vector:
        """Vector A a′ (3,) in the frame of the carrier, of a′ in that of the body, in its unit."""
        return rounded_vector(precise.rotate(self.turn, precise.triple(a)))

    def frame(self, axes: Sequence[float]) -> Quaternion:
        """Euler parameters turn ∘ p (4,) [-], from a frame of the body to that of the carrier."""
        return rounded_turn(precise.compose(self.turn, precise.quadruple(axes)))


def seen_from_carriers(
    constants: Constants, i: Placement, j: Placement, *, turning: bool = False
) -> Constants:
    """Points at + A s′ and vectors A a′ in the frames of the carriers of their bodies.

    Parameters
    ----------
    constants : tuple of (str, tuple of float)
        ``s_i_b`` and ``s_j_b`` are points (3,) [m], others that end in ``_i_b`` and ``_j_b``
        vectors.
    i, j : Placement
        Of bodies i and j.
    turning : bool
        Whether all but points are vectors of body j.
    """

    def seen(name: str, values: tuple[float, ...]) -> tuple[float, ...]:
        if name in {"s_i_b", "s_j_b"}:
            return (i if name == "s_i_b" else j).point(values)
        if name.endswith("_i_b"):
            return i.vector(values)
        return j.vector(values) if turning or name.endswith("_j_b") else values

    return tuple((name, seen(name, values)) for name, values in constants)


def rounded_vector(values: Triple, size: High = 0) -> Vector:
    """Vector (3,), rounded once in its frame and unit; noise below its size is zero."""
    x, y, z = precise.rounded(values, size, ROUNDING)
    return x, y, z


def rounded_turn(p: Quadruple) -> Quaternion:
    """Euler parameters p/|p| (4,) [-] of norm one, rounded once; of any two frames."""
    size = precise.length(p)
    w, x, y, z = precise.rounded([component / size for component in p], 1, ROUNDING)
    return w, x, y, z
