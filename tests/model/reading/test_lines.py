"""The line of each key, for documents that are written in every way that TOML allows."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kousoku.model.reading.lines import KeyPath as Keys
from kousoku.model.reading.lines import deep_key_line, each_key_line

ROOT = Path(__file__).parents[3]
SCENES = [*sorted((ROOT / "scenes").glob("*.toml")), *(ROOT / "tests/scenes").rglob("*.toml")]


def key_lines(text: str) -> dict[Keys, int]:
    """Line in which each key and each element of a list stands for the first time."""
    lines: dict[Keys, int] = {}
    for path, line in each_key_line(text):
        lines.setdefault(path, line)
    return lines


def test_keys_of_every_kind_are_found() -> None:
    text = (
        "# first\n"
        'title = """\n'
        'a = 1 \\"""\n'
        '[no.table]"""\n'
        "[nodes] # comment ]\n"
        "O1 = { at = [0, 0], 'x.y'.z = 1 }\n"
        '"O 2".at = [\n'
        "  1, # [\n"
        "  2,\n"
        "]\n"
        "\n"
        "[ links . l1 ]\n"
        "length = 1.0\n"
        "[[points]]\n"
        "mass = 1\n"
        "[points.at]\n"
        "x = 1\n"
        "[[points]]\n"
        "mass = 1979-05-27 07:32:00\n"
    )
    tomllib.loads(text)
    lines = key_lines(text)
    assert lines["title",] == 2
    assert lines["nodes",] == 5
    assert lines["nodes", "O1", "at", 1] == 6
    assert lines["nodes", "O1", "x.y", "z"] == 6
    assert lines["nodes", "O 2", "at"] == 7
    assert lines["nodes", "O 2", "at", 0] == 8
    assert lines["nodes", "O 2", "at", 1] == 9
    assert lines["links", "l1"] == 12
    assert lines["links", "l1", "length"] == 13
    assert lines["points",] == lines["points", 0] == 14
    assert lines["points", 0, "at", "x"] == 17
    assert lines["points", 1] == 18
    assert lines["points", 1, "mass"] == 19
    assert ("no",) not in lines


def test_quotes_at_the_end_of_a_long_text_belong_to_it() -> None:
    for mark in ('"', "'"):
        for count in (0, 1, 2):
            text = f"a = {mark * 3}\nx{mark * (3 + count)}\nb = 1"
            assert tomllib.loads(text)["a"] == "x" + mark * count
            assert key_lines(text) == {("a",): 1, ("b",): 3}


