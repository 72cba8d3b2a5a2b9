"""Solvers of scenes as texts, and a small package by hand: loading without the generator."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from kousoku.model.files.compressed import stored
from kousoku.model.files.manifest import REFERENCE_FILE, KernelManifest, Manifest
from kousoku.model.files.quantity import Quantity
from kousoku.model.reading.read import scene_from_toml
from kousoku.runtime import load, notice, plan, toolchain
from kousoku.runtime.dynamics import load_dynamics

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime import Library
    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.toolchain import Toolchain

_PLAN_TYPE = plan.plan_type
TINY = Path(__file__).parent / "tiny"
SPHERE = KernelManifest(
    name="sphere",
    title="squared distance",
    formula="C = length r.r",
    source="",
    inputs=(Quantity("r", (3,), "m", "point"), Quantity("length", (), "m", "length")),
    outputs=(Quantity("C", (1,), "m3", "value"), Quantity("C_q", (1, 4), "m2", "derivative")),
    nonzero=((0,), (0, 1, 2)),
    is_exact=True,
    operations=(("mul", 7), ("add", 3)),
)


SAID = Manifest("tiny", "Tiny", "kousoku generate tiny", "0", "", (), (), (SPHERE,))
DIGEST = SAID.stated()
POINTS: dict[str, list[float]] = {
    "ordinary": [0.1, -1.7, 0.3, 2.3],
    "small": [1e-160, 1e-170, 3.0, 1e-120],
    "zero": [0.0, 1.0, -1.0, 0.7],
    "infinite": [1.0, math.inf, 2.0, 1.5],
    "NaN": [1.0, 2.0, 2.0, math.nan],
}


@pytest.fixture(name="load")
def load_in_c(compiler: Toolchain, bodies_folder: Callable[..., Path]) -> Callable[..., Any]:
    """Function that makes the compiled solver of a scene with outputs."""
    return lambda scene, *outputs: load_dynamics(bodies_folder(scene, outputs), target="c")


@pytest.fixture
def solver_of(compiler: Toolchain, bodies_folder: Callable[..., Path]) -> Callable[..., Any]:
    """Function that makes a solver of a text."""
    assert compiler

    def solver(text: str, target: Any = "c") -> DynamicsSolver:
        scene = scene_from_toml(text)
        return load_dynamics(bodies_folder(scene, scene.outputs), target=target)

    return solver


def sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def reference() -> dict[str, Any]:
    """Reference values in exact arithmetic."""
    points = []
    for label, numbers in POINTS.items():
        r, length = numbers[:3], numbers[3]
        C = [_expected(numbers, [(1, (3, k, k)) for k in range(3)])]
        C_q = [_expected(numbers, [(2, (3, k))]) for k in range(3)]
        inputs = {"r": [_json(x) for x in r], "length": [_json(length)]}
        points.append(
            {"label": label, "inputs": inputs, "outputs": {"C": _columns(C), "C_q": _columns(C_q)}}
        )
    return {"format": 1, "package": "tiny", "kernels": [{"name": "sphere", "points": points}]}


def _expected(
    numbers: list[float], terms: list[tuple[int, tuple[int, ...]]]
) -> tuple[float | None, float, float]:
    """High, low and unit of a sum of (factor, places of the numbers multiplied)."""
    if not all(math.isfinite(numbers[place]) for _, places in terms for place in places):
        return None, 0.0, 5e-324
    values = []
    for factor, places in terms:
        value = Fraction(factor)
        for place in places:
            value *= Fraction(numbers[place])
        values.append(value)
    total = sum(values, Fraction(0))
    size = abs(total) + sum(
        (abs(v) * len(places) for v, (_, places) in zip(values, terms, strict=True)), Fraction(0)
    )
    high = float(total)
    return high, float(total - Fraction(high)), max(float(size / 2**53), 5e-324)


def _columns(elements: list[tuple[float | None, float, float]]) -> dict[str, Any]:
    names = ("high", "low", "unit")
    return {name: [element[k] for element in elements] for k, name in enumerate(names)}


def _json(x: float) -> float | str:
    return x if math.isfinite(x) else str(x)


def write_tiny(
    folder: Path,
    *,
    edit: Callable[[str, str], str] = lambda name, text: text,
    said: Manifest = SAID,
) -> Path:
    """Write the package as the generator would; ``edit`` changes a file before it is listed."""
    said = replace(said, digest=said.stated())
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    texts = {p.name: p.read_text(encoding="utf-8") for p in sorted(TINY.glob("kernels*"))}
    for name, text in texts.items():
        data = edit(name, text.replace("=DIGEST=", said.digest)).encode()
        (folder / name).write_bytes(data)
        files.append((name, sha256(data)))
    numbers = json.dumps(reference())
    (folder / REFERENCE_FILE).write_bytes(stored(REFERENCE_FILE, numbers))
    files.append((REFERENCE_FILE, sha256(numbers.encode())))
    text = replace(said, files=tuple(files)).to_json()
    (folder / "manifest.json").write_text(text, encoding="utf-8")
    return folder


def unlist(folder: Path, name: str) -> None:
    """Leave a file out of the manifest, whose digest is not over the files."""
    path = folder / "manifest.json"
    manifest = Manifest.from_json(path.read_text(encoding="utf-8"))
    files = tuple(listed for listed in manifest.files if listed[0] != name)
    path.write_text(replace(manifest, files=files).to_json(), encoding="utf-8")


@pytest.fixture
def cache(empty_cache: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Empty cache folder; only the library of the package is built into it."""
    monkeypatch.setattr(plan, "plan_type", lambda _: None)
    return empty_cache


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    """Folder of the small package."""
    return write_tiny(tmp_path / "tiny")


