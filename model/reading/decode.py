"""Turn a tree of tables into the records of a scene, with messages for people."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from functools import cache
from math import inf
from types import UnionType
from typing import TYPE_CHECKING, Any, Literal, TypeVar, Union, cast, get_args, get_origin

import msgspec

from kousoku.model.angles import Angle
from kousoku.model.elements.type_keys import keys_of_type, own_inputs
from kousoku.model.errors import SceneError
from kousoku.model.reading.of_sympy import is_of_sympy, plain_of
from kousoku.model.records.design import LARGEST, Design, Formula, NumberOrAngle
from kousoku.model.records.dotted_keys import join
from kousoku.model.records.problems import Problems
from kousoku.model.text import nearest, with_a

if TYPE_CHECKING:
    from kousoku.model.elements.inputs import ElementInput
    from kousoku.model.records.own_kind import OwnInput

S = TypeVar("S", bound=msgspec.Struct)

FAILED = object()
"""Marker of a value that cannot be built."""


MOST_ELEMENTS = 20_000
"""Bodies, joints … of the largest scene; larger tables are refused before they are read."""


_LIMITS = "joints have no limits and no stops"
_FRICTION = (
    "there is no Coulomb friction; 'damping' is viscous, and a force along a coordinate s may be"
    " such as '-3*s_dot/sqrt(s_dot^2 + 1e-6)'"
)
#: Values of the key ``order`` of a quaternion.
QUATERNIONS = ("wxyz", "xyzw")
MISSING_FEATURES = dict.fromkeys(
    ("limits", "limit", "range", "lower", "upper", "stop", "stops", "min", "max"), _LIMITS
) | dict.fromkeys(("coefficient", "coulomb", "friction", "mu", "static", "dynamic"), _FRICTION)
"""Keys of features that are not supported, and the reason."""


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
        Keys are unknown or missing, or values are not of the type that is wanted: all of them.
    """
    problems = Problems()
    values = _fields(tree, record, key, problems)
    problems.settle()
    return record(**values)


def decode_parts(
    tree: object, record: type[S], defaults: Mapping[str, Any], problems: Problems
) -> S:
    """Build the valid part of a record: wrong values are noted, broken, and left out.

    Parameters
    ----------
    tree : object
        What a TOML parser gave.
    record : type
        The record to build. Of its mappings the elements that are wrong are left out, of its other
        fields each that is wrong.
    defaults : mapping of str to object
        Values of required fields that are wrong.
    problems : Problems
        Where to note what is wrong.

    Raises
    ------
    SceneError
        The tree is no table: nothing can be built.
    """
    if not isinstance(tree, Mapping):
        raise SceneError(f"{_value_text(tree)} stands where a table is wanted")
    return record(**{**defaults, **_fields(tree, record, "", problems)})


def _fields(
    tree: object, record: type[msgspec.Struct], key: str, problems: Problems
) -> dict[str, Any]:
    """Valid fields; an unknown key breaks the known one that it resembles."""
    if not isinstance(tree, Mapping):
        example = getattr(record, "EXAMPLE", "")
        hint = f", such as {example}" if example else ""
        problems.add(f"{_value_text(tree)} stands where a table is wanted{hint}", key, breaks=key)
        return {}
    fields = _fields_of(record)
    flat = getattr(record, "FLAT", "")
    inputs = _own_inputs(tree, record, problems) if flat else {}
    known = {name: field for name, field in fields.items() if name not in (inputs or ())}
    resembled: dict[str, None] = {}
    for name in tree:
        if inputs is None or name in known or name in inputs or problems.is_full:
            continue
        problems.add(_unknown_key(str(name), tree, record, inputs), join(key, str(name)))
        resembled.setdefault(nearest(name, (*known, *inputs)))
    values: dict[str, Any] = {}
    if inputs:
        own_values = {
            name: _value(tree[name], entry.type, join(key, name), problems)
            for name, entry in inputs.items()
            if name in tree
        }
        values[flat] = {name: value for name, value in own_values.items() if value is not FAILED}
    for name, field in known.items():
        field_key = join(key, name)
        if name in tree:
            value = _value(tree[name], field.type, field_key, problems)
            if value is not FAILED:
                values[field.name] = value
        elif name in resembled:
            problems.break_(field_key)
        elif field.required:
            problems.add(
                f"is missing; wanted {_type_text(field.type)}", field_key, breaks=field_key
            )
    return values


