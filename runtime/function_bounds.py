"""Compare bounds of the functions whose roots a run seeks with the functions themselves.

Bounds over no time, at the numbers of ``functions`` in ``reference.json.gz``, are values and rates.
Those of a box must have between them what the functions are at places inside. Of distances a run
has values alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.runtime.integrate.scene_tables import Workspace
from kousoku.runtime.report import Row
from kousoku.runtime.solver_verify import NAMES

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from kousoku.runtime.dynamics_targets import NumpySolver
    from kousoku.runtime.integrate.arithmetic import Array

    #: Name, errors in units, computed numbers and references.
    Compared = tuple[str, Array, Array, Array]

#: Segments that bound functions: least and most of value and rate.
SEGMENTS = ("switching", "bending", "crossing")
#: Regions of the segment ``distance``, which has values alone.
DISTANCES = ("lengths", "distances")
#: Kernel that a report names for these rows.
KERNEL = "bounds"
#: Half sides of boxes, as parts of one and of the numbers read, and count of points inside of a
#: box at which functions are evaluated.
HALF_SIDES, INSIDE = (2.0**-20, 2.0**-7, 2.0**-2), 5
#: The unit of error inside of a box, as a part of one and of the number.
UNIT = 2.0**-24


def bound_rows(solver: NumpySolver, points: Sequence[Mapping[str, Any]]) -> Iterator[Row]:
    """Errors of values and rates, and of bounds, of each region of functions.

    Parameters
    ----------
    solver : NumpySolver
        Solver of a scene.
    points : sequence
        Times, what is read there, and values and rates.
    """
    scene, random = solver.solver.scene, np.random.default_rng(len(points))
    w = Workspace(scene, np.zeros(scene.work_size))
    w.prepare(scene.parameters)
    with np.errstate(all="ignore"):
        for number, point in enumerate(points):
            center = np.array([[point["time"], 1.0, 0.0], *point["read"]])
            references = {
                name: np.array([row or [np.nan] * 3 for row in values])
                for name, values in point["values"].items()
            }
            distances = {name: references.pop(name) for name in DISTANCES if name in references}
            compared = [*_evaluated(center, distances, w), *_exact(center, references, w)]
            for half_side in HALF_SIDES:
                half = half_side * np.maximum(1.0, np.abs(center))
                times = half[0, 0] * random.uniform(-1.0, 1.0, INSIDE)
                half[0] = 0.0  # at one time each number may be anywhere for itself
                places = center + half * random.uniform(-1.0, 1.0, (INSIDE, *half.shape))
                compared += _in_a_box(center - half, center + half, places, references, w)
                half *= random.uniform(0.0, 1.0, half.shape)
                least, most = _range(center, half_side * max(1.0, abs(center[0, 0])))
                places = _moved(center, times)
                compared += _in_a_box(least - half, most + half, places, references, w)
            for name, errors, computed, expected in compared:
                yield _row(name, number, errors, computed, expected)


def _evaluated(center: Array, references: Mapping[str, Array], w: Workspace) -> Iterator[Compared]:
    """Errors of values at a place (k, 3)."""
    w.t[0] = center[0, 0]
    w.measures[:] = center[1:, :2].ravel()
    w.run("distance")
    for name, (value, _, unit) in _columns(references):
        computed = _shaped(getattr(w, name), value.shape)
        yield name, np.abs(computed - value) / unit, computed, value


def _exact(center: Array, references: Mapping[str, Array], w: Workspace) -> Iterator[Compared]:
    """Errors of bounds of no width at a place (k, 3): they are values and rates."""
    exact = _bounds(center, center, references, w)
    for name, (value, rate, unit) in _columns(references):
        computed, expected = exact[name], np.hstack((value, value, rate, rate))
        yield name, np.abs(computed - expected) / unit, computed, expected


def _moved(center: Array, times: Array) -> Array:
    """Places (n, k, 3) on a motion with constant second derivatives through a place (k, 3).

    They are at times (n,) from there [s].
    """
    value, rate, second = center.T
    tau = times[:, np.newaxis]
    rates = rate + tau * second
    return np.stack((value + 0.5 * tau * (rate + rates), rates, second + 0.0 * tau), axis=-1)


def _range(center: Array, time: float) -> tuple[Array, Array]:
    """Least and largest numbers (k, 3) on such a motion up to a time [s] before and behind."""
    _, rate, second = center.T
    turning = np.clip(np.nan_to_num(-rate / second), -time, time)
    ends = _moved(center, np.array([-time, time]))
    extreme = _moved(center, turning)[range(len(center)), range(len(center))]
    every = np.concatenate((ends, extreme[np.newaxis]))
    return every.min(axis=0), every.max(axis=0)


def _in_a_box(
    least: Array, most: Array, places: Array, references: Mapping[str, Array], w: Workspace
) -> Iterator[Compared]:
    """Errors of bounds of a box (k, 3): excess of values at some places (n, k, 3) in it."""
    box = _bounds(least, most, references, w)
    for place in places:
        values = _bounds(place, place, references, w)
        for name, (_, _, unit) in _columns(references):
            inside = values[name]
            bounds = np.where(np.isinf(box[name]), np.nan, box[name])
            beyond = (bounds - inside) * [1.0, -1.0, 1.0, -1.0]
            errors = beyond / np.fmax(unit, UNIT * np.maximum(1.0, np.abs(inside)))
            yield f"{name} in a box", errors, box[name], inside


def _shaped(numbers: Array, shape: tuple[int, ...]) -> Array:
    """Numbers of a region in a shape, infinite where their count is another."""
    is_complete = numbers.size == np.prod(shape)
    return numbers.reshape(shape).copy() if is_complete else np.full(shape, np.inf)


def _columns(references: Mapping[str, Array]) -> Iterator[tuple[str, list[Array]]]:
    """Values, rates and units (n, 1) of the functions of each region."""
    for name, rows in references.items():
        yield name, np.split(rows, 3, axis=1)


def _bounds(
    least: Array, most: Array, references: Mapping[str, Array], w: Workspace
) -> dict[str, Array]:
    """Bounds (n, 4) of functions by region, over a box of what they read, time first."""
    ends = np.stack((least, most), axis=-1).ravel()
    numbers = [*ends[:2], *ends[6:]]  # of the time no rate
    for region in (w.span, w.law_span, w.ranges):
        region[:] = numbers[: len(region)]  # scenes lack some of them
    for segment in SEGMENTS:
        w.run(segment)
    return {name: _shaped(getattr(w, name), (len(rows), 4)) for name, rows in references.items()}


def _row(name: str, number: int, errors: Array, computed: Array, expected: Array) -> Row:
    """Worst error (n, 1) or (n, 4) of a region; NaN, without reference or bound, is none."""
    finite = np.where(np.isnan(errors), 0.0, errors)
    k, column = np.unravel_index(int(np.argmax(finite)), finite.shape)
    return Row(
        kernel=KERNEL,
        output=name,
        way=NAMES["numpy"],
        worst=max(0.0, float(finite[k, column])),
        element=(int(k), int(column)),
        point=number,
        label="drawn",
        inputs=(),
        got=float(computed[k, column]),
        wanted=float(expected[k, column]),
    )
