"""Bodies about a fixed point: the heavy top, and rotation without torque, stable and flipping.

O. Brüls, A. Cardona, M. Arnold, Mechanism and Machine Theory 48 (2012) 121-137: the heavy top.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from tests.benchmarks.kit import Case, required
from tests.benchmarks.peers import spinning
from tests.benchmarks.peers.equations import StateEquations, index_1
from tests.benchmarks.problems.problem import SCENES, BenchmarkProblem, reaction_norms
from tests.benchmarks.problems.tools import (
    FEW_STEPS,
    STEPPERS,
    STEPS,
    called,
    equation_lines,
    stepped,
)
from tests.benchmarks.rotations import rotated

if TYPE_CHECKING:
    from tests.benchmarks.kit import Size

WEIGHT = 9.81


@dataclass(frozen=True, slots=True)
class Top:
    """A body about a fixed point.

    Parameters
    ----------
    mass : float [kg]
        Its mass.
    center : (3,) [m]
        Its centre of mass in its frame, which has its origin at the fixed point.
    inertia : (3,) [kg m²]
        Its moments about the centre of mass.
    omega : (3,) [rad/s]
        Its angular velocity at the start, in its frame, which then is frame O.
    """

    mass: float
    center: tuple[float, float, float]
    inertia: tuple[float, float, float]
    omega: tuple[float, float, float]

    @property
    def is_held(self) -> bool:
        """Whether a joint holds it: a body without weight turns about its centre of mass."""
        return any(self.center)

    @property
    def about_point(self) -> Any:
        """The moments about the fixed point: the centre lies on an axis of the frame."""
        c = np.array(self.center)
        return np.array(self.inertia) + self.mass * (c @ c - c * c)


#: The points that are judged, in the body's frame.
SEEN = np.eye(3)


def matrix(p: Any) -> Any:
    """A(p)."""
    ca = required("casadi")
    a, b, c, d = (p[k] for k in range(4))
    rows = (
        (a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)),
        (2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)),
        (2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d),
    )
    return ca.vertcat(*(ca.horzcat(*row) for row in rows))


def turning(p: Any, w: Any) -> Any:
    """Rate ṗ."""
    ca = required("casadi")
    scalar = -ca.dot(p[1:], w)
    return ca.vertcat(scalar, p[0] * w + ca.cross(p[1:], w)) / 2


def by_euler(top: Top) -> StateEquations:
    """Euler's equations about the fixed point, with Euler parameters."""
    ca = required("casadi")
    p, w = ca.SX.sym("p", 4), ca.SX.sym("w", 3)
    a, center = matrix(p), ca.SX(top.center)
    moments = ca.SX(top.about_point)
    weight = ca.mtimes(a.T, ca.SX([0, 0, -top.mass * WEIGHT]))
    torque = ca.cross(center, weight) - ca.cross(w, moments * w)
    height = ca.mtimes(a, center)[2]
    return StateEquations(
        ca.vertcat(p, w),
        np.array([1.0, 0, 0, 0, *top.omega]),
        ca.vertcat(*(a[:, k] for k in range(3))),
        rate=ca.vertcat(turning(p, w), torque / moments),
        energy=ca.dot(moments, w * w) / 2 + top.mass * WEIGHT * height,
    )


def of_the_body(top: Top) -> StateEquations:
    """Equations of the body, whose fixed point multipliers hold: three rows."""
    ca = required("casadi")
    q, v = ca.SX.sym("q", 7), ca.SX.sym("v", 6)
    p, w = q[3:], v[3:]
    a, moments = matrix(p), ca.SX(top.inertia)
    center = np.array(top.center)
    weight = ca.SX([0, 0, -top.mass * WEIGHT])
    start = [*center, 1.0, 0, 0, 0, *np.cross(top.omega, center), *top.omega]
    return index_1(
        q,
        v,
        np.array(start),
        mass=ca.diag(ca.vertcat(ca.SX([top.mass] * 3), moments)),
        forces=ca.vertcat(weight, -ca.cross(w, moments * w)),
        constraints=q[:3] - ca.mtimes(a, ca.SX(center)),
        observed=ca.vertcat(*(a[:, k] for k in range(3))),
        q_dot=ca.vertcat(v[:3], turning(p, w)),
        energy=top.mass * ca.sumsqr(v[:3]) / 2 + ca.dot(moments, w * w) / 2 - ca.dot(weight, q[:3]),
        held=[slice(0, 3)],
    )


