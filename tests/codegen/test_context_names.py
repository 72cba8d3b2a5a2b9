"""Names: the formula's own, wherever the languages let them stand."""

import keyword

import pytest

from kousoku.codegen.context_names import RESERVED, Namer, identifier
from kousoku.model.errors import EmitError


@pytest.mark.parametrize("name", ["gamma", "y0", "int", "lambda", "class", "double", "out", "NULL"])
def test_reserved_names_get_an_underscore(name: str) -> None:
    assert Namer().take(name) == f"{name}_"


def test_a_name_that_is_taken_gets_another_underscore() -> None:
    namer = Namer()
    assert [namer.take(name) for name in ("a", "a", "gamma", "gamma_")] == [
        "a",
        "a_",
        "gamma_",
        "gamma__",
    ]


def test_temporaries_pass_over_names_that_arguments_have() -> None:
    namer = Namer()
    namer.keep("t1")
    assert [namer.temporary() for _ in range(3)] == ["t0", "t2", "t3"]


def test_no_keyword_of_python_is_forgotten() -> None:
    assert set(keyword.kwlist) <= RESERVED


@pytest.mark.parametrize("name", ["r_i", "A11", "x"])
def test_identifiers_pass(name: str) -> None:
    assert identifier(name, "name") == name


@pytest.mark.parametrize("name", ["", "1a", "a b", "δr", "_x", "a;b", "a\n"])
def test_anything_else_is_refused(name: str) -> None:
    with pytest.raises(EmitError, match="cannot be emitted"):
        identifier(name, "name")
