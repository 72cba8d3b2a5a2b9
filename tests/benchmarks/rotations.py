"""Rotations of rows of vectors, by rows of Euler parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.runtime.integrate import euler_parameters

if TYPE_CHECKING:
    from kousoku.model.numbers.real import Array


def rotated(p: Array, v: Array) -> Array:
    """Vectors A(p) v in frame O: lecture 7.1, (4.3).

    Parameters
    ----------
    p : (n, 4) [-]
        Euler parameters of norm one, scalar first.
    v : (n, 3)
        Vectors in the body frame; the result has their unit.
    """
    return euler_parameters.rotated(p.T, v.T).T


def composed(p: Array, q: Array) -> Array:
    """Euler parameters (n, 4) of the turns q, then p: products p∘q.

    Parameters
    ----------
    p, q : (n, 4) [-]
        Euler parameters, scalar first.
    """
    return euler_parameters.composed(p.T, q.T).T
