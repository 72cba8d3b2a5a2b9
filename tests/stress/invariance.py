"""The same motion in other words: what a change of words costs, in units of its own rounding."""

from __future__ import annotations

import random
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import numpy as np

import kousoku as ks
from kousoku.model.errors import KousokuError, MotionError
from kousoku.model.lowering import system_forces
from kousoku.model.reading.write import toml_of
from tests.random_draft import UNITS
from tests.random_geometry import product, turn
from tests.random_scenes import random_scene
from tests.stress import changes
from tests.stress.changes import DoesNotApply, Scaled
from tests.stress.comparing import size_of
from tests.stress.kit import Fault, Outcome, Question, Size
from tests.stress.scenes import (
    END,
    REASONS,
    SAMPLES,
    STOPS,
    is_by_rounding,
    quick_to_compile,
    reason_of,
    stopping,
    told,
)
from tests.stress.smaller import smallest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager

    Tree = dict[str, Any]

TOLERANCE = 1e-11
"""Of all motions."""

DISTANCE_MOVED = 1e6
"""How far scenes are moved [m]."""

UNIT = 3e-13
"""The cost of a change that only rounds: about a thousand roundings, which a motion makes of those
of its numbers and steps [m, rad]. The worst of 13 scenes, 1 1 0 in metres times 1e9, has one."""

ROUNDED = 1.0 + 2.0**-30
"""Lengths times this have other digits, and the motion has others by as much as they round."""

STEPS = TOLERANCE
"""The cost of a change of the steps: more coordinates count for their error, or other states."""

STRICT = 1e-13
"""The tolerance of motions that are off by more, and of which some step was rejected."""

LIMIT = 10.0
"""The largest error, in units of what the change costs."""

TIMES_THE_STEPS, MORE_STEPS = 50, 1000
"""So many times the steps of a motion, and so many more, are all that a change may take."""

A = product(turn((1, 2, -3), 1.25), turn((0, 0, 1), -2.0))


@dataclass(frozen=True)
class Change:
    """A scene in other words.

    Parameters
    ----------
    of : callable
        Returns the other scene.
    length, time : float
        What its lengths and times are multiplied by.
    turn : (3, 3), optional
        How its directions are turned.
    offset : (3,)
        How far it is moved, in the unit of the scene.
    cost : float
        What the change costs by itself, in metres or radians.
    tolerance : float
        Of the changed motion: none is tighter than what doubles know of positions there.
    """

    of: Callable[[Tree], Tree]
    length: float = 1.0
    time: float = 1.0
    turn: Any = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    offset: float = 0.0
    cost: float = UNIT
    tolerance: float = TOLERANCE


def _scaled(length: float = 1.0, mass: float = 1.0, time: float = 1.0) -> Change:
    return Change(lambda tree: Scaled(tree, length, mass, time).tree, length, time)


CHANGES: dict[str, Change] = {
    "reordered": Change(changes.reordered),
    "turned": Change(lambda tree: changes.turned(tree, A), turn=A),
    "split by welds": Change(changes.split, cost=STEPS),
    f"moved {DISTANCE_MOVED:g} m": Change(
        lambda tree: changes.moved(tree, (DISTANCE_MOVED * UNITS[tree["unit"]], 0.0, 0.0)),
        offset=DISTANCE_MOVED,
        cost=DISTANCE_MOVED * 2.0**-52,
        tolerance=DISTANCE_MOVED * 2.0**-52,
    ),
    "metres times 1e9": _scaled(length=1e9),
    "metres times 1e-9": _scaled(length=1e-9),
    "kilograms times 1e9": _scaled(mass=1e9),
    "kilograms times 1e-9": _scaled(mass=1e-9),
    "seconds times 1e9": _scaled(time=1e9),
    "seconds times 1e-9": _scaled(time=1e-9),
}


def cases(size: Size) -> Iterator[str]:
    """Name a case for each random scene, which is compiled once for every change."""
    for number in range(size.examples(1, 50)):
        yield f"changed {size.seed} {number}"


def run(case: str) -> Outcome:
    """Change the scene of a case in all ways, or in those that are named."""
    _, seed, number, *ways = case.split()
    outcome, place = Outcome(), f"{seed} {number} 0"
    chosen = {name: CHANGES[name] for name in ways or CHANGES}
    with quick_to_compile():
        ask(random_scene(random.Random(place)), outcome, f"scene {place}", chosen)
    return outcome


def ask(tree: Tree, outcome: Outcome, place: str, chosen: dict[str, Change]) -> None:
    """Compare a scene with all that it is in other words."""
    outcome.count("scenes")
    try:
        mechanism = ks.load(tree, target="c")
        motion: Any = mechanism.simulate(END, samples=SAMPLES, tolerance=TOLERANCE)
    except KousokuError as error:
        told(outcome, error, "refused", (*REASONS, *STOPS), place)
        return
    if is_by_rounding(tree, motion.ledger.trust):
        outcome.count("told that rounding decides: a force is too steep for doubles")
        return
    for name, change in chosen.items():
        try:
            units, details = off(tree, motion, change)
        except DoesNotApply as reason:
            outcome.count(f"{name} does not apply: {reason}")
            continue
        if not details:
            outcome.measure(f"{name} (units)", units, place)
        if details or not units <= LIMIT:
            title = f"{name}: {details.partition(';')[0] or 'another motion'}"

            def is_there(smaller: Tree, change: Change = change, details: str = details) -> bool:
                own = ks.load(smaller, target="c")
                moved = own.simulate(END, samples=SAMPLES, tolerance=TOLERANCE)
                other = off(smaller, moved, change)
                if details:
                    return other[1].partition(";")[0] == details.partition(";")[0]
                return not other[0] <= LIMIT and not other[1]

            small = smallest(tree, is_there)
            command = f"kousoku simulate scene.toml --end {END} --tolerance {TOLERANCE:g}"
            files = {"scene__toml": toml_of(small), "changed__toml": toml_of(change.of(small))}
            outcome.find(title, f"{units:.3g} units; {details}; {place}", command, **files)
    if changes.can_be_reversed(tree):
        there_and_back(mechanism, outcome, place)


