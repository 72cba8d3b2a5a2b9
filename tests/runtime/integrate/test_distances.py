"""Distances in a step: which fall, where they are least, and what of it cuts the step."""

from __future__ import annotations

import math
from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.runtime.integrate import distances
from kousoku.runtime.integrate.cuts import EARLY, MOST_PLACE_CUTS, cut_for_place
from kousoku.runtime.integrate.distances import (
    AROUND,
    BOUNDED_REVERSAL_PART,
    DIFFERENCE,
    DOUBLED,
    NODES,
    REVERSAL_PART,
    dip_between,
    falls_in,
    nearest_time,
    no_way,
    node_of,
    reversal_end,
)

if TYPE_CHECKING:
    from collections.abc import Callable


def beside(time: float, place: float, least: float = 0.0) -> float:
    """Square of a distance that is least at a place, and 0.5 half a second away from it."""
    return (time - place) ** 2 * (1.0 - 4.0 * least * least) + least * least


def searched(
    monkeypatch: pytest.MonkeyPatch, square: Callable[[float], float], *, lengths: int = 1
) -> Any:
    """Step from 0 to 1 in which the square of a distance is that function of time."""
    monkeypatch.setattr(distances, "distances_at", lambda time, _: np.array([square(time)]))
    scene = SimpleNamespace(n_distances=1, size=lambda _: lengths)
    return SimpleNamespace(
        start=0.0,
        h=1.0,
        place_cut=math.inf,
        place=math.inf,
        is_over=False,
        is_kept=True,
        state=SimpleNamespace(y=np.zeros(1), f=np.zeros(1)),
        work=SimpleNamespace(scene=scene, w=None),
    )


@pytest.mark.parametrize(
    ("square", "halves"),
    [
        (lambda time: (2.0 * time - 1.0) ** 2, (True, False)),
        (lambda time: 1.0 + time - time * time, (False, False)),
        (lambda time: 0.5 + 2.0 * (time - 0.5) ** 2, (False, False)),
        (lambda time: (1.0 - time) ** 2, (False, True)),  # it ends there
        (lambda time: time * time, (True, False)),  # it starts there
        (lambda time: (0.3 + time) ** 2, (True, False)),
        (lambda time: (0.5 + time) ** 2, (False, False)),
        (lambda time: (time - 0.1) ** 2, (True, False)),
        (lambda time: (4.0 * time * (1.0 - time) - 0.5) ** 2, (True, True)),  # there and back
        (lambda time: (4.0 * time * (1.0 - time) - 0.01) ** 2, (True, True)),
        (lambda time: math.nan, (False, False)),
        (lambda time: 0.0, (False, False)),
    ],
)
def test_cubics_tell_in_which_half_a_distance_falls(
    square: Callable[[float], float], halves: tuple[bool, bool]
) -> None:
    nodes = np.array([square(part) for part in NODES])
    assert tuple(falls_in(half, nodes) for half in range(2)) == halves


@pytest.mark.parametrize(
    ("cubic", "least"),
    [
        ((1.0, -4.0, 1.0, 4.0), 0.0),
        ((1.0, 1.0, 2.0, 1.0), math.inf),
        ((0.0, 1.0, -1.0, -1.0), math.inf),  # least at its end
        ((0.0, 3.0, 0.0, 3.0), -math.sqrt(3.0) / 6.0),  # behind a hill
        ((1.0, 0.0, 1.0, 0.0), math.inf),
        ((math.nan, -1.0, 1.0, 1.0), math.inf),
    ],
)
def test_the_dip_of_a_cubic(cubic: tuple[float, float, float, float], least: float) -> None:
    assert dip_between(*cubic) == pytest.approx(least, abs=1e-15)


def test_the_least_is_found_however_small_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    for there in (1e-9, 0.123, 0.5, 0.987654321):
        search = searched(monkeypatch, partial(beside, place=there))
        assert nearest_time(0, 0.0, 1.0, search) == pytest.approx(there, rel=1e-14, abs=1e-16)


def test_nodes_lie_closer_at_the_ends() -> None:
    nodes = [node_of(number) for number in range(2 * DOUBLED + 1)]
    assert nodes[:2] == [0.0, DIFFERENCE]
    assert nodes[DOUBLED] == 0.5
    assert nodes[-2:] == [1.0 - DIFFERENCE, 1.0]
    assert nodes == sorted(set(nodes))


