"""``kousoku generate`` and ``kousoku verify``: folders written, checked, and found wrong."""

from __future__ import annotations

import gzip
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.toolchain import Toolchain

    Run = Callable[..., tuple[int, str, str]]

LEVER = Path(__file__).parents[2] / "scenes" / "lever_crank.toml"
FILES = {
    "__init__.py",
    "kernels.py",
    "batch_numpy.py",
    "kernels.c",
    "kernels_batch.c",
    "expressions.h",
    "kernels.h",
    "lanes.h",
    "manifest.json",
}
#: What a scene has, of bodies or of nodes.
OF_SCENE = {"__init__.py", "solver.py", "solver.c", "solver.h", "integrate", "manifest.json"}


def names_in(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_kinds_and_scenes_go_into_folders_of_their_names(run: Run, tmp_path: Path) -> None:
    code, out, err = run("generate", "INPLANE", LEVER, "--out", tmp_path)
    assert (code, err) == (0, "")
    assert names_in(tmp_path) == {"n2", "lever_crank"}
    assert names_in(tmp_path / "n2") > FILES
    assert names_in(tmp_path / "lever_crank") > OF_SCENE
    assert "kernels.c" in out and "solver.c" in out
    assert "unchanged" in run("generate", "n2", "--out", tmp_path)[1]


def test_a_new_folder_is_that_of_one_package(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KOUSOKU_CC", "none")
    made = tmp_path / "made"
    for changed in (" more\n0 of 1 package unchanged", "1 of 1 package unchanged"):
        code, out, _ = run("generate", LEVER, "--out", made)
        assert code == 0 and changed in out
        assert names_in(made) > OF_SCENE
    assert run("generate", LEVER, "--out", made, "--check")[0] == 0
    program = "import made; made.solve(); print(made.__name__)"
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, check=False, capture_output=True, text=True
    )
    assert done.stdout == "made\n", done.stderr


def test_batches_of_a_copied_folder_compile_by_hand(
    run: Run, tmp_path: Path, compiler: Toolchain
) -> None:
    run("generate", "n1", "--out", tmp_path / "made")
    folder = shutil.copytree(tmp_path / "made", tmp_path / "copied")
    subprocess.run([*compiler.command, "-c", "kernels_batch.c"], cwd=folder, check=True)
    assert (folder / "kernels_batch.o").stat().st_size > 0


@pytest.mark.parametrize("name", ["n1", "lever_crank"])
def test_what_kousoku_ships_is_what_it_generates(run: Run, name: str) -> None:
    assert run("generate", name, "--check")[:2] == (0, "1 package, 0 files differ\n")


@pytest.mark.parametrize("name", ["p2", "p2_y"])
def test_a_kind_with_choices_of_rows_is_one_package(run: Run, tmp_path: Path, name: str) -> None:
    answer = json.loads(run("generate", name, "--out", tmp_path, "--json")[1])
    assert [Path(row["folder"]).name for row in answer["packages"]] == ["p2"]
    manifest = json.loads((tmp_path / "p2" / "manifest.json").read_text(encoding="utf-8"))
    names = [kernel["name"] for kernel in manifest["kernels"]]
    assert names[:3] == ["constraint_x", "rates_x", "reaction_x"] and len(names) == 9


def test_the_command_in_the_head_of_a_shipped_scene_works(run: Run, tmp_path: Path) -> None:
    head = (LEVER.parents[1] / "generated" / "lever_crank" / "solver.h").read_text("utf-8")
    command = next(line for line in head.splitlines() if "regenerate: " in line)
    run(*command.partition("regenerate: kousoku ")[2].split(), "--out", str(tmp_path))
    assert (tmp_path / "lever_crank" / "solver.h").read_text("utf-8") == head


def test_check_names_what_is_not_its_own(run: Run, tmp_path: Path) -> None:
    run("generate", "n1", "--out", tmp_path)
    mine = tmp_path / "n1" / "mine.txt"
    mine.write_text("mine", encoding="utf-8")
    data = tmp_path / "n1" / "data"
    data.mkdir()
    (data / "a.csv").write_text("mine", encoding="utf-8")
    (tmp_path / "n1" / "__pycache__").mkdir(exist_ok=True)
    code, _, err = run("generate", "n1", "--out", tmp_path, "--check")
    told = [f"{path} is not kousoku's own: it is left alone\n" for path in (data, mine)]
    assert (code, err) == (0, "".join(told))
    answer = json.loads(run("generate", "n1", "--out", tmp_path, "--check", "--json")[1])
    foreign = [str(data), str(mine)]
    assert answer == {"format": 1, "ok": True, "differences": [], "foreign": foreign}


def test_check_finds_an_edited_and_a_missing_file(run: Run, tmp_path: Path) -> None:
    check = ("generate", "n1", "--out", tmp_path, "--check")
    run("generate", "n1", "--out", tmp_path)
    assert run(*check)[0] == 0
    formulas = tmp_path / "n1" / "expressions.h"
    text = formulas.read_text(encoding="utf-8")
    formulas.write_text(text.replace("+", "-", 1), encoding="utf-8")
    (tmp_path / "n1" / "kernels.h").unlink()
    code, _, err = run(*check)
    assert code == 1
    for name in ("expressions.h", "kernels.h"):
        assert name in err
    assert not json.loads(run(*check, "--json")[1])["ok"]
    assert not (tmp_path / "n1" / "kernels.h").exists()


@pytest.mark.parametrize(
    ("target", "suffixes"),
    [("c", {".c", ".h", ".json", ".gz"}), ("numpy", {".py", ".json", ".gz"})],
)
def test_the_other_target_can_be_left_out(
    run: Run, tmp_path: Path, target: str, suffixes: set[str]
) -> None:
    assert run("generate", "n1", "--out", tmp_path, "--target", target)[0] == 0
    assert {Path(name).suffix for name in names_in(tmp_path / "n1")} == suffixes


def test_a_numpy_package_is_verified_without_c(run: Run, tmp_path: Path) -> None:
    run("generate", "n1", "--out", tmp_path, "--target", "numpy")
    code, out, _ = run("verify", tmp_path / "n1")
    assert code == 0
    assert "C is not checked" in out


@pytest.mark.parametrize("name", ["numpy", "class", "my loop", "json"])
def test_a_folder_that_python_could_not_import_is_refused(
    run: Run, tmp_path: Path, name: str
) -> None:
    code, _, err = run("generate", "n1", "--out", tmp_path / name)
    assert code == 2
    assert f"{name}: Python could not import the package: '{name}' " in err
    assert not (tmp_path / name).exists()


def test_the_folder_of_another_package_is_refused(run: Run, tmp_path: Path) -> None:
    folder = tmp_path / "made"
    assert run("generate", "n1", "--out", folder)[0] == 0
    code, _, err = run("generate", "n2", "--out", folder)
    assert code == 2
    assert f"{folder}: holds the package of n1, not of n2; choose another folder" in err
    assert run("generate", "n1", "--out", folder, "--check")[0] == 0


def test_an_installed_kousoku_has_nothing_to_check(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KOUSOKU_CACHE", str(tmp_path))
    for module in ("kousoku.cli.generate", "kousoku.cli.scenes"):
        monkeypatch.setattr(f"{module}.checkout", lambda: None)
    code, out, err = run("generate", "--check")
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert "nothing was generated in" in err and "make generate-check" in err


@pytest.mark.parametrize("name", ["n9", "missing.toml"])
def test_one_bad_name_and_nothing_is_written(run: Run, tmp_path: Path, name: str) -> None:
    code, out, err = run("generate", "n1", name, "--out", tmp_path)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1 and name in err
    assert not list(tmp_path.iterdir())


def test_what_kousoku_ships_keeps_both_targets(run: Run) -> None:
    code, _, err = run("generate", "n1", "--target", "c")
    assert code == 2 and "--out" in err


def test_verify_tells_the_worst_error_of_each_output(run: Run) -> None:
    code, out, err = run("verify", "n1", "--target", "numpy")
    assert (code, err) == (0, "")
    assert "C_q" in out and "units" in out


def test_verify_as_json_is_for_programs(run: Run) -> None:
    answer = json.loads(run("verify", "n1", "dot-2", "--target", "numpy", "--json")[1])
    assert answer["ok"] and answer["limit"] == 4.0
    assert [package["package"] for package in answer["packages"]] == ["n1", "n2"]
    assert all(row["worst"] <= row["limit"] for row in answer["packages"][0]["rows"])


def test_verify_fails_on_an_edited_reference(run: Run, tmp_path: Path) -> None:
    run("generate", "n1", "--out", tmp_path)
    reference = tmp_path / "n1" / "reference.json.gz"
    text = gzip.decompress(reference.read_bytes())
    reference.write_bytes(gzip.compress(text.replace(b"1", b"2", 1)))
    code, out, err = run("verify", tmp_path)
    assert code == 1
    assert "reference.json" in out + err


@pytest.mark.parametrize("name", ["n9", "no/such/folder", "docs"])
def test_verify_refuses_what_is_no_package(
    run: Run, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(LEVER.parents[1])
    code, out, err = run("verify", name)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1 and name in err


@pytest.mark.release
def test_all_that_is_committed_is_verified(run: Run) -> None:
    code, out, err = run("verify")
    assert (code, err) == (0, "")
    assert "WRONG" not in out
