"""Fixed points found in fewer steps: from the last few, the combination that was nearest to one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.numbers.real import Array

#: How many steps are remembered.
DEPTH = 6
#: What is smaller in the least squares, relative to the largest, says nothing.
SINGULAR = 1e-6


class Accelerated:
    """Anderson's acceleration of x ← g(x), in doubles or in 50 digits.

    Parameters
    ----------
    weights : array
        What a component weighs where differences are compared.
    """

    def __init__(self, weights: Array) -> None:
        self._weights = weights
        self._values: list[Any] = []
        self._changes: list[Any] = []

    def next(self, x: Sequence[Any] | Array, value: Sequence[Any] | Array) -> Any:
        """Point where g shall be evaluated next, an array of the numbers that it was given.

        Parameters
        ----------
        x, value : (n,)
            Where it was evaluated last, and g there.
        """
        here = np.asarray(value)
        self._values.append(here)
        self._changes.append(here - np.asarray(x))
        del self._values[:-DEPTH], self._changes[:-DEPTH]
        if len(self._values) == 1:
            return here
        pairs = list(zip(self._changes[1:], self._changes, strict=False))
        differences = np.array([self._weighed(a - b) for a, b in pairs]).T
        sizes = np.sqrt((differences * differences).sum(axis=0))
        if not sizes.all():
            return here
        change = self._weighed(self._changes[-1])
        factors = np.linalg.lstsq(differences / sizes, change, SINGULAR)[0] / sizes
        for factor, b, a in zip(factors.tolist(), self._values, self._values[1:], strict=False):
            here = here - factor * (a - b)
        return here

    def _weighed(self, x: Any) -> Array:
        """Numbers as doubles, weighed, of any size."""
        weighed: Array = np.array([float(component) for component in x]) * self._weights
        return weighed
