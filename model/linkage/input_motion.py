"""Values of the inputs at the divisions of a motion, with whole turns counted exactly."""

from __future__ import annotations

from fractions import Fraction
from math import gcd, tau
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.records.planar import Input
    from kousoku.model.records.scene import Scene


def turns_of(motion: Input) -> float | None:
    """Turns [-] of an input that is described by turns, else None.

    An input of a link or of a joint with neither ``to`` nor ``turns`` makes one turn.
    """
    if motion.turns is not None:
        return float(motion.turns)
    return 1.0 if motion.slider is None and motion.to is None else None


def input_values(motion: Input, divisions: int, ks: Sequence[int] | np.ndarray) -> np.ndarray:
    """Values of an input at the divisions `ks`, angles with whole turns taken off.

    With N turns over n divisions the angle at division k is from + 2π·frac(N k / n), where the
    fraction is taken before anything is rounded: the same division of every turn has the same
    angle, bit for bit.

    Parameters
    ----------
    motion : Input
        The prescribed motion.
    divisions : int
        Steps from the first to the last value.
    ks : (n,) int
        Divisions, beyond `divisions` too.

    Returns
    -------
    (n,) ndarray [rad or unit of the scene]
    """
    turns = turns_of(motion)
    k = np.asarray(ks)
    if turns is None:
        end = motion.start if motion.to is None else motion.to
        return motion.start + (end - motion.start) * (k / divisions)
    fraction = Fraction(turns) / divisions
    if abs(fraction.numerator) * int(k.max(initial=1)) < 2**62 and fraction.denominator < 2**53:
        fraction_of_turn = (k * fraction.numerator) % fraction.denominator / fraction.denominator
    else:  # no division of a later turn meets one of the first
        fraction_of_turn = k * turns / divisions % 1
    return motion.start + tau * fraction_of_turn


def period(scene: Scene) -> int:
    """Period of all positions in divisions, at most the divisions of the scene."""
    common_period = 1
    for motion in scene.inputs.values():
        turns = turns_of(motion)
        if turns is None or not turns.is_integer():
            return scene.divisions
        input_period = scene.divisions // gcd(int(turns), scene.divisions)
        common_period = common_period * input_period // gcd(common_period, input_period)
    return min(common_period, scene.divisions)
