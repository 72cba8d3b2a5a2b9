"""Events of motions in closed form: whether each is found once, and where it is.

A cart goes evenly, swings on a spring, bounces off a stiff wall, or is led. An event is where it
passes places, or where its speed does, in formulas with waves, poles, gates and peaks. Passages are
bisected between the times at which the cart turns back.
"""

from __future__ import annotations

import itertools
import math
import random
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple
from unittest.mock import patch

import numpy as np

import kousoku as ks
from kousoku.model.errors import MotionError
from kousoku.model.operations.expression import ZERO
from tests.stress.kit import Fault, Outcome, Question, Size
from tests.stress.scenes import STOPS, quick_to_compile, stopping, told

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager

END = 4.9
"""When motions end [s]."""
RUNS = 32
"""Motions of a case."""
MOST_STEPS = 50_000
EXACT = 1e3
"""Error of a place or a speed at an event, in tolerances."""
APART = 1e4
"""How far a cart goes beyond the place of an event, in tolerances, before it turns back or the
motion ends; two events are as far from each other."""
STIFFNESS = 1e4
"""Of the wall [N/m], which 1 kg meets at 1 m/s."""
CONTACT = math.pi / math.sqrt(STIFFNESS)
"""How long it is met [s]."""


@dataclass(frozen=True, slots=True)
class Line:
    """Motion along a line.

    Parameters
    ----------
    lines : str
        What the scene says of it.
    place, speed : callable
        Of the time.
    turns : tuple of float [s]
        Where it turns back, and where its speed does.
    is_led : bool
        Whether a driver determines it.
    """

    lines: str
    place: Callable[[float], float]
    speed: Callable[[float], float]
    turns: tuple[float, ...] = ()
    is_led: bool = False


def at_wall(time: float) -> tuple[float, float]:
    """Place and speed of what meets a wall at 1 m."""
    rate, since = math.sqrt(STIFFNESS), time - 1.0
    if since <= 0.0:
        return time, 1.0
    if since < CONTACT:
        return 1.0 + math.sin(rate * since) / rate, math.cos(rate * since)
    return 1.0 - (since - CONTACT), -1.0


def along(law: str) -> str:
    """Force on the cart."""
    return f'[forces]\npush = {{ type = "along", coordinate = "x", force = "{law}" }}\n'


def led(law: str) -> str:
    """Driver of the cart."""
    return f'[drivers]\nroad = {{ coordinate = "x", value = "{law}" }}\n'


HALVES = tuple(math.pi / 2 * k for k in range(1, 4))
LINES = {
    "even": Line("", lambda t: t, lambda _: 1.0),
    "spring": Line(along("-x"), math.sin, math.cos, HALVES),
    "wall": Line(
        along(f"-{STIFFNESS:g}*max(0, x - 1)"),
        lambda t: at_wall(t)[0],
        lambda t: at_wall(t)[1],
        (1.0, 1.0 + CONTACT / 2, 1.0 + CONTACT),
    ),
    "led": Line(led("t"), lambda t: t, lambda _: 1.0, is_led=True),
    "led_to_and_fro": Line(led("sin(t)"), math.sin, math.cos, HALVES, is_led=True),
}


class Law(NamedTuple):
    """Formula of an event, of u, c and d, and what u passes there.

    Parameters
    ----------
    formula : str
        Where it is zero u is at one of the values; u is the place or the speed.
    values : callable
        Of c and d: those between -4 and 6.
    """

    formula: str
    values: Callable[[float, float], list[float]]

    @property
    def parameters(self) -> list[str]:
        """Those of c and d that it has."""
        return [name for name in ("c", "d") if re.search(rf"\b{name}\b", self.formula)]


def multiples(period: float, first: float = 0.0) -> list[float]:
    """Values at which a wave is zero."""
    ends = (math.floor((end - first) / period) for end in (-4.0, 6.0))
    return [first + period * k for k in range(*ends)]


LAWS = {
    "place": Law("u - c", lambda c, _: [c]),
    "cube": Law("(u - c)^3", lambda c, _: [c]),
    "two": Law("(u - c)*(u - d)", lambda c, d: [c, d]),
    "wave": Law("sin(9*u + c)", lambda c, _: multiples(math.pi / 9, -c / 9)),
    "cubed_wave": Law("sin(pi*u)^3", lambda *_: multiples(1.0)),
    "fine_wave": Law("sin(100*pi*u)", lambda *_: multiples(0.01)),
    "pole": Law("tan(3*u + c)", lambda c, _: multiples(math.pi / 3, -c / 3)),
    "gate": Law("max(0, 0.05 - abs(u - c))*(u - c)", lambda c, _: [c]),
    "smooth_gate": Law("exp(-((u - c)/0.02)^2)*(u - c)", lambda c, _: [c]),
    "window": Law("abs(u - c) - 0.001", lambda c, _: [c - 0.001, c + 0.001]),
    "root": Law("sign(u - c)*sqrt(abs(u - c))", lambda c, _: [c]),
    "quotient": Law("(u - c)/(2 + cos(7*u))", lambda c, _: [c]),
    "hill": Law(
        "1/(1 + ((u - c)/(0.02*(sin(3*u)^2 + cos(3*u)^2)))^2) - 0.5",
        lambda c, _: [c - 0.02, c + 0.02],
    ),
    "kinked_quotient": Law("sin(u)*abs(u - c)/sin(u) - 0.001", lambda c, _: [c - 0.001, c + 0.001]),
}
NAMES = {"place": "x", "speed": "x_dot"}


