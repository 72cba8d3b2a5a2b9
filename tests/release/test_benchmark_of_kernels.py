"""The kernel benchmark: it states the emitted problem, judges its targets, misses no peer."""

import json
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from kousoku import runtime

Modules = tuple[ModuleType, ModuleType, ModuleType]

ROOT = Path(__file__).parents[2]


@pytest.fixture
def modules() -> Modules:
    """Return the benchmark's modules."""
    kernels, p2, kit = (import_module(f"benchmarks.{name}") for name in ("kernels", "p2", "kit"))
    return kernels, p2, kit


def test_the_peers_get_the_formula_that_is_emitted(modules: Modules) -> None:
    _, p2, _ = modules
    rows = p2.inputs(5)
    c, c_q = p2.p2(*[list(array.T) for array in rows])
    library = runtime.load(ROOT / "generated" / "kinds" / "p2", target="numpy")
    wanted_c, wanted_c_q = library["constraint_z"](*rows)
    np.testing.assert_allclose(np.stack(c, axis=-1), wanted_c, rtol=1e-13, atol=1e-14)
    jacobian = np.stack([np.stack(row, axis=-1) for row in c_q], axis=-2)
    np.testing.assert_allclose(jacobian, wanted_c_q, rtol=1e-13, atol=1e-14)


def test_the_judge_measures_in_units_of_rounding(modules: Modules) -> None:
    _, p2, _ = modules
    judge = p2.Judge()
    c, c_q = p2.p2(*[list(array.T) for array in judge.inputs])
    c = np.stack(c, axis=-1)
    c_q = np.stack([np.stack(row, axis=-1) for row in c_q], axis=-2)
    assert judge.worst(c, c_q) < 4
    c[7, 1] += 1e-12
    assert judge.worst(c, c_q) > 100


def test_a_missing_peer_is_an_error_that_says_what_to_install(modules: Modules) -> None:
    _, _, peers = modules
    with pytest.raises(peers.MissingError, match=r"no_such_peer.*kousoku\[bench\]"):
        peers.required("no_such_peer")


def fake(kernels: ModuleType, ratio: float) -> Any:
    benchmark = object.__new__(kernels.Benchmark)
    benchmark.rows = [kernels.Row("a contest", "kousoku", 1.0, 0.5)]
    benchmark.targets = [kernels.Target("a contest", "kousoku", "peer", ratio, 0.7)]
    return benchmark


@pytest.mark.parametrize(("ratio", "status"), [(0.7, 0), (0.71, 1)])
def test_check_fails_and_names_the_target_that_is_missed(
    modules: Modules,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    ratio: float,
    status: int,
) -> None:
    kernels, _, _ = modules
    monkeypatch.setattr(kernels, "run_all", lambda _folder: fake(kernels, ratio))
    monkeypatch.setattr(kernels, "described", lambda: ["here"])
    monkeypatch.setattr(sys, "argv", ["kernels.py", "--check", "--json"])
    assert kernels.main() == status
    printed = capsys.readouterr()
    assert json.loads(printed.out)["targets"][0]["is_met"] is (status == 0)
    assert ("a contest: kousoku takes 0.71 of peer, wanted at most 0.7" in printed.err) is (
        status == 1
    )


def test_a_missing_peer_ends_the_run_with_status_2(
    modules: Modules, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    kernels, _, peers = modules

    def fail(_folder: Path) -> None:
        raise peers.MissingError("the benchmark needs heyoka")

    monkeypatch.setattr(kernels, "run_all", fail)
    monkeypatch.setattr(sys, "argv", ["kernels.py"])
    assert kernels.main() == 2
    assert "needs heyoka" in capsys.readouterr().err
