"""The same mechanism with a universal joint and with kinds of one's own that state it."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

import kousoku as ks
from tests.random_geometry import turn

if TYPE_CHECKING:
    import random

    from kousoku.symbolic.derivation import Derivation

    Tree = dict[str, Any]


@cache
def kinds() -> list[Derivation]:
    """Kinds that hold two points together and two axes perpendicular, as a universal joint does."""
    i, j = ks.body("i"), ks.body("j")
    return [
        ks.derive("own_point", C=j.point() - i.point()),
        ks.derive("own_axes", C=i.axis().dot(j.axis())),
    ]


def pair(draw: random.Random) -> tuple[Tree, Tree]:
    """Two bodies on each other with the joint that is shipped, and with kinds of one's own.

    Their frames are neither at their centres of mass nor along principal axes.
    """

    def vector() -> Any:
        return np.array([draw.uniform(-1, 1) for _ in range(3)])

    bodies, places = {}, {}
    for name in ("one", "two"):
        axis, angle, position = vector().tolist(), draw.uniform(-3, 3), vector()
        places[name] = np.array(turn(tuple(axis), angle)), position
        bodies[name] = {
            "position": position.tolist(),
            "orientation": {"axis": axis, "angle": angle},
            "mass": draw.uniform(0.5, 2),
            "center": vector().tolist(),
            "inertia": {"xx": 1.0, "yy": 1.2, "zz": 0.8, "xy": 0.05, "yz": -0.03, "zx": 0.07},
        }

    def seen(name: str, place: Any) -> list[float]:
        orientation, position = places[name]
        components: list[float] = (orientation.T @ (place - position)).tolist()
        return components

    foot, middle, axis = vector(), vector(), vector()
    other = np.cross(axis, vector())
    points = [seen("one", middle), seen("two", middle)]
    axes = [(places[n][0].T @ x).tolist() for n, x in zip(bodies, (axis, other), strict=True)]
    hung: Tree = {"type": "spherical", "bodies": ["ground", "one"]}
    hung["points"] = [foot.tolist(), seen("one", foot)]
    ends: Tree = {"bodies": ["one", "two"]}
    shipped = {"middle": {"type": "universal", "points": points, "axes": axes} | ends}
    own = {
        "middle": {"type": "own_point", "s_i_b": points[0], "s_j_b": points[1]} | ends,
        "cross": {"type": "own_axes", "a_i_b": axes[0], "a_j_b": axes[1]} | ends,
    }
    whole = {"name": "pair", "unit": "m", "gravity": [3, 4, -8], "outputs": ["accelerations"]}
    shown, stated = (
        whole | {"bodies": bodies, "joints": {"foot": hung, **joints}} for joints in (shipped, own)
    )
    return shown, stated
