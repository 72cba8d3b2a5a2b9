"""The mechanisms of Yamada and Tatsumi (1981) as rigid bodies move as their link elements do.

The crank turns by itself. Where it passes α = 2πk/60 all bodies are where the link elements are,
with the velocities x′α̇ and accelerations x′α̇² + x′α̈; its speed follows from the energy of uniform
bars, and the reactions from Newton's and Euler's laws of each bar, written by hand below.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.numbers.real import Array
    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.integrate.motion import Motion
    from kousoku.runtime.linkage import LinkageSolver

    Mover = Callable[..., DynamicsSolver]

TOLERANCE = 1e-13
OUTPUTS = ("accelerations", "reactions", "energies")
DIVISIONS = 60


@dataclass(frozen=True, slots=True)
class Bar:
    """A uniform bar between two nodes, or a piston at one; with its mass [kg]."""

    body: str
    nodes: tuple[str, str]
    mass: float


@dataclass(frozen=True, slots=True)
class Mechanism:
    """Bars, the first of them the crank; hinges by their node, with bodies i and j; a guide."""

    name: str
    bars: tuple[Bar, ...]
    hinges: dict[str, tuple[str, str]]
    is_guided: bool


LEVER = Mechanism(
    "lever_crank",
    (
        Bar("crank", ("O1", "O2"), 0.3),
        Bar("coupler", ("O2", "O3"), 0.6),
        Bar("lever", ("O4", "O3"), 0.8),
    ),
    {
        "O1": ("ground", "crank"),
        "O2": ("crank", "coupler"),
        "O3": ("coupler", "lever"),
        "O4": ("ground", "lever"),
    },
    is_guided=False,
)
PISTON = Mechanism(
    "piston_crank",
    (
        Bar("crank", ("O1", "O2"), 0.1),
        Bar("rod", ("O2", "O3"), 0.2),
        Bar("piston", ("O3", "O3"), 0.2),
    ),
    {"O1": ("ground", "crank"), "O2": ("crank", "rod"), "O3": ("rod", "piston")},
    is_guided=True,
)
both = pytest.mark.parametrize("mechanism", [LEVER, PISTON], ids=lambda one: one.name)


def at_divisions(solver: DynamicsSolver) -> Motion:
    """Motion where the crank passes the divisions of a turn."""
    angles = 2 * np.pi * np.arange(1, DIVISIONS + 1) / DIVISIONS
    motion = solver.simulate(14, samples=1401, tolerance=TOLERANCE)
    times = np.interp(angles, crank_angle(motion), motion.time)
    for _ in range(4):
        motion = solver.simulate(times=times, tolerance=TOLERANCE)
        missing = np.remainder(angles - crank_angle(motion) + np.pi, 2 * np.pi) - np.pi
        times = times + missing / motion.angular_velocity["crank"][:, 2]
    return solver.simulate(times=times, tolerance=TOLERANCE)


def crank_angle(motion: Motion) -> Array:
    """Angle of the crank, counted on over whole turns."""
    p = motion.orientation["crank"]
    return np.unwrap(2 * np.arctan2(p[:, 3], p[:, 0]), period=4 * np.pi)


@pytest.fixture(scope="module")
def moved(mover: Mover) -> Callable[[Mechanism], Motion]:
    """Motion of a mechanism at the divisions, computed once."""
    known: dict[str, Motion] = {}

    def find(mechanism: Mechanism) -> Motion:
        if mechanism.name not in known:
            solver = mover(f"{mechanism.name}_bodies", OUTPUTS)
            known[mechanism.name] = at_divisions(solver)
        return known[mechanism.name]

    return find


@pytest.fixture
def slopes(solver: Callable[[str], LinkageSolver]) -> Callable[[Mechanism], Any]:
    """Positions x, x′ and x″ of the nodes at the divisions: α̇ = 1 and α̈ = 0 in the linkage."""

    def find(mechanism: Mechanism) -> tuple[dict[str, Array], ...]:
        found = solver(mechanism.name).solve()
        tables = (found.positions, found.velocities, found.accelerations)
        return tuple({node: rows[1:] for node, rows in table.items()} for table in tables)

    return find


def crossed(a: Array, b: Array) -> Array:
    """Component along z of the product of vectors in the plane."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


