"""Derived kinds, kept on disk by content: SymPy runs once for each version of one."""

from __future__ import annotations

import hashlib
import json
import logging
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

from kousoku.codegen.kernel_json import GRAPH_FILE, dump, parse
from kousoku.codegen.passes.optimise import optimise
from kousoku.model.errors import LoadError
from kousoku.model.files.cache import cache_folder, write_atomically
from kousoku.model.files.compressed import content
from kousoku.model.files.jsontext import to_text
from kousoku.model.files.manifest import REFERENCE_FILE
from kousoku.model.operations.kernel import Package
from kousoku.model.version import __version__

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.symbolic.derivation import Derivation

#: Sources that a derivation depends on, relative to the folder of the package kousoku.
SOURCES = (
    "symbolic/*.py",
    "codegen/matrix_chain.py",
    "codegen/derived.py",
    "codegen/freeze.py",
    "codegen/freeze_components.py",
    "codegen/known_errors.py",
    "codegen/manifold.py",
    "codegen/passes/*.py",
    "codegen/points.py",
    "codegen/reference.py",
    "codegen/states.py",
    "codegen/error_unit.py",
    "codegen/kernel_json.py",
    "codegen/sha256_random.py",
    "model/operations/arithmetic.py",
    "model/numbers/digits.py",
    "model/numbers/dual.py",
    "model/numbers/real.py",
    "model/operations/differentials.py",
    "model/operations/graph.py",
    "model/operations/interpret.py",
    "model/files/jsontext.py",
    "model/operations/kernel.py",
    "model/files/quantity.py",
    "model/mechanics/parallel_rows.py",
)
#: File beside the committed kinds with the digest of the sources that they were derived from.
RECORD_FILE = "derived.json"
#: Versions of SymPy that derive the same bytes: tests/release/test_reproducibility.py runs them.
SAME_BYTES = ("1.13.", "1.14.")
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Derived:
    """Result of deriving a kind: a package, and the references that it is checked against.

    Parameters
    ----------
    package : Package
        The frozen and optimised kernels.
    references : str
        The text of ``reference.json.gz``.
    """

    package: Package
    references: str


def derive_package(name: str) -> Derived:
    """Derive a package with SymPy, freeze and optimise it, and compute its references.

    Parameters
    ----------
    name : str
        A package of a kind, such as ``p2_z``.

    Raises
    ------
    DerivationError
        No kind has this package.
    """
    # SymPy takes a third of a second to import, and nothing needs it when the cache answers.
    from kousoku.symbolic import derive  # noqa: PLC0415

    derivation = derive(name)
    return freeze_derivation(derivation, f"kousoku generate {derivation.name}")


def freeze_derivation(
    derivation: Derivation, regenerate: str, *, is_thorough: bool = False
) -> Derived:
    """Freeze and optimise the functions of a derivation, and compute their references.

    Parameters
    ----------
    derivation : Derivation
        Of a kind that kousoku ships or of any other.
    regenerate : str
        The command that makes the package again.
    is_thorough : bool
        As :func:`kousoku.codegen.reference.references` takes it.

    Raises
    ------
    FreezeError, DerivationError
        It holds something that cannot be emitted.
    """
    from kousoku.codegen.reference import references  # noqa: PLC0415

    package = frozen_package(derivation, regenerate)
    return Derived(package, references(package, derivation.functions, is_thorough=is_thorough))


def frozen_package(derivation: Derivation, regenerate: str) -> Package:
    """Freeze and optimise the functions of a derivation.

    Parameters
    ----------
    derivation : Derivation
        Of a kind that kousoku ships or of any other.
    regenerate : str
        The command that makes the package again.

    Raises
    ------
    FreezeError
        It holds something that cannot be emitted.
    """
    from kousoku.codegen.freeze import freeze  # noqa: PLC0415

    return Package(
        name=derivation.name,
        title=derivation.title,
        regenerate=regenerate,
        kernels=tuple(optimise(freeze(function))[0] for function in derivation.functions),
    )


