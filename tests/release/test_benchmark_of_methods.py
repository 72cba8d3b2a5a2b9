"""The benchmark of methods: the one that is chosen needs few evaluations to its error."""

from __future__ import annotations

import pytest

from kousoku.runtime.integrate.settings import method_for
from tests.benchmarks.kit import Record, Size
from tests.benchmarks.methods import METHODS, TOLERANCES, WORSE, choices, contests, run, targets
from tests.benchmarks.race import Workers


def made(orders: tuple[float, float], contest: str = "a") -> list[Record]:
    """Records of methods whose evaluations grow as a root of the error."""
    return [
        Record(
            contest,
            "kousoku",
            method,
            f"{x:.1e}",
            error=3 * x,
            extra={"evaluations": count * x ** (-1 / order)},
        )
        for method, order, count in zip(METHODS, orders, (50.0, 150.0), strict=True)
        for x in TOLERANCES
    ]


def test_the_ratio_is_that_of_evaluations_to_the_same_error() -> None:
    found = choices([*made((5.0, 8.0)), *made((5.0, 8.0), "b")])
    assert len(found) == len(TOLERANCES)
    for one in found:
        assert one.errors == pytest.approx((3 * one.tolerance, 3 * one.tolerance))
        assert one.ratio == pytest.approx(one.tolerance ** (1 / 8 - 1 / 5) / 3, rel=1e-6)


def test_a_choice_that_costs_more_misses_its_target() -> None:
    every = contests(Size(is_full=True))
    costly = [record for contest in every for record in made((5.0, 5.5), contest)]
    missed = [one for one in targets(costly) if not one.is_met]
    assert missed and all(one.value is not None and one.value > WORSE for one in missed)


def test_few_problems_do_not_judge_the_choice() -> None:
    few = contests(Size())
    assert not targets([record for contest in few for record in made((5.0, 5.5), contest)])


@pytest.mark.usefixtures("compiler")
def test_the_method_that_is_chosen_costs_least_on_quick_problems() -> None:
    size = Size()
    records = [
        record
        for contest in contests(size)
        for record in run(contest, size, Workers("tests.benchmarks.methods", size))
    ]
    found = choices(records)
    assert [one.chosen for one in found if one.tolerance > 2e-4] == ["dopri5"] * 4
    assert [one.chosen for one in found if one.tolerance < 5e-6] == ["dop853"] * len(
        [one for one in found if one.tolerance < 5e-6]
    )
    far = [one.cost for one in found if not 1e-6 < one.tolerance < 1e-3]
    assert max(far) < WORSE


def test_drivers_lead_position_by_position() -> None:
    assert method_for(1e-9, is_driven=True) == "kinematics"
