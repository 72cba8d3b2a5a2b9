"""Build shared libraries into the per-user cache, once for each source and machine.

A library lies in a folder of its own, beside a file ``SHA256`` with its name and digest. The
folder's name is a hash of the sources, the compiler's version, the resolved target and the flags.
It is made elsewhere and renamed into place, so that it is there whole or not at all, whoever is
killed and however many build it at once; and nothing is loaded that does not match its SHA-256.
"""

from __future__ import annotations

import atexit
import errno
import hashlib
import os
import shutil
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from kousoku.model.errors import CacheError, CompilerError, NoCompilerError
from kousoku.model.files.cache import cache_folder
from kousoku.runtime.lock import locked
from kousoku.runtime.notice import say_once
from kousoku.runtime.toolchain import EXTENSION, LARGE, output, run

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Sequence

    from kousoku.runtime.toolchain import Toolchain

#: Seconds after which the folder of a build that was killed is swept away.
ABANDONED = 24 * 3600.0
_WORK = ".build-"
_DIGEST = "SHA256"
_NO_ROOM = (
    *(os.strerror(code) for code in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS)),
    "File size limit exceeded",
)
_TRIVIAL = b"#include <math.h>\ndouble half(double x);\ndouble half(double x) { return sqrt(x); }\n"


@dataclass(frozen=True, slots=True)
class Source:
    """Source of a library.

    Parameters
    ----------
    name : str
        The library's name.
    files : tuple of (str, bytes)
        Names and contents of C sources and headers. What ends in ``.c`` is compiled, what lies in a
        folder, as ``integrate/memory.h``, is there to be included.
    flags : tuple of str
        Compile flags beside the toolchain's.
    """

    name: str
    files: tuple[tuple[str, bytes], ...]
    flags: tuple[str, ...] = ()

    def key(self, toolchain: Toolchain) -> str:
        """SHA-256 of all that decides the bytes of the library."""
        key = hashlib.sha256(toolchain.fingerprint.encode())
        for text in (self.name, *self.flags):
            key.update(b"%d %s" % (len(text.encode()), text.encode()))
        for name, content in self.files:
            key.update(b"%d %s%d " % (len(name.encode()), name.encode(), len(content)))
            key.update(content)
        return key.hexdigest()


@dataclass(frozen=True, slots=True)
class Built:
    """A library that may be loaded.

    Parameters
    ----------
    path : Path
        The shared library.
    damage : str
        Damage of the library that lay there before; ``""`` if there was none.
    """

    path: Path
    damage: str = ""


def build(source: Source, toolchain: Toolchain) -> Built:
    """Library of a source, out of the cache or newly built.

    Raises
    ------
    CacheError
        It is not in the cache, and neither that nor a temporary folder can be written.
    CompilerError
        The compiler refuses the source; its whole output is in the message.
    NoCompilerError
        The compiler cannot build any library at all.
    """
    try:
        shelf = cache_folder() / "lib"
    except OSError as error:
        reason = f"there is no cache: {error}"
    else:
        entry = shelf / f"{source.name}-{source.key(toolchain)[:32]}"
        library, damage = _look(entry)
        if library is not None:
            return Built(library)
        try:
            return Built(_built(source, toolchain, entry), damage)
        except OSError as error:
            reason = f"cannot write the cache {shelf}: {error.strerror or error}"
            reason = f"{damage}; {reason}" if damage else reason
    advice = "free some space or set KOUSOKU_CACHE to a folder that can be written"
    try:
        entry = _own_shelf() / f"{source.name}-{source.key(toolchain)[:32]}"
        built = Built(_look(entry)[0] or _built(source, toolchain, entry))
    except OSError as error:
        reason = f"{reason}; nor a temporary folder: {error.strerror or error}; {advice}"
        raise CacheError(reason) from None
    say_once(f"{reason}; compiled in a temporary folder, for this process alone; {advice}")
    return built


def _built(source: Source, toolchain: Toolchain, entry: Path) -> Path:
    """Library of an entry, built here or meanwhile by another process."""
    entry.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    with locked(entry.with_suffix(".lock"), until=lambda: _look(entry)[0] is not None):
        library, _ = _look(entry)
        return library or _make(source, toolchain, entry)


