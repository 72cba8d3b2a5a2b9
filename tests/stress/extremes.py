"""Scenes that take digits: mass ratios and springs to 1e12, singular places and what is near them.

What a run gives at its rows is compared with the same equations in 60 digits, in units of what
rounding the scene's own numbers costs there. It may lose more where its verdict says so, or refuse.
"""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import numpy as np

import kousoku as ks
from kousoku.codegen.dynamics import analyse
from kousoku.codegen.dynamics.simplification import body_blocks
from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.reading.write import toml_of
from tests.stress.kit import Fault, Outcome, Question, Size
from tests.stress.planar import (
    GROUND,
    MP,
    Bar,
    Hinge,
    Scene,
    Spring,
    State,
    solution,
    units,
)
from tests.stress.scenes import HOLDS, NO_STEP, stopping

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from contextlib import AbstractContextManager

#: Digits that a solver may lose of those that rounding leaves. Accelerations are refined where a
#: run begins with more than 2·10⁻¹² of them lost, 4.3 digits, or pivots fall below 10⁻⁴ of what is
#: usual; on the way from there it may become some times as much.
MOST_LOST = 5
#: Accelerations of bodies that cannot move, by rounding [m/s², rad/s²].
RESTS = 1e-6
#: Of rows that are left out accelerations change by some times what these miss.
MISSED = 100.0
#: Rows that hold so much beyond the others are independent: a hundred closure tolerances.
INDEPENDENT = 1e-3


def bar(at: Any, mass: float, angle: float = 0.0, omega: float = 0.0, length: float = 1.0) -> Bar:
    """Bar from its origin along its x axis, not quite symmetric."""
    center = (0.5 * length, 0.03 * length)
    return Bar(at, mass, center, 0.1 * mass * length**2, angle, omega)


def chain(draw: random.Random) -> Scene:
    """Three bars that hang on each other, of masses that differ by up to 1e12."""
    bars, hinges, at, before = {}, {}, (0.0, 0.0), GROUND
    for k in range(3):
        angle = draw.uniform(-3, 3)
        mass = 10 ** draw.choice((0, draw.uniform(-6, 6), -6, 6))
        bars[f"b{k}"] = bar(at, mass, angle, draw.uniform(-1, 1))
        end = (1.0, 0.0) if k else (0.0, 0.0)
        hinges[f"h{k}"] = Hinge(before, f"b{k}", end, (0.0, 0.0))
        at = (at[0] + math.cos(angle), at[1] + math.sin(angle))
        before = f"b{k}"
    return Scene(bars, hinges)


def four_bar(
    lengths: tuple[float, float, float, float],
    turned: float,
    omega: float,
    masses: Sequence[float] = (1.0, 1.0, 1.0),
    **more: Any,
) -> Scene:
    """Crank, coupler, rocker and ground, closed by the circles' upper intersection."""
    a, b, c, d = (MP.mpf(x) for x in lengths)
    x, y = a * MP.cos(turned), a * MP.sin(turned)
    reach = MP.hypot(d - x, y)
    along = (reach**2 + b**2 - c**2) / (2 * reach)
    high = MP.sqrt(max(b**2 - along**2, 0))
    ex, ey = (d - x) / reach, -y / reach
    px, py = x + along * ex - high * ey, y + along * ey + high * ex
    beta, gamma = MP.atan2(py - y, px - x), MP.atan2(py, px - d)
    end = (float(x), float(y))
    # Rates that fit: what the ends of coupler and rocker do along each other.
    spread = MP.sin(gamma - beta) or MP.inf
    of_coupler = float(omega * a * MP.sin(turned - gamma) / (b * spread))
    of_rocker = float(omega * a * MP.sin(turned - beta) / (c * spread))
    bars = {
        "crank": bar((0.0, 0.0), masses[0], turned, omega, lengths[0]),
        "coupler": bar(end, masses[1], float(beta), of_coupler, lengths[1]),
        "rocker": bar((lengths[3], 0.0), masses[2], float(gamma), of_rocker, lengths[2]),
    }
    hinges = {
        "A": Hinge(GROUND, "crank", (0.0, 0.0), (0.0, 0.0)),
        "B": Hinge("crank", "coupler", (lengths[0], 0.0), (0.0, 0.0)),
        "C": Hinge("coupler", "rocker", (lengths[1], 0.0), (lengths[2], 0.0)),
        "D": Hinge(GROUND, "rocker", (lengths[3], 0.0), (0.0, 0.0)),
    }
    return Scene(bars, hinges, **more)