def cases(size: Size) -> Iterator[str]:
    """Name a case for each motion and law, of places and of speeds; some in the quick size."""
    every = [f"{line} {law} {what}" for line in LINES for law in LAWS for what in NAMES]
    count = size.examples(6, len(every))
    if not size.is_full:
        every = random.Random(size.seed).sample(every, min(count, len(every)))
    for case in every:
        yield f"{case} {size.seed}"


def scene(line: Line, law: Law, what: str) -> str:
    """Scene of a cart with one event."""
    formula = re.sub(r"\bu\b", NAMES[what], law.formula)
    return (
        'name = "events"\nunit = "m"\noutputs = ["coordinates"]\n'
        f"parameters = {{ {', '.join(f'{name} = 0.3' for name in law.parameters)} }}\n[bodies]\n"
        "cart = { point = true, position = [0, 0, 0]"
        f"{'' if line.is_led else ', velocity = [1, 0, 0]'}, mass = 1 }}\n"
        '[joints.line]\ntype = "point_on_line"\nbodies = ["ground", "cart"]\n'
        "points = [[0, 0, 0], [0, 0, 0]]\naxes = [[1, 0, 0], [1, 0, 0]]\n"
        '[coordinates]\nx = { body = "cart", along = [1, 0, 0] }\n'
        f'{line.lines}[events]\nany = {{ when = "{formula}" }}\n'
    )


def passages(line: Line, what: str, value: float) -> list[float]:
    """Times at which the place, or the speed, passes a value."""
    u = line.place if what == "place" else line.speed
    turns = [0.0, *(time for time in sorted({*line.turns, math.pi}) if time < END), END]
    found = []
    for first, last in itertools.pairwise(turns):
        low, high, rises = first, last, u(last) > u(first)
        if not min(u(first), u(last)) < value < max(u(first), u(last)):
            continue
        for _ in range(100):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if (u(middle) < value) == rises else (low, middle)
        found.append(low)
    return found


def is_clear(line: Line, what: str, values: list[float], apart: float) -> bool:
    """Whether no value is near to another, or to where the cart turns back, starts or ends."""
    u = line.place if what == "place" else line.speed
    ends = [u(time) for time in (0.0, *line.turns, END)]
    together = [*values, *ends]
    return all(abs(value - other) > apart for value in values for other in together
               if other is not value)  # fmt: skip


def run(case: str) -> Outcome:
    """Make motions with an event, and look for each passage."""
    name, law_name, what, _ = case.split()
    line, law, outcome = LINES[name], LAWS[law_name], Outcome()
    draw, text = random.Random(case), scene(line, law, what)
    with quick_to_compile():
        mechanism = ks.load(text, target="c")
        for _ in range(RUNS):
            ask(line, law, what, mechanism, draw, outcome, f"{case}: ", text)
    return outcome


def drawn_value(line: Line, what: str, draw: random.Random, tolerance: float) -> float:
    """Value that is passed: anywhere, or short of where the cart turns back."""
    u = line.place if what == "place" else line.speed
    reached = [u(k * END / 200) for k in range(201)] + [u(time) for time in line.turns]
    if draw.random() < 0.5:
        short = math.exp(draw.uniform(math.log(APART * tolerance), math.log(0.1)))
        return draw.choice((max(reached) - short, min(reached) + short))
    return draw.uniform(min(reached), max(reached))


def ask(
    line: Line,
    law: Law,
    what: str,
    mechanism: ks.Mechanism,
    draw: random.Random,
    outcome: Outcome,
    place: str,
    text: str,
) -> None:
    """Make a motion, and compare its events."""
    tolerance = 10.0 ** draw.uniform(-10.0, -6.0)
    c, d = (drawn_value(line, what, draw, tolerance) for _ in range(2))
    values = [value for value in law.values(c, d) if passages(line, what, value)]
    if not is_clear(line, what, values, APART * tolerance):
        outcome.count("drawn too near to where it turns back, and left out")
        return
    method: Any = draw.choice(("dop853", "dopri5", *["kinematics"] * line.is_led))
    options: dict[str, Any] = {"method": method, "tolerance": tolerance}
    given = {name: value for name, value in {"c": c, "d": d}.items() if name in law.parameters}
    options |= {"samples": draw.choice((2, 11, 101)), "parameters": given}
    outcome.count("motions")
    place += str(options)
    try:
        motion = mechanism.simulate(END, most_steps=MOST_STEPS, **options)
    except MotionError as stop:
        told(outcome, stop, "stopped", STOPS, place, events__toml=text)
        return
    wanted = sorted(time for value in values for time in passages(line, what, value))
    found = motion.events["any"].time
    outcome.count("events", len(wanted))
    if len(found) != len(wanted):
        title = "events are lost" if len(found) < len(wanted) else "events are made up"
        outcome.find(
            f"{title}, {law.formula} of {what}",
            f"{len(found)} of {len(wanted)}; {place}",
            events__toml=text,
        )
        return
    u = line.place if what == "place" else line.speed
    off = [abs(u(one) - u(other)) for one, other in zip(found, wanted, strict=True)]
    outcome.measure(
        "places and speeds at events (tolerances)",
        float(np.max(off, initial=0.0)) / tolerance,
        place,
        EXACT,
    )


def without_rates() -> AbstractContextManager[object]:
    """Let bounds of rates of formulas be zero."""
    return patch("kousoku.codegen.dynamics.composition.switching._rate", lambda *_: ZERO)


QUESTION = Question(
    asks="events of carts that go evenly, swing, bounce and are led, in formulas with waves, poles,"
    " gates and peaks: is each found once, and where it is?",
    cases=cases,
    run=run,
    faults=(
        Fault("bounds of rates that are none", without_rates, "spring window place 1"),
        Fault("motions that stop for no reason", stopping, "spring window place 1"),
    ),
    needs_compiler=True,
)
