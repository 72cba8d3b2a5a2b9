"""The rule that chooses the two rows of p1 and p2."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from kousoku.generated.kinds import p1_x, p1_y, p1_z, p2_x, p2_y, p2_z
from kousoku.model.errors import DerivationError
from kousoku.model.mechanics.parallel_rows import variant

P1 = {"p1_x": p1_x, "p1_y": p1_y, "p1_z": p1_z}
P2 = {"p2_x": p2_x, "p2_y": p2_y, "p2_z": p2_z}


@pytest.mark.parametrize(
    ("axis", "chosen"),
    [
        ((-3.0, 2.0, 1.0), "x"),
        ((1.0, -3.0, 2.0), "y"),
        ((1.0, 2.0, -3.0), "z"),
        ((1.0, -1.0, 1.0), "x"),
        ((0.0, 1.0, -1.0), "y"),
        ((0.0, 0.0, 5e-324), "z"),
    ],
)
def test_the_largest_component_chooses_and_of_equal_ones_the_first(
    axis: tuple[float, float, float], chosen: str
) -> None:
    assert variant("p1", axis) == f"p1_{chosen}"
    assert variant("p2", np.array(axis)) == f"p2_{chosen}"


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("axis", list(product((-1.0, 0.25, 2.0), repeat=3)))
def test_the_rows_that_are_kept_are_independent(axis: tuple[float, float, float]) -> None:
    still, r_j = np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.3, -0.2, 0.7])
    zero = np.zeros(3)
    _, jacobian = P2[variant("p2", axis)].constraint(zero, still, axis, zero, r_j, still, zero)
    largest, smallest = np.linalg.svd(jacobian[:, 6:9], compute_uv=False)
    assert smallest > 0.5 * largest
    c, jacobian = P1[variant("p1", axis)].constraint(still, axis, still, axis)
    largest, smallest = np.linalg.svd(jacobian[:, 9:12], compute_uv=False)
    np.testing.assert_allclose(c, 0, atol=1e-15)
    assert smallest > 0.5 * largest


@pytest.mark.parametrize(
    "axis", [(0.0, 0.0, 0.0), (1.0, 0.0), (1.0, float("nan"), 0.0), (float("inf"), 0.0, 0.0)]
)
def test_an_axis_without_direction_is_refused(axis: tuple[float, ...]) -> None:
    with pytest.raises(DerivationError, match=r"p2: the axis of body i is .*; wanted three finite"):
        variant("p2", axis)


def test_kinds_without_variants_are_refused() -> None:
    with pytest.raises(DerivationError, match="kind 'n1' has no variants; wanted 'p1' or 'p2'"):
        variant("n1", (1.0, 0.0, 0.0))
