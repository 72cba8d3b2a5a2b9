"""Check the solver of a scene of bodies: against 50 digits at a few states, and target by target.

At each state of ``reference.json.gz`` all that the solver computes is computed again, by C and by
NumPy, and its error is told in units of what rounding can do there. What the solver was composed of
has no part in the states of :mod:`kousoku.runtime.independent_verify`. The tables of its methods
must meet the conditions of their orders, and its steps show them. Then both targets make the same
few steps: a scene without sines or logarithms must give the same bits.
"""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from kousoku.model.errors import LoadError, NoCompilerError, SolveError, TargetError, VerifyError
from kousoku.model.manifest import REFERENCE_FILE
from kousoku.runtime.dynamics import DynamicsSolver, load_dynamics
from kousoku.runtime.importing import import_source
from kousoku.runtime.independent_verify import independent_rows
from kousoku.runtime.integrate.result import key_of
from kousoku.runtime.integrate.settings import Doubt, Status
from kousoku.runtime.notice import silent
from kousoku.runtime.options import METHODS, RUNGE_KUTTA
from kousoku.runtime.order import shown_order_problems, table_problems
from kousoku.runtime.reference import Expected
from kousoku.runtime.report import Report, Row

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    import numpy.typing as npt

    from kousoku.model.manifest import Manifest
    from kousoku.runtime.run import Run

    Array = npt.NDArray[np.float64]

HEADER = "solver.h"
FORMAT = 2
NAMES: dict[str, str] = {"c": "C", "numpy": "NumPy"}
#: Regions with one number for each constraint.
BY_ROW = ("C", "C_dot", "C_ddot", "lam", "pivots")
#: Steps that both targets make, rows that they write, and how exactly.
STEPS, ROWS, TOLERANCE = 2, 5, 1e-7
#: Largest relative difference where functions differ from library to library.
NEAR = 1e-9


def verify_solver(
    folder: Path,
    manifest: Manifest,
    files: Mapping[str, bytes],
    target: Literal["auto", "c", "numpy"],
) -> Report:
    """Whether a folder that was made from a scene of bodies computes what was composed.

    Parameters
    ----------
    folder : Path
        Where the files lie.
    manifest : Manifest
        What the folder promises.
    files : mapping of str to bytes
        Name and content, compared with the manifest.
    target : {"auto", "c", "numpy"}
        What to check.
    """
    problems: list[str] = []
    notes: list[str] = []
    try:
        data = _read(folder, files)
    except VerifyError as error:
        return Report(manifest.package, str(folder), (), (str(error),))
    solvers = list(_solvers(folder, target, problems, notes))
    if not solvers and not problems:
        problems.append("nothing was checked, because nothing could be run")
    points = data["points"] if data else []
    notes += _without(folder, data)
    independent = data["independent"] if data else []
    rows = [row for solver in solvers for row in _rows(solver, points)]
    rows += [row for solver in solvers for row in independent_rows(solver, independent)]
    problems += [str(row) for row in rows if not row.ok]
    if solvers:
        problems += table_problems(folder, files)
    problems += _code_problems(folder, files)
    if data and data["is_smooth"] and solvers and solvers[0].target.name == "c":
        methods = import_source(folder, files, "integrate/methods.py").METHODS
        problems += shown_order_problems(solvers[0], methods, {})
    if len(solvers) > 1:
        is_exact = bool(data and data["is_exact"])
        problems += _differences(solvers[0], solvers[1], _parameters(points), is_exact=is_exact)
    return Report(manifest.package, str(folder), tuple(rows), tuple(problems), tuple(notes))


def _read(folder: Path, files: Mapping[str, bytes]) -> dict[str, Any] | None:
    """Reference values, None where the folder was generated without."""
    if REFERENCE_FILE not in files:
        return None
    path = folder / REFERENCE_FILE
    try:
        data: dict[str, Any] = json.loads(files[REFERENCE_FILE])
        if data["format"] != FORMAT:
            raise VerifyError(f"{path}: its format is {data['format']}, wanted {FORMAT}")
        _ = [(point["label"], point["outputs"]) for point in data["points"]], data["is_exact"]
        _ = [(one["label"], one["values"]) for one in data["independent"]], data["is_smooth"]
    except (ValueError, KeyError, TypeError) as error:
        raise VerifyError(f"{path} cannot be read: {error!r}") from None
    return data


def _without(folder: Path, data: dict[str, Any] | None) -> Iterator[str]:
    """Reason why there is nothing to compare with."""
    if data is None:
        yield (
            f"{folder.name} has no {REFERENCE_FILE}: it was generated without reference values;"
            " kousoku generate SCENE.toml writes them"
        )
    elif not data["points"]:
        yield (
            f"{folder.name} has no reference values: its {data['operations']} operations are more"
            f" than {data['most_operations']}, or nothing is finite at the states that were tried"
        )
    elif not data["independent"]:
        yield (
            f"{folder.name} is not compared with each body's own equations: no state near its start"
            " is away from places where rows become dependent"
        )


