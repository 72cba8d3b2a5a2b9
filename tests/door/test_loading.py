"""What ``load`` takes, what it finds in the cache, and what it does where there is none."""

from __future__ import annotations

import copy
import errno
import multiprocessing
import os
import pickle
import time
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import pytest

import kousoku as ks
from kousoku import loading
from kousoku.model.errors import CacheError, SceneError
from kousoku.model.files.cache import cache_folder, clear, entries, shrink
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import read_scene
from kousoku.model.records.planar import Link

if TYPE_CHECKING:
    from collections.abc import Iterator

SCENES = Path(__file__).parents[2] / "scenes"
LOOP = SCENES / "loop_free.toml"
PENDULUM = SCENES / "pendulum.toml"


def numpy_loaded(scene: Any, outputs: Any = None) -> ks.Mechanism:
    return ks.load(scene, target="numpy", outputs=outputs)


def test_what_was_generated_is_found_by_the_bytes_of_the_file(
    empty_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = numpy_loaded(PENDULUM)
    monkeypatch.setattr(loading, "generated", None)
    monkeypatch.setattr(loading, "_text", None)  # not even read
    second = numpy_loaded(str(PENDULUM))
    assert (first.name, first.scene) == (second.name, second.scene)
    assert [entry.shelf for entry in entries()].count("scenes") == 1


@pytest.mark.usefixtures("empty_cache")
def test_the_same_scene_is_found_however_it_is_given(monkeypatch: pytest.MonkeyPatch) -> None:
    text = PENDULUM.read_text()
    numpy_loaded(PENDULUM)
    monkeypatch.setattr(loading, "generated", None)
    same = [text, f"# a remark\n{text}", tomllib.loads(text), numpy_loaded(PENDULUM).scene]
    assert {numpy_loaded(one).name for one in same} == {"pendulum"}


def test_other_outputs_other_scenes_and_another_kousoku_are_others(
    empty_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "reactions" not in numpy_loaded(PENDULUM).outputs
    assert ks.load(PENDULUM, target="numpy", outputs=["reactions"]).outputs == ("reactions",)
    numpy_loaded(PENDULUM.read_text().replace("9.81", "1.62"))
    monkeypatch.setattr(loading, "stamp", lambda: "another")
    numpy_loaded(PENDULUM)
    assert [entry.shelf for entry in entries()].count("scenes") == 4


@pytest.mark.usefixtures("numpy_solver")
def test_a_damaged_folder_is_generated_again(empty_cache: Path) -> None:
    numpy_loaded(PENDULUM)
    (solver,) = empty_cache.glob("scenes/*/pendulum/solver.py")
    solver.write_text("raise SystemExit")
    assert numpy_loaded(PENDULUM).simulate(0.1, samples=2).time[-1] == 0.1


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root writes anywhere")
def test_a_cache_that_cannot_be_written_is_done_without(empty_cache: Path) -> None:
    empty_cache.mkdir(mode=0o500)
    assert numpy_loaded(PENDULUM).name == "pendulum"


def test_a_cache_that_is_a_file_is_done_without(empty_cache: Path) -> None:
    empty_cache.write_text("")
    assert numpy_loaded(PENDULUM).name == "pendulum"


def _load_in_process(_: int) -> str:
    return ks.load(PENDULUM, target="numpy").name


@pytest.mark.usefixtures("empty_cache")
def test_many_processes_load_at_once() -> None:
    with multiprocessing.get_context("spawn").Pool(4) as pool:
        assert pool.map(_load_in_process, range(8)) == ["pendulum"] * 8
    assert [entry.shelf for entry in entries()].count("scenes") == 1


@pytest.mark.usefixtures("empty_cache")
def test_what_was_not_used_for_longest_makes_room() -> None:
    for gravity in "1.62", "3.71", "9.81":
        numpy_loaded(PENDULUM.read_text().replace("9.81", gravity))
    old = [entry for entry in entries() if entry.shelf == "scenes"]
    for k, entry in enumerate(old):
        os.utime(entry.path, (time.time() - 9000 + k,) * 2)
    assert shrink(old[1].size + old[2].size + 2000)[0].path == old[0].path
    assert [entry.path for entry in entries() if entry.shelf == "scenes"] == [
        entry.path for entry in old[1:]
    ]
    assert not shrink(0) or all(entry.path.exists() for entry in entries())
    clear()
    assert not entries()
    assert not list(cache_folder().glob("scenes/*"))


@pytest.fixture
def _recent(empty_cache: Path) -> Iterator[None]:
    numpy_loaded(PENDULUM)
    yield


@pytest.mark.usefixtures("_recent")
def test_what_was_used_just_now_stays() -> None:
    assert not shrink(0)


def test_a_size_of_the_cache_that_says_nothing_stops_before_work(
    empty_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KOUSOKU_CACHE_SIZE", "1Q")
    with pytest.raises(CacheError, match=r"KOUSOKU_CACHE_SIZE=1Q: wanted .* such as 500M"):
        numpy_loaded(PENDULUM)
    assert not empty_cache.exists() or not [*empty_cache.iterdir()]


@pytest.mark.parametrize("scene", [7, None, b"name", "missing.toml", "."])
def test_what_is_no_scene_is_refused(scene: object) -> None:
    with pytest.raises(ks.SceneError, match=r"no scene|cannot be read|is a folder"):
        numpy_loaded(scene)


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (None, "cannot be read: No such file or directory"),
        (b"\x89PNG\r\n\x1a\n\0", r"is not UTF-8 text \(at line 1\)"),
        (b'name = "x"\n\xff\xfe', r"is not UTF-8 text \(at line 2\)"),
        (b'name = "x"\nunit = "m"\n[bodies\n', "scene.toml:3: is not valid TOML"),
        (b'name = "x"\nunit = "ell"\n', "scene.toml:2: unit: .*'ell'"),
    ],
)
def test_a_file_that_is_no_scene_is_named(tmp_path: Path, data: bytes | None, says: str) -> None:
    path = tmp_path / "scene.toml"
    if data is not None:
        path.write_bytes(data)
    for given in (path, str(path)):
        with pytest.raises(ks.SceneError, match=says) as caught:
            numpy_loaded(given)
        assert all(line.startswith(str(path)) for line in str(caught.value).splitlines())


def test_names_and_texts_that_are_none_are_refused(tmp_path: Path) -> None:
    for given, says in (
        (tmp_path, "is a folder; wanted a scene file"),
        ("x" * 5000, "too long"),
        ("a\0b", "null"),
        ('name = "x"\nunit =\n', "line 2: is not valid TOML"),
    ):
        with pytest.raises(ks.SceneError, match=says):
            numpy_loaded(given)


def test_a_wrong_scene_is_refused_with_its_file_and_line(tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(LOOP.read_text().replace('"hinge"', '"hnige"', 1))
    with pytest.raises(ks.SceneError, match=rf"{wrong.name}:1[0-9]: joints.a.type"):
        numpy_loaded(wrong)


def test_an_output_that_there_is_not_is_refused() -> None:
    with pytest.raises(ks.SceneError, match="outputs: forces"):
        numpy_loaded(PENDULUM, ["forces"])
    with pytest.raises(ks.SceneError, match="wanted a list of names"):
        numpy_loaded(PENDULUM, 7)


def test_a_scene_that_was_put_together_by_hand_is_checked() -> None:
    scene = read_scene(SCENES / "lever_crank.toml")
    more = {**scene.links, "brace": Link(nodes=("O1", "O3"))}
    with pytest.raises(SceneError, match=r"wrong number of inputs: .* wants 0 inputs, got 1"):
        ks.load(msgspec.structs.replace(scene, links=more))


def test_a_builder_and_a_linkage_load() -> None:
    builder = (
        SceneBuilder("bar", unit="m")
        .gravity(0, 0, -9.81)
        .body("bar", rods=[{"mass": 1, "ends": [[0, 0, 0], [1, 0, 0]]}], position=[0, 0, 0])
        .joint("pin", type="hinge", bodies=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
    )
    bar = numpy_loaded(builder)
    assert repr(bar) == "<Mechanism bar: 1 body, 1 joint, 1 degree of freedom; in numpy>"
    crank = numpy_loaded(SCENES / "lever_crank.toml")
    assert repr(crank) == "<Mechanism lever_crank: 4 nodes, 4 links, 1 input; in numpy>"
    assert len(crank.solve(divisions=4)) == 5


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
@pytest.mark.parametrize("name", ["pendulum", "lever_crank"])
def test_a_mechanism_whose_scene_was_read_travels(name: str, copied: Any) -> None:
    mechanism = numpy_loaded(SCENES / f"{name}.toml")
    assert mechanism.scene.unit == mechanism.unit  # read: kept from now on
    other = copied(mechanism)
    assert other.scene == mechanism.scene
    with pytest.raises(TypeError):  # as little to be changed as before
        other.scene.nodes["new"] = None


def test_a_path_may_have_an_equals_sign(tmp_path: Path) -> None:
    path = tmp_path / "mass=2.toml"
    path.write_text(PENDULUM.read_text())
    assert numpy_loaded(str(path)).file == str(path)
    with pytest.raises(ks.SceneError, match=r"length=3.toml: cannot be read"):
        ks.load("length=3.toml")
    with pytest.raises(ks.SceneError, match="unit: is missing"):
        ks.load('name = "bar"')


@pytest.mark.usefixtures("empty_cache")
def test_without_room_anywhere_one_error_of_kousoku_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(loading, "_written", full)
    words = "pendulum: cannot write the cache: .*; nor a temporary folder: No space left on device"
    with pytest.raises(CacheError, match=words):
        numpy_loaded(PENDULUM)


def test_another_scene_beside_a_solver_in_the_cache_is_not_believed(empty_cache: Path) -> None:
    """Matrices and pictures are made from that text."""
    wanted = numpy_loaded(PENDULUM).text
    (file,) = empty_cache.glob("scenes/*/scene.toml")
    for damage in (wanted.replace("mass = 1", "mass = 2").encode(), b"", b"\xff"):
        file.write_bytes(damage)
        assert numpy_loaded(PENDULUM).text == wanted
        assert file.read_text(encoding="utf-8") == wanted
