"""Linkage that moves: the options of a caller are checked, and failures are told.

Told with kousoku's errors; where that is not installed with ``ValueError`` and ``StoppedError``.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..integrate.run_arguments import require_numbers, require_options, times_of
from ..messages import StoppedError, refusal, shown
from .rows import request
from .status import AnalysisStatus
from .trajectory import trajectory_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from .rows import Rows, RunRequest
    from .solve import KinematicSolver
    from .tables import Array
    from .trajectory import Trajectory

#: Options of a call that are counts, and all of them.
COUNTS = ("divisions", "turns", "first_turn", "from_turn")
OPTIONS = ("method", *COUNTS, "limit")
#: What to do where a linkage cannot be moved on.
ADVICE = {
    AnalysisStatus.DEAD_CENTRE: "shorten the way of the input, or drive another link",
    AnalysisStatus.LIMIT_TOO_SMALL: "give a larger residual limit",
    AnalysisStatus.NOT_FINITE: "check lengths, positions and inputs",
    AnalysisStatus.TOO_FAR: "begin nearer to the scene, or ask for more rows between",
}
#: Links that are violated by no more than this part of the size of the linkage are met: they are
#: not what keeps it from being assembled.
VIOLATED = 1e-9
#: Divisions that are counted without rounding.
MOST_COUNTED_DIVISIONS = 2**53


class Linkage:
    """A linkage of nodes with what moves it: in a folder alone NumPy and nothing else.

    Parameters
    ----------
    target : KinematicSolver
        What computes: the solver of the folder, or what does the same.
    data : mapping
        What its ``motion.json`` holds.
    """

    def __init__(self, target: KinematicSolver, data: Mapping[str, Any]) -> None:
        self.name: str = data["name"]
        self.target = target
        self.mechanism, self.scene = target.mechanism(data), target.scene(data)

    def request(self, **options: Any) -> RunRequest:
        """Run that options ask for, those of :meth:`solve`.

        Raises
        ------
        ValueError, TypeError
            They are not such options.
        """
        return request(self.scene, **options)

    def rows(self, run: RunRequest) -> Rows:
        """Rows that :meth:`solve` starts from, for a run."""
        return self.target.solve(self.mechanism, run)

    def solve(self, **options: Any) -> Trajectory:
        """Motion of the scene.

        Parameters
        ----------
        method : {"newton", "paper"}, optional
            Full Newton, or the iteration of the paper, (27) and (28); as in the scene by default.
        divisions : int, optional
            Divisions of a turn; as in the scene by default.
        turns : int
            How many turns to write, one by default: ``turns * divisions + 1`` rows.
        first_turn : int
            The first turn that is written, counted from 0.
        from_turn : int, optional
            The turn at whose start the linkage is as in the scene, 0 by default: whole turns need
            not lead back, and all from there on are made.
        limit : float, optional
            Largest residual, in the unit of the scene.

        Raises
        ------
        AssemblyError
            The linkage does not fit together near the positions of the scene.
        MotionError
            It cannot be moved on; the error has the trajectory up to there.
        SolveError
            An option is not possible, or a residual limit is below rounding.
        """
        return self._moved(options)

    def simulate(
        self,
        end: float | None = None,
        *,
        times: Sequence[float] | Array | None = None,
        samples: int = 1001,
        **options: Any,
    ) -> Trajectory:
        """Motion in time, with all inputs at from + rate t + ½ acceleration t².

        Where :meth:`solve` keeps the divisions and one rate at all of them, here the rates grow
        with the accelerations, and inputs go on by their laws until the end, also beyond ``to``
        and ``turns``. Between times they go at most a division of the scene in one step, and halt
        where they turn back, so that no dead centre on the way is passed over.

        Parameters
        ----------
        end : float [s]
            The last time; ``samples`` times from 0 on are written, equally far apart.
        times : sequence of float [s], optional
            The times to write, ascending, instead of ``end`` and ``samples``.
        samples : int
            How many times.
        **options
            ``method`` and ``limit``, as of :meth:`solve`.

        Raises
        ------
        AssemblyError, MotionError, SolveError
            As of :meth:`solve`.
        """
        require_options(self.name, options, ("method", "limit"), "end", "times", "samples")
        return self._moved(options, times_of(self.name, end, times, samples))

    def _moved(self, options: dict[str, Any], times: Array | None = None) -> Trajectory:
        run, rows = self._rows(options, times)
        motion = trajectory_of(self.mechanism, run, rows, name=self.name, target=self.target.name)
        if rows.status != AnalysisStatus.GOOD:
            raise self._error(run, rows, motion)
        return motion

    def _rows(self, options: dict[str, Any], times: Array | None) -> tuple[RunRequest, Rows]:
        self._check(options)
        try:
            run = self.request(**options)
        except (ValueError, TypeError) as error:
            raise refusal(f"{self.name}: {error}") from None
        if times is not None:
            run = replace(run, times=times, rows=len(times))
        try:
            if run.first + run.rows > MOST_COUNTED_DIVISIONS:
                raise MemoryError
            return run, self.rows(run)
        except MemoryError:
            raise refusal(
                f"{self.name}: no room for {shown(run.rows)} rows from division {shown(run.first)}"
                " on; ask for fewer turns or divisions"
            ) from None

    def _check(self, options: Mapping[str, Any]) -> None:
        """Refuse options that there are not, or that are no numbers where these are wanted."""
        require_options(self.name, options, OPTIONS)
        counts = {key: options[key] for key in COUNTS if options.get(key) is not None}
        require_numbers(self.name, is_whole=True, **counts)
        limit = options.get("limit")
        if limit is not None:
            require_numbers(self.name, limit=limit)
            if not 0.0 < limit < np.inf:
                raise refusal(f"{self.name}: limit {shown(limit)}; wanted a length above 0")

    def _error(self, run: RunRequest, rows: Rows, motion: Trajectory) -> Exception:
        """Say what went wrong, where, and what to do."""
        mechanism, name = self.mechanism, self.name
        block, status = mechanism.blocks[rows.block], AnalysisStatus(rows.status)
        unknowns = mechanism.unknowns[block.unknowns]
        nodes = ", ".join(dict.fromkeys(unknown.name.partition(".")[0] for unknown in unknowns))
        held = f"{nodes}, held by {', '.join(block.links)}"
        known = {link.name for link in mechanism.links}
        named = [f"links.{link}" for link in block.links if link in known]
        keys = ", ".join(named)
        driven = ", ".join(f"inputs.{coordinate.name}" for coordinate in mechanism.inputs)
        where = ", ".join(
            f"{coordinate.name} = {value:.9g} {coordinate.unit}"
            for coordinate, value in zip(mechanism.inputs, rows.reached, strict=True)
        )
        why = status.message
        if status == AnalysisStatus.NOT_ASSEMBLED:
            misfit = self._misfit(rows.position[0], block.links)
            text = f"{name}: {keys}: {why}: {held}, at {where}: {misfit}"
            return refusal(text, "AssemblyError", named)
        if status in {AnalysisStatus.ON_DEAD_CENTRE, AnalysisStatus.OTHER_SIDE}:
            text = (
                f"{name}: {keys}: {why}: {held}, at {where}; move the positions of these nodes to"
                " the side that is wanted"
            )
            return refusal(text, "AssemblyError", named)
        advice = ADVICE.get(status, "check the options")
        text = (
            f"{name}: {driven}: {why}: {held}, at {where}, after {rows.done} good positions of"
            f" {run.rows}; {advice}"
        )
        return refusal(text, "MotionError", motion, alone=StoppedError)

    def _misfit(self, position: Array, links: Iterable[str]) -> str:
        """Say by how much links are violated where the assembly stopped."""
        mechanism, texts = self.mechanism, []
        positions = dict(zip(mechanism.nodes, position, strict=True))
        for name, first, second, length in mechanism.links:
            gap = float(np.hypot(*(positions[second] - positions[first]))) - length
            if name in links and abs(gap) > VIOLATED * mechanism.length:
                texts.append(
                    f"{name} would have to be {abs(gap):.6g} {mechanism.unit}"
                    f" {'longer' if gap > 0 else 'shorter'} to reach from {first} to {second}"
                )
        fits = "no link is violated much, but they cannot all be met"
        return f"{', '.join(texts) or fits}; change lengths or positions"
