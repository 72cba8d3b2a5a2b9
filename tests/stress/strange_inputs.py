"""What strangers write: formulas of a grammar, values of any sort, scenes that are nearly right."""

from __future__ import annotations

import copy
import datetime
import json
import math
import random
import tomllib
from functools import cache
from typing import TYPE_CHECKING, Any

import msgspec
from hypothesis import strategies as st

from kousoku.model.reading.read import scene_from_dict
from kousoku.model.reading.write import to_toml, toml_of
from tests.random_scenes import random_scene
from tests.stress.kit import ROOT

if TYPE_CHECKING:
    from collections.abc import Callable

    from hypothesis.strategies import DrawFn, SearchStrategy

    Tree = dict[str, Any]

PWNED = "__import__('os').system('touch pwned')"

NAMES = (
    *("a", "b", "t", "x", "ground", "q", "pi", "deg", "sin", "self", "np", "kousoku", "main"),
    *("__class__", "__import__", "_", "a_", "a__b", "A", "int", "register", "y0", "EOF", "errno"),
    *("lambda", "None", "True", "match", "type", "print", "open", "name", "time", "con", "nul"),
    *(
        "../x",
        "/etc/passwd",
        "a/b",
        "a.b",
        "a b",
        "a-b",
        "",
        ".",
        "..",
        "\0",
        "a\nb",
        "ä",
        "x" * 31,
    ),
    *(
        "x" * 32,
        "x" * 10_000,
        "%s%n",
        "{{7*7}}",
        "*/",
        "//",
        '"',
        "'",
        "\\",
        "`",
        "\u202e",
        "\ud800",
    ),
    *(
        "DIGEST",
        "NAN",
        "INFINITY",
        "I",
        "M_PI",
        "_Bool",
        "state",
        "rows",
        "values",
        "steps",
        "work",
    ),
)
"""Names that mean something to Python, C, a file system, a template, or a terminal."""

FUNCTIONS = (
    "sin",
    "cos",
    "sqrt",
    "exp",
    "log",
    "abs",
    "min",
    "max",
    "atan2",
    "sign",
    "tan",
    "tanh",
)
NUMBERS = (
    *("0", "1", "2.5", "-1", "1e-3", "1e50", "1e99", "1e400", "1e-400", "1e999999999", "9" * 50),
    *(
        "0.1.2",
        "1e",
        ".",
        "1.",
        ".5",
        "0x10",
        "1_000",
        "1j",
        "inf",
        "nan",
        "30 deg",
        "٣",
        "１",
        "1e+",
    ),
)
WORDS = ("t", "t", "k", "k", "pi", "deg", "x", "v", "t.real", "k.__class__", "().__class__", *NAMES)
MARKS = ("+", "-", "*", "/", "^", "**", "//", "%", "@", "<", "==", ":=", ";", ",", "&", "|", " if ")
ATTACKS = (
    PWNED,
    "eval('1')",
    "exec('import os')",
    "open('pwned', 'w')",
    "t.__class__.__mro__[1].__subclasses__()",
    "(lambda: 1)()",
    "[c for c in ().__class__.__bases__]",
    "f'{1}'",
    "9^9^9^9^9",
    "2^(2^(2^(2^(2^60))))",
    "1e50^99",
    "sqrt(-1)",
    "log(0)",
    "1/(t - t)",
    "0^0",
    "k^t^k^t",
    "1 # comment",
    "1 /* comment */",
    "1; system(0)",
    "t\\\n",
)


def formulas() -> SearchStrategy[str]:
    """Formulas: right ones, nearly right ones, deep ones, and what is none."""
    atoms = st.sampled_from([*NUMBERS[:5], *WORDS[:5]]) | st.sampled_from([*NUMBERS, *WORDS])
    marks = st.sampled_from(MARKS[:5]) | st.sampled_from(MARKS)

    def larger(inner: SearchStrategy[str]) -> SearchStrategy[str]:
        call = st.sampled_from(FUNCTIONS) | st.sampled_from(NAMES)
        return (
            st.tuples(inner, marks, inner).map("".join)
            | inner.map("({})".format)
            | inner.map("-{}".format)
            | st.tuples(call, st.lists(inner, max_size=3).map(", ".join)).map(
                lambda two: f"{two[0]}({two[1]})"
            )
        )

    grammar = st.recursive(atoms, larger, max_leaves=12)
    deep = st.tuples(
        st.sampled_from(["(", "-", "sin(", "1+(", "t^", "min(t,", "abs(", "2*("]),
        st.integers(1, 3000),
        st.sampled_from(["t", "1", ""]),
    ).map(lambda of: of[0] * of[1] + of[2] + (")" * of[1] if "(" in of[0] else ""))
    wide = st.tuples(st.sampled_from(["t+", "k*", "t/", "t^"]), st.integers(1, 900)).map(
        lambda of: of[0] * of[1] + "1"
    )
    edited = st.tuples(grammar, st.integers(0, 60), st.text(max_size=2)).map(
        lambda of: of[0][: of[1]] + of[2] + of[0][of[1] + 1 :]
    )
    return grammar | edited | deep | wide | st.sampled_from(ATTACKS) | st.text(max_size=30)