def paths(value: object, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    """Paths to all values in a tree, and to all tables and lists."""
    items: Any = ()
    if isinstance(value, dict):
        items = value.items()
    elif isinstance(value, list):
        items = enumerate(value)
    found = [path] if path else []
    for key, inner in items:
        found += paths(inner, (*path, key))
    return found


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_all_keys_of_a_scene_stand_where_they_are_said_to(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    try:
        tree = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return
    lines = key_lines(text)
    assert sorted(lines, key=str) == sorted(paths(tree), key=str)
    written = text.splitlines()
    for place, line in lines.items():
        if isinstance(place[-1], str):
            assert place[-1] in written[line - 1]


KEYS = st.text("ab-_1", min_size=1, max_size=3) | st.text("a.'\"\\ \n#=[é", max_size=3)
TEXTS = st.text("ab'\"\\\n#=[]{},", max_size=8)
PLAIN = st.integers() | st.booleans() | st.floats(allow_nan=False) | TEXTS | st.dates()
VALUES = st.recursive(
    PLAIN,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=3),
    max_leaves=6,
)
TABLES = st.recursive(
    st.dictionaries(KEYS, VALUES, max_size=3),
    lambda inner: st.dictionaries(
        KEYS, inner | VALUES | st.lists(inner, min_size=1, max_size=3), max_size=3
    ),
    max_leaves=5,
)


class Writer:
    """Write a tree as TOML in a way that is drawn, and note where each key went."""

    def __init__(self, data: st.DataObject) -> None:
        self.data = data
        self.text = ""
        self.lines: dict[tuple[str | int, ...], int] = {}

    def note(self, path: tuple[str | int, ...]) -> None:
        self.lines.setdefault(path, self.text.count("\n") + 1)

    def one_of(self, *choices: str) -> str:
        return self.data.draw(st.sampled_from(choices))

    def key(self, key: str) -> str:
        forms = [json.dumps(key)]
        if key and all(mark in "ab-_1" for mark in key):
            forms.append(key)
        if not set(key) & set("'\n"):
            forms.append(f"'{key}'")
        space = self.one_of("", " ", "\t")
        return space + self.one_of(*forms) + space

    def string(self, text: str) -> str:
        forms = [json.dumps(text), '"""' + json.dumps(text)[1:-1] + '"""']
        forms.append('"""\n' + json.dumps(text)[1:-1].replace("\\n", "\n") + '"""')
        if not set(text) & set("'\n"):
            forms.append(f"'{text}'")
        if "'" not in text:
            forms.append(f"'''\n{text}'''")
        return self.one_of(*forms)

    def value(self, value: object, path: tuple[str | int, ...]) -> None:
        if isinstance(value, str):
            self.text += self.string(value)
        elif isinstance(value, bool):
            self.text += str(value).lower()
        elif isinstance(value, list):
            self.text += "["
            for index, item in enumerate(value):
                self.text += self.one_of("", " ", "\n", "# ]\n\n ")
                self.note((*path, index))
                self.value(item, (*path, index))
                self.text += self.one_of(",", " ,", "\n,", "#,\n,")
            self.text += self.one_of("]", "\n]")
        elif isinstance(value, dict):
            self.text += "{"
            for index, (key, item) in enumerate(value.items()):
                self.text += ", " if index else ""
                self.pair(key, item, path)
            self.text += " }"
        else:
            self.text += str(value)

    def pair(self, key: str, item: object, path: tuple[str | int, ...]) -> None:
        self.note((*path, key))
        self.text += self.key(key)
        path = (*path, key)
        while isinstance(item, dict) and len(item) == 1 and self.data.draw(st.booleans()):
            ((key, item),) = item.items()
            path = (*path, key)
            self.note(path)
            self.text += "." + self.key(key)
        self.text += "=" + self.one_of("", " ")
        self.value(item, path)

    def header(self, keys: list[str], path: tuple[str | int, ...], *, is_list: bool) -> None:
        for depth in range(1, len(path) + 1):
            self.note(path[:depth])
        left, right = ("[[", "]]") if is_list else ("[", "]")
        self.text += left + ".".join(map(self.key, keys)) + right + self.one_of("\n", " # [x]\n")

    def table(self, table: dict[str, Any], keys: list[str], path: tuple[str | int, ...]) -> None:
        apart = []
        for key, item in table.items():
            has_header = isinstance(item, dict) or (
                isinstance(item, list) and item and all(isinstance(x, dict) for x in item)
            )
            if has_header and self.data.draw(st.booleans()):
                apart.append((key, item))
                continue
            self.text += self.one_of("", "\n", "# a = 1\n")
            self.pair(key, item, path)
            self.text += self.one_of("\n", " \n", "# b\n")
        for key, item in apart:
            if isinstance(item, dict):
                self.header([*keys, key], (*path, key), is_list=False)
                self.table(item, [*keys, key], (*path, key))
                continue
            for index, element in enumerate(item):
                self.header([*keys, key], (*path, key, index), is_list=True)
                self.table(element, [*keys, key], (*path, key, index))


@settings(max_examples=150, deadline=None)
@given(TABLES, st.data())
def test_any_document_has_its_keys_where_they_were_written(
    tree: dict[str, Any], data: st.DataObject
) -> None:
    writer = Writer(data)
    writer.table(tree, [], ())
    assert tomllib.loads(writer.text) == tree
    assert key_lines(writer.text) == writer.lines


def test_lists_may_be_nested_deeper_than_calls_of_functions() -> None:
    assert len(key_lines("a = " + "[" * 3000 + "]" * 3000)) == 3000


def test_line_ends_of_every_system_count_as_one() -> None:
    assert key_lines("a = 1\r\nb = 2\r\n")["b",] == 2


@pytest.mark.parametrize(
    "key",
    [
        ".".join("a" * 50),
        " . ".join(["a-b_1"] * 50),
        ".".join(['"a \\" b"'] * 50),
        "[" + ".".join(["'a.'"] * 50) + "]",
    ],
)
def test_a_key_of_many_parts_is_found_before_a_parser_meets_it(key: str) -> None:
    assert deep_key_line(f"x = 1\n{key} = 1\n", 32) == 2
    assert deep_key_line(f"x = 1\n{key} = 1\n", 50) == 0


@pytest.mark.parametrize(
    "line", [f"x = [{'1.5, ' * 99}]", f'x = "{"a." * 99}"', "# " + "... " * 99]
)
def test_dots_that_join_no_keys_are_no_long_key(line: str) -> None:
    assert deep_key_line(line, 32) == 0
