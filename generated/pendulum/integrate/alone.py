"""A run of a generated folder, with NumPy and nothing else."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .body_tables import BodyPlaces, body_tables
from .initial import Start, evaluated, lead
from .methods import METHODS
from .placing import place
from .scene import state_of
from .settings import (
    BAD_ARGUMENT,
    GOOD,
    NOT_ASSEMBLED,
    NOT_PROJECTED,
    PAUSED,
    STEP_TOO_SMALL,
    Settings,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path
    from typing import TypeAlias

    import numpy.typing as npt

    from .solver import Solver

    Array: TypeAlias = npt.NDArray[np.float64]
    Table: TypeAlias = dict[str, Array]

MESSAGES = {
    PAUSED: "most_steps are made",
    STEP_TOO_SMALL: "no step can be taken",
    NOT_PROJECTED: "the constraints cannot be met inside of a step",
    NOT_ASSEMBLED: "the start cannot be brought onto the constraints",
    BAD_ARGUMENT: "an argument is out of range, or a time is",
}


class Motion(NamedTuple):
    """What :func:`simulate` gives.

    Parameters
    ----------
    unit : float [m]
        The unit of lengths.
    method : str
        How it was integrated.
    time : (n,) array [s]
        The times.
    position, velocity, acceleration : dict of str to (n, 3) array
        Of the origin of each body's frame, in frame O; accelerations where they are wanted.
    orientation : dict of str to (n, 4) array
        Euler parameters of each body that turns, scalar first.
    angular_velocity, angular_acceleration : dict of str to (n, 3) array
        Components in the frame of the body [rad/s, rad/s²].
    parts : dict of str to (n, ·) array
        What else is wanted, as it stands in the rows of the solver, in SI units.
    """

    unit: float
    method: str
    time: Array
    position: Table
    orientation: Table
    velocity: Table
    angular_velocity: Table
    acceleration: Table
    angular_acceleration: Table
    parts: Table


def simulate(
    solver: Solver,
    folder: Path,
    end: float | None = None,
    *,
    times: Sequence[float] | Array | None = None,
    samples: int = 1001,
    tolerance: float = 1e-9,
    method: str | None = None,
    step: float | None = None,
    largest_step: float = 1e300,
    most_steps: int = 1_000_000,
    parameters: Mapping[str, float] | None = None,
    initial: Mapping[str, float] | None = None,
    q0: Array | None = None,
    v0: Array | None = None,
) -> Motion:
    """Move the scene from time 0, in Python: a hundred times as long as compiled.

    Parameters
    ----------
    solver : Solver
        That of the folder.
    folder : Path
        Where its ``motion.json`` is.
    end : float [s], optional
        The last of ``samples`` times from 0 on.
    times : sequence of float [s], optional
        The times to write, instead of both.
    tolerance, method, step, largest_step, most_steps, parameters, initial, q0, v0
        As of ``kousoku.runtime.options.options_of``.

    Raises
    ------
    ArithmeticError
        The motion cannot go on.
    ValueError
        An option is not possible.
    """
    text = (folder / "motion.json").read_text(encoding="utf-8")
    data: dict[str, Any] = json.loads(text)
    if (end is None) == (times is None):
        raise ValueError("give either end or times")
    chosen = np.array(times if end is None else np.linspace(0.0, end, samples), float)
    known = dict(data["parameters"])
    values = {**known, **(parameters or {})}
    is_driven = solver.scene.is_driven
    names = (*(one.name for one in METHODS), *["kinematics"] * is_driven)
    name = method or names[-1 if is_driven else int(tolerance <= 1e-5)]
    if len(values) > len(known) or name not in names:
        raise ValueError(
            f"parameters {list(values)}, method {name!r}; wanted of {list(known)} and {names}"
        )
    settings = Settings(tolerance, min(largest_step, 1e300), step or 0.0, False, names.index(name))
    state, workspace = np.zeros(solver.scene.state_size), np.zeros(solver.scene.work_size)
    rows = np.empty((len(chosen), solver.scene.row_size))
    q, v = np.array(data["q"], float), np.array(data["v"], float)
    given = np.array(list(values.values()), float)
    if solver.scene.has_design:
        if solver.evaluate(0.0, q, v, given, workspace) != GOOD:
            raise ValueError(
                f"parameters {values}: wanted such that masses and lengths are positive"
            )
        _put_design(data, q, v, workspace)
    status = solver.start(0.0, q, v, given, state, workspace)
    if status == GOOD and any(one is not None for one in (initial, q0, v0)):
        start = _start_of(solver, data, given, state_of(solver.scene, state).y)
        q, v = lead(start, initial) if initial is not None else place(start, q0, v0)
        status = solver.start(0.0, q, v, given, state, workspace)
    if status == GOOD:
        status, _ = solver.run(settings, chosen, most_steps, state, workspace, rows)
    if status != GOOD:
        time = state_of(solver.scene, state).time
        raise ArithmeticError(f"{MESSAGES[status]}, at t = {time:.9g} s")
    return _motion_of(solver, data, name, rows)


def _put_design(data: dict[str, Any], q: Array, v: Array, workspace: Array) -> None:
    """Put in the numbers that depend on parameters: of the start, and of the frames of bodies."""
    base, size = data["design"]["place"]
    numbers = workspace[base : base + size].copy()
    for k, at in data["design"]["start"]:
        part, own = (q, k) if k < len(q) else (v, k - len(q))
        part[own] = numbers[at]
    for body in data["bodies"]:
        for name in ("origin_b", "axes_b"):
            given = body[name]
            body[name] = [numbers[x] if isinstance(x, int) else x for x in given]


def _start_of(solver: Solver, data: dict[str, Any], parameters: Array, y: Array) -> Start:
    """Return where the scene starts, from where initial values are led."""
    nq, unit = solver.scene.nq, data["unit"]
    return Start(
        evaluated(solver.evaluate, parameters, solver.scene.work_size, data["places"]),
        y[:nq].copy(),
        y[nq:].copy(),
        [BodyPlaces.from_data(body) for body in data["bodies"]],
        {
            one["name"]: (*one["columns"][:2], unit if one["is_length"] else 1.0)
            for one in data["coordinates"]
        },
        [*data["rows"], *data["left_out"], *data["reduced"]],
        [at for _, at in data["works"]],
        data["length"],
        unit,
    )


def _motion_of(solver: Solver, data: dict[str, Any], method: str, rows: Array) -> Motion:
    """Return rows of the solver by name, for the frames of the scene."""
    parts, at = {}, 1
    for name in ("q", "v", *solver.scene.parts):
        size = solver.scene.size(name)
        parts[name] = rows[:, at : at + size]
        at += size
    bodies = [BodyPlaces.from_data(body) for body in data["bodies"]]
    q, v = parts.pop("q"), parts.pop("v")
    found = body_tables(bodies, q, v, parts.pop("v_dot", None), data["unit"])
    tables = {name: found.get(name, {}) for name in Motion._fields[3:-1]}
    return Motion(data["unit"], method, rows[:, 0], **tables, parts=parts)
