"""Write scenes as TOML, so that what was built in Python can be kept in a file."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping

import msgspec

from kousoku.model.angles import Angle
from kousoku.model.records.design import Formula
from kousoku.model.records.scene import TABLES, Scene

BARE = re.compile(r"[A-Za-z0-9_-]+")
"""Keys that TOML takes without quotes."""


def to_toml(scene: Scene) -> str:
    """Text of a scene file that reads back as the same scene.

    Defaults are left out, numbers have all their digits, and elements keep their order.
    """
    given = _given(scene)
    own = {key: value for key, value in given.items() if key not in (*TABLES, "method")}
    tables = {table: getattr(scene, table) for table in TABLES} | {"method": _given(scene.method)}
    return toml_of(own | {table: one for table, one in tables.items() if one})


def toml_of(tree: Mapping[str, object]) -> str:
    """Text of a file that reads back as a tree: one line an element of each table."""
    tables = {key: value for key, value in tree.items() if isinstance(value, Mapping)}
    own = {key: value for key, value in tree.items() if key not in tables}
    parts = [f"[{_key(key)}]\n{_lines(value)}" for key, value in tables.items()]
    return "\n".join([_lines(own), *parts])


def _lines(table: Mapping[str, object]) -> str:
    return "".join(f"{_key(key)} = {_value(value)}\n" for key, value in table.items())


def _given(record: msgspec.Struct) -> dict[str, object]:
    """Fields that differ from their defaults, by their names in a file."""
    found = {
        field.encode_name: getattr(record, field.name)
        for field in msgspec.structs.fields(record)
        if field.required or getattr(record, field.name) not in (field.default, {})
    }
    flat = found.pop(getattr(record, "FLAT", ""), None)
    return found | flat if isinstance(flat, dict) else found


def _key(key: str) -> str:
    return key if BARE.fullmatch(key) else _quoted(key)


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: object) -> str:
    if isinstance(value, msgspec.Struct):
        value = _given(value)
    if isinstance(value, Mapping):
        inner = ", ".join(f"{_key(key)} = {_value(item)}" for key, item in value.items())
        return f"{{ {inner} }}"
    if isinstance(value, tuple | list):
        return f"[{', '.join(_value(item) for item in value)}]"
    if isinstance(value, Formula | Angle):
        return _quoted(value.text)
    if isinstance(value, bool):
        return "true" if value else "false"
    return _quoted(value) if isinstance(value, str) else str(value)
