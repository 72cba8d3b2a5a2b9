"""Check the solver of a linkage: its segments against 50 digits, then its motions.

At each point of ``reference.json.gz`` every segment is run, by C and by NumPy, and its error is
told in units of what rounding can do there; segments that use only + − × ÷ √ must give the same
bits by both. Then both methods move the linkage, and rows are compared with motions in 50 digits.
"""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.errors import VerifyError
from kousoku.model.manifest import REFERENCE_FILE
from kousoku.runtime.dynamics_verify import NAMES, solvers_of, without_references
from kousoku.runtime.kinematics.rows import METHODS, OF_NODES
from kousoku.runtime.kinematics.status import Status
from kousoku.runtime.linkage import open_linkage
from kousoku.runtime.reference import Expected
from kousoku.runtime.report import Report, Row, worst_rows

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from kousoku.runtime.arguments import Floats
    from kousoku.runtime.choice import Target
    from kousoku.runtime.kinematics.rows import Run
    from kousoku.runtime.linkage import LinkageSolver
    from kousoku.runtime.sources import Sources

FORMAT = 1
#: Largest difference, relative to the largest length, velocity or acceleration: far above the
#: rounding of a mechanism that comes near its dead centres, far below any wrong formula.
LIMIT = 1e-9
#: Other rates, so that no term of the velocities and accelerations is zero or counts once.
SPEED, SPEED_DOT = -1.5, 0.75


def verify_linkage(sources: Sources, target: Target) -> Report:
    """Return whether a folder that was made from a linkage computes what was composed.

    Parameters
    ----------
    sources : Sources
        Its files, compared with the manifest.
    target : {"auto", "c", "numpy"}
        What to check.
    """
    folder, package = sources.folder, sources.manifest.package
    problems: list[str] = []
    notes: list[str] = []
    try:
        data = _read(sources)
    except VerifyError as error:
        return Report(package, str(folder), (), (str(error),))
    solvers = list(
        solvers_of(lambda wanted: open_linkage(sources, wanted), target, problems, notes)
    )
    if data is None:
        notes += without_references(folder)
        return Report(package, str(folder), (), tuple(problems), tuple(notes))
    rows: list[Row] = []
    bits: dict[tuple[int, str, str], Floats] = {}
    for solver in solvers:
        found = [row for k, point in enumerate(data["points"]) for row in _rows(solver, k, point)]
        rows += worst_rows(row for row, _ in found)
        for row, values in found:
            key = row.point, row.kernel, row.output
            same = np.array_equal(bits.setdefault(key, values), values, equal_nan=True)
            if row.kernel in data["exact"] and row.ok and not same:
                problems.append(
                    f"{row.kernel}: {row.output} has not the same bits in C and in NumPy, at point"
                    f" {row.point} ({row.label})"
                )
    problems += [str(row) for row in rows if not row.ok]
    for solver in solvers:
        problems += solver_problems(solver, data["solution"])
    return Report(package, str(folder), tuple(rows), tuple(problems), tuple(notes))


def _read(sources: Sources) -> dict[str, Any] | None:
    """Return the reference values, None where the folder was generated without."""
    if REFERENCE_FILE not in sources.files:
        return None
    path = sources.folder / REFERENCE_FILE
    try:
        data: dict[str, Any] = json.loads(sources.files[REFERENCE_FILE])
        if data["format"] != FORMAT:
            raise VerifyError(f"{path}: its format is {data['format']}, wanted {FORMAT}")
        _ = [(point["label"], point["inputs"], point["outputs"]) for point in data["points"]]
        _ = [data["solution"][name] for name in ("divisions", "rows", *OF_NODES)], data["exact"]
    except (ValueError, KeyError, TypeError) as error:
        raise VerifyError(f"{path} cannot be read: {error!r}") from None
    return data


