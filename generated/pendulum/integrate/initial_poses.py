"""Initial poses and velocities of bodies, q0 and v0: placed where they are given, as written.

What :mod:`.body_tables` makes of q and v is undone here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..messages import refusal
from .body_tables import indices, solver_state, written_state
from .initial_coordinates import ROUNDING_OF_COORDINATES, InitialError, Leader, Start, lead
from .run_arguments import misfit_of_bodies

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from .arithmetic import Array
    from .body_tables import BodyPlaces
    from .initial_values import InitialValues
    from .motion import Layout
    from .start_evaluation import Evaluate

#: What bodies may miss of joints: lengths relative to the scene's, velocities to the largest.
MISSES = 1e-6
#: A whole turn, and so many that are tried to close gears.
TURN, MOST_TURNS = 2.0 * np.pi, 1000


def started(
    layout: Layout,
    rows: Sequence[tuple[str, str]],
    evaluate: Evaluate,
    y: Array,
    initial: InitialValues,
) -> tuple[Array, Array]:
    """Coordinates q and velocities v with initial values.

    Parameters
    ----------
    layout : Layout
        What stands where, with the parameters of the run.
    rows : sequence of (str, str)
        Joint and unit of all constraints: solved for, left out, put onto joints.
    evaluate : callable
        What :func:`.start_evaluation.evaluated` returns, with the parameters of the run.
    y : (nq + nv,) array
        Where the scene starts with them: q, then v, in SI units.
    initial : InitialValues
        Values of coordinates and rates, or q0 and v0 as written.

    Returns
    -------
    q, v : (nq,), (nv,) array
        On the constraints, in SI units.

    Raises
    ------
    SolveError
        It cannot be; where kousoku is not installed it is a ``ValueError``.
    """
    count = layout.sizes["q"]
    start = Start(
        evaluate,
        y[:count].copy(),
        y[count:].copy(),
        layout.bodies,
        {
            name: (columns[0], columns[1], layout.unit if is_length else 1.0)
            for name, is_length, columns in layout.coordinates
        },
        tuple(rows),
        [index for _, index in layout.works],
        layout.length,
        layout.unit,
    )
    poses = (np.array(values) if values else None for values in initial[1:])
    try:
        return lead(start, dict(initial.values)) if initial.values else place(start, *poses)
    except InitialError as error:
        raise refusal(f"{layout.name}: {error}") from None


def place(
    start: Start, q0: Array | None, v0: Array | None, counted: Array | None = None
) -> tuple[Array, Array]:
    """Start of a scene, q and v, when its bodies are placed, or are given velocities.

    Parameters
    ----------
    start : Start
        The scene.
    q0 : array, optional
        For each body r of its frame's origin in frame O, in the unit of the scene, then its Euler
        parameters, scalar first, unless it is a point.
    v0 : array, optional
        For each body the velocity of that origin in frame O, in the unit of the scene per second,
        then ω′ [rad/s] unless it is a point.
    counted : (nq,) array, optional
        q of the solver where turns are counted, within half a turn of q0; as the start counts them,
        and gears need, unless given.

    Returns
    -------
    q, v : (nq,), (nv,) array
        On the constraints, in SI units.

    Raises
    ------
    InitialError
        Bodies or velocities are not where the solver can have them, or joints are open.
    """
    leader = Leader(start)
    initial_state = written_state(start.bodies, start.q, start.v, start.unit)
    problems: list[str] = []
    wanted = []
    for name, values, written in zip(("q0", "v0"), (q0, v0), initial_state, strict=True):
        if values is not None and (wrong := misfit_of_bodies(name, values, written.size)):
            raise InitialError(wrong)
        wanted.append(written if values is None else values.copy())
    for body, part in _slices(start.bodies, wanted[0], 4):
        size = np.linalg.norm(part[3:])
        if body.p and not abs(size - 1.0) <= MISSES:
            problems.append(f"Euler parameters of body {body.name} have not the norm 1")
        part[3:] /= size or 1.0
    q, v = start.q.copy(), start.v.copy()
    if not problems:
        placed = solver_state(start.bodies, wanted[0], wanted[1], start.unit, (q, v))
        reached = written_state(start.bodies, *placed, start.unit)
        if q0 is not None:
            q, problems = placed[0], [*_misplaced(start, wanted[0], reached[0], 4)]
        if v0 is not None:
            v = placed[1]
            problems += _misplaced(start, wanted[1], reached[1], 3)
    if not problems and q0 is not None:
        q += _missing_turns(start, q, counted)
        problems += _gaps(start, _residuals(start, q), 1.0)
        q, _ = leader.corrected(q, np.empty((0, len(v))), [], np.empty(0), ROUNDING_OF_COORDINATES)
    if not problems and v0 is not None:
        at = start.evaluate(q, v)
        problems += [f"{text}/s" for text in _gaps(start, at["C_dot"], max(1.0, leader.size(v)))]
        v = v + at["dv"]
    if problems:
        raise InitialError(f"q0 or v0 cannot be: {'; '.join(problems)}")
    if v0 is None:
        rates = start.evaluate(start.q, start.v)["coordinates"][leader.rates]
        moves = leader.jacobian(q)
        chosen = leader.independent(moves, [])
        v = leader.velocities(q, moves, chosen, rates[chosen])
    return q, v


def _slices(
    bodies: Sequence[BodyPlaces], values: Array, turning: int
) -> Iterator[tuple[BodyPlaces, Array]]:
    """Bodies with their slices of a state as written: three numbers, then those of a turn."""
    first = 0
    for body in bodies:
        size = 3 + turning * bool(body.p)
        yield body, values[first : first + size]
        first += size


def _misplaced(start: Start, wanted: Array, reached: Array, turning: int) -> Iterator[str]:
    """Bodies that the solver cannot place as they are wanted, and by how much."""
    there = _slices(start.bodies, reached, turning)
    for (body, part), (_, has) in zip(_slices(start.bodies, wanted, turning), there, strict=True):
        back = -1.0 if turning == 4 and part[3:] @ has[3:] < 0.0 else 1.0  # p and -p turn alike
        lengths = np.abs(part[:3] - has[:3]).max() * start.unit / start.length
        miss = max(lengths, np.abs(part[3:] - back * has[3:]).max(initial=0.0))
        if not miss <= MISSES:
            yield (
                f"body {body.name} by {miss:.3g}, lengths relative to {start.length:.6g} m: the"
                " scene is proven to keep it in a plane or at rest there, or another body is fixed"
                " to it"
            )


def _gaps(start: Start, residuals: Array, speed: float) -> list[str]:
    """Gaps of joints whose rows do not hold."""
    worst: dict[tuple[str, str], float] = {}
    for (name, unit), size in zip(start.rows, np.abs(residuals).tolist(), strict=True):
        if not size <= MISSES * speed * (start.length if unit == "m" else 1.0):
            worst[name, unit] = max(size, worst.get((name, unit), 0.0))
    return [f"{name} is open by {size:.3g} {unit}" for (name, unit), size in worst.items()]


def _residuals(start: Start, q: Array) -> Array:
    """Residuals of all rows, also of those left out."""
    evaluated = start.evaluate(q, np.zeros_like(start.v))
    return np.concatenate([evaluated["C"], evaluated["C_left_out"]])


def _missing_turns(start: Start, q: Array, counted: Array | None) -> Array:
    """Turns that angles of q lack: no orientation tells them, but gears that fit."""
    residuals, lacks = _residuals(start, q), np.zeros_like(q)
    of_bodies = {k for body in start.bodies for k in indices((*body.r, *body.p))}
    angles = [k for k in range(len(q)) if k not in {*of_bodies, *start.works}]
    if counted is not None:
        lacks[angles] = (counted - q)[angles]
        return lacks
    slopes = np.zeros((len(residuals), len(q)))
    for k in angles:
        lacks[k] = TURN
        slopes[:, k] = _residuals(start, q + lacks) - residuals
        lacks[k] = 0.0
    counts = np.outer(np.arange(1.0, MOST_TURNS), [1.0, -1.0]).ravel()
    for k in angles:
        rows = np.flatnonzero(np.abs(slopes[:, k]) > MISSES)
        geared = [m for m in angles if m != k and slopes[rows, m].any()]
        residuals = _residuals(start, q + lacks)
        if len(rows) and np.abs(residuals[rows]).max() > MISSES:
            others = slopes[rows][:, geared]
            beyond = residuals[rows] + np.outer(counts, slopes[rows, k])
            turns = np.round(-beyond @ np.linalg.pinv(others).T)
            fits = np.abs(beyond + turns @ others.T).max(axis=1) <= MISSES
            if fits.any():
                best = int(np.argmax(fits))
                lacks[k] += TURN * counts[best]
                lacks[geared] += TURN * turns[best]
    return lacks
