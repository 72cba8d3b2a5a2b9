"""The question of changed words: what it takes for a difference, and what for rounding."""

from __future__ import annotations

import random

import pytest

import kousoku as ks
from tests.random_scenes import random_scene
from tests.stress import invariance
from tests.stress.kit import Outcome
from tests.stress.scenes import END, SAMPLES, quick_to_compile, too_steep

#: What it looks at is no part of kousoku.
pytestmark = pytest.mark.release


def test_a_step_that_rounding_rejects_is_no_other_motion() -> None:
    """Where a force bends beside a row, the motion was off by its error, 3000 times rounding."""
    tree = random_scene(random.Random("1 27 1"))
    with quick_to_compile():
        motion = ks.load(tree, target="c").simulate(
            END, samples=SAMPLES, tolerance=invariance.TOLERANCE
        )
        units, details = invariance.off(tree, motion, invariance.CHANGES["turned"])
    assert motion.ledger.rejected
    assert units <= invariance.LIMIT
    assert not details


def test_redundant_rows_cost_what_they_miss() -> None:
    """Axes of a loop are parallel to ten digits: turned, other rows of it stay, 16 units away."""
    tree = random_scene(random.Random("1 27 0"))
    with quick_to_compile():
        motion = ks.load(tree, target="c").simulate(
            END, samples=SAMPLES, tolerance=invariance.TOLERANCE
        )
        units, details = invariance.off(tree, motion, invariance.CHANGES["turned"])
    assert motion.ledger.trust.missed > invariance.UNIT
    assert units <= invariance.LIMIT
    assert not details


def test_a_larger_tolerance_costs_what_the_scene_loses_by_it() -> None:
    """At 1e6 m a scene was off by 52 units: it loses 12 by that tolerance where it is."""
    tree = random_scene(random.Random("1 19 1"))
    with quick_to_compile():
        motion = ks.load(tree, target="c").simulate(
            END, samples=SAMPLES, tolerance=invariance.TOLERANCE
        )
        units, details = invariance.off(tree, motion, invariance.CHANGES["moved 1e+06 m"])
    assert 1.0 < units <= invariance.LIMIT
    assert not details


def test_a_change_that_takes_far_more_steps_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """In metres times 1e-9 one took so many that its case ended by the time, and told nothing."""
    monkeypatch.setattr(invariance, "TIMES_THE_STEPS", 0)
    monkeypatch.setattr(invariance, "MORE_STEPS", 3)
    tree = random_scene(random.Random("1 11 1"))
    with quick_to_compile():
        motion = ks.load(tree, target="c").simulate(
            END, samples=SAMPLES, tolerance=invariance.TOLERANCE
        )
        units, details = invariance.off(tree, motion, invariance.CHANGES["seconds times 1e9"])
    assert units == float("inf")
    assert details.startswith("takes far more steps; ")


@pytest.mark.parametrize(
    ("place", "change"), [("1 11 1", "metres times 1e-9"), ("1 22 1", "moved 1e+06 m")]
)
def test_units_and_places_of_a_loop_cost_no_steps(place: str, change: str) -> None:
    """Both took 250 times as many: pivots of rows in metres were compared with others in radians.

    Of the one far away more was asked of its energy than rounding of its positions leaves.
    """
    tree = random_scene(random.Random(place))
    with quick_to_compile():
        motion = ks.load(tree, target="c").simulate(
            END, samples=SAMPLES, tolerance=invariance.TOLERANCE
        )
        units, details = invariance.off(tree, motion, invariance.CHANGES[change])
    assert units <= invariance.LIMIT
    assert not details


def test_a_verdict_that_nothing_explains_keeps_no_scene_from_being_compared() -> None:
    """A scene without a root, of which it is said that a force is too steep for doubles."""
    tree, outcome = random_scene(random.Random("1 3 0")), Outcome()
    with quick_to_compile(), too_steep():
        invariance.ask(tree, outcome, "", {"turned": invariance.CHANGES["turned"]})
    assert outcome.figures.keys() >= {"turned (units)"}
