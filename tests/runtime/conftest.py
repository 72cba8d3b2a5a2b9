"""A small package written by hand, so that loading is tested without the generator."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from kousoku.model.manifest import KernelManifest, Manifest
from kousoku.model.quantity import Quantity

if TYPE_CHECKING:
    from collections.abc import Callable

TINY = Path(__file__).parent / "tiny"
DIGEST = "3f9a" * 16
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


def write_tiny(folder: Path, *, edit: Callable[[str, str], str] = lambda name, text: text) -> Path:
    """Write the package as the generator would; ``edit`` changes a file before it is listed."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    texts = {p.name: p.read_text(encoding="utf-8") for p in sorted(TINY.glob("kernels*"))}
    for name, text in texts.items():
        data = edit(name, text.replace("DIGEST", DIGEST)).encode()
        (folder / name).write_bytes(data)
        files.append((name, hashlib.sha256(data).hexdigest()))
    manifest = Manifest(
        "tiny", "Tiny", "kousoku generate tiny", "0", DIGEST, tuple(files), (SPHERE,)
    )
    (folder / "manifest.json").write_text(manifest.to_json(), encoding="utf-8")
    return folder


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return an empty cache folder."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("KOUSOKU_CACHE", str(folder))
    return folder


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    """Return the folder of the small package."""
    return write_tiny(tmp_path / "tiny")
