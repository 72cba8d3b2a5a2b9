"""Scene files: what is read, and the message for each thing that can be wrong with one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from kousoku.model.errors import AssemblyError, SceneError
from kousoku.model.reading import read
from kousoku.model.reading.decode import MOST_ELEMENTS
from kousoku.model.reading.lines import each_key_line
from kousoku.model.reading.read import (
    LARGEST_FILE,
    located,
    read_scene,
    scene_from_dict,
    scene_from_toml,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).parents[3]
SCENES = sorted((ROOT / "scenes").glob("*.toml"))
KNOWN_LATER = sorted((ROOT / "tests" / "scenes").glob("*.toml"))
BAD = sorted((ROOT / "tests" / "scenes" / "bad").glob("*.toml"))


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_a_committed_scene_is_valid_and_named_as_its_file(path: Path) -> None:
    assert read_scene(path).name == path.stem


@pytest.mark.parametrize("path", BAD, ids=lambda path: path.stem)
def test_a_bad_scene_gets_one_message_with_file_key_and_reason(path: Path) -> None:
    """The first two lines of each file hold the key and a part of the reason."""
    key, says = (line.partition(": ")[2] for line in path.read_text().splitlines()[:2])
    with pytest.raises(SceneError) as caught:
        read_scene(path)
    error = caught.value
    assert error.file == str(path)
    assert error.key == key
    assert says in error.problem
    assert len(error.problems) == 1
    line = error.problems[0].line
    where = f"{path}:{line}" if line else str(path)
    assert str(error) == ": ".join(part for part in (where, key, error.problem) if part)
    assert "\n" not in str(error)


@pytest.mark.parametrize("path", KNOWN_LATER, ids=lambda path: path.stem)
def test_what_only_the_solver_can_know_is_left_to_it(path: Path) -> None:
    assert read_scene(path).name == path.stem


def test_the_paper_scenes_hold_what_section_4_says() -> None:
    piston = read_scene(ROOT / "scenes" / "piston_crank.toml")
    lever = read_scene(ROOT / "scenes" / "lever_crank.toml")
    assert [piston.length(name) for name in piston.links] == [1, 2]
    assert [lever.length(name) for name in lever.links] == [30, 60, 80, 100]
    for scene in (piston, lever):
        assert (scene.unit, scene.divisions, scene.residual_limit) == ("cm", 60, 1e-13)
        (alpha,) = scene.inputs.values()
        assert (alpha.about, alpha.start, alpha.turns) == ("O1", 0, 1)
        assert (alpha.rate, alpha.acceleration) == (1, 0)
    assert piston.nodes["O3"].at[0] > 0
    assert lever.nodes["O3"].at[1] > 0
    assert lever.nodes["O4"].at == (100, 0)


def test_a_file_that_is_not_there_is_named() -> None:
    with pytest.raises(SceneError, match=r"^nowhere\.toml: cannot be read: No such file"):
        read_scene("nowhere.toml")


def test_a_file_of_a_similar_name_is_told(tmp_path: Path) -> None:
    (tmp_path / "four_bar.toml").write_text("", encoding="utf-8")
    for name in ("four-bar.toml", "four_bar"):
        with pytest.raises(SceneError, match=r"No such file or directory; did you mean") as caught:
            read_scene(tmp_path / name)
        assert str(caught.value).endswith(f"{str(tmp_path / 'four_bar.toml')!r}?")


def test_a_folder_is_no_scene(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="cannot be read: "):
        read_scene(tmp_path)


def test_a_name_that_no_file_has_is_shown_safely() -> None:
    with pytest.raises(SceneError, match=r"^'a\\x00b': is not the name of a file"):
        read_scene("a\0b")


def test_text_in_another_encoding_is_refused_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "latin.toml"
    path.write_bytes('name = "x"\ntitle = "Schwinge für O4"\n'.encode("latin-1"))
    with pytest.raises(SceneError, match=r"is not UTF-8 text \(at line 2\)"):
        read_scene(path)


def test_the_mark_that_some_editors_put_first_is_read_over(tmp_path: Path) -> None:
    path = tmp_path / "lever.toml"
    text = (ROOT / "scenes" / "lever_crank.toml").read_bytes()
    path.write_bytes(b"\xef\xbb\xbf" + text.replace(b"\n", b"\r\n"))
    assert read_scene(path) == read_scene(ROOT / "scenes" / "lever_crank.toml")


def test_broken_toml_is_refused_with_its_line() -> None:
    with pytest.raises(SceneError, match=r"is not valid TOML: .*line 2"):
        scene_from_toml('name = "x"\nunit == "m"\n')


def test_a_number_of_ten_thousand_digits_is_refused() -> None:
    with pytest.raises(SceneError, match="is not valid TOML"):
        scene_from_toml("divisions = " + "9" * 10_000)


def test_tables_nested_too_deeply_are_refused() -> None:
    with pytest.raises(SceneError, match="nested too deeply"):
        scene_from_toml("nodes = " + "[" * 100_000)


def test_a_file_that_never_ends_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    path.write_bytes(b"#" * (LARGEST_FILE + 1))
    with pytest.raises(SceneError, match="is too large: a scene file has at most 8 MiB"):
        read_scene(path)


@pytest.mark.parametrize("tree", [None, 3, "scene", [], [{}], object()])
def test_what_is_no_table_is_no_scene(tree: object) -> None:
    with pytest.raises(SceneError, match="stands where a table is wanted"):
        scene_from_dict(tree)


def test_a_key_of_a_hundred_thousand_parts_is_refused_before_it_is_parsed() -> None:
    with pytest.raises(SceneError, match="line 2: has a key of more than 32 parts"):
        scene_from_toml('name = "x"\n' + ".".join("a" * 100_000) + " = 1\n")


def test_numbers_and_arrays_of_numpy_stand_for_those_of_python() -> None:
    def body(position: object, mass: object, xx: object) -> dict[str, object]:
        inertia = {"xx": xx, "yy": 1, "zz": 1}
        solid = {"position": position, "mass": mass, "inertia": inertia}
        return {"name": "s", "unit": "m", "bodies": {"b": solid}}

    given = body(np.arange(3.0), np.int64(2), np.float64(1.5))
    assert scene_from_dict(given) == scene_from_dict(body([0, 1, 2], 2, 1.5))
    with pytest.raises(SceneError, match="a list of 2 stands where a list of 3 numbers is wanted"):
        scene_from_dict(body(np.zeros(2), 2, 1))


def test_lines_stand_behind_whole_names_in_errors_of_assembly(tmp_path: Path) -> None:
    path = tmp_path / "open.toml"
    path.write_text("[joints.a]\n[joints.ab]\n[inputs.turn]\n", encoding="utf-8")
    says = "s: open: joints.ab by 2 m, joints.a.b, joints.a by 1 m, drivers.turn by 1 rad; mend"
    keys = ["joints.gone", "joints.ab", "joints.a", "drivers.turn"]
    found = located(AssemblyError(says, keys), path)
    assert isinstance(found, AssemblyError)
    assert found.keys == tuple(keys)
    assert str(found) == (
        f"{path}:2: s: open: joints.ab (line 2) by 2 m, joints.a.b, joints.a (line 1) by 1 m, "
        "drivers.turn (line 3) by 1 rad; mend"
    )


def test_a_scene_that_is_too_large_is_refused_where_its_table_begins(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The line of a limit is said at once: what stands behind it is not gone through."""
    gone_through = []

    def counted(text: str) -> Iterator[tuple[tuple[str | int, ...], int]]:
        for path, line in each_key_line(text):
            gone_through.append(path)
            yield path, line

    monkeypatch.setattr(read, "each_key_line", counted)
    bodies = "\n".join(f"b{k} = {{ position = [{k}, 0, 0] }}" for k in range(MOST_ELEMENTS + 1))
    with pytest.raises(SceneError) as caught:
        scene_from_toml(f'name = "many"\nunit = "m"\n[bodies]\n{bodies}\n', file="many.toml")
    assert str(caught.value).startswith("many.toml:3: bodies: has 20001 elements")
    assert gone_through == [("name",), ("unit",), ("bodies",)]
