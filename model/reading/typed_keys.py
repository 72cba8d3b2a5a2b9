"""Write the keys of records as typed dictionaries, for type checkers and editors.

What ``python -m kousoku.model.reading.typed_keys`` prints is committed as
``model/reading/keys.py``.
"""

from __future__ import annotations

import sys
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin

import msgspec

from kousoku.model.records.design import Design, NumberOrAngle
from kousoku.model.records.loads import Force
from kousoku.model.records.orientation import Orientation
from kousoku.model.records.planar import Method
from kousoku.model.records.solids import Box, Cylinder, Inertia, MassPoint, Rod, Sphere
from kousoku.model.records.spatial import Body, Coordinate, Driver, Event, Joint

RECORDS = (
    *(Orientation, Inertia, MassPoint, Box, Rod, Cylinder, Sphere),
    *(Body, Joint, Coordinate, Driver, Force, Event, Method),
)
"""The records, those first that others hold."""

HEAD = '''"""Keys of the records of a scene, typed: what the calls of the builder take.

Written by ``python -m kousoku.model.reading.typed_keys`` from the records themselves.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, Required, TypedDict

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Value = float | str
    Numbers = Sequence[float] | NDArray[Any]
    Values = Sequence[Value] | NDArray[Any]
    Rows = Sequence[Numbers] | NDArray[Any]
    Points = Sequence[Values] | NDArray[Any]
'''


def keys_text() -> str:
    """Text of ``model/reading/keys.py``."""
    return "\n\n".join([HEAD, *(_record(record) for record in RECORDS)])


def _record(record: type[msgspec.Struct]) -> str:
    lines = [f"class {record.__name__}Keys(TypedDict, total=False):"]
    lines.append(f'    """Keys of :class:`{record.__module__}.{record.__name__}`."""\n')
    flat = getattr(record, "FLAT", "")
    for field in (field for field in msgspec.structs.fields(record) if field.name != flat):
        text = _annotation(field.type)
        text = f"Required[{text}]" if field.required else text
        lines.append(_line(field.encode_name, text))
    return "\n".join(lines) + "\n"


def _line(name: str, text: str) -> str:
    """Field, broken as the formatter does where it is long."""
    line = f"    {name}: {text}"
    if len(line) <= 100:
        return line
    return f"    {name}: (\n        {text.replace(' | ', chr(10) + '        | ')}\n    )"


def _annotation(kind: Any) -> str:
    """Annotation of the values that the builder takes for a type."""
    choices = list(get_args(kind)) if get_origin(kind) in (Union, UnionType) else [kind]
    texts = dict.fromkeys(_single_annotation(choice) for choice in choices)
    if "Value" in texts:  # a number or the text of a formula
        texts.pop("float", None)
        texts.pop("str", None)
    if {"float", "str"} <= {*texts}:
        texts = {("Value" if text == "float" else text): None for text in texts if text != "str"}
    return " | ".join(texts)


def _single_annotation(kind: Any) -> str:
    if kind in (Design, NumberOrAngle):
        return "Value"
    if kind is type(None):
        return "None"
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Literal:
        return f"Literal[{', '.join(map(repr, arguments))}]".replace("'", '"')
    if origin is tuple:
        return _list_annotation(_annotation(arguments[0]))
    if issubclass(kind, msgspec.Struct):
        return f"{kind.__name__}Keys"
    return str(kind.__name__)


def _list_annotation(text: str) -> str:
    arrays = {"float": "Numbers", "Value": "Values", "Numbers": "Rows", "Values": "Points"}
    return arrays.get(text, f"Sequence[{text}]")


if __name__ == "__main__":
    sys.stdout.write(keys_text())
