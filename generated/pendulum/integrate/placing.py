"""Initial values of a run: bodies where the scene does not start, as they are written.

What :mod:`.body_tables` makes of q and v is undone here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .body_tables import composed, crossed, rotated
from .initial import BACK, ROUNDING, InitialError, Leader, Start, indices, lead, taken

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import TypeAlias

    import numpy.typing as npt

    from .body_tables import BodyPlaces
    from .initial import Evaluate
    from .motion import Layout

    Array: TypeAlias = npt.NDArray[np.float64]

#: What bodies may miss of joints: lengths relative to the scene's, velocities to the largest.
MISSES = 1e-6
#: A whole turn, and so many that are tried to close gears.
TURN, MOST_TURNS = 2.0 * np.pi, 1000


def started(
    layout: Layout,
    rows: Sequence[tuple[str, str]],
    evaluate: Evaluate,
    y: Array,
    given: tuple[Mapping[str, float], Array | None, Array | None],
) -> tuple[Array, Array]:
    """Return q and v with initial values.

    Parameters
    ----------
    layout : Layout
        What stands where, with the parameters of the run.
    rows : sequence of (str, str)
        Joint and unit of all constraints: solved for, left out, put onto joints.
    evaluate : callable
        What :func:`.initial.evaluated` returns, with the parameters of the run.
    y : array
        Where the scene starts with them: q, then v.
    given : (mapping of str to float, array or None, array or None)
        Values of coordinates and rates, or q0 and v0 as written.

    Raises
    ------
    InitialError
        It cannot be.
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
        [at for _, at in layout.works],
        layout.length,
        layout.unit,
    )
    return lead(start, given[0]) if given[0] else place(start, *given[1:])


def place(start: Start, q0: Array | None, v0: Array | None) -> tuple[Array, Array]:
    """Return where a scene starts when its bodies are placed, or are given velocities.

    Parameters
    ----------
    start : Start
        The scene.
    q0 : array, optional
        For each body r of its frame's origin in frame O, in the unit of the scene, then its Euler
        parameters, scalar first, unless it is a point.
    v0 : array, optional
        For each body the velocity of that origin in frame O, then ω′ [rad/s] unless it is a point.

    Returns
    -------
    q, v : array
        On the constraints.

    Raises
    ------
    InitialError
        Bodies or velocities are not where the solver can have them, or joints are open.
    """
    leader = Leader(start)
    problems: list[str] = []
    q, v = start.q.copy(), start.v.copy()
    for name, values, into in (("q0", q0, q), ("v0", v0, v)):
        if values is None:
            continue
        known = np.zeros(len(into), bool)
        rest = np.array(values, float)
        of_bodies = [
            (*body.r, *body.p) if into is q else (*body.v, *body.omega_b) for body in start.bodies
        ]
        size = sum(map(len, of_bodies))
        if rest.shape != (size,) or not np.isfinite(rest).all():
            raise InitialError(
                f"{name} has the shape {rest.shape}; wanted {size} finite numbers: of each body"
                f" {'r (3), Euler parameters (4)' if into is q else 'velocity (3), omega_b (3)'};"
                " a point has the first three alone"
            )
        for body, to in zip(start.bodies, of_bodies, strict=True):
            given, rest = rest[: len(to)], rest[len(to) :]
            given[:3] *= start.unit
            if into is q and body.p and abs(np.linalg.norm(given[3:]) - 1.0) > MISSES:
                problems.append(f"Euler parameters of body {body.name} have not the norm 1")
                continue
            found = _of_masses(body, q, given, is_position=into is q)
            problems += _put(body.name, found, to, into, known, start.length)
    if not problems and q0 is not None:
        q += _turns(start, q)
        problems += _open(start, _residuals(start, q), 1.0)
        q, _ = leader.met(q, np.empty((0, len(v))), [], np.empty(0), ROUNDING)
    if not problems and v0 is not None:
        at = start.evaluate(q, v)
        problems += [f"{text}/s" for text in _open(start, at["C_dot"], max(1.0, leader.size(v)))]
        v = v + at["dv"]
    if problems:
        raise InitialError(f"q0 or v0 cannot be: {'; '.join(problems)}")
    if v0 is None:
        rates = start.evaluate(start.q, start.v)["coordinates"][leader.rates]
        moves = leader.jacobian(q)
        chosen = leader.independent(moves, [])
        v = leader.moving(q, moves, chosen, rates[chosen])
    return q, v


