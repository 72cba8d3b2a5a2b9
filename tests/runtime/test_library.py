"""Loading a generated folder."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
import pytest

from kousoku.runtime import load

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.usefixtures("cache")


@pytest.mark.parametrize("target", ["c", "numpy"])
def test_a_loaded_kernel_computes(tiny: Path, target: Literal["c", "numpy"]) -> None:
    library = load(tiny, target=target)
    C, C_q = library.sphere([1, 2, 3], 2)
    assert library.target == target
    np.testing.assert_array_equal(C, [28.0])
    np.testing.assert_array_equal(C_q, [[4.0, 8.0, 12.0, 0.0]])
