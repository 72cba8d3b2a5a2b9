"""The rooms of the house: who may import whom, what stays light, and what is named is there."""

from __future__ import annotations

import ast
import json
import os
import pkgutil
import re
import subprocess
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path

import pytest

from kousoku.codegen.emit import MESSAGES, OF_MODEL, runtime_source, runtime_sources

ROOT = Path(__file__).parents[1]

#: A folder may import itself and what stands here.
MAY_IMPORT = {
    "model": set(),
    "symbolic": {"model"},
    "ledger": {"model", "symbolic"},
    "codegen": {"model", "symbolic", "library"},
    "runtime": {"model", "library"},
    "generated": {"runtime", "library"},
}
#: Rooms of a folder, and files beside them; each may import what stands before it.
STAGES = {
    "model": (
        *("errors", "angles", "text", "version", "files", "operations", "records", "numbers"),
        *("expressions", "mechanics", "linkage", "elements", "validation", "reading", "lowering"),
    ),
    "codegen/dynamics": (
        *("disjoint_sets", "recording", "operations", "own_kinds", "elements", "assembly"),
        *("simplification", "redundancy", "assembled", "analyse", "composition", "emission"),
        *("checking", "choose", "generate", "explanation"),
    ),
}
#: The room of ``model``, and the files beside it, that ``runtime`` uses.
SHARED = {"angles", "errors", "files"}
#: Folders of ``runtime`` that generated folders take along.
LIBRARIES = ("integrate", "kinematics")
#: The file of ``runtime`` that they use, and which goes along, too.
BESIDE = "messages"
#: Modules that import each other in a circle, at most: at the top of files; inside of functions,
#: too; and for types alone. These numbers may only fall.
MOST_IN_CYCLES = {"top": 0, "functions": 9, "types": 59}
#: Packages whose docstrings list their modules.
WITH_LISTS = (
    *("codegen", "codegen/linkage", "runtime", "runtime/kinematics", "ledger/documents"),
    *(f"codegen/dynamics/{name}" for name in ("recording", "operations", "assembly")),
    *(f"codegen/dynamics/{name}" for name in ("simplification", "redundancy", "composition")),
    *(f"codegen/dynamics/{name}" for name in ("emission", "checking", "explanation")),
)
HAND_WRITTEN = ("kousoku", "model", "symbolic", "ledger", "codegen", "runtime", "tests/benchmarks")


def sources(folder: str) -> list[Path]:
    """Python files of a root folder, its links left out."""
    found = (ROOT / folder).rglob("*.py")
    return sorted(path for path in found if not any(p.is_symlink() for p in path.parents))


class _WhatIsReadFirst(ast.NodeTransformer):
    """Leaves out what runs when a function is called."""

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        return None


class _WhatRuns(ast.NodeTransformer):
    """Leaves out what type checkers alone read."""

    def visit_If(self, node: ast.If) -> ast.If | None:
        return None if ast.unparse(node.test) == "TYPE_CHECKING" else node


@cache
def imports(path: Path, *, with_types: bool = True, in_functions: bool = True) -> set[str]:
    """Absolute names of all that a file imports, wherever in the file."""
    names = set()
    package = ("kousoku", *path.relative_to(ROOT).parent.parts)
    tree = ast.parse(path.read_text(encoding="utf-8"))
    tree = tree if with_types else _WhatRuns().visit(tree)
    for node in ast.walk(tree if in_functions else _WhatIsReadFirst().visit(tree)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) + 1 - node.level] if node.level else ()
            module = ".".join((*above, *filter(None, [node.module])))
            names.add(module)
            names |= {f"{module}.{alias.name}" for alias in node.names}
    return names


def rooms(path: Path) -> set[str]:
    """Sub-packages of kousoku that a file imports; ``library``: what goes along."""
    parts = (name.split(".")[1:3] for name in imports(path) if name.startswith("kousoku."))
    return {"library" if part[-1] in {*LIBRARIES, BESIDE} else part[0] for part in parts}


@pytest.mark.parametrize("folder", MAY_IMPORT)
def test_each_folder_imports_only_what_stands_left_of_it(folder: str) -> None:
    allowed = MAY_IMPORT[folder] | {folder}
    wrong = {str(p.relative_to(ROOT)): rooms(p) - allowed for p in sources(folder)}
    assert not {path: names for path, names in wrong.items() if names}


@pytest.mark.parametrize(("within", "stage"), [(a, b) for a in STAGES for b in STAGES[a]])
def test_each_stage_imports_only_what_stands_before_it(within: str, stage: str) -> None:
    """So that no two rooms import each other, not even for a type.

    Only elements name, in types, the stages that call them with themselves as an argument.
    """
    after = STAGES[within][STAGES[within].index(stage) + 1 :]
    folder = ROOT / within
    above = f"kousoku.{within.replace('/', '.')}."
    for path in sorted((folder / stage).rglob("*.py")) or [folder / f"{stage}.py"]:
        names = imports(path, with_types=stage != "elements")
        used = {name.removeprefix(above).split(".")[0] for name in names if name.startswith(above)}
        assert used.isdisjoint(after), path


