"""Rows of linkages are on the branch of the first position, whatever the divisions and turns.

Six coordinates have to be found together here, and several assemblies lie on the same side of a
dead centre: neither residuals nor the sign of a determinant tell them apart. Compared with are
hundreds of small steps by a program that shares nothing with the solver.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.errors import MotionError

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.numbers.real import Array
    from kousoku.runtime.linkage import LinkageSolver

    Solver = Callable[[str], LinkageSolver]
    SolverIn = Callable[[str, str], LinkageSolver]

NODES = ("O3", "O6", "A", "B", "P", "Q")
#: Links by their nodes; O1 is the origin.
LINKS = {
    "l1": ("O1", "A"),
    "l3": ("O3", "B"),
    "ab": ("A", "B"),
    "bp": ("B", "P"),
    "pa": ("P", "A"),
    "rod": ("P", "Q"),
    "k": ("O6", "Q"),
}


class SixBar:
    """A Stephenson six-bar that is driven from behind, given by its nodes at division 0 [m]."""

    def __init__(self, *nodes: tuple[float, float]) -> None:
        self.at = {"O1": np.zeros(2)} | {
            name: np.array(node, float) for name, node in zip(NODES, nodes, strict=True)
        }
        ends = [(self.at[a], self.at[b]) for a, b in LINKS.values()]
        *lengths, self.crank = (math.dist(a, b) for a, b in ends)
        self.lengths = np.array(lengths)
        arm = self.at["Q"] - self.at["O6"]
        self.start = math.atan2(arm[1], arm[0])

    @property
    def text(self) -> str:
        """The scene."""
        lines = ['name = "six_bar"', 'unit = "m"', "[nodes]"]
        for name, at in self.at.items():
            fixed = ", fixed = true" * name.startswith("O")
            lines.append(f"{name} = {{ at = {at.tolist()}{fixed} }}")
        lengths = dict(zip(LINKS, [*self.lengths.tolist(), self.crank], strict=True))
        lines.append("[links]")
        for name, (a, b) in LINKS.items():
            lines.append(f'{name} = {{ nodes = ["{a}", "{b}"], length = {lengths[name]!r} }}')
        given = f'link = "k", about = "O6", from = {self.start!r}, turns = 1'
        return "\n".join([*lines, "[inputs]", f"alpha = {{ {given} }}", ""])

    def equations(self, x: Array, alpha: float) -> tuple[Array, Array, Array]:
        """Residuals, and their derivatives by A, B, P and by the angle."""
        arm = self.crank * np.array([math.cos(alpha), math.sin(alpha)])
        place = self.at | {"Q": self.at["O6"] + arm}
        place |= dict(zip("ABP", x.reshape(3, 2), strict=True))
        residual, slope, rate = -(self.lengths**2), np.zeros((6, 6)), np.zeros(6)
        for row, (a, b) in enumerate([*LINKS.values()][:6]):
            d = place[b] - place[a]
            residual[row] += d @ d
            for node, sign in ((a, -2), (b, 2)):
                if node in "ABP":
                    k = 2 * "ABP".index(node)
                    slope[row, k : k + 2] += sign * d
                elif node == "Q":
                    rate[row] += sign * (d[1] * arm[0] - d[0] * arm[1])
        return residual, slope, rate

    def followed(self, turns: int, count: int) -> Array:
        """Points A, B, P at so many small steps a turn, up to a dead centre, (rows, 6)."""
        x = np.concatenate([self.at[node] for node in "ABP"])
        _, slope, rate = self.equations(x, self.start)
        side, step, rows = np.sign(np.linalg.det(slope)), math.tau / count, [x]
        for k in range(1, turns * count + 1):
            predicted = x - np.linalg.solve(slope, rate) * step
            moved, x = np.abs(predicted - x).max(), predicted
            for _ in range(8):
                residual, slope, rate = self.equations(x, self.start + k * step)
                if np.abs(residual).max() < 1e-14:
                    break
                x = x - np.linalg.solve(slope, residual)
            is_far = np.abs(x - predicted).max() > 0.3 * moved + 20 * step**2
            if is_far or np.sign(np.linalg.det(slope)) != side:
                break
            rows.append(x)
        return np.array(rows)

    @cached_property
    def fine(self) -> Array:
        """Two turns in 720 steps each, as far as it goes."""
        return self.followed(2, 720)


#: Each one jumped with few divisions, or ran on where it stops.
JUMP = SixBar(
    (0.380260771611302, 0.0),
    (-0.260271550715222, -1.168485798161584),
    (0.504222922837068, 0.0225702197513038),
    (-0.9006520110389387, -0.9103850311286859),
    (0.4718687724460289, -0.6913005045828078),
    (-0.5704966000767693, -1.4993585994102394),
)
#: After a turn it is another assembly, and the next turn stops soon.
MONODROMY = SixBar(
    (1.2809383833917525, 0.0),
    (-1.0739244695366552, 0.8541587424211255),
    (-0.6992369194748509, 0.8589926208226251),
    (-0.3173560614709423, 0.5917452725072281),
    (-0.5030309326725195, 0.2558402231368615),
    (-0.8213801622669534, 1.1167255136437537),
)
#: After a turn it is another assembly, after two it is back.
TWO_TURNS = SixBar(
    (0.36, 0.0), (0.27, -0.37), (1.46, 0.0), (1.51, -0.67), (0.08, -0.81), (-0.86, -0.22)
)


def positions(rows: Any) -> Array:
    """Points A, B, P of a solver's good rows, (rows, 6)."""
    got: Array = rows.position[: rows.done, 3:6].reshape(rows.done, 6)
    return got


