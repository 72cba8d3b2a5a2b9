"""Long motions: conservative ones, driven ones, and chaotic ones by their statistics.

Where no force does work the energy stays. Each step may change it by its error, so that what is
lost grows with the steps at most; what rounding loses grows with their root. A crank that is led is
after 100,000 turns where it was after one.
"""

from __future__ import annotations

import math
import tomllib
from fractions import Fraction
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import numpy as np

import kousoku as ks
from kousoku.runtime.options import Options
from kousoku.runtime.run import GOES_ON, Run
from tests.stress.comparing import Comparison, U, size_of
from tests.stress.kit import ROOT, Fault, Outcome, Question, Size

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager

    from kousoku.model.numbers.real import Array
    from kousoku.runtime.kinematics.trajectory import Trajectory

#: Committed scenes where no force takes or gives energy.
CONSERVATIVE = ("pendulum", "heavy_top", "n_four_bar", "bricard", "flipping_body")
WAYS = (("dopri5", 1e-6), ("dop853", 1e-9), ("dop853", 1e-12), ("dop853", 1e-14))
ALLOWED = 0.1
"""Energy that a step may lose, in tolerances: what the verdict lets a healthy run lose."""
ENERGY_ROUNDING_OF_STEPS = 4e-16
"""What is lost by rounding in a step, relative to the energy that moves, where all add up."""
OPEN = 1000 * U
"""How far joints may be open beyond what the solver says of itself, by rounding [m, rad]."""
ROWS = 400
FEWEST = 300
"""From how many steps or turns on tables tell what is off."""
DIVISIONS = 6
"""Positions of each turn of a linkage."""

#: Two rods that swing freely: far beyond the energy at which they turn over, nothing repeats.
DOUBLE = """
name = "double_pendulum"
unit = "m"
gravity = [0, -9.81, 0]
outputs = ["energies", "coordinates"]
[bodies]
upper = { position = [0, 0, 0], rods = [{ mass = 1, ends = [[0, 0, 0], [1, 0, 0]] }] }
lower = { position = [1, 0, 0], rods = [{ mass = 1, ends = [[0, 0, 0], [1, 0, 0]] }] }
[joints]
top = { type = "revolute", bodies = ["ground", "upper"], at = [0, 0, 0], axis = [0, 0, 1] }
middle = { type = "revolute", bodies = ["upper", "lower"], at = [1, 0, 0], axis = [0, 0, 1] }
[coordinates]
first = { joint = "top" }
second = { joint = "middle" }
"""
#: A crank that leads a rod and a slider, one turn a second, and a wheel of three times its teeth.
LED = """
name = "led_crank"
unit = "m"
outputs = ["coordinates"]
[bodies]
crank = { position = [0, 0, 0], rods = [{ mass = 1, ends = [[0, 0, 0], [0.1, 0, 0]] }] }
rod = { position = [0.1, 0, 0], rods = [{ mass = 1, ends = [[0, 0, 0], [0.3, 0, 0]] }] }
slider = { position = [0.4, 0, 0], boxes = [{ mass = 1, size = [0.1, 0.1, 0.1] }] }
wheel = { position = [0, 1, 0], boxes = [{ mass = 1, size = [0.3, 0.3, 0.1] }] }
[joints]
shaft = { type = "revolute", bodies = ["ground", "crank"], at = [0, 0, 0], axis = [0, 0, 1] }
pin = { type = "revolute", bodies = ["crank", "rod"], at = [0.1, 0, 0], axis = [0, 0, 1] }
gudgeon = { type = "revolute", bodies = ["rod", "slider"], at = [0.4, 0, 0], axis = [0, 0, 1] }
guide = { type = "prismatic", bodies = ["ground", "slider"], at = [0.4, 0, 0], axis = [1, 0, 0] }
axle = { type = "revolute", bodies = ["ground", "wheel"], at = [0, 1, 0], axis = [0, 0, 1] }
mesh = { type = "gear", joints = ["shaft", "axle"], ratio = -3 }
[coordinates]
turn = { joint = "shaft" }
wheel_turn = { joint = "axle" }
place = { joint = "guide" }
[drivers]
motor = { coordinate = "turn", value = "2*pi*t" }
"""


