"""The nearest positions at which all rows hold, in 50 digits.

Where that fails and drivers prescribe at t = 0 what is far from the positions of the scene, joints
are put together first, and the drivers lead the mechanism from there step by step.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.least import Solver
from kousoku.codegen.dynamics.operations import COLUMNS
from kousoku.codegen.dynamics.pose import Pose
from kousoku.codegen.dynamics.residuals import Residuals
from kousoku.codegen.dynamics.violations import key_of, listed, violations
from kousoku.model import precise
from kousoku.model.errors import AssemblyError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.least import Metric
    from kousoku.model.mechanism import System
    from kousoku.model.precise import High

CLOSED = 1e-12
"""What is violated by less than this part of the size of the system fits."""

EXACT = 1e-22
"""Where iterations stop, far beyond the digits of doubles."""

ON_THE_WAY = 1e-9
"""Where they stop between the positions of the scene and those that drivers prescribe."""

MOST_STEPS = 100
"""Steps on the way to the nearest positions."""

FIRST_DAMPING, LEAST_DAMPING = 1e-3, 1e-12
"""Damping of the first step, and what is as good as none."""

SLOW, PATIENCE = 0.9, 15
"""A step is slow that leaves more than this part of the rows, and how many are taken."""

LARGEST_TURN = 0.5
"""The largest turn of a body in one step, about each axis, in radians."""

ROUNDING = 16 * 2.0**-52
"""What fits to this part of the size of the system is taken as it is."""

NEARLY = 1e-5
"""What is violated by less, and yet not closed, was stopped by rows that lose rank."""

FAR = 0.25
"""Drivers go at most this far at once, in radians or sizes of the system."""

MOST_STAGES, MOST_HALVINGS = 64, 5
"""Stages on the way of drivers, and how often one that fails is halved."""


def nearest(system: System, rows: Residuals, metric: Metric) -> Pose:
    """Return the positions nearest to those of a system at which all rows hold.

    Raises
    ------
    AssemblyError
        There are none near; the message names the joints and drivers that stay violated, by how
        many metres and radians.
    """
    start = Pose.of(system.bodies, system.coordinates)
    search = _Search(rows, metric)
    pose = search.restored(start)
    open_joints = violations(rows, pose, CLOSED * metric.size)
    if open_joints and (driven := _driven(start, system, search)):
        pose = driven
        open_joints = violations(rows, pose, CLOSED * metric.size)
    if open_joints:
        raise AssemblyError(
            f"{system.name}: does not fit together near these positions; as near as it comes, "
            f"these stay open: {listed(open_joints, ('m', 'rad'))}; {_advice(system, open_joints)}"
        )
    return _polished(start, pose, search)


def _advice(system: System, open_joints: Mapping[str, tuple[float, float]]) -> str:
    if max(map(max, open_joints.values())) <= NEARLY:
        return (
            "the nearest position is one where joints repeat each other, or they contradict each"
            " other by so little: give other positions, or numbers with more digits"
        )
    if any(one.is_driver and key_of(one) in open_joints for one in system.constraints):
        return (
            "the joints, or other drivers, do not allow what drivers prescribe at t = 0: check"
            " lengths, points, axes and these values, and leave out drivers of what others move"
        )
    return "check lengths, points, axes and the positions that the scene gives"


class _Search:
    """Steps of least norm towards positions at which rows have wanted values.

    Parameters
    ----------
    rows : Residuals
        All of them.
    metric : Metric
        What displacements weigh.
    """

    def __init__(self, rows: Residuals, metric: Metric) -> None:
        self.rows, self.metric = rows, metric
        self.lengths = metric.lengths(rows)

    def size(self, c: Sequence[High]) -> High:
        """Return the norm of rows as lengths."""
        return precise.length([x * y for x, y in zip(c, self.lengths, strict=True)])

    def restored(
        self, pose: Pose, wanted: Sequence[High] | None = None, until: float = EXACT
    ) -> Pose:
        """Return positions near a pose at which rows are as wanted, or as near as they come.

        Gauss-Newton steps of least norm, damped while they overshoot (Levenberg and Marquardt),
        because rows may depend on each other.
        """
        damping, slow = FIRST_DAMPING, 0
        wanted = wanted or [precise.ZERO[0]] * self.rows.rows
        c, jacobian = self.rows.at(pose)
        missing = _less(wanted, c)
        size = self.size(missing)
        while size > until * self.metric.size and slow < PATIENCE:
            solver = Solver(jacobian, self.metric, self.lengths)
            moved = pose.moved(_shortened(solver.step(missing, damping)))
            c, moved_jacobian = self.rows.at(moved)
            moved_missing = _less(wanted, c)
            moved_size = self.size(moved_missing)
            slow = slow + 1 if moved_size > SLOW * size else 0
            if moved_size >= size:
                damping = max(10 * damping, LEAST_DAMPING)
                continue
            pose, jacobian = self.rows.counted(moved), moved_jacobian
            missing, size = moved_missing, moved_size
            damping = damping / 100 if damping > LEAST_DAMPING else 0.0
        return pose

    def reached(self, pose: Pose, wanted: Sequence[High]) -> bool:
        """Return whether rows are as wanted, as far as counts on the way."""
        c, _ = self.rows.at(pose)
        return bool(self.size(_less(wanted, c)) <= ON_THE_WAY * self.metric.size)


def _driven(start: Pose, system: System, search: _Search) -> Pose | None:
    """Return positions to which drivers lead from afar; None if none is far, or does not arrive.

    The joints are put together without drivers first. From there the value that each driver is
    away from what it prescribes goes to zero in equal stages.
    """
    rows, metric = search.rows, search.metric
    kept = [one for one in rows.constraints if not one.is_driver]
    drives = [one.is_driver for one in rows.constraints for _ in range(rows.count(one))]
    if _stages(_part(rows.at(start)[0], drives), search) <= 1:
        return None
    others = _Search(Residuals.of(system, kept), metric)
    pose = others.restored(start, until=ON_THE_WAY)
    away = _part(rows.at(pose)[0], drives)
    stages = min(MOST_STAGES, _stages(away, search))
    done, part, halvings = 0.0, 1 / stages, 0
    while done < 1:
        left = precise.number(max(0.0, 1 - done - part))
        wanted = [left * x for x in away]
        moved = search.restored(pose, wanted, ON_THE_WAY)
        if search.reached(moved, wanted):
            pose, done = moved, done + part
        elif halvings < MOST_HALVINGS:
            part, halvings = part / 2, halvings + 1
        else:
            return None
    return search.restored(pose)


def _part(c: Sequence[High], drives: Sequence[bool]) -> list[High]:
    """Return the rows of drivers, zeros for the others."""
    return [x if is_driven else precise.ZERO[0] for x, is_driven in zip(c, drives, strict=True)]


def _stages(away: Sequence[High], search: _Search) -> int:
    """Return in how many stages drivers reach what they prescribe."""
    largest = max((abs(x * y) for x, y in zip(away, search.lengths, strict=True)), default=0)
    return max(1, math.ceil(largest / (FAR * search.metric.size)))


def _polished(start: Pose, pose: Pose, search: _Search) -> Pose:
    """Return the positions nearest to ``start`` on the branch of ``pose``, which fits already.

    With d the displacement so far, d ← W⁻¹ C_qᵀ λ where S λ = C_q d − C, until it stays. Where that
    does not settle, the positions stay those that fit.
    """
    metric = search.metric
    moved = pose
    for _ in range(MOST_STEPS):
        c, jacobian = search.rows.at(moved)
        d = moved.since(start)
        wanted = _less(jacobian.times(d), c)
        towards = Solver(jacobian, metric, search.lengths).displacement(wanted)
        moved = search.rows.counted(replace(start.moved(towards), near=moved.near))
        change = metric.norm(_less(towards, d))
        if change <= EXACT * metric.size:
            return moved
    return moved if change <= ROUNDING * metric.size else pose


def _less(a: Sequence[High], b: Sequence[High]) -> list[High]:
    return [x - y for x, y in zip(a, b, strict=True)]


def _shortened(step: Sequence[High]) -> list[High]:
    """Return a displacement that turns no body further than is sensible in one step."""
    turns = [abs(x) for k, x in enumerate(step) if k % COLUMNS >= COLUMNS // 2]
    largest = max(turns, default=0)
    return [x * LARGEST_TURN / largest for x in step] if largest > LARGEST_TURN else list(step)