def observe(body: str, result: Any) -> Any:
    """Axes of the body: points at 1 m."""
    p = result.orientation[body]
    return np.hstack([rotated(p, np.tile(axis, (len(p), 1))) for axis in SEEN])


def peers(top: Top, problem: BenchmarkProblem, size: Size) -> list[Case]:
    """Cases of all peers."""
    cases = equation_lines(problem, size, "reduced", "reduced", partial(by_euler, top))
    if top.is_held:
        make = partial(of_the_body, top)
        cases += equation_lines(problem, size, "index 1", "equations", make, has_multipliers=True)
    counts = STEPS if size.is_full else FEW_STEPS
    for method in ("RK4", "implicit"):
        make_mujoco = partial(spinning.mujoco, top, method)
        cases += stepped(problem, "MuJoCo", method, counts, make_mujoco)
    cases += [
        Case(
            "Pinocchio",
            "ABA and DOP853",
            f"tolerance {tolerance:.0e}",
            "scene",
            partial(called, problem, partial(spinning.pinocchio, top, tolerance)),
        )
        for tolerance in STEPPERS
    ]
    for line in spinning.EXUDYN if size.is_full else ():
        if top.is_held or "index" not in line:
            cases += stepped(problem, "Exudyn", line, counts, partial(spinning.exudyn, top, line))
    return cases


def problem_of(
    name: str, title: str, scene: str, body: str, top: Top, end: float, **more: Any
) -> BenchmarkProblem:
    """Problem of a top."""
    forms = [partial(by_euler, top), *([partial(of_the_body, top)] if top.is_held else [])]
    return BenchmarkProblem(
        name=name,
        title=title,
        scene=lambda: SCENES / f"{scene}.toml",
        observe=partial(observe, body),
        length=1.0,
        end=end,
        forms=tuple(forms),
        peers=partial(peers, top),
        **more,
    )


def _turned(parameters: dict[float, tuple[float, ...]]) -> dict[float, tuple[float, ...]]:
    """Axes of published Euler parameters: Jacobi's elliptic functions, Taylor series."""
    return {time: tuple(spinning.axes_of(np.array(p))) for time, p in parameters.items()}


PROBLEMS = (
    problem_of(
        "heavy_top",
        "Heavy top, 2 s",
        "heavy_top",
        "top",
        Top(15.0, (0.0, 1.0, 0.0), (0.234375, 0.46875, 0.234375), (0.0, 150.0, -4.61538)),
        2.0,
        reactions=partial(reaction_norms, ("tip",)),
        published={
            time: (*[np.nan] * 3, *place)
            for time, place in (
                (0.1, (0.421296658925402044, 0.894571974345592991, -0.149164700561899612)),
                (0.5, (-0.702468297056585589, -0.0211651847019233266, -0.711400257651734406)),
                (2.0, (-0.15041682274564175, -0.7241655916368956, -0.6730222695604441)),
            )
        },
    ),
    problem_of(
        "free_body",
        "Rotation without torque, 20 s",
        "free_body",
        "brick",
        Top(1.0, (0.0, 0.0, 0.0), (1.0, 2.0, 3.0), (1.0, 0.5, 0.8)),
        20.0,
        published=_turned(
            {
                1.0: (
                    *(0.795789637277817041, 0.321372852481080977),
                    *(0.365723135416716387, 0.360117940556118198),
                ),
                20.0: (
                    *(0.100908208415313747, -0.139704728646542354),
                    *(-0.594022976081353469, -0.785771484692375011),
                ),
            }
        ),
    ),
    problem_of(
        "flipping_body",
        "Rotation that flips, 10 s",
        "flipping_body",
        "brick",
        Top(1.0, (0.0, 0.0, 0.0), (1.0, 2.0, 3.0), (0.001, 5.0, 0.001)),
        10.0,
        published=_turned(
            {
                1.0: (
                    *(-0.801143500512254317, 0.000176340037225100837),
                    *(0.598471822096493283, 0.000733926199377245885),
                ),
                10.0: (
                    *(0.20320052058628315, -0.670231878449195148),
                    *(-0.492842339601163567, -0.516338266875870996),
                ),
            }
        ),
    ),
)
