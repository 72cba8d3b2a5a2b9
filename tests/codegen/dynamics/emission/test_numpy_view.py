"""The solver in Python: its segments compute what the program says, one by one and together."""

from __future__ import annotations

import ast
import math
import re
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.checking.run import Workspace
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.emission.emit import emit_dynamics
from kousoku.codegen.dynamics.emission.numpy_view import numpy_view
from kousoku.codegen.dynamics.recording.inline import inline
from kousoku.codegen.dynamics.recording.program import SEGMENTS

if TYPE_CHECKING:
    from types import SimpleNamespace

    from kousoku.codegen.dynamics.recording.program import Program


def text_of(program: Program, system: Any) -> str:
    return emit_dynamics(program, system)["solver.py"]


def module_of(text: str) -> Any:
    module = ModuleType("solver")
    exec(compile(text, "solver.py", "exec"), module.__dict__)
    return module


def run(module: Any, values: list[float]) -> list[float]:
    """Run all segments on a workspace."""
    w = np.array(values)
    with np.errstate(all="ignore"):
        for name in SEGMENTS:
            if hasattr(module, name):
                getattr(module, name)(w)
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
    program = inline(compose(system), limit=limit)
    workspace = Workspace(program)
    for region in ("q", "v"):
        noise = rng.normal(scale=0.05, size=len(workspace[region]))
        workspace[region] = [a + b for a, b in zip(workspace[region], noise, strict=True)]
    values = run(module_of(text_of(program, system)), workspace.values)
    workspace.run(*(segment.name for segment in program.segments))
    assert values == workspace.values
    assert max(map(abs, workspace["v_dot"])) > 0.1


def test_equal_tasks_of_a_level_run_together(mechanisms: SimpleNamespace) -> None:
    system = mechanisms.chain(40)
    module = module_of(text_of(compose(system), system))
    together = [tasks for tasks in module.GEOMETRY if isinstance(tasks, module.Together)]
    assert sum(tasks.writes.shape[1] for tasks in together) >= 2 * 40
    assert all(tasks.reads.shape[1] >= module.MANY for tasks in together)


@pytest.mark.parametrize(
    ("value", "wanted"), [(0.0, math.inf), (-1.0, math.nan), (math.inf, math.nan)]
)
def test_what_no_number_comes_out_of_gives_infinities_and_nan_as_in_c(
    mechanisms: SimpleNamespace, value: float, wanted: float
) -> None:
    system = mechanisms.heavy_top()
    module = module_of(text_of(inline(compose(system), limit=100_000), system))

    def kernel(x: Any, m: Any) -> list[Any]:
        return [m.cos(x[0]) / (m.sqrt(x[0]) * m.fabs(x[0]))]

    tasks = module.InTurn(np.array([0]), [(kernel, module.picker([0]))], np.array([1]))
    w = np.array([value, 0.0])
    with np.errstate(all="ignore"):
        module.run_tasks(w, [tasks])
    np.testing.assert_equal(w[1], wanted)


def test_functions_of_arrays_have_the_bits_of_those_of_floats(
    mechanisms: SimpleNamespace, rng: np.random.Generator
) -> None:
    system = mechanisms.heavy_top()
    module = module_of(text_of(compose(system), system))
    x, y = rng.uniform(0.0, 7.0, size=(2, 2000))
    for name in ("sqrt", "sin", "cos", "exp", "log"):
        wanted = [getattr(math, name)(value) for value in x]
        np.testing.assert_array_equal(getattr(module.OF_ARRAYS, name)(x), wanted, err_msg=name)
    wanted = [math.atan2(*pair) for pair in zip(x, y, strict=True)]
    np.testing.assert_array_equal(module.OF_ARRAYS.atan2(x, y), wanted)
    np.testing.assert_array_equal(module.OF_ARRAYS.atan2(0.0, -x), np.full(len(x), math.pi))
    with np.errstate(all="ignore"):
        np.testing.assert_array_equal(module.OF_ARRAYS.log(np.array([0.0, 1.0])), [-np.inf, 0.0])


def test_a_kernel_unpacks_only_what_it_reads(mechanisms: SimpleNamespace) -> None:
    system = mechanisms.heavy_top()
    program = inline(compose(system), limit=100_000)
    for kernel in numpy_view(program, 1.0).kernels:
        read = " ".join(text for _, text in kernel.statements) + " ".join(kernel.results)
        assert all(name in read for name in kernel.inputs)
        assert len(kernel.inputs) < program.size


def test_both_languages_have_the_same_functions_and_the_same_state(
    mechanisms: SimpleNamespace,
) -> None:
    system = mechanisms.chain(3)
    outputs = ("accelerations", "reactions", "energies")
    files = emit_dynamics(compose(system, ("checks", *outputs)), system, outputs)
    c, python = files["solver.c"], files["solver.py"]
    start = r"^(?:static )?(?:int|double|void|size_t|const char \*) ?(?:kousoku_chain3_)?(\w+)\("
    in_c = set(re.findall(start, c, re.MULTILINE))
    tree = ast.parse(python)
    in_python = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    # NumPy and modules have these already
    assert in_c - in_python == {
        *("are_finite", "digest", "state_size", "work_size", "row_size"),
        *("placed", "accelerations"),
    }
    reading = {"numbers", "places", "tasks_of", "in_turn", "picker"}
    assert in_python - in_c == reading | {
        *("evaluated", "fmax", "of_each", "parts_of", "mean_square", "advance")
    }
    module = module_of(python)
    enum = "    " + c[c.index("S_KEY") : c.index("S_COUNT")]
    names = re.findall(r"^ *(S_\w+),", enum, re.MULTILINE)
    assert [getattr(module, name) for name in names] == list(range(module.S_COUNT))


def test_the_text_is_python_with_numpy_alone_in_lines_of_a_hundred(
    mechanisms: SimpleNamespace,
) -> None:
    system = mechanisms.chain(3)
    text = text_of(compose(system), system)
    imported = {
        name
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in ([node.module] if isinstance(node, ast.ImportFrom) else [node.names[0].name])
    }
    allowed = {"__future__", "math", "operator", "typing", "collections.abc", "numpy"}
    assert imported <= allowed | {"numpy.typing"}
    assert max(map(len, text.splitlines())) <= 100
