"""What docs/scenes.md shows is what the reader takes."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path
from typing import get_args

import msgspec
import pytest

from kousoku.model.elements.joints import COUPLINGS, JOINTS
from kousoku.model.errors import SceneError
from kousoku.model.expressions.parser import ARGUMENTS
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.decode import MOST_ELEMENTS
from kousoku.model.reading.read import read_scene, scene_from_dict, scene_from_toml
from kousoku.model.records import loads, planar, spatial
from kousoku.model.records.orientation import Orientation
from kousoku.model.records.scene import TABLES, Scene
from kousoku.model.records.units import Unit

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "scenes.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^( *)```(\w+)\n(.*?)^ *```$", TEXT, re.M | re.S)


def blocks(language: str) -> list[str]:
    """Code blocks of a language, their indentation taken off."""
    return [re.sub(f"^{dent}", "", body, flags=re.M) for dent, of, body in BLOCKS if of == language]


@pytest.mark.parametrize("name", ["piston_crank", "lever_crank"])
def test_the_scenes_of_the_paper_are_shown_as_they_are(name: str) -> None:
    (shown,) = (text for text in blocks("toml") if f'name = "{name}"' in text)
    committed = read_scene(ROOT / "scenes" / f"{name}.toml")
    scene = scene_from_toml(shown)
    assert (scene.nodes, scene.links, scene.sliders) == (
        committed.nodes,
        committed.links,
        committed.sliders,
    )


def test_every_shown_part_stands_in_a_committed_scene() -> None:
    committed = [
        tomllib.loads(path.read_text(encoding="utf-8")) for path in (ROOT / "scenes").glob("*.toml")
    ]
    for text in blocks("toml"):
        for table, elements in tomllib.loads(text).items():
            if table in TABLES:
                for name, element in elements.items():
                    found = [tree.get(table, {}).get(name, {}) for tree in committed]
                    assert any(element.items() <= of.items() for of in found), f"{table}.{name}"


@pytest.mark.usefixtures("compiler")
def test_the_shown_python_builds_a_scene(capsys: pytest.CaptureFixture[str]) -> None:
    planar, spatial = blocks("python")
    exec(compile(planar, "docs/scenes.md", "exec"), {})
    assert scene_from_toml(capsys.readouterr().out).length("l3") == 80
    exec(compile(spatial, "docs/scenes.md", "exec"), {})
    (body,) = system_of(scene_from_toml(capsys.readouterr().out)).bodies
    assert body.r[2] == pytest.approx(0.04 * math.cos(0.3))


def test_the_largest_count_of_elements_is_stated() -> None:
    assert f"at most {MOST_ELEMENTS:,} elements" in TEXT


def test_the_shown_message_is_the_one_that_comes() -> None:
    (shown,) = blocks("text")
    tree = tomllib.loads((ROOT / "scenes" / "lever_crank.toml").read_text(encoding="utf-8"))
    tree["links"]["l2"]["length"], tree["links"]["l3"]["length"] = 45, 70
    with pytest.raises(SceneError) as caught:
        scene_from_dict(tree)
    assert " ".join(shown.split()) == str(caught.value)
    tree["inputs"]["alpha"] = {"link": "l1", "about": "O1", "from": -1, "to": 1}
    scene_from_dict(tree)


@pytest.mark.parametrize(
    "record",
    [
        Scene,
        planar.Node,
        planar.Link,
        planar.Rigid,
        planar.Slider,
        planar.Input,
        planar.Method,
        spatial.Body,
        spatial.Joint,
        spatial.Coordinate,
        spatial.Driver,
        loads.Force,
        Orientation,
    ],
)
def test_every_key_is_in_a_table(record: type[msgspec.Struct]) -> None:
    for field in msgspec.structs.fields(record):
        name = field.encode_name
        shown = (
            rf"^\| `{name}`|^\| `\w+` \| .*`{name}`|^\| `link`, `{name}`|^### `\[{name}\]`|joint = "
        )
        assert re.search(shown, TEXT, re.M), name


def test_every_unit_is_listed() -> None:
    for unit in get_args(Unit):
        assert f'`"{unit}"`' in TEXT


@pytest.mark.parametrize("name", JOINTS)
def test_the_table_of_joints_is_the_one_of_the_code(name: str) -> None:
    joint = JOINTS[name]
    aliases = ", ".join(f"`{alias}`" for alias in joint.aliases)
    kinds = ", ".join(part.kind for part in joint.parts)
    row = f"| `{name}` | {aliases} | {kinds} | {joint.rows} |"
    assert row.replace("|  |", "| |") in TEXT


@pytest.mark.parametrize("name", COUPLINGS)
def test_the_table_of_couplings_is_the_one_of_the_code(name: str) -> None:
    coupling = COUPLINGS[name]
    aliases = ", ".join(f"`{alias}`" for alias in coupling.aliases)
    keys = ", ".join(f"`{key}`" for key in coupling.keys)
    assert f"| `{name}` | {aliases} | {keys} | " in TEXT


def test_every_function_of_formulas_is_listed() -> None:
    (listed,) = re.findall(r"`(sin cos [a-z0-9 ]+)`", TEXT)
    assert set(listed.split()) == set(ARGUMENTS)
