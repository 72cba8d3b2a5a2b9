"""Assembly: the consistent positions and velocities nearest to those that a scene gives.

Positions are the q with C(q) = 0 whose displacement d from the start has the least dᵀ W d, where
W holds masses and moments of inertia: d = W⁻¹ C_dᵀ λ. Velocities are those with C_q v = ν for which
v − v₀ is least in the same way. Drivers are rows like all others, taken at t = 0. Rows are
evaluated in 50 digits and equations solved in doubles, again and again, until all digits of a
double are right: the result is rounded once.
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
"""Ratio of a coupling above which the rank of S, in which it is squared, may be lost."""

ROUNDING_OF_ITERATIONS = 1e-20
"""Components below this part of the size of the system are rounding of iterations: zeros."""


def assemble(system: System, left_out: Collection[tuple[int, int]] = ()) -> System:
    """System at the nearest positions and velocities that joints and drivers allow.

    Positions and velocities that fit to rounding stay as they are, and so do held ones. Angles
    count from the values that they have there, on the turn on which their drivers start.

    Parameters
    ----------
    system : System
        A scene.
    left_out : collection of (int, int)
        Rows that others imply within the closure tolerance, by the indices of a constraint and of
        its row: they need not hold.

    Raises
    ------
    AssemblyError
        No position near fits, or no velocity does; the message names the joints and drivers that
        stay violated, by how many metres and radians, or metres and radians per second.
    """
    fixed = fixed_system(system)
    placed = _assembled(fixed, left_out)
    return placed if fixed is system else _with_positions(system, placed)


def _nearest(system: System, left_out: Collection[tuple[int, int]], metric: Metric) -> Pose:
    """Nearest positions at which all rows hold, searched for near the origin.

    Far from it the digits of doubles do not suffice for a search to settle.
    """
    shifted, offset = brought_near(system, metric.size)
    rows = Residuals.of(shifted, shifted.constraints + shifted.held, left_out)
    return nearest_pose(shifted, rows, metric).shifted(offset)


def _with_positions(system: System, placed: System) -> System:
    """System whose numbers depend on parameters, at the positions and velocities of another."""
    bodies = tuple(
        replace(body, r=to.r, p=to.p, v=to.v, omega_b=to.omega_b)
        for body, to in zip(system.bodies, placed.bodies, strict=True)
    )
    coordinates = tuple(
        replace(coordinate, near=to.near)
        for coordinate, to in zip(system.coordinates, placed.coordinates, strict=True)
    )
    return replace(system, bodies=bodies, coordinates=coordinates)


def _assembled(system: System, left_out: Collection[tuple[int, int]]) -> System:
    """System in numbers, assembled."""
    system = wound_as_driven(system)
    positions = Residuals.of(system, system.constraints + system.held, left_out)
    speeds = Residuals.of(system, system.constraints + system.held_rates, left_out)
    metric = Metric(system)
    positions_fit = _positions_fit(system, positions, metric)
    velocities_fit = _velocities_fit(system, speeds, metric)
    if positions_fit and velocities_fit:
        return unwrapped(system)
    if max(positions.rows, speeds.rows) > MOST_ASSEMBLED_ROWS:
        raise AssemblyError(
            f"{system.name}: the positions and velocities of the scene do not fit, and it has "
            f"{positions.rows} rows; assembly moves at most {MOST_ASSEMBLED_ROWS}: "
            "give those that fit"
        )
    pose = Pose.of(system.bodies, system.coordinates)
    if not positions_fit:
        pose = _nearest(system, left_out, metric)
    v = _velocities(system, speeds, Metric(system, THINNEST), pose)
    fastest = max(_speed(v, k, metric.size) for k in range(len(system.bodies)))
    bodies = tuple(
        _assembled_body(body, pose, v, k, (metric.size, fastest), is_moved=not positions_fit)
        for k, body in enumerate(system.bodies)
    )
    coordinates = tuple(
        replace(coordinate, near=float(near))
        for coordinate, near in zip(system.coordinates, pose.near, strict=True)
    )
    return unwrapped(replace(system, bodies=bodies, coordinates=coordinates))


def _positions_fit(system: System, rows: Residuals, metric: Metric) -> bool:
    """Whether all rows hold to rounding."""
    c, _ = rows.at_start(system.bodies)
    distance = max((max(map(abs, body.r)) for body in system.bodies), default=0.0)
    lengths = np.where(rows.in_metres, metric.size + distance, 1.0)
    limits = ROUNDING_OF_STATES * (lengths + rows.sizes)
    return bool(np.all(np.abs(c) <= limits))


def _velocities_fit(system: System, rows: Residuals, metric: Metric) -> bool:
    """Whether velocities keep all joints closed to rounding."""
    _, rates = rows.at_start(system.bodies)
    end = rows.first[len(system.constraints)]
    fastest = max((max(map(abs, body.omega_b)) for body in system.bodies), default=0.0)
    speed = max((max(map(abs, body.v)) for body in system.bodies), default=0.0)
    limits = ROUNDING_OF_STATES * np.where(rows.in_metres, speed + fastest * metric.size, fastest)
    return bool(np.all(np.abs(rates) <= limits, where=np.arange(rows.rows) < end))


def _speed(v: Sequence[High], k: int, size: float) -> High:
    """Largest velocity of a point of body k near its centre."""
    turning = v[COLUMNS * k + 3 : COLUMNS * k + COLUMNS]
    return precise.length(turning) * size + precise.length(v[COLUMNS * k : COLUMNS * k + 3])


def _assembled_body(
    body: MovingBody,
    pose: Pose,
    v: Sequence[High],
    k: int,
    sizes: tuple[float, High],
    *,
    is_moved: bool,
) -> MovingBody:
    """Body as assembled; sizes are the length and the largest velocity of the system."""
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
    v_0 = [
        x
        for body, p in zip(system.bodies, pose.p, strict=False)
        for x in chain.from_iterable(_given_velocities(body, p))
    ]
    _, jacobian = rows.at(pose)
    end = rows.first[len(system.constraints)]
    rates = [x - y for x, y in zip(jacobian.times(v_0), rows.nu, strict=True)]
    wanted = [-x if row < end else precise.ZERO[0] for row, x in enumerate(rates)]
    lengths = metric.lengths(rows)
    change = MinimumNormSolver(jacobian, metric, rows).displacement(wanted)
    v = [x + y for x, y in zip(v_0, change, strict=True)]
    residuals = [x - y for x, y in zip(jacobian.times(change), wanted, strict=True)]
    prescribed = max((abs(x * y) for x, y in zip(rows.nu, lengths, strict=True)), default=0)
    speed = max(metric.norm(v_0), prescribed) / metric.size
    _check_velocities(system, rows, residuals, (float(speed), metric.size), pose)
    return v


def _given_velocities(body: MovingBody, p: Quadruple) -> tuple[Triple, Triple]:
    """Velocities v and omega_b that the scene gives for a body that assembly turned to p.

    The velocity of its origin stays, and the given components of its angular velocity.
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
    residuals: Sequence[High],
    sizes: tuple[float, float],
    pose: Pose,
) -> None:
    """Refuse velocities that violate joints, or held velocities that contradict each other.

    The sizes are the speed in lengths of the system per second, and this length.
    """
    speed, length = sizes
    violated: dict[str, list[float]] = {}
    for instance, first, end in zip(rows.constraints, rows.first, rows.first[1:], strict=False):
        largest = violated.setdefault(key_of(instance), [0.0, 0.0])
        for row in range(first, end):
            unit = 0 if rows.in_metres[row] else 1
            largest[unit] = max(largest[unit], abs(float(residuals[row])))
    if worst := worst_first(violated, CONSTRAINT_TOLERANCE * speed, length):
        is_driven = any(c.is_driver and key_of(c) in worst for c in system.constraints)
        advice = (
            "the joints, or other drivers, do not allow what drivers prescribe, or it stands at a"
            " dead centre of theirs: start it elsewhere, or leave out drivers of what others move"
            if is_driven
            else "hold less, or give velocities that fit"
        )
        excess = excess_of_drivers(system, pose) if is_driven else ""
        raise AssemblyError(
            f"{system.name}: {excess}no velocities near those of the scene keep its joints closed;"
            f" as near as they come, these are torn: {sizes_of(worst, ('m/s', 'rad/s'))}; {advice}"
            f"{remark_on_ratios(system.constraints, STEEP)}",
            [*worst],
        )
