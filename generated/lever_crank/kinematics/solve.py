"""Position, velocity and acceleration analysis of a mechanism, division by division.

M. Yamada and S. Tatsumi (1981), with full Newton beside their iteration; numbers in parentheses
are their equations.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .approach import approach
from .assembly import assemble
from .block_equations import LinkageCoordinates, segments_of
from .continuation import Continuation
from .rows import OF_LINKS, OF_NODES, Rows, RunRequest, empty_rows
from .status import AnalysisStatus, StopError
from .tables import LinkageTables

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Any

    from ..integrate.tasks import Function
    from .tables import Array


class KinematicSolver:
    """Solver of a folder: its segments, and the analysis beside them.

    Parameters
    ----------
    kernels, tasks
        As of :func:`segments_of`; none where a compiled library computes.
    """

    #: What computes.
    name = "numpy"

    def __init__(
        self,
        kernels: Sequence[tuple[Function, int, str, str]] = (),
        tasks: Mapping[str, str] | None = None,
    ) -> None:
        self.segments = segments_of(kernels, tasks or {})

    def mechanism(self, data: Mapping[str, Any]) -> LinkageTables:
        """Mechanism from ``motion.json``."""
        return LinkageTables.from_data(data, self.segments)

    def scene(self, data: Mapping[str, Any]) -> RunRequest:
        """Run that the scene asks for, from ``motion.json``."""
        return RunRequest(**data["run"])

    def solve(self, mechanism: LinkageTables, run: RunRequest) -> Rows:
        """Rows that are asked for, as far as the mechanism moves."""
        return solve(mechanism, run)


def solve(mechanism: LinkageTables, run: RunRequest) -> Rows:
    """Rows that are asked for, as far as the mechanism moves.

    Parameters
    ----------
    mechanism : LinkageTables
        The tables and segments.
    run : RunRequest
        What is asked.
    """
    rows = empty_rows(mechanism, max(run.rows, 0))
    if not run.is_possible:
        rows.status = AnalysisStatus.BAD_ARGUMENT
        return rows
    with np.errstate(all="ignore"):
        _Analysis(mechanism, run, rows).make()
    return rows


class _Analysis:
    """A continuation whose positions are written into rows."""

    def __init__(self, mechanism: LinkageTables, run: RunRequest, rows: Rows) -> None:
        self.wants_angles = mechanism.wants_angles
        self.run = run
        self.rows = rows
        self.path = Continuation(mechanism, run)

    def make(self) -> None:
        """Write all rows, or all until the mechanism stops and where it did."""
        rows, path = self.rows, self.path
        try:
            self._follow(approach(path, assemble(path.newton, path.position)))
        except StopError as stop:
            rows.status = stop.status
        rows.reached = path.counted_inputs
        if rows.status != AnalysisStatus.GOOD and rows.done < self.run.rows:
            none = np.zeros_like(path.position.x)
            self._write(0, none, none)
            rows.alpha[rows.done] = rows.reached
            rows.residual[rows.done] = rows.condition[rows.done] = math.inf
        rows.block = path.newton.at

    def _follow(self, residual: float) -> None:
        """Go from division to division and write the rows that are asked for."""
        run, rows, path = self.run, self.rows, self.path
        iterations, begin, home = 0, path.division, path.position.x
        if run.times is not None:
            path.motion_at(begin)
            iterations, residual = path.advance(0, residual)
        while True:
            x_dot, x_ddot = path.motion_at(path.division)
            if path.division >= run.first:
                self._write(path.division, x_dot, x_ddot)
                rows.iterations[rows.done] = iterations
                rows.residual[rows.done] = residual
                rows.condition[rows.done] = path.condition
                rows.done += 1
            if rows.done == run.rows:
                return
            iterations, residual = path.advance(path.division + 1, residual)
            made = path.division - begin
            if path.division < run.first and made % run.divisions == 0 and path.is_at(home):
                # So many turns lead back, and so do as many more.
                path.division += (run.first - path.division) // made * made

    def _write(self, division: int, x_dot: Array, x_ddot: Array) -> None:
        """Write the results that are wanted of the position into the next row."""
        run, rows, row, path = self.run, self.rows, self.rows.done, self.path
        equations = path.newton.equations
        equations.place(path.position)
        equations.place(LinkageCoordinates(path.rate, x_dot), "_dot")
        equations.place(LinkageCoordinates(np.asarray(run.rate_dot), x_ddot), "_ddot")
        equations.run("nodes")
        if self.wants_angles:
            equations.run("angles")
        for name in OF_NODES + OF_LINKS * self.wants_angles:
            result = getattr(rows, name)[row]
            result[:] = equations.region(name).reshape(result.shape)
        is_timed = run.times is not None
        rows.alpha[row] = path.position.alpha if is_timed else run.counted_inputs(division)