def off(tree: Tree, motion: Any, change: Change) -> tuple[float, str]:
    """Error of the motion of a changed scene in units, or what refuses it.

    Which step is rejected may depend on rounding, where forces bend or jump: the motion is then off
    by its own error. So both are run with a tolerance at which that counts as nothing. A change
    that needs a larger tolerance costs at least what the scene itself loses by it, and one that
    rounds what it loses where all its lengths are rounded anew. Where rows are redundant but for
    what they miss, as axes that are parallel to ten digits, other words may keep others of them.
    """
    units, details, rejected = _off(tree, motion, change)
    if details or units <= LIMIT:
        return units, details
    units /= max(1.0, motion.ledger.trust.missed / change.cost)
    if units <= LIMIT:
        return units, details
    if change.tolerance != TOLERANCE:
        same = Change(lambda own: own, cost=change.cost, tolerance=change.tolerance)
        loses, reason, _ = _off(tree, motion, same)
        return units if reason else units / max(1.0, loses), details
    if not rejected:
        loses, reason, _ = _off(tree, motion, _scaled(length=ROUNDED))
        return units if reason else units / max(1.0, loses), details
    strict = ks.load(tree, target="c").simulate(END, samples=SAMPLES, tolerance=STRICT)
    more = replace(change, tolerance=STRICT, cost=STEPS)
    return _off(tree, strict, more)[:2]


def _off(tree: Tree, motion: Any, change: Change) -> tuple[float, str, int]:
    """Error of a motion, what refuses it, and how many steps were rejected."""
    other_tree = change.of(tree)
    steps = motion.ledger.steps
    most = TIMES_THE_STEPS * steps + MORE_STEPS
    try:
        other: Any = ks.load(other_tree, target="c").simulate(
            END * change.time, samples=SAMPLES, tolerance=change.tolerance, most_steps=most
        )
    except MotionError as error:
        if error.result.ledger.steps < most:
            return np.inf, f"is refused: {reason_of(error)}; {error}", 0
        return np.inf, f"takes far more steps; {most / steps:.3g} times as many; {error}", 0
    except KousokuError as error:
        return np.inf, f"is refused: {reason_of(error)}; {error}", 0
    rejected = motion.ledger.rejected + other.ledger.rejected
    if not other.ledger.trust.is_trusted and motion.ledger.trust.is_trusted:
        return np.inf, f"is not trusted; {other.ledger.trust}", rejected
    metre = UNITS[tree["unit"]]
    turning = np.array(change.turn, dtype=float)
    worst = 0.0
    for name, r in motion.position.items():
        there = other.position[name] / change.length
        there = there - np.array([change.offset * metre, 0, 0])
        worst = max(worst, size_of(there - r @ turning.T) / metre)
    for name, rate in motion.angular_velocity.items():
        there = other.angular_velocity[name] * change.time
        worst = max(worst, size_of(there - rate) / (1 + size_of(rate)))
    return worst / change.cost, "", rejected


def there_and_back(mechanism: Any, outcome: Outcome, place: str) -> None:
    """Run a motion, and back from its end with the opposite velocities."""
    motion = mechanism.simulate(END, samples=2, tolerance=TOLERANCE)
    _, q, v = motion.state(-1)
    try:
        back = mechanism.simulate(END, samples=2, tolerance=TOLERANCE, q0=q, v0=-v)
    except KousokuError as error:
        outcome.find(f"time reversed: is refused: {reason_of(error)}", f"{error}; {place}")
        return
    metre = UNITS[mechanism.unit]
    worst = 0.0
    for name, r in motion.position.items():
        worst = max(worst, size_of(back.position[name][-1] - r[0]) / metre)
    outcome.measure("time reversed (units)", worst / STEPS, place, LIMIT)


def pulled(x: float, z: float) -> AbstractContextManager[object]:
    """Let gravity be other than the scene says along the first and the last axis of frame O."""
    right = system_forces.gravity_of

    def wrong(scene: Any, unit: Any) -> Any:
        own = right(scene, unit)
        return (own[0] * x, own[1], own[2] * z)

    return patch("kousoku.model.lowering.system.gravity_of", wrong)


QUESTION = Question(
    asks="the same motion in other words, moved by 1e6 m, turned, reordered, split by welds, in"
    " other units of length, mass and time, and backwards: how far is it from itself, in units of"
    " what the change costs?",
    cases=cases,
    run=run,
    needs_compiler=True,
    faults=(
        Fault("gravity along one axis alone", partial(pulled, 0.0, 1.0), "changed 1 4 turned"),
        Fault(
            "gravity that is wrong along one axis in digit 10",
            partial(pulled, 1.0, 1 + 1e-10),
            "changed 1 4 turned",
        ),
        Fault("motions that stop for no reason", stopping, "changed 1 4 turned", "refused"),
    ),
    seconds=1200.0,
)
