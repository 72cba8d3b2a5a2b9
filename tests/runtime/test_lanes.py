"""The lanes layout: packing and unpacking blocks."""

from __future__ import annotations

import numpy as np
import pytest

from kousoku.runtime import from_lanes, to_lanes


def test_an_element_of_all_lanes_of_a_block_lies_together() -> None:
    values = np.arange(12.0).reshape(6, 2)
    blocks = to_lanes(values, 4)
    np.testing.assert_array_equal(blocks[0], [[0, 2, 4, 6], [1, 3, 5, 7]])
    np.testing.assert_array_equal(blocks[1], [[8, 10, 10, 10], [9, 11, 11, 11]])
    assert blocks.flags.c_contiguous


@pytest.mark.parametrize("shape", [(), (3,), (2, 12)])
@pytest.mark.parametrize("n", [0, 1, 7, 8, 9])
def test_unpacking_undoes_packing(rng: np.random.Generator, n: int, shape: tuple[int, ...]) -> None:
    values = rng.standard_normal((n, *shape))
    blocks = to_lanes(values, 8)
    assert blocks.shape == (-(-n // 8), *shape, 8)
    back = from_lanes(blocks, n)
    np.testing.assert_array_equal(back, values)
    assert back.flags.c_contiguous
    assert from_lanes(blocks).shape == (8 * len(blocks), *shape)
