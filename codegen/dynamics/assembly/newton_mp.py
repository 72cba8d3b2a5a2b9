"""The nearest positions at which all rows hold, in 50 digits.

Where that fails and drivers prescribe values at t = 0 far from the positions of the scene, joints
are assembled first, and the drivers lead the mechanism from there step by step.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kousoku.codegen.dynamics.assembly.excess import excess_of_drivers
from kousoku.codegen.dynamics.assembly.minimum_norm import MinimumNormSolver
from kousoku.codegen.dynamics.assembly.newton_double import (
    LEAST_DAMPING,
    PATIENCE,
    SLOW,
    DoublePose,
    GaussNewton,
)
from kousoku.codegen.dynamics.assembly.pose import Pose
from kousoku.codegen.dynamics.assembly.residuals import Residuals
from kousoku.codegen.dynamics.assembly.violations import (
    CONSTRAINT_TOLERANCE,
    key_of,
    sizes_of,
    violations,
)
from kousoku.model.errors import AssemblyError
from kousoku.model.numbers import precise

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.assembly.minimum_norm import Metric
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.precise import High
    from kousoku.model.numbers.real import Array

CONVERGED = 1e-22
"""Residual at which iterations stop, far beyond the digits of doubles."""

ON_THE_WAY = 1e-9
"""Residual at which they stop on the way from the scene to what drivers prescribe."""

MOST_PRECISE_STEPS = 12
"""Steps in 50 digits on the way to the nearest positions; each adds some digits."""

MOST_SLIDES, SLID = 60, 1e-16
"""Steps along positions that fit, and the last of them, as a part of the size of the system."""

ROUNDING_OF_STATES = 16 * 2.0**-52
"""Residual, as a part of the size of the system, up to which positions stay as they are."""

NEARLY = 1e-5
"""Violation below which a search that has not closed was stopped by rows that lose rank, where
Newton's method converges linearly."""

LONGEST_DRIVER_STEP = 0.25
"""Longest step of a driver, in radians or sizes of the system: near enough that Newton's method
stays on the branch that the scene is on."""

MOST_STAGES, MOST_HALVINGS = 64, 5
"""Stages on the way of drivers, and how often one that fails is halved."""


def nearest_pose(system: System, rows: Residuals, metric: Metric) -> Pose:
    """Positions nearest to those of a system at which all rows hold: least dᵀ W d with C = 0 (m,).

    d is δr [m] in frame O and a rotation vector [rad] in the principal frame of each body.

    Raises
    ------
    AssemblyError
        There are none near; the message names the joints and drivers that stay violated, by how
        many metres and radians.
    """
    start = Pose.of(system.bodies, system.coordinates)
    search = _PreciseGaussNewton(rows, metric)
    double_start = DoublePose.of(start)
    pose = search.solve(search.doubles.solve(double_start).pose())
    open_joints = violations(rows, pose, metric.size)
    if open_joints and (driven := _led_by_drivers(double_start, system, search)):
        pose = search.solve(driven.pose())
        open_joints = violations(rows, pose, metric.size)
    if open_joints:
        excess = excess_of_drivers(system, start)
        raise AssemblyError(
            f"{system.name}: {excess}does not fit together near these positions; as near as it "
            f"comes, these stay open: {sizes_of(open_joints, ('m', 'rad'))};"
            f" {_advice(system, open_joints)}",
            [*open_joints],
        )
    return _project_nearest(start, pose, search)


def _advice(system: System, open_joints: Mapping[str, tuple[float, float]]) -> str:
    if max(map(max, open_joints.values())) <= NEARLY:
        return (
            "the nearest position is one where joints repeat each other, or they contradict each"
            " other by so little: give other positions, or numbers with more digits"
        )
    if any(c.is_driver and key_of(c) in open_joints for c in system.constraints):
        return (
            "the joints, or other drivers, do not allow what drivers prescribe at t = 0: check"
            " lengths, points, axes and these values, and leave out drivers of what others move"
        )
    return "check lengths, points, axes and the positions that the scene gives"


class _PreciseGaussNewton:
    """Steps of least norm towards positions at which rows hold.

    Parameters
    ----------
    rows : Residuals
        All rows.
    metric : Metric
        Weights of displacements.
    """

    def __init__(self, rows: Residuals, metric: Metric) -> None:
        self.rows, self.metric = rows, metric
        self.lengths = metric.lengths(rows)
        self.doubles = GaussNewton(rows, metric)

    def size(self, c: Sequence[High]) -> High:
        """Norm of rows as lengths."""
        return precise.length([x * y for x, y in zip(c, self.lengths, strict=True)])

    def solve(self, pose: Pose) -> Pose:
        """Positions at which rows hold, near those where they nearly do.

        Gauss-Newton steps of least norm, damped where they overshoot (Levenberg and Marquardt),
        because rows may depend on each other.
        """
        damping, slow = 0.0, 0
        c, jacobian = self.rows.at(pose)
        size = self.size(c)
        while CONVERGED * self.metric.size < size <= NEARLY * self.metric.size and slow < PATIENCE:
            solver = MinimumNormSolver(jacobian, self.metric, self.rows)
            moved = pose.moved(solver.step([-x for x in c], damping))
            moved_c, moved_jacobian = self.rows.at(moved)
            moved_size = self.size(moved_c)
            slow = slow + 1 if moved_size > SLOW * size else 0
            if moved_size >= size:
                damping = max(10 * damping, LEAST_DAMPING)
                continue
            pose, c, jacobian = self.rows.counted(moved), moved_c, moved_jacobian
            size, damping = moved_size, damping / 100 if damping > LEAST_DAMPING else 0.0
        return pose