def _of_masses(body: BodyPlaces, q: Array, given: Array, *, is_position: bool) -> Array:
    """Return position or velocity of the centre of mass and the principal frame."""
    if not body.p:
        return given
    arm, axes = np.array(body.origin_b, float), np.array(body.axes_b, float)
    p = taken(body.p, q)
    if is_position:
        turned = composed(given[3:], axes * BACK)
        turned = -turned if turned @ p < 0.0 else turned
        return np.concatenate([given[:3] - rotated(turned, arm), turned])
    omega = rotated(axes, given[3:])
    return np.concatenate([given[:3] - rotated(p, crossed(omega, arm)), omega])


def _put(
    name: str, found: Array, to: Sequence[float], into: Array, known: Array, length: float
) -> list[str]:
    """Put a body where it stands in q or v; return what does not agree with what is there."""
    misses = []
    for k, (at, value) in enumerate(zip(to, found.tolist(), strict=True)):
        if isinstance(at, int) and not known[at]:
            into[at], known[at] = value, True
        else:
            has = into[at] if isinstance(at, int) else at
            misses.append(abs(value - has) / (length if k < 3 else 1.0))
    if max(misses, default=0.0) <= MISSES:
        return []
    return [
        f"body {name} by {max(misses):.3g}, lengths relative to {length:.6g} m: the scene is proven"
        " to keep it in a plane or at rest there, or another body is fixed to it"
    ]


def _open(start: Start, left: Array, speed: float) -> list[str]:
    """Return the joints whose rows do not hold, and how far."""
    worst: dict[tuple[str, str], float] = {}
    for (name, unit), size in zip(start.rows, np.abs(left).tolist(), strict=True):
        if not size <= MISSES * speed * (start.length if unit == "m" else 1.0):
            worst[name, unit] = max(size, worst.get((name, unit), 0.0))
    return [f"{name} is open by {size:.3g} {unit}" for (name, unit), size in worst.items()]


def _residuals(start: Start, q: Array) -> Array:
    """Return what is left of all rows."""
    found = start.evaluate(q, np.zeros_like(start.v))
    return np.concatenate([found["C"], found["C_left_out"]])


def _turns(start: Start, q: Array) -> Array:
    """Return the whole turns that angles of q lack where gears fit: no orientation tells them."""
    left, lacks = _residuals(start, q), np.zeros_like(q)
    places = {k for body in start.bodies for k in indices((*body.r, *body.p))}
    angles = [k for k in range(len(q)) if k not in {*places, *start.works}]
    slopes = np.zeros((len(left), len(q)))
    for k in angles:
        lacks[k] = TURN
        slopes[:, k] = _residuals(start, q + lacks) - left
        lacks[k] = 0.0
    counts = np.outer(np.arange(1.0, MOST_TURNS), [1.0, -1.0]).ravel()
    for k in angles:
        rows = np.flatnonzero(np.abs(slopes[:, k]) > MISSES)
        geared = [m for m in angles if m != k and slopes[rows, m].any()]
        left = _residuals(start, q + lacks)
        if len(rows) and np.abs(left[rows]).max() > MISSES:
            others = slopes[rows][:, geared]
            beyond = left[rows] + np.outer(counts, slopes[rows, k])
            turns = np.round(-beyond @ np.linalg.pinv(others).T)
            fits = np.abs(beyond + turns @ others.T).max(axis=1) <= MISSES
            if fits.any():
                best = int(np.argmax(fits))
                lacks[k] += TURN * counts[best]
                lacks[geared] += TURN * turns[best]
    return lacks
