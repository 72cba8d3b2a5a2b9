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
    fields = _changed_fields(scene)
    keys = {key: value for key, value in fields.items() if key not in (*TABLES, "method")}
    tables = {table: getattr(scene, table) for table in TABLES}
    tables["method"] = _changed_fields(scene.method)
    return toml_of(keys | {table: elements for table, elements in tables.items() if elements})


def toml_of(tree: Mapping[str, object]) -> str:
    """Text of a file that reads back as a tree: one line an element of each table."""
    tables = {key: value for key, value in tree.items() if isinstance(value, Mapping)}
    keys = {key: value for key, value in tree.items() if key not in tables}
    blocks = [f"[{_key(key)}]\n{_lines(value)}" for key, value in tables.items()]
    return "\n".join([_lines(keys), *blocks])


def _lines(table: Mapping[str, object]) -> str:
    return "".join(f"{_key(key)} = {_value(value)}\n" for key, value in table.items())


def _changed_fields(record: msgspec.Struct) -> dict[str, object]:
    """Fields that differ from their defaults, by their names in a file."""
    fields = {
        field.encode_name: getattr(record, field.name)
        for field in msgspec.structs.fields(record)
        if field.required or getattr(record, field.name) not in (field.default, {})
    }
    flat = fields.pop(getattr(record, "FLAT", ""), None)
    return fields | flat if isinstance(flat, dict) else fields


def _key(key: str) -> str:
    return key if BARE.fullmatch(key) else _quoted(key)


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: object) -> str:
    if isinstance(value, msgspec.Struct):
        value = _changed_fields(value)
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
