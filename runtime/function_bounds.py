"""Compare bounds of the functions whose roots a run looks for with what they are bounds of.

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

    #: What is compared, errors in units, what was computed, and what is wanted.
    Compared = tuple[str, Array, Array, Array]

#: Segments that bound functions: least and most of value and rate.
SEGMENTS = ("switching", "bending", "crossing")
#: Regions of the segment ``distance``, which has values alone.
DISTANCES = ("lengths", "distances")
#: What is said of such a row.
KERNEL = "bounds"
#: Half of the sides of boxes, as parts of one and of what is read, and at how many places inside
#: functions are looked at.
HALF_SIDES, INSIDE = (2.0**-20, 2.0**-7, 2.0**-2), 5
#: The unit of error inside of a box, as a part of one and of the number.
UNIT = 2.0**-24


def bound_rows(solver: NumpySolver, points: Sequence[Mapping[str, Any]]) -> Iterator[Row]:
    """Errors of values and rates, and of bounds, of each region of functions.

    Parameters
    ----------
    solver : NumpySolver
        That of a scene.
    points : sequence
        Times, what is read there, and values and rates.
    """
    scene, random = solver.solver.scene, np.random.default_rng(len(points))
    w = Workspace(scene, np.zeros(scene.work_size))
    w.prepare(scene.parameters)
    with np.errstate(all="ignore"):
        for number, point in enumerate(points):
            place = np.array([[point["time"], 1.0, 0.0], *point["read"]])
            known = {
                name: np.array([row or [np.nan] * 3 for row in values])
                for name, values in point["values"].items()
            }
            distances = {name: known.pop(name) for name in DISTANCES if name in known}
            compared = [*_evaluated(place, distances, w), *_exact(place, known, w)]
            for half_side in HALF_SIDES:
                half = half_side * np.maximum(1.0, np.abs(place))
                half[0, 1:] = 0.0  # time goes on evenly
                ways = half * random.uniform(-1.0, 1.0, (INSIDE, *half.shape))
                compared += _in_a_box(place, half, ways, known, w)
            for name, errors, got, wanted in compared:
                yield _row(name, number, errors, got, wanted)


def _evaluated(place: Array, known: Mapping[str, Array], w: Workspace) -> Iterator[Compared]:
    """Errors of values at a place (k, 3)."""
    w.t[0] = place[0, 0]
    w.measures[:] = place[1:, :2].ravel()
    w.run("distance")
    for name, (value, _, unit) in _columns(known):
        found = _as_many(getattr(w, name), value.shape)
        yield name, np.abs(found - value) / unit, found, value


def _exact(place: Array, known: Mapping[str, Array], w: Workspace) -> Iterator[Compared]:
    """Errors of bounds of no width at a place (k, 3): they are values and rates."""
    exact = _bounds(place, place, known, w)
    for name, (value, rate, unit) in _columns(known):
        found, wanted = exact[name], np.hstack((value, value, rate, rate))
        yield name, np.abs(found - wanted) / unit, found, wanted


def _in_a_box(
    place: Array, half: Array, ways: Array, known: Mapping[str, Array], w: Workspace
) -> Iterator[Compared]:
    """Errors of bounds of a box about a place (k, 3): what is beyond them some ways from there."""
    box = _bounds(place - half, place + half, known, w)
    for way in ways:
        found = _bounds(place + way, place + way, known, w)
        for name, (_, _, unit) in _columns(known):
            inside = found[name]
            told = np.where(np.isinf(box[name]), np.nan, box[name])
            beyond = (told - inside) * [1.0, -1.0, 1.0, -1.0]
            errors = beyond / np.fmax(unit, UNIT * np.maximum(1.0, np.abs(inside)))
            yield f"{name} in a box", errors, box[name], inside


def _as_many(numbers: Array, shape: tuple[int, ...]) -> Array:
    """Numbers of a region in a shape, infinite where it has not as many as its functions want."""
    is_whole = numbers.size == np.prod(shape)
    return numbers.reshape(shape).copy() if is_whole else np.full(shape, np.inf)


def _columns(known: Mapping[str, Array]) -> Iterator[tuple[str, list[Array]]]:
    """Values, rates and units (n, 1) of the functions of each region."""
    for name, rows in known.items():
        yield name, np.split(rows, 3, axis=1)


def _bounds(
    least: Array, most: Array, known: Mapping[str, Array], w: Workspace
) -> dict[str, Array]:
    """Bounds (n, 4) by region of known functions, where what is read, time first, is in a box."""
    ends = np.stack((least, most), axis=-1).ravel()
    numbers = [*ends[:2], *ends[6:]]  # of the time no rate
    for region in (w.span, w.law_span, w.ranges):
        region[:] = numbers[: len(region)]  # scenes lack some of them
    for segment in SEGMENTS:
        w.run(segment)
    return {name: _as_many(getattr(w, name), (len(rows), 4)) for name, rows in known.items()}


def _row(name: str, number: int, errors: Array, got: Array, wanted: Array) -> Row:
    """Worst error (n, 1) or (n, 4) of a region; where nothing is known, or told, there is none."""
    known = np.where(np.isnan(errors), 0.0, errors)
    k, part = np.unravel_index(int(np.argmax(known)), known.shape)
    return Row(
        kernel=KERNEL,
        output=name,
        way=NAMES["numpy"],
        worst=max(0.0, float(known[k, part])),
        element=(int(k), int(part)),
        point=number,
        label="drawn",
        inputs=(),
        got=float(got[k, part]),
        wanted=float(wanted[k, part]),
    )