def heavy_loop(draw: random.Random) -> Scene:
    """Four-bar of masses that differ by up to 1e12."""
    masses = [10 ** draw.choice((0, draw.uniform(-6, 6), -6, 6)) for _ in range(3)]
    return four_bar(
        (1.0, 3.0, 2.0, 3.0), draw.uniform(0.5, 2.5), draw.uniform(-1, 1), tuple(masses)
    )


def change_point(draw: random.Random) -> Scene:
    """Parallelogram near the position in which all bars lie in line, or there."""
    near = draw.choice((0.0, 10 ** draw.uniform(-12, -1)))
    return four_bar((1.0, 2.0, 1.0, 2.0), near, 1.0)


def dead_centre(draw: random.Random) -> Scene:
    """Crank near the end of its way, or there: coupler and rocker lie in line."""
    near = draw.choice((0.0, 10 ** draw.uniform(-12, -1)))
    a, b, c, d = 2.0, 1.0, 1.5, 2.2
    end = math.acos((a * a + d * d - (b + c) ** 2) / (2 * a * d))
    return four_bar((a, b, c, d), end - near, 0.0)


def stiff(draw: random.Random) -> Scene:
    """Two bars and a spring of up to 1e12 N/m from the end of the last to the ground."""
    scene = chain(random.Random(draw.random()))
    bars = {name: scene.bars[name] for name in ("b0", "b1")}
    hinges = {name: scene.hinges[name] for name in ("h0", "h1")}
    bars = {k: bar(x.at, 1.0, x.angle, x.omega) for k, x in bars.items()}
    last = bars["b1"]
    x = last.at[0] + math.cos(last.angle)
    y = last.at[1] + math.sin(last.angle)
    anchor = (x + draw.uniform(0.5, 1), y - draw.uniform(0.5, 1))
    stiffness = 10 ** draw.choice((12, draw.uniform(3, 12)))
    free = math.hypot(anchor[0] - x, anchor[1] - y) * (1 - 10 / stiffness)
    spring = Spring("b1", GROUND, (1.0, 0.0), anchor, stiffness, free)
    return Scene(bars, hinges, {"k": spring})


def leaning(draw: random.Random) -> Scene:
    """Four-bar whose last axis leans by 1e-12 to 0.1."""
    return four_bar((1.0, 3.0, 2.0, 3.0), 1.0, 0.5, nearly=10 ** draw.uniform(-12, -1), leans=True)


def coincident(draw: random.Random) -> Scene:
    """Four-bar on a small body whose two pins are in one place, or nearly."""
    short = draw.choice((0.0, 10 ** draw.uniform(-12, -3)))
    scene = four_bar((1.0, 3.0, 2.0, 3.0), 1.0, 0.0)
    bars, hinges = dict(scene.bars), dict(scene.hinges)
    pin, which = draw.choice((("A", "crank"), ("D", "rocker")))
    old = hinges[pin]
    bars["small"] = bar(old.s_i, 1.0, draw.uniform(-3, 3))
    hinges[pin] = Hinge("small", which, (short, 0.0), old.s_j)
    hinges["E"] = Hinge(GROUND, "small", old.s_i, (0.0, 0.0))
    return Scene(bars, hinges)


