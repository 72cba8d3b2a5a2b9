"""Names become columns, symbols and folders, so that only harmless ones are taken."""

from __future__ import annotations

import keyword
import re

import pytest

from kousoku.model.validation.names import LONGEST_NAME, PATTERN, name_problem, scene_name_problem


@pytest.mark.parametrize("name", ["O1", "A", "crank_pin", "l1", "alpha", "x2y", "gamma", "a_1_b"])
def test_textbook_names_are_taken(name: str) -> None:
    assert name_problem(name) is None
    assert re.search(PATTERN, name)


@pytest.mark.parametrize(
    "name",
    ["", "1a", "a b", "a-b", "a.b", "a/b", "..", "_a", "a__b", "ａ", "α", "a\n", "a\0", "$(id)"],
)
def test_what_is_no_identifier_of_python_and_c_is_refused(name: str) -> None:
    assert "is not a name" in (name_problem(name) or "")
    assert not re.search(PATTERN, name) or name.endswith("\n")


@pytest.mark.parametrize("name", keyword.kwlist)
def test_python_keywords_are_refused(name: str) -> None:
    assert "Python keyword" in (name_problem(name) or "")


@pytest.mark.parametrize(
    "name", ["int", "double", "restrict", "switch", "struct", "namespace", "template", "bool"]
)
def test_keywords_of_c_and_of_c_plus_plus_are_refused(name: str) -> None:
    assert "C or C++ keyword" in (name_problem(name) or "")


@pytest.mark.parametrize("name", ["sin", "sqrt", "NAN", "errno", "printf", "main", "memcpy"])
def test_names_of_the_c_library_are_refused(name: str) -> None:
    assert "C library" in (name_problem(name) or "")


def test_names_are_as_long_as_c_promises_to_tell_apart() -> None:
    assert name_problem("a" * LONGEST_NAME) is None
    problem = name_problem("a" * 10**6) or ""
    assert "1000000 characters" in problem
    assert len(problem) < 200


@pytest.mark.parametrize("name", ["typing", "queue", "math"])
def test_scene_cannot_hide_a_module_of_python(name: str) -> None:
    """Its folder would be found first by whoever starts Python beside it."""
    assert "is a module of Python" in (scene_name_problem(name) or "")
    assert name_problem(name) is None


@pytest.mark.parametrize("name", ["kinds", "numpy", "con", "NUL", "com1"])
def test_a_scene_is_not_named_as_a_folder_that_cannot_be(name: str) -> None:
    assert name_problem(name) is None
    assert "folder" in (scene_name_problem(name) or "")
