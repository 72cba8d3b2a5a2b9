"""The programs in docs/dynamics.md run, and its numbers hold."""

from __future__ import annotations

import ast
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pytest

    from kousoku.runtime.toolchain import Toolchain

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "dynamics.md").read_text(encoding="utf-8")


def test_programs_of_the_document_run(
    compiler: Toolchain, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(ROOT / "scenes", tmp_path / "scenes")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for number, block in enumerate(re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)):
        program = tmp_path / f"program_{number}.py"
        program.write_text(block, encoding="utf-8")
        names = runpy.run_path(str(program), init_globals=names)
    assert names["motion"].time.tolist() == [0.0, 0.5, 1.0, 1.5]
    assert names["motion"].is_complete
    assert (tmp_path / "top.csv").is_file()


def test_the_study_of_parameters_prints_what_the_document_says(compiler: Toolchain) -> None:
    study = ROOT / "docs" / "examples" / "parameter_study.py"
    done = subprocess.run([sys.executable, study], check=True, capture_output=True, text=True)
    table = re.search(r"```text\n(crank.*?)```", TEXT, re.DOTALL)
    assert table is not None
    assert done.stdout == table[1]
    for line in done.stdout.splitlines()[1:]:
        crank, rod, force = (float(x) for x in re.findall(r"[\d.]+", line))
        assert abs(force - 0.4 * crank * 300**2 * (1 + crank / rod)) < 0.1  # at its dead centre


def test_table_of_the_ledger_has_every_field_of_it() -> None:
    from kousoku.runtime.run_ledger import RunLedger

    table = TEXT.partition("## The ledger")[2].partition("`checks=False`")[0]
    fields = " ".join(re.findall(r"^\| (`.*?) \|", table, re.MULTILINE))
    assert set(re.findall(r"`(\w+)`", fields)) == set(RunLedger.__slots__)


def test_answers_and_types_of_ledgers_have_every_field_of_them() -> None:
    from kousoku.cli.answers import RunLedgerAnswer
    from kousoku.runtime.kinematics.trajectory import Iterations
    from kousoku.runtime.run_ledger import RunLedger

    fields = set(RunLedger.__slots__)
    assert set(RunLedgerAnswer.__annotations__) == fields - {"trust"}  # an answer of its own
    tree = ast.parse((ROOT / "runtime" / "integrate" / "result.py").read_text(encoding="utf-8"))
    of_types = next(x for x in ast.walk(tree) if isinstance(x, ast.ClassDef) and x.name == "Ledger")
    named = {ast.unparse(x.target) for x in of_types.body if isinstance(x, ast.AnnAssign)}
    called = {name for name in named if callable(getattr(RunLedger, name, None))}
    assert named - called == fields | set(Iterations._fields)


def test_return_values_are_those_of_the_header(compiler: Toolchain) -> None:
    from kousoku.runtime.integrate.settings import MESSAGES

    table = TEXT.partition("A call of `…_run` returns")[2]
    listed = {int(x.replace("−", "-")) for x in re.findall(r"−?\d+(?=[,; ])", table)}
    assert set(MESSAGES) | {0, 1, 2} <= listed