def two_pins(draw: random.Random) -> Scene:
    """Bar that two pins hold on the ground, 1e-12 to 0.1 m from each other."""
    apart, angle = draw.choice((0.0, 10 ** draw.uniform(-12, -1))), draw.uniform(-3, 3)
    end = (apart * math.cos(angle), apart * math.sin(angle))
    hinges = {
        "A": Hinge(GROUND, "b", (0.0, 0.0), (0.0, 0.0)),
        "F": Hinge(GROUND, "b", end, (apart, 0.0)),
    }
    return Scene({"b": bar((0.0, 0.0), 1.0, angle)}, hinges, nearly=apart)


FAMILIES: dict[str, Callable[[random.Random], Scene]] = {
    "mass ratios to 1e12 in a chain": chain,
    "mass ratios to 1e12 in a loop": heavy_loop,
    "springs to 1e12 N/m": stiff,
    "change points of a parallelogram": change_point,
    "ends of a crank's way": dead_centre,
    "axes that lean by 1e-12 to 0.1": leaning,
    "two pins 1e-12 to 0.1 m apart": two_pins,
    "bodies with both pins in one place": coincident,
}
#: Families of which some are refused, and for what: at some positions nothing is determined, and
#: rows that hold nearly nothing are told.
MAY_REFUSE = {
    "change points of a parallelogram": ("the start cannot be brought onto the constraints",),
    "axes that lean by 1e-12 to 0.1": (HOLDS,),
    "two pins 1e-12 to 0.1 m apart": (HOLDS,),
}
#: How long they are moved [s]: the end of a spring of 1e12 N/m swings in microseconds.
SPANS = {"springs to 1e12 N/m": (1e-6,)}
MOVES = (1e-3, 1.0)


def states_of(run: Any, row: int, names: Any) -> dict[str, State]:
    """State of each body in a row, as the doubles that it is."""
    found = {}
    for name in names:
        body = run.body(name)
        e0, _, _, e3 = (MP.mpf(float(x)) for x in body.orientation[row])
        found[name] = State(
            [float(x) for x in body.position[row][:2]],
            2 * MP.atan2(e3, e0),
            [float(x) for x in body.velocity[row][:2]],
            float(body.angular_velocity[row][2]),
        )
    return found


def numbers_of(run: Any, row: int, scene: Scene) -> dict[str, float]:
    """Accelerations and forces of a row, as :meth:`Solution.numbers` names them."""
    found = {}
    for name in scene.bars:
        body = run.body(name)
        found[f"{name}.ax"], found[f"{name}.ay"], _ = body.acceleration[row].tolist()
        found[f"{name}.alpha"] = body.angular_acceleration[row][2].item()
    for name in scene.hinges:
        found[f"{name}.fx"], found[f"{name}.fy"], _ = run.force[name][row].tolist()
    return found


def judge(outcome: Outcome, family: str, case: str, scene: Scene, span: float) -> None:
    """Run a scene, and compare its rows with 60 digits."""
    texts = {"planar__toml": toml_of(scene.tree)}
    command = f"kousoku simulate planar.toml --end {span:g} --samples 3"
    try:
        run = ks.load(scene.tree, target="numpy").simulate(span, samples=3)
    except ks.KousokuError as error:
        is_on_its_way = NO_STEP in str(error)
        way = "stopped on its way, in words" if is_on_its_way else "refused"
        outcome.count(f"{family}: {way}")
        known = MAY_REFUSE.get(family, ())
        if not (is_on_its_way or any(reason in str(error) for reason in known)):
            outcome.find(f"{family}: refused", f"{case}: {error}", command, **texts)
        return
    trusted = run.ledger.trust.is_trusted
    outcome.count(f"{family}: {'trusted' if trusted else 'not trusted, and the run says so'}")
    for row in range(len(run.time)):
        lost = digits_lost(outcome, family, scene, run, row)
        if lost is None:
            continue
        beyond, name = lost
        if trusted:
            outcome.measure(f"{family}: lost beyond rounding (digits)", beyond, f"{name}, {case}")
        if trusted and not beyond <= MOST_LOST:
            outcome.find(f"{family}: wrong without a word", f"{name}: {beyond:.1f} digits", **texts)


