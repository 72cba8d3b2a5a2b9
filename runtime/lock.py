"""A lock between processes that the operating system frees when its holder dies."""

from __future__ import annotations

import os
import sys
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

#: A holder that takes longer is not waited for: the lock saves work, it does not guard anything.
PATIENCE = 300.0


@contextmanager
def locked(path: Path, *, until: Callable[[], bool]) -> Iterator[None]:
    """Hold a lock file while the block runs, as far as the file system can.

    Returns early, without the lock, when ``until`` becomes true, when the holder is too slow, or
    where files cannot be locked.

    Raises
    ------
    OSError
        The lock file cannot be made.
    """
    handle = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o600)
    try:
        deadline = time.monotonic() + PATIENCE
        pause = 0.005
        while not _try_lock(handle) and not until() and time.monotonic() < deadline:
            time.sleep(pause)
            pause = min(2 * pause, 0.1)
        yield
    finally:
        os.close(handle)


if sys.platform == "win32":
    import msvcrt

    def _try_lock(handle: int) -> bool:
        """Whether the lock was taken; it is not while another process holds it."""
        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except PermissionError:
            return False
        except OSError:
            return True
        return True

else:
    import fcntl

    def _try_lock(handle: int) -> bool:
        """Whether the lock was taken; it is not while another process holds it."""
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:  # a file system without locks
            return True
        return True
