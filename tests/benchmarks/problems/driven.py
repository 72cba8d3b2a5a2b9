"""A rod that hangs on a pivot which a driver shakes up and down: 3 s."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from kousoku.model.reading.builder import SceneBuilder
from tests.benchmarks.kit import required
from tests.benchmarks.peers.equations import StateEquations, index_1
from tests.benchmarks.problems.forms import observed_of
from tests.benchmarks.problems.problem import BenchmarkProblem, reaction_norms
from tests.benchmarks.problems.tools import equation_lines
from tests.benchmarks.problems.tree import GROUND, Tree, TreeLink

if TYPE_CHECKING:
    from kousoku.model.records.scene import Scene
    from tests.benchmarks.kit import Case, Size

END, WEIGHT = 3.0, 9.81
#: The pivot is at y = 0.1 m sin(20/s t); the rod is uniform, of 1 m and 1 kg, and starts at 1 rad
#: from the downward vertical, at rest beside the pivot.
SHAKE, OFTEN, START = 0.1, 20.0, 1.0
INERTIA = 1 / 12
ROD = Tree(
    links=(
        TreeLink("slide y", GROUND, (0.0,) * 3, 0.5, (0.0,) * 3, (1e-3,) * 3),
        TreeLink("z", 0, (0.0,) * 3, 1.0, (0.0, -0.5, 0.0), (INERTIA, 1e-3, INERTIA)),
    ),
    q=(0.0, START),
    v=(SHAKE * OFTEN, 0.0),
    gravity=(0.0, -WEIGHT, 0.0),
    observed=((1, (0.0, -1.0, 0.0)),),
    axes="xy",
)


def scene() -> Scene:
    """Scene: a carriage that is driven, and the rod on it."""
    builder = SceneBuilder("driven_pendulum", unit="m").gravity(*ROD.gravity)
    builder.body(
        "carriage",
        position=(0, 0, 0),
        velocity=(0, SHAKE * OFTEN, 0),
        mass=0.5,
        inertia={"xx": 1e-3, "yy": 1e-3, "zz": 1e-3},
    )
    builder.body(
        "rod",
        position=(0, 0, 0),
        velocity=(0, SHAKE * OFTEN, 0),
        orientation={"axis": (0, 0, 1), "angle": START},
        mass=1,
        center=(0, -0.5, 0),
        inertia={"xx": INERTIA, "yy": 1e-3, "zz": INERTIA},
    )
    builder.joint(
        "guide", type="prismatic", bodies=("ground", "carriage"), at=(0, 0, 0), axis=(0, 1, 0)
    )
    builder.joint(
        "hinge", type="revolute", bodies=("carriage", "rod"), at=(0, 0, 0), axis=(0, 0, 1)
    )
    builder.coordinate("height", joint="guide")
    builder.driver("shaker", coordinate="height", value=f"{SHAKE}*sin({OFTEN}*t)")
    return builder.build()


def by_angle() -> StateEquations:
    """Equation of the angle, with time as a state."""
    ca = required("casadi")
    angle, rate, time = (ca.SX.sym(name) for name in ("angle", "rate", "time"))
    height = SHAKE * ca.sin(OFTEN * time)
    felt = WEIGHT - SHAKE * OFTEN**2 * ca.sin(OFTEN * time)
    return StateEquations(
        ca.vertcat(angle, rate, time),
        np.array([START, 0.0, 0.0]),
        ca.vertcat(ca.sin(angle), height - ca.cos(angle)),
        rate=ca.vertcat(rate, -0.5 * felt * ca.sin(angle) / (INERTIA + 0.25), 1),
    )


def with_pivot() -> StateEquations:
    """Equations of the rod in the plane, whose end multipliers lead along the pivot."""
    ca = required("casadi")
    q, v = ca.SX.sym("q", 4), ca.SX.sym("v", 3)
    angle, time = q[2], q[3]
    down = ca.vertcat(ca.sin(angle), -ca.cos(angle))
    pivot = ca.vertcat(0, SHAKE * ca.sin(OFTEN * time))
    start = [np.sin(START) / 2, -np.cos(START) / 2, START, 0, 0, SHAKE * OFTEN, 0]
    return index_1(
        q,
        v,
        np.array(start),
        mass=ca.diag(ca.SX([1, 1, INERTIA])),
        forces=ca.SX([0, -WEIGHT, 0]),
        constraints=q[:2] - down / 2 - pivot,
        observed=q[:2] + down / 2,
        q_dot=ca.vertcat(v, 1),
        held=[slice(0, 2)],
    )


def peers(problem: BenchmarkProblem, size: Size) -> list[Case]:
    """Cases of all peers."""
    return [
        *equation_lines(problem, size, "index 1", "equations", with_pivot, has_multipliers=True),
        *equation_lines(problem, size, "reduced", "reduced", by_angle),
    ]


PROBLEM = BenchmarkProblem(
    name="driven_pendulum",
    title="Rod on a driven pivot, 3 s",
    scene=scene,
    observe=observed_of(ROD, ["carriage", "rod"]),
    length=1.0,
    end=END,
    forms=(by_angle, with_pivot),
    reactions=partial(reaction_norms, ("hinge",)),
    peers=peers,
)
