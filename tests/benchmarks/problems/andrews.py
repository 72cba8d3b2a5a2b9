"""Andrews' squeezer mechanism to 0.03 s: seven bodies in a plane, a torque against a spring.

Data: Test Set for IVP Solvers (Bari), problem Andrews; E. Hairer, G. Wanner, Solving Ordinary
Differential Equations II, VII.7. Its printed digits err by 1e-9 rad.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from tests.benchmarks.kit import required
from tests.benchmarks.peers.equations import StateEquations, one_freedom
from tests.benchmarks.problems.forms import flat
from tests.benchmarks.problems.problem import SCENES, BenchmarkProblem, reaction_norms
from tests.benchmarks.problems.tools import equation_lines, tree_lines
from tests.benchmarks.problems.tree import GROUND, LoopClosure, Spring, Tree, TreeLink, equations

if TYPE_CHECKING:
    from tests.benchmarks.kit import Case, Size

END = 0.03
A, B, C = (-0.06934, -0.00227, 0.0), (-0.03635, 0.03273, 0.0), (0.014, 0.072, 0.0)
STIFFNESS, FREE_LENGTH, TORQUE = 4530.0, 0.07785, 0.033
#: Lengths of FE, OF, EG, BE, AH, HE and AG.
D, RR, E, SS, U, ZF, ZT = 0.028, 0.007, 0.02, 0.035, 0.04, 0.02, 0.04
#: Where the spring holds the triangle.
SPRUNG = (0.02, -0.018, 0.0)
BETA = -0.06171389001427645
#: The scene's joints, in the order of the hinges of the links and of the loops.
JOINTS = ("O", "F", "B", "A", "G", "A_lower", "H", "E", "E_upper", "E_lower")


def _link(parent: int, at: Any, mass: float, center: Any, inertia: float) -> TreeLink:
    return TreeLink("z", parent, at, mass, (*center, 0.0), (inertia, inertia, inertia))


TREE = Tree(
    links=(
        _link(GROUND, (0.0, 0.0, 0.0), 0.04325, (0.00092, 0.0), 2.194e-6),
        _link(0, (RR, 0.0, 0.0), 0.00365, (-0.0115, 0.0), 4.41e-7),
        _link(GROUND, B, 0.02373, (0.01043, -0.01874), 5.255e-6),
        _link(GROUND, A, 0.0705, (0.02308, 0.00916), 1.169e-5),
        _link(3, (ZT, 0.0, 0.0), 0.00706, (0.0, 0.01421 - E), 5.667e-7),
        _link(GROUND, A, 0.05498, (0.00449, -0.01228), 1.912e-5),
        _link(5, (0.0, -U, 0.0), 0.00706, (ZF - 0.01421, 0.0), 5.667e-7),
    ),
    q=(
        BETA,
        0.0,
        0.45527981916307037,
        0.48736497954384256,
        0.22266839016588588,
        1.2305474445498212,
        -0.22266839016588588,
    ),
    v=(0.0,) * 7,
    gravity=(0.0, 0.0, 0.0),
    observed=((0, (RR, 0.0, 0.0)), (3, (ZT, 0.0, 0.0)), (5, (0.0, -U, 0.0))),
    axes="xy",
    loops=tuple(
        LoopClosure((2, (0.0, -SS, 0.0)), end, "xy")
        for end in ((1, (-D, 0.0, 0.0)), (4, (0.0, -E, 0.0)), (6, (ZF, 0.0, 0.0)))
    ),
    springs=(Spring((GROUND, C), (2, SPRUNG), STIFFNESS, FREE_LENGTH),),
    torques={0: TORQUE},
)


def by_crank() -> StateEquations:
    """Equation of the crank's angle: all other points are where circles meet."""
    ca = required("casadi")
    angle, rate = ca.SX.sym("angle"), ca.SX.sym("rate")

    def meet(first: Any, r_1: float, second: Any, r_2: float, side: int) -> Any:
        apart = second - first
        squared = ca.sumsqr(apart)
        along = (squared + r_1 * r_1 - r_2 * r_2) / (2 * squared)
        across = side * ca.sqrt(r_1 * r_1 / squared - along * along)
        return first + along * apart + across * ca.vertcat(-apart[1], apart[0])

    a, b = ca.SX(A[:2]), ca.SX(B[:2])
    f = RR * ca.vertcat(ca.cos(angle), ca.sin(angle))
    e = meet(f, D, b, SS, 1)
    g = meet(e, E, a, ZT, -1)
    h = meet(e, ZF, a, U, 1)
    links = TREE.links

    def slope(x: Any) -> Any:
        return ca.jacobian(x, angle)

    def turning(x: Any, length: float) -> Any:
        return (x[0] * slope(x)[1] - x[1] * slope(x)[0]) / length**2

    def arm(k: int) -> float:
        return float(np.sum(np.square(links[k].center)))

    mass = links[0].inertia[2] + links[0].mass * arm(0)
    moving = (
        (1, e - f, D, f + (e - f) * (0.0115 / D)),
        (4, g - e, E, e + (g - e) * (0.01421 / E)),
        (6, h - e, ZF, e + (h - e) * (0.01421 / ZF)),
    )
    for k, x, length, centre in moving:
        mass += links[k].inertia[2] * turning(x, length) ** 2
        mass += links[k].mass * ca.sumsqr(slope(centre))
    for k, x, length in ((2, e - b, SS), (3, g - a, ZT), (5, h - a, U)):
        mass += (links[k].inertia[2] + links[k].mass * arm(k)) * turning(x, length) ** 2
    down = (e - b) / SS
    sprung = b + SPRUNG[0] * ca.vertcat(-down[1], down[0]) - SPRUNG[1] * down
    stretch = ca.sqrt(ca.sumsqr(sprung - ca.SX(C[:2]))) - FREE_LENGTH
    return one_freedom(
        angle,
        rate,
        np.array([BETA, 0.0]),
        mass=mass,
        potential=STIFFNESS / 2 * stretch**2 - TORQUE * angle,
        observed=ca.vertcat(f, g, h),
    )


def with_loops() -> StateEquations:
    """Equations in joint coordinates, whose loops meet at E."""
    return equations(TREE)


def of_all_bodies() -> StateEquations:
    """Equations of all bodies."""
    return flat(TREE)


def peers(problem: BenchmarkProblem, size: Size) -> list[Case]:
    """Cases of all peers."""
    cases = equation_lines(
        problem, size, "index 1", "equations", with_loops, has_multipliers=True, is_long=True
    )
    if size.is_full:
        cases += equation_lines(problem, size, "reduced", "reduced", by_crank, is_long=True)
    return [*cases, *tree_lines(problem, size, TREE)]


def observe(result: Any) -> Any:
    """F, G and H."""
    return np.hstack(
        [result.position[body][:, :2] for body in ("coupler", "upper_arm", "lower_arm")]
    )


PROBLEM = BenchmarkProblem(
    name="andrews",
    title="Andrews' squeezer, 0.03 s",
    scene=lambda: SCENES / "andrews_squeezer.toml",
    observe=observe,
    length=RR,
    end=END,
    forms=(by_crank, with_loops, of_all_bodies),
    reactions=partial(reaction_norms, JOINTS),
    published={
        # From the quadrature of the energy, 30 digits.
        0.03: (
            *(-0.00696303942704684, -0.0007183884307192215),
            *(-0.03471521904988391, 0.017758093872270467),
            *(-0.034681333564428374, -0.02223939761003774),
        )
    },
    peers=peers,
    is_quick=True,
)
