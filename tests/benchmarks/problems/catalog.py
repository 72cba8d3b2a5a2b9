"""All problems, in the order of the page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.benchmarks.problems import andrews, closed, driven, n_four_bar, pendulum, top, trees

if TYPE_CHECKING:
    from tests.benchmarks.problems.problem import BenchmarkProblem

PROBLEMS: dict[str, BenchmarkProblem] = {
    one.name: one
    for one in (
        pendulum.PROBLEM,
        andrews.PROBLEM,
        *n_four_bar.PROBLEMS,
        *top.PROBLEMS,
        *trees.PROBLEMS,
        *closed.PROBLEMS,
        driven.PROBLEM,
    )
}
