"""The two rows that p1 and p2 keep: the rule of lecture 8.2, applied in the frame of body i."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from kousoku.model.errors import DerivationError

if TYPE_CHECKING:
    from collections.abc import Iterable

#: The rows of ã′ that hold the component of the named axis, by number from 0.
ROWS = {"x": (1, 2), "y": (0, 2), "z": (0, 1)}


def variant(kind: str, axis: Iterable[float]) -> str:
    """Package whose rows hold the largest component of an axis, such as ``p2_z``.

    The axis is constant in its body, so that one choice serves for a whole run (8.16).

    Parameters
    ----------
    kind : str
        ``p1`` or ``p2``.
    axis : (3,) iterable of float
        a′ of body i in the frame of i, of any unit and of any length but zero. Of components that
        are equally large the first is taken.

    Raises
    ------
    DerivationError
        The kind has no variants, or the axis no direction.
    """
    if kind not in {"p1", "p2"}:
        raise DerivationError(f"kind {kind!r} has no variants; wanted 'p1' or 'p2'")
    components = [float(x) for x in axis]
    sizes = [abs(x) for x in components]
    if len(sizes) != len(ROWS) or not all(map(math.isfinite, sizes)) or not any(sizes):
        raise DerivationError(
            f"{kind}: the axis of body i is {components}; wanted three finite "
            "components, not all zero"
        )
    return f"{kind}_{'xyz'[sizes.index(max(sizes))]}"
