"""Assembly: the nearest positions and velocities that fit, from those that a scene gives.

Positions are the q with C(q) = 0 whose displacement d from the start has the least dᵀ W d, where
W holds masses and moments of inertia: d = W⁻¹ C_qᵀ λ. Velocities are those with C_q v = 0 for which
v − v₀ is least in the same way. Rows are evaluated in 50 digits and equations solved in doubles,
again and again, until the result no longer depends on how: it is rounded once.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.least import Metric, Solver
from kousoku.codegen.dynamics.operations import COLUMNS
from kousoku.codegen.dynamics.pose import Pose
from kousoku.codegen.dynamics.residuals import Residuals
from kousoku.codegen.dynamics.violations import listed, violations, worst_first
from kousoku.model import precise
from kousoku.model.errors import AssemblyError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.residuals import Jacobian
    from kousoku.model.mechanism import MovingBody, System
    from kousoku.model.precise import High

ROUNDING = 16 * 2.0**-52
"""What fits to this part of the size of the system is taken as it is."""

CLOSED = 1e-12
"""What is violated by less than this part of the size of the system fits."""

EXACT = 1e-22
"""Where iterations stop, far beyond the digits of doubles."""

MOST_ROWS = 2000
"""Rows of the largest system whose positions are moved; S is dense here."""

MOST_STEPS = 100
"""Steps on the way to the nearest positions."""

FIRST_DAMPING, LEAST_DAMPING = 1e-3, 1e-12
"""Damping of the first step, and what is as good as none."""

SLOW, PATIENCE = 0.9, 15
"""A step is slow that leaves more than this part of the rows, and how many are taken."""

LARGEST_TURN = 0.5
"""The largest turn of a body in one step, about each axis, in radians."""

NOISE = 1e-20
"""Components below this part of the size of the system are zeros that iterations left."""

NEARLY = 1e-5
"""What is violated by less, and yet not closed, was stopped by rows that lose rank."""


def assemble(system: System) -> System:
    """Return a system at the nearest positions and velocities that its joints allow.

    What fits to rounding stays as it is, and so does what bodies hold.

    Raises
    ------
    AssemblyError
        No position near fits, or no velocity does; the message names the joints that stay violated,
        by how many metres and radians, or metres and radians per second.
    """
    positions = Residuals(system.constraints + system.held, system.bodies)
    speeds = Residuals(system.constraints + system.held_rates, system.bodies)
    metric = Metric(system)
    fits = _fits(system, positions, metric)
    moves = _moves(system, speeds, metric)
    if fits and moves:
        return system
    if max(positions.rows, speeds.rows) > MOST_ROWS:
        raise AssemblyError(
            f"{system.name}: the positions and velocities of the scene do not fit, and it has "
            f"{positions.rows} rows; assembly moves at most {MOST_ROWS}: give those that fit"
        )
    pose = Pose.of(system.bodies)
    if not fits:
        pose = _nearest(system, positions, metric)
    v = _velocities(system, speeds, metric, pose)
    fastest = max(_speed(v, k, metric.size) for k in range(len(system.bodies)))
    bodies = tuple(
        _placed(body, pose, v, k, (metric.size, fastest), is_moved=not fits)
        for k, body in enumerate(system.bodies)
    )
    return replace(system, bodies=bodies)


def _fits(system: System, rows: Residuals, metric: Metric) -> bool:
    """Return whether all rows hold to rounding."""
    c, _ = rows.fast(system.bodies)
    far = max((max(map(abs, body.r)) for body in system.bodies), default=0.0)
    limits = ROUNDING * np.where(rows.in_metres, metric.size + far, 1.0)
    return bool(np.all(np.abs(c) <= limits))


def _moves(system: System, rows: Residuals, metric: Metric) -> bool:
    """Return whether velocities keep all joints closed to rounding."""
    _, rates = rows.fast(system.bodies)
    kept = rows.first[len(system.constraints)]
    fastest = max((max(map(abs, body.omega_b)) for body in system.bodies), default=0.0)
    speed = max((max(map(abs, body.v)) for body in system.bodies), default=0.0)
    limits = ROUNDING * np.where(rows.in_metres, speed + fastest * metric.size, fastest)
    return bool(np.all(np.abs(rates) <= limits, where=np.arange(rows.rows) < kept))


def _speed(v: Sequence[High], k: int, size: float) -> High:
    """Return the largest velocity of a point of body k near its centre."""
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
    """Return a body where assembly put it; sizes are the system's length and largest velocity."""
    size, fastest = sizes
    vx, vy, vz = v[COLUMNS * k : COLUMNS * k + 3]
    turning = v[COLUMNS * k + 3 : COLUMNS * k + COLUMNS]
    vx, vy, vz = precise.rounded((vx, vy, vz), fastest, NOISE)
    wx, wy, wz = precise.rounded(turning, fastest / size, NOISE)
    moving = replace(body, v=(vx, vy, vz), omega_b=(wx, wy, wz))
    if not is_moved:
        return moving
    x, y, z = precise.rounded(pose.r[k], size, NOISE)
    norm = precise.length(pose.p[k])
    w, e1, e2, e3 = precise.rounded([component / norm for component in pose.p[k]], 1, NOISE)
    return replace(moving, r=(x, y, z), p=(w, e1, e2, e3))