@cache
def _fields_of(record: type[msgspec.Struct]) -> dict[str, Any]:
    """Fields of a record by their names in a file."""
    flat = getattr(record, "FLAT", "")
    fields = msgspec.structs.fields(record)
    return {field.encode_name: field for field in fields if field.name != flat}


def _own_inputs(
    tree: Mapping[Any, object], record: type[msgspec.Struct], problems: Problems
) -> Mapping[str, OwnInput | ElementInput] | None:
    """Keys that the type of a record alone has, or None where the type is unknown.

    Of records without a type, the keys of all their sorts.
    """
    sort = tree.get("type") if "type" in _fields_of(record) else ""
    if not isinstance(sort, str):
        return {}
    return own_inputs(record, sort, problems.kinds)


def _unknown_key(
    name: str,
    tree: Mapping[Any, object],
    record: type[msgspec.Struct],
    inputs: Mapping[str, OwnInput | ElementInput],
) -> str:
    """Message for an unknown key of a record, with the keys that it may have."""
    fields = (*inputs, *_fields_of(record))
    near = nearest(name, fields)
    sort = tree.get("type")
    keys = keys_of_type(record, sort)
    if inputs and not keys and "type" in tree:
        keys = ("type", "bodies", *inputs)
    listed = ", ".join(keys or fields)
    known = f"{with_a(str(sort))} has {listed}" if keys else f"known here: {listed}"
    if name in MISSING_FEATURES:
        return f"unknown key: {MISSING_FEATURES[name]}; {known}"
    return f"unknown key; did you mean {near!r}?" if near else f"unknown key; {known}"


def _value(value: object, kind: Any, key: str, problems: Problems) -> object:
    """Value of a type, or ``FAILED`` with the reason noted."""
    if problems.is_full:
        problems.break_(key)
        return FAILED
    if is_of_sympy(value):
        try:
            value = plain_of(value)
        except ValueError as error:
            return _failed(str(error), key, problems)
    elif hasattr(value, "tolist"):
        value = value.tolist()
    kind = _without_none(kind)
    if kind == Design and isinstance(value, str):
        problems.has_formulas = True
        return Formula(value)
    if kind == NumberOrAngle and isinstance(value, str):
        return _angle(value, key, problems)
    wanted, kind = kind, _chosen(kind, value)
    origin, arguments = get_origin(kind), get_args(kind)
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        return _record(value, kind, key, problems)
    if origin is Mapping:
        return _mapping(value, arguments[1], key, problems)
    if origin is tuple:
        return _tuple(value, kind, key, problems)
    if isinstance(value, int | float) and not abs(value) <= LARGEST:
        problem = "is too large" if abs(value) < inf else "is not a finite number"
        shown = _value_text(value).removeprefix("the number ")
        return _failed(f"{shown} {problem}; wanted at most {LARGEST:g}", key, problems)
    if isinstance(value, str) and any("\ud800" <= mark <= "\udfff" for mark in value):
        return _failed(f"{_value_text(value)} has half of a character", key, problems)
    try:
        leaf: object = msgspec.convert(value, kind)
    except msgspec.ValidationError:
        return _failed(_refusal(value, wanted), key, problems)
    return leaf


def _angle(text: str, key: str, problems: Problems) -> object:
    try:
        angle = Angle(text)
    except ValueError as error:
        return _failed(
            f"the text {error}; no formula may stand here, write the number itself", key, problems
        )
    if not abs(angle) <= LARGEST:
        return _failed(
            f"{_value_text(text)} is too large; wanted at most {LARGEST:g}", key, problems
        )
    return angle


