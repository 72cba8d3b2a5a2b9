"""Distances in a step: which sink, where they are least, and what of it cuts the step."""

from __future__ import annotations

import math
from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.runtime.integrate import distances
from kousoku.runtime.integrate.distances import (
    AROUND,
    MOST_TURNED,
    TOLD_TURNING,
    TURNING,
    nearest_time,
    no_way,
    sinks_between,
    turned_end,
    turned_in,
)

if TYPE_CHECKING:
    from collections.abc import Callable


def beside(time: float, place: float, least: float = 0.0) -> float:
    """Square of a distance that is least at a place, and 0.5 half a second away from it."""
    return (time - place) ** 2 * (1.0 - 4.0 * least * least) + least * least


def looked_at(
    monkeypatch: pytest.MonkeyPatch, square: Callable[[float], float], *, lengths: int = 1
) -> Any:
    """Step from 0 to 1 in which the square of a distance is that function of time."""
    monkeypatch.setattr(distances, "distances_at", lambda time, _: np.array([square(time)]))
    scene = SimpleNamespace(n_distances=1, size=lambda _: lengths)
    return SimpleNamespace(
        start=0.0, h=1.0, turning=math.inf, is_over=False, work=SimpleNamespace(scene=scene)
    )


@pytest.mark.parametrize(
    ("first", "middle", "last", "sinks"),
    [
        (1.0, 0.0, 1.0, True),
        (1.0, 1.2, 1.0, False),
        (1.0, 0.5, 1.0, False),
        (1.0, 0.25, 0.0, True),  # it ends there
        (1.0, 0.5, 0.2, False),
        (0.09, 0.25, 0.81, False),
        (math.nan, 0.0, 1.0, False),
        (0.0, 0.0, 0.0, False),
    ],
)
def test_a_parabola_tells_what_sinks(first: float, middle: float, last: float, sinks: bool) -> None:
    assert sinks_between(first, middle, last) is sinks


def test_the_least_is_found_however_small_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    for there in (1e-9, 0.123, 0.5, 0.987654321):
        look = looked_at(monkeypatch, partial(beside, place=there))
        assert nearest_time(0, look) == pytest.approx(there, rel=1e-14, abs=1e-16)


def test_a_step_ends_before_the_place_then_right_behind_it(monkeypatch: pytest.MonkeyPatch) -> None:
    look = looked_at(monkeypatch, lambda time: (time - 0.4) ** 2)
    assert turned_end(1.0, look) == pytest.approx(0.4 * (1.0 - 1e-3))
    assert not look.is_over
    look = looked_at(monkeypatch, lambda time: (time - 1e-9) ** 2)
    assert turned_end(1.0, look) == pytest.approx(1e-9 + no_way(look), rel=1e-6)
    assert look.is_over


def test_a_step_that_leads_over_the_place_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    look = looked_at(monkeypatch, lambda time: (time - 0.5) ** 2)
    assert turned_end(1.0, look) < 1.0  # it may end there for another reason
    look.turning = 1.0
    assert turned_end(1.0, look) == math.inf


def test_a_step_that_starts_behind_the_place_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    look = looked_at(monkeypatch, lambda time: (time + 1e-9) ** 2)
    assert turned_end(1.0, look) == math.inf


def test_what_passes_beside_the_place_turns_as_soon_as_it_is_near(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    look = looked_at(monkeypatch, lambda time: (time - 0.5) ** 2 + 1e-6)
    assert turned_end(1.0, look) == pytest.approx(0.5 - AROUND * 1e-3, rel=1e-6)


@pytest.mark.parametrize(("lengths", "most"), [(1, TURNING), (0, TOLD_TURNING)])
def test_what_passes_far_beside_the_place_cuts_no_step(
    monkeypatch: pytest.MonkeyPatch, lengths: int, most: float
) -> None:
    for part, is_cut in ((0.9, True), (1.1, False)):
        square = partial(beside, place=0.5, least=0.5 * part * most)
        look = looked_at(monkeypatch, square, lengths=lengths)
        assert (turned_end(1.0, look) < 1.0) is is_cut


def test_distances_that_are_negative_or_lost_cut_no_step(monkeypatch: pytest.MonkeyPatch) -> None:
    for square in (lambda _: math.nan, lambda time: -((time - 0.5) ** 2), lambda _: 0.0):
        assert turned_end(1.0, looked_at(monkeypatch, square)) == math.inf


def test_a_step_that_is_cut_too_often_is_told() -> None:
    state = SimpleNamespace(sides=np.zeros(2))
    look: Any = SimpleNamespace(state=state, start=0.0, h=1.0, turned=0, is_untold=False)
    for _ in range(MOST_TURNED):
        assert turned_in(0.5, 1.0, look) == look.turning == 0.5
        assert not look.is_untold
    assert turned_in(0.5, 1.0, look) == 1.0
    assert look.is_untold
