"""Random scenes: C, NumPy and the independent evaluator, and all methods, must agree.

Each is generated, compiled and moved for a moment; its rows are compared one by one with what the
independent evaluator says at the same positions and velocities. A scene is refused for a reason
that is counted, or agrees, or is a finding, with the smallest scene that shows it.
"""

from __future__ import annotations

import os
import platform
import random
import re
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import numpy as np
from hypothesis import strategies as st
from msgspec import structs

import kousoku as ks
from kousoku.codegen.dynamics.operations import own_frames
from kousoku.codegen.dynamics.recording.matrix import stack
from kousoku.mechanism import Mechanism
from kousoku.model.elements.event import ZeroCrossing
from kousoku.model.elements.gear import Gear
from kousoku.model.elements.joint import JointKind
from kousoku.model.errors import KousokuError, MotionError, SceneError
from kousoku.model.reading.write import toml_of
from kousoku.runtime import run_ledger
from kousoku.runtime.integrate import trust
from kousoku.runtime.integrate.settings import KINEMATICS, Doubt
from kousoku.runtime.run import GOES_ON
from tests.random_draft import UNITS
from tests.random_scenes import numbered_scenes, random_scene
from tests.stress.comparing import Comparison, nodes, size_of
from tests.stress.kit import Disagreement, Fault, Outcome, Question, Size, falsify
from tests.stress.own_kinds import kinds, pair
from tests.stress.smaller import smallest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from contextlib import AbstractContextManager

    from kousoku.runtime.integrate.trust import Trust

    Tree = dict[str, Any]

BATCH = 10
"""Random scenes of a case."""

QUICK = (9, 54)
"""Numbered scenes that the quick size asks: couplings, and forces and events of distances."""

END, SAMPLES = 0.25, 6
"""A short motion [s], and its rows."""

MOST_STEPS = 5000
"""Steps of a motion at most: dry friction that holds takes a million, and tells that."""

BEST, OTHER = "dop853", "dopri5, finer"
"""With what motions are compared, and with what that one is."""

WAYS: dict[str, dict[str, Any]] = {
    "default": {"tolerance": 1e-9},
    "dopri5": {"method": "dopri5", "tolerance": 1e-9},
    BEST: {"method": "dop853", "tolerance": 1e-11},
    OTHER: {"method": "dopri5", "tolerance": 1e-11},
    "fixed step": {"method": "dop853", "step": END / 100},
}
"""How a motion is computed: no two of them by the same method with the same steps."""

AGREE, AGREE_BY_STEP, AT_JUMPS = 5.0, 0.01, 1e3
"""How far two methods may be from each other in tolerances, for a motion and for each of its steps.
A tolerance is the root mean square of two errors of each freedom, one of them may have it all, and
is relative to a length of the scene. Where a force jumps with the state runs are known to be up to
some tens of tolerances off in `forces`; a closer limit was not measured here."""

STEPS: dict[str, dict[str, Any]] = {
    "fixed steps": {"method": "dopri5", "step": 0.02},
    "dopri5": {"method": "dopri5", "tolerance": 1e-6},
    "dop853": {"method": "dop853", "tolerance": 1e-9},
    KINEMATICS: {"method": KINEMATICS},
}
MANY = 60
"""How many steps of these ways are made in NumPy, too: nearly always all. NumPy takes a hundred
times as long as C."""

FIXED, FIXED_AT_JUMPS = 1e-11, 1e-10
"""What counts as the tolerance of steps of fixed length, unless the method itself takes more steps:
then they are too long, and as far off as the verdict on them lets energies be."""

FIXED_AT_ROOTS = 5e-3 * (END / 100) ** 1.5 * END**0.5
"""How far they may be off where a force is the root of a coordinate, for each m/s² or rad/s² that
is reached. What grows like the root of time has no derivative that an order needs: of its integral
over the first step the weights of the method miss 5e-3, and the motion goes on with that."""

BENT, LOCATED = "abs(x)*x", "max(x, -x)*x"
"""A law whose second derivative jumps, where no step ends: estimates of errors are of orders that
a step over it does not have, and each is zero for some place of the bend in the step. So motions
may be as far off as the verdict lets energies be. Beside it the same law, written so that steps end
there: these motions are held to what smooth ones are."""

OWN = 1e-9
"""How far motions of the same mechanism may be from each other, and accelerations, whose rows are
of other kinds: some tens of times what steps and rounding make of it."""

IS_GLIBC = platform.libc_ver()[0] == "glibc"
"""Whether C and Python call the same sines."""

SINES = r"sin|cos|tan|exp|log|\^|angle|drivers|revolute"
"""What tells that a scene has sines, which are not the same in all libraries of C."""

