"""Loading a generated folder."""

from __future__ import annotations

import ctypes
import gzip
import logging
import shutil
import subprocess
import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
import pytest

from kousoku.model.errors import (
    CacheError,
    CompilerError,
    LoadError,
    NoCompilerError,
    TargetError,
)
from kousoku.model.files.manifest import Manifest
from kousoku.runtime import load
from kousoku.runtime.toolchain import EXTENSION
from tests.runtime.conftest import DIGEST, write_tiny

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from kousoku.runtime.choice import Target

pytestmark = pytest.mark.usefixtures("warm_cache")


@pytest.mark.usefixtures("compiler")
def test_auto_takes_c_where_there_is_a_compiler(tiny: Path) -> None:
    library = load(tiny)
    assert library.target == "c"
    assert library.path is not None
    assert library.path.suffix == EXTENSION
    assert load(str(tiny), target="c").path == library.path


def test_numpy_needs_no_compiler(tiny: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("KOUSOKU_CC", "/nowhere/cc")
    library = load(tiny, target="numpy")
    assert (library.target, library.path) == ("numpy", None)
    np.testing.assert_array_equal(library.sphere([1, 2, 3], 2)[0], [28.0])


def test_without_a_compiler_auto_takes_numpy_and_says_so_once(
    tiny: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("KOUSOKU_CC", "none")
    assert [load(tiny).target for _ in range(3)] == ["numpy"] * 3
    said = "kousoku uses the NumPy kernels: KOUSOKU_CC=none switches the C compiler off"
    assert caplog.record_tuples == [("kousoku", logging.WARNING, said)]


def test_without_a_compiler_c_is_refused(tiny: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("KOUSOKU_CC", "none")
    with pytest.raises(NoCompilerError, match="KOUSOKU_CC=none"):
        load(tiny, target="c")


def test_the_message_is_one_line_on_stderr_even_where_warnings_are_errors(tiny: Path) -> None:
    code = "import sys; from kousoku.runtime import load; load(sys.argv[1]); load(sys.argv[1])"
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", code, str(tiny)],
        capture_output=True,
        text=True,
        check=True,
        env={"KOUSOKU_CC": "none"},
    )
    assert run.stdout == ""
    assert run.stderr.count("\n") == 1


def test_an_unknown_target_is_refused(tiny: Path) -> None:
    wrong: Any = "fortran"
    with pytest.raises(TargetError, match="got 'fortran', wanted 'auto', 'c' or 'numpy'"):
        load(tiny, target=wrong)


def test_kernels_are_found_by_name(tiny: Path) -> None:
    library = load(tiny, target="numpy")
    assert library.sphere is library["sphere"] is library.kernels["sphere"]
    assert "sphere" in dir(library)
    with pytest.raises(AttributeError, match="tiny has no kernel 'cube'; it has sphere"):
        _ = library.cube
    with pytest.raises(KeyError, match="tiny has no kernel 'cube'; it has sphere"):
        library["cube"]


@pytest.mark.parametrize("target", ["auto", "c", "numpy"])
@pytest.mark.parametrize("name", ["kernels.c", "kernels.h", "kernels.py"])
def test_an_edited_file_is_named(tiny: Path, name: str, target: Target) -> None:
    with (tiny / name).open("a", encoding="utf-8") as file:
        file.write("\n")
    with pytest.raises(LoadError) as raised:
        load(tiny, target=target)
    message = str(raised.value)
    assert f"{tiny / name} was edited" in message
    assert "generate the package again: kousoku generate tiny" in message


def test_a_compressed_file_counts_by_what_it_holds(tiny: Path) -> None:
    path = tiny / "reference.json.gz"
    text = gzip.decompress(path.read_bytes())
    path.write_bytes(gzip.compress(text, compresslevel=1, mtime=7))
    assert load(tiny, target="numpy").kernels
    path.write_bytes(path.read_bytes() + b" ")
    with pytest.raises(LoadError, match="something follows its end"):
        load(tiny, target="numpy")
    path.write_bytes(gzip.compress(text + b"\n"))
    with pytest.raises(LoadError, match=r"reference\.json\.gz was edited"):
        load(tiny, target="numpy")


@pytest.mark.parametrize("keep", [0, 5, 40, -1])
def test_a_damaged_compressed_file_is_named(tiny: Path, keep: int) -> None:
    path = tiny / "reference.json.gz"
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(LoadError) as raised:
        load(tiny, target="numpy")
    assert f"{path} is damaged: reference.json.gz cannot be decompressed" in str(raised.value)
    assert "generate the package again: kousoku generate tiny" in str(raised.value)


def test_all_edited_and_missing_files_are_named(tiny: Path) -> None:
    (tiny / "kernels.c").unlink()
    (tiny / "kernels.py").write_text("", encoding="utf-8")
    with pytest.raises(LoadError) as raised:
        load(tiny)
    assert "kernels.c is missing" in str(raised.value)
    assert "kernels.py was edited" in str(raised.value)


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "null", '{"format": 99}', '{"format": 2}', '{"format": 2, "kernels": 3}'],
)
def test_what_is_no_manifest_is_refused(tiny: Path, text: str) -> None:
    (tiny / "manifest.json").write_text(text, encoding="utf-8")
    with pytest.raises(LoadError, match=r"manifest\.json is not a manifest of this version"):
        load(tiny)


