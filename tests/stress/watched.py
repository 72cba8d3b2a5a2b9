"""A watch over what strangers' files make this process do: code, files, memory, time."""

from __future__ import annotations

import os
import signal
import sys
import sysconfig
import tempfile
import time
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import numpy as np

from tests.stress.kit import ROOT, Disagreement

if TYPE_CHECKING:
    from collections.abc import Iterator

SECONDS = 5.0
"""Of processor time that an input may take."""

BYTES = 2**30
"""Of memory that an input may take."""

#: What runs something, whatever its arguments.
RUNS = (
    *("os.system", "os.exec", "os.fork", "os.forkpty", "os.posix_spawn", "os.spawn"),
    *("subprocess.Popen", "pty.spawn", "ctypes.dlopen", "pickle.find_class", "os.startfile"),
    *("socket.connect", "socket.bind", "urllib.Request", "webbrowser.open"),
)
#: What changes files, and which of its arguments are their names.
CHANGES = {
    "os.remove": 1,
    "os.rename": 2,
    "os.mkdir": 1,
    "os.rmdir": 1,
    "os.link": 2,
    "os.symlink": 2,
    "os.truncate": 1,
    "os.chmod": 1,
    "shutil.rmtree": 1,
}
#: What :func:`shutil.rmtree` does, and the library of Python alone with a folder that is open.
OF_TREES = ("os.remove", "os.rmdir")
WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
#: What makes classes of texts as modules are imported, or only reads them.
MAKERS = {"dataclasses", "collections", "ast", "typing"}
#: Where code of Python, of its packages and of kousoku stands.
LIBRARY = tuple(
    str(Path(place).resolve())
    for place in (sys.base_prefix, sys.prefix, *sysconfig.get_paths().values(), str(ROOT))
)
SYSTEM = ("/proc", "/sys", "/dev", "/usr", "/etc/localtime", "<frozen")


class Watch:
    """What was heard while an input was read: there is one, since hooks cannot be taken away."""

    def __init__(self) -> None:
        self.is_on = self.is_set = False
        self.places: tuple[str, ...] = ()
        self.heard: list[str] = []

    def hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Note an event that no file of a stranger may cause."""
        if not self.is_on:
            return
        self.is_on = False  # what follows is our own
        try:
            if what := self._wrong(event, arguments):
                self.heard.append(what)
        finally:
            self.is_on = True

    def _wrong(self, event: str, arguments: tuple[Any, ...]) -> str:
        if event in {"exec", "compile"} and sys._getframe(2).f_globals["__name__"] in MAKERS:
            return ""
        if event in RUNS:
            return f"{event} {arguments[0]!r:.80}"
        if event == "exec":
            file = str(getattr(arguments[0], "co_filename", "<unknown>"))
            return "" if self._is_within(file, *LIBRARY) else f"exec of {file}"
        if event == "compile":
            file = _name(arguments[1])
            return "" if self._is_within(file, *LIBRARY) else f"compile of {arguments[0]!r:.80}"
        if event == "open" and not isinstance(arguments[0], int):
            writes = isinstance(arguments[2], int) and arguments[2] & WRITES
            readable = () if writes else (*LIBRARY, *SYSTEM)
            is_right = self._is_within(_name(arguments[0]), *readable)
            return "" if is_right else f"open {'to write' * bool(writes)} {arguments[0]!r:.80}"
        if event in OF_TREES and isinstance(arguments[1], int) and arguments[1] >= 0:
            return ""  # a name within a folder that is open: shutil.rmtree has told which
        for name in arguments[: CHANGES.get(event, 0)]:
            if not isinstance(name, int) and not self._is_within(_name(name)):
                return f"{event} {name!r:.80}"
        return ""

    def _is_within(self, name: str, *more: str) -> bool:
        full = name if name.startswith("<") else str(Path(name).absolute())
        return full.startswith((*self.places, *more))


WATCH = Watch()


def _name(given: object) -> str:
    if isinstance(given, bytes):
        return os.fsdecode(given)
    return os.fspath(given) if isinstance(given, os.PathLike) else str(given)


@contextmanager
def watched(*places: Path) -> Iterator[None]:
    """Refuse code that runs, files outside of some places, much memory, and much time.

    Parameters
    ----------
    *places : Path
        Folders in which files may be read, written and, where they are Python, run.

    Raises
    ------
    Disagreement
        Something of it happened.
    """
    if not WATCH.is_set:
        sys.addaudithook(WATCH.hear)
        WATCH.is_set = True
    WATCH.places = tuple(str(place.absolute()) for place in places)
    WATCH.heard = []
    start = time.process_time()
    # what is imported here for the first time on this machine is none of an input's doing
    with patch.object(sys, "dont_write_bytecode", True), _bounded():
        WATCH.is_on = True
        try:
            yield
        finally:
            WATCH.is_on = False
    if WATCH.heard:
        raise Disagreement(f"it makes kousoku do: {WATCH.heard[0]}")
    if (took := time.process_time() - start) > SECONDS:
        raise Disagreement(f"it takes {took:.1f} s of processor time")


@contextmanager
def _bounded() -> Iterator[None]:
    """Let a block have so much time and memory, as far as the system can tell."""
    if sys.platform == "win32":
        yield
        return
    import resource

    def stop(*_: object) -> None:
        raise Disagreement(f"it takes more than {SECONDS:g} s of processor time")

    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    pages = Path("/proc/self/statm")
    if pages.exists():
        used = int(pages.read_text(encoding="ascii").split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + BYTES, hard))
    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
    try:
        yield
    except MemoryError:
        raise Disagreement(f"it takes more than {BYTES / 2**30:g} GiB of memory") from None
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


@cache
def warm() -> None:
    """Import and cache what any input needs, so that it is not taken for its own doing."""
    import kousoku as ks
    from kousoku.loading import generated
    from kousoku.model.reading.read import read_scene

    scenes = ROOT / "scenes"
    for name in ("lever_crank", "pendulum"):
        generated(read_scene(scenes / f"{name}.toml"))
        run = ks.load(scenes / f"{name}.toml", target="numpy").simulate(0.01, samples=2)
        with tempfile.TemporaryDirectory() as folder:
            run.save(Path(folder, "run.npz"))
            run.save(Path(folder, "run.csv"))
            found = ks.open_run(Path(folder, "run.npz"))
            found.animate(Path(folder, "run.html"))
        _ = repr(found), found._repr_html_(), str(found.ledger), np.linalg.norm([1.0])
