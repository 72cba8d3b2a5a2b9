"""Random scenes: C, NumPy and the independent evaluator, and all methods, must agree.

Each is generated, compiled and moved for a moment; its rows are compared one by one with what the
independent evaluator says at the same positions and velocities. A scene is refused for a reason
that is counted, or agrees, or is a finding, with the smallest scene that shows it.
"""

from __future__ import annotations

import os
import random
import re
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import numpy as np
from hypothesis import strategies as st
from msgspec import structs

import kousoku as ks
from kousoku.model import combinations
from kousoku.model.errors import KousokuError, MotionError, SceneError
from kousoku.model.write import toml_of
from tests.random_draft import UNITS
from tests.random_scenes import numbered_scenes, random_scene
from tests.stress.comparing import Comparison, size_of
from tests.stress.kit import Disagreement, Fault, Outcome, Question, Size, falsify
from tests.stress.smaller import smallest

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.mechanism import Mechanism

    Tree = dict[str, Any]

BATCH = 10
"""Random scenes of a case."""

END, SAMPLES = 0.25, 6
"""A short motion [s], and its rows."""

WAYS: dict[str, dict[str, Any]] = {
    "default": {"tolerance": 1e-9},
    "dopri5": {"method": "dopri5", "tolerance": 1e-9},
    "dop853": {"method": "dop853", "tolerance": 1e-11},
    "fixed step": {"method": "dop853", "step": END / 100},
}
"""How a motion is computed; the last may miss more where formulas switch."""

AGREE = 1e-6
"""How far two methods may be from each other, in metres and radians."""

SAME = 1e-9
"""How far C and NumPy may be from each other where a scene has sines."""


REASONS = ("axes that parameters turn", "hold", "does not fit together near")
"""What random scenes are refused for, and rightly."""


