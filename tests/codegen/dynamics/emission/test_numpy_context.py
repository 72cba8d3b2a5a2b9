"""The solver in Python: its segments compute what the program says, one by one and together."""

from __future__ import annotations

import ast
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.emission.emit import emit_dynamics
from kousoku.codegen.dynamics.emission.numpy_context import numpy_context
from kousoku.codegen.dynamics.recording.inline import inline
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.recording.program import SEGMENTS
from kousoku.runtime.importing import import_source
from kousoku.runtime.integrate.tasks import MANY
from tests.analysed import all_rows

if TYPE_CHECKING:
    from types import SimpleNamespace

    from kousoku.codegen.dynamics.recording.program import Program


def solver_of(program: Program, system: Any) -> Any:
    """Solver of a program, with the integrator that goes along."""
    files = {name: text.encode() for name, text in emit_dynamics(program, system).items()}
    return import_source(Path(system.name), files, "solver.py").SOLVER


def run(solver: Any, values: list[float]) -> list[float]:
    """Run all segments on a workspace."""
    w = np.array(values)
    workspace = sys.modules[type(solver.scene).__module__].Workspace(solver.scene, w)
    with np.errstate(all="ignore"):
        for name in SEGMENTS:
            workspace.run(name)
    result: list[float] = w.tolist()
    return result


@pytest.mark.parametrize(
    ("name", "count", "limit"),
    [("chain", 3, 0), ("chain", 20, 0), ("four_bars", 1, 100_000), ("four_bars", 17, 0)],
)
def test_segments_compute_the_same_bits_as_the_program(
    mechanisms: SimpleNamespace, rng: np.random.Generator, name: str, count: int, limit: int
) -> None:
    system = getattr(mechanisms, name)(count)
    program = inline(compose(all_rows(system)), limit=limit)
    workspace = ProgramInterpreter(program)
    for region in ("q", "v"):
        noise = rng.normal(scale=0.05, size=len(workspace[region]))
        workspace[region] = [a + b for a, b in zip(workspace[region], noise, strict=True)]
    values = run(solver_of(program, system), workspace.values)
    workspace.run(*(segment.name for segment in program.segments))
    assert values == workspace.values
    assert max(map(abs, workspace["v_dot"])) > 0.1


def test_equal_tasks_of_a_level_run_together(mechanisms: SimpleNamespace) -> None:
    system = mechanisms.chain(40)
    geometry = solver_of(compose(all_rows(system)), system).scene.segments["geometry"]
    together = [tasks for tasks in geometry if hasattr(tasks, "writes")]
    assert sum(tasks.writes.shape[1] for tasks in together) >= 2 * 40
    assert all(tasks.reads.shape[1] >= MANY for tasks in together)


def test_a_kernel_unpacks_only_what_it_reads(mechanisms: SimpleNamespace) -> None:
    system = mechanisms.heavy_top()
    program = inline(compose(all_rows(system)), limit=100_000)
    for kernel in numpy_context(program, system, 1.0).kernels:
        read = " ".join((*(text for _, text in kernel.statements), *kernel.results))
        assert all(name in read for name in kernel.inputs)
        assert len(kernel.inputs) < program.size


def test_the_text_is_python_with_the_integrator_alone_in_lines_of_a_hundred(
    mechanisms: SimpleNamespace,
) -> None:
    system = mechanisms.chain(3)
    text = emit_dynamics(compose(all_rows(system)), system)["solver.py"]
    imported = {
        name
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in ([node.module] if isinstance(node, ast.ImportFrom) else [node.names[0].name])
    }
    inside = {"integrate.scene_tables", "integrate.scene_solver", "integrate.tasks"}
    assert imported <= {"__future__", "typing", *inside}
    assert max(map(len, text.splitlines())) <= 100


def test_tasks_say_what_they_belong_to_in_both_languages(mechanisms: SimpleNamespace) -> None:
    system = mechanisms.chain(3)
    files = emit_dynamics(compose(all_rows(system)), system)
    joints = {one.joint for one in system.constraints}
    for name in ("solver.c", "solver.py"):
        owners = set(re.findall(r"(?:/\*|#) (\w+)(?: \*/)?$", files[name], re.MULTILINE))
        assert owners >= joints | {body.name for body in system.bodies}