def values() -> SearchStrategy[Any]:
    """Values of all types, most of them where they do not belong."""
    leaves = (
        st.sampled_from([0, 1, -1, 0.5, 1e-3, True, "t", "k", "", [0, 0, 1], []])
        | st.sampled_from(
            [math.nan, math.inf, -math.inf, 1e308, 5e-324, -0.0, 1e49, 1e50, 1e51, 2**63, 10**400]
        )
        | st.sampled_from([*NAMES, *ATTACKS])
        | st.sampled_from(["x" * 100_000, "\n" * 1000, datetime.date(2000, 1, 1), None, 10**25])
        | st.floats()
        | st.integers()
        | formulas()
        | st.lists(st.floats(-10, 10), min_size=3, max_size=3)
    )
    deep = st.integers(2, 200).map(_nested)
    return (
        st.recursive(
            leaves,
            lambda inner: (
                st.lists(inner, max_size=4)
                | st.dictionaries(st.sampled_from(NAMES), inner, max_size=3)
            ),
            max_leaves=6,
        )
        | deep
    )


def _nested(depth: int) -> Any:
    value: Any = 1
    for k in range(depth):
        value = [value] if k % 2 else {"a": value}
    return value


@cache
def trees() -> list[Tree]:
    """Right scenes: those that are committed, small ones first, and random ones."""
    paths = [
        path
        for folder in ("scenes", "scenes/adams", "tests/scenes", "tests/scenes/design")
        for path in sorted((ROOT / folder).glob("*.toml"))
    ]
    texts = [path.read_text(encoding="utf-8") for path in paths]
    texts += [to_toml(scene_from_dict(random_scene(random.Random(k), k))) for k in range(0, 50, 3)]
    return [tomllib.loads(text) for text in sorted(texts, key=len)]


def places(tree: object, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths to all values of a tree."""
    pairs = (
        tree.items()
        if isinstance(tree, dict)
        else enumerate(tree)
        if isinstance(tree, list)
        else ()
    )
    inner = [place for key, value in pairs for place in places(value, (*path, key))]
    return [path, *inner] if path else inner


@st.composite
def edited_trees(draw: DrawFn) -> Tree:
    """Right scene with some values, keys or tables that are others."""
    tree = copy.deepcopy(draw(st.sampled_from(trees())))
    for _ in range(draw(st.integers(1, 3))):
        every = places(tree)
        if not every:
            break
        *path, last = draw(st.sampled_from(every))
        table: Any = tree
        for key in path:
            table = table[key]
        draw(st.sampled_from(EDITS))(draw, table, last, tree)
    return tree


def _another_value(draw: DrawFn, table: Any, last: Any, tree: Tree) -> None:
    table[last] = draw(values())


def _no_value(draw: DrawFn, table: Any, last: Any, tree: Tree) -> None:
    del table[last]


def _another_name(draw: DrawFn, table: Any, last: Any, tree: Tree) -> None:
    if isinstance(table, dict):
        table[draw(st.sampled_from(NAMES))] = table.pop(last)


def _twice(draw: DrawFn, table: Any, last: Any, tree: Tree) -> None:
    if isinstance(table, dict):
        table[draw(st.sampled_from(NAMES))] = copy.deepcopy(table[last])
    else:
        table.append(copy.deepcopy(table[last]))


def _from_elsewhere(draw: DrawFn, table: Any, last: Any, tree: Tree) -> None:
    value: Any = draw(st.sampled_from(trees()))
    *path, key = draw(st.sampled_from(places(value)))
    for part in path:
        value = value[part]
    table[last] = copy.deepcopy(value[key])


def _formula(draw: DrawFn, table: Any, last: Any, tree: Tree) -> None:
    table[last] = draw(formulas())
    if draw(st.booleans()):
        tree["parameters"] = {"k": draw(values())}


EDITS: tuple[Callable[[DrawFn, Any, Any, Tree], None], ...] = (
    _another_value,
    _no_value,
    _another_name,
    _twice,
    _from_elsewhere,
    _formula,
)


@st.composite
def edited_texts(draw: DrawFn) -> str:
    """Text of a right scene with some marks that are others, or of an edited tree."""
    if draw(st.booleans()):
        return written(draw(edited_trees()))
    text = written(draw(st.sampled_from(trees())))
    for _ in range(draw(st.integers(1, 3))):
        start = draw(st.integers(0, len(text)))
        size = draw(st.integers(0, 8))
        put = draw(
            st.text(max_size=4)
            | st.sampled_from(
                ["nan", "[[", "]]", '"""', "=", "\0", "\r", "#", "[a.b.c]\n", "{", "}"]
            )
            | st.sampled_from(["[" * 3000, "{a=" * 3000, "a." * 3000 + "b=1\n", "\ufeff", "inf"])
            | formulas()
        )
        text = text[:start] + put + text[start + size :]
    return text


