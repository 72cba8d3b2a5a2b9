"""Where kousoku keeps what it can make again, and how files are written whole or not at all."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path


def cache_folder() -> Path:
    r"""Return the per-user cache folder, which may not exist yet.

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
        _allow_what_the_umask_allows(temporary)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _home() -> Path:
    try:
        return Path.home()
    except RuntimeError as problem:
        raise OSError(f"no cache folder: {problem}; set KOUSOKU_CACHE to a folder") from problem


def _allow_what_the_umask_allows(path: str) -> None:
    """Give a temporary file, made for its owner alone, the rights of an ordinary file."""
    if os.name == "posix":
        mask = os.umask(0)
        os.umask(mask)
        Path(path).chmod(0o666 & ~mask)