def _led_by_drivers(
    start: DoublePose, system: System, search: _PreciseGaussNewton
) -> DoublePose | None:
    """Positions to which drivers lead from afar; None if none is far, or one does not arrive.

    The joints are assembled without drivers first. From there the distance of each driver from its
    prescribed value goes to zero in equal stages.
    """
    doubles, size = search.doubles, search.metric.size
    drives = np.repeat(
        [c.is_driver for c in search.rows.constraints],
        [search.rows.count(c) for c in search.rows.constraints],
    )
    if _stages(doubles.residual(start), drives, size) <= 1:
        return None
    indices = [k for k, c in enumerate(search.rows.constraints) if not c.is_driver]
    joints = [search.rows.constraints[k] for k in indices]
    left_out = [(indices.index(k), row) for k, row in search.rows.left_out if k in indices]
    joint_search = GaussNewton(Residuals.of(system, joints, left_out), search.metric)
    pose = joint_search.solve(start, until=ON_THE_WAY)
    lengths = np.where(search.rows.in_metres, 1.0, size)
    offsets = np.where(drives, -doubles.residual(pose) / lengths, 0.0)
    done, halvings = 0.0, 0
    fraction = 1 / min(MOST_STAGES, _stages(doubles.residual(pose), drives, size))
    while done < 1:
        wanted = max(0.0, 1 - done - fraction) * offsets
        moved = doubles.solve(pose, wanted, ON_THE_WAY)
        residual = doubles.residual(moved, wanted)
        if float((residual * residual).sum()) ** 0.5 <= ON_THE_WAY * size:
            pose, done = moved, done + fraction
        elif halvings < MOST_HALVINGS:
            fraction, halvings = fraction / 2, halvings + 1
        else:
            return None
    return doubles.solve(pose)


def _stages(residual: Array, drives: Array, size: float) -> int:
    """Number of stages in which drivers reach their prescribed values."""
    largest = float(np.abs(residual[drives]).max(initial=0.0))
    return max(1, math.ceil(largest / (LONGEST_DRIVER_STEP * size)))


def _project_nearest(start: Pose, pose: Pose, search: _PreciseGaussNewton) -> Pose:
    """Positions nearest to ``start`` on the branch of ``pose``, which fits already.

    With d the displacement so far, and C_d = C_q ∂q/∂d, d ← W⁻¹ C_dᵀ λ where S λ = C_d d − C, until
    d converges. Where it does not, as for rows that depend on each other only where they hold,
    steps go along positions that fit.
    """
    metric, doubles = search.metric, search.doubles
    double_start = DoublePose.of(start)
    projected = doubles.project_nearest(double_start, DoublePose.of(pose))
    if projected is None:
        return _stepwise_nearest(start, pose, search)
    moved = replace(projected.pose(), near=pose.near)
    d = moved.since(start)
    solver: MinimumNormSolver | None = None
    for _ in range(MOST_PRECISE_STEPS):
        c, jacobian = search.rows.at(moved)
        jacobian = jacobian.of_displacement(d)
        solver = (
            solver.with_jacobian(jacobian)
            if solver
            else MinimumNormSolver(jacobian, metric, search.rows)
        )
        nearest = solver.displacement(_difference(jacobian.times(d), c))
        step = _difference(nearest, d)
        change = metric.norm(step)
        if change <= CONVERGED * metric.size:
            return search.rows.counted(replace(start.moved(nearest), near=moved.near))
        correction = doubles.implicit_correction(
            double_start, projected, np.array([float(x) for x in step])
        )
        d = [x + precise.number(y) for x, y in zip(d, correction.tolist(), strict=True)]
        moved = search.rows.counted(replace(start.moved(d), near=moved.near))
    return (
        moved
        if change <= ROUNDING_OF_STATES * metric.size
        else _stepwise_nearest(start, pose, search)
    )


def _stepwise_nearest(start: Pose, pose: Pose, search: _PreciseGaussNewton) -> Pose:
    """Positions nearest to ``start``, by steps from positions to others that fit.

    A step reduces d to its part W⁻¹ C_dᵀ λ. Where steps do not become smaller, positions stay,
    unless steps are rounding by then: for dependent rows doubles give no more digits.
    """
    metric, rows = search.metric, search.rows
    current, last = pose, metric.norm(pose.since(start))
    for _ in range(MOST_SLIDES):
        d = current.since(start)
        jacobian = rows.at(current)[1].of_displacement(d)
        normal = MinimumNormSolver(jacobian, metric, rows).displacement(jacobian.times(d))
        size = metric.norm(_difference(d, normal))
        if size <= SLID * metric.size:
            return current
        if not size < last:
            return current if size <= CONSTRAINT_TOLERANCE * metric.size else pose
        moved = rows.counted(replace(start.moved(normal), near=current.near))
        current, last = search.solve(search.doubles.solve(DoublePose.of(moved)).pose()), size
        if violations(rows, current, metric.size):
            break
    return pose


def _difference(a: Sequence[High], b: Sequence[High]) -> list[High]:
    return [x - y for x, y in zip(a, b, strict=True)]
