"""Scenes to begin with move as they are written; check and schema tell what is wrong with one."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jsonschema
import pytest

from kousoku.cli.new import Sort, template
from kousoku.model.reading.read import scene_from_toml
from kousoku.model.reading.schema import schema_text

if TYPE_CHECKING:
    from collections.abc import Callable

    Run = Callable[..., tuple[int, str, str]]

SCENES = Path(__file__).parents[2] / "scenes"


@pytest.mark.parametrize("sort", list(Sort))
def test_a_new_scene_is_right_and_moves_for_its_duration(
    run: Run, tmp_path: Path, sort: Sort, compiler: object
) -> None:
    file = tmp_path / f"{sort.value}.toml"
    code, out, err = run("new", sort.value, file)
    assert (code, err) == (0, "")
    assert f"kousoku simulate {file}" in out
    jsonschema.validate(tomllib.loads(file.read_text("utf-8")), json.loads(schema_text()))
    assert run("check", file)[0] == 0
    code, out, err = run("simulate", file, "--json")
    data = json.loads(out)
    assert (code, data["scene"], data["rows"]) == (0, sort.value.replace("-", "_"), 1001), err
    assert all("moved" not in note and "turned" not in note for note in data.get("notes", []))


@pytest.mark.parametrize("sort", list(Sort))
def test_a_template_has_a_duration_and_explains_itself(sort: Sort) -> None:
    text = template(sort, "mine")
    scene = scene_from_toml(text)
    assert scene.name == "mine"
    assert scene.duration is not None
    assert text.startswith("# ") and text.count("#") > 4


@pytest.mark.parametrize(
    ("file", "says"),
    [
        ("there.toml", "is there already"),
        ("scene.txt", "ends in .toml"),
        ("2nd.toml", "names the scene, too: '2nd' is not a name"),
    ],
)
def test_a_file_that_cannot_be_is_refused(run: Run, tmp_path: Path, file: str, says: str) -> None:
    (tmp_path / "there.toml").write_text("mine")
    code, _, err = run("new", "pendulum", tmp_path / file)
    assert code == 2
    assert says in err
    assert (tmp_path / "there.toml").read_text() == "mine"


@pytest.mark.parametrize("command", [("new", "pendulum"), ("schema", "--out")])
def test_no_folder_is_made(run: Run, tmp_path: Path, command: tuple[str, ...]) -> None:
    folder = tmp_path / "misspelt"
    code, out, err = run(*command, folder / "x.toml")
    assert (code, out, folder.exists()) == (2, "", False)
    assert err == f"kousoku: {folder / 'x.toml'}: there is no folder {folder}; make it first\n"


def test_a_new_scene_names_the_schema_beside_it(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    assert run("new", "linkage", file, "--schema")[0] == 0
    first, _, _ = file.read_text("utf-8").partition("\n")
    beside = tmp_path / first.removeprefix("#:schema ")
    assert beside.read_text("utf-8") == schema_text() == run("schema")[1]
    assert run("schema", "--out", tmp_path / "again.json")[0] == 0
    assert (tmp_path / "again.json").read_bytes() == beside.read_bytes()
    assert json.loads(schema_text())["$id"] == "urn:kousoku:scene"


def test_all_problems_of_all_files_are_found_and_nothing_is_generated(
    run: Run, tmp_path: Path, empty_cache: Path
) -> None:
    wrong, open_ = tmp_path / "wrong.toml", tmp_path / "open.toml"
    wrong.write_text('name = "wrong"\nunit = "m"\n[bodies]\nb = { positoin = [0, 0, 0] }\n')
    hinge = '{ type = "pin", bodies = ["ground", "b"], at = [0, 0, 0], axis = [0, 0, 1] }'
    open_.write_text(
        'name = "open"\nunit = "m"\n[bodies]\nb = { position = [0, 0, 0], mass = 1,'
        f" inertia = {{ xx = 1, yy = 1, zz = 1 }} }}\n[joints]\na = {hinge}\n"
        '[drivers]\none = { joint = "a", value = "t" }\n'
        'two = { body = "b", point = [1, 0, 0], path = ["1", "t", "5"] }\n'
    )
    code, out, _ = run("check", wrong, SCENES / "pendulum.toml", open_, "--json")
    data = json.loads(out)
    assert (code, data["format"]) == (2, 1)
    first, second, third = data["scenes"]
    assert [one["line"] for one in first["problems"]] == [4]
    assert "did you mean 'position'" in first["problems"][0]["text"]
    assert (second["is_valid"], second["problems"]) == (True, [])
    assert second["what"] == "1 body, 1 joint; 1 degree of freedom"
    assert not third["is_valid"]
    assert "for 1 degree of freedom" in third["problems"][0]["problem"]
    assert not empty_cache.exists()


def test_notes_are_told_and_do_not_count_as_problems(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "moved.toml"
    bar = "position = [0.4, 0.3, 0.2], rods = [{ mass = 1, ends = [[0, 0, 0], [1, 0, 0]] }]"
    points = "points = [[0, 0, 0], [0, 0, 0]], axes = [[0, 1, 0], [0, 1, 0]]"
    file.write_text(
        f'name = "moved"\nunit = "m"\n[bodies]\nbar = {{ {bar} }}\n[joints]\n'
        f'a = {{ type = "pin", bodies = ["ground", "bar"], {points} }}\n'
    )
    code, out, _ = run("check", file)
    assert code == 0
    assert out.splitlines() == [
        f"{file}: note: assembly changed bodies.bar: moved by 0.539 m, turned by 10.6 deg",
        f"{file}: 1 body, 1 joint; 1 degree of freedom",
    ]


def test_a_parameter_that_no_formula_has_is_told(run: Run, tmp_path: Path) -> None:
    text = (SCENES / "loop_free.toml").read_text(encoding="utf-8")
    file = tmp_path / "loop_free.toml"
    file.write_text(text.replace("{ mass = 3 }", "{ mass = 3, maas = 2 }"), encoding="utf-8")
    code, out, _ = run("check", file)
    assert code == 0
    (note,) = (line for line in out.splitlines() if "note: parameters" in line)
    assert note == f"{file}: note: parameters.maas: stands in no formula, and changes nothing"


@pytest.mark.parametrize(
    ("force", "problem", "note"),
    [
        ("-20*turn_dot/abs(turn_dot)", False, True),
        ("-2*log(turn_dot)", True, False),
        ("-20*sign(turn_dot)", False, True),
        ("3*sign(2*turn_dot - t)*turn", False, True),
        ("-20*turn_dot/sqrt(turn_dot^2 + 1e-6)", False, False),
        ("-20*sign(turn)", False, False),
        ("-20*abs(turn_dot)*turn_dot", False, False),
    ],
)
def test_dry_friction_is_told_before_it_stops_a_run(
    run: Run, tmp_path: Path, force: str, problem: bool, note: bool
) -> None:
    file = tmp_path / "dry.toml"
    hinge = '{ type = "hinge", bodies = ["ground", "bar"], at = [0, 0, 0], axis = [0, 0, 1] }'
    file.write_text(
        'name = "dry"\nunit = "m"\ncoordinates = { turn = { joint = "a" } }\n[bodies]\n'
        "bar = { position = [0, 0, 0], rods = [{ mass = 1, ends = [[0, 0, 0], [1, 0, 0]] }] }\n"
        f"[joints]\na = {hinge}\n[forces]\n"
        'push = { type = "force", body = "bar", force = ["t", 0, 0] }\n'
        f'dry = {{ type = "along", coordinate = "turn", force = "{force}" }}\n'
    )
    code, out, _ = run("check", file, "--json")
    found = json.loads(out)["scenes"][0]
    told = [(one["line"], one["key"]) for one in found["problems"]]
    assert (code, told) == ((2, [(10, "forces.dry")]) if problem else (0, []))
    assert any("as dry friction does" in one["problem"] for one in found["notes"]) == (
        note and not problem
    )


@pytest.mark.parametrize("name", ["none.toml", ""])
def test_a_file_that_cannot_be_read_is_a_problem(run: Run, tmp_path: Path, name: str) -> None:
    code, out, _ = run("check", tmp_path / name)
    assert code == 2
    assert "cannot be read" in out


def test_the_schema_is_printed_without_what_generates(loaded_by: Callable[..., set[str]]) -> None:
    loaded: Any = loaded_by("schema")
    assert not {name for name in loaded if name.startswith("kousoku.codegen")}
