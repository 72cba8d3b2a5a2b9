"""Drivers of a scene: coordinates and points as functions of time."""

from __future__ import annotations

from math import copysign, nan, sqrt, tau
from typing import TYPE_CHECKING

from kousoku.model.linkage.input_motion import turns_of
from kousoku.model.records.spatial import Driver

if TYPE_CHECKING:
    from kousoku.model.records.planar import Input
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Value


SMALLEST = 50
"""Negative exponent of the smallest number that is written as one."""


def drivers_of(scene: Scene) -> dict[str, Driver]:
    """Drivers of a spatial scene by name, and its inputs as drivers."""
    inputs = {
        name: Driver(joint=given.joint, value=law_of(given))
        for name, given in scene.inputs.items()
        if given.joint is not None
    }
    return {**scene.drivers, **inputs}


def law_of(given: Input) -> str:
    """Formula start + rate t + ½ acceleration t² of an input, in rad or the unit of the scene."""
    start, rate, acceleration = map(formula_text, (given.start, given.rate, given.acceleration))
    return f"{start} + {rate}*t + {acceleration}/2*t^2"


def way_of(given: Input) -> float:
    """Way of an input with its sign, 2π turns or to − start [rad or unit of the scene]."""
    turns = turns_of(given)
    if turns is not None:
        return tau * turns
    assert given.to is not None
    return given.to - given.start


def time_of(given: Input, part: float) -> float:
    """Time [s] at which an input has gone a part of its way, from 0 to 1; not a number if never.

    It is the first t at which rate t + ½ acceleration t² = part · way. An input that first goes
    the other way never does.
    """
    way = way_of(given)
    sign = copysign(1.0, way)
    rate, acceleration, way = sign * given.rate, sign * given.acceleration, abs(way)
    square = rate * rate + 2 * acceleration * way * part
    if way == 0 or rate < 0 or (rate == 0 and acceleration <= 0) or square < 0:
        return nan
    return 2 * way * part / (rate + sqrt(square)) if part else 0.0


def times_of(scene: Scene) -> list[float] | None:
    """Times at which the inputs of a spatial scene take their values.

    Returns
    -------
    (divisions + 1,) list of float [s], or None
        One time for each division 0 … ``divisions``; none where the scene has no inputs.
    """
    given = next(iter(scene.inputs.values()), None)
    if given is None:
        return None
    return [time_of(given, k / scene.divisions) for k in range(scene.divisions + 1)]


def formula_text(value: Value) -> str:
    """Value as a formula; what is too small for a number of the grammar as a quotient."""
    if isinstance(value, str):
        return value
    digits, _, exponent = repr(value).partition("e-")
    power = int(exponent or 0)
    if power <= SMALLEST:
        return repr(value)
    return digits + f"/1e{SMALLEST}" * (power // SMALLEST) + f"/1e{power % SMALLEST}"