def random_six_bar(seed: int) -> SixBar:
    """Six-bar whose crank is short, so that it often turns."""
    rng = np.random.default_rng(seed)
    o6, angle = rng.uniform(-1.3, 1.3, 2), rng.uniform(0, math.tau)
    q = o6 + rng.uniform(0.1, 0.5) * np.array([math.cos(angle), math.sin(angle)])
    nodes = [(rng.uniform(0.3, 1.5), 0.0), o6, *rng.uniform(-1.5, 1.5, (3, 2)), q]
    return SixBar(*((float(x), float(y)) for x, y in nodes))


def assert_on_branch(six: SixBar, solver: LinkageSolver) -> None:
    """Check rows of several divisions, and where they end."""
    fine = six.followed(1, 720)
    for divisions in (3, 5, 12, 48):
        got = solver.rows(solver.request(divisions=divisions))
        every = 720 // divisions
        # Small steps stop a little before a dead centre.
        assert got.done in {1 + (len(fine) - 1 + k) // every for k in (0, 2)}, divisions
        rows = fine[::every][: got.done]
        np.testing.assert_allclose(positions(got)[: len(rows)], rows, rtol=0, atol=1e-8)


@pytest.mark.parametrize("six", [JUMP, MONODROMY, TWO_TURNS], ids=["jump", "monodromy", "two"])
@pytest.mark.parametrize("method", ["newton", "paper"])
def test_coarse_divisions_stay_on_the_branch(solver: Solver, six: SixBar, method: str) -> None:
    moving, fine = solver(six.text), six.fine[:721]
    for divisions in (3, 5, 12, 48):
        got = moving.rows(moving.request(divisions=divisions, method=method))
        np.testing.assert_allclose(positions(got), fine[:: 720 // divisions], rtol=0, atol=1e-9)


@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.usefixtures("compiler")
def test_turns_that_do_not_lead_back_are_made(solver_in: SolverIn, target: str) -> None:
    """Two turns lead back: so do ten thousand, which are not made."""
    moving, fine = solver_in(TWO_TURNS.text, target), TWO_TURNS.fine
    assert np.abs(fine[720] - fine[0]).max() > 0.1
    np.testing.assert_allclose(fine[1440], fine[0], rtol=0, atol=1e-9)
    for first in (0, 1, 10_000, 10_001):
        got = moving.solve(first_turn=first, divisions=24)
        turn = fine[720 * (first % 2) :][:721:30]
        for k, node in enumerate("ABP"):
            wanted = turn[:, 2 * k : 2 * k + 2]
            np.testing.assert_allclose(got.positions[node], wanted, rtol=0, atol=1e-9)
        assert got.alpha[0] == pytest.approx(TWO_TURNS.start + math.tau * first, rel=1e-15)
        assert got.turn_gaps["P"] == pytest.approx(math.dist(turn[0, 4:], turn[-1, 4:]), abs=1e-9)
    twice = moving.solve(turns=2, divisions=24)
    np.testing.assert_allclose(twice.positions["B"][-1], twice.positions["B"][0], atol=1e-12)


def test_a_turn_that_is_said_to_begin_as_the_scene_says_does(solver: Solver) -> None:
    moving = solver(TWO_TURNS.text)
    first, there = (moving.solve(first_turn=k, from_turn=k, divisions=8) for k in (0, 1))
    for node, rows in first.positions.items():
        np.testing.assert_array_equal(there.positions[node], rows)


@pytest.mark.parametrize("six", [JUMP, MONODROMY, TWO_TURNS], ids=["jump", "monodromy", "two"])
@pytest.mark.usefixtures("compiler")
def test_both_targets_take_the_same_steps(solver_in: SolverIn, six: SixBar) -> None:
    one, other = (solver_in(six.text, target) for target in ("c", "numpy"))
    for options in ({"divisions": 3}, {"divisions": 7, "method": "paper"}, {"turns": 2}):
        got, wanted = (each.rows(each.request(**options)) for each in (one, other))
        np.testing.assert_array_equal(got.iterations, wanted.iterations)
        np.testing.assert_allclose(got.condition, wanted.condition, rtol=1e-9)
        np.testing.assert_allclose(got.reached, wanted.reached, rtol=1e-12)


@pytest.mark.parametrize(("first", "target"), [(1, "c"), (7, "c"), (7, "numpy")])
@pytest.mark.usefixtures("compiler")
def test_a_later_turn_that_cannot_be_made_stops_at_the_angle_that_was_counted(
    solver_in: SolverIn, first: int, target: str
) -> None:
    stop = MONODROMY.start + (len(MONODROMY.fine) - 1) * math.tau / 720
    with pytest.raises(MotionError, match="a dead centre, or a change point") as stopped:
        solver_in(MONODROMY.text, target).solve(first_turn=first)
    reached = float(str(stopped.value).partition("at alpha = ")[2].partition(" ")[0])
    assert reached == pytest.approx(stop, abs=math.tau / 360)
    assert reached > math.tau
    assert f"after {2 - min(first, 2)} good positions" in str(stopped.value)


def test_what_a_turn_leads_to_is_told(solver: Solver) -> None:
    turn = solver(MONODROMY.text).solve()
    gaps = {node: round(gap, 2) for node, gap in turn.turn_gaps.items()}
    assert gaps == {"A": 0.11, "B": 0.38, "P": 0.5}
    told = "a turn leads to another assembly: A 0.108 m, B 0.38 m, P 0.5 m from where it began"
    assert turn.notes == (told,)
    assert turn.summary()["turn_gaps"] == turn.turn_gaps
    for back in (solver("lever_crank").solve(), solver("stephenson_six_bar").solve(turns=2)):
        assert back.turn_gaps == {} and back.notes == ()


@pytest.mark.parametrize(
    "seed", [1, 2, 7, *(pytest.param(x, marks=pytest.mark.release) for x in (10, 44, 49, 62))]
)
def test_any_six_bar_stays_on_its_branch(solver_in: SolverIn, seed: int) -> None:
    six = random_six_bar(seed)
    assert_on_branch(six, solver_in(six.text, "numpy"))


def test_simulation_in_time_stays_on_the_branch(solver: Solver) -> None:
    """The six-bar that jumped turns with the rate of its input, 1 rad/s, one turn."""
    got = solver(JUMP.text).simulate(times=[math.tau * k / 3 for k in range(4)])
    for k, node in enumerate("ABP"):
        wanted = JUMP.fine[:721:240, 2 * k : 2 * k + 2]
        np.testing.assert_allclose(got.positions[node], wanted, rtol=0, atol=1e-9)


def test_digits_that_a_dead_centre_takes_are_told(solver: Solver) -> None:
    """A crank and a rocker that all but stretch their coupler: lengths by 1e-8 from a fold."""
    text = """
name = "nearly_dead"
unit = "m"
divisions = 4
[nodes]
O = { at = [0, 0], fixed = true }
A = { at = [1, 0] }
B = { at = [2, 1] }
C = { at = [4, 0], fixed = true }
[links]
crank = { nodes = ["O", "A"], length = 1 }
coupler = { nodes = ["A", "B"], length = 2.5 }
rocker = { nodes = ["C", "B"], length = 2.50000001 }
[inputs]
alpha = { link = "crank", about = "O", from = 0, turns = 1, rate = 1 }
"""
    got = solver(text).solve()
    k = int(np.argmax(got.condition))
    assert got.alpha[k] == pytest.approx(math.pi)
    between = math.pi - 2 * math.acos(2.5 / (2.5 + 5e-9))  # of coupler and rocker
    assert got.condition[k] == pytest.approx(2 / math.sin(between), rel=0.5)
    (note,) = got.notes
    assert "near a dead centre, at alpha = 3.14159265 rad, positions lose 4 of 16 digits" in note
    assert solver(text).solve(turns=1, divisions=2).ledger.condition == got.condition[k]
