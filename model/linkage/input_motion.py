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


def turns_of(given: Input) -> float | None:
    """Turns [-] of an input that is described by turns, else None.

    An input of a link or of a joint with neither ``to`` nor ``turns`` makes one turn.
    """
    if given.turns is not None:
        return float(given.turns)
    return 1.0 if given.slider is None and given.to is None else None


def input_values(given: Input, divisions: int, ks: Sequence[int] | np.ndarray) -> np.ndarray:
    """Values of an input at the divisions `ks`, angles with whole turns taken off.

    With N turns over n divisions the angle at division k is from + 2π·frac(N k / n), where the
    fraction is taken before anything is rounded: the same division of every turn has the same
    angle, bit for bit.

    Parameters
    ----------
    given : Input
        The prescribed motion.
    divisions : int
        Steps from the first to the last value.
    ks : (n,) int
        Divisions, beyond `divisions` too.

    Returns
    -------
    (n,) ndarray [rad or unit of the scene]
    """
    turns = turns_of(given)
    k = np.asarray(ks)
    if turns is None:
        to = given.start if given.to is None else given.to
        return given.start + (to - given.start) * (k / divisions)
    fraction = Fraction(turns) / divisions
    if abs(fraction.numerator) * int(k.max(initial=1)) < 2**62 and fraction.denominator < 2**53:
        part = (k * fraction.numerator) % fraction.denominator / fraction.denominator
    else:  # no division of a later turn meets one of the first
        part = k * turns / divisions % 1
    return given.start + tau * part


def period(scene: Scene) -> int:
    """Period of all positions in divisions, at most the divisions of the scene."""
    repeats = 1
    for given in scene.inputs.values():
        turns = turns_of(given)
        if turns is None or not turns.is_integer():
            return scene.divisions
        own = scene.divisions // gcd(int(turns), scene.divisions)
        repeats = repeats * own // gcd(repeats, own)
    return min(repeats, scene.divisions)
