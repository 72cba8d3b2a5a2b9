"""Positions of all bodies of a system in 50 digits, and displacements between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.model.numbers import precise
from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.precise import IDENTITY, ZERO, High, Quadruple, Triple

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.model.mechanics.multibody import MovingBody, RelativeCoordinate


_ONE, _NONE = precise.number(1.0), precise.number(0.0)
_UNIT = (_ONE, _NONE, _NONE), (_NONE, _ONE, _NONE), (_NONE, _NONE, _ONE)


@dataclass(frozen=True, slots=True)
class Pose:
    """Positions of all bodies, points are at r + A(p) s′; the ground is last, index −1.

    Parameters
    ----------
    r : tuple of (3,) [m]
        Centres of mass, frame O.
    p : tuple of (4,)
        Euler parameters of the principal frames, of norm one.
    near : tuple of number
        Coordinates that angles are counted from, to within half a turn.
    """

    r: tuple[Triple, ...]
    p: tuple[Quadruple, ...]
    near: tuple[High, ...] = ()

    @classmethod
    def of(
        cls, bodies: Sequence[MovingBody], coordinates: Sequence[RelativeCoordinate] = ()
    ) -> Pose:
        """Positions at the start."""
        r = [precise.triple(body.r) for body in bodies]
        p = [normalised(body.p) for body in bodies]
        near = tuple(precise.number(coordinate.near) for coordinate in coordinates)
        return cls((*r, ZERO), (*p, IDENTITY), near)

    def moved(self, step: Sequence[High]) -> Pose:
        """Positions after a displacement (δr, δθ′) (6 bodies,): p ∘ (cos θ/2, δθ′ sin(θ/2)/θ)."""
        r, p = [], []
        for k, (dr, turn) in enumerate(_by_body(step)):
            r.append(precise.add(self.r[k], dr))
            p.append(precise.compose(self.p[k], _from_turn(turn)))
        return Pose((*r, ZERO), (*p, IDENTITY), self.near)

    def shifted(self, offset: Sequence[float]) -> Pose:
        """Positions r + offset of all bodies but the ground, moved by the same vector (3,) [m]."""
        by = precise.triple(offset)
        return Pose((*(precise.add(r, by) for r in self.r[:-1]), ZERO), self.p, self.near)

    def since(self, start: Pose) -> list[High]:
        """Displacement (δr, δθ′) (6 bodies,) from ``start`` to here; p̄ ∘ p is the turn by δθ′."""
        step: list[High] = []
        for k in range(len(self.r) - 1):
            step += precise.subtract(self.r[k], start.r[k])
            step += _to_turn(precise.compose(precise.conjugate(start.p[k]), self.p[k]))
        return step


def _by_body(step: Sequence[High]) -> Iterator[tuple[Triple, Triple]]:
    for k in range(0, len(step), COLUMNS):
        x, y, z, a, b, c = step[k : k + COLUMNS]
        yield (x, y, z), (a, b, c)


def normalised(values: Sequence[float]) -> Quadruple:
    """Euler parameters p/|p| (4,) [-] of norm one, from a body frame to frame O."""
    p = precise.quadruple(values)
    size = precise.length(p)
    return p[0] / size, p[1] / size, p[2] / size, p[3] / size


def _from_turn(turn: Triple) -> Quadruple:
    """Euler parameters of a rotation vector."""
    angle = precise.length(turn)
    if angle == 0:
        return IDENTITY
    sine = CONTEXT.sin(angle / 2)
    return (CONTEXT.cos(angle / 2), *precise.scale(sine / angle, turn))


def rates_of_turn(turn: Triple) -> tuple[Triple, Triple, Triple]:
    """Matrix T (3, 3) [-] with δθ′ = T dw of a rotation vector w (3,) [rad] that changes by dw.

    T = 1 − (1 − cos|w|)/|w|² w̃ + (|w| − sin|w|)/|w|³ w̃², all in the body frame.
    """
    angle = precise.length(turn)
    if angle == 0:
        return _UNIT
    a = 2 * (CONTEXT.sin(angle / 2) / angle) ** 2
    b = (angle - CONTEXT.sin(angle)) / angle**3
    columns = []
    for axis in _UNIT:
        crossed = precise.cross(turn, axis)
        crossed_twice = precise.scale(b, precise.cross(turn, crossed))
        columns.append(
            precise.add(precise.subtract(axis, precise.scale(a, crossed)), crossed_twice)
        )
    (xx, yx, zx), (xy, yy, zy), (xz, yz, zz) = columns
    return (xx, xy, xz), (yx, yy, yz), (zx, zy, zz)


def _to_turn(p: Quadruple) -> Triple:
    """Rotation vector of Euler parameters, at most half a turn."""
    e = (p[1], p[2], p[3])
    sine = precise.length(e)
    if sine == 0:
        return ZERO
    angle = 2 * CONTEXT.atan2(sine, abs(p[0]))
    return precise.scale((angle if p[0] >= 0 else -angle) / sine, e)