def _rows(
    solver: LinkageSolver, number: int, point: Mapping[str, Any]
) -> Iterator[tuple[Row, Floats]]:
    """Yield the error of each output of each segment at a point, and what it gave."""
    given = {name: np.array(x, dtype=np.float64) for name, x in point["inputs"].items()}
    inputs = tuple((name, ", ".join(map(repr, x.tolist()))) for name, x in given.items())
    for segment, outputs in point["outputs"].items():
        with np.errstate(all="ignore"):
            found = solver.evaluate(segment, given)
        for name, columns in outputs.items():
            expected = Expected.of_columns(columns)
            values = found[name][: expected.high.shape[1]].copy()
            row = expected.row(
                values,
                kernel=segment,
                output=name,
                way=NAMES[solver.target],
                point=number,
                label=point["label"],
                inputs=inputs,
            )
            yield row, values


def solver_problems(solver: LinkageSolver, solution: Mapping[str, Any]) -> Iterator[str]:
    """Yield what is wrong with the motions that a solver gives.

    Both methods are run as the scene says, and once more with other rates, from another turn on
    where the inputs turn; each row that is known is compared.
    """
    rows, divisions = solution["rows"], solution["divisions"]
    exact = {name: np.array(solution[name], dtype=np.float64) for name in OF_NODES}
    for method in METHODS if rows else ():
        run = solver.request(method=method, divisions=divisions)
        other, wanted = _at_other_rates(run, exact)
        if run.is_periodic and rows[-1] == divisions:
            # the continuation begins at the turn before
            other = replace(other, start=divisions + 3, first=2 * divisions)
        where = f"solver by {solver.target}, {method}"
        yield from _problems(where, solver, run, rows, exact)
        yield from _problems(f"{where}, at other rates", solver, other, rows, wanted)


def _at_other_rates(run: Run, exact: dict[str, Floats]) -> tuple[Run, dict[str, Floats]]:
    """Return a run whose time goes by otherwise, and what it must give.

    With t(τ), dt/dτ = s and d²t/dτ² = c, a velocity v becomes s v, an acceleration a becomes
    s² a + c v; the same holds for the inputs.
    """
    position, velocity, acceleration = (exact[name] for name in OF_NODES)
    s, c = SPEED, SPEED_DOT
    other = replace(
        run,
        rate=[s * rate for rate in run.rate],
        rate_dot=[
            s * s * rate_dot + c * rate
            for rate, rate_dot in zip(run.rate, run.rate_dot, strict=True)
        ],
    )
    motions = (position, s * velocity, s * s * acceleration + c * velocity)
    return other, dict(zip(OF_NODES, motions, strict=True))


def _problems(
    where: str, solver: LinkageSolver, run: Run, rows: Sequence[int], exact: dict[str, Floats]
) -> Iterator[str]:
    """Yield how a run differs from the rows that are known."""
    mechanism, got = solver.mechanism, solver.rows(run)
    good = [k for k, row in enumerate(rows) if row < got.done]
    if len(good) < len(rows):
        yield f"{where}: stops after {got.done} rows: {Status(got.status).message}"
    if not good:
        return
    inputs = np.array([run.counted_inputs(run.first + rows[k]) for k in good])
    size = np.abs(inputs).max(axis=0)
    for k, wanted in zip(good, inputs, strict=True):
        if not np.all(np.abs(got.alpha[rows[k]] - wanted) <= LIMIT * size):
            yield (
                f"{where}: inputs at division {rows[k]} of {run.divisions}: got"
                f" {got.alpha[rows[k]].tolist()}, wanted {wanted.tolist()}"
            )
            break
    for name, wanted in exact.items():
        values = getattr(got, name)[[rows[k] for k in good]].reshape(len(good), -1)
        errors = np.nan_to_num(np.abs(values - wanted[good]), nan=np.inf)
        scale = max(float(np.max(np.abs(wanted))), mechanism.length)
        k, element = divmod(int(np.argmax(errors)), errors.shape[1])
        if not errors[k, element] <= LIMIT * scale:
            node = mechanism.nodes[element // 2]
            yield (
                f"{where}: {name} {'xy'[element % 2]} of {node} at division {rows[k]} of "
                f"{run.divisions}: got {float(values[k, element])!r}, wanted "
                f"{float(wanted[k, element])!r} within {LIMIT * scale:.0e}"
            )
