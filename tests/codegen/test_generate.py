"""The pipeline of a kind, and the folders that are written."""

import gzip
import json
import subprocess
import sys
from pathlib import Path

import pytest

import kousoku.generated
from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.emit import sha256
from kousoku.codegen.generate import (
    check_tree,
    foreign_files,
    generate_kind,
    package_names,
    write_tree,
)
from kousoku.codegen.kernel_json import parse
from kousoku.model.errors import DerivationError
from kousoku.model.files.manifest import Manifest
from kousoku.model.reading.read import scene_from_toml

FILES = {
    "batch_numpy.py",
    "expressions.h",
    "__init__.py",
    "graph.json.gz",
    "kernels.c",
    "kernels.h",
    "kernels.py",
    "kernels_batch.c",
    "lanes.h",
    "manifest.json",
    "reference.json.gz",
}

COMMITTED = Path(kousoku.generated.__path__[0]) / "kinds"
SCENES = Path(__file__).parents[2] / "scenes"
EDITED = "it was edited after it was generated"


def test_a_kind_becomes_a_folder_whose_manifest_lists_it(empty_cache: Path) -> None:
    tree = generate_kind("n1", COMMITTED)
    assert set(tree) == FILES
    assert list(tree)[-1] == "manifest.json"
    manifest = Manifest.from_json(tree["manifest.json"])
    assert {name for name, _ in manifest.files} == FILES - {"manifest.json"}
    assert parse(tree["graph.json.gz"]).name == manifest.package == "n1"
    assert manifest.regenerate == "kousoku generate n1"


def test_all_packages_of_all_kinds_have_names() -> None:
    names = package_names()
    assert len(names) == len(set(names))
    assert {"rotation", "n1", "p1", "p2", "link", "mass_points", "rigid_body"} <= set(names)


def test_an_unknown_kind_is_an_error(empty_cache: Path) -> None:
    with pytest.raises(DerivationError, match="unknown kind 'sponge'"):
        generate_kind("sponge")


