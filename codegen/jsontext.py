"""JSON that a reader can follow and a diff can show: short things on a line, long lists wrapped."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable

WIDTH = 100


def to_text(value: object) -> str:
    """Return ``value`` as JSON; equal values give equal bytes, and doubles all their digits.

    Raises
    ------
    ValueError
        A number is not finite; JSON has no word for it.
    """
    return "\n".join(_lines(value, "")) + "\n"


def _lines(value: object, indent: str) -> list[str]:
    """Return the lines of ``value``, all but the first indented."""
    line = _one_line(value)
    if len(indent) + len(line) < WIDTH or not isinstance(value, dict | list | tuple) or not value:
        return [line]
    inner = indent + " "
    if isinstance(value, dict):
        items = [_entry(key, item, inner) for key, item in value.items()]
        return ["{", *_with_commas(items, inner), f"{indent}}}"]
    if _is_flat(value):
        return ["[", *(inner + line for line in _wrapped(value, inner)), f"{indent}]"]
    return ["[", *_with_commas([_lines(item, inner) for item in value], inner), f"{indent}]"]


def _one_line(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def _entry(key: str, item: object, indent: str) -> list[str]:
    first, *rest = _lines(item, indent)
    return [f"{_one_line(key)}: {first}", *rest]


def _with_commas(items: list[list[str]], indent: str) -> Iterable[str]:
    for k, (first, *rest) in enumerate(items):
        *body, last = [indent + first, *rest]
        yield from body
        yield last + ("," if k < len(items) - 1 else "")


def _is_flat(value: Any) -> bool:
    """Whether each element is a number, a string, or a short list of these."""
    return all(
        _is_scalar(item)
        or (isinstance(item, list | tuple) and all(map(_is_scalar, item)) and _is_short(item))
        for item in value
    )


def _is_scalar(value: object) -> bool:
    return not isinstance(value, dict | list | tuple)


def _is_short(value: object) -> bool:
    return len(_one_line(value)) < WIDTH // 3


def _wrapped(value: Any, indent: str) -> Iterable[str]:
    """Return the elements of a flat list, as many on a line as fit."""
    line = ""
    for k, item in enumerate(value):
        text = _one_line(item) + ("," if k < len(value) - 1 else "")
        if line and len(indent) + len(line) + 1 + len(text) > WIDTH:
            yield line
            line = ""
        line = f"{line} {text}" if line else text
    yield line
