"""Segments in NumPy: the bits of C, one task at a time and many together."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from kousoku.runtime.integrate import tasks
from kousoku.runtime.integrate.tasks import MANY, TaskKernel, numbers, places, run_tasks, segment_of


def total(x: Any, m: Any) -> list[Any]:
    return [x[0] + x[1], m.sqrt(x[0] * x[1])]


SUM = TaskKernel(total, 3, places("0 0  1 0", 2), places("2 0  2 1", 2))


def test_a_table_ends_its_lines_with_what_they_belong_to() -> None:
    assert numbers("1.5 2 # rod: 7\n-3 # motor") == [1.5, 2.0, -3.0]
    assert places("1 2 # 9\n3 4", 2).tolist() == [[1, 2], [3, 4]]
    assert places("", 3).shape == (0, 3)


@pytest.mark.parametrize("count", [1, MANY - 1, MANY, 3 * MANY])
def test_few_and_many_tasks_compute_the_same_bits(count: int, rng: np.random.Generator) -> None:
    w = np.concatenate((rng.uniform(1e-3, 1e3, 2 * count), np.zeros(2 * count)))
    table = " ".join(f"{2 * k} {2 * k + 1} {2 * count + 2 * k}" for k in range(count))
    expected = [y for k in range(count) for y in total(w[2 * k : 2 * k + 2].tolist(), math)]
    segment = segment_of([SUM], f"0 {count} {table}")
    assert len(segment) == 1
    run_tasks(w, segment)
    assert w[2 * count :].tolist() == expected


def test_a_task_reads_what_the_one_before_wrote() -> None:
    w = np.array([2.0, 8.0, 0.0, 0.0, 0.0, 0.0])
    run_tasks(w, segment_of([SUM], "0 2  0 1 2  2 3 4"))
    assert w.tolist() == [2.0, 8.0, 10.0, 4.0, 14.0, math.sqrt(40.0)]


def test_a_kernel_that_reads_nothing_writes_its_numbers() -> None:
    kernel = TaskKernel(lambda _x, _m: [0.5], 1, places("", 2), places("0 0", 2))
    w = np.zeros(2)
    run_tasks(w, segment_of([kernel], "0 1 1"))
    assert w.tolist() == [0.0, 0.5]


@pytest.mark.parametrize(
    ("value", "wanted"), [(0.0, math.inf), (-1.0, math.nan), (math.inf, math.nan)]
)
def test_what_no_number_comes_out_of_gives_infinities_and_nan_as_in_c(
    value: float, wanted: float
) -> None:
    def kernel(x: Any, m: Any) -> list[Any]:
        return [m.cos(x[0]) / (m.sqrt(x[0]) * m.fabs(x[0]))]

    w = np.array([value, 0.0])
    with np.errstate(all="ignore"):
        run_tasks(
            w, segment_of([TaskKernel(kernel, 2, places("0 0", 2), places("1 0", 2))], "0 1 0 1")
        )
    np.testing.assert_equal(w[1], wanted)


def test_functions_of_arrays_have_the_bits_of_those_of_floats(rng: np.random.Generator) -> None:
    x, y = rng.uniform(0.0, 7.0, size=(2, 2000))
    for name in ("sqrt", "sin", "cos", "exp", "log"):
        wanted = [getattr(math, name)(value) for value in x]
        np.testing.assert_array_equal(getattr(tasks.OF_ARRAYS, name)(x), wanted, err_msg=name)
    wanted = [math.atan2(*pair) for pair in zip(x, y, strict=True)]
    np.testing.assert_array_equal(tasks.OF_ARRAYS.atan2(x, y), wanted)
    np.testing.assert_array_equal(tasks.OF_ARRAYS.atan2(0.0, -x), np.full(len(x), math.pi))
    with np.errstate(all="ignore"):
        np.testing.assert_array_equal(tasks.OF_ARRAYS.log(np.array([0.0, 1.0])), [-np.inf, 0.0])


def test_the_larger_of_a_number_and_a_nan_is_the_number_as_in_c() -> None:
    assert tasks.fmax(1.0, math.nan) == tasks.fmax(math.nan, 1.0) == 1.0
    assert tasks.fmax(1.0, 2.0) == tasks.fmax(2.0, 1.0) == 2.0
