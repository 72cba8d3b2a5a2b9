"""The JSON schema of scene files, for editors and for other programs.

``python -m kousoku.model.reading.schema`` prints what is committed as ``model/scene.schema.json``.
"""

from __future__ import annotations

import inspect
import json
import re
import sys
from typing import TYPE_CHECKING, Any

import msgspec

from kousoku.model.elements.drivers import own_inputs
from kousoku.model.elements.forces import FORCES
from kousoku.model.elements.joints import COUPLINGS, JOINTS, NAMES
from kousoku.model.records import loads, own_kind, planar, scene, spatial
from kousoku.model.records.design import LARGEST
from kousoku.model.records.scene import TABLES, Scene
from kousoku.model.validation.names import LONGEST_NAME, PATTERN
from kousoku.model.validation.validate import (
    LONGEST_TITLE,
    MOST_CLOSURE,
    MOST_DIVISIONS,
    MOST_ITERATIONS,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from kousoku.model.elements.inputs import ElementInput

LIMITS: dict[str, dict[str, dict[str, object]]] = {
    "Scene": {
        "name": {"pattern": PATTERN, "maxLength": LONGEST_NAME},
        "title": {"maxLength": LONGEST_TITLE},
        "duration": {"exclusiveMinimum": 0},
        "closure_tolerance": {"exclusiveMinimum": 0, "maximum": MOST_CLOSURE},
        "divisions": {"minimum": 1, "maximum": MOST_DIVISIONS},
    },
    "Link": {"length": {"exclusiveMinimum": 0}},
    "Rigid": {"links": {"minItems": 2, "uniqueItems": True}},
    "Method": {
        "residual": {"exclusiveMinimum": 0},
        "iterations": {"minimum": 1, "maximum": MOST_ITERATIONS},
    },
    "Body": {"mass": {"exclusiveMinimum": 0}},
    "Joint": {"length": {"exclusiveMinimum": 0}},
    "Force": {"free_length": {"minimum": 0}},
    "MassPoint": {"mass": {"exclusiveMinimum": 0}},
    "Box": {"mass": {"exclusiveMinimum": 0}},
    "Rod": {"mass": {"exclusiveMinimum": 0}},
    "Cylinder": {"mass": {"exclusiveMinimum": 0}, "radius": {"exclusiveMinimum": 0}},
    "Sphere": {"mass": {"exclusiveMinimum": 0}, "radius": {"exclusiveMinimum": 0}},
}
"""Limits of single values that the types do not express, by record and key."""

NUMBER = {"type": "number", "minimum": -LARGEST, "maximum": LARGEST}


TEXTS: dict[str, dict[str, Any]] = {
    "formula": {"type": "string"},
    "angle": {"type": "string", "pattern": r"^[-+ 0-9.eE]*[*]? *(deg|pi)? *(/[ 0-9.eE+-]+)?$"},
}
"""Texts that may stand in place of a number, by the mark of its type."""


def _triple(name: str) -> dict[str, Any]:
    item = {"$ref": f"#/$defs/{name}"}
    return {
        "type": "array",
        "prefixItems": [item, item, item],
        "minItems": 3,
        "maxItems": 3,
        "items": False,
    }


SHARED: dict[str, dict[str, Any]] = {
    "number": NUMBER,
    "formula": {"anyOf": [{"$ref": "#/$defs/number"}, {"type": "string"}]},
    "number_or_angle": {"anyOf": [{"$ref": "#/$defs/number"}, TEXTS["angle"]]},
    "vector": _triple("number"),
    "turns": _triple("number_or_angle"),
    "place": _triple("formula"),
}
"""Schemas that occur in many keys: they are defined once, under these names."""


def scene_schema() -> dict[str, Any]:
    """JSON schema (draft 2020-12) of a scene.

    It describes values one by one; relations of elements, such as names that resolve and degrees of
    freedom, are checked by :func:`kousoku.model.validation.validate.check`.
    """
    schema = msgspec.json.schema(Scene)
    definitions: dict[str, Any] = schema["$defs"]
    for name, definition in definitions.items():
        modules = (scene, planar, spatial, loads, own_kind)
        record = next(getattr(module, name) for module in modules if hasattr(module, name))
        _describe(definition, record)
        definition["properties"].pop(getattr(record, "FLAT", ""), None)
        for key, limits in LIMITS.get(name, {}).items():
            definition["properties"][key].update(limits)
    of_joints = [kind.inputs for kind in JOINTS.values()]
    of_joints += [kind.inputs for kind in COUPLINGS.values()]
    of_forces = [kind.inputs for kind in FORCES.values()]
    for name, types, inputs in (("Joint", NAMES, of_joints), ("Force", FORCES, of_forces)):
        definitions[name]["properties"]["type"]["enum"] = list(types)
        definitions[name]["properties"] |= _own_keys(inputs)
    definitions["Driver"]["properties"] |= _own_keys([own_inputs()])
    for table in TABLES:
        definitions["Scene"]["properties"][table]["propertyNames"] = {
            "pattern": PATTERN,
            "maxLength": LONGEST_NAME,
        }
    head = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": "urn:kousoku:scene",
        "title": "A scene of kousoku",
    }
    shared = dict(_shared(_bounded(schema)))
    return head | shared | {"$defs": shared["$defs"] | SHARED}