def test_what_is_no_package_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LoadError, match="nowhere is not a generated package"):
        load(tmp_path / "nowhere")


@pytest.mark.parametrize("told", ["3", '["kernels.c"]', '["kernels.c", 3]', "[" * 90_000])
def test_a_manifest_whose_files_are_no_pairs_of_texts_is_refused(tiny: Path, told: str) -> None:
    """They are not under its digest."""
    path = tiny / "manifest.json"
    head, _, _ = path.read_text(encoding="utf-8").partition('"files":')
    path.write_text(f'{head}"files":[{told}]}}', encoding="utf-8")
    with pytest.raises(LoadError, match="is not a manifest of this version"):
        load(tiny, target="numpy")


def test_every_edit_of_a_manifest_is_caught(tiny: Path) -> None:
    """What it says is under its digest, what it lists under theirs; blanks that say nothing too."""
    path = tiny / "manifest.json"
    text = path.read_text(encoding="utf-8")
    for k, old in enumerate(text):
        for new in ("", chr(ord(old) ^ 1)):
            path.write_bytes((text[:k] + new + text[k + 1 :]).encode())
            with pytest.raises(LoadError):
                load(tiny, target="numpy")


def test_edited_manifest_is_named_with_the_command_that_makes_it_again(tiny: Path) -> None:
    path = tiny / "manifest.json"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace('"unit":"m2"', '"unit":"mm"'), encoding="utf-8")
    with pytest.raises(LoadError) as raised:
        load(tiny)
    assert str(raised.value) == (
        f"{path} was edited: its digest is not over what it says\n"
        "generate the package again: kousoku generate tiny"
    )


def test_the_command_of_an_edited_manifest_stays_on_one_line(tiny: Path) -> None:
    path = tiny / "manifest.json"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("kousoku generate", "kousoku\u2028generate"), encoding="utf-8")
    with pytest.raises(LoadError, match=r"kousoku\\u2028generate tiny$"):
        load(tiny)


def test_manifest_of_another_package_does_not_fit_the_sources(tiny: Path) -> None:
    """One whose own digest is right is still not what the module was emitted with."""
    path = tiny / "manifest.json"
    manifest = replace(Manifest.from_json(path.read_text(encoding="utf-8")), title="Other")
    other = replace(manifest, digest=manifest.stated())
    path.write_text(other.to_json(), encoding="utf-8")
    with pytest.raises(LoadError, match=f"has the digest {DIGEST}, the manifest beside it"):
        load(tiny, target="numpy")


@pytest.mark.parametrize(
    "name", ["../kernels.c", "/etc/passwd", "a/b/c.c", "a/../b.c", "a\\\\b.c", "..", ""]
)
def test_a_manifest_cannot_reach_outside_its_folder(tiny: Path, name: str) -> None:
    manifest = tiny / "manifest.json"
    text = manifest.read_text(encoding="utf-8").replace("kernels.c", name, 1)
    manifest.write_text(text, encoding="utf-8")
    with pytest.raises(LoadError, match="which is not a plain file name"):
        load(tiny)


def test_numpy_kernels_come_from_the_bytes_that_were_checked(tmp_path: Path) -> None:
    """Python's cache of compiled modules goes by date and size; a flipped sign changes neither."""
    write_tiny(tmp_path / "a")
    first = load(tmp_path / "a", target="numpy").sphere([1, 2, 3], 1)[0]
    write_tiny(tmp_path / "a", edit=lambda _, text: text.replace("x * x + y", "x * x - y"))
    second = load(tmp_path / "a", target="numpy").sphere([1, 2, 3], 1)[0]
    assert (first[0], second[0]) == (14.0, 6.0)
    assert not list((tmp_path / "a").glob("__pycache__"))


@pytest.mark.usefixtures("compiler")
def test_a_changed_source_gives_another_library(tmp_path: Path) -> None:
    plus = load(write_tiny(tmp_path / "a"))
    minus = load(
        write_tiny(tmp_path / "b", edit=lambda _, text: text.replace("+ r[2] *", "- r[2] *"))
    )
    assert plus.path != minus.path
    assert plus.sphere([1, 2, 3], 1)[0] == [14.0]
    assert minus.sphere([1, 2, 3], 1)[0] == [-4.0]


def with_library_of(folder: Path, edit: Callable[[str, str], str], tiny: Path) -> Path:
    """Put the library of an edited package, with its right digest, in the place of another."""
    foreign = load_path(write_tiny(folder, edit=edit))
    place = load_path(tiny)
    for path in foreign.parent.iterdir():
        shutil.copy(path, place.parent / path.name)
    return place


