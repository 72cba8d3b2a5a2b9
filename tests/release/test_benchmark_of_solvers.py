"""The benchmark of solvers: it times what is right, misses no target, and goes on without peers."""

import json
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from kousoku.runtime.toolchain import Toolchain

ROOT = Path(__file__).parents[2]
FILES = ("solvers", "chains", "aba", "four_bars", "first_step", "loops", "peers", "p2")


@pytest.fixture
def solvers(monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """Import the benchmark's files, which stand beside each other."""
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    yield import_module("solvers")
    for name in FILES:
        sys.modules.pop(name, None)


@pytest.mark.parametrize("count", [2, 10])
def test_the_accelerations_that_are_timed_are_those_of_dense_matrices(
    solvers: ModuleType, compiler: Toolchain, tmp_path: Path, count: int
) -> None:
    """At random consistent states; the matrices are those of joint angles, without constraints."""
    chains = solvers.chains
    ours = chains.kousoku_accelerations(count, tmp_path)
    ours.run(1)
    assert chains.difference(ours.results(), chains.reference(count)) < 1e-11


def test_the_recursion_gives_what_dense_matrices_give(solvers: ModuleType) -> None:
    theta, rate = solvers.chains.joint_states(10)
    wanted = [solvers.chains.dense(*state) for state in zip(theta, rate, strict=True)]
    assert solvers.chains.recursive(theta, rate) == pytest.approx(np.array(wanted), rel=1e-10)


def test_the_accelerations_of_a_thousand_bars_are_those_of_the_recursion(
    solvers: ModuleType, compiler: Toolchain, tmp_path: Path
) -> None:
    benchmark = solvers.Benchmark()
    solvers.long_chain(benchmark, tmp_path)
    (target,) = benchmark.targets
    assert target.is_met and target.limit == 1e-9, target


def test_the_dense_matrices_swing_a_bar_as_a_pendulum(solvers: ModuleType) -> None:
    """θ̈ = m g l cos θ / J about the hinge, θ downwards from the horizontal about y."""
    theta = np.array([0.3])
    inertia = 1.01 / 12 + 0.25
    wanted = 9.81 * 0.5 * np.cos(theta) / inertia
    assert solvers.chains.dense(theta, np.array([0.7])) == pytest.approx(wanted, rel=1e-14)


def test_the_motion_of_the_bars_is_differentiated_as_differences_are(solvers: ModuleType) -> None:
    theta, rate = (array[:2, :4] for array in solvers.chains.joint_states(10))
    change, h = rate[::-1], 1e-4

    def at(t: float) -> object:
        angles = theta + t * rate + t * t / 2 * change
        return solvers.chains.bars(angles, rate + t * change, change)

    before, now, after = at(-h), at(0.0), at(h)
    for value, slope in (("r", "v"), ("v", "a"), ("omega_b", "alpha_b")):
        difference = (getattr(after, value) - getattr(before, value)) / (2 * h)
        assert getattr(now, slope) == pytest.approx(difference, rel=1e-6, abs=1e-6)


def test_the_loosest_tolerance_reaches_both_limits_and_a_looser_one_does_not(
    solvers: ModuleType, compiler: Toolchain, tmp_path: Path
) -> None:
    bars = solvers.four_bars
    solver = bars.load(tmp_path)
    tolerance, method = bars.cheapest(solver)
    reached = bars.kousoku_run(solver, tolerance, method, bars.ROWS)
    assert reached.position <= 1e-6 and reached.energy <= 5e-6
    looser = bars.kousoku_run(solver, 10 * tolerance, method, bars.ROWS)
    assert looser.position > 1e-6 or looser.energy > 5e-6


def fake(solvers: ModuleType, value: float | None) -> object:
    benchmark = solvers.Benchmark()
    benchmark.row("a contest", "kousoku", "1 ns", "0")
    benchmark.judge("a contest", "time over a peer's", value, 0.7)
    benchmark.missing.append("the benchmark needs a peer")
    return benchmark


@pytest.mark.parametrize(
    ("value", "status", "said"),
    [(0.7, 0, ""), (0.71, 1, "is 0.71"), (None, 1, "is not measured")],
)
def test_check_fails_and_names_the_target_that_is_missed_or_not_measured(
    solvers: ModuleType,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    value: float | None,
    status: int,
    said: str,
) -> None:
    monkeypatch.setattr(solvers, "run_all", lambda: fake(solvers, value))
    monkeypatch.setattr(solvers, "described", lambda: ["here"])
    monkeypatch.setattr(sys, "argv", ["solvers.py", "--check", "--json"])
    assert solvers.main() == status
    printed = capsys.readouterr()
    assert json.loads(printed.out)["targets"][0]["is_met"] is (status == 0)
    assert "left out: the benchmark needs a peer" in printed.err
    line = f"a contest: time over a peer's {said}, wanted at most 0.7"
    assert (line in printed.err) is (status == 1)


def test_without_check_a_missed_target_is_no_failure(
    solvers: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(solvers, "run_all", lambda: fake(solvers, 9.0))
    monkeypatch.setattr(solvers, "described", lambda: ["here"])
    monkeypatch.setattr(sys, "argv", ["solvers.py"])
    assert solvers.main() == 0
    assert "MISSED a contest" in capsys.readouterr().out


def test_without_peers_what_does_not_need_them_is_there(
    solvers: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in ("exudyn", "pinocchio"):
        monkeypatch.setitem(sys.modules, name, None)
    benchmark = solvers.Benchmark()
    peers = solvers.find_peers(benchmark, tmp_path)
    assert not peers.has_pinocchio and peers.loop is None and peers.exudyn is None
    assert len(benchmark.missing) == 2
    assert "pinocchio" in benchmark.missing[0] and "exudyn" in benchmark.missing[1]
