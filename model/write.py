"""Write scenes as TOML, so that what was built in Python can be kept in a file."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import msgspec

from kousoku.model.angles import Angle
from kousoku.model.design import Formula
from kousoku.model.scene import TABLES, Scene

if TYPE_CHECKING:
    from collections.abc import Mapping


def to_toml(scene: Scene) -> str:
    """Return the text of a scene file that reads back as the same scene.

    Defaults are left out, numbers have all their digits, and elements keep their order.
    """
    parts = [_entries(scene, leave_out=(*TABLES, "method"))]
    for table in TABLES:
        elements: Mapping[str, msgspec.Struct] = getattr(scene, table)
        if elements:
            lines = [f"{name} = {_value(element)}\n" for name, element in elements.items()]
            parts.append(f"[{table}]\n{''.join(lines)}")
    if method := _entries(scene.method):
        parts.append(f"[method]\n{method}")
    return "\n".join(parts)


def _given(record: msgspec.Struct) -> dict[str, object]:
    """Return the fields that differ from their defaults, by their names in a file."""
    return {
        field.encode_name: getattr(record, field.name)
        for field in msgspec.structs.fields(record)
        if field.required or getattr(record, field.name) != field.default
    }


def _entries(record: msgspec.Struct, leave_out: tuple[str, ...] = ()) -> str:
    given = _given(record).items()
    return "".join(f"{key} = {_value(value)}\n" for key, value in given if key not in leave_out)


def _value(value: object) -> str:
    if isinstance(value, msgspec.Struct):
        inner = ", ".join(f"{key} = {_value(item)}" for key, item in _given(value).items())
        return f"{{ {inner} }}"
    if isinstance(value, tuple):
        return f"[{', '.join(_value(item) for item in value)}]"
    if isinstance(value, Formula | Angle):
        return json.dumps(value.text, ensure_ascii=False)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return repr(value)