@pytest.mark.parametrize("place", [1e-6, 0.01, 0.2, 0.7])
def test_early_places_lie_where_the_first_rates_lead(
    monkeypatch: pytest.MonkeyPatch, place: float
) -> None:
    """A polynomial that is thrown off by 1e9 m has some where nothing is."""
    search = searched(monkeypatch, lambda time: 1e18 * (time - place) ** 2 * (1.0 - 0.5 * time))
    monkeypatch.setattr(distances, "distances_of", lambda *_: np.array([1e18 * place**2]))
    assert reversal_end(1.0, search) <= place + no_way(search)
    search.is_kept = False
    assert math.isinf(reversal_end(1.0, search)) == (place < EARLY)
    monkeypatch.setattr(distances, "distances_of", lambda *_: np.array([0.0]))
    assert reversal_end(1.0, search) <= place + no_way(search)


@pytest.mark.parametrize("place", [1e-5, 1e-4, 0.01, 0.1, 0.3])
def test_the_first_of_two_places_cuts_a_step(monkeypatch: pytest.MonkeyPatch, place: float) -> None:
    search = searched(monkeypatch, lambda time: ((time - place) * (1.0 - place - time)) ** 2)
    assert reversal_end(1.0, search) == pytest.approx(place, rel=2e-3)


def test_a_step_ends_before_the_place_then_right_behind_it(monkeypatch: pytest.MonkeyPatch) -> None:
    search = searched(monkeypatch, lambda time: (time - 0.4) ** 2)
    assert reversal_end(1.0, search) == pytest.approx(0.4 * (1.0 - 1e-3))
    assert not search.is_over
    search = searched(monkeypatch, lambda time: (time - 1e-9) ** 2)
    assert reversal_end(1.0, search) == pytest.approx(1e-9 + no_way(search), rel=1e-6)
    assert search.is_over


def test_a_step_that_leads_over_the_place_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    search = searched(monkeypatch, lambda time: (time - 0.5) ** 2)
    assert reversal_end(1.0, search) < 1.0  # it may end there for another reason
    search.place_cut = 1.0
    assert reversal_end(1.0, search) == math.inf


def test_a_step_that_was_to_end_before_the_place_and_leads_over_it_is_cut(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search = searched(monkeypatch, lambda time: (time - 0.5) ** 2)
    search.place_cut, search.place = 1.0, 1.001
    assert reversal_end(1.0, search) < 0.5 == pytest.approx(search.place)


def test_a_step_that_starts_behind_the_place_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    search = searched(monkeypatch, lambda time: (time + 1e-9) ** 2)
    assert reversal_end(1.0, search) == math.inf


def test_what_passes_beside_the_place_reverses_as_soon_as_it_is_near(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search = searched(monkeypatch, lambda time: (time - 0.5) ** 2 + 1e-6)
    assert reversal_end(1.0, search) == pytest.approx(0.5 - AROUND * 1e-3, rel=1e-6)


@pytest.mark.parametrize(("lengths", "most"), [(1, REVERSAL_PART), (0, BOUNDED_REVERSAL_PART)])
def test_what_passes_far_beside_the_place_cuts_no_step(
    monkeypatch: pytest.MonkeyPatch, lengths: int, most: float
) -> None:
    for part, is_cut in ((0.9, True), (1.1, False)):
        square = partial(beside, place=0.5, least=0.5 * part * most)
        search = searched(monkeypatch, square, lengths=lengths)
        assert (reversal_end(1.0, search) < 1.0) is is_cut


def test_distances_that_are_negative_or_lost_cut_no_step(monkeypatch: pytest.MonkeyPatch) -> None:
    for square in (lambda _: math.nan, lambda time: -((time - 0.5) ** 2), lambda _: 0.0):
        assert reversal_end(1.0, searched(monkeypatch, square)) == math.inf


def test_a_step_that_is_cut_too_often_is_unresolved() -> None:
    state = SimpleNamespace(sides=np.zeros(2))
    search: Any = SimpleNamespace(state=state, start=0.0, h=1.0, place_cuts=0, is_unresolved=False)
    for _ in range(MOST_PLACE_CUTS):
        assert cut_for_place(0.5, 1.0, search) == search.place_cut == 0.5
        assert not search.is_unresolved
    assert cut_for_place(0.5, 1.0, search) == 1.0
    assert search.is_unresolved