@pytest.mark.parametrize("within", STAGES)
def test_every_stage_has_its_place(within: str) -> None:
    folder = ROOT / within
    assert {path.parent.name for path in folder.glob("*/__init__.py")} | {
        path.stem for path in folder.glob("*.py") if path.stem != "__init__"
    } == {*STAGES[within]}


def test_pictures_use_nothing_of_the_door_that_shows_them() -> None:
    door = {path.stem for path in (ROOT / "kousoku").glob("*.py")} | {"cli"}
    for path in sources("kousoku/view"):
        assert door.isdisjoint(rooms(path)) and "kousoku" not in imports(path), path


def test_no_file_imports_a_root_folder_by_its_bare_name() -> None:
    bare = {*MAY_IMPORT}
    for folder in (*HAND_WRITTEN, "generated", "tests"):
        for path in sources(folder):
            assert not bare & {name.split(".")[0] for name in imports(path)}, path


@pytest.mark.parametrize("folder", ["runtime", "generated"])
def test_what_runs_needs_numpy_and_the_standard_library_only(folder: str) -> None:
    allowed = sys.stdlib_module_names | {"numpy", "kousoku"}
    for path in sources(folder):
        assert {name.split(".")[0] for name in imports(path, with_types=False)} <= allowed, path


def test_runtime_uses_only_what_is_light_of_model() -> None:
    for path in sources("runtime"):
        used = {n.split(".")[2] for n in imports(path) if n.startswith("kousoku.model.")}
        assert used <= SHARED, path


@pytest.mark.parametrize("folder", LIBRARIES)
def test_libraries_that_are_copied_along_stand_alone(folder: str) -> None:
    """They import NumPy, the standard library, and each other by relative names."""
    allowed = sys.stdlib_module_names | {"numpy"}
    for path in sources(f"runtime/{folder}"):
        inside = tuple(f"kousoku.runtime.{name}." for name in (*LIBRARIES, BESIDE))
        names = imports(path, with_types=False)
        others = {name for name in names if not f"{name}.".startswith(inside)}
        assert {name.split(".")[0] for name in others} <= allowed, path
        assert not re.search(r"(from|import) kousoku", path.read_text(encoding="utf-8")), path
    for path in (ROOT / "runtime" / folder).glob("*.h"):
        text = path.read_text(encoding="utf-8")
        included = set(re.findall(r'#include "(.+)"', text))
        # The tables of methods in C are written from those in Python.
        assert included <= {other.name for other in path.parent.glob("*.h")} | {"methods.h"}, path
        assert max(map(len, text.splitlines())) <= 100 and "\t" not in text, path


def test_messages_that_are_copied_along_stand_alone() -> None:
    path = ROOT / "runtime" / f"{BESIDE}.py"
    assert {name.split(".")[0] for name in imports(path)} <= sys.stdlib_module_names
    assert runtime_sources(MESSAGES) == {path.name: path.read_text(encoding="utf-8")}


def test_files_of_model_that_are_copied_along_stand_alone() -> None:
    """They import the standard library only, and what differs names them."""
    for copy, own in OF_MODEL.items():
        path = ROOT / "model" / own
        assert {name.split(".")[0] for name in imports(path)} <= sys.stdlib_module_names, path
        assert runtime_source(copy) == (f"model/{own}", path.read_text(encoding="utf-8"))
        assert runtime_sources(copy.partition("/")[0])[copy] == path.read_text(encoding="utf-8")


def in_cycles(graph: dict[str, set[str]]) -> set[str]:
    """Modules from which imports lead back to themselves."""
    reached = {name: set(others) for name, others in graph.items()}
    for middle in graph:  # Warshall's closure
        for name in [name for name in graph if middle in reached[name]]:
            reached[name] |= reached[middle]
    return {name for name, others in reached.items() if name in others}


@pytest.mark.parametrize("where", MOST_IN_CYCLES)
def test_modules_that_import_each_other_in_a_circle_do_not_become_more(where: str) -> None:
    paths = [path for room in HAND_WRITTEN for path in sources(room)]
    parts = {path: path.relative_to(ROOT).with_suffix("").parts for path in paths}
    modules = {
        ".".join(("kousoku", *own[own[0] == "kousoku" :])).removesuffix(".__init__"): path
        for path, own in parts.items()
    }
    graph = {}
    for name, path in modules.items():
        found = imports(path, with_types=where == "types", in_functions=where != "top")
        graph[name] = (found & modules.keys()) - {name}
    wrong = in_cycles(graph)
    assert len(wrong) <= MOST_IN_CYCLES[where], sorted(wrong)