@pytest.fixture(scope="session")
def warm_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Cache folder that all tests of this run share."""
    return tmp_path_factory.mktemp("cache")


@pytest.fixture
def warm_cache(
    request: pytest.FixtureRequest, warm_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Use the shared cache, for tests that are not about the cache."""
    if "cache" not in request.fixturenames:
        monkeypatch.setenv("KOUSOKU_CACHE", str(warm_folder))


@pytest.fixture
def wrapper(tmp_path: Path, compiler: Toolchain) -> Callable[[str], str]:
    """Function that writes a compiler: shell code, then the real compiler."""

    def write(code: str, name: str = "wrapped-cc") -> str:
        real = " ".join(compiler.command)
        path = tmp_path / name
        path.write_text(f'#!/bin/sh\n{code}\nexec {real} "$@"\n', encoding="utf-8")
        path.chmod(0o755)
        return str(path)

    return write


@pytest.fixture(autouse=True)
def forgotten(request: pytest.FixtureRequest) -> None:
    """Let a test say again what was said once, and find anew a compiler that it changes."""
    if {"monkeypatch", "wrapper", "cache"} & set(request.fixturenames):
        for function in (toolchain._chosen, toolchain._first, toolchain.probe, _PLAN_TYPE):
            function.cache_clear()
    notice._said.clear()


@pytest.fixture(
    params=[
        pytest.param("extension", marks=pytest.mark.compiles),
        pytest.param("ctypes", marks=pytest.mark.compiles),
        "numpy",
    ]
)
def library(request: pytest.FixtureRequest, warm_package: Path) -> Library:
    """Small package, called in each of the three ways there are."""
    request.getfixturevalue("warm_cache")
    if request.param == "numpy":
        return load(warm_package, target="numpy")
    request.getfixturevalue("compiler")
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "ctypes":
            patch.setattr(plan, "plan_type", lambda _: None)
        loaded = load(warm_package, target="c")
    if request.param == "extension" and loaded.sphere._fast is None:
        pytest.skip("no headers of Python and NumPy for the extension")
    return loaded


@pytest.fixture(scope="session")
def warm_package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the small package, for tests that do not change it."""
    return write_tiny(tmp_path_factory.mktemp("package") / "tiny")


@pytest.fixture
def backend(compiler: Toolchain) -> str:
    """Solvers of scenes are tested in C: ``test_same_bits.py`` has that NumPy makes its bits."""
    return "c"
