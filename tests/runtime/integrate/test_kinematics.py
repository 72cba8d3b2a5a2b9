"""Kinematics in NumPy: where steps are put, with what they find made up."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from kousoku.runtime.integrate import kinematics
from kousoku.runtime.integrate.kinematics import HALVES, driven_step, watched_end
from kousoku.runtime.integrate.methods import METHODS
from kousoku.runtime.integrate.pivot_monitor import WEAK_PIVOT_RATIO
from kousoku.runtime.integrate.search import Search
from kousoku.runtime.integrate.settings import Status

ANY: Any = None


@pytest.fixture
def work() -> Any:
    scene = SimpleNamespace(parts=(), has_functions=False, has_narrow=True, works=0)
    return SimpleNamespace(scene=scene, k=np.zeros((8, 3)))


@pytest.fixture
def state() -> Any:
    return SimpleNamespace(
        **{"time": 2.0, "step_size": 0.0, "largest_pivot_ratio": 1.0, "avoided": 0, "rejected": 0},
        **{"drift": 0.0, "untold": 0.0, "energy_moved": 0.0, "moved": 0.0},
        **{"simpson": 0.0, "error": 0.0, "usual_ratio": 1.0, "is_near": 0.0, "sides": np.zeros(0)},
    )


class Tried:
    """Where a step tried to end, and whether in halves; what it found is made up."""

    def __init__(self, drifts: list[float], ratios: list[float], rough: list[float]) -> None:
        self.drifts, self.ratios, self.rough = [*drifts], [*ratios], [*rough]
        self.ends: list[tuple[float, bool]] = []
        self.kept: tuple[float, float] | None = None

    def reach(self, end: float, parts: Any, *_: Any) -> tuple[float, float]:
        self.ends.append((end, parts is HALVES))
        drift = self.drifts.pop(0) if self.drifts else 0.0
        usual = 0.0 if drift >= 0.0 else math.inf
        return drift, self.rough.pop(0) if self.rough else usual

    def pivot_ratio(self, *_: Any) -> float:
        return self.ratios.pop(0) if self.ratios else 1.0

    def accept_position(self, _: Any, end: float, asked: float, *__: Any) -> None:
        self.kept = end, asked


def step(
    monkeypatch: pytest.MonkeyPatch, state: Any, work: Any, asked: float, **found: list[float]
) -> Tried:
    """Make a step of at most 1 s, and return what it tried."""
    tried = Tried(*(found.get(name, []) for name in ("drifts", "ratios", "rough")))
    for name in ("reach", "pivot_ratio", "accept_position"):
        monkeypatch.setattr(kinematics, name, getattr(tried, name))
    monkeypatch.setattr(kinematics, "signed_ratio", lambda *_: 1.0)
    for name in ("note_pivot_ratio", "note_largest_pivot"):
        monkeypatch.setattr(kinematics, name, lambda *_: None)
    settings: Any = SimpleNamespace(largest_step=1.0, checks=False, tolerance=1e-9)
    assert driven_step(settings, asked, state, work) is Status.GOOD
    return tried


def test_a_step_is_put_before_where_rows_are_nearly_dependent_and_then_behind_it(
    monkeypatch: pytest.MonkeyPatch, state: Any, work: Any
) -> None:
    parts = [1.0, 0.75, 0.5, *(1.25**n for n in range(1, 11))]
    assert parts[-2] < kinematics.FURTHEST_TRIAL < parts[-1]
    tried = step(monkeypatch, state, work, 100.0, ratios=[0.5 * WEAK_PIVOT_RATIO] * 13)
    assert tried.ends == [(2.0 + part, part <= 1.0) for part in parts]
    assert (state.avoided, state.rejected) == (12, 0)
    assert tried.kept == (2.0 + parts[-1], 100.0)


def test_a_ratio_at_the_threshold_is_not_weak(
    monkeypatch: pytest.MonkeyPatch, state: Any, work: Any
) -> None:
    tried = step(monkeypatch, state, work, 100.0, ratios=[WEAK_PIVOT_RATIO])
    assert tried.ends == [(3.0, True)]
    assert state.avoided == 0


def test_a_ratio_is_weak_beside_the_largest_one(
    monkeypatch: pytest.MonkeyPatch, state: Any, work: Any
) -> None:
    state.largest_pivot_ratio = 1e-3
    assert len(step(monkeypatch, state, work, 100.0, ratios=[1e-8]).ends) == 1
    state.largest_pivot_ratio = 1e3
    assert len(step(monkeypatch, state, work, 100.0, ratios=[1e-4]).ends) == 2


def test_a_step_that_is_not_smooth_is_halved(
    monkeypatch: pytest.MonkeyPatch, state: Any, work: Any
) -> None:
    tried = step(monkeypatch, state, work, 100.0, drifts=[-1.0, -1.0, 0.0])
    assert tried.ends == [(3.0, True), (2.5, True), (2.25, True)]
    assert (state.avoided, state.rejected) == (0, 2)


def test_how_rough_a_step_is_tells_the_next_one(
    monkeypatch: pytest.MonkeyPatch, state: Any, work: Any
) -> None:
    """It goes with the square of the length."""
    tried = step(monkeypatch, state, work, 100.0, drifts=[-1.0, 0.0], rough=[4.0, 0.81])
    assert [end - 2.0 for end, _ in tried.ends] == [1.0, pytest.approx(0.45)]
    assert state.step_size == pytest.approx(0.45)


def test_a_short_step_to_the_time_that_is_asked_for_does_not_lengthen_others(
    monkeypatch: pytest.MonkeyPatch, state: Any, work: Any
) -> None:
    state.step_size = 0.4
    step(monkeypatch, state, work, 2.01)
    assert state.step_size == 0.4


def test_a_place_that_is_not_smooth_behind_a_weak_one_is_given_up(
    monkeypatch: pytest.MonkeyPatch, state: Any, work: Any
) -> None:
    """The step begins again, half as long."""
    ratios = [0.5 * WEAK_PIVOT_RATIO] * 3
    tried = step(monkeypatch, state, work, 100.0, ratios=ratios, drifts=[0.0, 0.0, 0.0, -1.0, 0.0])
    assert [end - 2.0 for end, _ in tried.ends] == [1.0, 0.75, 0.5, 1.25, 0.5]
    assert (state.avoided, state.rejected) == (3, 1)


def test_a_step_whose_works_miss_the_tolerance_is_shortened(
    monkeypatch: pytest.MonkeyPatch, state: Any, work: Any
) -> None:
    work.scene.parts = ("energies",)
    errors = [1.5, 0.5]
    monkeypatch.setattr(kinematics, "sum_works", lambda *_, **__: (errors.pop(0), 0.0, True))
    tried = step(monkeypatch, state, work, 100.0)
    assert [end - 2.0 for end, _ in tried.ends] == [1.0, pytest.approx(0.9 * 1.5 ** (-1 / 9))]
    assert state.rejected == 1


@pytest.mark.parametrize(
    ("part", "exact", "told", "seen", "wanted"),
    [
        (1.0, 3.0, 2.5, 3.0, 2.5),  # samples tell no more than that
        (1.0, 3.0, 3.0, 2.25, 2.25),  # an event comes first
        (1.0, 2.125, 3.0, 2.25, 2.125),  # the polynomial does not tell where it is
        (0.5, 3.0, 2.5, 2.75, 2.5),
        (1.25, 2.125, 2.5, 2.25, 3.0),  # it leaps
        (1.0, 3.0, 3.0, 3.0, 3.0),
    ],
)
def test_a_step_is_searched_from_where_it_begins(
    monkeypatch: pytest.MonkeyPatch,
    state: Any,
    work: Any,
    part: float,
    exact: float,
    told: float,
    seen: float,
    wanted: float,
) -> None:
    begun: list[Any] = []
    monkeypatch.setattr(kinematics, "begin_search", lambda *given, has_stages: begun.append(given))
    search = Search(state, work, state.time)
    to = seen if part <= 1.0 else 3.0  # what follows a cut is seen later
    monkeypatch.setattr(
        kinematics, "resolved_end", lambda *given: min(told, to) if given == (to, search) else 0
    )
    monkeypatch.setattr(kinematics, "exact_end", lambda *_: exact)
    monkeypatch.setattr(kinematics, "add_middle_rows", lambda *_: None)
    search.h = 1.0
    monkeypatch.setattr(
        kinematics, "crossing_end", lambda *given: seen if given == (3.0, search) else 0
    )
    search.crosses = np.zeros(1, bool)
    assert watched_end(ANY, 3.0, part, search) == wanted
    ((settings, method, length, *_),) = begun
    assert (settings, method, length) == (ANY, METHODS[-1], 1.0)
    is_cut = part <= 1.0 and seen <= min(exact, told) and seen < 3.0
    assert (search.cut == seen) == is_cut