def _failed(problem: str, key: str, problems: Problems) -> object:
    problems.add(problem, key, breaks=key)
    return FAILED


def _record(value: object, record: type[msgspec.Struct], key: str, problems: Problems) -> object:
    """Record without problems, or ``FAILED``."""
    before = len(problems.found)
    values = _fields(value, record, key, problems)
    if len(problems.found) > before:
        problems.break_(key)
        return FAILED
    return record(**values)


def _mapping(value: object, kind: Any, key: str, problems: Problems) -> object:
    """Elements without problems, or ``FAILED`` where there is no table."""
    if not isinstance(value, Mapping):
        return _failed(f"{_value_text(value)} stands where a table is wanted", key, problems)
    if len(value) > MOST_ELEMENTS:
        problem = f"has {len(value)} elements; the limit is {MOST_ELEMENTS}"
        return _failed(problem, key, problems)
    pairs = (
        (str(name), _value(item, kind, join(key, str(name)), problems))
        for name, item in value.items()
    )
    return {name: item for name, item in pairs if item is not FAILED}


def _tuple(value: object, kind: Any, key: str, problems: Problems) -> object:
    kinds = get_args(kind)
    is_open = len(kinds) == 2 and kinds[1] is Ellipsis
    if not isinstance(value, list | tuple) or not (is_open or len(value) == len(kinds)):
        return _failed(_refusal(value, kind), key, problems)
    if is_open:
        kinds = kinds[:1] * len(value)
    pairs = zip(value, kinds, strict=True)
    items = [
        _value(item, item_kind, f"{key}[{index}]", problems)
        for index, (item, item_kind) in enumerate(pairs)
    ]
    return FAILED if FAILED in items else tuple(items)


def _without_none(kind: Any) -> Any:
    if get_origin(kind) in (Union, UnionType):
        kinds = [choice for choice in get_args(kind) if choice is not type(None)]
        return Union[tuple(kinds)]  # noqa: UP007 of one type it is that type
    return kind


def _choices(kind: Any) -> tuple[Any, ...]:
    """Choices of a type: a number, the text of a formula, a list."""
    return get_args(kind) if get_origin(kind) in (Union, UnionType) else (kind,)


def _chosen(kind: Any, value: object) -> Any:
    """Choice of a type that a value is meant to be."""
    choices = _choices(kind)
    lists = [choice for choice in choices if get_origin(choice) is tuple]
    if lists and isinstance(value, list | tuple):
        return lists[0]
    if str in choices and isinstance(value, str):
        return str
    return next((choice for choice in choices if choice not in lists), choices[0])


def _refusal(value: object, kind: Any) -> str:
    problem = f"{_value_text(value)} stands where {_type_text(kind)} is wanted"
    if isinstance(value, str) and kind in (int, float):
        problem += "; no formula may stand here, write the number itself"
    if get_args(_without_none(kind)) == QUATERNIONS:
        problem += "; it belongs to quaternion: angles have 'sequence', such as 'zyx', and 'about'"
    return problem


def _type_text(kind: Any) -> str:
    kind = _without_none(kind)
    if kind == Design:
        return "a number, or a formula of parameters,"
    if kind == NumberOrAngle:
        return "a number, or an angle such as '30 deg',"
    if str in _choices(kind) and kind is not str:
        names = {float: "a number", str: "a formula"}
        return " or ".join(names.get(choice) or _type_text(choice) for choice in _choices(kind))
    nouns = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}
    if kind in nouns:
        return nouns[kind]
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Literal:
        return "one of " + ", ".join(repr(choice) for choice in arguments)
    if origin is tuple and arguments[-1] is Ellipsis:
        return "a list"
    if origin is tuple:
        noun = "numbers or formulas" if float in _choices(arguments[0]) else "lists"
        numbers = dict.fromkeys((float, Design, NumberOrAngle), "numbers")
        noun = (numbers | {str: "names"}).get(arguments[0], noun)
        return f"a list of {len(arguments)} {noun}"
    return "a table"


def _value_text(value: object) -> str:
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
