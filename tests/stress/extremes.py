"""Scenes that take digits: mass ratios and springs to 1e12, singular places and what is near them.

What a run gives at its rows is compared with the same equations in 60 digits, in units of what
rounding the scene's own numbers costs there. It may lose more where its verdict says so, or refuse.
"""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import kousoku as ks
from kousoku.model.errors import NoCompilerError
from tests.stress.kit import Fault, Outcome, Question, Size
from tests.stress.planar import (
    GROUND,
    MP,
    Bar,
    Hinge,
    Scene,
    Spring,
    State,
    left,
    solution,
    units,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

#: Units that a solver may lose: some hundred roundings on its way to a number.
LIMIT = 1000.0


def bar(at: Any, mass: float, angle: float = 0.0, omega: float = 0.0, length: float = 1.0) -> Bar:
    """Return a bar from its origin along its x axis, not quite symmetric."""
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
    masses: tuple[float, float, float] = (1.0, 1.0, 1.0),
    lean: float = 0.0,
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
    bars = {
        "crank": bar((0.0, 0.0), masses[0], turned, omega, lengths[0]),
        "coupler": bar(end, masses[1], float(beta), 0.0, lengths[1]),
        "rocker": bar((lengths[3], 0.0), masses[2], float(gamma), 0.0, lengths[2]),
    }
    hinges = {
        "A": Hinge(GROUND, "crank", (0.0, 0.0), (0.0, 0.0)),
        "B": Hinge("crank", "coupler", (lengths[0], 0.0), (0.0, 0.0)),
        "C": Hinge("coupler", "rocker", (lengths[1], 0.0), (lengths[2], 0.0)),
        "D": Hinge(GROUND, "rocker", (lengths[3], 0.0), (0.0, 0.0)),
    }
    return Scene(bars, hinges, lean=lean)


def heavy_loop(draw: random.Random) -> Scene:
    """Return a four-bar of masses that differ by up to 1e12."""
    masses = [10 ** draw.choice((0, draw.uniform(-6, 6), -6, 6)) for _ in range(3)]
    return four_bar(
        (1.0, 3.0, 2.0, 3.0), draw.uniform(0.5, 2.5), draw.uniform(-1, 1), tuple(masses)
    )


def change_point(draw: random.Random) -> Scene:
    """Return a parallelogram near the position in which all bars lie in line, or there."""
    near = draw.choice((0.0, 10 ** draw.uniform(-12, -1)))
    return four_bar((1.0, 2.0, 1.0, 2.0), near, 1.0)


def dead_centre(draw: random.Random) -> Scene:
    """Return a crank-rocker whose coupler is nearly in line with its rocker's or crank's end."""
    # Without a driver nothing is singular here: a triple rocker whose crank stops at its end.
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
    """Return a four-bar whose last axis leans by 1e-12 to 0.1."""
    return four_bar((1.0, 3.0, 2.0, 3.0), 1.0, 0.5, lean=10 ** draw.uniform(-12, -1))


def coincident(draw: random.Random) -> Scene:
    """Return a four-bar one bar of which has its pins in one place, or nearly."""
    short = draw.choice((0.0, 10 ** draw.uniform(-12, -3)))
    lengths = draw.choice(((short, 3.0, 2.0, 3.0), (1.0, short, 2.2, 3.0), (1.0, 3.0, short, 3.5)))
    scene = four_bar((1.0, 3.0, 2.0, 3.0), 1.0, 0.0)
    del lengths
    bars = dict(scene.bars)
    hinges = dict(scene.hinges)
    which = draw.choice(("crank", "rocker"))
    # A small body between the ground and the bar, which turns about pins so near to each other.
    old = hinges["A" if which == "crank" else "D"]
    bars["small"] = bar(tuple(float(x) for x in old.s_i), 1.0, draw.uniform(-3, 3), 0.0, 1.0)
    hinges["A" if which == "crank" else "D"] = Hinge("small", which, (short, 0.0), old.s_j)
    hinges["E"] = Hinge(GROUND, "small", old.s_i, (0.0, 0.0))
    return Scene(bars, hinges)


FAMILIES: dict[str, Callable[[random.Random], Scene]] = {
    "mass ratios to 1e12 in a chain": chain,
    "mass ratios to 1e12 in a loop": heavy_loop,
    "springs to 1e12 N/m": stiff,
    "change points of a parallelogram": change_point,
    "ends of a crank's way": dead_centre,
    "axes that lean by 1e-12 to 0.1": leaning,
    "pins in one place": coincident,
}


def states_of(run: Any, row: int, names: Any) -> dict[str, State]:
    """Return the state of each body in a row, as the doubles that it is."""
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
    """Return accelerations and forces of a row, as :meth:`Solution.numbers` names them."""
    found = {}
    for name in scene.bars:
        body = run.body(name)
        found[f"{name}.ax"], found[f"{name}.ay"], _ = body.acceleration[row].tolist()
        found[f"{name}.alpha"] = body.angular_acceleration[row][2].item()
    for name in scene.hinges:
        found[f"{name}.fx"], found[f"{name}.fy"], _ = run.force[name][row].tolist()
    return found
