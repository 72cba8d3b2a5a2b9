"""A type checker sees what is misspelt at the door, and takes what is right."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

from kousoku.runtime.integrate import result
from kousoku.runtime.kinematics.trajectory import Iterations
from kousoku.runtime.run_ledger import RunLedger

ROOT = Path(__file__).parents[2]

#: A user's program; what is marked is wrong, and nothing else is.
PROGRAM = """
import kousoku as ks
from matplotlib.figure import Figure

loop = ks.load("loop.toml", outputs=["reactions"], target="c")
loop = ks.load("loop.toml", outputs=["reaction"])  # wrong
loop = ks.load("loop.toml", taget="c")  # wrong

run = loop.simulate(2, parameters={"mass": 2}, initial={"angle": "30 deg"}, largest_step=0.01)
run = loop.simulate(2, tolerence=1e-6)  # wrong
run = loop.simulate(2, method="euler")  # wrong
run = loop.simulate(2, samples=3, method="newton", limit=1e-9)
run = loop.simulate(2, tolerance=1e-6, limit=1e-9)  # wrong
run = loop.simulate(2, method="newton", tolerance=1e-6)  # wrong
run = loop.solve(divisions=12, turns=2)
run = loop.solve(division=12)  # wrong
going = loop.begin([0, 1], checks=False)
going = loop.begin([0, 1], chekcs=False)  # wrong

run.animate("x.html", paths_of=["a", ("rod", (0, 0, 1))], forces=False, fps=10, speed=0.5)
run.animate("x.html", path_of="a")  # wrong
run.animate("x.html", speed="slow")  # wrong
page: str = run.animate(start=1, end=2).html
run.animate().stil()  # wrong
figure: Figure = run.plot("crank.x")
run.plot(column="crank.x")  # wrong
run.plot().savfig("x.png")  # wrong
for one in run.figures(of="rod").values():
    one.savefig("x.png")
force: float = run.joint("a").force[0, 1]
place: float = run.body("rod").positoin[0, 1]  # wrong
by: str = run.stopped_by or f"{run.method} {run.iterations.max()}"
count: int = run.events["lands"].cuont  # wrong
left: float = run.ledger.violations["a"].metres[0] + run.ledger.residual
if run.ledger.trust.is_trusted and run.ledger.energy_eror:  # wrong
    going.motion().ledger.step  # wrong
run.save("x.csv")
run.save(path_of="x.csv")  # wrong

builder = ks.SceneBuilder("arm", unit="m")
builder.body("rod", position=(0, 0, 0), mass=1)
builder.body("rod", positoin=(0, 0, 0))  # wrong

try:
    loop.simulate(2)
except ks.MotionError as error:
    error.result.save("x.csv")
"""


def test_a_type_checker_sees_the_fields_of_both_ledgers() -> None:
    (shown,) = (
        node
        for node in ast.walk(ast.parse(Path(result.__file__).read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef) and node.name == "Ledger"
    )
    fields = {
        ast.unparse(one.target): ast.unparse(one.annotation)
        for one in shown.body
        if isinstance(one, ast.AnnAssign)
    }
    of_linkages = {name: one.__forward_arg__ for name, one in Iterations.__annotations__.items()}
    known = RunLedger.__annotations__ | of_linkages
    assert {name: what for name, what in fields.items() if "Callable" not in what} == known
    assert all(hasattr(RunLedger, name) for name in fields.keys() - known.keys())


def test_what_is_misspelt_is_seen_by_a_type_checker(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    program = tmp_path / "program.py"
    program.write_text(PROGRAM, encoding="utf-8")
    found = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", str(program)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    ).stdout
    wrong = {k for k, line in enumerate(PROGRAM.splitlines(), 1) if line.endswith("# wrong")}
    told = set(map(int, re.findall(r"program\.py:(\d+): error", found)))
    assert told == wrong, found
    assert len(wrong) == 19