def recall_or_derive(name: str) -> Derived:
    """Result of :func:`derive_package`, from the cache where that has it.

    A cache that is broken, full or read-only costs time and a message, nothing else.
    """
    key = content_key()
    try:
        path = cache_folder() / "derived" / f"{name}-{key[:32]}.json"
    except OSError as problem:
        _LOG.warning("nothing derived is kept: %s", problem)
        return derive_package(name)
    derived = _recall(path, name)
    if derived is None:
        derived = derive_package(name)
        if _hash_sources() == key:
            _keep(path, derived)
        else:
            _LOG.warning("%s is not kept: its sources were edited while this process ran", name)
    return derived


def record_of(trees: Mapping[str, Mapping[str, str]]) -> str:
    """Text of ``derived.json``: the digest of the sources, and of graphs and references.

    Parameters
    ----------
    trees : mapping of str to mapping of str to str
        Files of each kind that is shipped.
    """
    kinds = {n: _digest(tree[GRAPH_FILE], tree[REFERENCE_FILE]) for n, tree in trees.items()}
    return to_text({"format": 1, "sources": source_key(), "kinds": kinds})


def recall_committed(folder: Path, name: str) -> Derived | None:
    """Committed derivation of a kind, where deriving it again would give the same.

    That is so where version and sources are those of ``derived.json``, graph and references in the
    folder of the kind have the digest there, and this SymPy is known to derive the same bytes.

    Parameters
    ----------
    folder : Path
        Folder of the kinds, each in a folder of its name.
    name : str
        A kind.
    """
    try:
        record = json.loads((folder / RECORD_FILE).read_text(encoding="utf-8"))
        if record["sources"] != source_key() or not metadata.version("sympy").startswith(
            SAME_BYTES
        ):
            return None
        graph, references = (
            content(file, (folder / name / file).read_bytes()).decode()
            for file in (GRAPH_FILE, REFERENCE_FILE)
        )
        is_same = record["kinds"][name] == _digest(graph, references)
        return Derived(parse(graph), references) if is_same else None
    except (OSError, ValueError, KeyError, TypeError, LoadError):
        return None  # then it is derived


@cache
def content_key() -> str:
    """SHA-256 over all inputs of a derivation: sources and versions.

    It is computed at the first call, before the modules that derive are imported: a process that
    outlives an edit of the sources still runs the old ones.
    """
    return _hash_sources()


@cache
def source_key() -> str:
    """SHA-256 over the sources of derivations, without versions of libraries."""
    return _hash_sources(())


def _hash_sources(libraries: Sequence[str] = ("mpmath", "sympy")) -> str:
    root = Path(__file__).parents[1]
    total = hashlib.sha256()
    versions = [("kousoku", __version__)]
    versions += [(name, metadata.version(name)) for name in libraries]
    total.update(repr(versions).encode())
    for pattern in SOURCES:
        for path in sorted(root.glob(pattern)):
            total.update(f"\n{path.relative_to(root).as_posix()}\n".encode())
            total.update(path.read_bytes())
    return total.hexdigest()


def _recall(path: Path, name: str) -> Derived | None:
    """Derivation in a file of the cache; None where there is none, or it is damaged."""
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as problem:
        _LOG.warning("%s is derived again: %s cannot be read: %s", name, path, problem)
        return None
    try:
        data = json.loads(text)
        graph, references = data["graph"], data["references"]
        if data["sha256"] != _digest(graph, references):
            raise ValueError("its digest is another")
        package = parse(graph)
    except (ValueError, KeyError, TypeError, LoadError) as problem:
        _LOG.warning("%s is derived again: %s is damaged: %s", name, path, problem)
        return None
    return Derived(package, references)


def _keep(path: Path, derived: Derived) -> None:
    graph, references = dump(derived.package), derived.references
    data = {"sha256": _digest(graph, references), "graph": graph, "references": references}
    try:
        write_atomically(path, json.dumps(data).encode())
    except OSError as problem:
        _LOG.warning("%s is not kept for the next time: %s", derived.package.name, problem)


def _digest(graph: str, references: str) -> str:
    return hashlib.sha256(json.dumps([graph, references]).encode()).hexdigest()
