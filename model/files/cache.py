"""The cache of files that kousoku can make again; files are written whole or not at all."""

from __future__ import annotations

import os
import re
import shutil
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from kousoku.model.errors import CacheError, printable

if TYPE_CHECKING:
    from collections.abc import Iterator

#: Folders of the cache: solvers of scenes, their keys by the bytes of a scene, derived kinds,
#: kernels of derivations of one's own, compiled libraries, sources that came with pickled objects,
#: and folders that a command was asked to generate.
SHELVES = ("scenes", "found", "derived", "kernels", "lib", "verified", "sources", "generated")
#: The folder of what the user asked for, which is not removed to make room.
ASKED_FOR = "generated"
#: Bytes that the cache may take, unless ``KOUSOKU_CACHE_SIZE`` says another number.
LARGEST_CACHE = 2 * 1024**3
#: A number of bytes as people write it: ``500M``, ``1.5 GB``, ``2GiB``.
_SIZE = re.compile(
    r" *([0-9]{1,18}(?:\.[0-9]{0,18})?) *(?:([kmgt])(i?))?b? *", re.ASCII | re.IGNORECASE
)
_POWERS = {"": 0, "k": 1, "m": 2, "g": 3, "t": 4}
#: An entry that was used so lately stays, since another process may be reading it [s].
RECENT = 600.0


@dataclass(frozen=True, slots=True)
class CacheEntry:
    """Entry of the cache under one key.

    Parameters
    ----------
    path : Path
        A folder, or a file.
    size : int
        Bytes.
    used : float [s]
        When it was made or found last, since the epoch.
    """

    path: Path
    size: int
    used: float

    @property
    def shelf(self) -> str:
        """The folder of the cache that it stands in."""
        return self.path.parent.name


def cache_folder() -> Path:
    r"""Per-user cache folder, which may not exist yet.

    ``KOUSOKU_CACHE`` wins; else it is the platform's own place: ``$XDG_CACHE_HOME/kousoku`` or
    ``~/.cache/kousoku``, ``~/Library/Caches/kousoku`` on macOS, ``%LOCALAPPDATA%\kousoku\Cache``
    on Windows.

    Raises
    ------
    OSError
        The platform knows no home folder; callers go on without a cache, as with a full one.
    """
    chosen = os.environ.get("KOUSOKU_CACHE")
    if chosen:
        return Path(chosen).absolute()
    if sys.platform == "win32":
        local = os.environ.get("LOCALAPPDATA")
        return (Path(local) if local else _home() / "AppData" / "Local") / "kousoku" / "Cache"
    if sys.platform == "darwin":
        return _home() / "Library" / "Caches" / "kousoku"
    xdg = os.environ.get("XDG_CACHE_HOME", "")
    # The XDG specification tells programs to ignore a relative path.
    return (Path(xdg) if Path(xdg).is_absolute() else _home() / ".cache") / "kousoku"


def write_atomically(path: Path, data: bytes) -> None:
    """Write a file so that a reader, or a crash, finds the old file or the new one, never half.

    Missing parent folders are made.

    Raises
    ------
    OSError
        The folder cannot be written; nothing is left behind.
    """
    try:
        _write(path, data)
    except OSError as error:
        if error.errno is not None and error.filename is None:  # as where the disk is full
            error.filename = str(path)
        raise


def _write(path: Path, data: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        _grant_ordinary_rights(temporary)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _home() -> Path:
    try:
        return Path.home()
    except RuntimeError as problem:
        raise OSError(f"no cache folder: {problem}; set KOUSOKU_CACHE to a folder") from problem


def _grant_ordinary_rights(path: str) -> None:
    """Grant a temporary file, made for its owner alone, the rights that the umask allows."""
    if os.name == "posix":
        mask = os.umask(0)
        os.umask(mask)
        Path(path).chmod(0o666 & ~mask)


def touch(path: Path) -> None:
    """Note that an entry was used."""
    with suppress(OSError):
        os.utime(path)


def entries() -> list[CacheEntry]:
    """Entries of the cache, the longest unused first."""
    root = cache_folder()
    in_shelves = [entry for shelf in SHELVES for entry in _entries_of(root / shelf)]
    return sorted(in_shelves, key=lambda entry: (entry.used, entry.path))


def _entries_of(shelf: Path) -> Iterator[CacheEntry]:
    with suppress(OSError):
        for path in sorted(shelf.iterdir()):
            if path.name.startswith(".") or path.suffix == ".lock":
                continue
            with suppress(OSError):
                used = path.stat().st_mtime
                files = (file for file in path.rglob("*") if file.is_file())
                size = sum(file.stat().st_size for file in files) if path.is_dir() else 0
                yield CacheEntry(path, size or path.stat().st_size, used)


def size_limit() -> int:
    """Bytes that the cache may take: :data:`LARGEST_CACHE`, or what ``KOUSOKU_CACHE_SIZE`` is.

    That is a number of bytes, or one with a unit: k, M, G and T are powers of 1000, Ki, Mi, Gi and
    Ti powers of 1024; a ``B`` may follow, and case does not count.

    Raises
    ------
    CacheError
        The variable holds no such number.
    """
    setting = os.environ.get("KOUSOKU_CACHE_SIZE", "")
    if not setting.strip():
        return LARGEST_CACHE
    match = _SIZE.fullmatch(setting)
    if match is None:
        shown = printable(setting if len(setting) <= 40 else f"{setting[:40]}…")
        raise CacheError(
            f"KOUSOKU_CACHE_SIZE={shown}: wanted a number of bytes, alone or with a unit, such as"
            " 500M, 1.5GB or 2GiB"
        )
    number, unit, binary = match.groups(default="")
    return int(float(number) * (1024 if binary else 1000) ** _POWERS[unit.lower()])


def shrink(limit: int | None = None) -> list[CacheEntry]:
    """Remove the longest unused entries until the rest is within the limit.

    Parameters
    ----------
    limit : int, optional
        Bytes that may stay; :func:`size_limit` unless given.

    Returns
    -------
    list of CacheEntry
        The entries that were removed.
    """
    limit = size_limit() if limit is None else limit
    kept = [entry for entry in entries() if entry.shelf != ASKED_FOR]
    size, latest = sum(entry.size for entry in kept), time.time() - RECENT
    removed = []
    for entry in kept:
        if size <= limit or entry.used > latest:
            break
        if _remove(entry.path):
            size -= entry.size
            removed.append(entry)
    return removed


def clear() -> list[CacheEntry]:
    """Remove all entries; return those that were removed."""
    return [entry for entry in entries() if _remove(entry.path)]


def _remove(path: Path) -> bool:
    """Remove an entry at once: no process finds a part of it."""
    try:
        if path.is_dir() and not path.is_symlink():
            gone = path.with_name(f".gone-{os.getpid()}-{path.name}")
            path.rename(gone)
            shutil.rmtree(gone, ignore_errors=True)
        else:
            path.unlink()
    except OSError:
        return False
    return True
