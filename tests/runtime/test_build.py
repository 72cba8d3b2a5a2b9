"""The cache of compiled libraries: whole or not at all, and never another machine's."""

from __future__ import annotations

import errno
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from ctypes import CDLL
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import pytest

from kousoku.model.errors import CacheError, CompilerError, NoCompilerError
from kousoku.runtime.build import ABANDONED, Source, build
from kousoku.runtime.toolchain import EXTENSION, GCC, LARGE, Toolchain, find_toolchain, probe

if TYPE_CHECKING:
    from collections.abc import Callable

SOURCE = Source("seven", (("seven.c", b"int seven(void);\nint seven(void) { return 7; }\n"),))


def entries(cache: Path) -> list[Path]:
    """Folders of libraries and of builds."""
    return sorted(path for path in (cache / "lib").iterdir() if path.is_dir())


def test_a_library_lies_beside_its_digest(cache: Path, compiler: Toolchain) -> None:
    built = build(SOURCE, compiler)
    assert CDLL(str(built.path)).seven() == 7
    assert built.damage == ""
    (entry,) = entries(cache)
    assert sorted(entry.iterdir()) == sorted([entry / "SHA256", built.path])
    digest = hashlib.sha256(built.path.read_bytes()).hexdigest()
    listed = (entry / "SHA256").read_text(encoding="ascii")
    assert listed == f"{digest}  {built.path.name}\n"  # as sha256sum --check reads it


