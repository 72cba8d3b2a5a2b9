"""Check the solver of a scene of bodies: against 50 digits at a few states, and target by target.

What the solver was composed of has no part in the states of
:mod:`kousoku.runtime.independent_verify`. The tables of its methods must meet the conditions of
their orders, and its steps show them. Then both targets make the same few steps: a scene without
sines or logarithms must give the same bits.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.errors import SolveError
from kousoku.model.files.manifest import REFERENCE_FORMATS
from kousoku.runtime.dynamics import DynamicsSolver, open_dynamics
from kousoku.runtime.dynamics_targets import NumpySolver
from kousoku.runtime.function_bounds import bound_rows
from kousoku.runtime.importing import import_source
from kousoku.runtime.independent_verify import independent_rows
from kousoku.runtime.integrate.settings import Doubt, Status
from kousoku.runtime.messages import scene_key
from kousoku.runtime.options import METHOD_NAMES, RUNGE_KUTTA
from kousoku.runtime.order import shown_order_problems, table_problems
from kousoku.runtime.reference import Expected
from kousoku.runtime.report import Row, worst_rows
from kousoku.runtime.solver_verify import NAMES, SolverCheck

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    from kousoku.runtime.choice import Target
    from kousoku.runtime.run import Run
    from kousoku.runtime.solver_verify import Data

HEADER = "solver.h"
#: Regions with one number for each constraint.
BY_ROW = ("C", "C_dot", "C_ddot", "lam", "pivots")
#: Steps that both targets make, rows that they write, and how exactly.
STEPS, ROWS, TOLERANCE = 2, 5, 1e-7
#: Largest relative difference where functions differ from library to library.
MOST_RELATIVE_DIFFERENCE = 1e-9


class BodiesCheck(SolverCheck[DynamicsSolver]):
    """The check of a folder that was made from a scene of bodies."""

    REFERENCE_FORMAT = REFERENCE_FORMATS["dynamics"]

    def load(self, target: Target) -> DynamicsSolver:
        """Solver by a target."""
        return open_dynamics(self.sources, target)

    def require(self, data: Mapping[str, Any]) -> object:
        """Read all that reference values must have."""
        independent = [(record["label"], record["values"]) for record in data["independent"]]
        points = [(point["label"], point["outputs"]) for point in data["points"]]
        functions = [
            (record["time"], record["read"], record["values"]) for record in data["functions"]
        ]
        return points, independent, functions, data["is_exact"], data["is_smooth"]

    def rows(self, solver: DynamicsSolver, data: Mapping[str, Any]) -> Iterable[Row]:
        """Worst error of each region, and of each body's own equations."""
        return (
            *worst_rows(_rows(solver, data["points"])),
            *independent_rows(solver, data["independent"]),
            *worst_rows(_bound_rows(solver, data["functions"])),
        )

    def notes(self, data: Mapping[str, Any]) -> Iterator[str]:
        """Notes on why there is nothing to compare with."""
        name = self.sources.folder.name
        if not data["points"]:
            yield (
                f"{name} has no reference values: its {data['operations']} operations are more"
                f" than {data['most_operations']}, or nothing is finite at the states that were"
                " tried"
            )
        elif not data["independent"]:
            yield (
                f"{name} is not compared with each body's own equations: no state near its start"
                " is away from places where rows become dependent"
            )

    def problems(self, solvers: Sequence[DynamicsSolver], data: Data) -> Iterator[str]:
        """Problems with methods and codes, and places where targets move differently."""
        folder, files = self.sources.folder, self.sources.files
        if solvers:
            yield from table_problems(folder, files)
        yield from _code_problems(folder, files)
        if data and data["is_smooth"] and solvers and solvers[0].target.name == "c":
            methods = import_source(folder, files, "integrate/methods.py").METHODS
            yield from shown_order_problems(solvers[0], methods)
        if len(solvers) > 1:
            is_exact = bool(data and data["is_exact"])
            values = _parameters(data["points"] if data else ())
            yield from _differences(solvers[0], solvers[1], values, is_exact=is_exact)


