"""Forces with a narrow hill in the argument of a function, in a factor, or behind a kink.

The work of a hill is an integral, which is computed here by halving intervals about it. No body
turns back, so that the work of a force of place is one of the place alone.
"""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.polynomial.legendre import leggauss

from tests.stress.force_laws import CART, END, SPEED, Form

if TYPE_CHECKING:
    import random
    from collections.abc import Callable

    from numpy.typing import NDArray

    import kousoku as ks
    from tests.stress.force_laws import Drawn

    Array = NDArray[np.float64]
    Function = Callable[[Array], Array]


ENERGY = 0.5 * SPEED * SPEED
"""Kinetic energy of the cart at its start [J]."""
MOST_WORK = 0.4 * ENERGY
"""Largest work of a force [J]: the cart never turns back."""
LOSABLE = 0.1
"""Part of the energy that errors are relative to: a thousand tolerances of it are a hundred of all,
which the verdict on energies lets a run lose."""
MANY = 1000
"""Random runs of the full size: many share a compiled scene."""


class Hill(NamedTuple):
    """Hill of a function of u, at a place, as scenes and as NumPy have it.

    Parameters
    ----------
    argument : str
        Function of u.
    function : callable
        Its value.
    is_low : bool
        Whether it is low beside a constant, whatever its width.
    is_secant : bool
        Whether it is a hyperbolic secant; else it is exp(-d²).
    """

    argument: str
    function: Callable[[Array], Array]
    is_low: bool = True
    is_secant: bool = False

    @property
    def text(self) -> str:
        """Formula of u, ``place``, ``width`` and ``size``."""
        there = re.sub(r"\bu\b", "place", self.argument)
        d = f"({self.argument} - ({there}))/width"
        shape = f"2/(exp({d}) + exp(-{d}))" if self.is_secant else f"exp(-({d})^2)"
        return f"size/(8*width)*{shape}" if self.is_low else f"size*{shape}"

    def value(self, u: Array, place: float, width: float, size: float) -> Array:
        """Value of the formula."""
        d = (self.function(u) - self.function(np.array(place))) / width
        if self.is_low:
            size = size / (8.0 * width)
        if self.is_secant:
            return size / np.cosh(np.clip(d, -300.0, 300.0))
        return size * np.exp(-(d**2))


PLAIN = Hill("u", lambda u: u, is_low=False)
CUBIC = "u - u^3/400", lambda u: u - u**3 / 400  # bounds of it are loose
CURVED, SECANT = Hill(*CUBIC), Hill(*CUBIC, is_secant=True)
RATIONAL = Hill("10*u/(5 + u)", lambda u: 10 * u / (5 + u))  # it has a pole


class Law(NamedTuple):
    """Force, as scenes and as NumPy have it: u is time, or place in the unit of a second's way.

    Parameters
    ----------
    formula : str
        Of u and of the hill h.
    value : callable
        Of u and of the value of the hill there.
    kink : float
        Where it has one, but for the hill.
    hill : Hill
        What h is.
    """

    formula: str
    value: Callable[[Array, Array], Array]
    kink: float = 0.0
    hill: Hill = PLAIN

    @property
    def text(self) -> str:
        """Formula of u alone."""
        return re.sub(r"\bh\b", self.hill.text, self.formula)