def written(tree: Tree) -> str:
    """Tree as TOML, whatever it holds, and text for what TOML has not."""
    return toml_of(_as_toml_has_it(tree))


def _as_toml_has_it(value: Any) -> Any:
    if isinstance(value, dict):
        return {_as_toml_has_it(str(k)): _as_toml_has_it(x) for k, x in value.items()}
    if isinstance(value, list | tuple):
        return [*map(_as_toml_has_it, value)]
    if isinstance(value, str):  # a half of a pair is no character
        return value.encode("utf-8", "replace").decode()
    return "none" if value is None else value


#: Small scenes with a place for a formula, by what it may depend on.
WITH_FORMULA = {
    "force of time": {
        "bodies": {"b": {"point": True, "position": [1, 2, 3], "mass": 1}},
        "parameters": {"k": 2.0},
        "forces": {"f": {"type": "force", "body": "b", "force": ["FORMULA", 0, 0]}},
    },
    "number of the design": {
        "bodies": {"b": {"point": True, "position": [1, 2, 3], "mass": "FORMULA"}},
        "parameters": {"k": 2.0},
    },
    "force along a coordinate": {
        "bodies": {"b": {"point": True, "position": [0, 0, 1], "mass": 1}},
        "coordinates": {"x": {"body": "b", "along": [0, 0, 1]}},
        "parameters": {"k": 2.0},
        "forces": {"f": {"type": "along", "coordinate": "x", "force": "FORMULA"}},
    },
    "driver": {
        "bodies": {"b": {"point": True, "position": [0, 0, 1], "mass": 1}},
        "coordinates": {"x": {"body": "b", "along": [0, 0, 1]}},
        "parameters": {"k": 2.0},
        "drivers": {"d": {"coordinate": "x", "value": "FORMULA"}},
    },
    "event": {
        "bodies": {"b": {"point": True, "position": [0, 0, 1], "mass": 1}},
        "coordinates": {"x": {"body": "b", "along": [0, 0, 1]}},
        "parameters": {"k": 2.0},
        "events": {"e": {"when": "FORMULA", "action": "stop"}},
    },
    "tension": {
        "bodies": {"b": {"point": True, "position": [1, 0, 1], "mass": 1}},
        "parameters": {"k": 2.0},
        "forces": {
            "f": {
                "type": "spring_damper",
                "bodies": ["ground", "b"],
                "points": [[0, 0, 0], [0, 0, 0]],
                "tension": "FORMULA",
            }
        },
    },
}


def with_formula(place: str, formula: str) -> tuple[Tree, str]:
    """Scene that has a formula in a place, and the element that this is in."""
    text = msgspec.json.encode({"name": "with_formula", "unit": "m"} | WITH_FORMULA[place]).decode()

    elements: list[str] = []

    def put(value: Any, path: str = "") -> Any:
        if isinstance(value, dict):
            return {key: put(one, f"{path}.{key}") for key, one in value.items()}
        if isinstance(value, list):
            return [put(one, path) for one in value]
        if value != "FORMULA":
            return value
        elements.append(".".join(path.split(".")[1:3]))
        return formula

    tree: Tree = put(json.loads(text))
    return tree, elements[0]
