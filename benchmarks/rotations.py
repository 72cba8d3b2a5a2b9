"""Rotations of rows of vectors, by rows of Euler parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.runtime.integrate import body_tables

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Array = npt.NDArray[np.float64]


def rotated(p: Array, v: Array) -> Array:
    """Matrix A(p) v for rows of Euler parameters of norm one, and of vectors."""
    return body_tables.rotated(p.T, v.T).T


def composed(p: Array, q: Array) -> Array:
    """Products p∘q for rows of Euler parameters, scalar first."""
    return body_tables.composed(p.T, q.T).T
