"""Turn a tree of tables into the records of a scene, with messages for people."""

from __future__ import annotations

import datetime
import difflib
import json
import re
from collections.abc import Mapping
from functools import cache
from math import inf
from types import UnionType
from typing import Any, Literal, TypeVar, Union, cast, get_args, get_origin

import msgspec

from kousoku.model.errors import SceneError

S = TypeVar("S", bound=msgspec.Struct)

LARGEST = 1e50
"""Numbers beyond it are refused: their products would leave the range of doubles."""

MOST_ELEMENTS = 20_000
"""Bodies, joints … of the largest scene; larger tables are refused before they are read."""


def decode(tree: object, record: type[S], *, key: str = "") -> S:
    """Build a record from a table.

    Parameters
    ----------
    tree : object
        What a TOML parser gave; anything else is refused.
    record : type
        The record to build, whose fields may be records, mappings of them and tuples of them.
    key : str
        Where the table stands, for messages.

    Raises
    ------
    SceneError
        A key is unknown or missing, or a value is not of the type that is wanted.
    """
    if not isinstance(tree, Mapping):
        raise SceneError(f"{_got(tree)} stands where a table is wanted", key=key)
    fields = _fields(record)
    for name in tree:
        if name not in fields:
            problem = unknown("key", str(name), tuple(fields))
            raise SceneError(problem, key=_join(key, str(name)))
    values: dict[str, Any] = {}
    for name, field in fields.items():
        place = _join(key, name)
        if name in tree:
            values[field.name] = _value(tree[name], field.type, place)
        elif field.required:
            raise SceneError(f"is missing; wanted {_wanted(field.type)}", key=place)
    return record(**values)


@cache
def _fields(record: type[msgspec.Struct]) -> dict[str, Any]:
    """Return the fields of a record by their names in a file."""
    return {field.encode_name: field for field in msgspec.structs.fields(record)}


def unknown(what: str, name: str, known: tuple[str, ...]) -> str:
    """Return the message for a name that is not among `known`, with the nearest one."""
    near = difflib.get_close_matches(name[:80], known, n=1)
    if near:
        return f"unknown {what}; did you mean {near[0]!r}?"
    listed = ", ".join(known[:12]) + (", …" if len(known) > 12 else "")
    return f"unknown {what}; known here: {listed or 'none'}"


def _value(value: object, kind: Any, key: str) -> object:
    kind = _without_none(kind)
    origin, arguments = get_origin(kind), get_args(kind)
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        return decode(value, kind, key=key)
    if origin is Mapping:
        if not isinstance(value, Mapping):
            raise SceneError(f"{_got(value)} stands where a table is wanted", key=key)
        if len(value) > MOST_ELEMENTS:
            raise SceneError(f"has {len(value)} elements; the limit is {MOST_ELEMENTS}", key=key)
        return {
            str(name): _value(item, arguments[1], _join(key, str(name)))
            for name, item in value.items()
        }
    if origin is tuple:
        return _tuple(value, kind, key)
    if isinstance(value, int | float) and not abs(value) <= LARGEST:
        problem = "is too large" if abs(value) < inf else "is not a finite number"
        shown = _got(value).removeprefix("the number ")
        raise SceneError(f"{shown} {problem}; wanted at most {LARGEST:g}", key=key)
    try:
        leaf: object = msgspec.convert(value, kind)
    except msgspec.ValidationError:
        raise SceneError(_refusal(value, kind), key=key) from None
    return leaf


def _tuple(value: object, kind: Any, key: str) -> tuple[object, ...]:
    kinds = get_args(kind)
    is_open = len(kinds) == 2 and kinds[1] is Ellipsis
    if not isinstance(value, list | tuple) or not (is_open or len(value) == len(kinds)):
        raise SceneError(_refusal(value, kind), key=key)
    if is_open:
        kinds = kinds[:1] * len(value)
    pairs = zip(value, kinds, strict=True)
    return tuple(_value(item, of, f"{key}[{i}]") for i, (item, of) in enumerate(pairs))


def _join(key: str, name: str) -> str:
    shown = name if len(name) <= 40 else name[:40] + "…"
    if not re.fullmatch("[A-Za-z0-9_-]+…?", shown):
        shown = json.dumps(shown, ensure_ascii=not shown.isprintable())
    return f"{key}.{shown}" if key else shown


def _without_none(kind: Any) -> Any:
    if get_origin(kind) in (Union, UnionType):
        return next(of for of in get_args(kind) if of is not type(None))
    return kind


def _refusal(value: object, kind: Any) -> str:
    problem = f"{_got(value)} stands where {_wanted(kind)} is wanted"
    if isinstance(value, str) and kind in (int, float):
        problem += "; formulas are not evaluated in a scene, write the number itself"
    return problem


def _wanted(kind: Any) -> str:
    kind = _without_none(kind)
    simple = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}
    if kind in simple:
        return simple[kind]
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Literal:
        return "one of " + ", ".join(repr(choice) for choice in arguments)
    if origin is tuple and arguments[-1] is Ellipsis:
        return "a list"
    if origin is tuple:
        what = {float: "numbers", str: "names"}.get(arguments[0], "lists")
        return f"a list of {len(arguments)} {what}"
    return "a table"


def _got(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f"the text {value[:40] + ('…' if len(value) > 40 else '')!r}"
    if isinstance(value, int) and abs(value) >= 10**20:
        return "a whole number of more than 20 digits"
    if isinstance(value, int | float):
        return f"the number {value!r}"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}"
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, datetime.date | datetime.time):
        return "a date or time"
    return f"a value of type {cast(type, type(value)).__name__}"
