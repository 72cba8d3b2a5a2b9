"""The integrator in C and in NumPy: the same files, functions and thresholds."""

from __future__ import annotations

import ast
import re
from collections import Counter
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[3] / "runtime" / "integrate"
BOTH = sorted(path.stem for path in FOLDER.glob("*.h") if path.with_suffix(".py").exists())
#: Headers without a file of NumPy; ``lacking`` says what a scene lacks, it has no thresholds.
ONLY_C = sorted({path.stem for path in FOLDER.glob("*.h")} - set(BOTH))
#: What NumPy has, or what Python says in the line where it is wanted.
IN_C = {"substitute_back", "multiply_rows", "set_order", "inverse_mass", "sign_of"}
IN_C |= {"are_changed", "largest_residual", "are_finite"}
#: The verdict is put into words by those who have them: programs in C have bits.
IN_WORDS = {"trust_of", "problems_of", "relative_impulse", "below_tolerance", "untold"}
IN_WORDS |= {"missed_by", "released"}
IN_PYTHON = {"inverse_masses", "largest", "smallest", "laws_at", "mean_square", *IN_WORDS}


def functions_in_c(name: str) -> set[str]:
    text = (FOLDER / f"{name}.h").read_text(encoding="utf-8")
    return set(re.findall(r"^static (?:\w+ )+\*?(\w+)\(", text, re.MULTILINE))


def functions_in_python(name: str) -> set[str]:
    tree = ast.parse((FOLDER / f"{name}.py").read_text(encoding="utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def thresholds_in_c(name: str) -> dict[str, float]:
    text = (FOLDER / f"{name}.h").read_text(encoding="utf-8")
    found = re.findall(r"^#define ([A-Z_]+) \(?([^\s()]+)\)?$", text, re.MULTILINE)
    found += re.findall(r"^enum \{ ([A-Z_]+) = (\d+) \};$", text, re.MULTILINE)
    return {key: float(value) for key, value in found}


def thresholds_in_python(name: str) -> dict[str, float]:
    text = (FOLDER / f"{name}.py").read_text(encoding="utf-8")
    found = re.findall(r"^([A-Z_]+) = ([-\d.e]+)$", text, re.MULTILINE)
    return {key: float(value) for key, value in found}


def test_each_part_is_there_in_both_languages() -> None:
    assert set(ONLY_C) == {"integrate", "lacking", "memory", "calls"}
    assert len(BOTH) >= 8


@pytest.mark.parametrize("name", BOTH)
def test_both_have_the_same_functions(name: str) -> None:
    assert functions_in_c(name) - IN_C == functions_in_python(name) - IN_PYTHON


@pytest.mark.parametrize("name", BOTH)
def test_both_have_the_same_thresholds(name: str) -> None:
    assert thresholds_in_c(name) == thresholds_in_python(name)


ALONE = [(name, key) for name in ONLY_C if name != "lacking" for key in thresholds_in_c(name)]


@pytest.mark.parametrize(("name", "threshold"), ALONE)
def test_a_threshold_of_c_alone_stands_in_one_file_of_python(name: str, threshold: str) -> None:
    files = [thresholds_in_python(path.stem) for path in FOLDER.glob("*.py")]
    found = [numbers[threshold] for numbers in files if threshold in numbers]
    assert found == [thresholds_in_c(name)[threshold]]


def test_each_macro_is_defined_in_one_header() -> None:
    defined = Counter[str]()
    for path in FOLDER.parent.rglob("*.h"):
        text = path.read_text(encoding="utf-8")
        defined.update(set(re.findall(r"^ *# *define (\w+)", text, re.MULTILINE)))
    assert defined["EARLY"] == 1
    assert [name for name, files in defined.items() if files > 1] == []


def test_thresholds_of_c_alone_are_found() -> None:
    found = {threshold for _, threshold in ALONE}
    assert found >= {"CLEARLY", "LEAST_TOLERANCE", "NOTHING_MOVES", "NO_TIME", "BENT"}
