"""IFToMM A01: a mass on a massless bar of 1 m, from the horizontal, 10 s.

M. González, D. Dopico, U. Lugrís, J. Cuadrado, A benchmarking system for MBS simulation software,
Multibody System Dynamics 16 (2006) 179-190. To kousoku it is a rod of 1.5 m on a hinge, whose point
at 1 m moves as that mass does.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tests.benchmarks.kit import required
from tests.benchmarks.peers.equations import StateEquations, index_1, one_freedom
from tests.benchmarks.problems.problem import SCENES, BenchmarkProblem
from tests.benchmarks.problems.tools import equation_lines, tree_lines
from tests.benchmarks.problems.tree import GROUND, Tree, TreeLink

if TYPE_CHECKING:
    from tests.benchmarks.kit import Case, Size

END, WEIGHT = 10.0, 9.81
#: From the closed form in elliptic functions.
PUBLISHED = {
    1.0: (0.986291751131875, -0.165010853125541),
    5.0: (-0.942305435043757, -0.334754338414001),
    10.0: (-0.275087462576117, -0.961419205099125),
}


ROD = Tree(
    links=(TreeLink("z", GROUND, (0.0,) * 3, 1.0, (0.75, 0.0, 0.0), (0.001, 0.1875, 0.1875)),),
    q=(np.pi,),
    v=(0.0,),
    gravity=(0.0, -WEIGHT, 0.0),
    observed=((0, (1.0, 0.0, 0.0)),),
    axes="xy",
)


def reduced() -> StateEquations:
    """Equation of the angle from the downward vertical."""
    ca = required("casadi")
    angle, rate = ca.SX.sym("angle"), ca.SX.sym("rate")
    sine, cosine = ca.sin(angle), ca.cos(angle)
    return one_freedom(
        angle,
        rate,
        np.array([-np.pi / 2, 0.0]),
        mass=ca.SX(1),
        potential=-WEIGHT * cosine,
        observed=ca.vertcat(sine, -cosine),
    )


def with_multiplier() -> StateEquations:
    """Equations of the mass in x and y, held by its distance."""
    ca = required("casadi")
    q, v = ca.SX.sym("q", 2), ca.SX.sym("v", 2)
    return index_1(
        q,
        v,
        np.array([-1.0, 0, 0, 0]),
        mass=ca.SX.eye(2),
        forces=ca.SX([0, -WEIGHT]),
        constraints=(ca.sumsqr(q) - 1) / 2,
        observed=q,
        energy=ca.sumsqr(v) / 2 + WEIGHT * q[1],
    )


def peers(problem: BenchmarkProblem, size: Size) -> list[Case]:
    """Cases of all peers; those that take scenes get the rod."""
    return [
        *equation_lines(
            problem, size, "index 1", "equations", with_multiplier, has_multipliers=True
        ),
        *equation_lines(problem, size, "reduced", "reduced", reduced),
        *tree_lines(problem, size, ROD),
    ]


PROBLEM = BenchmarkProblem(
    name="pendulum",
    title="Pendulum A01, 10 s",
    scene=lambda: SCENES / "pendulum.toml",
    observe=lambda result: result.position["rod"][:, :2],
    length=1.0,
    end=END,
    forms=(reduced, with_multiplier),
    published=PUBLISHED,
    peers=peers,
    is_quick=True,
)
