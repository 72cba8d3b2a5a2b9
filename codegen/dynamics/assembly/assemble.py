"""Assembly: the nearest positions and velocities that fit, from those that a scene gives.

Positions are the q with C(q) = 0 whose displacement d from the start has the least dᵀ W d, where
W holds masses and moments of inertia: d = W⁻¹ C_dᵀ λ. Velocities are those with C_q v = ν for which
v − v₀ is least in the same way. Drivers are rows like all others, taken at t = 0. Rows are
evaluated in 50 digits and equations solved in doubles, again and again, until the result no longer
depends on how: it is rounded once.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.assembly.excess import excess_of_drivers
from kousoku.codegen.dynamics.assembly.minimum_norm import THINNEST, Metric, MinimumNormSolver
from kousoku.codegen.dynamics.assembly.near_origin import brought_near
from kousoku.codegen.dynamics.assembly.newton_mp import ROUNDING_OF_STATES, nearest_pose
from kousoku.codegen.dynamics.assembly.pose import Pose, normalised
from kousoku.codegen.dynamics.assembly.residuals import Residuals, remark_on_ratios
from kousoku.codegen.dynamics.assembly.unwrap import unwrapped, wound_as_driven
from kousoku.codegen.dynamics.assembly.violations import (
    CONSTRAINT_TOLERANCE,
    key_of,
    sizes_of,
    worst_first,
)
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.model.errors import AssemblyError
from kousoku.model.lowering.parametric import fixed_system
from kousoku.model.numbers import precise

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from kousoku.model.mechanics.multibody import MovingBody, System
    from kousoku.model.numbers.precise import High, Quadruple, Triple

MOST_ASSEMBLED_ROWS = 6000
"""Rows of the largest system whose positions are moved."""

STEEP = 1e5
"""Ratios of couplings from which on rank is not always told in S, where they are squared."""

ROUNDING_OF_ITERATIONS = 1e-20
"""Components below this part of the size of the system are zeros that iterations left."""


def assemble(system: System, left_out: Collection[tuple[int, int]] = ()) -> System:
    """System at the nearest positions and velocities that joints and drivers allow.

    What fits to rounding stays as it is, and so does what is held. Angles count from the values
    that they have there, on the turn on which their drivers start.

    Parameters
    ----------
    system : System
        A scene.
    left_out : collection of (int, int)
        Rows that others imply but for the closure tolerance, by the places of constraints: they
        need not hold.

    Raises
    ------
    AssemblyError
        No position near fits, or no velocity does; the message names the joints and drivers that
        stay violated, by how many metres and radians, or metres and radians per second.
    """
    fixed = fixed_system(system)
    placed = _assembled(fixed, left_out)
    return placed if fixed is system else _with_places(system, placed)


def _nearest(system: System, left_out: Collection[tuple[int, int]], metric: Metric) -> Pose:
    """Nearest positions at which all rows hold, searched for near the origin.

    Far from it doubles do not tell positions well enough for a search to settle.
    """
    there, offset = brought_near(system, metric.size)
    rows = Residuals.of(there, there.constraints + there.held, left_out)
    return nearest_pose(there, rows, metric).shifted(offset)


def _with_places(system: System, placed: System) -> System:
    """System whose numbers depend on parameters, where its bodies were placed."""
    bodies = tuple(
        replace(body, r=at.r, p=at.p, v=at.v, omega_b=at.omega_b)
        for body, at in zip(system.bodies, placed.bodies, strict=True)
    )
    coordinates = tuple(
        replace(one, near=at.near)
        for one, at in zip(system.coordinates, placed.coordinates, strict=True)
    )
    return replace(system, bodies=bodies, coordinates=coordinates)


def _assembled(system: System, left_out: Collection[tuple[int, int]]) -> System:
    """System whose numbers are those of the scene, assembled."""
    system = wound_as_driven(system)
    positions = Residuals.of(system, system.constraints + system.held, left_out)
    speeds = Residuals.of(system, system.constraints + system.held_rates, left_out)
    metric = Metric(system)
    fits = _fits(system, positions, metric)
    moves = _moves(system, speeds, metric)
    if fits and moves:
        return unwrapped(system)
    if max(positions.rows, speeds.rows) > MOST_ASSEMBLED_ROWS:
        raise AssemblyError(
            f"{system.name}: the positions and velocities of the scene do not fit, and it has "
            f"{positions.rows} rows; assembly moves at most {MOST_ASSEMBLED_ROWS}: "
            "give those that fit"
        )
    pose = Pose.of(system.bodies, system.coordinates)
    if not fits:
        pose = _nearest(system, left_out, metric)
    v = _velocities(system, speeds, Metric(system, THINNEST), pose)
    fastest = max(_speed(v, k, metric.size) for k in range(len(system.bodies)))
    bodies = tuple(
        _placed(body, pose, v, k, (metric.size, fastest), is_moved=not fits)
        for k, body in enumerate(system.bodies)
    )
    coordinates = tuple(
        replace(one, near=float(near))
        for one, near in zip(system.coordinates, pose.near, strict=True)
    )
    return unwrapped(replace(system, bodies=bodies, coordinates=coordinates))


def _fits(system: System, rows: Residuals, metric: Metric) -> bool:
    """Whether all rows hold to rounding."""
    c, _ = rows.fast(system.bodies)
    far = max((max(map(abs, body.r)) for body in system.bodies), default=0.0)
    limits = ROUNDING_OF_STATES * (np.where(rows.in_metres, metric.size + far, 1.0) + rows.sizes)
    return bool(np.all(np.abs(c) <= limits))


def _moves(system: System, rows: Residuals, metric: Metric) -> bool:
    """Whether velocities keep all joints closed to rounding."""
    _, rates = rows.fast(system.bodies)
    kept = rows.first[len(system.constraints)]
    fastest = max((max(map(abs, body.omega_b)) for body in system.bodies), default=0.0)
    speed = max((max(map(abs, body.v)) for body in system.bodies), default=0.0)
    limits = ROUNDING_OF_STATES * np.where(rows.in_metres, speed + fastest * metric.size, fastest)
    return bool(np.all(np.abs(rates) <= limits, where=np.arange(rows.rows) < kept))


def _speed(v: Sequence[High], k: int, size: float) -> High:
    """Largest velocity of a point of body k near its centre."""
    turning = v[COLUMNS * k + 3 : COLUMNS * k + COLUMNS]
    return precise.length(turning) * size + precise.length(v[COLUMNS * k : COLUMNS * k + 3])


def _placed(
    body: MovingBody,
    pose: Pose,
    v: Sequence[High],
    k: int,
    sizes: tuple[float, High],
    *,
    is_moved: bool,
) -> MovingBody:
    """Body where assembly put it; sizes are the system's length and largest velocity."""
    size, fastest = sizes
    vx, vy, vz = v[COLUMNS * k : COLUMNS * k + 3]
    turning = v[COLUMNS * k + 3 : COLUMNS * k + COLUMNS]
    vx, vy, vz = precise.rounded((vx, vy, vz), fastest, ROUNDING_OF_ITERATIONS)
    wx, wy, wz = precise.rounded(turning, fastest / size, ROUNDING_OF_ITERATIONS)
    moving = replace(body, v=(vx, vy, vz), omega_b=(wx, wy, wz))
    if not is_moved:
        return moving
    x, y, z = precise.rounded(pose.r[k], size, ROUNDING_OF_ITERATIONS)
    norm = precise.length(pose.p[k])
    w, e1, e2, e3 = precise.rounded(
        [component / norm for component in pose.p[k]], 1, ROUNDING_OF_ITERATIONS
    )
    return replace(moving, r=(x, y, z), p=(w, e1, e2, e3))