def digits_lost(
    outcome: Outcome, family: str, scene: Scene, run: Any, row: int
) -> tuple[float, str] | None:
    """Digits that a row lacks though its state determines them, and of which number.

    None where its forces are not determined, and it says so.
    """
    got = numbers_of(run, row, scene)
    if "nothing can move" in " ".join(run.notes):
        still = max(
            abs(x) for name, x in got.items() if "." in name and name.split(".")[1][0] == "a"
        )
        outcome.count(f"{family}: held, and the run says so")
        return (math.inf, "a body that cannot move moves") if still > RESTS else None
    if run.ledger.passed and any(math.isnan(x) for x in got.values()):
        outcome.count(f"{family}: rows without forces, which the ledger counts")
        return None
    # Of hinges that are redundant but for less than the tolerance one is left out.
    is_near = scene.nearly < INDEPENDENT
    kept = scene.without("F") if is_near and "F" in scene.hinges else scene
    states = states_of(run, row, scene.bars)
    try:
        wanted, unit = solution(kept, states).numbers(), units(kept, states, row)
    except ZeroDivisionError:
        return math.inf, "a position at which nothing is determined"
    forces = {name: x for name, x in wanted.items() if name.split(".")[0] in scene.hinges}
    missed = MISSED * scene.nearly if is_near else 0.0
    worst = (0.0, "")
    for name, x in wanted.items():
        if kept is not scene and name in forces:
            continue
        allowed = max(unit[name], MP.mpf(missed) * (1 + abs(x)) / 10**MOST_LOST)
        error = abs(MP.mpf(got[name]) - x) / allowed
        digits = math.inf if math.isnan(got[name]) else float(MP.log10(max(error, 1)))
        worst = max(worst, (digits, name))
    return worst


def cases(size: Size) -> Iterator[str]:
    """Name a case for each family and batch."""
    for batch in range(size.examples(1, 10)):
        for family in FAMILIES:
            yield f"{family}, {size.seed} {batch} {4 if size.is_full else 2}"


def run(case: str) -> Outcome:
    """Ask some scenes of a family."""
    outcome = Outcome()
    family, rest = case.split(", ")
    seed, batch, number = rest.split()
    for k in range(int(number)):
        name = f"{family}, {seed} {batch} {k}"
        scene = FAMILIES[family](random.Random(name))
        spans = SPANS.get(family, MOVES)
        judge(outcome, family, name, scene, spans[k % len(spans)])
    return outcome


def unrefined() -> AbstractContextManager[object]:
    """Compose chains of uneven masses without the refinement of their accelerations."""
    return patch.object(analyse, "has_extreme_mass_ratio", lambda _: False)


def single_masses() -> AbstractContextManager[object]:
    """Invert masses with the seven digits of single precision."""
    real = body_blocks.inverse_masses

    def rounded(*args: Any) -> list[Any]:
        return [CONTEXT.mpf(float(np.float32(float(x)))) for x in real(*args)]

    return patch.object(body_blocks, "inverse_masses", rounded)


QUESTION = Question(
    asks="mass ratios and springs to 1e12, rows that are nearly redundant, change points, dead"
    " centres, pins in one place: how many digits are lost against 60-digit solutions, beyond what"
    " rounding the scene's numbers costs, and is one lost without a word?",
    cases=cases,
    run=run,
    faults=(
        Fault(
            "chains of uneven masses that are not refined",
            unrefined,
            "mass ratios to 1e12 in a chain, 1 2 1",
        ),
        Fault("masses in single precision", single_masses, "mass ratios to 1e12 in a loop, 1 3 2"),
        Fault("motions that stop for no reason", stopping, "axes that lean by 1e-12 to 0.1, 1 1 1"),
    ),
)
