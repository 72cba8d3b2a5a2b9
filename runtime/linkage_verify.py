"""Check the solver of a linkage: its segments against 50 digits, then its motions.

Segments that use only + − × ÷ √ must give the same bits in C and in NumPy. Then both methods move
the linkage, and rows are compared with motions in 50 digits.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.files.manifest import REFERENCE_FORMATS
from kousoku.runtime.kinematics.rows import LINKAGE_METHODS, OF_NODES
from kousoku.runtime.kinematics.status import AnalysisStatus
from kousoku.runtime.linkage import LinkageSolver, open_linkage
from kousoku.runtime.reference import Expected
from kousoku.runtime.report import Row, worst_rows
from kousoku.runtime.solver_verify import NAMES, SolverCheck

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from kousoku.runtime.arguments import Floats
    from kousoku.runtime.choice import Target
    from kousoku.runtime.kinematics.rows import RunRequest
    from kousoku.runtime.solver_verify import Data

#: Largest difference, relative to the largest length, velocity or acceleration: far above the
#: rounding of a mechanism that comes near its dead centres, far below any wrong formula.
LIMIT = 1e-9
#: Other rates, so that no term of the velocities and accelerations is zero or counts once.
SPEED, SPEED_DOT = -1.5, 0.75


class LinkageCheck(SolverCheck[LinkageSolver]):
    """The check of a folder that was made from a linkage."""

    REFERENCE_FORMAT = REFERENCE_FORMATS["linkage"]

    def load(self, target: Target) -> LinkageSolver:
        """Solver by a target."""
        return open_linkage(self.sources, target)

    def require(self, data: Mapping[str, Any]) -> object:
        """Read all that reference values must have."""
        solution = [data["solution"][name] for name in ("divisions", "rows", *OF_NODES)]
        points = [(point["label"], point["inputs"], point["outputs"]) for point in data["points"]]
        return points, solution, data["exact"]

    def rows(self, solver: LinkageSolver, data: Mapping[str, Any]) -> Iterable[Row]:
        """Worst error of each output of each segment."""
        return worst_rows(_rows(solver, data["points"]))

    def problems(self, solvers: Sequence[LinkageSolver], data: Data) -> Iterator[str]:
        """Problems with segments that have other bits in C, and with motions."""
        if data is None:
            return
        if len(solvers) > 1:
            yield from _differences(solvers[0], solvers[1], data)
        for solver in solvers:
            yield from _motion_problems(solver, data["solution"])


def _computed(
    solver: LinkageSolver, point: Mapping[str, Any]
) -> Iterator[tuple[str, str, Floats, Mapping[str, Any]]]:
    """Segments and outputs, with their computed and their stored values at a point."""
    inputs = {name: np.array(x, dtype=np.float64) for name, x in point["inputs"].items()}
    for segment, outputs in point["outputs"].items():
        with np.errstate(all="ignore"):
            regions = solver.evaluate(segment, inputs)
        for name, columns in outputs.items():
            yield segment, name, regions[name][: len(columns["high"])], columns


def _rows(solver: LinkageSolver, points: Sequence[Mapping[str, Any]]) -> Iterator[Row]:
    """Errors of each output of each segment at each point."""
    for number, point in enumerate(points):
        inputs = tuple((name, ", ".join(map(repr, x))) for name, x in point["inputs"].items())
        for segment, name, values, columns in _computed(solver, point):
            yield Expected.of_columns(columns).row(
                values,
                kernel=segment,
                output=name,
                way=NAMES[solver.target.name],
                point=number,
                label=point["label"],
                inputs=inputs,
            )


def _differences(
    first: LinkageSolver, second: LinkageSolver, data: Mapping[str, Any]
) -> Iterator[str]:
    """First differences in bits of two targets, of segments that use only + − × ÷ √."""
    reported = set[tuple[str, str]]()
    for point in data["points"]:
        pairs = zip(_computed(first, point), _computed(second, point), strict=True)
        for (segment, name, a, _), (_, _, b, _) in pairs:
            is_skipped = segment not in data["exact"] or (segment, name) in reported
            if not is_skipped and not np.array_equal(a, b, equal_nan=True):
                reported.add((segment, name))
                yield (
                    f"{segment}: {name} has not the same bits in C and in NumPy, at the point"
                    f" {point['label']}: {a.tolist()} and {b.tolist()}"
                )


def _motion_problems(solver: LinkageSolver, solution: Mapping[str, Any]) -> Iterator[str]:
    """Problems with the motions that a solver gives.

    Both methods are run as the scene says, once more with other rates, from another turn on where
    the inputs turn, and from the inputs of a row on the way; each row that is known is compared.
    """
    rows, divisions = solution["rows"], solution["divisions"]
    exact = {name: np.array(solution[name], dtype=np.float64) for name in OF_NODES}
    for method in LINKAGE_METHODS if rows else ():
        run = solver.request(method=method, divisions=divisions)
        rescaled, expected = _at_other_rates(run, exact)
        if run.is_periodic and rows[-1] == divisions:
            # the continuation begins at the turn before
            rescaled = replace(rescaled, start=divisions + 3, first=2 * divisions)
        label = f"solver by {solver.target.name}, {method}"
        yield from _problems(label, solver, run, rows, exact)
        yield from _problems(f"{label}, at other rates", solver, rescaled, rows, expected)
        k = len(rows) // 3  # half a turn does not tell signs
        moved = replace(run, origin=run.counted_inputs(rows[k]), rows=1)
        row = {name: values[k : k + 1] for name, values in exact.items()}
        yield from _problems(f"{label}, from another origin", solver, moved, [0], row)


def _at_other_rates(
    run: RunRequest, exact: dict[str, Floats]
) -> tuple[RunRequest, dict[str, Floats]]:
    """Run with another law of time, and its exact motion.

    With t(τ), dt/dτ = s and d²t/dτ² = c, a velocity v becomes s v, an acceleration a becomes
    s² a + c v; the same holds for the inputs.
    """
    position, velocity, acceleration = (exact[name] for name in OF_NODES)
    s, c = SPEED, SPEED_DOT
    rescaled = replace(
        run,
        rate=[s * rate for rate in run.rate],
        rate_dot=[
            s * s * rate_dot + c * rate
            for rate, rate_dot in zip(run.rate, run.rate_dot, strict=True)
        ],
    )
    motions = (position, s * velocity, s * s * acceleration + c * velocity)
    return rescaled, dict(zip(OF_NODES, motions, strict=True))


def _problems(
    label: str,
    solver: LinkageSolver,
    run: RunRequest,
    rows: Sequence[int],
    exact: dict[str, Floats],
) -> Iterator[str]:
    """Differences of a run from the rows that are known."""
    mechanism, computed = solver.mechanism, solver.rows(run)
    written = [k for k, row in enumerate(rows) if row < computed.done]
    if len(written) < len(rows):
        message = AnalysisStatus(computed.status).message
        yield f"{label}: stops after {computed.done} rows: {message}"
    if not written:
        return
    inputs = np.array([run.counted_inputs(run.first + rows[k]) for k in written])
    size = np.abs(inputs).max(axis=0)
    for k, expected in zip(written, inputs, strict=True):
        if not np.all(np.abs(computed.alpha[rows[k]] - expected) <= LIMIT * size):
            yield (
                f"{label}: inputs at division {rows[k]} of {run.divisions}: got"
                f" {computed.alpha[rows[k]].tolist()}, wanted {expected.tolist()}"
            )
            break
    for name, expected in exact.items():
        values = getattr(computed, name)[[rows[k] for k in written]].reshape(len(written), -1)
        errors = np.nan_to_num(np.abs(values - expected[written]), nan=np.inf)
        scale = max(float(np.max(np.abs(expected))), mechanism.length)
        k, element = divmod(int(np.argmax(errors)), errors.shape[1])
        if not errors[k, element] <= LIMIT * scale:
            node = mechanism.nodes[element // 2]
            yield (
                f"{label}: {name} {'xy'[element % 2]} of {node} at division {rows[k]} of "
                f"{run.divisions}: got {float(values[k, element])!r}, wanted "
                f"{float(expected[k, element])!r} within {LIMIT * scale:.0e}"
            )
