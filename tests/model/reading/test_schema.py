"""The published JSON schema says what the types say, and accepts what the reader accepts."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from kousoku.model.reading.schema import SHARED, scene_schema, schema_text

ROOT = Path(__file__).parents[3]
COMMITTED = ROOT / "model" / "scene.schema.json"
SCENES = sorted((ROOT / "scenes").glob("*.toml"))

VALUES = (
    "unknown_key",
    "unknown_key_at_top",
    "zero_length_link",
    "negative_length",
    "formula",
    "formula_that_runs_code",
    "unknown_unit",
    "unit_left_out",
    "no_divisions",
    "fractional_divisions",
    "too_large_number",
    "infinite_position",
    "name_with_a_blank",
    "scene_name_is_a_path",
    "residual_of_zero",
    "unknown_scheme",
)
"""Bad scenes whose one value is wrong by itself, which is what a schema can see."""


@pytest.fixture(scope="module")
def validator() -> Any:
    """Validator of the committed schema."""
    schema = json.loads(COMMITTED.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def test_the_committed_schema_is_what_the_types_say_today() -> None:
    assert COMMITTED.read_text(encoding="utf-8") == schema_text(), (
        "python -m kousoku.model.reading.schema > model/scene.schema.json"
    )


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_the_schema_accepts_every_committed_scene(path: Path, validator: Any) -> None:
    validator.validate(tomllib.loads(path.read_text(encoding="utf-8")))


@pytest.mark.parametrize("name", VALUES)
def test_the_schema_refuses_values_that_are_wrong_by_themselves(name: str, validator: Any) -> None:
    path = ROOT / "tests" / "scenes" / "bad" / f"{name}.toml"
    assert not validator.is_valid(tomllib.loads(path.read_text(encoding="utf-8")))


def test_every_key_is_described() -> None:
    for name, definition in scene_schema()["$defs"].items():
        if name in SHARED:
            continue
        assert definition["description"], name
        for key, value in definition["properties"].items():
            assert value.get("description"), f"{name}.{key}"


@pytest.mark.parametrize("name", SHARED)
def test_what_stands_in_many_places_is_defined_once(name: str) -> None:
    text = json.dumps(scene_schema(), sort_keys=True)
    assert text.count(json.dumps(SHARED[name], sort_keys=True)) == 1
    assert f'"#/$defs/{name}"' in text


def test_no_key_takes_null_which_toml_does_not_have() -> None:
    assert "null" not in schema_text()
