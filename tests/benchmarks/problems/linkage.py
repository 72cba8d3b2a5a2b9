"""A linkage of nodes: a Stephenson six-bar, a turn of its crank in 60 divisions.

Its positions are where circles meet, one after the other: a closed form, by hand.
"""

from __future__ import annotations

import tomllib
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

import kousoku as ks
from tests.benchmarks.kit import Call, Case, Judged, required
from tests.benchmarks.problems.problem import SCENES

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.numbers.real import Array
    from tests.benchmarks.kit import Size

CONTEST, FILE = "linkage", SCENES / "stephenson_six_bar.toml"
DIVISIONS = 60
#: Largest residuals of loops [mm], and what moves kousoku: Newton's method, and that of the paper.
LIMITS = (1e-3, 1e-6, 1e-9, 1e-13)
METHODS = ("newton", "paper")
MOVING = ("A", "B", "P", "Q")
#: Where three nodes meet: the node, the ends of its two links, and these.
DYADS = (
    ("B", "A", "O3", "ab", "rocker1"),
    ("P", "A", "B", "pa", "bp"),
    ("Q", "P", "O6", "rod", "rocker2"),
)


def contests(size: Size) -> list[str]:
    """Its name."""
    return [CONTEST] if size.is_full else []


def given() -> tuple[dict[str, Array], dict[str, float]]:
    """Nodes' positions near which it starts, and the lengths of links, of the file."""
    scene = tomllib.loads(FILE.read_text(encoding="utf-8"))
    nodes = {name: np.array(one["at"], dtype=np.float64) for name, one in scene["nodes"].items()}
    return nodes, {name: float(one["length"]) for name, one in scene["links"].items()}


def by_circles(angles: Array) -> dict[str, Array]:
    """Positions of the nodes at angles of the crank, each on the side where it starts."""
    near, lengths = given()
    at = {name: np.tile(place, (len(angles), 1)) for name, place in near.items()}
    at["A"] = near["O1"] + lengths["crank"] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for name, first, second, to_first, to_second in DYADS:
        side = np.sign(_cross(near[second] - near[first], near[name] - near[first]))
        apart = at[second] - at[first]
        squared = np.sum(apart * apart, axis=1)
        along = (squared + lengths[to_first] ** 2 - lengths[to_second] ** 2) / (2 * squared)
        across = side * np.sqrt(lengths[to_first] ** 2 / squared - along**2)
        normal = np.stack([-apart[:, 1], apart[:, 0]], axis=1)
        at[name] = at[first] + along[:, None] * apart + across[:, None] * normal
    return at


def _cross(a: Array, b: Array) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _angles() -> Array:
    return np.linspace(0.0, 2 * np.pi, DIVISIONS + 1)


def _judged(found: Array) -> Judged:
    """Largest error of all nodes, relative to the crank."""
    wanted = by_circles(_angles())
    right = np.hstack([wanted[name] for name in MOVING])
    return Judged(float(np.abs(found - right).max()) / given()[1]["crank"])


def _kousoku(method: Any, limit: float) -> Call:
    mechanism = ks.load(FILE, target="c")

    def run() -> Any:
        return mechanism.solve(method=method, limit=limit, divisions=DIVISIONS)

    def judge() -> Judged:
        result = run()
        return _judged(np.hstack([result.node(name).position[:, :2] for name in MOVING]))

    return Call(run, judge, count=DIVISIONS)


def _scipy(limit: float) -> Call:
    """SciPy's MINPACK from division to division, with the Jacobian."""
    root = required("scipy.optimize").root
    near, lengths = given()
    angles = _angles()
    pins = near["O1"] + lengths["crank"] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    ends = [(name, *pair) for name, *pair in DYADS]
    free = [name for name, *_ in ends]
    bars = [
        (free.index(name), other, lengths[link])
        for name, first, second, to_first, to_second in ends
        for other, link in ((first, to_first), (second, to_second))
    ]

    def equations(x: Array, pin: Array) -> tuple[Array, Array]:
        value, slope = np.zeros(len(bars)), np.zeros((len(bars), len(x)))
        for k, (own, other, length) in enumerate(bars):
            end = pin if other == "A" else near[other]
            if other in free:
                end = x[2 * free.index(other) :][:2]
            apart = x[2 * own : 2 * own + 2] - end
            value[k] = (apart @ apart - length * length) / (2 * length)
            slope[k, 2 * own : 2 * own + 2] = apart / length
            if other in free:
                slope[k, 2 * free.index(other) :][:2] = -apart / length
        return value, slope

    def run() -> Array:
        x, rows = np.concatenate([near[name] for name in free]), []
        for pin in pins:
            x = root(equations, x, args=(pin,), jac=True, tol=limit / lengths["ab"]).x
            rows.append(np.concatenate([pin, x]))
        return np.array(rows)

    return Call(run, lambda: _judged(run()), count=DIVISIONS)


def _closed() -> Call:
    """Closed form in NumPy, all divisions at once."""
    angles = _angles()

    def run() -> dict[str, Array]:
        return by_circles(angles)

    return Call(run, lambda: _judged(np.hstack([run()[name] for name in MOVING])), count=DIVISIONS)


def cases() -> list[Case]:
    """Cases."""
    lines: list[tuple[str, str, Any, Callable[[float], Call]]] = [
        *(("kousoku", method, "kousoku", partial(_kousoku, method)) for method in METHODS),
        ("SciPy", "MINPACK, loop equations", "equations", _scipy),
    ]
    made = [
        Case(tool, line, f"residual {limit:.0e}", kind, partial(make, limit))
        for tool, line, kind, make in lines
        for limit in LIMITS
    ]
    return [*made, Case("NumPy", "circles, closed form", "", "reduced", _closed)]
