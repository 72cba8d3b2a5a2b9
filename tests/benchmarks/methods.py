"""Methods: which needs the fewest evaluations to the error that a tolerance gives.

Counts, not times: what is chosen where no method is asked for (`method_for`) is the
same on every machine, and this question says whether it is still right.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kousoku.runtime.integrate.settings import LEAST_TOLERANCES, method_for
from tests.benchmarks.kit import (
    BenchmarkTarget,
    Case,
    Figures,
    Question,
    Record,
    Size,
    number,
    table,
)
from tests.benchmarks.problems.catalog import PROBLEMS
from tests.benchmarks.problems.problem import kousoku_call

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tests.benchmarks.race import Workers

#: Half a decade apart, so that errors in between are found by interpolation.
TOLERANCES = tuple(10.0 ** (-k / 2) for k in range(4, 25))
METHODS = tuple(LEAST_TOLERANCES)
#: The chosen method may need so many times the evaluations of the other, in the mean of problems:
#: near the tolerance where both need as many, either will do.
WORSE = 1.1


def contests(size: Size) -> list[str]:
    """Problems that both methods integrate in no more than a second."""
    return [
        name
        for name, one in PROBLEMS.items()
        if set(METHODS) <= set(one.methods) and not one.is_large and (size.is_full or one.is_quick)
    ]


def cases(_contest: str, _size: Size) -> list[Case]:
    """None: nothing is timed."""
    return []


def run(contest: str, _size: Size, _workers: Workers) -> list[Record]:
    """Evaluations and errors of both methods at all tolerances."""
    found = []
    for method in METHODS:
        for tolerance in TOLERANCES:
            judged = kousoku_call(PROBLEMS[contest], method, tolerance, "end").judge()
            names = (contest, "kousoku", method, f"{tolerance:.1e}")
            found.append(Record(*names, error=judged.error, extra=judged.extra))
    return found


class MethodChoice(NamedTuple):
    """Choice of a method by tolerance, in the geometric mean of problems.

    Parameters
    ----------
    tolerance : float
        That of both methods.
    errors : tuple of float
        Of positions, with ``dopri5`` and ``dop853``.
    ratio : float
        Evaluations of ``dopri5`` over those of ``dop853`` to the same error: the mean at the
        errors that both have.
    """

    tolerance: float
    errors: tuple[float, float]
    ratio: float

    @property
    def chosen(self) -> str:
        """The method that is chosen where none is asked for."""
        return method_for(self.tolerance, is_driven=False)

    @property
    def cost(self) -> float:
        """Evaluations of the chosen method over those of the other."""
        return self.ratio if self.chosen == METHODS[0] else 1.0 / self.ratio


def choices(records: Sequence[Record]) -> list[MethodChoice]:
    """Choices at each tolerance, as far as both methods reach the errors of each other."""
    found = []
    for tolerance in TOLERANCES:
        errors: list[list[float]] = [[], []]
        ratios = []
        for contest in dict.fromkeys(one.contest for one in records if one.line in METHODS):
            lines = [_line(records, contest, method) for method in METHODS]
            here = [line[TOLERANCES.index(tolerance)] for line in lines]
            for own, (error, _) in zip(errors, here, strict=True):
                own.append(error)
            for error, _ in here:
                first, second = (_to(line, error) for line in lines)
                if first and second:
                    ratios.append(first / second)
        if ratios:
            found.append(
                MethodChoice(tolerance, (_mean(errors[0]), _mean(errors[1])), _mean(ratios))
            )
    return found


def _line(records: Sequence[Record], contest: str, method: str) -> list[tuple[float, float]]:
    """Error and evaluations at all tolerances."""
    return [
        (one.error or math.nan, one.extra["evaluations"])
        for one in records
        if (one.contest, one.line) == (contest, method)
    ]


def _to(line: Sequence[tuple[float, float]], error: float) -> float | None:
    """Evaluations to an error, interpolated between tolerances; None beyond them.

    A tighter tolerance that happens to err more counts as if it erred as the looser one.
    """
    reached, counts = zip(*line, strict=True)
    least = np.minimum.accumulate(reached)
    if not least[-1] <= error <= least[0]:
        return None
    return float(np.exp(np.interp(-np.log(error), -np.log(least), np.log(counts))))


def _mean(values: Sequence[float]) -> float:
    """Geometric mean."""
    return float(np.exp(np.mean(np.log(values))))


def body(records: Sequence[Record], _figures: Figures) -> str:
    """Table from which methods are chosen."""
    rows = [
        [
            f"{one.tolerance:.0e}",
            *(number(error) for error in one.errors),
            f"{one.ratio:.2f}",
            one.chosen,
        ]
        for one in choices(records)
    ]
    heads = [f"error of {method}" for method in METHODS]
    return table(["tolerance", *heads, "dopri5 over dop853", "chosen"], rows) if rows else ""


def targets(records: Sequence[Record]) -> list[BenchmarkTarget]:
    """Targets of the choice, which is made from all problems: few of them say little."""
    measured = {one.contest for one in records if one.line in METHODS}
    if not measured.issuperset(contests(Size(is_full=True))):
        return []
    return [
        BenchmarkTarget(
            "all", f"evaluations of the method chosen at {one.tolerance:.0e}", one.cost, WORSE
        )
        for one in choices(records)
    ]


QUESTION = Question(
    title="Which method is chosen",
    asks=(
        "A run that asks for no method gets the one that needs fewer evaluations to the error that"
        " its tolerance gives. Errors are those of positions, as above, in the geometric mean of"
        " all problems that move freely; the ratio is that of evaluations to the same error, at"
        " the errors that both methods have with this tolerance. Nothing here depends on the"
        " machine. A motion that drivers determine is found position by position, `kinematics`."
    ),
    contests=contests,
    cases=cases,
    body=body,
    targets=targets,
    run=run,
)
