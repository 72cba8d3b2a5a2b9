"""Columns of numbers as a file: CSV with all digits, or NumPy's own format."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.cache import write_atomically
from kousoku.model.errors import SolveError
from kousoku.runtime.given import shown

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy.typing as npt

    Array = npt.NDArray[np.float64]

#: Suffixes of files that results go to.
SUFFIXES = (".csv", ".npz")


def save_columns(table: Mapping[str, Array], path: str | Path) -> None:
    """Write columns to a ``.csv`` or ``.npz`` file, whole or not at all.

    A CSV file has one line of names, then one line a row with all digits of the doubles.

    Raises
    ------
    SolveError
        The name ends otherwise or is none, or the file cannot be written.
    """
    if not isinstance(path, str | os.PathLike):
        raise SolveError(f"{shown(path)} is no name of a file; wanted one")
    path = Path(path)
    if "\0" in str(path):
        raise SolveError(f"{shown(str(path))} is not the name of a file: it has a null character")
    if path.suffix not in SUFFIXES:
        raise SolveError(f"{path}: results go to a file that ends in {' or '.join(SUFFIXES)}")
    try:
        write_atomically(path, _csv(table) if path.suffix == ".csv" else _npz(table))
    except OSError as error:
        raise SolveError(f"{path}: cannot be written: {error.strerror or error}") from error


def _csv(table: Mapping[str, Array]) -> bytes:
    lines = [",".join(table)]
    rows = zip(*(column.tolist() for column in table.values()), strict=True)
    lines += [",".join(map(repr, row)) for row in rows]
    return ("\n".join(lines) + "\n").encode()


def _npz(table: Mapping[str, Array]) -> bytes:
    buffer = io.BytesIO()
    columns: dict[str, Any] = dict(table)
    np.savez(buffer, **columns)
    return buffer.getvalue()
