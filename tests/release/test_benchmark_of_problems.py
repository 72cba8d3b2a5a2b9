"""The problems of the benchmarks: digits, scenes and forms of equations are of one motion."""

import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import kousoku as ks
from kousoku.runtime.toolchain import Toolchain
from tests.benchmarks import solvers
from tests.benchmarks.kit import Figures, PeerMissingError, Record, Size
from tests.benchmarks.peers import mujoco
from tests.benchmarks.problems import andrews, closed, linkage, n_four_bar, pendulum, trees
from tests.benchmarks.problems.catalog import PROBLEMS
from tests.benchmarks.problems.growth import growth
from tests.benchmarks.problems.problem import (
    GROWTH,
    PROMISED,
    TIMES,
    USUAL_GROWTH,
    Digits,
    finished,
    kousoku_call,
)
from tests.benchmarks.problems.tree import Tree, frames, placed, point_at, pulled, slopes

TREES: dict[str, Tree] = {
    "pendulum": pendulum.ROD,
    "andrews": andrews.TREE,
    "n_four_bar_2": n_four_bar.tree_of(2),
    "small_pendulum": trees.SMALL,
    "chain_10": trees.chain_of(10),
    "governor": trees.GOVERNOR,
    "slider_crank": closed.slider_crank(),
    "bricard": closed.BRICARD,
}
SMALL = ("small_pendulum", "free_body", "driven_pendulum", "heavy_top")
#: A minute and more.
SLOW_TO_GROW = {"governor", "n_four_bar_200", "n_four_bar_1000"}


def gaps(tree: Tree, q: np.ndarray) -> np.ndarray:
    where = frames(tree, q)
    apart = [(point_at(one.a, where) - point_at(one.b, where), one.rows) for one in tree.loops]
    return np.array([gap["xyz".index(row)] for gap, rows in apart for row in rows])


@pytest.mark.parametrize("name", PROBLEMS)
def test_a_problem_has_digits_at_all_times_up_to_its_end(name: str) -> None:
    problem, digits = PROBLEMS[name], Digits.read(name)
    assert len(digits.times) == TIMES and digits.times[-1] == problem.end
    assert digits.positions.shape[0] == TIMES and np.isfinite(digits.positions).all()
    for time, wanted in problem.published.items():
        row = digits.positions[np.argmin(np.abs(digits.times - time)), : len(wanted)]
        assert np.nanmax(np.abs(row - wanted)) < 1e-12 * problem.length


@pytest.mark.parametrize("name", TREES)
def test_the_loops_of_a_tree_are_closed_at_the_start_and_stay_so(name: str) -> None:
    tree = TREES[name]
    q, v, h = np.array(tree.q), np.array(tree.v), 1e-6
    rates = (gaps(tree, q + h * v) - gaps(tree, q - h * v)) / (2 * h)
    scale = max(1.0, float(np.abs(v).max()))
    assert np.abs(gaps(tree, q)).max(initial=0.0) < 1e-14
    assert np.abs(rates).max(initial=0.0) < 1e-9 * scale


@pytest.mark.parametrize("name", SMALL)
def test_kousoku_meets_digits_and_reactions(name: str, compiler: Toolchain) -> None:
    judged = kousoku_call(PROBLEMS[name], "dop853", 1e-12, "end").judge()
    assert judged.error is not None and judged.error < 1e-9
    assert judged.extra.get("reactions", 0.0) < 1e-8


@pytest.mark.parametrize("name", [name for name in GROWTH if name not in SLOW_TO_GROW])
def test_what_is_promised_grows_with_errors(name: str, compiler: Toolchain) -> None:
    noted, promised = GROWTH[name], PROBLEMS[name].promised
    assert growth(PROBLEMS[name]) == pytest.approx(noted, rel=0.1)
    assert promised == pytest.approx(PROMISED * max(1, noted / USUAL_GROWTH))


def test_how_far_errors_grow_is_noted_of_all_problems(tmp_path: Path) -> None:
    assert set(GROWTH) == set(PROBLEMS)
    found = solvers.body(
        [
            Record("slider_crank", "kousoku", line, solvers.TIGHT, "kousoku", 1.0, 1.0, 1, 2e-10)
            for line in ("auto", "dopri5")
        ],
        Figures(tmp_path, "plots"),
    )
    assert "| Spatial slider-crank, 5 s | 57 | 2.0e-10 in 0 steps | 2.0e-10 in 0 steps |" in found


def test_a_scene_starts_where_its_tree_does(compiler: Toolchain) -> None:
    """Also where it is written in another way: joints of other kinds, a file."""
    for name in ("slider_crank", "bricard", "andrews", "governor"):
        problem = PROBLEMS[name]
        h = 1e-6
        result = ks.load(problem.scene()).simulate(times=[0.0, h])
        tree = TREES[name]
        q, v = np.array(tree.q), np.array(tree.v)
        found = problem.observe(result)
        assert np.abs(found[0] - placed(tree, q)).max() < 1e-12
        assert np.abs(found[1] - placed(tree, q + h * v)).max() < 1e-7 * problem.length