def schema_text() -> str:
    """Text of ``scene.schema.json``."""
    return json.dumps(scene_schema(), indent=2, ensure_ascii=False) + "\n"


def _own_keys(tables: Iterable[Mapping[str, ElementInput]]) -> dict[str, Any]:
    """Keys that some types of a record alone have."""
    entries = {name: entry for table in tables for name, entry in table.items()}
    return {
        name: {"anyOf": [msgspec.json.schema(entry.type), {"type": "null"}]}
        | {"default": None, "description": entry.meaning}
        for name, entry in entries.items()
    }


def _describe(definition: dict[str, Any], record: type[msgspec.Struct]) -> None:
    """Copy the numpydoc of a record to the descriptions that editors show."""
    text = inspect.cleandoc(record.__doc__ or "")
    summary, _, parameters = text.partition("Parameters\n----------\n")
    definition["description"] = _plain(summary)
    names = {field.name: field.encode_name for field in msgspec.structs.fields(record)}
    for head, body in re.findall(r"^(\w[^:\n]*) : [^\n]*\n((?:    .*\n?|\n)+)", parameters, re.M):
        for name in re.split(r",\s*", head):
            definition["properties"][names[name]]["description"] = _plain(body)


def _plain(text: str) -> str:
    """Numpydoc text as one line without markup."""
    text = re.sub(r":\w+:`(?:[\w.]*\.)?(\w+)`", r"\1", text)
    return " ".join(text.replace("`", "").split())


def _bounded(node: Any) -> Any:
    """Bound every number, and drop null: TOML has none, a key is left out instead."""
    if isinstance(node, list):
        return [_bounded(item) for item in node]
    if not isinstance(node, dict):
        return node
    if "anyOf" in node:
        choices = [option for option in node["anyOf"] if option != {"type": "null"}]
        keywords = {key: item for key, item in node.items() if key not in ("anyOf", "default")}
        if len(choices) > 1:  # a number, or the text of a formula
            return keywords | {"anyOf": _bounded(choices)}
        return _bounded(choices[0] | keywords)
    for mark, text in TEXTS.items():
        if node.get(mark) is True:  # a key of a record may have the same name
            return _number_or_text({key: item for key, item in node.items() if key != mark}, text)
    bounded = {key: _bounded(item) for key, item in node.items() if item is not None}
    if bounded.get("type") == "number":
        bounded = NUMBER | bounded
        if "exclusiveMinimum" in bounded:
            del bounded["minimum"]
    return bounded


def _number_or_text(node: dict[str, Any], text: dict[str, Any]) -> Any:
    """Schema of a number: within its limits, or the text of a formula or an angle."""
    notes = {key: node[key] for key in ("description", "default") if key in node}
    number = {key: item for key, item in node.items() if key not in notes}
    return _bounded({key: item for key, item in notes.items() if item is not None}) | {
        "anyOf": [_bounded(number), text]
    }


def _shared(node: Any) -> Any:
    """Schema with references in place of the schemas of :data:`SHARED`."""
    if isinstance(node, list):
        return [_shared(item) for item in node]
    if not isinstance(node, dict):
        return node
    shared = {key: _shared(item) for key, item in node.items()}
    notes = {key: shared[key] for key in ("description", "default") if key in shared}
    shape = {key: item for key, item in shared.items() if key not in notes}
    name = next((name for name, definition in SHARED.items() if shape == definition), None)
    return shared if name is None else {"$ref": f"#/$defs/{name}"} | notes


if __name__ == "__main__":
    sys.stdout.write(schema_text())
