"""Closed loops in space: a slider-crank with a rod between skew guides, and Bricard's linkage."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.reading.builder import SceneBuilder
from tests.benchmarks.kit import required
from tests.benchmarks.peers.equations import StateEquations, one_freedom
from tests.benchmarks.problems.forms import inertia_of, observed_of
from tests.benchmarks.problems.problem import SCENES, BenchmarkProblem
from tests.benchmarks.problems.tools import equation_lines, tree_lines
from tests.benchmarks.problems.tree import (
    GROUND,
    LoopClosure,
    Tree,
    TreeLink,
    equations,
    frames,
    symbols,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.records.scene import Scene
    from tests.benchmarks.kit import Case, Size

WEIGHT = 9.81
#: The crank's bearing, its radius, the length of the rod, and the crank's rate at the start.
BEARING, CRANK, ROD, RATE = (0.0, 0.1, 0.12), 0.08, 0.3, 6.0
#: Masses and moments of the three bodies; the rod's are about x, its own axis, and across.
CRANK_MASS, CRANK_MOMENT = 0.12, 1e-4
ROD_MASS, ROD_ALONG, ROD_ACROSS = 0.5, 2e-4, 4e-3
SLIDER_MASS = 2.0


def slider_crank() -> Tree:
    """Crank about x, and the slider on x with its rod on a universal joint."""
    y, z = BEARING[1], BEARING[2] + CRANK
    place = math.sqrt(ROD**2 - y**2 - z**2)
    turned, lifted = math.atan2(-y, place), math.asin(z / ROD)
    # The pin moves along −y.
    speed = CRANK * RATE
    along = y * speed / place
    flat = math.hypot(place, y)
    u_dot = np.array([along, speed, 0.0]) / ROD
    turn_rate = (place * u_dot[1] + y * u_dot[0]) * ROD / flat**2
    return Tree(
        links=(
            TreeLink("x", GROUND, BEARING, CRANK_MASS, (0.0, 0.0, 0.0), (CRANK_MOMENT,) * 3),
            TreeLink("slide x", GROUND, (0.0,) * 3, SLIDER_MASS, (0.0,) * 3, (1e-3,) * 3),
            TreeLink("z", 1, (0.0,) * 3, 0.0, (0.0,) * 3, (0.0,) * 3),
            TreeLink("y", 2, (0.0,) * 3, ROD_MASS, (-ROD / 2, 0.0, 0.0), _rod()),
        ),
        q=(0.0, place, turned, lifted),
        v=(RATE, along, turn_rate, 0.0),
        gravity=(0.0, 0.0, -WEIGHT),
        observed=((0, (0.0, 0.0, CRANK)), (1, (0.0, 0.0, 0.0))),
        loops=(LoopClosure((0, (0.0, 0.0, CRANK)), (3, (-ROD, 0.0, 0.0))),),
    )


def _rod() -> tuple[float, float, float]:
    return ROD_ALONG, ROD_ACROSS, ROD_ACROSS


def scene_of_slider_crank() -> Scene:
    """Scene: revolute, spherical, universal and prismatic joints."""
    tree = slider_crank()
    where = frames(tree, np.array(tree.q))
    builder = SceneBuilder("spatial_slider_crank", unit="m").gravity(*tree.gravity)
    for name, k in (("crank", 0), ("slider", 1), ("rod", 3)):
        link = tree.links[k]
        builder.body(
            name,
            position=where[0][k].tolist(),
            orientation={"matrix": where[1][k].tolist()},
            mass=link.mass,
            center=link.center,
            inertia=inertia_of(link.inertia),
            angular_velocity=None if k else (RATE, 0, 0),
            hold=[] if k else ["angular_velocity"],
        )
    x, z = ((1, 0, 0), (1, 0, 0)), ((0, 0, 1), (0, 1, 0))
    none = (0, 0, 0)
    builder.joint(
        "bearing", type="revolute", bodies=("ground", "crank"), points=(BEARING, none), axes=x
    )
    builder.joint(
        "pin", type="spherical", bodies=("crank", "rod"), points=((0, 0, CRANK), (-ROD, 0, 0))
    )
    builder.joint("cross", type="universal", bodies=("slider", "rod"), points=(none, none), axes=z)
    builder.joint(
        "guide", type="prismatic", bodies=("ground", "slider"), points=(none, none), axes=x
    )
    return builder.build()


def by_crank() -> StateEquations:
    """Equation of the crank's angle."""
    ca = required("casadi")
    angle, rate = ca.SX.sym("angle"), ca.SX.sym("rate")
    y = BEARING[1] - CRANK * ca.sin(angle)
    z = BEARING[2] + CRANK * ca.cos(angle)
    x = ca.sqrt(ROD**2 - y * y - z * z)

    def slope(value: Any) -> Any:
        return ca.jtimes(value, angle, 1)

    # The rod's axis is u: it turns about z, then about y.
    u = ca.vertcat(x, -y, -z) / ROD
    flat = u[0] ** 2 + u[1] ** 2
    turn = (u[0] * slope(u[1]) - u[1] * slope(u[0])) / flat
    lift = -slope(u[2]) / ca.sqrt(flat)
    omega = ca.vertcat(u[2] * turn, lift, ca.sqrt(flat) * turn)
    centre = ca.vertcat(x / 2, y / 2, z / 2)
    mass = CRANK_MOMENT + SLIDER_MASS * slope(x) ** 2
    mass += ROD_MASS * ca.sumsqr(ca.vertcat(*(slope(centre[k]) for k in range(3))))
    mass += ca.dot(ca.SX(_rod()), omega * omega)
    return one_freedom(
        angle,
        rate,
        np.array([0.0, RATE]),
        mass=mass,
        potential=ROD_MASS * WEIGHT * z / 2,
        observed=ca.vertcat(0, y, z, x, 0, 0),
    )