@cache
def _own_shelf() -> Path:
    """Temporary folder of this process, gone at its end."""
    shelf, owner = Path(tempfile.mkdtemp(prefix="kousoku-")), os.getpid()

    def remove() -> None:
        if os.getpid() == owner:  # not where a process that was forked ends
            shutil.rmtree(shelf, ignore_errors=True)

    atexit.register(remove)
    return shelf


def _look(entry: Path) -> tuple[Path | None, str]:
    """Library of an entry if it is intact, else None and its damage."""
    try:
        expected, _, name = (entry / _DIGEST).read_text(encoding="ascii").strip().partition("  ")
        content = (entry / name).read_bytes()
    except (FileNotFoundError, NotADirectoryError):
        return None, f"{entry} lacks a file" if entry.exists() else ""
    except (OSError, ValueError) as error:
        return None, f"{entry} cannot be read: {error}"
    if hashlib.sha256(content).hexdigest() == expected:
        return entry / name, ""
    return None, f"{entry / name} does not match its SHA-256: it was truncated or replaced"


def _make(source: Source, toolchain: Toolchain, entry: Path) -> Path:
    """Compile in a folder of our own, then move the finished folder to its place."""
    _sweep(entry.parent)
    work = Path(tempfile.mkdtemp(prefix=_WORK, dir=entry.parent))
    try:
        finished = work / "finished"
        finished.mkdir()
        for name, content in source.files:
            (work / name).parent.mkdir(exist_ok=True)
            (work / name).write_bytes(content)
        # A name of its own, because a process that has opened a library gets the same one again
        # under that name, also where the file behind it has been damaged and built again.
        library = finished / f"{source.name}-{work.name.removeprefix(_WORK)}{EXTENSION}"
        _compile(source, toolchain, work, library)
        digest = hashlib.sha256(library.read_bytes()).hexdigest()
        (finished / _DIGEST).write_text(f"{digest}  {library.name}\n", encoding="ascii")
        return _publish(finished, entry)
    finally:
        shutil.rmtree(work, ignore_errors=True)


def _publish(finished: Path, entry: Path) -> Path:
    """Rename a folder into place; an intact one that is there already is as good."""
    for attempt in range(3):
        reason = ""
        try:
            finished.rename(entry)
        except OSError as error:
            reason = str(error)
        library, _ = _look(entry)
        if library is not None:
            return library
        with suppress(OSError):
            entry.rename(finished.parent / f"damaged{attempt}")
    raise OSError(reason or f"{entry} is damaged by somebody else")


def _sweep(shelf: Path) -> None:
    """Remove the folders of builds that were killed long ago."""
    for work in shelf.glob(f"{_WORK}*"):
        with suppress(OSError):
            if time.time() - work.stat().st_mtime > ABANDONED:
                shutil.rmtree(work, ignore_errors=True)


def _compile(source: Source, toolchain: Toolchain, work: Path, library: Path) -> None:
    sources = {name: text for name, text in source.files if name.endswith(".c") and "/" not in name}
    target = str(library.relative_to(work))
    is_large = max(map(len, sources.values())) > LARGE
    for command in toolchain.compile_commands([*sources], target, source.flags, is_large=is_large):
        process = run(command, cwd=str(work))
        if process.returncode == 0 and library.exists():
            return
    messages = output(process)
    if any(text in messages for text in _NO_ROOM):
        raise OSError(f"the compiler could not write its output; it said:\n{messages}")
    _check_compiler(toolchain, work)
    raise CompilerError(_refusal(f"refused {', '.join(sources)}", toolchain, command, process))


def _check_compiler(toolchain: Toolchain, work: Path) -> None:
    (work / "trivial.c").write_bytes(_TRIVIAL)
    command = toolchain.compile_command(["trivial.c"], f"trivial{EXTENSION}")
    process = run(command, cwd=str(work))
    if process.returncode != 0:
        raise NoCompilerError(_refusal("builds no shared library", toolchain, command, process))


def _refusal(
    failure: str,
    toolchain: Toolchain,
    command: Sequence[str],
    process: subprocess.CompletedProcess[bytes],
) -> str:
    return (
        f"{toolchain.name} {failure}\ncommand: {' '.join(command)}\n"
        f"exit status {process.returncode}; it said:\n{output(process)}\n"
        "(KOUSOKU_CC chooses another compiler; KOUSOKU_CC=none the NumPy kernels)"
    )