def test_a_warm_cache_starts_no_sympy(empty_cache: Path) -> None:
    generate_kind("n1")
    program = (
        "import sys; from kousoku.codegen.generate import generate_kind\n"
        "generate_kind('n1'); assert 'sympy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def tree_with(**texts: str) -> dict[str, str]:
    manifest = json.dumps({"files": [[name.replace("_", "."), ""] for name in texts]})
    files = {name.replace("_", "."): text for name, text in texts.items()}
    return files | {"manifest.json": manifest}


def test_a_written_folder_is_up_to_date(tmp_path: Path) -> None:
    tree = tree_with(a_c="one\n", b_py="two\n")
    assert write_tree(tmp_path / "new", tree) == ["a.c", "b.py", "manifest.json"]
    assert check_tree(tmp_path / "new", tree) == []
    assert write_tree(tmp_path / "new", tree) == []


def test_differences_name_the_file_and_the_line(tmp_path: Path) -> None:
    tree = tree_with(a_c="one\ntwo\n", b_py="two\n")
    write_tree(tmp_path, tree)
    (tmp_path / "a.c").write_bytes(b"one\nTWO\n")
    (tmp_path / "b.py").unlink()
    (tmp_path / "c.txt").write_text("mine")
    differs, missing = check_tree(tmp_path, tree)
    assert differs.endswith(f"a.c differs from line 2 on: 'TWO' instead of 'two'; {EDITED}")
    assert missing.endswith("b.py is missing")
    assert foreign_files(tmp_path, tree) == [tmp_path / "c.txt"]


def test_what_an_older_version_wrote_is_a_difference_and_a_users_file_is_not(
    tmp_path: Path,
) -> None:
    """The one is removed by generating again, the other never: a check would fail for ever."""
    write_tree(tmp_path, tree_with(a_c="one\n", b_py="two\n"))
    (tmp_path / "mine.txt").write_text("mine")
    tree = tree_with(a_c="one\n")
    manifest, stale = check_tree(tmp_path, tree)
    assert "manifest.json differs" in manifest
    assert stale.endswith("b.py is not generated any more")
    assert foreign_files(tmp_path, tree) == [tmp_path / "mine.txt"]
    write_tree(tmp_path, tree)
    assert check_tree(tmp_path, tree) == []
    assert foreign_files(tmp_path, tree) == [tmp_path / "mine.txt"]


@pytest.fixture
def written(empty_cache: Path, tmp_path: Path) -> dict[str, str]:
    """Package n1, which lies in the folder ``n1``."""
    tree = generate_kind("n1", COMMITTED)
    write_tree(tmp_path / "n1", tree)
    return tree


@pytest.mark.parametrize(
    ("key", "cause"),
    [
        ("derivation", "changed: the derivation (symbolic/)"),
        ("templates", "changed: the templates (codegen/templates/)"),
        ("runtime", "changed: the plain source that goes along (runtime/)"),
        ("version", "changed: the version of kousoku, 0.0.1, is 0.1.0 now"),
        ("", "changed: what emits it (codegen/)"),
    ],
)
def test_a_difference_names_the_input_that_changed(
    written: dict[str, str], tmp_path: Path, key: str, cause: str
) -> None:
    """The folder is one that was generated before, of another input, with another kernels.h."""
    path = tmp_path / "n1" / "manifest.json"
    before = "/* of before */\n"
    manifest = json.loads(path.read_text(encoding="utf-8"))
    inputs = [[name, "0" * 16 if name == key else digest] for name, digest in manifest["inputs"]]
    digests = dict(manifest["files"]) | {"kernels.h": sha256(before)}
    manifest |= {"inputs": inputs, "files": list(digests.items())}
    manifest |= {"version": "0.0.1"} if key == "version" else {}
    path.write_text(json.dumps(manifest), encoding="utf-8")
    (tmp_path / "n1" / "kernels.h").write_text(before, encoding="utf-8")
    header, _ = check_tree(tmp_path / "n1", written)
    assert "kernels.h differs from line 1 on" in header
    assert header.endswith(cause)


def test_a_scene_that_changed_is_named_and_not_what_follows_from_it(tmp_path: Path) -> None:
    text = (SCENES / "pendulum.toml").read_text(encoding="utf-8")
    write_tree(tmp_path, generate_dynamics(scene_from_toml(text)))
    changed = text.replace("9.81", "9.80")
    assert changed != text
    for problem in check_tree(tmp_path, generate_dynamics(scene_from_toml(changed))):
        assert problem.endswith("; changed: the scene")


def test_a_difference_names_the_runtime_file_that_changed(
    written: dict[str, str], tmp_path: Path
) -> None:
    path = tmp_path / "n1" / "manifest.json"
    before = "# of before\n"
    manifest = json.loads(path.read_text(encoding="utf-8"))
    digests = dict(manifest["files"]) | {"batch_numpy.py": sha256(before)}
    path.write_text(json.dumps(manifest | {"files": list(digests.items())}), encoding="utf-8")
    (tmp_path / "n1" / "batch_numpy.py").write_text(before, encoding="utf-8")
    assert check_tree(tmp_path / "n1", written)[0].endswith("; changed: runtime/batch_numpy.py")


def test_a_long_line_is_shown_from_where_it_differs(tmp_path: Path) -> None:
    tree = tree_with(a_c="start, " * 30 + "here, " + "end, " * 30 + "\n")
    write_tree(tmp_path, tree)
    (tmp_path / "a.c").write_bytes(tree["a.c"].replace("here", "there").encode())
    (differs,) = check_tree(tmp_path, tree)
    old, new = differs.partition("line 1 on: ")[2].partition("; ")[0].split(" instead of ")
    assert (old[:3], new[:3]) == ("'… ", "'… ")
    assert "start, there, end" in old
    assert "start, here, end" in new


def test_what_differs_is_shown_rather_than_a_digest(tmp_path: Path) -> None:
    one, other = "0d64ff41541dfdbe", "87eeb8a25595d5e7"
    tree = tree_with(a_c=f'return "{one}";\n1.23456789012345678e-05\n')
    write_tree(tmp_path, tree)
    (tmp_path / "a.c").write_text(f'return "{other}";\n1.23456789012345679e-05\n')
    (differs,) = check_tree(tmp_path, tree)
    assert "from line 2 on: '1.23456789012345679e-05' instead of '1.23456789012345678" in differs
    (tmp_path / "a.c").write_text(f'return "{other}";\n1.23456789012345678e-05\n')
    (differs,) = check_tree(tmp_path, tree)
    assert f"from line 1 on: 'return \"{other}\";' instead of " in differs


def test_what_is_kept_compressed_counts_as_it_is_before(tmp_path: Path) -> None:
    tree = tree_with(a_json_gz="one\n")
    write_tree(tmp_path, tree)
    path = tmp_path / "a.json.gz"
    assert gzip.decompress(path.read_bytes()) == b"one\n"
    path.write_bytes(gzip.compress(b"one\n", compresslevel=1, mtime=7))
    assert check_tree(tmp_path, tree) == []
    assert write_tree(tmp_path, tree) == []
    path.write_bytes(gzip.compress(b"two\n"))
    (differs,) = check_tree(tmp_path, tree)
    assert differs.endswith(f"a.json.gz differs from line 1 on: 'two' instead of 'one'; {EDITED}")
    path.write_bytes(path.read_bytes()[:-3])
    (damaged,) = check_tree(tmp_path, tree)
    assert damaged.endswith("a.json.gz is damaged")
    assert write_tree(tmp_path, tree) == ["a.json.gz"]


def test_line_ends_are_bytes_too(tmp_path: Path) -> None:
    write_tree(tmp_path, tree_with(a_c="one\n"))
    (tmp_path / "a.c").write_bytes(b"one\r\n")
    assert len(check_tree(tmp_path, tree_with(a_c="one\n"))) == 1


def test_what_an_older_version_left_is_removed_and_a_users_file_is_not(tmp_path: Path) -> None:
    write_tree(tmp_path, tree_with(a_c="one\n", b_py="two\n"))
    (tmp_path / "mine.txt").write_text("mine")
    assert write_tree(tmp_path, tree_with(a_c="one\n")) == ["manifest.json", "b.py"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.c", "manifest.json", "mine.txt"]


@pytest.mark.parametrize(
    "text",
    [
        '{"files":[[3,4]]}',
        '{"files":[["nu\\u0000ll.c",""]]}',
        '{"files":[["folder",""]]}',
        '{"files":[["' + "x" * 5000 + '.c",""]]}',
        "[" * 90_000,
    ],
    ids=["number", "null", "folder", "long", "deep"],
)
def test_a_folder_with_any_manifest_is_written(tmp_path: Path, text: str) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "manifest.json").write_text(text)
    tree = tree_with(a_c="one\n")
    assert check_tree(tmp_path, tree)
    assert write_tree(tmp_path, tree) == ["a.c", "manifest.json"]
    assert (tmp_path / "folder").is_dir()


def test_a_manifest_cannot_remove_files_elsewhere(tmp_path: Path) -> None:
    outside = tmp_path / "outside.txt"
    outside.write_text("keep")
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "manifest.json").write_text(json.dumps({"files": [["../outside.txt", ""]]}))
    write_tree(folder, tree_with(a_c="one\n"))
    assert outside.exists()