def modules_after(code: str) -> set[str]:
    """Run code in a fresh interpreter and return the top-level modules that it loaded."""
    tail = "\nimport json, sys; print(json.dumps(sorted({m.split('.')[0] for m in sys.modules})))"
    run = subprocess.run(
        [sys.executable, "-c", code + tail],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "KOUSOKU_CC": "none"},
    )
    return set(json.loads(run.stdout.splitlines()[-1]))


BLOCK = """
import sys
class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {"sympy", "mpmath", "jinja2", "msgspec", "typer", "rich"}:
            raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Refuse())
"""


def test_generating_the_solver_of_a_scene_needs_no_sympy() -> None:
    """All that is derived is frozen; importing SymPy would be a third of the time it takes."""
    loaded = modules_after(
        "from kousoku.codegen.dynamics.generate import generate_dynamics\n"
        "from kousoku.model.reading.families import chain\n"
        "generate_dynamics(chain(2))"
    )
    assert "mpmath" in loaded
    assert "sympy" not in loaded


def test_import_of_runtime_pulls_in_neither_sympy_nor_jinja2() -> None:
    loaded = modules_after("import kousoku.runtime")
    assert "numpy" in loaded
    assert not loaded & {"sympy", "mpmath", "jinja2", "msgspec", "typer", "rich", "matplotlib"}


def test_runtime_and_generated_work_where_only_numpy_is_installed() -> None:
    code = BLOCK + "import kousoku.runtime\nfrom kousoku.generated.kinds import n1\nn1.constraint"
    assert "numpy" in modules_after(code)


def test_every_template_is_known_as_one() -> None:
    """Editors and the wheel know templates by their suffix."""
    files = [path for path in (ROOT / "codegen" / "templates").rglob("*") if path.is_file()]
    assert files
    assert [path for path in files if path.suffix != ".jinja"] == []


def test_nothing_is_left_behind() -> None:
    for folder in (*HAND_WRITTEN, "tests"):
        for path in sources(folder):
            assert path.stem not in {"utils", "helpers"}, path
            if path != Path(__file__):
                text = path.read_text(encoding="utf-8")
                assert "TODO" not in text and "type: ignore" not in text, path


@pytest.mark.parametrize("page", ["architecture.md", "decisions.md", "pipeline.md"])
def test_every_file_that_a_page_names_is_there(page: str) -> None:
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    named = re.findall(r"`(\w+/[\w/]*\.py)`", text)
    assert named
    assert [name for name in named if not (ROOT / name).is_file()] == []


def named_in_list(package: Path) -> set[str]:
    """Names in double backticks of a package's docstring."""
    text = (package / "__init__.py").read_text(encoding="utf-8")
    return set(re.findall(r"``(\w+)``", ast.get_docstring(ast.parse(text)) or ""))


@pytest.mark.parametrize("folder", WITH_LISTS)
def test_the_list_of_a_package_names_all_of_its_modules(folder: str) -> None:
    package = ROOT / folder
    modules = {path.stem for path in package.iterdir() if path.suffix in {".py", ".toml"}}
    modules |= {path.parent.name for path in package.glob("*/__init__.py")}
    assert named_in_list(package) == modules - {"__init__"}


def test_the_integrator_has_a_list_of_what_is_in_c_and_in_python_and_one_of_the_rest() -> None:
    package = ROOT / "runtime" / "integrate"
    in_c, in_python = ({path.stem for path in package.glob(f"*.{end}")} for end in ("h", "py"))
    both, _, alone = (package / "__init__.py").read_text(encoding="utf-8").partition("Python alone")
    assert {*re.findall(r"``(\w+)``", both)} == in_c & in_python
    assert {*re.findall(r"``(\w+)``", alone)} == in_python - in_c - {"__init__"}


def is_there(name: str, path: Path) -> bool:
    """Whether a file knows a name, or there is a module or a part of one that is called so."""
    tree = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    if name.partition(".")[0] in {getattr(x, "name", getattr(x, "id", None)) for x in tree}:
        return True
    package = ".".join(("kousoku", *path.relative_to(ROOT).parent.parts))
    above = ("", "kousoku.runtime.")  # libraries name each other as in a generated folder
    for full in [f"{package}{name}"] if name[0] == "." else [f"{one}{name}" for one in above]:
        with suppress(ImportError, AttributeError):
            pkgutil.resolve_name(full)
            return True
    return False


@pytest.mark.parametrize("folder", HAND_WRITTEN)
def test_every_name_that_a_docstring_refers_to_is_there(folder: str) -> None:
    for path in sources(folder):
        text = path.read_text(encoding="utf-8")
        named = set(re.findall(r":\w+:`~?([\w.]+)`", text))
        assert [name for name in named if not is_there(name, path)] == [], path


def test_the_list_of_slow_tests_names_tests_that_are_there() -> None:
    names = (ROOT / "tests" / "slow.txt").read_text(encoding="utf-8").split()
    assert names == sorted(names)
    for name in names:
        path, _, function = name.partition("::")
        assert re.search(rf"def {function}\(", (ROOT / path).read_text(encoding="utf-8")), name
