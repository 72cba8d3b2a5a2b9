"""LU factorisation: solutions, and a pivot that tells side and distance of a singularity."""

from __future__ import annotations

import numpy as np
import pytest

from kousoku.runtime.kinematics.lu import LU


@pytest.mark.parametrize("n", [1, 2, 3, 6])
def test_solution_solves_the_equations(rng: np.random.Generator, n: int) -> None:
    for _ in range(20):
        matrix, right = rng.normal(size=(n, n)), rng.normal(size=n)
        solution = LU(matrix.copy(), np.ones(n)).solve(right)
        np.testing.assert_allclose(matrix @ solution, right, rtol=0, atol=1e-11)


def test_pivot_has_the_sign_of_the_determinant(rng: np.random.Generator) -> None:
    for _ in range(50):
        matrix = rng.normal(size=(4, 4))
        assert LU(matrix.copy(), np.ones(4)).pivot * np.linalg.det(matrix) > 0


def test_pivot_is_the_smallest_of_columns_scaled_to_lengths() -> None:
    assert LU(np.diag([2.0, 30.0]), np.array([1.0, 10.0])).pivot == 2.0
    assert LU(np.diag([2.0, -30.0]), np.array([1.0, 100.0])).pivot == -0.3
    assert LU(np.array([[0.0, 1.0], [1.0, 0.0]]), np.ones(2)).pivot == -1.0


def test_pivot_of_a_singular_matrix_is_zero() -> None:
    assert LU(np.array([[1.0, 2.0], [2.0, 4.0]]), np.ones(2)).pivot == 0.0
    assert LU(np.full((2, 2), np.nan), np.ones(2)).pivot == 0.0