def load_path(folder: Path) -> Path:
    """Build a package in a process of its own, so that nothing of it is mapped in this one."""
    code = (
        "import sys; from kousoku.runtime.library import *\n"
        "from kousoku.runtime.build import *; from kousoku.runtime.toolchain import *\n"
        "source = Source('tiny', c_sources(Sources.read(sys.argv[1]).files))\n"
        "print(build(source, find_toolchain()).path)\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", code, str(folder)], capture_output=True, text=True, check=True
    )
    return type(folder)(run.stdout.strip())


@pytest.mark.usefixtures("compiler", "cache")
@pytest.mark.parametrize(
    ("old", "new", "difference"),
    [
        (DIGEST, "beef" * 16, f"it exports the digest {'beef' * 16}, the manifest wants {DIGEST}"),
        ("_tiny_digest", "_other_digest", "kousoku_tiny_digest"),
        ("r[3] length[1] -> C", "r[3] size[1] -> C", "sphere has the signature r[3] size[1]"),
        ('C_q[4]"', 'C_q[3]"', "-> C[1] C_q[3], the manifest wants r[3] length[1] -> C[1] C_q[4]"),
    ],
)
def test_a_foreign_or_stale_library_is_refused_with_a_sentence(
    tiny: Path, tmp_path: Path, old: str, new: str, difference: str
) -> None:
    place = with_library_of(tmp_path / "other", lambda _, text: text.replace(old, new), tiny)
    for target in ("auto", "c"):
        with pytest.raises(LoadError) as raised:
            load(tiny, target=target)
        assert str(raised.value).startswith(str(place.parent))
        assert " is not the library of the package 'tiny': " in str(raised.value)
        assert difference in str(raised.value)


@pytest.mark.usefixtures("compiler", "cache")
def test_a_truncated_library_is_never_opened(
    tiny: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = load_path(tiny)
    place.write_bytes(place.read_bytes()[:4096])
    opened: list[int] = []
    original = ctypes.CDLL

    def watched(name: str) -> ctypes.CDLL:
        opened.append(type(tiny)(name).stat().st_size)
        return original(name)

    monkeypatch.setattr(ctypes, "CDLL", watched)
    library = load(tiny)
    assert library.sphere([1, 2, 3], 2)[0] == [28.0]
    assert min(opened) > 4096
    assert "does not match its SHA-256: it was truncated or replaced" in library.damage
    assert [record.message for record in caplog.records] == [
        f"{library.damage}; it was built again"
    ]
    assert load(tiny).damage == ""


@pytest.mark.usefixtures("compiler", "cache")
@pytest.mark.parametrize("target", ["auto", "c"])
def test_a_build_with_fast_math_is_refused(
    tiny: Path, monkeypatch: pytest.MonkeyPatch, target: Target
) -> None:
    monkeypatch.setenv("KOUSOKU_CFLAGS", "-ffast-math")
    with pytest.raises(CompilerError, match="must not be compiled with -ffast-math") as raised:
        load(tiny, target=target)
    assert not isinstance(raised.value, NoCompilerError)


@pytest.mark.usefixtures("compiler")
def test_any_exported_function_can_be_had(tiny: Path) -> None:
    library = load(tiny)
    width = library.function("kousoku_tiny_lanes")
    width.restype = ctypes.c_size_t
    assert width() == library.sphere.lane_width == 4
    assert library.function("kousoku_tiny_lanes").restype is ctypes.c_int
    with pytest.raises(LoadError, match="exports no function 'kousoku_tiny_cube'"):
        library.function("kousoku_tiny_cube")


def test_the_numpy_target_has_no_c_functions(tiny: Path) -> None:
    with pytest.raises(LoadError, match="the target is NumPy, there is no C function 'f'"):
        load(tiny, target="numpy").function("f")


@pytest.mark.usefixtures("compiler")
def test_a_cache_that_cannot_be_written_means_a_temporary_folder_or_numpy(
    tiny: Path, cache: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache.write_text("a file in its place", encoding="utf-8")
    assert [load(tiny).target for _ in range(2)] == ["c"] * 2
    assert len(caplog.messages) == 1
    assert caplog.messages[0].startswith(f"cannot write the cache {cache}")

    def refuse() -> NoReturn:
        raise OSError("no room")

    monkeypatch.setattr("kousoku.runtime.build._own_shelf", refuse)
    assert [load(tiny).target for _ in range(2)] == ["numpy"] * 2
    assert len(caplog.messages) == 2
    assert caplog.messages[1].startswith(
        f"kousoku uses the NumPy kernels: cannot write the cache {cache}"
    )
    with pytest.raises(CacheError, match=r"nor a temporary folder: no room; .*KOUSOKU_CACHE"):
        load(tiny, target="c")
