"""Rotations by Euler parameters of all bodies at once: components first, bodies, then rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .arithmetic import Array

#: Signs that make Euler parameters those of the opposite rotation.
BACK = np.array([1.0, -1.0, -1.0, -1.0])


def crossed(a: Array, b: Array) -> Array:
    """Product a × b (3, ·) of vectors in one frame, components first; its unit is that of a b."""
    return np.stack(
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    )


def rotated(p: Array, v: Array) -> Array:
    """Vectors A(p) v (3, ·) for Euler parameters of norm one, components first.

    v, of any unit, is in the body frame, A v in frame O: v + 2 e₀ (e × v) + 2 e × (e × v).
    """
    t = 2.0 * crossed(p[1:], v)
    turned: Array = v + p[0] * t + crossed(p[1:], t)
    return turned


def composed(p: Array, q: Array) -> Array:
    """Product p∘q (4, ·) of Euler parameters [-], components first, of these the scalar.

    It is (p₀ q₀ − p·q, p₀ q + q₀ p + p × q): q takes a frame to the one that p takes further.
    """
    scalar = p[0] * q[0] - (p[1] * q[1] + p[2] * q[2] + p[3] * q[3])
    vector = p[0] * q[1:] + q[0] * p[1:] + crossed(p[1:], q[1:])
    return np.concatenate([scalar[np.newaxis], vector])
