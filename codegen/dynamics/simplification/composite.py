"""The composite body of several rigidly connected ones, in 50 digits, rounded once."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.placement import (
    ROUNDING,
    Placement,
    rounded_turn,
    rounded_vector,
)
from kousoku.codegen.dynamics.recording.design import start_of
from kousoku.model.errors import SceneError
from kousoku.model.lowering.mass import principal, steiner
from kousoku.model.mechanics.frames import not_negative, to_vector
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.numbers import precise
from kousoku.model.numbers.precise import IDENTITY, ZERO, High, Quadruple, Triple
from kousoku.model.numbers.traced import Traced
from kousoku.model.numbers.varying import fixed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.mechanics.multibody import MovingBody

    Constants = tuple[tuple[str, tuple[float, ...]], ...]


def on_ground(body: MovingBody) -> Placement:
    """Placement of a body that stands still: r (3,) [m] and p (4,), s = r + A s′ in frame O."""
    r, p, _, _ = start_of(body)
    return Placement(GROUND_INDEX, r, p)


def joined(
    bodies: Sequence[MovingBody], carrier: int, normal: int | None
) -> tuple[MovingBody, list[Placement]]:
    """Composite body of some bodies, and the placement of each in it.

    m = Σ m_k, centre Σ m_k r_k / m (3,) [m], inertia Σ A_k I′_k A_kᵀ + m_k d̃ᵀd̃ (3, 3) [kg m²]
    with d from the centre, in the frame of the first, and v = v_1 + ω × d: three mass points,
    (total-mass), (centre-of-mass), (inertia).

    Parameters
    ----------
    bodies : sequence of MovingBody
        At their positions, which give their relative positions.
    carrier : int
        Index of the composite body.
    normal : int, optional
        Normal axis of a plane that joints hold all bodies in. Products of inertia with it do not
        count there, and it stays a principal axis.

    Returns
    -------
    MovingBody
        With the name of the first, at its position and velocity.
    list of Placement
        Placement of the principal frame of each body.
    """
    first = bodies[0]
    starts = [start_of(body) for body in bodies]
    r, p, speed, spin = starts[0]
    points = [precise.rotate_back(p, precise.subtract(start[0], r)) for start in starts]
    turns = [precise.compose(precise.conjugate(p), start[1]) for start in starts]
    mass, center, moments, axes = _mass_of(bodies, points, turns, normal)
    velocity = precise.rotate(p, precise.cross(spin, center))
    rounded = to_vector(moments)
    body = replace(
        first,
        mass=precise.double(mass),
        inertia=not_negative(rounded),
        r=fixed(rounded_vector(precise.add(r, precise.rotate(p, center)), precise.length(r))),
        p=fixed(rounded_turn(precise.compose(p, precise.conjugate(axes)))),
        v=fixed(rounded_vector(precise.add(speed, velocity), precise.length(velocity))),
        omega_b=fixed(rounded_vector(precise.rotate(axes, spin))),
    )
    placements = [
        Placement(
            carrier,
            precise.rotate(axes, precise.subtract(point, center)),
            precise.compose(axes, turn),
        )
        for point, turn in zip(points, turns, strict=True)
    ]
    of_first = placements[0]
    return replace(
        body, origin_b=of_first.point(first.origin_b), axes_b=of_first.frame(first.axes_b)
    ), placements


def _mass_of(
    bodies: Sequence[MovingBody],
    points: Sequence[Triple],
    turns: Sequence[Quadruple],
    normal: int | None,
) -> tuple[High, Triple, Triple, Quadruple]:
    """Mass, centre, principal moments and the rotation to their axes, in the frame of the first."""
    masses = [precise.number(body.mass) for body in bodies]
    mass = sum(masses, precise.number(0.0))
    if not mass:
        return mass, ZERO, ZERO, IDENTITY
    center = ZERO
    for m, point in zip(masses, points, strict=True):
        center = precise.add(center, precise.scale(m / mass, point))
    total = [[precise.number(0.0)] * 3 for _ in range(3)]
    for b, m, point, turn in zip(bodies, masses, points, turns, strict=True):
        offset_inertia = steiner(m, precise.subtract(point, center))
        axes = [precise.rotate(turn, precise.triple(row)) for row in AXES]
        for i in range(3):
            for j in range(3):
                rotated = sum(precise.number(b.inertia[k]) * axes[k][i] * axes[k][j] for k in ALL)
                total[i][j] += rotated + offset_inertia[i][j]
    try:
        moments, axes_of = principal(_without_noise(total, normal))
    except SceneError as error:
        key = f"bodies.{bodies[0].name}"
        raise SceneError(error.problems[0].problem, key=key) from None
    return mass, center, moments, axes_of


def _without_noise(tensor: Sequence[Sequence[High]], normal: int | None) -> list[list[High]]:
    """Inertia tensor without products with the normal and products that are rounding."""
    limit = ROUNDING * max(tensor[k][k] for k in ALL)
    return [
        [
            precise.number(0.0)
            if i != j and (normal in {i, j} or _is_noise(tensor[i][j], limit))
            else tensor[i][j]
            for j in ALL
        ]
        for i in ALL
    ]


def _is_noise(value: High, limit: High) -> bool:
    return not isinstance(value, Traced) and bool(abs(value) <= limit)


ALL = range(3)
AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