def _code_problems(folder: Path, files: Mapping[str, bytes]) -> Iterator[str]:
    """Status codes whose values in C differ."""
    if HEADER not in files:
        return
    text = files[HEADER].decode()
    codes = {status.name: status.value for status in Status}
    codes |= {f"DOUBT_{doubt.name}": doubt.value for doubt in Doubt}
    for name, value in codes.items():
        match = re.search(rf"_{name} = (.*?),?\n", text)
        if match is None or match[1] != str(value):
            actual = "none" if match is None else match[1]
            yield f"{folder / HEADER}: {name} is {actual}, wanted {value}"


def _rows(solver: DynamicsSolver, points: Sequence[Mapping[str, Any]]) -> Iterator[Row]:
    """Error of each region at each state."""
    for number, point in enumerate(points):
        q, v = (np.array(point[name], dtype=np.float64) for name in ("q", "v"))
        values = zip(solver.parameters, point.get("parameters", ()), strict=False)
        outputs = solver.evaluate(point["time"], q, v, {name: value for (name, _), value in values})
        for name, columns in point["outputs"].items():
            row = Expected.of_columns(columns).row(
                outputs[name],
                kernel="solver",
                output=name,
                way=NAMES[solver.target.name],
                point=number,
                label=point["label"],
                inputs=(("time", repr(point["time"])),),
            )
            yield replace(row, label=row.label + _owner(solver, name, row.element[0]))


def _bound_rows(solver: DynamicsSolver, points: Sequence[Mapping[str, Any]]) -> Iterator[Row]:
    """Errors of bounds of functions, which the solver in NumPy tells; C makes the same steps."""
    if isinstance(solver.target, NumpySolver):
        yield from bound_rows(solver.target, points)


def _owner(solver: DynamicsSolver, region: str, element: int) -> str:
    """Text with the joint of a number, empty where it has none."""
    if region in BY_ROW and element < len(solver.rows):
        return f", {scene_key(solver.rows[element][0])}"
    return ""


def _parameters(points: Sequence[Mapping[str, Any]]) -> Sequence[float]:
    """Last values of parameters that a state has, none where all are of the scene."""
    return next((point["parameters"] for point in reversed(points) if "parameters" in point), ())


def _differences(
    base: DynamicsSolver, other: DynamicsSolver, values: Sequence[float], *, is_exact: bool
) -> Iterator[str]:
    """Differences between two targets: the first steps of each method, and the rows."""
    for method in METHOD_NAMES if base.is_driven else RUNGE_KUTTA:
        try:
            runs = [_run(solver, method, values) for solver in (base, other)]
        except SolveError as error:
            yield f"solver, {method}: {error}"
            continue
        a, b = (run.save().rows.ravel() for run in runs)
        if is_exact:
            a, b = (np.concatenate([run.state, x]) for run, x in zip(runs, (a, b), strict=True))
        limit = 0.0 if is_exact else MOST_RELATIVE_DIFFERENCE * float(np.nanmax(np.abs(a)))
        differing = np.flatnonzero(~((np.abs(a - b) <= limit) | (np.isnan(a) & np.isnan(b))))
        if len(differing):
            yield (
                f"solver, {method}: {NAMES[base.target.name]} and {NAMES[other.target.name]} differ"
                f" after {STEPS} steps in {len(differing)} of {len(a)} numbers of the run, first at"
                f" {differing[0]}: {float(a[differing[0]])!r} and {float(b[differing[0]])!r}"
            )


def _run(solver: DynamicsSolver, method: str, values: Sequence[float]) -> Run:
    """Make a few steps, then the same again with rows in between."""
    names = (name for name, _ in solver.parameters)
    parameters = dict(zip(names, values, strict=False))
    options: dict[str, Any] = {"tolerance": TOLERANCE, "method": method, "parameters": parameters}
    first = solver.begin([0.0, 1.0], **options)
    first.advance(max_steps=STEPS)
    run = solver.begin(np.linspace(0.0, first.time, ROWS), **options)
    run.finish()
    return run
