"""Samples of a step that tell how narrow parts vary: where they are, and what is between them."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from kousoku.runtime.integrate import variation
from kousoku.runtime.integrate.search import CELLS, TimeNode
from kousoku.runtime.integrate.variation import are_narrow_resolved, resolved_end


def sampled(
    monkeypatch: pytest.MonkeyPatch, values: Any, slopes: Any, bounds: Any
) -> tuple[bool, list[tuple[float, float]]]:
    """Look at one part from 1 s to 3 s; return whether it is resolved, and the pairs of samples."""
    pairs: list[tuple[float, float]] = []

    def node_at(time: float, _: Any) -> TimeNode:
        value = np.array([values(time)])
        return TimeNode(time, np.zeros((0, 2)), value, value)

    def bound_functions(a: TimeNode, b: TimeNode, _: Any) -> Any:
        pairs.append((a.time, b.time))
        return np.array([*bounds(a.time, b.time), *slopes(a.time, b.time)]).reshape(4, 1)

    monkeypatch.setattr(variation, "node_at", node_at)
    monkeypatch.setattr(variation, "bound_functions", bound_functions)
    search: Any = SimpleNamespace(
        state=SimpleNamespace(sides=np.zeros(0)),
        has_error=False,
        is_coarse=False,
        tolerance=1e-9,
        work=SimpleNamespace(
            w=SimpleNamespace(narrow=np.zeros(4)),
            scene=SimpleNamespace(narrow_scales=np.array([[1.0, 0.0]]), is_driven=False),
        ),
    )
    return are_narrow_resolved(1.0, 3.0, search), pairs


def test_samples_part_a_step_evenly_from_its_begin_to_its_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    still = (lambda _: 1.0, lambda *_: (0.0, 0.0), lambda *_: (1.0, 1.0))
    is_resolved, pairs = sampled(monkeypatch, *still)
    ends = np.linspace(1.0, 3.0, CELLS + 1).tolist()
    assert is_resolved
    assert pairs == [*pairwise(ends)]


@pytest.mark.parametrize("cell", range(CELLS))
def test_what_may_happen_between_any_two_samples_is_not_resolved(
    monkeypatch: pytest.MonkeyPatch, cell: int
) -> None:
    """All samples are 1, but between two of them the bounds allow a hill of 3 and its slopes."""
    first = 1.0 + 2.0 * cell / CELLS

    def is_open(a: float, b: float) -> bool:
        return a <= first + 1e-9 < b

    def bounds(a: float, b: float) -> tuple[float, float]:
        return (1.0, 3.0) if is_open(a, b) else (1.0, 1.0)

    def slopes(a: float, b: float) -> tuple[float, float]:
        return (-10.0, 10.0) if is_open(a, b) else (0.0, 0.0)

    is_resolved, _ = sampled(monkeypatch, lambda _: 1.0, slopes, bounds)
    assert not is_resolved


def test_what_varies_as_samples_say_is_resolved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Slopes are known to 1.6: over 2 s a part may vary by 3.2, and samples vary by 2."""
    is_resolved, _ = sampled(
        monkeypatch, lambda t: t - 1.0, lambda *_: (0.2, 1.8), lambda *_: (0.0, 4.0)
    )
    assert is_resolved
    is_resolved, _ = sampled(
        monkeypatch, lambda t: t - 1.0, lambda *_: (-0.2, 2.2), lambda *_: (0.0, 4.0)
    )
    assert not is_resolved


def test_a_part_whose_bounds_leave_it_nearly_what_it_is_is_resolved(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    steep = (lambda _: 4.0, lambda *_: (-9.0, 9.0))
    assert sampled(monkeypatch, *steep, lambda *_: (3.0, 5.0))[0]
    assert not sampled(monkeypatch, *steep, lambda *_: (2.9, 5.1))[0]


def test_a_step_whose_length_is_rounded_up_is_looked_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Nothing was resolved in what is left of it, which is empty: a false alarm, 511 looks."""
    start, end = 0.3, 0.9
    assert start + (end - start) > end
    looks: list[tuple[float, float]] = []

    def are_resolved(first: float, last: float, _: Any) -> bool:
        looks.append((first, last))
        return True

    monkeypatch.setattr(variation, "are_narrow_resolved", are_resolved)
    monkeypatch.setattr(variation, "is_at_pole", lambda *_, in_between: False)
    search: Any = SimpleNamespace(start=start, h=end - start, is_unresolved=False)
    assert (resolved_end(end, search), search.is_unresolved) == (end, False)
    assert looks == [(start, end)]
