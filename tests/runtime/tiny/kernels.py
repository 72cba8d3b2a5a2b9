"""The smallest package that has a scalar input, a structural zero and two outputs."""

from __future__ import annotations

from typing import Any

import numpy as np

DIGEST = "=DIGEST="


def sphere(
    r: Any, length: Any, *, out: Any = None, outputs: tuple[str, ...] = ("C", "C_q")
) -> tuple[Any, ...]:
    """C = length (r·r), and its derivative with a zero behind it."""
    r, length = np.asarray(r), np.asarray(length)
    batch = np.broadcast_shapes(r.shape[:-1], length.shape)
    if out is None:
        shapes = {"C": (*batch, 1), "C_q": (*batch, 1, 4)}
        out = tuple(np.empty(shapes[name]) if name in outputs else None for name in shapes)
    x, y, z = r[..., 0], r[..., 1], r[..., 2]
    if out[0] is not None:
        out[0][..., 0] = length * (x * x + y * y + z * z)
    if out[1] is not None:
        t0 = length + length
        for k, component in enumerate((x, y, z)):
            out[1][..., 0, k] = t0 * component
        out[1][..., 0, 3] = 0.0
    return tuple(array for array in out if array is not None)
