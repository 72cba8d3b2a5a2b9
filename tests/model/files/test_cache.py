"""The cache folder of each platform, and files that are written whole or not at all."""

import errno
import os
import re
import sys
from pathlib import Path

import pytest

from kousoku.model.errors import CacheError
from kousoku.model.files.cache import (
    LARGEST_CACHE,
    SHELVES,
    cache_folder,
    size_limit,
    write_atomically,
)


def test_the_environment_chooses_the_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("KOUSOKU_CACHE", str(tmp_path))
    assert cache_folder() == tmp_path


def test_a_relative_choice_is_made_absolute(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("KOUSOKU_CACHE", "here")
    assert cache_folder() == tmp_path / "here"


@pytest.mark.parametrize(
    ("platform", "variable", "value", "wanted"),
    [
        ("linux", "XDG_CACHE_HOME", "/xdg", "/xdg/kousoku"),
        ("linux", "XDG_CACHE_HOME", "relative", "/home/me/.cache/kousoku"),
        ("linux", "XDG_CACHE_HOME", "", "/home/me/.cache/kousoku"),
        ("darwin", "XDG_CACHE_HOME", "/xdg", "/home/me/Library/Caches/kousoku"),
        ("win32", "LOCALAPPDATA", "/local", "/local/kousoku/Cache"),
        ("win32", "LOCALAPPDATA", "", "/home/me/AppData/Local/kousoku/Cache"),
    ],
)
def test_each_platform_has_its_own_place(
    monkeypatch: pytest.MonkeyPatch, platform: str, variable: str, value: str, wanted: str
) -> None:
    monkeypatch.delenv("KOUSOKU_CACHE", raising=False)
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setattr(Path, "home", lambda: Path("/home/me"))
    monkeypatch.setenv(variable, value)
    assert cache_folder() == Path(wanted)


def test_no_home_folder_is_an_error_that_names_the_variable(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def no_home() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("KOUSOKU_CACHE", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(Path, "home", no_home)
    with pytest.raises(OSError, match="set KOUSOKU_CACHE"):
        cache_folder()


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        ("", LARGEST_CACHE),
        ("1000", 1000),
        ("1G", 10**9),
        ("500 MB", 500 * 10**6),
        ("1.5k", 1500),
        ("2GiB", 2 * 1024**3),
        ("64mi", 64 * 1024**2),
        ("1T", 10**12),
    ],
)
def test_the_size_of_the_cache_has_units(
    monkeypatch: pytest.MonkeyPatch, given: str, wanted: int
) -> None:
    monkeypatch.setenv("KOUSOKU_CACHE_SIZE", given)
    assert size_limit() == wanted


@pytest.mark.parametrize(
    "given", ["much", "-1", "1Q", "1,5G", "1e9", "²", "G", "nan", "1\nG", "9" * 400]
)
def test_a_size_of_the_cache_that_says_nothing_is_refused(
    monkeypatch: pytest.MonkeyPatch, given: str
) -> None:
    monkeypatch.setenv("KOUSOKU_CACHE_SIZE", given)
    with pytest.raises(CacheError, match=r"KOUSOKU_CACHE_SIZE=.* 500M, 1\.5GB or 2GiB") as no:
        size_limit()
    assert "\n" not in str(no.value)


def test_a_file_is_replaced_and_no_temporary_stays(tmp_path: Path) -> None:
    path = tmp_path / "new" / "file.txt"
    write_atomically(path, b"one")
    write_atomically(path, b"two")
    assert path.read_bytes() == b"two"
    assert list(path.parent.iterdir()) == [path]


def test_a_write_that_fails_keeps_the_old_file(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path = tmp_path / "file.txt"
    write_atomically(path, b"old")

    def full(*_: object) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(OSError, match="No space left"):
        write_atomically(path, b"new")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(os.name != "posix", reason="rights of POSIX")
def test_disk_that_is_full_is_told_with_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The system names no file where a write fails, only where a file is opened."""

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fdopen", full)
    with pytest.raises(OSError, match="No space left on device") as raised:
        write_atomically(tmp_path / "a.txt", b"new")
    assert raised.value.filename == str(tmp_path / "a.txt")


def test_a_file_has_the_rights_of_an_ordinary_file(tmp_path: Path) -> None:
    path = tmp_path / "file.txt"
    write_atomically(path, b"data")
    ordinary = tmp_path / "ordinary.txt"
    ordinary.write_bytes(b"data")
    assert path.stat().st_mode == ordinary.stat().st_mode


def test_each_folder_that_sources_put_into_the_cache_is_one_that_is_cleared() -> None:
    root, found = Path(__file__).parents[3], set()
    for folder in ("codegen", "kousoku", "model", "runtime"):
        for path in (root / folder).rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            found |= set(re.findall(r'cache_folder\(\) / "(\w+)"', text))
    assert {"kernels", "scenes"} <= found <= set(SHELVES)
