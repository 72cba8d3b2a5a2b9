"""Words for a run whose rows nearly depend on each other with its parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..messages import scene_key
from .settings import CLEARLY

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from .arithmetic import Array

#: Rows that hold a smaller part of the most are not named with it.
LEAST_SHOWN_SHARE = 1e-3
#: Less than this is shown as nothing.
ROUNDING_OF_DEPENDENCE = 1e-12
#: Joints that a text names.
SHOWN = 3


def nearly_dependent(
    name: str,
    rows: Sequence[Sequence[str]],
    places: Mapping[str, Sequence[int]],
    work: Array,
    tolerance: float,
) -> str:
    """Message that refuses a run whose rows nearly depend on each other.

    Parameters
    ----------
    name : str
        What the message is on: the scene, and its parameters.
    rows : sequence of (str, str)
        Joint and unit of each row that is checked.
    places : mapping of str to (int, int)
        Where regions are in the memory for work, and how large.
    work : (work_size,) array
        In which rows that are not independent have what they hold beyond others [m, rad].
    tolerance : float [-]
        The closure tolerance.
    """
    first, _ = places.get("C") or places["C_left_out"]
    missed = work[first : first + len(rows)]
    worst: dict[str, str] = {}
    for k in np.argsort(-missed).tolist():
        if missed[k] > LEAST_SHOWN_SHARE * missed.max():
            (joint, unit), size = rows[k], missed[k] if missed[k] > ROUNDING_OF_DEPENDENCE else 0.0
            worst.setdefault(joint, f"{size:.3g} {unit} of {scene_key(joint)}")
    held = ", ".join([*worst.values()][:SHOWN])
    return (
        f"{name}: rows of joints that are independent with the parameters of the scene are nearly"
        f" redundant: beyond all others they hold {held} for each length or radian that bodies"
        f" move, and are independent above {CLEARLY * tolerance:.3g} only; rows are chosen for the"
        " values of the scene: write these ones into its file, and generate it again"
    )