def _velocities(system: System, rows: Residuals, metric: Metric, pose: Pose) -> list[High]:
    """Velocities nearest to those of the scene at which all joints stay closed."""
    given = [
        x
        for body, p in zip(system.bodies, pose.p, strict=False)
        for x in chain.from_iterable(_given_velocities(body, p))
    ]
    _, jacobian = rows.at(pose)
    kept = rows.first[len(system.constraints)]
    rates = [x - y for x, y in zip(jacobian.times(given), rows.nu, strict=True)]
    wanted = [-x if row < kept else precise.ZERO[0] for row, x in enumerate(rates)]
    lengths = metric.lengths(rows)
    change = MinimumNormSolver(jacobian, metric, rows).displacement(wanted)
    v = [x + y for x, y in zip(given, change, strict=True)]
    torn = [x - y for x, y in zip(jacobian.times(change), wanted, strict=True)]
    prescribed = max((abs(x * y) for x, y in zip(rows.nu, lengths, strict=True)), default=0)
    speed = max(metric.norm(given), prescribed) / metric.size
    _check_velocities(system, rows, torn, (float(speed), metric.size), pose)
    return v


def _given_velocities(body: MovingBody, p: Quadruple) -> tuple[Triple, Triple]:
    """Velocities v and omega_b that the scene gives for a body that assembly turned to p.

    The velocity of its origin stays, and of its angular velocity the components that are given.
    """
    v, omega_b = precise.triple(body.v), precise.triple(body.omega_b)
    before = normalised(body.p)
    if p == before:
        return v, omega_b
    arm = precise.triple(body.origin_b)
    origin = precise.add(v, precise.rotate(before, precise.cross(omega_b, arm)))
    if body.spins_in_o:
        omega_b = precise.rotate_back(p, precise.rotate(before, omega_b))
    return precise.subtract(origin, precise.rotate(p, precise.cross(omega_b, arm))), omega_b


def _check_velocities(
    system: System,
    rows: Residuals,
    missing: Sequence[High],
    sizes: tuple[float, float],
    pose: Pose,
) -> None:
    """Refuse velocities that tear joints, or that bodies hold against each other.

    The sizes are the speed in lengths of the system per second, and this length.
    """
    speed, length = sizes
    torn: dict[str, list[float]] = {}
    for instance, first, end in zip(rows.constraints, rows.first, rows.first[1:], strict=False):
        worst = torn.setdefault(key_of(instance), [0.0, 0.0])
        for row in range(first, end):
            unit = 0 if rows.in_metres[row] else 1
            worst[unit] = max(worst[unit], abs(float(missing[row])))
    if named := worst_first(torn, CONSTRAINT_TOLERANCE * speed, length):
        is_driven = any(one.is_driver and key_of(one) in named for one in system.constraints)
        advice = (
            "the joints, or other drivers, do not allow what drivers prescribe, or it stands at a"
            " dead centre of theirs: start it elsewhere, or leave out drivers of what others move"
            if is_driven
            else "hold less, or give velocities that fit"
        )
        excess = excess_of_drivers(system, pose) if is_driven else ""
        raise AssemblyError(
            f"{system.name}: {excess}no velocities near those of the scene keep its joints closed;"
            f" as near as they come, these are torn: {sizes_of(named, ('m/s', 'rad/s'))}; {advice}"
            f"{remark_on_ratios(system.constraints, STEEP)}",
            [*named],
        )