LAWS = {
    "sine": Law("sin(u/3 + h)", lambda u, h: np.sin(u / 3 + h)),
    "scaled": Law("sin((u/3 + h)/0.7)", lambda u, h: np.sin((u / 3 + h) / 0.7)),
    "magnitude": Law("cos(abs(u - 4 + h))", lambda u, h: np.cos(np.abs(u - 4 + h)), 4.0),
    "larger": Law("sin(max(u/3 + h, 1))", lambda u, h: np.sin(np.maximum(u / 3 + h, 1)), 3.0),
    "smaller": Law("cos(min(u/3 + h, 50)/2)", lambda u, h: np.cos((u / 3 + h) / 2)),
    "decay": Law("exp(-abs(u/9 + h))", lambda u, h: np.exp(-np.abs(u / 9 + h))),
    "logarithm": Law("log(max(u/3 + h, -9) + 10)", lambda u, h: np.log(u / 3 + h + 10)),
    "hypotenuse": Law("sqrt(1 + (u - 4 + h)^2)/4", lambda u, h: np.hypot(1, u - 4 + h) / 4),
    "reciprocal": Law("9/(9 + u + h)", lambda u, h: 9 / (9 + u + h)),
    "power": Law("(u/9 + h + 3)^1.5/4", lambda u, h: (u / 9 + h + 3) ** 1.5 / 4),
    "factor": Law("(2 + cos(u))*(1 + h)/3", lambda u, h: (2 + np.cos(u)) * (1 + h) / 3),
    "terms": Law(
        "(1 + u + u^2/9 + u^3/99 + h)*(1 + u/9 + u^2/99 + cos(u))/99",
        lambda u, h: (1 + u + u**2 / 9 + u**3 / 99 + h) * (1 + u / 9 + u**2 / 99 + np.cos(u)) / 99,
    ),
    "nested": Law("sin(u/3 + sin(u/3 + h))", lambda u, h: np.sin(u / 3 + np.sin(u / 3 + h))),
    "arctangent": Law("atan(u - 4 + h)", lambda u, h: np.arctan(u - 4 + h)),
    "angle": Law("atan2(u + 1 + h, 3)", lambda u, h: np.arctan2(u + 1 + h, 3)),
    "bell": Law("exp(-(u/3 - 1 + h)^2)", lambda u, h: np.exp(-((u / 3 - 1 + h) ** 2))),
    "product": Law("u*sin(u/3 + h)/9", lambda u, h: u * np.sin(u / 3 + h) / 9),
    "divisor": Law("1/(1 + h)", lambda _, h: 1 / (1 + h), hill=CURVED),
    "exponent": Law("exp(h)", lambda _, h: np.exp(h), hill=CURVED),
    "radicand": Law("sqrt(1 + h)", lambda _, h: np.sqrt(1 + h), hill=CURVED),
    "cosine": Law("cos(h)", lambda _, h: np.cos(h), hill=CURVED),
    "divisor_of_quotient": Law("1/(1 + h)", lambda _, h: 1 / (1 + h), hill=RATIONAL),
    "exponent_of_quotient": Law("exp(h)", lambda _, h: np.exp(h), hill=RATIONAL),
    "divisor_of_secant": Law("1/(1 + h)", lambda _, h: 1 / (1 + h), hill=SECANT),
    "exponent_of_secant": Law("exp(h)", lambda _, h: np.exp(h), hill=SECANT),
    "square": Law("(u*(2 + h))^2/400", lambda u, h: (u * (2 + h)) ** 2 / 400),
    "high_power": Law("1e-12*(u + h)^12", lambda u, h: 1e-12 * (u + h) ** 12),
}
NODES, WEIGHTS = leggauss(20)


def integral(function: Function, start: float, end: float, allowed: float) -> float:
    """Integral of a function, by halving until halves agree with the whole."""

    def gauss(first: float, last: float) -> float:
        half = 0.5 * (last - first)
        return half * float(WEIGHTS @ function(first + half * (1.0 + NODES)))

    middle = 0.5 * (start + end)
    halves = gauss(start, middle) + gauss(middle, end)
    if abs(halves - gauss(start, end)) <= allowed:
        return halves
    parts = ((start, middle), (middle, end))
    return sum(integral(function, first, last, allowed) for first, last in parts)


@dataclass(frozen=True, slots=True)
class Force:
    """Force of a law with its parameters, in newtons."""

    law: Law
    parameters: dict[str, float]
    height: float

    def __call__(self, u: Array) -> Array:
        """Value of the force."""
        place, width, size = (self.parameters[name] for name in ("place", "width", "size"))
        hill = self.law.hill.value(u, place, width, size)
        return self.height * self.law.value(u, hill)

    def impulse(self, end: float) -> float:
        """Integral from 0 to an end, of intervals that grow from the hill and the kink on."""
        width = self.parameters["width"]
        ways = width * 2.0 ** np.arange(-1.0, np.log2(END / width))
        middles = self.parameters["place"], self.law.kink
        cuts = np.concatenate([(0.0, end), *((x, *(x - ways), *(x + ways)) for x in middles)])
        cuts = np.unique(np.clip(cuts, 0.0, end))
        allowed = 1e-13 * end * float(np.abs(self(cuts)).max())
        return sum(integral(self, *ends, allowed) for ends in itertools.pairwise(cuts))


