"""JSON that a reader can follow and a diff can show: a record on a line, long lists wrapped."""

from __future__ import annotations

import json

WIDTH = 140


def to_text(value: object) -> str:
    """``value`` as JSON; equal values give equal bytes, and doubles all their digits.

    Raises
    ------
    ValueError
        A number is not finite; JSON has no word for it.
    """
    return "\n".join(_lines(value, "", 0)) + "\n"


def _lines(value: object, indent: str, offset: int) -> list[str]:
    """Lines of ``value``, all but the first indented.

    Parameters
    ----------
    value : object
        What is written.
    indent : str
        Of the lines that follow.
    offset : int
        Count of characters before it on the first line.
    """
    line = _one_line(value)
    if len(indent) + offset + len(line) < WIDTH or not isinstance(value, dict | list | tuple):
        return [line]
    inner = indent + " "
    if isinstance(value, dict):
        heads, items = [f"{_one_line(key)}: " for key in value], list(value.values())
    else:
        heads, items = [""] * len(value), list(value)
    lines, packed = [], ""
    for k, (head, item) in enumerate(zip(heads, items, strict=True)):
        first, *rest = _lines(item, inner, len(head))
        item_lines = [inner + head + first, *rest]
        item_lines[-1] += "," if k < len(items) - 1 else ""
        is_packed = not rest and _is_flat(item)
        if packed and (not is_packed or len(packed) + len(item_lines[0]) - len(indent) > WIDTH):
            lines.append(packed)
            packed = ""
        if not is_packed:
            lines += item_lines
        else:
            packed = f"{packed} {item_lines[0].lstrip()}" if packed else item_lines[0]
    lines += [packed] if packed else []
    return ["{", *lines, f"{indent}}}"] if isinstance(value, dict) else ["[", *lines, f"{indent}]"]


def _one_line(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def _is_flat(value: object) -> bool:
    """Whether a value is a number, a string, or a list of these."""
    if isinstance(value, list | tuple):
        return not any(isinstance(item, dict | list | tuple) for item in value)
    return not isinstance(value, dict)