def cases(size: Size) -> Iterator[str]:
    """Name a case for each batch of random scenes, and one that Hypothesis draws."""
    for batch in range(-(-size.examples(10, 1000) // BATCH)):
        yield f"random {size.seed} {batch}"
    yield f"hypothesis {size.seed} {100 if size.is_full else 3}"


def run(case: str) -> Outcome:
    """Run the scenes of a case."""
    sort, seed, number = case.split()
    outcome = Outcome()
    with quick_to_compile():
        if sort == "numbered":
            ask(numbered_scenes()[int(number)], outcome, f"numbered scene {number}")
            return outcome
        if sort == "random":
            for k in range(BATCH):
                draw = random.Random(f"{seed} {number} {k}")
                ask(random_scene(draw), outcome, f"scene {seed} {number} {k}")
            return outcome

        def is_taken(draw: random.Random) -> None:
            own = Outcome()
            ask(random_scene(draw), own, "a scene that Hypothesis drew", is_smallest=True)
            outcome.add(Outcome(own.figures, own.counts))
            if own.findings:
                raise Disagreement(own.findings[0])

        strategy = st.randoms(use_true_random=False)
        if found := falsify(strategy, is_taken, seed=int(seed), examples=int(number)):
            if not isinstance(found[1], Disagreement):
                raise found[1]
            outcome.findings.append(found[1].args[0])
    return outcome


@contextmanager
def quick_to_compile() -> Iterator[None]:
    """Compile without optimising unless flags are given: bits are the same."""
    with patch.dict(os.environ, {"KOUSOKU_CFLAGS": os.environ.get("KOUSOKU_CFLAGS", "-O0")}):
        yield


def ask(tree: Tree, outcome: Outcome, place: str, *, is_smallest: bool = False) -> None:
    """Compare a scene in all ways; what is found is shown by the smallest scene that has it."""
    own = look(tree, place)
    outcome.add(Outcome(own.figures, own.counts))
    if not own.findings:
        return
    titles = {one.title: one for one in own.findings}
    first = own.findings[0].title

    def is_there(smaller: Tree) -> bool:
        return any(one.title == first for one in look(smaller, place).findings)

    small = tree if is_smallest else smallest(tree, is_there)
    for title, finding in titles.items():
        command = f"kousoku simulate scene.toml --end {END} --tolerance 1e-9"
        outcome.find(title, finding.details, command, scene__toml=toml_of(small))


def look(tree: Tree, place: str) -> Outcome:
    """Return what a scene measures, and what it finds."""
    outcome = Outcome()
    outcome.count("scenes")
    try:
        mechanism = ks.load(tree, target="c")
        runs, stops = moved(mechanism)
    except KousokuError as error:
        reason = reason_of(error)
        outcome.count(f"refused: {reason}")
        if not any(known in reason for known in REASONS):
            outcome.find("refused for a reason that is not known", f"{error}; {place}")
        return outcome
    except Exception as error:
        outcome.find(f"a crash: {type(error).__name__}", f"{error}; {place}")
        return outcome
    if stops:
        outcome.count("stopped and told")
        if runs and stops.keys() != {"fixed step"}:  # one that is too long
            name, stop = next(iter(stops.items()))
            outcome.find(f"{name} stops where others move on", f"{stop}; {place}")
        return outcome
    comparison = Comparison(tree, mechanism)
    for figure, value, limit in comparison.rows(runs["default"]):
        outcome.measure(figure, value, place)
        if not value <= limit:
            title = f"{figure}: kousoku and the independent evaluator disagree"
            outcome.find(title, f"{value:.3g}, at most {limit:.3g}; {place}")
    methods(tree, runs, outcome, place)
    try:
        targets(tree, mechanism, outcome, place)
    except KousokuError as error:
        outcome.find("NumPy refuses what C moves", f"{error}; {place}")
    outcome.count("moved")
    return outcome


def reason_of(error: KousokuError) -> str:
    """Return the kind of an error, and its text without names and numbers."""
    problem = error.problems[0].problem if isinstance(error, SceneError) else str(error)
    text = re.sub(r"\b\w*_\d+\b|'[^']*'|[-+]?\d[\d.e+-]*", "…", problem.splitlines()[0])
    return f"{type(error).__name__}: {text[:70]}"


def moved(mechanism: Mechanism) -> tuple[dict[str, Any], dict[str, MotionError]]:
    """Return the motions of a scene, and why there is none."""
    runs: dict[str, Any] = {}
    stops: dict[str, MotionError] = {}
    for name, options in WAYS.items():
        try:
            runs[name] = mechanism.simulate(END, samples=SAMPLES, **options)
        except MotionError as error:
            stops[name] = error
    return runs, stops


def methods(tree: Tree, runs: dict[str, Any], outcome: Outcome, place: str) -> None:
    """Compare the motions of all methods, and their verdicts with what is true."""
    best = runs["dop853"]
    for name, one in runs.items():
        off = apart(tree, one, best)
        if one is not best:
            outcome.measure(f"{name} and dop853 (m, rad)", off, place)
        outcome.count("verdicts")
        trust = one.ledger.trust
        if trust.is_trusted and off > AGREE:
            outcome.find(f"{name} and dop853 are apart, and trusted", f"{off:.3g}; {place}")
        if not trust.is_trusted:
            outcome.count("verdicts 'not trusted'")
            if off <= AGREE:
                outcome.count("false alarms")
                outcome.find(f"{name}: a false alarm", f"{trust}; {place}")


def apart(tree: Tree, one: Any, other: Any) -> float:
    """Return how far two motions are apart, in metres and radians, of all rows."""
    worst = 0.0
    for name in one.position:
        worst = max(worst, size_of(one.position[name] - other.position[name]) / UNITS[tree["unit"]])
    for name in one.orientation:
        p, q = one.orientation[name], other.orientation[name]
        signs = np.sign((p * q).sum(axis=1, keepdims=True))
        worst = max(worst, 2 * size_of(p - signs * q))
    return worst


def targets(tree: Tree, mechanism: Mechanism, outcome: Outcome, place: str) -> None:
    """Compare the bits of C and NumPy along some steps."""
    way: dict[str, Any] = {"method": "dopri5", "step": 0.02, "times": [0.0, 0.03]}
    one = mechanism.simulate(**way)
    other = ks.load(tree, target="numpy").simulate(**way)
    columns = {name: (values, other[name]) for name, values in one.columns().items()}
    same = all(a.tobytes() == b.tobytes() for a, b in columns.values())
    outcome.count("scenes of the same bits in C and NumPy", int(same))
    worst = 0.0
    for a, b in columns.values():
        if not (np.isnan(a) == np.isnan(b)).all():
            worst = np.inf
        worst = max(worst, size_of(np.nan_to_num(a - b)) / (1 + size_of(np.nan_to_num(a))))
    outcome.measure("C and NumPy (relative)", worst, place)
    has_sines = re.search(r"sin|cos|tan|exp|log|\^|angle|drivers|revolute", toml_of(tree))
    if worst > (SAME if has_sines else 0.0) and not same:
        outcome.find("C and NumPy disagree", f"{worst:.3g}; {place}")


@contextmanager
def wrong_way() -> Iterator[None]:
    """Couple gears with the opposite ratio."""
    right = combinations._gear

    def wrong(name: str, joint: Any, coordinates: Any) -> Any:
        return right(name, structs.replace(joint, ratio=-float(joint.ratio)), coordinates)

    with patch.object(combinations, "_gear", wrong):
        yield


QUESTION = Question(
    asks="random scenes of all joints, couplings, forces, drivers, events and outputs: do C, NumPy,"
    " an independent evaluator and all methods agree, and is one refused for no reason?",
    cases=cases,
    run=run,
    faults=(Fault("gears that turn the wrong way", wrong_way, "numbered 1 9"),),
)