def draw(random_: random.Random) -> tuple[str, Force]:
    """Draw a force of a law, and the law's name."""
    name = random_.choice(list(LAWS))
    width = 10.0 ** random_.uniform(-4.0, -0.5)
    # one in five only reaches into the end of the motion
    place = random_.uniform(0.0, END) if random_.random() < 0.8 else END + 3.0 * width
    size = width * 10.0 ** random_.uniform(-1.0, 0.5) * random_.choice((-1.0, 1.0))
    height = random_.uniform(0.1, 1.0) * random_.choice((-1.0, 1.0)) * MOST_WORK / (SPEED * END)
    parameters = {"place": place, "width": width, "size": size, f"{name}_height": height}
    return name, Force(LAWS[name], parameters, height)


def of_place(random_: random.Random) -> Drawn:
    """Draw a force of place, with the work that it does up to where the cart then is."""
    name, force = draw(random_)

    def wanted(result: ks.Result) -> dict[str, tuple[float, float, float]]:
        cart = result.body("cart")
        work = SPEED * force.impulse(cart.position[-1, 0] / SPEED)
        kinetic = 0.5 * cart.velocity[-1, 0] ** 2
        allowed = LOSABLE * ENERGY
        return {
            "kinetic energy [J]": (kinetic, ENERGY + work, allowed),
            "work [J]": (result.ledger.works[name], work, allowed),
        }

    return force.parameters, wanted


def of_time(random_: random.Random) -> Drawn:
    """Draw a force of time, with the speed that it gives."""
    _, force = draw(random_)
    speed = SPEED + force.impulse(END)

    def wanted(result: ks.Result) -> dict[str, tuple[float, float, float]]:
        reached = result.body("cart").velocity[-1, 0]
        return {"speed [m/s]": (reached, speed, 0.5 * LOSABLE * SPEED)}

    return force.parameters, wanted


def led(random_: random.Random) -> Drawn:
    """Draw a force of place on a cart that is led, with its work."""
    name, force = draw(random_)
    work = SPEED * force.impulse(END)

    def wanted(result: ks.Result) -> dict[str, tuple[float, float, float]]:
        return {"work [J]": (result.ledger.works[name], work, LOSABLE * ENERGY)}

    return force.parameters, wanted


def scene(name: str, u: str) -> str:
    """Scene of a cart under all laws, each of a height of its own, which is zero."""
    parameters = {"place": 5.0, "width": 1.0, "size": 1.0} | {f"{law}_height": 0.0 for law in LAWS}
    written = ", ".join(f"{parameter} = {value}" for parameter, value in parameters.items())
    forces = ""
    for key, law in LAWS.items():
        force = re.sub(r"\bu\b", u, f"{key}_height*({law.text})")
        forces += f'{key} = {{ type = "along", coordinate = "x", force = "{force}" }}\n'
    text = CART.format(name=name, law="0")
    text = re.sub(r"parameters = .*", f"parameters = {{ {written} }}", text)
    return re.sub(r"wall = .*\n", forces, text)


PLACE = f"(x/{SPEED:g})"
ROAD = f'[drivers]\nroad = {{ coordinate = "x", value = "{SPEED:g}*t" }}\n'
FORMS = {
    "hidden_of_place": Form("hidden hills", scene("hidden_of_place", PLACE), of_place, MANY),
    "hidden_of_time": Form("hidden hills", scene("hidden_of_time", "t"), of_time, MANY),
    "hidden_led": Form(
        "hidden hills, kinematics", scene("hidden_led", PLACE) + ROAD, led, MANY, is_led=True
    ),
}
