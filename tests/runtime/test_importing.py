"""Modules of a generated folder, imported from the bytes whose digests were compared."""

from __future__ import annotations

import sys
import traceback
from typing import TYPE_CHECKING

import pytest

from kousoku.model.errors import LoadError
from kousoku.runtime.importing import import_source

if TYPE_CHECKING:
    from pathlib import Path

FILES = {
    "__init__.py": b"raise AssertionError('the folder itself is not imported')",
    "solver.py": b"from .inner import twice\nfrom .inner.deep import HALF\nVALUE = twice(HALF)\n",
    "inner/__init__.py": b"from .deep import twice\n",
    "inner/deep.py": b"HALF = 21\ndef twice(x):\n    return x + x\n",
    "solver.c": b"int x;",
}


def test_a_module_finds_those_beside_it_and_in_folders(tmp_path: Path) -> None:
    assert import_source(tmp_path, FILES, "solver.py").VALUE == 42


def test_nothing_is_read_from_the_disk(tmp_path: Path) -> None:
    (tmp_path / "solver.py").write_text("VALUE = 'edited since'", encoding="utf-8")
    assert import_source(tmp_path, FILES, "solver.py").VALUE == 42


def test_the_same_bytes_are_one_module_and_others_are_another(tmp_path: Path) -> None:
    module = import_source(tmp_path, FILES, "solver.py")
    assert import_source(tmp_path, dict(FILES), "solver.py") is module
    other = FILES | {"inner/deep.py": FILES["inner/deep.py"].replace(b"21", b"4")}
    assert import_source(tmp_path, other, "solver.py").VALUE == 8
    assert module.VALUE == 42


def test_a_module_that_fails_is_not_kept_and_its_lines_are_shown(tmp_path: Path) -> None:
    files = {"solver.py": b"x = 1\nraise ValueError('here')\n"}
    for _ in range(2):
        with pytest.raises(ValueError, match="here") as caught:
            import_source(tmp_path, files, "solver.py")
        last = traceback.extract_tb(caught.value.__traceback__)[-1]
        assert (last.filename, last.line) == (
            str(tmp_path / "solver.py"),
            "raise ValueError('here')",
        )
    assert not [name for name in sys.modules if name.endswith(f"{tmp_path.name}.solver")]


def test_a_module_that_is_missing_is_told(tmp_path: Path) -> None:
    files = {name: data for name, data in FILES.items() if name != "inner/deep.py"}
    with pytest.raises(LoadError, match=r"inner/deep\.py is wanted, and its manifest does not"):
        import_source(tmp_path, files, "solver.py")


def test_a_module_of_others_that_is_missing_keeps_its_own_error(tmp_path: Path) -> None:
    with pytest.raises(ModuleNotFoundError, match="nowhere_to_be_found"):
        import_source(tmp_path, {"solver.py": b"import nowhere_to_be_found\n"}, "solver.py")
