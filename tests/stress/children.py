"""Processes that are forked from this one, and in which something goes wrong on purpose."""

from __future__ import annotations

import contextlib
import errno
import io
import json
import os
import signal
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kousoku.model.errors import KousokuError
from tests.stress.watched import CHANGES, WRITES

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    Work = Callable[[], str]
    Mishap = Callable[[], None]

CAN_FORK = hasattr(os, "fork")
FULL, READ_ONLY = errno.ENOSPC, errno.EROFS
#: What needs no room on a disk.
FREES = {"os.remove", "os.rmdir", "shutil.rmtree"}


@dataclass(frozen=True, slots=True)
class End:
    """How a process ended.

    Parameters
    ----------
    how : {"good", "refused", "foreign", "killed"}
        It did its work, kousoku refused to, something else was raised, or it was killed.
    text : str
        What the work gave, or the error.
    said : str
        What it wrote to its error stream.
    """

    how: str
    text: str
    said: str = ""


def begun(
    work: Work, mishap: Mishap | None = None, gate: tuple[int, int] | None = None
) -> tuple[int, int]:
    """Fork a process that does some work; return its id and where its end is read.

    Parameters
    ----------
    work : callable
        Returns a text.
    mishap : callable, optional
        Prepares what goes wrong in it.
    gate : pair of int, optional
        A pipe: it begins when all others have closed its end to write.
    """
    read, write = os.pipe()
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if child:
        os.close(write)
        return child, read
    try:
        os.close(read)
        if gate is not None:
            os.close(gate[1])
            os.read(gate[0], 1)
        os.write(write, json.dumps(_ended(work, mishap)).encode()[:60_000])
    finally:
        os._exit(0)


def _ended(work: Work, mishap: Mishap | None) -> list[str]:
    said = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        try:
            if mishap is not None:
                mishap()
            end = ["good", work()]
        except KousokuError as error:
            end = ["refused", str(error)[:2000]]
        except BaseException as error:
            end = ["foreign", f"{type(error).__name__}: {error}"[:2000]]
    return [*end, said.getvalue()[:4000]]


def ended(child: int, read: int) -> End:
    """End of a process, when it has ended."""
    with os.fdopen(read, "rb") as stream:
        data = stream.read()
    _, status = os.waitpid(child, 0)
    if not data:
        return End("killed", f"wait status {status}")
    return End(*json.loads(data))


def alone(work: Work, mishap: Mishap | None = None) -> End:
    """End of one process."""
    return ended(*begun(work, mishap))


def together(works: Sequence[Work]) -> list[End]:
    """Ends of processes that begin at once."""
    gate = os.pipe()
    running = [begun(work, gate=gate) for work in works]
    for end in gate:
        os.close(end)
    return [ended(*child) for child in running]


def _changes(event: str, arguments: tuple[Any, ...]) -> Iterator[str]:
    """Files that an event changes."""
    if event == "open" and isinstance(arguments[2], int) and arguments[2] & WRITES:
        yield str(arguments[0])
    for name in arguments[: CHANGES.get(event, 0)]:
        yield str(name)


def counting(found: list[int]) -> Mishap:
    """Mishap that counts changes of files, and lets them be."""

    def hear(event: str, arguments: tuple[Any, ...]) -> None:
        found[0] += any(True for _ in _changes(event, arguments))

    return lambda: sys.addaudithook(hear)


def killed_before(number: int) -> Mishap:
    """Mishap that kills the process before a change of a file, by its number."""
    left = [number]

    def hear(event: str, arguments: tuple[Any, ...]) -> None:
        if any(True for _ in _changes(event, arguments)):
            left[0] -= 1
            if left[0] < 0:
                os.kill(os.getpid(), signal.SIGKILL)

    return lambda: sys.addaudithook(hear)


def killed_just_after(number: int) -> Mishap:
    """Mishap that kills the process just after a change of a file, by its number."""
    left = [number]

    def hear(event: str, arguments: tuple[Any, ...]) -> None:
        left[0] -= any(True for _ in _changes(event, arguments))

    def returned(frame: object, event: str, function: object) -> None:
        if left[0] < 0 and event == "c_return":  # what was heard has been done
            os.kill(os.getpid(), signal.SIGKILL)

    def prepare() -> None:
        sys.addaudithook(hear)
        sys.setprofile(returned)

    return prepare


def killed_at_size(size: int) -> Mishap:
    """Mishap that kills the process while it writes a file, after so many bytes."""

    def prepare() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
        _limit(size)

    return prepare


def full_after(size: int) -> Mishap:
    """Mishap that lets no file have more bytes: writing fails half way."""
    return lambda: _limit(size)


def _limit(size: int) -> None:
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))


def full_from(number: int) -> Mishap:
    """Mishap that lets no file be made from some change on: there is no room for it."""
    left = [number]

    def hear(event: str, arguments: tuple[Any, ...]) -> None:
        for name in _changes(event, arguments):
            left[0] -= 1
            if left[0] < 0 and event not in FREES:
                raise OSError(FULL, os.strerror(FULL), name)
            break

    return lambda: sys.addaudithook(hear)


def read_only(folder: Path, *but: Path) -> Mishap:
    """Mishap that lets nothing in a folder be changed but in some others, also by root."""

    def hear(event: str, arguments: tuple[Any, ...]) -> None:
        for name in _changes(event, arguments):
            path = Path(name).absolute()
            if path.is_relative_to(folder) and not any(map(path.is_relative_to, but)):
                raise OSError(READ_ONLY, os.strerror(READ_ONLY), name)

    return lambda: sys.addaudithook(hear)