def _nearest(system: System, rows: Residuals, metric: Metric) -> Pose:
    """Return the nearest positions at which all rows hold."""
    start = Pose.of(system.bodies)
    lengths = metric.lengths(rows)
    pose = _restored(start, rows, metric, lengths)
    open_joints = violations(rows.constraints, pose, CLOSED * metric.size)
    if open_joints:
        raise AssemblyError(
            f"{system.name}: does not fit together near these positions; as near as it comes, "
            f"these stay open: {listed(open_joints, ('m', 'rad'))}; {_advice(open_joints)}"
        )
    return _polished(start, pose, rows, metric, lengths)


def _advice(open_joints: Mapping[str, tuple[float, float]]) -> str:
    if max(map(max, open_joints.values())) > NEARLY:
        return "check lengths, points, axes and the positions that the scene gives"
    return (
        "the nearest position is one where joints repeat each other, or they contradict each other "
        "by so little: give other positions, or numbers with more digits"
    )


def _restored(start: Pose, rows: Residuals, metric: Metric, lengths: Sequence[High]) -> Pose:
    """Return positions near ``start`` at which rows hold, or as near as they come.

    Gauss-Newton steps of least norm, damped while they overshoot (Levenberg and Marquardt), because
    rows may depend on each other.
    """
    pose, damping, slow = start, FIRST_DAMPING, 0
    c, jacobian = rows.at(pose)
    size = _length(c, lengths)
    while size > EXACT * metric.size and slow < PATIENCE:
        solver = Solver(jacobian, metric, lengths)
        step = solver.step([-x for x in c], damping)
        moved = pose.moved(_shortened(step))
        moved_c, moved_jacobian = rows.at(moved)
        moved_size = _length(moved_c, lengths)
        slow = slow + 1 if moved_size > SLOW * size else 0
        if moved_size >= size:
            damping = max(10 * damping, LEAST_DAMPING)
            continue
        pose, c, jacobian, size = moved, moved_c, moved_jacobian, moved_size
        damping = damping / 100 if damping > LEAST_DAMPING else 0.0
    return pose


def _polished(
    start: Pose, pose: Pose, rows: Residuals, metric: Metric, lengths: Sequence[High]
) -> Pose:
    """Return the positions nearest to ``start`` on the branch of ``pose``, which fits already.

    With d the displacement so far, d ← W⁻¹ C_qᵀ λ where S λ = C_q d − C, until it stays. Where that
    does not settle, the positions stay those that fit.
    """
    moved = pose
    for _ in range(MOST_STEPS):
        c, jacobian = rows.at(moved)
        d = moved.since(start)
        wanted = _missing(jacobian, d, c)
        nearest = Solver(jacobian, metric, lengths).displacement(wanted)
        moved = start.moved(nearest)
        change = metric.norm([x - y for x, y in zip(nearest, d, strict=True)])
        if change <= EXACT * metric.size:
            return moved
    return moved if change <= ROUNDING * metric.size else pose


def _velocities(system: System, rows: Residuals, metric: Metric, pose: Pose) -> list[High]:
    """Return the velocities nearest to those of the scene at which all joints stay closed."""
    given = [precise.number(x) for body in system.bodies for x in (*body.v, *body.omega_b)]
    _, jacobian = rows.at(pose)
    kept = rows.first[len(system.constraints)]
    rates = jacobian.times(given)
    wanted = [-x if row < kept else precise.ZERO[0] for row, x in enumerate(rates)]
    change = Solver(jacobian, metric, metric.lengths(rows)).displacement(wanted)
    v = [x + y for x, y in zip(given, change, strict=True)]
    torn = [x - y for x, y in zip(jacobian.times(change), wanted, strict=True)]
    _check_velocities(system, rows, torn, metric.norm(given))
    return v


def _missing(jacobian: Jacobian, v: Sequence[High], wanted: Sequence[High]) -> list[High]:
    return [x - y for x, y in zip(jacobian.times(v), wanted, strict=True)]


def _check_velocities(
    system: System, rows: Residuals, missing: Sequence[High], speed: High
) -> None:
    """Refuse velocities that tear joints, or that bodies hold against each other."""
    torn: dict[str, list[float]] = {}
    for instance, first, end in zip(rows.constraints, rows.first, rows.first[1:], strict=False):
        worst = torn.setdefault(instance.joint, [0.0, 0.0])
        for row in range(first, end):
            unit = 0 if rows.in_metres[row] else 1
            worst[unit] = max(worst[unit], abs(float(missing[row])))
    if named := worst_first(torn, CLOSED * float(speed)):
        raise AssemblyError(
            f"{system.name}: no velocities near those of the scene keep its joints closed; as near "
            f"as they come, these are torn: {listed(named, ('m/s', 'rad/s'))}; hold less, or give "
            "velocities that fit"
        )


def _length(c: Sequence[High], lengths: Sequence[High]) -> High:
    """Return the norm of rows as lengths."""
    return precise.length([x * y for x, y in zip(c, lengths, strict=True)])


def _shortened(step: Sequence[High]) -> list[High]:
    """Return a displacement that turns no body further than is sensible in one step."""
    turns = [abs(x) for k, x in enumerate(step) if k % COLUMNS >= COLUMNS // 2]
    largest = max(turns, default=0)
    return [x * LARGEST_TURN / largest for x in step] if largest > LARGEST_TURN else list(step)
