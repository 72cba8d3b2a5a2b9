"""Drivers of a scene, its inputs included: coordinates and points as functions of time."""

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
"""Negative decimal exponent of the smallest number that is written without a quotient."""


def drivers_of(scene: Scene) -> dict[str, Driver]:
    """Drivers of a spatial scene by name, and its inputs as drivers."""
    inputs = {
        name: Driver(joint=motion.joint, value=law_of(motion))
        for name, motion in scene.inputs.items()
        if motion.joint is not None
    }
    return {**scene.drivers, **inputs}


def law_of(motion: Input) -> str:
    """Formula start + rate t + ½ acceleration t² of an input, in rad or the unit of the scene."""
    start, rate, acceleration = map(formula_text, (motion.start, motion.rate, motion.acceleration))
    return f"{start} + {rate}*t + {acceleration}/2*t^2"


def travel_of(motion: Input) -> float:
    """Signed travel of an input from first to last value, 2π turns or to − start [rad or unit]."""
    turns = turns_of(motion)
    if turns is not None:
        return tau * turns
    assert motion.to is not None
    return motion.to - motion.start


def time_of(motion: Input, fraction: float) -> float:
    """Time [s] at which an input has gone a fraction of its travel, 0 to 1; not a number if never.

    It is the first t at which rate t + ½ acceleration t² = fraction · travel. An input that first
    starts in the other direction never does.
    """
    travel = travel_of(motion)
    sign = copysign(1.0, travel)
    rate, acceleration, travel = sign * motion.rate, sign * motion.acceleration, abs(travel)
    square = rate * rate + 2 * acceleration * travel * fraction
    if travel == 0 or rate < 0 or (rate == 0 and acceleration <= 0) or square < 0:
        return nan
    return 2 * travel * fraction / (rate + sqrt(square)) if fraction else 0.0


def times_of(scene: Scene) -> list[float] | None:
    """Times at which the inputs of a spatial scene take their values.

    Returns
    -------
    (divisions + 1,) list of float [s], or None
        One time for each division 0 … ``divisions``; none where the scene has no inputs.
    """
    motion = next(iter(scene.inputs.values()), None)
    if motion is None:
        return None
    return [time_of(motion, k / scene.divisions) for k in range(scene.divisions + 1)]


def formula_text(value: Value) -> str:
    """Value as a formula; a number that is too small for the grammar becomes a quotient."""
    if isinstance(value, str):
        return value
    digits, _, exponent = repr(value).partition("e-")
    power = int(exponent or 0)
    if power <= SMALLEST:
        return repr(value)
    return digits + f"/1e{SMALLEST}" * (power // SMALLEST) + f"/1e{power % SMALLEST}"
