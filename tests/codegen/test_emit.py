"""Emission: the folder as a whole."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.emit import emit
from kousoku.model.errors import EmitError
from kousoku.model.files.manifest import Manifest
from kousoku.model.operations.kernel import Package
from kousoku.runtime.batch_numpy import BLOCK
from kousoku.runtime.importing import import_source

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.operations.kernel import Package

ROOT = Path(__file__).parents[2]


@pytest.fixture
def folder(n1_package: Package) -> dict[str, str]:
    return emit(n1_package, {"reference.json.gz": "{}\n"})


def test_the_folder_has_the_files_that_the_house_names(folder: dict[str, str]) -> None:
    assert list(folder) == [
        "__init__.py",
        "kernels.py",
        "kernels.c",
        "kernels_batch.c",
        "expressions.h",
        "kernels.h",
        "batch_numpy.py",
        "lanes.h",
        "reference.json.gz",
        "manifest.json",
    ]


def test_the_manifest_holds_the_hash_of_every_other_file(folder: dict[str, str]) -> None:
    manifest = Manifest.from_json(folder["manifest.json"])
    hashes = {name: hashlib.sha256(text.encode()).hexdigest() for name, text in folder.items()}
    del hashes["manifest.json"]
    assert dict(manifest.files) == hashes


def test_the_library_the_module_and_the_manifest_have_one_digest(folder: dict[str, str]) -> None:
    digest = json.loads(folder["manifest.json"])["digest"]
    assert f'return "{digest}";' in folder["kernels.c"]
    assert f'DIGEST = "{digest}"' in folder["kernels.py"]


def test_no_line_is_long_or_ends_in_a_blank_and_every_file_ends_in_one_newline(
    folder: dict[str, str],
) -> None:
    for name, text in folder.items():
        assert text.endswith("\n") and not text.endswith("\n\n"), name
        for line in text.splitlines():
            assert line == line.rstrip(), (name, line)
            assert len(line) <= 100 or name in {"manifest.json", "lanes.h"}, (name, line)


def test_c_is_ascii_and_has_no_pow_no_heap_and_no_globals(folder: dict[str, str]) -> None:
    for name in ("kernels.c", "kernels_batch.c", "expressions.h", "kernels.h"):
        assert folder[name].isascii()
        for word in ("pow(", "malloc", "calloc", "alloca"):
            assert word not in folder[name]


def test_emitting_twice_gives_the_same_bytes(n1_package: Package, folder: dict[str, str]) -> None:
    assert emit(n1_package, {"reference.json.gz": "{}\n"}) == folder


def test_another_graph_has_another_digest(n1_package: Package, folder: dict[str, str]) -> None:
    kernel = replace(n1_package.kernels[0], results=((0,), (1, 1, 1)))
    other = emit(replace(n1_package, kernels=(kernel,)), {})
    assert json.loads(other["manifest.json"])["digest"] not in folder["kernels.c"]


@pytest.mark.parametrize("name", ["p2 z", "2p", "ä", "", "a-b", "x;int main"])
def test_a_name_that_is_no_identifier_is_refused(n1_package: Package, name: str) -> None:
    with pytest.raises(EmitError, match="cannot be emitted"):
        emit(replace(n1_package, name=name), {})


def test_generated_python_is_formatted_and_clean(folder: dict[str, str], tmp_path: Path) -> None:
    ruff = shutil.which("ruff", path=str(Path(sys.executable).parent)) or shutil.which("ruff")
    if ruff is None:
        pytest.skip("ruff is not installed")
    package = tmp_path / "generated" / "n1"
    package.mkdir(parents=True)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for name, text in folder.items():
        (package / name).write_text(text, encoding="utf-8")
    for command in (["format", "--check", "--diff"], ["check", "--no-cache"]):
        done = subprocess.run(
            [ruff, *command, "."], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    "name", ["kernels.c", "kernels_batch.c", "expressions.h", "kernels.py", "kernels.h"]
)
def test_text_of_n1(folder: dict[str, str], golden: Callable[[str], None], name: str) -> None:
    digest = json.loads(folder["manifest.json"])["digest"]
    golden(folder[name].replace(digest, "DIGEST").replace(digest[:16], "DIGEST"))


def load_module(folder: dict[str, str], tmp_path: Path) -> Any:
    """Emitted NumPy module."""
    return import_source(tmp_path, {n: t.encode() for n, t in folder.items()}, "kernels.py")


def test_numpy_batches_equal_single_evaluations_bit_for_bit(
    folder: dict[str, str], tmp_path: Path, rng: np.random.Generator
) -> None:
    module = load_module(folder, tmp_path)
    n = 2 * BLOCK + 3
    inputs = [rng.normal(size=(n, k)) for k in (4, 3, 4, 3)]
    values, vectors = module.constraint(*inputs)
    for k in (0, 1, BLOCK - 1, BLOCK, n - 1):
        value, vector = module.constraint(*[x[k].tolist() for x in inputs])
        assert value.tobytes() == values[k].tobytes()
        assert vector.tobytes() == vectors[k].tobytes()


def test_leading_axes_are_broadcast(
    folder: dict[str, str], tmp_path: Path, rng: np.random.Generator
) -> None:
    module = load_module(folder, tmp_path)
    p_i, a_i, a_j = rng.normal(size=(5, 1, 4)), rng.normal(size=3), rng.normal(size=(2, 3))
    p_j = rng.normal(size=4)
    value, vector = module.constraint(p_i, a_i, p_j, a_j)
    assert value.shape == (5, 2, 1) and vector.shape == (5, 2, 3)
    alone = module.constraint(p_i[3, 0], a_i, p_j, a_j[1], outputs=["C"])
    np.testing.assert_array_equal(value[3, 1], alone[0])
