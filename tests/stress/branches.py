"""Driven linkages whose branches meet, or come near: on their branch, or not trusted.

Four-bars, parallelograms and slider-cranks miss a place where branches meet by a gap of 1e-13 to
1e-3 of a metre, or by none, or by so much that nothing may be doubted. Closed forms tell where they
are; where branches do meet motions go straight on.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import numpy as np

import kousoku as ks
from kousoku.model.errors import KousokuError, MotionError
from kousoku.runtime.integrate import trust
from kousoku.runtime.integrate.settings import Doubt
from tests.stress.kit import Fault, Outcome, Question, Size
from tests.stress.scenes import STOPS, quick_to_compile, reason_of, stopping, told

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager

    Array = Any

RUNS = 12
"""Motions of a linkage, by three methods in turn."""

HEALTHY = 1e-2
"""A gap with which a motion must be trusted [m]."""

OFF = 1e-6
"""How far a motion may be off, where branches are ten times as far from each other [m]."""

MOST_STEPS = 10_000
"""Steps of a motion at most: nearer to where branches meet than its tolerance tells one may take
millions, and tells that. Others have hundreds."""

METHODS = ("kinematics", "dop853", "dopri5")
LAWS: dict[str, Callable[[Any, float], Any]] = {
    "even": lambda x, _: x,
    "swinging": lambda x, amplitude: amplitude * np.sin(x),
    "uneven": lambda x, _: x - 0.9 * np.sin(x),
}
TEXTS = {"even": "rate*t", "swinging": "amp*sin(rate*t)", "uneven": "rate*t - 0.9*sin(rate*t)"}


@dataclass(frozen=True, slots=True)
class Linkage:
    """A linkage, and what its closed form says.

    Parameters
    ----------
    text : str
        The scene.
    start : float [rad]
        The angle of its crank.
    law : str
        How that is driven.
    end_of : callable
        Returns the end of its second bar by angles of the crank and a sign for each, 1 on the
        branch on which it starts.
    meets : tuple of float [rad]
        Angles of the crank at which branches meet, or nearly.
    bar : (str, float)
        That bar, and its length [m].
    gap : float [m]
        By how much they miss each other.
    """

    text: str
    start: float
    law: str
    end_of: Callable[[Array, Array], Array]
    meets: tuple[float, ...]
    bar: tuple[str, float]
    gap: float


def cases(size: Size) -> Iterator[str]:
    """Name a case for each linkage."""
    for k in range(size.examples(4, 40)):
        yield f"near {size.seed} {k}"


def body(name: str, at: tuple[float, float], angle: float, length: float, mass: float) -> str:
    """Bar that begins at a place."""
    box = f"{{ mass = {mass!r}, size = [{length!r}, 0.1, 0.1], at = [{length / 2!r}, 0, 0] }}"
    turn = f"{{ axis = [0, 0, 1], angle = {angle!r} }}"
    place = f"position = [{at[0]!r}, {at[1]!r}, 0]\norientation = {turn}\nboxes = [{box}]\n"
    return f"[bodies.{name}]\n{place}"


def joined(bodies: dict[str, tuple[float, float, float, float]], pins: str, law: str) -> str:
    """Scene of bars, by place, angle and length, with the joints that close it."""
    parameters = "rate = 1.0\n" + "amp = 1.0\n" * (law == "swinging")
    bars = "".join(body(n, (x, y), a, b, round(b, 2)) for n, (x, y, a, b) in bodies.items())
    return (
        f'name = "near"\nunit = "m"\ngravity = [0, -9.81, 0]\n[parameters]\n{parameters}{bars}'
        f'[joints]\n{pins}[drivers]\nmotor = {{ joint = "a", value = "{TEXTS[law]}" }}\n'
    )


def pin(name: str, one: str, x: float, other: str, y: float) -> str:
    """Hinge at a place along each of two bars."""
    pair = f'bodies = ["{one}", "{other}"], points = [[{x!r}, 0, 0], [{y!r}, 0, 0]]'
    return f'{name} = {{ type = "revolute", {pair}, axes = [[0, 0, 1], [0, 0, 1]] }}\n'


def four_bar(draw: random.Random, gap: float, law: str) -> Linkage:
    """Four-bar that nearly lies flat where its crank points away, or to the other pin."""
    crank = draw.uniform(0.3, 1.5)
    ground = crank * draw.uniform(1.3, 4.0)
    kind = draw.choice(("parallelogram", "stretched", "folded"))
    total, apart = ground + crank + gap, ground - crank - gap
    if kind == "stretched":
        apart = (ground - crank) * draw.uniform(-0.8, 0.8)
    elif kind == "folded":
        apart, total = ground - crank - gap, (ground + crank) * draw.uniform(1.15, 2.0)
    coupler = ground if kind == "parallelogram" else (total + apart) / 2
    rocker = crank + gap if kind == "parallelogram" else total - coupler
    start, side = draw.uniform(-3.0, 3.0), draw.choice((-1.0, 1.0))

    def end_of(angle: Array, sign: Array) -> Array:
        at = crank * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        way = np.array([ground, 0.0]) - at
        far = np.hypot(way[..., 0], way[..., 1])
        outer = (coupler + rocker + far) * (coupler + rocker - far)  # so that no digits are lost
        area = np.maximum(outer * (far + coupler - rocker) * (far - coupler + rocker), 0.0)
        along = ((coupler - rocker) * (coupler + rocker) + far * far) / (2 * far)
        across = side * sign * np.sqrt(area) / (2 * far)
        normal = np.stack([-way[..., 1], way[..., 0]], axis=-1)
        return at + (along / far)[..., None] * way + (across / far)[..., None] * normal

    x, y = crank * math.cos(start), crank * math.sin(start)
    meet = end_of(np.array(start), np.array(1.0)).tolist()
    bodies = {
        "crank": (0.0, 0.0, start, crank),
        "coupler": (x, y, math.atan2(meet[1] - y, meet[0] - x), coupler),
        "rocker": (ground, 0.0, math.atan2(meet[1], meet[0] - ground), rocker),
    }
    pins = pin("a", "ground", 0.0, "crank", 0.0) + pin("b", "crank", crank, "coupler", 0.0)
    pins += pin("c", "coupler", coupler, "rocker", rocker)
    pins += pin("d", "ground", ground, "rocker", 0.0)
    meets = {"parallelogram": (0.0, math.pi), "stretched": (math.pi,), "folded": (0.0,)}[kind]
    text = joined(bodies, pins, law)
    return Linkage(text, start, law, end_of, meets, ("coupler", coupler), gap)


def slider_crank(draw: random.Random, gap: float, law: str) -> Linkage:
    """Slider-crank whose rod is nearly across the slide where its crank is."""
    crank = draw.uniform(0.3, 1.5)
    offset = draw.choice((0.0, crank * draw.uniform(-0.8, 0.8)))
    rod = crank + abs(offset) + gap
    start, side = draw.uniform(-3.0, 3.0), draw.choice((-1.0, 1.0))

    def end_of(angle: Array, sign: Array) -> Array:
        up = np.abs(offset - crank * np.sin(angle))
        across = side * sign * np.sqrt(np.maximum((rod - up) * (rod + up), 0.0))
        return np.stack([crank * np.cos(angle) + across, offset + 0.0 * angle], axis=-1)

    x, y = crank * math.cos(start), crank * math.sin(start)
    slider = float(end_of(np.array(start), np.array(1.0))[0])
    bodies = {
        "crank": (0.0, 0.0, start, crank),
        "rod": (x, y, math.atan2(offset - y, slider - x), rod),
        "slider": (slider, offset, 0.0, 0.3 * crank),
    }
    pins = pin("a", "ground", 0.0, "crank", 0.0) + pin("b", "crank", crank, "rod", 0.0)
    pins += pin("c", "rod", rod, "slider", 0.0)
    pair = f'bodies = ["ground", "slider"], points = [[0, {offset!r}, 0], [0, 0, 0]]'
    pins += f'd = {{ type = "prismatic", {pair}, axes = [[1, 0, 0], [1, 0, 0]] }}\n'
    up, down = math.pi / 2, -math.pi / 2
    meets = (up, down) if offset == 0.0 else (down if offset > 0.0 else up,)
    return Linkage(joined(bodies, pins, law), start, law, end_of, meets, ("rod", rod), gap)


def random_linkage(draw: random.Random) -> Linkage:
    """Linkage with a gap of any size, or none."""
    gap = draw.choice((0.0, *(10 ** draw.uniform(-13.0, -2.7) for _ in range(8)), 10**-1.5))
    return draw.choice((four_bar, slider_crank))(draw, gap, draw.choice(tuple(TEXTS)))


def signs_of(linkage: Linkage, angle_at: Callable[[Array], Array], times: Array) -> Array:
    """Branch at times, 1 or -1: where branches meet the motion goes straight on to the other."""
    if linkage.gap > 0.0:
        return np.ones_like(times)
    fine = np.unique(np.concatenate([np.linspace(0.0, times[-1], 20001), times]))
    passed = np.zeros_like(fine)
    for meet in linkage.meets:
        turns = np.floor((angle_at(fine) - meet) / math.tau)
        passed[1:] += np.cumsum(np.abs(np.diff(turns)))
    return np.where(passed[np.searchsorted(fine, times)] % 2 == 0, 1.0, -1.0)


def is_on_branch(linkage: Linkage, angle_at: Callable[[Array], Array], motion: Any) -> bool:
    """Whether no row of a motion is on the other branch."""
    name, length = linkage.bar
    e0, e3 = motion.orientation[name][:, 0], motion.orientation[name][:, 3]
    turned = np.stack([e0 * e0 - e3 * e3, 2 * e0 * e3], axis=-1)
    there = motion.position[name][:, :2] + length * turned
    angle, sign = angle_at(motion.time), signs_of(linkage, angle_at, motion.time)
    own, other = linkage.end_of(angle, sign), linkage.end_of(angle, -sign)
    off, apart = (np.hypot(*(one - own).T) for one in (there, other))
    is_other = np.hypot(*(there - other).T) < off
    return not bool(np.any(is_other & (off > OFF) & (apart > 10 * OFF)))


def run(case: str) -> Outcome:
    """Move a linkage by all methods, at many speeds and tolerances."""
    _, seed, k = case.split()
    draw, outcome = random.Random(f"{seed} {k}"), Outcome()
    linkage = random_linkage(draw)
    with quick_to_compile():
        mechanism = ks.load(linkage.text, target="c")
        for n in range(RUNS):
            move(linkage, mechanism, METHODS[n % len(METHODS)], draw, outcome)
    return outcome


def move(
    linkage: Linkage, mechanism: Any, method: Any, draw: random.Random, outcome: Outcome
) -> None:
    """Move a linkage once, and judge what is said of it."""
    rate = draw.choice((-1.0, 1.0)) * 10 ** draw.uniform(-1.0, 2.0)
    amplitude = draw.uniform(1.0, 3.0) * (draw.choice(linkage.meets) - linkage.start)
    times = np.linspace(0.0, draw.uniform(0.3, 2.5) * math.tau / abs(rate), draw.choice((2, 6, 51)))
    tolerance = 10 ** draw.uniform(-10.0, -3.0)
    given = {"rate": rate} | ({"amp": amplitude} if linkage.law == "swinging" else {})

    def angle_at(t: Array) -> Array:
        return linkage.start + LAWS[linkage.law](rate * t, amplitude)

    outcome.count("motions")
    options = {"method": method, "tolerance": tolerance, "parameters": given}
    options |= {"most_steps": MOST_STEPS}
    place = f"gap {linkage.gap:.3g} m, {options}, {len(times)} rows to {times[-1]!r} s"
    try:
        motion = mechanism.simulate(times=times, **options)
    except MotionError as stop:
        told(outcome, stop, "stopped", STOPS, place, near__toml=linkage.text)
        return
    except KousokuError as error:
        outcome.find(f"refused: {reason_of(error)}", place, near__toml=linkage.text)
        return
    verdict, is_there = motion.ledger.trust, is_on_branch(linkage, angle_at, motion)
    outcome.count(
        f"{'on' if is_there else 'off'} their branch, {'' if verdict.is_trusted else 'not '}trusted"
    )
    if verdict.is_trusted and not is_there:
        outcome.find(f"{method} is on another branch and trusted", place, near__toml=linkage.text)
    if linkage.gap >= HEALTHY and motion.ledger.branch_points:
        outcome.find(f"{method} is doubted far from others", place, near__toml=linkage.text)


def nothing_doubted() -> AbstractContextManager[object]:
    """Let steps that may have leapt be no doubt."""
    right = trust.judge

    def wrong(*given: Any, **more: Any) -> Any:
        verdict = right(*given, **more)
        return verdict._replace(doubts=verdict.doubts & ~(Doubt.BRANCH_POINTS | Doubt.ENERGY))

    return patch.object(trust, "judge", wrong)


QUESTION = Question(
    asks="driven four-bars, parallelograms and slider-cranks that pass places where branches of"
    " their motion meet, or come near: are they on their branch, as closed forms say, or not"
    " trusted?",
    cases=cases,
    run=run,
    faults=(
        Fault("steps that leap are no doubt", nothing_doubted, "near 1 19"),
        Fault("motions that stop for no reason", stopping, "near 1 19"),
    ),
    needs_compiler=True,
)
