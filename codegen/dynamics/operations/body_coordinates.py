"""Coordinates of bodies in a plane and in space, and the masses that their motion needs."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING

from kousoku.model.errors import Problem, SceneError
from kousoku.model.mechanics.multibody import GROUND_INDEX

if TYPE_CHECKING:
    from kousoku.model.mechanics.multibody import MovingBody, System

#: Places in (r, p) that are coordinates, and in (δr, δθ′), of a rigid body and of a point.
SPATIAL = ((0, 1, 2, 3, 4, 5, 6), (0, 1, 2, 3, 4, 5))
SPATIAL_POINT = ((0, 1, 2), (0, 1, 2))
PLANAR = ((0, 1, 3, 6), (0, 1, 5))
PLANAR_POINT = ((0, 1), (0, 1))

NO_TURN = (1.0, 0.0, 0.0, 0.0)
#: How many joints a moving body may have.
MOST_JOINTS_OF_BODY = 64


def shape(body: MovingBody, *, is_planar: bool) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Coordinates of a body: places (c,) in (r, p) (7,) [m, -] and in (δr, δθ′) (6,) [m, rad].

    r and δr are in frame O, δθ′ in the principal frame, δp = ½ p ∘ (0, δθ′); in the plane they are
    x, y, and p₀, p_z or δθ′_z.
    """
    if is_planar:
        return PLANAR_POINT if body.is_point else PLANAR
    return SPATIAL_POINT if body.is_point else SPATIAL


def start(body: MovingBody) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Position (r, p) (7,) and velocity (v, ω′) (6,) at the start; a point does not turn.

    r [m] and v [m/s] of the centre of mass in frame O, ω′ [rad/s] in the principal frame.
    """
    if body.is_point:
        return (*body.r, *NO_TURN), (*body.v, 0.0, 0.0, 0.0)
    return (*body.r, *body.p), (*body.v, *body.omega_b)


def require_masses(system: System, *, is_planar: bool) -> None:
    """Refuse bodies that lack masses or moments that their motion depends on.

    Raises
    ------
    SceneError
        Bodies have no mass, or no moment about an axis that they can turn about: all of them.
    """
    problems = []
    for body in system.bodies:
        if body.mass <= 0:
            problems.append(
                Problem("is missing; its motion depends on it", f"bodies.{body.name}.mass")
            )
            continue
        _, columns = shape(body, is_planar=is_planar)
        moments = [body.inertia[k - 3] for k in columns if k > 2]
        if any(moment <= 0 for moment in moments):
            problem = (
                f"has a principal moment of {min(moments)} kg m² about an axis that it can turn"
                " about; wanted positive ones: give it some thickness"
            )
            problems.append(Problem(problem, f"bodies.{body.name}.inertia"))
    if problems:
        raise SceneError.of(problems)


def with_all_inertias(system: System) -> System:
    """System with bodies that can turn about any axis: thin ones get some thickness.

    Moments (3,) [kg m²] in the principal frame that are zero become max(I)/2, or 1. A motion in a
    plane, and what it takes to hold bodies in it, does not change by that.
    """
    return replace(system, bodies=tuple(map(_with_all_inertias, system.bodies)))


def _with_all_inertias(body: MovingBody) -> MovingBody:
    if body.is_point:
        return body
    x, y, z = body.inertia
    thin = float(max(x, y, z)) / 2 or 1.0
    return replace(body, inertia=(x or thin, y or thin, z or thin))


def coordinate_counts(system: System, *, is_planar: bool) -> tuple[int, int]:
    """Counts n of q (n,) [m, -] and m of v (m,) [m/s, rad/s]."""
    shapes = [shape(body, is_planar=is_planar) for body in system.bodies]
    return sum(len(kept) for kept, _ in shapes), sum(len(columns) for _, columns in shapes)


def require_few_joints(system: System) -> None:
    """Refuse bodies with so many joints that coupling every two of them is hopeless.

    Raises
    ------
    SceneError
        A body has more than :data:`MOST_JOINTS_OF_BODY`.
    """
    joints = dict.fromkeys((x.joint, body) for x in system.constraints for body in x.bodies)
    counts = Counter(body for _, body in joints if body != GROUND_INDEX)
    for body, count in counts.items():
        if count > MOST_JOINTS_OF_BODY:
            raise SceneError(
                f"has {count} joints; at most {MOST_JOINTS_OF_BODY} are possible on one body that"
                " moves, because the cost grows with their cube: divide it into bodies"
                " with fixed joints",
                key=f"bodies.{system.bodies[body].name}",
            )