def _code_problems(folder: Path, files: Mapping[str, bytes]) -> Iterator[str]:
    """Codes of what a call returns that are others in C."""
    if HEADER not in files:
        return
    text = files[HEADER].decode()
    codes = {status.name: status.value for status in Status}
    codes |= {f"DOUBT_{doubt.name}": doubt.value for doubt in Doubt}
    for name, value in codes.items():
        found = re.search(rf"_{name} = (.*?),?\n", text)
        if found is None or found[1] != str(value):
            got = "none" if found is None else found[1]
            yield f"{folder / HEADER}: {name} is {got}, wanted {value}"


def _solvers(
    folder: Path, target: str, problems: list[str], notes: list[str]
) -> Iterator[DynamicsSolver]:
    """Solver by each target; what cannot be had is a problem or a note."""
    targets: tuple[Literal["c", "numpy"], ...] = ("c", "numpy")
    for wanted in targets:
        if target not in {"auto", wanted}:
            continue
        try:
            with silent():
                solver = load_dynamics(folder, target=wanted)
            yield solver
        except (NoCompilerError, TargetError) as error:
            text = f"{NAMES[wanted]} is not checked: {error}"
            (notes if target == "auto" else problems).append(text)
        except LoadError as error:
            problems.append(str(error))


def _rows(solver: DynamicsSolver, points: Sequence[Mapping[str, Any]]) -> Iterator[Row]:
    """Worst error of each region over all states."""
    worst: dict[str, Row] = {}
    for number, point in enumerate(points):
        for row in _rows_at(solver, number, point):
            known = worst.get(row.output)
            if known is None or row.worst > known.worst:
                worst[row.output] = row
    yield from worst.values()


def _rows_at(solver: DynamicsSolver, number: int, point: Mapping[str, Any]) -> Iterator[Row]:
    q, v = (np.array(point[name], dtype=np.float64) for name in ("q", "v"))
    given = zip(solver.parameters, point.get("parameters", ()), strict=False)
    found = solver.evaluate(point["time"], q, v, {name: value for (name, _), value in given})
    for name, columns in point["outputs"].items():
        expected = Expected(
            *(np.array([columns[key]], dtype=np.float64) for key in ("high", "low", "unit"))
        )
        values = found[name][None, :]
        (errors,) = expected.errors(values)
        element = int(np.argmax(errors))
        yield Row(
            kernel="solver",
            output=name,
            way=NAMES[solver.target.name],
            worst=float(errors[element]),
            element=(element,),
            point=number,
            label=point["label"] + _owner(solver, name, element),
            inputs=(("time", repr(point["time"])),),
            got=float(values[0, element]),
            wanted=float(expected.high[0, element]),
        )


def _owner(solver: DynamicsSolver, region: str, element: int) -> str:
    """Say which joint a number belongs to."""
    if region in BY_ROW and element < len(solver.rows):
        return f", {key_of(solver.rows[element][0])}"
    return ""


def _parameters(points: Sequence[Mapping[str, Any]]) -> Sequence[float]:
    """Last values of parameters that a state has, none where all are of the scene."""
    return next((point["parameters"] for point in reversed(points) if "parameters" in point), ())


def _differences(
    one: DynamicsSolver, other: DynamicsSolver, values: Sequence[float], *, is_exact: bool
) -> Iterator[str]:
    """Differences between two targets: the first steps of each method, and the rows."""
    for method in METHODS if one.is_driven else RUNGE_KUTTA:
        try:
            runs = [_run(solver, method, values) for solver in (one, other)]
        except SolveError as error:
            yield f"solver, {method}: {error}"
            continue
        a, b = (run.save().rows.ravel() for run in runs)
        if is_exact:
            a, b = (np.concatenate([run.state, x]) for run, x in zip(runs, (a, b), strict=True))
        limit = 0.0 if is_exact else NEAR * float(np.nanmax(np.abs(a)))
        places = np.flatnonzero(~((np.abs(a - b) <= limit) | (np.isnan(a) & np.isnan(b))))
        if len(places):
            yield (
                f"solver, {method}: {NAMES[one.target.name]} and {NAMES[other.target.name]} differ"
                f" after {STEPS} steps in {len(places)} of {len(a)} numbers of the run, first at"
                f" {places[0]}: {float(a[places[0]])!r} and {float(b[places[0]])!r}"
            )


def _run(solver: DynamicsSolver, method: str, values: Sequence[float]) -> Run:
    """Make a few steps, then the same again with rows in between."""
    names = (name for name, _ in solver.parameters)
    given = dict(zip(names, values, strict=False))
    how: dict[str, Any] = {"tolerance": TOLERANCE, "method": method, "parameters": given}
    first = solver.begin([0.0, 1.0], **how)
    first.advance(max_steps=STEPS)
    run = solver.begin(np.linspace(0.0, first.time, ROWS), **how)
    run.finish()
    return run