_ALONG, _ACROSS = 0.05**2 / 2, (3 * 0.05**2 + 1) / 12


def _of_bricard(*, rows: str) -> Tree:
    """Tree from the hinge a on, whose end meets the hinge f."""

    def link(joint: Any, parent: int, at: Any, along: int, side: int) -> TreeLink:
        c, m = [0.0] * 3, [_ACROSS] * 3
        c[along], m[along] = side / 2, _ALONG
        return TreeLink(joint, parent, at, 1.0, (c[0], c[1], c[2]), (m[0], m[1], m[2]))

    end = (0.0, 0.0, -1.0)
    return Tree(
        links=(
            link("z", GROUND, (1.0, 0.0, 0.0), 1, 1),
            link("x", 0, (0.0, 1.0, 0.0), 2, 1),
            link("y", 1, (0.0, 0.0, 1.0), 0, -1),
            link("z", 2, (-1.0, 0.0, 0.0), 1, -1),
            link("x", 3, (0.0, -1.0, 0.0), 2, -1),
        ),
        q=(0.0,) * 5,
        v=(0.0,) * 5,
        gravity=(0.0, -WEIGHT, 0.0),
        observed=((1, (0.0, 0.0, 0.0)), (2, (0.0, 0.0, 0.0)), (3, (0.0, 0.0, 0.0))),
        loops=(
            LoopClosure((4, end), (GROUND, (0.0, 0.0, 0.0))),
            LoopClosure((4, (0.0, 1.0, -1.0)), (GROUND, (0.0, 1.0, 0.0)), rows),
        ),
    )


BRICARD = _of_bricard(rows="x")


def by_curve() -> StateEquations:
    """Equation along the curve of the two angles that all six hinges have in turn.

    With α of the hinges a, c, e and β of b, d, f, from the start in a cube, it closes where
    sin α + sin β = sin α sin β; the state is α, β and the speed along the curve.
    """
    ca = required("casadi")
    a, b, speed = ca.SX.sym("a"), ca.SX.sym("b"), ca.SX.sym("speed")
    along = ca.vertcat(-ca.cos(b) * (1 - ca.sin(a)), ca.cos(a) * (1 - ca.sin(b)))
    made = symbols(BRICARD)
    kinetic = ca.Function("kinetic", [made.q, made.v], [made.kinetic()])
    weight = ca.Function("weight", [made.q], [made.weight()])
    seen = ca.Function("seen", [made.q], [made.observed()])
    q = ca.vertcat(a, b, -a, b, a)
    v = ca.vertcat(along[0], along[1], -along[0], along[1], along[0])
    mass, height = 2 * kinetic(q, v), weight(q)
    both = ca.vertcat(a, b)

    def slope(value: Any) -> Any:
        return ca.jtimes(value, both, along)

    change = -(slope(height) + slope(mass) * speed * speed / 2) / mass
    return StateEquations(
        ca.vertcat(both, speed),
        np.zeros(3),
        seen(q),
        rate=ca.vertcat(along * speed, change),
        energy=mass * speed * speed / 2 + height,
    )


def peers_of(
    tree: Tree, reduced: Callable[[], StateEquations], problem: BenchmarkProblem, size: Size
) -> list[Case]:
    """Cases of all peers."""
    make = partial(equations, tree)
    return [
        *equation_lines(
            problem, size, "index 1", "equations", make, has_multipliers=True, is_long=True
        ),
        *equation_lines(problem, size, "reduced", "reduced", reduced, is_long=tree is BRICARD),
        *tree_lines(problem, size, tree, is_redundant=tree is BRICARD),
    ]


PROBLEMS = (
    BenchmarkProblem(
        name="slider_crank",
        title="Spatial slider-crank, 5 s",
        scene=scene_of_slider_crank,
        observe=observed_of(slider_crank(), ["crank", "slider", "cross", "rod"]),
        length=ROD,
        end=5.0,
        forms=(by_crank, partial(equations, slider_crank())),
        peers=partial(peers_of, slider_crank(), by_crank),
    ),
    BenchmarkProblem(
        name="bricard",
        title="Bricard's linkage of uniform rods, 9 s",
        scene=lambda: SCENES / "bricard.toml",
        observe=observed_of(BRICARD, [f"rod_{k}" for k in range(1, 6)]),
        length=1.0,
        end=9.0,
        forms=(by_curve, partial(equations, BRICARD)),
        peers=partial(peers_of, BRICARD, by_curve),
    ),
)
