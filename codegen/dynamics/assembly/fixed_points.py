"""Anderson acceleration: from the last few steps, the combination nearest to a fixed point."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.numbers.real import Array

#: Steps that are remembered.
DEPTH = 6
#: Relative singular value below which differences count as dependent in the least squares.
SINGULAR = 1e-6


class AndersonAcceleration:
    """Anderson's acceleration of x ← g(x), in doubles or in 50 digits.

    Parameters
    ----------
    weights : array
        Weights of the components in the norm of differences.
    """

    def __init__(self, weights: Array) -> None:
        self._weights = weights
        self._values: list[Any] = []
        self._changes: list[Any] = []

    def next(self, x: Sequence[Any] | Array, value: Sequence[Any] | Array) -> Any:
        """Point at which g shall be evaluated next, an array of numbers of the same kind.

        Parameters
        ----------
        x, value : (n,)
            The last point of evaluation, and g there.
        """
        following = np.asarray(value)
        self._values.append(following)
        self._changes.append(following - np.asarray(x))
        del self._values[:-DEPTH], self._changes[:-DEPTH]
        if len(self._values) == 1:
            return following
        pairs = list(zip(self._changes[1:], self._changes, strict=False))
        differences = np.array([self._weighed(a - b) for a, b in pairs]).T
        sizes = np.sqrt((differences * differences).sum(axis=0))
        if not sizes.all():
            return following
        change = self._weighed(self._changes[-1])
        factors = np.linalg.lstsq(differences / sizes, change, SINGULAR)[0] / sizes
        for factor, b, a in zip(factors.tolist(), self._values, self._values[1:], strict=False):
            following = following - factor * (a - b)
        return following

    def _weighed(self, x: Any) -> Array:
        """Numbers as doubles, weighed, of any size."""
        weighed: Array = np.array([float(component) for component in x]) * self._weights
        return weighed