def cases(size: Size) -> Iterator[str]:
    """Name motions, how they are made, and how many steps or turns they have."""
    steps = size.fixed(10_000, 1_000_000)
    for scene in CONSERVATIVE:
        for way in range(len(WAYS)) if size.is_full else (1, 3):
            yield f"conservative {scene} {way} {steps}"
    turns = size.fixed(300, 100_000)
    for method in ("kinematics", "dop853"):
        yield f"driven {method} {turns}"
    yield f"linkage lever_crank {turns}"
    yield f"chaotic {size.fixed(500, 50_000)}"


def run(case: str) -> Outcome:
    """Make a motion and look at it."""
    outcome = Outcome()
    what, *words = case.split()
    MOTIONS[what](outcome, *words)
    return outcome


def marks(number: int) -> dict[str, int]:
    """Number of steps or turns and its tenths, by what the columns of tables are called."""
    tenths = (number // 10**k for k in reversed(range(len(str(number)))))
    return {f"{one:.0e}".replace("e+0", "e"): one for one in tenths if one >= min(FEWEST, number)}


def growth(time: Array, lost: Array) -> float:
    """Exponent by which the largest value so far grows with time."""
    largest = np.maximum.accumulate(lost)
    is_late = (time > 0.01 * time[-1]) & (largest > 0.0)
    if is_late.sum() < 3:
        return 0.0
    return float(np.polyfit(np.log(time[is_late]), np.log(largest[is_late]), 1)[0])


def conservative(outcome: Outcome, name: str, way: str, steps: str) -> None:
    """Look at energy and constraints of a free motion, after so many steps."""
    method, tolerance = WAYS[int(way)]
    scene = ks.load(ROOT / "scenes" / f"{name}.toml", outputs=["energies"])
    options: dict[str, Any] = {"method": method, "tolerance": tolerance}
    short = scene.simulate(10.0, samples=2, **options)
    end = 10.0 * int(steps) / short.ledger.steps
    times = np.concatenate(([0.0], np.geomspace(1e-4 * end, end, ROWS)))
    motion = scene.begin(times, most_steps=20 * int(steps), **options)
    columns, met = marks(int(steps)), {}
    for column, mark in columns.items():
        while motion.steps < mark and motion.advance(mark - motion.steps) in GOES_ON:
            pass
        met[column] = motion.written, motion.motion().ledger.worst("position")[0]
    result: Any = motion.finish()
    position = result.ledger.worst("position")[0]
    met[column] = len(result), position  # so many steps, nearly
    where = f"{name}, {method} with {tolerance:g}, {result.ledger.steps} steps"
    # of the rows, not by the ledger: the solver's own sum is what is looked at
    energy = result.energy["total"]
    kinetic = result.energy["kinetic"]
    moved = (kinetic + np.abs(energy - kinetic - (energy[0] - kinetic[0]))).max()
    lost = np.abs(energy - energy[0])
    made = result.ledger.steps * result.time / end
    allowed = (ALLOWED * tolerance + ENERGY_ROUNDING_OF_STEPS) * np.maximum(made, 1000.0) * moved
    allowed += 1e-13 * np.abs(energy[0])
    k = int(np.argmax(lost / allowed))
    outcome.count("steps of conservative motions", result.ledger.steps)
    outcome.count("motions that are not trusted", int(not result.ledger.trust.is_trusted))
    label = "energy lost (of what steps and rounding may lose)"
    outcome.measure(label, lost[k] / allowed[k], f"{where}, at {result.time[k]:.4g} s", limit=1.0)
    steep = growth(result.time[1:], lost[1:] / moved)
    # a sum of errors grows with 1, a sum of sums with 2
    outcome.measure("growth of the energy lost with time (exponent)", steep, where, limit=1.5)
    row, largest = f"{name}, {method} with {tolerance:g}", np.maximum.accumulate(lost / moved)
    outcome.tabulate("growth of the energy lost with time (exponent)", row, "fitted", steep, where)
    for column, (written, drift) in met.items():
        at = f"{where}, after {column} steps"
        of_energy = largest[written - 1]
        outcome.tabulate("energy lost, by steps (of what moves)", row, column, of_energy, at)
        outcome.tabulate("drift of constraints, by steps (m)", row, column, drift, at)
    outcome.measure("constraints at the end (m)", position, where, limit=1e-9)
    seen, label = open_by(name, scene, result), "constraints at the end, seen from outside (m, rad)"
    outcome.measure(label, seen, where, limit=2.0 * position + OPEN)
    drifts = [drift for _, drift in met.values()]
    of_a_tenth = position / max(drifts[-2:][0], 1e-15)  # a column is ten times the one before
    outcome.measure("constraints at the end (of a tenth)", of_a_tenth, where, limit=30.0)


def open_by(name: str, scene: Any, result: Any) -> float:
    """Largest distance that joints are open in the last row, as the independent evaluator says."""
    tree = tomllib.loads((ROOT / "scenes" / f"{name}.toml").read_text(encoding="utf-8"))
    comparison = Comparison(tree, scene)
    t, q, v = result.state(len(result) - 1)
    evaluator = comparison.evaluator
    found = evaluator.evaluate(t, evaluator.state_of(q.tolist(), v.tolist()))
    return size_of(found.C / comparison.scales(found))


def driven(outcome: Outcome, method: str, turns: str) -> None:
    """Look at a crank that is led after many turns: angles count, and all is where it was."""
    scene, number = ks.load(LED), int(turns)
    rows = np.unique(np.geomspace(1, number, 40).round())
    parts = np.array([0.0, 0.2, 0.55])
    times = np.concatenate((parts, (rows[:, None] + parts).ravel()))
    options: dict[str, Any] = {"method": method, "most_steps": 10**9}
    result = scene.simulate(times=times, **options)
    outcome.count(f"turns of a crank that is led, {method}", number)
    where = f"{number} turns, {method}"
    angle = 2.0 * math.pi * result.time
    unit = np.maximum(np.spacing(angle), np.spacing(1.0))
    # lengths as exact as the angle that leads them
    place = 0.1 * np.cos(angle) + np.sqrt(0.09 - (0.1 * np.sin(angle)) ** 2) - 0.4
    for name, wanted in (("turn", angle), ("wheel_turn", -3.0 * angle), ("place", place)):
        for column, mark in marks(number).items():
            drift = np.abs(result[name] - wanted)[result.time < mark + 1].max()
            at = f"{where}, up to turn {mark}"
            table = "drift of a crank that is led, by turns (rad, m)"
            outcome.tabulate(table, f"{name}, {method}", column, drift, at)
    for name, wanted in (("turn", angle), ("wheel_turn", -3.0 * angle)):
        off = np.abs(result[name] - wanted) / np.maximum(np.spacing(np.abs(wanted)), unit)
        k = int(off.argmax())
        label = "angle that counts (units in the last place)"
        outcome.measure(label, off[k], f"{name}, turn {result.time[k]:.0f}, {where}", limit=16.0)
    off = np.abs(result["place"] - place) / (unit + 1e-15)
    k = int(off.argmax())
    label = "place of the slider (m, of the rounding of its angle)"
    outcome.measure(label, off[k], f"turn {result.time[k]:.0f}, {where}", limit=16.0)


def linkage(outcome: Outcome, name: str, turns: str) -> None:
    """Look at a linkage of nodes that makes turn after turn: each is as the first.

    So is the last one where it alone is asked for.
    """
    scene: Any = ks.load(ROOT / "scenes" / f"{name}.toml")
    number = int(turns)
    made = turns_of(scene.solve(turns=number, divisions=DIVISIONS))
    asked = turns_of(scene.solve(first_turn=number - 1, divisions=DIVISIONS))
    outcome.count("turns of a linkage, one after the other", len(made))
    off = np.abs(made - made[0]).max(axis=(1, 2))
    for column, mark in marks(number).items():
        k = int(off[:mark].argmax())
        table = "turns of a linkage beside the first, by turns (relative)"
        outcome.tabulate(table, name, column, off[k], f"turn {k}")
    # the angle of the input has so many digits left
    limit = 64.0 * np.spacing(2.0 * math.pi * number)
    label = "a late turn of a linkage beside the first (relative)"
    outcome.measure(label, off.max(), f"{name}, turn {off.argmax()} of {number}", limit=limit)
    label = "the last turn of a linkage, asked for alone (relative)"
    outcome.measure(label, np.abs(asked - made[-1]).max(), f"{name}, {number}", limit=limit)


def turns_of(motion: Trajectory) -> Array:
    """Positions and velocities of each turn, relative to the largest: (turns, divisions, n)."""
    q, v = (np.hstack([*of_nodes.values()]) for of_nodes in (motion.positions, motion.velocities))
    rows = np.hstack((q / np.abs(q).max(), v / max(np.abs(v).max(), 1.0)))
    return rows[:-1].reshape((-1, DIVISIONS, rows.shape[1]))


def chaotic(outcome: Outcome, end: str) -> None:
    """Compare means over a chaotic motion: of two tolerances, and of two methods.

    A motion that has lost energy on the way, which steps may, has another mean: by no more.
    """
    scene, blocks = ks.load(DOUBLE), 20
    times = np.linspace(0.0, float(end), 20 * int(end) + 1)
    means = []
    for number, (method, tolerance) in enumerate((*WAYS[:3], ("dopri5", 1e-11))):
        options: dict[str, Any] = {"method": method, "tolerance": tolerance}
        options["initial"] = {"first": 2.0 + 1e-9 * number, "second": 0.3}
        result: Any = scene.simulate(times=times, most_steps=10**9, **options)
        lost = np.abs(result.energy["total"] - result.energy["total"][0])
        allowed = (ALLOWED * tolerance + ENERGY_ROUNDING_OF_STEPS) * max(result.ledger.steps, 1000)
        where = f"{method} with {tolerance:g}, {result.ledger.steps} steps"
        outcome.count("steps of chaotic motions", result.ledger.steps)
        moved = result.energy["kinetic"].max()
        label = "energy lost (of what steps and rounding may lose)"
        outcome.measure(label, lost.max() / (allowed * moved), f"chaotic, {where}", limit=1.0)
        split = np.array_split(result.energy["kinetic"], blocks)
        means.append((where, np.array([part.mean() for part in split]), lost.mean()))
    *others, (best, usual, rest) = means
    for where, one, lost in others:
        error = math.sqrt((one.var() + usual.var()) / (blocks - 1))
        off = max(0.0, abs(one.mean() - usual.mean()) - lost - rest) / error
        label = "mean kinetic energy of a chaotic motion, two ways (standard errors)"
        outcome.measure(label, off, f"{where}; {best}", limit=5.0)


MOTIONS: dict[str, Callable[..., None]] = {
    "conservative": conservative,
    "driven": driven,
    "linkage": linkage,
    "chaotic": chaotic,
}


def long_steps() -> AbstractContextManager[object]:
    """Make steps as long as for a tolerance that is 10,000 times larger."""
    whole = Options.settings

    def longer(options: Options) -> Any:
        asked = whole(options)
        return asked._replace(tolerance=1e4 * asked.tolerance)

    return patch.object(Options, "settings", longer)


def pushed_off() -> AbstractContextManager[object]:
    """Push the first body off by 1e-6 in rows, of which the solver says nothing."""
    right = Run.finish

    def finish(*given: Any) -> Any:
        motion = right(*given)
        motion.rows = motion.rows + 1e-6 * (np.arange(motion.rows.shape[1]) == 1)
        return motion

    return patch.object(Run, "finish", finish)


def short_turns() -> AbstractContextManager[object]:
    """Read π with one digit wrong, the thirteenth."""
    pi = Fraction("3.141592653589893")
    return patch.dict("kousoku.model.expressions.parser.CONSTANTS", {"pi": pi})


QUESTION = Question(
    asks="long motions that keep their energy, many turns of those that are led, means of chaotic"
    " ones: what drifts, and how does it grow?",
    in_full="1,000,000 steps, and 100,000 turns of each that is led and of a linkage",
    cases=cases,
    run=run,
    needs_compiler=True,
    faults=(
        Fault(
            "steps are too long for their tolerance", long_steps, "conservative pendulum 1 20000"
        ),
        Fault("joints that open in silence", pushed_off, "conservative n_four_bar 1 2000"),
        Fault("π has a wrong digit, the thirteenth", short_turns, "driven kinematics 300"),
    ),
)