@pytest.mark.usefixtures("cache")
@pytest.mark.parametrize("more", [0, 1])
@pytest.mark.parametrize("refused", ["-flto", "-nothing"])
def test_what_is_large_is_compiled_with_fewer_passes(
    wrapper: Callable[[str], str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    more: int,
    refused: str,
) -> None:
    name, text = SOURCE.files[0]
    large = Source("seven", ((name, text.ljust(LARGE + more)),))
    log = tmp_path / "log"
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    monkeypatch.setenv(
        "KOUSOKU_CC",
        wrapper(f'echo "$@" >> {log}; case "$*" in *{refused}*) exit 1;; esac'),
    )

    assert CDLL(str(build(large, find_toolchain()).path)).seven() == 7

    asked = [line for line in log.read_text(encoding="utf-8").splitlines() if "seven.c" in line]
    assert ["-O1" in line for line in asked] == [more == 1] * len(asked)
    if GCC in find_toolchain().version:
        tried = {"-flto": [True, False], "-nothing": [True]}[refused]
        assert ["-flto" in line for line in asked] == (tried if more else [False])


@pytest.mark.usefixtures("cache")
def test_a_library_is_built_once(
    wrapper: Callable[[str], str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    log = tmp_path / "log"
    monkeypatch.setenv("KOUSOKU_CC", wrapper(f'echo "$@" >> {log}'))
    toolchain = find_toolchain()
    probes = len(log.read_text(encoding="utf-8").splitlines())
    assert build(SOURCE, toolchain) == build(SOURCE, toolchain)
    assert len(log.read_text(encoding="utf-8").splitlines()) == probes + 1


@pytest.mark.usefixtures("cache")
@pytest.mark.parametrize(
    "other",
    [
        Source("eight", SOURCE.files),
        Source("seven", (("seven.c", SOURCE.files[0][1] + b"\n"),)),
        Source("seven", (*SOURCE.files, ("seven.h", b""))),
        Source("seven", SOURCE.files, ("-DX",)),
    ],
)
def test_any_change_of_a_source_gives_another_library(other: Source, compiler: Toolchain) -> None:
    assert build(other, compiler).path != build(SOURCE, compiler).path


def test_a_library_built_for_other_processor_features_is_not_taken(
    cache: Path, wrapper: Callable[..., str]
) -> None:
    fake = 'for a in "$@"; do [ "$a" = -dM ] && echo "#define __OTHER_FEATURE__ 1"; done'
    here, elsewhere = probe((wrapper("", "a"),), ()), probe((wrapper(fake, "b"),), ())
    paths = {build(SOURCE, here).path, build(SOURCE, elsewhere).path}
    assert len(paths) == len(entries(cache)) == 2
    # Damage to the one built elsewhere cannot reach this machine: it is not even looked at.
    build(SOURCE, elsewhere).path.write_bytes(b"not a library")
    assert CDLL(str(build(SOURCE, here).path)).seven() == 7


@pytest.mark.parametrize("length", [0, 100, -1])
def test_a_truncated_library_is_not_loaded_but_built_again(
    cache: Path, compiler: Toolchain, length: int
) -> None:
    path = build(SOURCE, compiler).path
    path.write_bytes(path.read_bytes()[:length])
    again = build(SOURCE, compiler)
    assert "does not match its SHA-256: it was truncated or replaced" in again.damage
    assert CDLL(str(again.path)).seven() == 7
    assert len(entries(cache)) == 1
    assert build(SOURCE, compiler).damage == ""


@pytest.mark.parametrize("left", ["SHA256", EXTENSION])
@pytest.mark.usefixtures("cache")
def test_half_an_entry_is_built_again(compiler: Toolchain, left: str) -> None:
    for path in build(SOURCE, compiler).path.parent.iterdir():
        if not path.name.endswith(left):
            path.unlink()
    again = build(SOURCE, compiler)
    assert "lacks a file" in again.damage
    assert CDLL(str(again.path)).seven() == 7


@pytest.mark.usefixtures("cache")
def test_another_library_in_its_place_is_not_loaded(compiler: Toolchain) -> None:
    other = Source("eight", (("eight.c", b"int seven(void);\nint seven(void) { return 8; }\n"),))
    path = build(SOURCE, compiler).path
    shutil.copy(build(other, compiler).path, path)
    assert CDLL(str(build(SOURCE, compiler).path)).seven() == 7


def test_the_compilers_own_words_are_shown_whole(cache: Path, compiler: Toolchain) -> None:
    broken = Source("broken", (("broken.c", b'#error "first"\nint x = "second;\n'),))
    with pytest.raises(CompilerError, match=r"refused broken\.c") as raised:
        build(broken, compiler)
    message = str(raised.value)
    for text in (
        '#error "first"',
        "second",
        "broken.c:2",
        compiler.name,
        "command: ",
        "KOUSOKU_CC",
    ):
        assert text in message
    assert not isinstance(raised.value, NoCompilerError)
    assert entries(cache) == []


def test_a_compiler_that_cannot_link_counts_as_none(
    cache: Path, wrapper: Callable[[str], str]
) -> None:
    code = 'for a in "$@"; do [ "$a" = -o ] && { echo "no linker here" >&2; exit 1; }; done'
    with pytest.raises(NoCompilerError, match=r"builds no shared library[\s\S]*no linker here"):
        build(SOURCE, probe((wrapper(code),), ()))
    assert entries(cache) == []


def test_a_cache_that_cannot_be_written_is_told_and_done_without(
    cache: Path, compiler: Toolchain, caplog: pytest.LogCaptureFixture
) -> None:
    cache.mkdir()
    (cache / "lib").write_text("in the way", encoding="utf-8")
    first, second = build(SOURCE, compiler), build(SOURCE, compiler)
    assert first == second
    assert first.path.is_file() and cache not in first.path.parents
    (said,) = caplog.messages
    assert re.match(r"cannot write the cache .*lib: .*compiled in a temporary folder, for", said)
    assert "KOUSOKU_CACHE" in said


def test_the_temporary_folder_is_gone_when_the_process_ends(tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("in the way", encoding="utf-8")
    code = "from kousoku.runtime import build; print(build._own_shelf())"
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert Path(done.stdout.strip()).parent == tmp_path
    assert [path.name for path in tmp_path.iterdir()] == ["cache"]


@pytest.mark.usefixtures("cache")
@pytest.mark.parametrize("code", [errno.EROFS, errno.ENOSPC, errno.EACCES, errno.EDQUOT])
def test_every_reason_not_to_write_is_told(
    compiler: Toolchain, monkeypatch: pytest.MonkeyPatch, code: int
) -> None:
    def refuse(**_: object) -> NoReturn:
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(tempfile, "mkdtemp", refuse)
    new = Source("never_built", SOURCE.files)  # not in the temporary folder of other tests
    with pytest.raises(CacheError, match=os.strerror(code)):
        build(new, compiler)


def test_a_compiler_that_runs_out_of_space_is_the_caches_fault(
    cache: Path, wrapper: Callable[[str], str]
) -> None:
    code = (
        'for a in "$@"; do [ "$a" = -o ] &&'
        ' { echo "as: BFD: lib.so: No space left on device" >&2; exit 1; }; done'
    )
    with pytest.raises(CacheError, match=r"BFD: lib\.so: No space left on device"):
        build(SOURCE, probe((wrapper(code),), ()))
    assert entries(cache) == []


def test_a_library_in_a_read_only_cache_is_used(
    cache: Path, compiler: Toolchain, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = build(SOURCE, compiler)

    def refuse(*_: object, **__: object) -> NoReturn:
        raise PermissionError(errno.EROFS, os.strerror(errno.EROFS))

    for name in ("mkdir", "rename", "write_bytes", "write_text"):
        monkeypatch.setattr(Path, name, refuse)
    monkeypatch.setattr(tempfile, "mkdtemp", refuse)
    monkeypatch.setattr(os, "open", refuse)
    assert build(SOURCE, compiler) == first, cache


def test_without_a_home_there_is_no_cache(
    compiler: Toolchain, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def no_home() -> NoReturn:
        raise OSError("no home folder")

    monkeypatch.setattr("kousoku.runtime.build.cache_folder", no_home)
    assert build(SOURCE, compiler).path.is_file()
    assert caplog.messages[0].startswith("there is no cache: no home folder; compiled in a temp")


@pytest.mark.usefixtures("cache")
def test_one_that_was_built_meanwhile_is_as_good(
    compiler: Toolchain, monkeypatch: pytest.MonkeyPatch
) -> None:
    rename = Path.rename
    built: list[int] = []

    def late(self: Path, target: Path) -> Path:
        if not built:
            monkeypatch.setattr(Path, "rename", rename)
            shutil.copytree(self, target)
            built.append(target.stat().st_ino)
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", late)
    assert build(SOURCE, compiler).path.parent.stat().st_ino == built[0]


def test_folders_of_builds_that_were_killed_are_swept_away_later(
    cache: Path, compiler: Toolchain
) -> None:
    old, new = cache / "lib" / ".build-old", cache / "lib" / ".build-new"
    for folder in (old, new):
        folder.mkdir(parents=True)
    then = time.time() - ABANDONED - 60
    os.utime(old, (then, then))
    build(SOURCE, compiler)
    assert not old.exists()
    assert new.exists()


@pytest.mark.skipif(sys.platform == "win32", reason="permissions of POSIX")
def test_nobody_else_may_write_into_the_cache(cache: Path, compiler: Toolchain) -> None:
    path = build(SOURCE, compiler).path
    for folder in (cache / "lib", path.parent.parent):
        assert folder.stat().st_mode & 0o022 == 0
