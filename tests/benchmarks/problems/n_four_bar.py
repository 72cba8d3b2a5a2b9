"""IFToMM A02: N four-bars side by side, all links of 1 m and 1 kg, 10 s.

It turns through positions where all cranks lie along the couplers, and its constraints lose rank.
M. González and others, Multibody System Dynamics 16 (2006) 179-190.
"""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.reading.families import n_four_bar
from tests.benchmarks.kit import required
from tests.benchmarks.peers.equations import StateEquations, one_freedom
from tests.benchmarks.problems.problem import BenchmarkProblem
from tests.benchmarks.problems.tools import equation_lines, tree_lines
from tests.benchmarks.problems.tree import GROUND, LoopClosure, Tree, TreeLink

if TYPE_CHECKING:
    from tests.benchmarks.kit import Case, Size

END, WEIGHT, INERTIA = 10.0, 9.81, 1 / 12
#: Of MuJoCo: runs take seconds.
STEPS = (1_000, 5_000, 10_000)
#: x and y of B₀ at 10 s, from the elliptic functions of the crank angle.
PUBLISHED = {
    2: (0.3284581115408154, 0.944518538178601),
    40: (0.1805122266867284, 0.9835727405823116),
}


def tree_of(count: int) -> Tree:
    """Tree of cranks, each with its coupler, whose ends meet the next crank."""
    moments = (1e-3, INERTIA, INERTIA)
    links: list[TreeLink] = []
    loops, rates, angles = [], [], []
    for k in range(count + 1):
        crank = len(links)
        at = (float(k), 0.0, 0.0)
        links.append(TreeLink("z", GROUND, at, 1.0, (0.5, 0.0, 0.0), moments))
        angles.append(math.pi / 2)
        rates.append(-1.0)
        if k:
            loops.append(LoopClosure((crank - 1, (1.0, 0.0, 0.0)), (crank, (1.0, 0.0, 0.0)), "xy"))
        if k < count:
            links.append(TreeLink("z", crank, (1.0, 0.0, 0.0), 1.0, (0.5, 0.0, 0.0), moments))
            angles.append(-math.pi / 2)
            rates.append(1.0)
    return Tree(
        tuple(links),
        tuple(angles),
        tuple(rates),
        (0.0, -WEIGHT, 0.0),
        observed=tuple((2 * k, (1.0, 0.0, 0.0)) for k in seen(count)),
        axes="xy",
        loops=tuple(loops),
    )


def seen(count: int) -> tuple[int, int, int]:
    """Cranks whose ends are judged."""
    return 0, count // 2, count


def by_crank(count: int) -> StateEquations:
    """Equation of the angle of the cranks from the vertical."""
    ca = required("casadi")
    angle, rate = ca.SX.sym("angle"), ca.SX.sym("rate")
    mass, weight = (count + 1) / 3 + count, (count + 1) / 2 + count
    ends = [ca.vertcat(k + ca.sin(angle), ca.cos(angle)) for k in seen(count)]
    return one_freedom(
        angle,
        rate,
        np.array([0.0, 1.0]),
        mass=ca.SX(mass),
        potential=WEIGHT * weight * ca.cos(angle),
        observed=ca.vertcat(*ends),
    )


def observe(count: int, result: Any) -> Any:
    """Ends of the cranks; a coupler begins there, and the last one ends at the last."""
    starts = [f"coupler_{k}" for k in seen(count)[:2]]
    ends = [result.position[name][:, :2] for name in starts]
    last = result.position[f"coupler_{count - 1}"][:, :2]
    p = result.orientation[f"coupler_{count - 1}"]
    along = np.stack([p[:, 0] ** 2 - p[:, 3] ** 2, 2 * p[:, 0] * p[:, 3]], axis=1)
    return np.hstack([*ends, last + along])


def peers(count: int, problem: BenchmarkProblem, size: Size) -> list[Case]:
    """Cases of all peers."""
    cases = equation_lines(problem, size, "reduced", "reduced", partial(by_crank, count))
    tree = tree_of(count)
    if count <= MIDDLE and size.is_full:
        cases += tree_lines(problem, size, tree, steps=STEPS, is_singular=True)
    return cases


#: Up to so many, tools that take scenes get all bodies. Equations of index 1 do not pass where
#: rank is lost: their steps get shorter without end.
MIDDLE = 40


def problem_of(count: int) -> BenchmarkProblem:
    """Problem with so many four-bars."""
    published = {10.0: PUBLISHED[count]} if count in PUBLISHED else {}
    return BenchmarkProblem(
        name=f"n_four_bar_{count}",
        title=f"N-four-bar A02, N = {count}, 10 s",
        scene=partial(n_four_bar, count),
        observe=partial(observe, count),
        length=1.0,
        end=END,
        forms=(partial(by_crank, count),),
        published=published,
        peers=partial(peers, count),
        is_quick=count == MIDDLE,
        is_large=count > MIDDLE,
    )


PROBLEMS = tuple(problem_of(count) for count in (2, 40, 200, 1000))
