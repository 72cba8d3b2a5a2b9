"""What deriving gives is kept by content, and a cache that is ill harms nothing."""

import gzip
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from kousoku.codegen import derived
from kousoku.codegen.derived import (
    RECORD_FILE,
    SOURCES,
    Derived,
    content_key,
    recall_committed,
    recall_or_derive,
    record_of,
    source_key,
)
from kousoku.codegen.generate import write_tree
from kousoku.codegen.kernel_json import GRAPH_FILE, dump
from kousoku.model.files.manifest import REFERENCE_FILE
from kousoku.model.operations.kernel import Package

ROOT = Path(__file__).parents[2]


@pytest.fixture
def cache(empty_cache: Path) -> Iterator[Path]:
    content_key.cache_clear()
    yield empty_cache
    content_key.cache_clear()


@pytest.fixture
def counted(n1_package: Package, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Replace deriving by something fast, and list what was derived."""
    names: list[str] = []

    def derive_package(name: str) -> Derived:
        names.append(name)
        return Derived(n1_package, '{"format": 1}\n')

    monkeypatch.setattr(derived, "derive_package", derive_package)
    return names


def test_a_kind_is_derived_once(cache: Path, counted: list[str]) -> None:
    first = recall_or_derive("n1")
    assert recall_or_derive("n1") == first
    assert counted == ["n1"]


def test_another_source_is_another_entry(
    cache: Path, counted: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    recall_or_derive("n1")
    monkeypatch.setattr(derived, "__version__", "9.9")
    content_key.cache_clear()
    recall_or_derive("n1")
    assert counted == ["n1", "n1"]


def test_what_old_code_derives_is_not_kept_for_edited_sources(
    cache: Path,
    counted: list[str],
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    content_key()
    monkeypatch.setattr(derived, "__version__", "9.9")
    recall_or_derive("n1")
    assert not list(cache.rglob("*.json"))
    assert "its sources were edited while this process ran" in caplog.text


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: data[: len(data) // 2],
        lambda data: data.replace(b"*", b"+", 1),
        lambda data: b"\xff\xfe",
        lambda data: b"",
        lambda data: b"[]",
    ],
)
def test_a_damaged_entry_is_told_and_derived_again(
    cache: Path,
    counted: list[str],
    caplog: pytest.LogCaptureFixture,
    damage: Callable[[bytes], bytes],
) -> None:
    first = recall_or_derive("n1")
    (entry,) = cache.rglob("*.json")
    damaged = damage(entry.read_bytes())
    assert damaged != entry.read_bytes()
    entry.write_bytes(damaged)
    assert recall_or_derive("n1") == first
    assert counted == ["n1", "n1"]
    assert "n1 is derived again" in caplog.text
    assert recall_or_derive("n1") == first
    assert counted == ["n1", "n1"]


def test_a_cache_that_cannot_be_written_is_told_and_harms_nothing(
    tmp_path: Path,
    counted: list[str],
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("KOUSOKU_CACHE", str(tmp_path / "file"))
    assert recall_or_derive("n1") == recall_or_derive("n1")
    assert counted == ["n1", "n1"]
    assert "is not kept for the next time" in caplog.text


def test_no_home_folder_is_told_and_harms_nothing(
    counted: list[str], caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_folder() -> Path:
        raise OSError("no cache folder")

    monkeypatch.setattr(derived, "cache_folder", no_folder)
    assert recall_or_derive("n1").package.name == "n1"
    assert "nothing derived is kept: no cache folder" in caplog.text


@pytest.fixture
def committed(n1_package: Package, tmp_path: Path) -> Iterator[Path]:
    """Lay out the kind n1 as it is committed, and of which sources it was derived."""
    source_key.cache_clear()
    folder = tmp_path / "kinds"
    tree = {GRAPH_FILE: dump(n1_package), REFERENCE_FILE: '{"format": 1}\n'}
    write_tree(folder / "n1", tree | {"manifest.json": "{}"})
    (folder / RECORD_FILE).write_text(record_of({"n1": tree}), encoding="utf-8")
    yield folder
    source_key.cache_clear()


def test_a_committed_kind_of_the_same_sources_is_not_derived_again(
    committed: Path, n1_package: Package
) -> None:
    known = recall_committed(committed, "n1")
    assert known == Derived(n1_package, '{"format": 1}\n')
    assert recall_committed(committed, "n2") is None


@pytest.mark.parametrize("change", ["source", "sympy", "graph", "record", "no record"])
def test_a_committed_kind_is_derived_again_after_any_change(
    committed: Path, monkeypatch: pytest.MonkeyPatch, change: str
) -> None:
    match change:
        case "source":
            monkeypatch.setattr(derived, "__version__", "9.9")
            source_key.cache_clear()
        case "sympy":
            monkeypatch.setattr(derived, "SAME_BYTES", ("0.7.",))
        case "graph":
            path = committed / "n1" / GRAPH_FILE
            text = gzip.decompress(path.read_bytes())
            path.write_bytes(gzip.compress(text.replace(b"*", b"+", 1)))
        case "record":
            (committed / RECORD_FILE).write_text("[]", encoding="utf-8")
        case _:
            (committed / RECORD_FILE).unlink()
    assert recall_committed(committed, "n1") is None


def test_the_key_covers_every_module_that_deriving_imports() -> None:
    program = (
        "import sys; from kousoku.codegen.derived import derive_package\n"
        "derive_package('n1')\n"
        "print(*(m.__file__ for n, m in sys.modules.items() if n.startswith('kousoku.')))"
    )
    out = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True)
    imported = {Path(name).resolve() for name in out.stdout.decode().split()}
    covered = {path.resolve() for pattern in SOURCES for path in ROOT.glob(pattern)}
    plumbing = {ROOT / "codegen" / "__init__.py", *(ROOT / "model").rglob("[!q]*.py")}
    assert imported - covered - plumbing == set()


def test_every_pattern_of_the_key_finds_a_file() -> None:
    assert len(content_key()) == 64
    for pattern in SOURCES:
        assert list(ROOT.glob(pattern)), pattern
