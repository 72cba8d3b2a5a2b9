"""The integrator in C and in NumPy: the same files, functions and thresholds."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[3] / "runtime" / "integrate"
BOTH = sorted(path.stem for path in FOLDER.glob("*.h") if path.with_suffix(".py").exists())
#: What NumPy has, or what Python says in the line where it is wanted.
IN_C = {"substitute_back", "multiply_rows", "set_order", "inverse_mass", "sign_of"}
IN_C |= {"are_changed", "largest_residual", "are_finite"}
#: The verdict is put into words by those who have them: programs in C have bits.
IN_WORDS = {"trust_of", "below_tolerance", "untold", "missed_by", "released"}
IN_PYTHON = {"inverse_masses", "largest", "smallest", "laws_at", "mean_square", *IN_WORDS}


def functions_in_c(name: str) -> set[str]:
    text = (FOLDER / f"{name}.h").read_text(encoding="utf-8")
    return set(re.findall(r"^static (?:\w+ )+\*?(\w+)\(", text, re.MULTILINE))


def functions_in_python(name: str) -> set[str]:
    tree = ast.parse((FOLDER / f"{name}.py").read_text(encoding="utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_each_part_is_there_in_both_languages() -> None:
    only_c = {path.stem for path in FOLDER.glob("*.h")} - set(BOTH)
    assert only_c == {"integrate", "lacking", "memory", "calls"}
    assert len(BOTH) >= 8


@pytest.mark.parametrize("name", BOTH)
def test_both_have_the_same_functions(name: str) -> None:
    assert functions_in_c(name) - IN_C == functions_in_python(name) - IN_PYTHON


@pytest.mark.parametrize("name", BOTH)
def test_both_have_the_same_thresholds(name: str) -> None:
    text = (FOLDER / f"{name}.h").read_text(encoding="utf-8")
    in_c = dict(re.findall(r"^#define ([A-Z_]+) \(?([^\s()]+)\)?$", text, re.MULTILINE))
    in_c |= dict(re.findall(r"^enum \{ ([A-Z_]+) = (\d+) \};$", text, re.MULTILINE))
    text = (FOLDER / f"{name}.py").read_text(encoding="utf-8")
    in_python = dict(re.findall(r"^([A-Z_]+) = ([-\d.e]+)$", text, re.MULTILINE))
    assert {key: float(x) for key, x in in_c.items()} == {
        key: float(x) for key, x in in_python.items()
    }
