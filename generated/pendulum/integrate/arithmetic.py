"""Comparisons and sums that say what becomes of a NaN and of rounding."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from typing import TypeAlias

    import numpy.typing as npt

    Array: TypeAlias = npt.NDArray[np.float64]


def larger(a: float, b: float) -> float:
    """Larger of two numbers, the second if the first is a NaN."""
    return a if a > b else b


def smaller(a: float, b: float) -> float:
    """Smaller of two numbers, the second if the first is a NaN."""
    return a if a < b else b


def rounding_of_sum(a: Array, b: Array, total: Array) -> Array:
    """Remainder (a + b) − total of arrays (n,), in their unit, that rounding left over, exactly.

    Knuth's TwoSum.
    """
    part = total - a
    return (a - (total - part)) + (b - part)


def mean_square(x: Array, count: int) -> float:
    """Mean square Σ xᵢ² / count of x (n,), in its unit squared, n at least 1.

    It is added up in the order of C: both take equal steps.
    """
    return float(np.cumsum(x * x)[-1]) / count
