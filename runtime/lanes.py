"""The lanes layout: blocks of as many evaluations as a vector register holds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from kousoku.runtime.arguments import Floats


def to_lanes(values: Floats, width: int) -> Floats:
    """Batch packed into blocks.

    Parameters
    ----------
    values : (n, *shape)
        The batch axis first, n at least 1 unless there is nothing to pack; in any units.
    width : int
        Lanes of a block, ``kernel.lane_width``.

    Returns
    -------
    (ceil(n / width), *shape, width) ndarray
        A last block that is not full repeats the last evaluation.
    """
    n = len(values)
    n_blocks = -(-n // width)
    rows = np.minimum(np.arange(n_blocks * width), n - 1)
    blocks = values[rows].reshape((n_blocks, width, *values.shape[1:]))
    return np.ascontiguousarray(np.moveaxis(blocks, 1, -1))


def from_lanes(blocks: Floats, n: int | None = None) -> Floats:
    """First ``n`` evaluations, all by default, with the batch axis first.

    Parameters
    ----------
    blocks : (n_blocks, *shape, width)
        Blocks as `to_lanes` packs them.
    n : int, optional
        Count of evaluations.
    """
    rows = np.moveaxis(blocks, -1, 1)
    return np.ascontiguousarray(rows.reshape((-1, *blocks.shape[1:-1]))[:n])
