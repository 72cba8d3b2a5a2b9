"""Constraints that are left out because they depend on others are watched in every run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.emission.emit import emit_dynamics
from kousoku.codegen.dynamics.generate import LEDGER_OUTPUTS, generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.errors import MotionError
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.read import read_scene
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.integrate.motion import Motion
from tests.analysed import all_rows, without

if TYPE_CHECKING:
    from kousoku.runtime.toolchain import Toolchain

SCENES = Path(__file__).parents[2] / "scenes"


@pytest.fixture(scope="module")
def loose(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a pendulum whose hinge does not hold its point along x."""
    system = assemble(system_of(read_scene(SCENES / "pendulum.toml")))
    whole = all_rows(system)
    kinds = [one.kind for one in system.constraints]
    rows = [x for x in whole.outline.rows if (kinds[x.instance], x.row) == ("point", 0)]
    folder = tmp_path_factory.mktemp("loose") / "pendulum"
    write_tree(folder, emit_dynamics(compose(without(whole, rows), LEDGER_OUTPUTS), system))
    return folder


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_joint_that_comes_open_where_a_row_was_left_out_is_named(
    compiler: Toolchain, loose: Path, target: Any
) -> None:
    with pytest.raises(MotionError, match=r"joints come open: .*: joints\.hinge by") as stopped:
        load_dynamics(loose, target=target).simulate(0.5, samples=6)
    motion = stopped.value.result
    assert isinstance(motion, Motion)
    ledger = motion.ledger

    assert len(motion) < 6
    assert ledger.released == ("hinge",)
    assert ledger.violations["hinge"].metres[0] > 1e-6
    assert ledger.worst_joint("position") == "hinge"
    assert "came open: joints.hinge; a constraint that was left out" in str(ledger)


@pytest.mark.usefixtures("numpy_solver", "shipped_flags")
def test_row_that_depends_on_others_is_met_and_the_same_in_both_targets(
    compiler: Toolchain, tmp_path: Path
) -> None:
    folder = tmp_path / "bricard"
    write_tree(folder, generate_dynamics(read_scene(SCENES / "bricard.toml"), ()))
    solvers = [load_dynamics(folder, target=target) for target in ("c", "numpy")]
    runs = [solver.begin(np.linspace(0.0, 0.5, 4), tolerance=1e-9) for solver in solvers]
    ledgers = [run.finish().ledger for run in runs]

    assert len(solvers[0].rows) == 29
    assert len(solvers[0].left_out) == 1
    assert ledgers[0].released == ()
    assert "came open" not in str(ledgers[0])
    np.testing.assert_array_equal(runs[0].state, runs[1].state)
    joint = solvers[0].left_out[0][0]
    # nothing solves for it: the other 29 rows hold it up to rounding
    assert 0.0 < max(ledgers[0].violations[joint].radians[:2]) < 1e-12


def test_checks_can_be_left_out_of_a_run(compiler: Toolchain, loose: Path) -> None:
    ledger = load_dynamics(loose).simulate(0.5, samples=6, checks=False).ledger

    assert ledger.released == ()
    assert not ledger.violations