SAME = 1e3
"""How far C and NumPy may then be from each other, in units in the last place: each of some tens of
stages has a few sines, known to a unit, and a motion makes of them some times as much."""


HOLDS = "above which it is not redundant, and it is independent above"
"""How the message goes on that tells a row that holds nearly nothing beside others."""

REASONS = ("axes that parameters turn", HOLDS, "does not fit together near")
"""What random scenes are refused for, and rightly."""

NO_STEP = "no step can be taken: "
STOPS = (
    NO_STEP,
    " steps are made and t = ",
    "the constraints cannot be met inside of a step of ",
)
"""What motions stop for, and rightly; the last where steps of fixed length are too long."""

TOO_LONG = {"fixed step"}
"""Ways that alone may stop: their steps are too long for some scenes."""


def cases(size: Size) -> Iterator[str]:
    """Name a case for each batch of random scenes, each numbered or own one, and for Hypothesis."""
    number = size.examples(3, 1000)
    for batch in range(-(-number // BATCH)):
        of_batch = map(str, range(min(BATCH, number - batch * BATCH)))
        yield " ".join(["scene", str(size.seed), str(batch), *of_batch])
    for k in range(len(numbered_scenes())) if size.is_full else QUICK:
        yield f"numbered {k}"
    for number in range(size.fixed(1, 20)):
        yield f"own {size.seed} {number}"
    for batch in range(4 if size.is_full else 1):
        yield f"hypothesis {size.seed + batch} {25 if size.is_full else 2}"


def run(case: str) -> Outcome:
    """Ask the scenes of a case by its sort: random ones by batch and places, ``scene 1 0 7``."""
    sort, *words = case.split()
    outcome = Outcome()
    with quick_to_compile():
        SORTS[sort](outcome, *words)
    return outcome


def drawn(outcome: Outcome, seed: str, batch: str, *places: str) -> None:
    """Ask random scenes, each by its own draw."""
    for k in places:
        draw = random.Random(f"{seed} {batch} {k}")
        ask(random_scene(draw), outcome, f"scene {seed} {batch} {k}")


def numbered(outcome: Outcome, number: str) -> None:
    """Ask a scene that holds one thing of each sort."""
    ask(numbered_scenes()[int(number)], outcome, f"numbered scene {number}")


def searched(outcome: Outcome, seed: str, examples: str) -> None:
    """Ask scenes that Hypothesis draws, and makes smaller where one is wrong."""

    def is_taken(draw: random.Random) -> None:
        own = Outcome()
        ask(random_scene(draw), own, "a scene that Hypothesis drew", is_smallest=True)
        outcome.add(Outcome(own.figures, own.counts))
        if own.findings:
            raise Disagreement(own.findings[0])

    strategy = st.randoms(use_true_random=False)
    if found := falsify(strategy, is_taken, seed=int(seed), examples=int(examples)):
        if not isinstance(found[1], Disagreement):
            raise found[1]
        outcome.findings.append(found[1].args[0])


def of_own_kinds(outcome: Outcome, seed: str, number: str) -> None:
    """Move a mechanism with a joint that is shipped, and with kinds of one's own that state it."""
    place = f"own {seed} {number}"
    shipped, own = pair(random.Random(place))
    made: Any = [ks.load(tree, target="c", kinds=kinds()) for tree in (shipped, own)]
    one, other = (one.simulate(END, samples=SAMPLES, **WAYS[BEST]) for one in made)
    outcome.count("scenes of kinds of one's own")
    off = apart(shipped, one, other)
    outcome.measure("kinds of one's own and a shipped joint (m, rad)", off, place, OWN)
    first, second = (
        np.hstack([*run.acceleration.values(), *run.angular_acceleration.values()])
        for run in (one, other)
    )
    off = size_of(first - second) / size_of(first)
    outcome.measure("their accelerations (relative)", off, place, OWN)


SORTS: dict[str, Callable[..., None]] = {
    "own": of_own_kinds,
    "scene": drawn,
    "numbered": numbered,
    "hypothesis": searched,
}
"""What asks a case, by its first word."""


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
    small = tree
    for title, finding in titles.items():

        def is_there(smaller: Tree, title: str = title) -> bool:
            return any(one.title == title for one in look(smaller, place).findings)

        if not is_smallest:  # the one before is a good beginning where it shows this, too
            begin = small if small is tree or is_there(small) else tree
            small = smallest(begin, is_there, among=len(titles))
        way = WAYS.get(re.split(":| stops", title)[0], WAYS["default"])
        options = (f"--{name.replace('_', '-')} {value}" for name, value in way.items())
        command = " ".join([f"kousoku simulate scene.toml --end {END}", *options])
        outcome.find(title, finding.details, command, scene__toml=toml_of(small))


def look(tree: Tree, place: str) -> Outcome:
    """Outcome of a scene: its measures and findings."""
    outcome = Outcome()
    outcome.count("scenes")
    try:
        mechanism = ks.load(tree, target="c")
        runs, stops = moved(mechanism)
    except KousokuError as error:
        told(outcome, error, "refused", REASONS, place)
        return outcome
    except Exception as error:
        outcome.find(f"a crash: {type(error).__name__}", f"{error}; {place}")
        return outcome
    for stop in stops.values():
        told(outcome, stop, "stopped", STOPS, place)
    if stops.keys() - TOO_LONG:
        if runs:
            name, stop = next(iter(stops.items()))
            outcome.find(f"{name} stops where others move on", f"{stop}; {place}")
        return outcome
    comparison = Comparison(tree, mechanism)
    run = runs["default"]
    times = nodes(run.time[-1] * (0.999 if run.stopped_by else 1.0))
    powered: Any = mechanism.simulate(times=times, **WAYS["default"])
    for figure, value, limit in chain(comparison.rows(run), comparison.works(powered)):
        outcome.measure(figure, value, place)
        if not value <= limit:
            title = f"{figure}: kousoku and the independent evaluator disagree"
            outcome.find(title, f"{value:.3g}, at most {limit:.3g}; {place}")
    for what, number in comparison.counts.items():
        outcome.count(what, number)
    methods(tree, runs, outcome, place)
    if BENT in str(tree.get("forces")):
        located(tree, outcome, place)
    targets(tree, mechanism, outcome, place)
    outcome.count("moved")
    return outcome


def told(
    outcome: Outcome, error: KousokuError, what: str, known: Iterable[str], place: str, **files: str
) -> None:
    """Count why something is refused, or stops; that is a finding where the reason is not known."""
    outcome.count(f"{what}: {reason_of(error)}")
    if not any(reason in str(error) for reason in known):
        outcome.find(f"{what} for a reason that is not known", f"{error}; {place}", **files)


def reason_of(error: KousokuError) -> str:
    """Kind of an error, and its text without names and numbers."""
    problem = error.problems[0].problem if isinstance(error, SceneError) else str(error)
    problem = re.sub(r"\bwith (\w+ = \S+, )*\w+ = \S+: ", "", problem)
    text = re.sub(r"\b\w*_\d+\b|'[^']*'|[-+]?\d[\d.e+-]*", "…", problem.splitlines()[0])
    return f"{type(error).__name__}: {text[:70]}"


def moved(mechanism: Mechanism) -> tuple[dict[str, Any], dict[str, MotionError]]:
    """Motions of a scene, and why there is none."""
    runs: dict[str, Any] = {}
    stops: dict[str, MotionError] = {}
    for name, options in WAYS.items():
        try:
            runs[name] = mechanism.simulate(END, samples=SAMPLES, most_steps=MOST_STEPS, **options)
        except MotionError as error:
            stops[name] = error
    return runs, stops


def methods(tree: Tree, runs: dict[str, Any], outcome: Outcome, place: str) -> None:
    """Compare each motion with one of another method, and its verdict with what is true."""
    for name, one in runs.items():
        other = OTHER if runs[OTHER].method != one.method else BEST
        off, limit = apart(tree, one, runs[other]), most_apart(tree, runs, name, other)
        pair = " and ".join(sorted((name, other)))
        outcome.measure(f"{pair} (m, rad)", off, place)
        outcome.count("verdicts")
        verdict = one.ledger.trust
        if verdict.is_trusted and not off <= limit:
            outcome.find(f"{name} and {other} are apart, and trusted", f"{off:.3g}; {place}")
        if not verdict.is_trusted:
            outcome.count("verdicts 'not trusted'")
            if is_by_rounding(tree, verdict):
                outcome.count("verdicts 'not trusted', as rounding decides about a force")
            elif off <= limit:
                outcome.count("false alarms")
                outcome.find(f"{name}: a false alarm", f"{verdict}; {place}")


def is_by_rounding(tree: Tree, verdict: Trust) -> bool:
    """Whether all that speaks against a run is that rounding decides about a root.

    That is √|u| of a u that rests at 0: methods agree or not, by rounding of u.
    """
    impulse, problems = verdict.impulse, verdict.problems
    is_told = impulse is not None and impulse > verdict.limit and len(problems) == 1
    return is_told and "sqrt(" in str(tree.get("forces"))


def located(tree: Tree, outcome: Outcome, place: str) -> None:
    """Compare the motions of a scene whose steps end where its second derivatives jump."""
    forces = tree["forces"].items()
    laws = {name: {key: at_bends(value) for key, value in one.items()} for name, one in forces}
    other, place = tree | {"forces": laws}, f"{place}, with {LOCATED}"
    runs, stops = moved(ks.load(other, target="c"))
    if stops.keys() - TOO_LONG:
        name, stop = next(iter(stops.items()))
        outcome.find(f"{name} stops where others move on", f"{stop}; {place}")
        return
    methods(other, runs, outcome, place)


def at_bends(value: Any) -> Any:
    """Return a formula whose steps end at bends, or a number."""
    return value.replace(BENT, LOCATED) if isinstance(value, str) else value


def most_apart(tree: Tree, runs: dict[str, Any], name: str, other: str) -> float:
    """Largest distance that a motion may have from another one, in metres and radians."""
    forces, layout = str(tree.get("forces")), runs[name].layout
    jumps, bends, limit = "sign(" in forces, BENT in forces, 0.0
    size = max(1.0, layout.length) * (2 * layout.sizes["v"]) ** 0.5
    for one in (name, other):
        steps = runs[one].ledger.steps
        times = max(size * (AGREE + AGREE_BY_STEP * steps), AT_JUMPS if jumps else 0.0)
        times = max(times, trust.HEALTHY * size if bends else 0.0)
        if "step" not in WAYS[one]:
            limit += WAYS[one]["tolerance"] * times
        elif bends or runs[BEST].ledger.steps > steps:  # the method itself takes shorter steps
            limit += trust.FIXED * max(times, trust.HEALTHY * size)
        else:
            limit += (FIXED_AT_JUMPS if jumps else FIXED) * times
            if "sqrt(" in forces:
                limit += FIXED_AT_ROOTS * hardest(tree, runs[BEST])
    return limit


def hardest(tree: Tree, run: Any) -> float:
    """Return the largest mean acceleration between rows, in metres, radians and seconds."""
    rates = [v / UNITS[tree["unit"]] for v in run.velocity.values()]
    rates += run.angular_velocity.values()
    return size_of(*(np.diff(v, axis=0) / np.diff(run.time)[:, None] for v in rates))


def apart(tree: Tree, one: Any, other: Any) -> float:
    """Distance of two motions, in metres and radians, of all rows."""
    worst = 0.0
    for name in one.position:
        worst = max(worst, size_of(one.position[name] - other.position[name]) / UNITS[tree["unit"]])
    for name in one.orientation:
        p, q = one.orientation[name], other.orientation[name]
        signs = np.sign((p * q).sum(axis=1, keepdims=True))
        worst = max(worst, 2 * size_of(p - signs * q))
    return worst


def targets(tree: Tree, mechanism: Mechanism, outcome: Outcome, place: str) -> None:
    """Compare the bits of C and NumPy along some steps of each method; NaN is the same as NaN."""
    solver: Any = mechanism.solver
    in_numpy, same = ks.load(tree, target="numpy"), units_allowed(toml_of(tree))
    for name, way in STEPS.items():
        if name == KINEMATICS and not solver.is_driven:
            continue
        try:
            times, is_whole = times_of(mechanism, way)
            one = mechanism.simulate(times=times, **way)
        except MotionError as stop:
            told(outcome, stop, "stopped", STOPS, place)
            continue
        try:
            other = in_numpy.simulate(times=times, **way)
        except KousokuError as error:
            outcome.find("NumPy refuses what C moves", f"{error}; {place}")
            continue
        outcome.count(f"whole motions in C and NumPy, {name}", int(is_whole))
        worst = max(units_apart(values, other[key]) for key, values in one.columns().items())
        outcome.count(f"scenes of the same bits in C and NumPy, {name}", int(worst == 0.0))
        outcome.measure(f"C and NumPy, {name} (units in the last place)", worst, place)
        if not worst <= same:
            outcome.find("C and NumPy disagree", f"{worst:.3g}; {name}; {place}")


def units_allowed(text: str) -> float:
    """Units in the last place that C and NumPy may be apart, of a scene."""
    return SAME if not IS_GLIBC and re.search(SINES, text) else 0.0


def times_of(mechanism: Mechanism, way: dict[str, Any]) -> tuple[list[float], bool]:
    """Times of rows within the first steps made in a way, and whether these are all it makes."""
    run = mechanism.begin([0.0, END], **way)
    while run.steps < MANY and run.advance(MANY - run.steps) in GOES_ON:
        pass  # events tell themselves on the way
    return [0.0, 0.4 * run.time, 0.99 * run.time, run.time], run.steps < MANY


def units_apart(one: Any, other: Any) -> float:
    """Distance of a column from another one in units in the last place of its largest."""
    if not (np.isnan(one) == np.isnan(other)).all():
        return np.inf
    one, other = np.nan_to_num(one), np.nan_to_num(other)
    return float(size_of(one - other) / np.spacing(max(1.0, size_of(one))))


def geared(factor: float) -> AbstractContextManager[object]:
    """Couple gears with another ratio."""
    right = Gear.combination

    def wrong(self: Any, name: str, joint: Any, coordinates: Any) -> Any:
        other = structs.replace(joint, ratio=factor * float(joint.ratio))
        return right(self, name, other, coordinates)

    return patch.object(Gear, "combination", wrong)


def sideways() -> AbstractContextManager[object]:
    """Count second displacements along the first direction of a plane."""
    right = JointKind.measure

    def wrong(self: Any, joint: Any, sort: str, ends: Any) -> Any:
        return right(self, joint, sort.removeprefix("second_") if "disp" in sort else sort, ends)

    return patch.object(JointKind, "measure", wrong)


def late() -> AbstractContextManager[object]:
    """Find events where their formulas are a little above zero."""
    right = ZeroCrossing.element

    def wrong(*given: Any) -> Any:
        event = right(*given)
        return replace(event, when=f"({event.when}) - 1e-10")

    return patch.object(ZeroCrossing, "element", wrong)


def generous() -> AbstractContextManager[object]:
    """Add a little to all works."""
    right = run_ledger._works

    def wrong(*given: Any) -> dict[str, float]:
        return {name: work * (1 + 1e-6) for name, work in right(*given).items()}

    return patch.object(run_ledger, "_works", wrong)


@contextmanager
def too_steep() -> Iterator[None]:
    """Say of every run that a force in it is too steep for doubles."""
    right = trust.judge

    def wrong(*given: Any, **more: Any) -> Any:
        verdict = right(*given, **more)
        return verdict._replace(doubts=verdict.doubts | Doubt.IMPULSE)

    with patch.object(trust, "judge", wrong), patch.object(trust, "relative_impulse", lambda _: 1):
        yield


def stopping() -> AbstractContextManager[object]:
    """Stop every motion, and give a reason that is none."""
    right = Mechanism.simulate

    def wrong(self: Any, *given: Any, **more: Any) -> Any:
        raise MotionError("nonsense: at t = 0 s: nothing goes on", right(self, *given, **more))

    return patch.object(Mechanism, "simulate", wrong)


def swapped() -> AbstractContextManager[object]:
    """Let the frame of each body of a kind of one's own swing as that of the other."""

    def wrong(graph: Any, parts: Any, *more: Any) -> Any:
        return stack(graph, parts[::-1], *more)

    return patch.object(own_frames, "stack", wrong)


def rounded_up(first: int = 1) -> AbstractContextManager[object]:
    """Let NumPy round up what a step gives, by a unit in the last place, from some step on."""
    right = b"state.y[:] = work.y"
    beyond = f"[math.nextafter(x, math.inf) for x in work.y] if state.steps >= {first} else "
    wrong = b"state.y[:] = " + beyond.encode() + b"work.y"

    def spoilt(source: bytes, *given: Any, **more: Any) -> Any:
        return compile(source.replace(right, wrong), *given, **more)

    return patch("kousoku.runtime.importing.compile", spoilt, create=True)


QUESTION = Question(
    asks="random scenes of all joints, couplings, forces, drivers, events and outputs: do C, NumPy,"
    " an independent evaluator and all methods agree, and is one refused for no reason?",
    cases=cases,
    run=run,
    needs_compiler=True,
    faults=(
        Fault("gears that turn the wrong way", partial(geared, -1.0), "numbered 9"),
        Fault("gears whose ratio is wrong in digit 11", partial(geared, 1 + 1e-11), "numbered 9"),
        Fault("second displacements along the first direction", sideways, "numbered 50"),
        Fault("events that are late by 1e-10", late, "scene 2 1 8"),
        Fault("works that are wrong in digit 7", generous, "scene 2 0 2"),
        Fault("steps that NumPy alone rounds up", rounded_up, "scene 2 0 2"),
        Fault("kinds of one's own whose frames swing as others", swapped, "own 1 0"),
        Fault("verdicts that every force is too steep", too_steep, "scene 2 0 2"),
        Fault("motions that stop for no reason", stopping, "scene 2 0 2", "stopped for a reason"),
        Fault(
            "steps that NumPy alone rounds up from the seventh on",
            partial(rounded_up, 7),
            "scene 2 0 2",
        ),
    ),
)