@both
def test_bodies_pass_the_places_of_the_link_elements(
    moved: Callable[[Mechanism], Motion], slopes: Callable[[Mechanism], Any], mechanism: Mechanism
) -> None:
    motion = moved(mechanism)
    x, first, second = slopes(mechanism)
    rate = motion.angular_velocity["crank"][:, 2:]
    change = motion.angular_acceleration["crank"][:, 2:]
    size = max(np.abs(rows).max() for rows in x.values())
    for bar in mechanism.bars:
        a, b = bar.nodes
        assert motion.position[bar.body][:, :2] == pytest.approx(x[a], abs=1e-11 * size)
        assert motion.velocity[bar.body][:, :2] == pytest.approx(first[a] * rate, abs=1e-11 * size)
        wanted = second[a] * rate**2 + first[a] * change
        assert motion.acceleration[bar.body][:, :2] == pytest.approx(wanted, abs=2e-11 * size)
        p = motion.orientation[bar.body]
        along = np.stack([p[:, 0] ** 2 - p[:, 3] ** 2, 2 * p[:, 0] * p[:, 3]], axis=1)
        length = np.linalg.norm(x[b] - x[a], axis=1, keepdims=True)
        assert along * length == pytest.approx(x[b] - x[a], abs=1e-11 * size) or a == b


@both
def test_the_crank_turns_as_the_energy_of_the_bars_allows(
    moved: Callable[[Mechanism], Motion], slopes: Callable[[Mechanism], Any], mechanism: Mechanism
) -> None:
    """Of a uniform bar it is m (v_a·v_a + v_a·v_b + v_b·v_b)/6, with v = x′α̇."""
    motion = moved(mechanism)
    _, first, _ = slopes(mechanism)
    reduced = np.zeros(DIVISIONS)
    for bar in mechanism.bars:
        a, b = (first[node] for node in bar.nodes)
        reduced += bar.mass / 6 * np.sum(a * a + a * b + b * b, axis=1)
    rate = motion.angular_velocity["crank"][:, 2]
    assert rate == pytest.approx(np.sqrt(reduced[-1] / reduced), rel=1e-11)
    assert motion.energy["total"] == pytest.approx(np.full(DIVISIONS, reduced[-1]), rel=1e-12)


@both
def test_the_joints_carry_what_the_laws_of_newton_and_euler_ask_for(
    moved: Callable[[Mechanism], Motion], slopes: Callable[[Mechanism], Any], mechanism: Mechanism
) -> None:
    """The unknowns are the forces of all joints and α̈; there are as many laws."""
    motion = moved(mechanism)
    x, first, second = slopes(mechanism)
    rate = motion.angular_velocity["crank"][:, 2]
    for row in range(DIVISIONS):
        at = [{node: rows[row] for node, rows in table.items()} for table in (x, first, second)]
        forces, change = by_hand(mechanism, at, rate[row])
        limit = 1e-9 * max(np.abs(force).max() for force in forces.values())
        assert motion.angular_acceleration["crank"][row, 2] == pytest.approx(change, abs=1e-9)
        for joint, force in forces.items():
            assert motion.force[joint][row, :2] == pytest.approx(force, abs=limit)
            assert motion.torque[joint][row, 2] == pytest.approx(0, abs=limit)


def by_hand(
    mechanism: Mechanism, at: list[dict[str, Array]], rate: float
) -> tuple[dict[str, Array], float]:
    """Forces on bodies j, and α̈: m a = ΣF and J ω̇ = ΣM about the middle of each bar."""
    x, first, second = at
    laws: list[Array] = []
    rights: list[float] = []
    joints = list(mechanism.hinges)
    size = 2 * len(joints) + mechanism.is_guided + 1
    for bar in mechanism.bars:
        a, b = bar.nodes
        law = np.zeros((3, size))
        for k, (node, (i, j)) in enumerate(mechanism.hinges.items()):
            sign = (j == bar.body) - (i == bar.body)
            arm = x[node] - (x[a] + x[b]) / 2
            law[:, 2 * k : 2 * k + 2] = sign * np.array([[1, 0], [0, 1], [-arm[1], arm[0]]])
        if a == b:
            law[1, 2 * len(joints)] = 1
        count = 2 if a == b else 3
        law[:, -1] = -inertia_force(bar, x, first)
        laws.append(law[:count])
        rights += list(rate**2 * inertia_force(bar, x, second)[:count])
    found = np.linalg.solve(np.vstack(laws), np.array(rights))
    forces = {node: found[2 * k : 2 * k + 2] for k, node in enumerate(joints)}
    if mechanism.is_guided:
        forces["guide"] = np.array([0, found[2 * len(joints)]])
    return forces, float(found[-1])


def inertia_force(bar: Bar, x: dict[str, Array], a: dict[str, Array]) -> Array:
    """Products m a of the middle and J ω̇, from the accelerations of both ends; J = m L²/12."""
    one, other = bar.nodes
    turning = crossed(x[other] - x[one], a[other] - a[one]) / 12
    return bar.mass * np.append((a[one] + a[other]) / 2, turning)
