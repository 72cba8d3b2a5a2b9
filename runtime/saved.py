"""A run in numbers, as it is saved: looked at before another run goes on from it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.errors import SolveError
from kousoku.runtime.integrate.initial_values import InitialValues
from kousoku.runtime.integrate.run_arguments import numbers_of, times_of
from kousoku.runtime.messages import shown
from kousoku.runtime.options import METHOD_NAMES, Options, options_of
from kousoku.runtime.run_ledger import COUNTS

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    import numpy.typing as npt

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.integrate.arithmetic import Array

#: Fields of a state that are counts: those of the ledger, and others.
COUNTED = (*COUNTS, "next_row", "event", "bent", "short_steps", "not_finite")
#: Fields that a step starts from.
FINITE = (
    *("time", "time_before", "step_size", "y", "low", "f", "y_before", "dense"),
    *("parameters", "momenta", "sides", "counts", "fired"),
    *("error", "fastest", "stride", "untold", "is_refined", "longest"),
)
#: Other fields of the control of steps, and those of the verdict.
NUMBERS = (
    *("limit", "behind", "switched", "largest_pivot_ratio", "least_pivot_ratio"),
    *("drift", "row_drift"),
    *("momentum_errors", "lowest", "highest"),
)
#: Fields that are NaN where formulas of a row have no value, which is counted and never trusted.
OF_ROWS = ("energy_error", "energy_moved", "work_error", "violations")


def digest_of(arrays: Mapping[str, npt.NDArray[Any]]) -> str:
    """SHA-256 digest of arrays: of their names, types, shapes and content."""
    total = hashlib.sha256()
    for name in sorted(arrays):
        array = np.asarray(arrays[name])
        total.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
        total.update(array.tobytes())
    return total.hexdigest()


@dataclass(frozen=True, slots=True)
class SavedRun:
    """Run in numbers, all that it is: it can be pickled, copied, and resumed elsewhere.

    Parameters
    ----------
    options : Options
        Options of the run.
    times : array [s]
        The times to write.
    state : array
        The state of the solver.
    rows : array
        The rows that were written.
    events : array
        Index of each event that was told, then the row there.
    digest : str
        SHA-256 of all the above.
    """

    options: Options
    times: Array
    state: Array
    rows: Array
    events: Array
    digest: str = ""

    def sealed(self) -> SavedRun:
        """Saved run with the digest of what it holds."""
        arrays = {"times": self.times, "state": self.state, "rows": self.rows}
        text = np.array(repr(self.options))
        return replace(self, digest=digest_of(arrays | {"events": self.events, "options": text}))

    def __repr__(self) -> str:
        last = self.times[-1] if len(self.times) else 0.0
        return f"<SavedRun: {len(self.rows)} of {len(self.times)} rows to {last:g} s>"


def checked_run(solver: DynamicsSolver, saved: object) -> SavedRun:
    """Saved run whose numbers fit the solver and each other.

    Raises
    ------
    SolveError
        It is no saved run, or belongs to another solver, or was cut, forged or damaged; the message
        says in what.
    """
    if not isinstance(saved, SavedRun):
        raise SolveError(
            f"{solver.name}: a run is resumed from {shown(saved)}; wanted what save() of a run"
            " returned"
        )
    checked = SavedRun(
        options=_options(solver, saved.options),
        times=times_of(solver.name, None, saved.times, 0),
        state=numbers_of(solver.name, "state", saved.state),
        rows=numbers_of(solver.name, "rows", saved.rows),
        events=numbers_of(solver.name, "events", saved.events),
    )
    problem = next(_problems(solver, checked), "")
    if not problem and replace(checked, options=saved.options).sealed().digest != saved.digest:
        problem = (
            "its numbers are not those that were saved, as their digest tells; take a copy that"
            " nothing changed, or begin again"
        )
    if problem:
        raise SolveError(f"{solver.name}: the run cannot be resumed: {problem}")
    return checked


def _options(solver: DynamicsSolver, options: object) -> Options:
    if not isinstance(options, Options):
        raise SolveError(f"{solver.name}: options {shown(options)}; wanted those of a saved run")
    names = set(Options.__slots__) - {"parameters", "initial"}
    if not isinstance(options.initial, InitialValues):
        raise SolveError(
            f"{solver.name}: initial {shown(options.initial)}; wanted that of a saved run"
        )
    try:
        parameters = dict(options.parameters)
    except (TypeError, ValueError):
        raise SolveError(
            f"{solver.name}: parameters {shown(options.parameters)}; wanted names and numbers"
        ) from None
    fields = {name: getattr(options, name) for name in names}
    return replace(options_of(solver, **fields, parameters=parameters), initial=options.initial)


def _problems(solver: DynamicsSolver, saved: SavedRun) -> Iterator[str]:
    """Problems of a saved run; later ones may follow from the first."""
    target, fields = solver.target, solver.state
    if saved.state.shape != (target.state_size,):
        yield (
            f"the state belongs to another solver: its size differs, {saved.state.size} numbers"
            f" instead of {target.state_size}"
        )
        return
    if saved.rows.shape[1:] != (target.row_size,):
        yield (
            f"the rows belong to another solver: their shape is {saved.rows.shape}, wanted"
            f" {target.row_size} numbers in each"
        )
        return
    if (
        saved.events.shape[1:] != (1 + target.row_size,)
        or not np.isin(saved.events[:, 0], range(len(solver.layout.events))).all()
    ):
        yield f"its events belong to another solver: their shape is {saved.events.shape}"
        return
    number = {name: float(fields[name].view(saved.state)) for name in (*COUNTED, "method")}
    yield from (
        f"{name} in the state is {value!r}; wanted a count"
        for name, value in number.items()
        if not (0.0 <= value < 2.0**53 and value.is_integer())
    )
    yield from (
        f"{name} in the state is not finite"
        for name in FINITE
        if not np.isfinite(fields[name].view(saved.state)).all()
    )
    yield from (
        f"{name} in the state is no number"
        for name in (*NUMBERS, *OF_ROWS * (number["not_finite"] == 0.0))
        if np.isnan(fields[name].view(saved.state)).any()
    )
    yield from _disagreements(solver, saved, int(number["next_row"]), number["method"])


def _disagreements(
    solver: DynamicsSolver, saved: SavedRun, written: int, method: float
) -> Iterator[str]:
    """Contradictions between the fields of a saved run."""
    fields, rows, times = solver.state, saved.rows, saved.times
    if written > len(times):
        yield f"{written} rows are written, {len(times)} times are asked for"
        return
    if len(rows) != written:
        yield f"it has {len(rows)} rows, {written} are written: rows were cut or added"
        return
    if not np.array_equal(rows[:, 0], times[:written]):
        yield "its rows are of other times than those that are asked for"
    if not np.isfinite(rows[:, : 1 + len(solver.q) + len(solver.v)]).all():
        yield "a position or velocity in its rows is not finite"
    before, reached = (float(fields[name].view(saved.state)) for name in ("time_before", "time"))
    if before > reached:
        yield f"its last step leads from t = {before!r} s back to {reached!r} s"
    if written and times[written - 1] > reached:
        yield f"rows are written to t = {times[written - 1]!r} s, but only {reached!r} s is reached"
    if written < len(times) and times[written] < before:
        yield f"its next row, t = {times[written]!r} s, is before its last step, {before!r} s"
    if method not in {0.0, 1.0 + METHOD_NAMES.index(saved.options.method)}:
        yield f"it was not begun with the method {saved.options.method!r}"
    values = [value for _, value in saved.options.parameters]
    if not np.array_equal(fields["parameters"].view(saved.state), values):
        yield "its options have other parameters than its state"
