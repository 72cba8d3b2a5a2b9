"""Folders and functions that a caller gives, refused in one line where they are none."""

from __future__ import annotations

import os
from pathlib import Path

from kousoku.model.errors import LoadError, SolveError
from kousoku.runtime.integrate.result import shown


def folder_of(given: object) -> Path:
    """Absolute path of a folder.

    Raises
    ------
    LoadError
        What is given is no path.
    """
    if not isinstance(given, str | os.PathLike):
        raise LoadError(f"{shown(given)} is no folder; wanted the path of one")
    if "\0" in str(given):
        raise LoadError(f"{shown(given)} is not the name of a folder: it has a null character")
    return Path(given).absolute()


def require_callable(scene: str, progress: object) -> None:
    """Refuse what cannot be called with the time reached and the last time.

    Raises
    ------
    SolveError
        It is something else.
    """
    if progress is not None and not callable(progress):
        raise SolveError(f"{scene}: progress {shown(progress)}; wanted a function of two times")