def test_the_c_alone_comes_to_the_end(compiler: Toolchain) -> None:
    problem = PROBLEMS["small_pendulum"]
    run = ks.load(problem.scene()).begin(times=[problem.end], checks=False)
    finished(run)
    assert run.time == problem.end and run.written == 1


def test_slopes_are_the_velocities_of_points() -> None:
    tree, h = closed.slider_crank(), 1e-6
    q, v = np.array(tree.q), np.arange(1.0, 5.0)
    point = (3, (-0.1, 0.02, 0.03))
    ahead, behind = (point_at(point, frames(tree, q + side * h * v)) for side in (1, -1))
    found = v @ slopes(tree, point, frames(tree, q))
    assert found == pytest.approx((ahead - behind) / (2 * h), abs=1e-8)


def test_springs_pull_as_their_energy_falls_and_dampers_take_power() -> None:
    tree, h = trees.GOVERNOR, 1e-6
    q, v = np.array([0.3, -1.0, 1.1, 0.02]), np.array([0.1, 0.2, -0.3, 0.4])

    def lengths(q: np.ndarray) -> np.ndarray:
        where = frames(tree, q)
        ends = [(point_at(one.a, where), point_at(one.b, where)) for one in tree.springs]
        return np.array([np.linalg.norm(b - a) for a, b in ends])

    def energy(q: np.ndarray) -> float:
        return float(sum(4e5 * (lengths(q) - 0.45) ** 2))

    still = pulled(tree, q, np.zeros(4))
    slope = [(energy(q + h * e) - energy(q - h * e)) / (2 * h) for e in np.eye(4)]
    assert still == pytest.approx(-np.array(slope), rel=1e-6, abs=1e-3)
    rates = (lengths(q + h * v) - lengths(q - h * v)) / (2 * h)
    power = (pulled(tree, q, v) - still) @ v
    assert power == pytest.approx(-4e4 * float(rates @ rates), rel=1e-6)


@pytest.mark.parametrize("name", TREES)
def test_the_model_of_mujoco_has_all_joints_points_and_loops(name: str) -> None:
    tree = TREES[name]
    root = ElementTree.fromstring(mujoco.text(tree))
    assert len(list(root.iter("joint"))) == len(tree.links)
    assert sorted(mujoco.order_of(tree)) == list(range(len(tree.links)))
    assert len(list(root.iter("connect"))) == len(tree.loops)
    masses = [float(one.attrib["mass"]) for one in root.iter("inertial")]
    assert min(masses) > 0
    assert sum(masses) == pytest.approx(sum(link.mass for link in tree.links))
    named = [one for one in root.iter("site") if "name" in one.attrib]
    assert len(named) == len(tree.observed) + 2 * len(tree.springs)


def test_the_closed_form_of_the_linkage_keeps_all_lengths() -> None:
    angles = np.linspace(0, 2 * np.pi, 13)
    at = linkage.by_circles(angles)
    lengths = linkage.given()[1]
    ends = {"crank": ("O1", "A"), "ab": ("A", "B"), "bp": ("B", "P"), "pa": ("P", "A")}
    ends |= {"rocker1": ("O3", "B"), "rod": ("P", "Q"), "rocker2": ("O6", "Q")}
    for link, (a, b) in ends.items():
        apart = np.linalg.norm(at[a] - at[b], axis=1)
        assert apart == pytest.approx(lengths[link], rel=1e-13), link


@pytest.mark.parametrize("is_full", [False, True])
def test_all_cases_differ_and_need_no_peer_until_they_are_prepared(is_full: bool) -> None:
    size = Size(is_full)
    for contest in solvers.contests(size):
        found = [(one.tool, one.line, one.setting) for one in solvers.cases(contest, size)]
        assert len(set(found)) == len(found)
        assert {"kousoku"} < {tool for tool, *_ in found}
    assert len(solvers.contests(Size())) == 3


def test_a_peer_that_is_not_there_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("mujoco", "exudyn", "pinocchio", "heyoka", "casadi"):
        monkeypatch.setitem(sys.modules, name, None)
    others = [one for one in solvers.cases("andrews", Size(is_full=True)) if one.tool != "kousoku"]
    for case in others:
        with pytest.raises(PeerMissingError, match="pip install"):
            case.prepare()
    assert {one.tool for one in others} == {
        *("heyoka", "SciPy", "CasADi", "MuJoCo", "Pinocchio", "Exudyn")
    }


def test_the_n_four_bar_is_judged_beside_exudyn_by_position_and_energy() -> None:
    line, setting = solvers.EXUDYN
    peer = Record(solvers.FOUR_BARS, "Exudyn", line, setting, "scene", 6.0, 6.0, 1, 1e-2)
    ours = [
        Record(solvers.FOUR_BARS, "kousoku", "dop853", "a", "kousoku", 1e-3, 1e-3, 7, 1e-7),
        Record(solvers.FOUR_BARS, "kousoku", "dop853", "b", "kousoku", 5e-2, 5e-2, 7, 1e-8),
    ]
    ours[0].extra["energy"], ours[1].extra["energy"] = 1e-3, 1e-6
    (target,) = (one for one in solvers.targets([*ours, peer]) if "Exudyn" in one.quantity)
    assert target.value == pytest.approx(5e-2 / 6) and target.is_met
