"""The contest: two-row p2 with all of C and C_q, 26 numbers from 23 run-time arguments.

Every program gets the same formula (lecture 8.2, (8.16), on homogeneous Euler parameters), with
what it has in common written once, so that no peer pays for a clumsy statement of the problem.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.codegen.freeze_components import freeze_components
from kousoku.model.numbers.dual import evaluate_dual
from kousoku.symbolic.components import cross
from kousoku.symbolic.kinds import derive
from kousoku.symbolic.matrices import quadratic_form
from tests.benchmarks.limits import aligned

if TYPE_CHECKING:
    from collections.abc import Callable

PACKAGE = "p2_z"
#: Inputs by name and size; the rows are those of the largest component of a, here z.
SIZES = {"r_i": 3, "p_i": 4, "a_i_b": 3, "s_i_b": 3, "r_j": 3, "p_j": 4, "s_j_b": 3}
N_IN, N_OUT = sum(SIZES.values()), 26
#: Evaluations whose error is measured.
SAMPLE = 48

Vector = list[Any]


def p2(
    r_i: Vector, p_i: Vector, a: Vector, s_i: Vector, r_j: Vector, p_j: Vector, s_j: Vector
) -> tuple[Vector, list[Vector]]:
    """C and the rows of C_q over any numbers that can be added and multiplied.

    C = S ã A_iᵀ (r_j + A_j s_j − r_i − A_i s_i), and with y = A_iᵀ (r_j + A_j s_j − r_i) the blocks
    of C_q are −S ã A_iᵀ, S ã ỹ, S ã A_iᵀ, −S ã A_iᵀ A_j s̃_j; S keeps the rows x and y.
    """
    to_i, a_j = _transposed(quadratic_form(p_i)), quadratic_form(p_j)
    far = [r + x - o for r, x, o in zip(r_j, _times(a_j, s_j), r_i, strict=True)]
    y = [_dot(row, far) for row in to_i]
    length = _dot(p_i, p_i)
    d = [x - length * length * s for x, s in zip(y, s_i, strict=True)]
    moved = _transposed([cross(row, s_j) for row in a_j])  # A_j s̃_j
    c, rows = [], []
    for k in (0, 1):
        c.append(_row(a, k, d))
        block = [_row(a, k, column) for column in _transposed(to_i)]
        turn_i = _turned(a, k, y)
        turn_j = [-_dot(block, column) for column in moved]
        rows.append([*(-x for x in block), *turn_i, *block, *turn_j])
    return c, rows


def _transposed(rows: list[Vector]) -> list[Vector]:
    return [list(column) for column in zip(*rows, strict=True)]


def _dot(a: Vector, b: Vector) -> Any:
    total = a[0] * b[0]
    for x, y in zip(a[1:], b[1:], strict=True):
        total = total + x * y
    return total


def _times(matrix: list[Vector], x: Vector) -> Vector:
    return [_dot(row, x) for row in matrix]


def _row(a: Vector, k: int, x: Vector) -> Any:
    """Row k of ã x."""
    return a[1] * x[2] - a[2] * x[1] if k == 0 else a[2] * x[0] - a[0] * x[2]


def _turned(a: Vector, k: int, y: Vector) -> Vector:
    """Row k of ã ỹ."""
    if k == 0:
        return [-(a[1] * y[1] + a[2] * y[2]), a[1] * y[0], a[2] * y[0]]
    return [a[0] * y[1], -(a[0] * y[0] + a[2] * y[2]), a[2] * y[1]]


def symbols(make: Callable[[str], Any]) -> list[Vector]:
    """23 arguments, array by array, as symbols of some system."""
    return [[make(f"{name}_{k}") for k in range(size)] for name, size in SIZES.items()]


def inputs(n: int) -> list[np.ndarray]:
    """Inputs of n ordinary evaluations, row-major: unit quaternions, lengths of order one.

    The first evaluations are the same for every n, and every array begins a cache line.
    """
    table = np.random.default_rng(1981).normal(size=(n, N_IN))
    parts = np.split(table, np.cumsum([*SIZES.values()])[:-1], axis=1)
    return [
        aligned(part / np.linalg.norm(part, axis=1, keepdims=True) if name[0] == "p" else part)
        for name, part in zip(SIZES, parts, strict=True)
    ]


class Judge:
    """Measures errors against 50 digits, in the unit u·(|f| + Σ|x_i ∂f/∂x_i|), u = 2⁻⁵³."""

    def __init__(self) -> None:
        function = next(f for f in derive(PACKAGE).functions if f.name == "constraint")
        components = freeze_components(function)
        self.inputs = inputs(SAMPLE)
        self._wanted = []
        for k in range(SAMPLE):
            point = {name: x[k].tolist() for name, x in zip(SIZES, self.inputs, strict=True)}
            duals = evaluate_dual(components, point)
            for place, dual in enumerate([*duals["C"], *duals["C_q"]]):
                moved = sum(abs(point[name][i] * x) for (name, i), x in dual.gradient.items())
                unit = 2.0**-53 * float(abs(dual.value) + moved)
                self._wanted.append((k, place, dual.value, unit))

    def worst(self, c: np.ndarray, c_q: np.ndarray) -> float:
        """Largest error of the sample, C (n, 2) and C_q (n, 2, 12), in units."""
        numbers = np.concatenate([c[:SAMPLE], c_q[:SAMPLE].reshape(-1, 24)], axis=1)
        return max(
            float(abs(value - numbers[k, place])) / unit for k, place, value, unit in self._wanted
        )
