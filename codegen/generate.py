"""Stages from a kind, or a derivation of one's own, to the folder of its kernels.

``derive``: name → Derivation
    SymPy derives it, where neither the committed folder nor the cache has the derivation.
``require_proved``: Derivation
    One of one's own is proved; tests prove the kinds that are shipped.
``frozen_package``: Derivation → Package
    ``freeze``, then ``optimise``: kernels of its matrix level.
``references``: Package, Derivation → text
    Points with values in 50 digits, of its component level.
``emit``: Package, texts → {file: text}
    The folder.
``write_tree``: {file: text} → names of files that changed
    Written; ``check_tree`` reports instead where a folder differs.
"""

from __future__ import annotations

import json
import re
from dataclasses import replace
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

from kousoku.codegen.derived import (
    Derived,
    freeze_derivation,
    recall_committed,
    recall_or_derive,
)
from kousoku.codegen.emit import LIBRARIES, emit, runtime_source, sha256, with_manifest
from kousoku.codegen.kernel_json import GRAPH_FILE, dump
from kousoku.model.files.cache import write_atomically
from kousoku.model.files.compressed import content, stored
from kousoku.model.files.jsontext import to_text
from kousoku.model.files.manifest import MANIFEST_FILE, PLAIN, REFERENCE_FILE, Manifest
from kousoku.model.operations.kernel import Package
from kousoku.symbolic.kinds import KINDS, packages_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from kousoku.model.operations.kernel import Kernel
    from kousoku.symbolic.derivation import Derivation

    SourceTree = dict[str, str]

#: A digest in a line: hexadecimal digits, and no decimal number.
DIGEST = re.compile(r"\b(?=[0-9e]*[a-df])[0-9a-f]{16,}\b")
#: Characters of a line that differs that are shown.
EXCERPT_LENGTH = 60


def package_names() -> tuple[str, ...]:
    """Packages of all kinds, in the order of the list of kinds.

    The choices of rows of a kind are one package, ``p2`` of ``p2_x``, ``p2_y`` and ``p2_z``.
    """
    return tuple(KINDS)


def package_of(name: str) -> str:
    """Package that holds a kind or one choice of its rows: ``p2`` for ``p2_z``.

    Raises
    ------
    DerivationError
        No kind has this name.
    """
    packages = packages_of(name)
    return next(kind for kind, entry in KINDS.items() if packages[0] in entry.packages)


def generate_kind(name: str, committed: Path | None = None) -> SourceTree:
    """Derive, freeze, optimise and emit one package of a kind.

    Parameters
    ----------
    name : str
        A package, such as ``p2``, or a choice of its rows, ``p2_z``; see :func:`package_of`.
    committed : Path, optional
        Folder of the kinds that are committed: what was derived from these sources is taken from
        there.

    Returns
    -------
    dict of str to str
        File name and text, the manifest last. The same on every machine.

    Raises
    ------
    DerivationError
        No kind has this package.
    """
    package = package_of(name)
    if committed is not None and (recalled := recall_committed(committed, package)):
        return _emitted(recalled)
    derived = [recall_or_derive(choice) for choice in KINDS[package].packages]
    return _emitted(derived[0] if len(derived) == 1 else _merged(package, derived))


def _merged(name: str, derived: Sequence[Derived]) -> Derived:
    """Choices of the rows of a kind as one package, ``rates_x`` of ``rates``."""
    choices = tuple(part.package.name.removeprefix(f"{name}_") for part in derived)
    kernels: list[Kernel] = []
    points: list[dict[str, object]] = []
    for choice, part in zip(choices, derived, strict=True):
        kernels += [replace(k, name=f"{k.name}_{choice}") for k in part.package.kernels]
        data = json.loads(part.references)
        points += [kernel | {"name": f"{kernel['name']}_{choice}"} for kernel in data["kernels"]]
    first = derived[0].package
    package = Package(name, first.title, f"kousoku generate {name}", tuple(kernels), choices)
    return Derived(package, to_text(data | {"package": name, "kernels": points}))


def generate(derivation: Derivation, *, regenerate: str = "") -> SourceTree:
    """Prove, freeze, optimise and emit a derivation: the folder of a kind of one's own.

    :func:`write_tree` writes the folder; ``kousoku.runtime`` loads and verifies it.

    Parameters
    ----------
    derivation : Derivation
        Result of ``kousoku.symbolic.constraint.derive_constraint``, or functions that were put
        together by hand.
    regenerate : str
        The command that makes the folder again, for the head of its files and for messages.

    Returns
    -------
    dict of str to str
        File name and text, the manifest last. The same on every machine.

    Raises
    ------
    DerivationError
        A name is no identifier or is taken, an input is not declared, the two levels differ, or a
        step does not follow.
    FreezeError
        An expression holds a node that cannot be emitted.
    """
    require_proved(derivation)
    command = regenerate or f"run the program that derives {derivation.name}"
    return _emitted(freeze_derivation(derivation, command, is_thorough=True))


def require_proved(derivation: Derivation) -> None:
    """Refuse a derivation of one's own that does not hold, or that cannot be emitted.

    Raises
    ------
    DerivationError
        As of :func:`generate`.
    """
    # SymPy takes a third of a second to import, and a kind that is recalled needs none of it.
    from kousoku.symbolic.check import check_functions, check_names  # noqa: PLC0415
    from kousoku.symbolic.prove import prove, prove_steps  # noqa: PLC0415

    check_names(derivation)
    check_functions(derivation)
    for function in derivation.functions:
        prove(function)
    prove_steps(derivation)


def _emitted(derived: Derived) -> SourceTree:
    data = {GRAPH_FILE: dump(derived.package), REFERENCE_FILE: derived.references}
    return emit(derived.package, data)


def without(tree: SourceTree, *endings: str) -> SourceTree:
    """Package without the files whose names end so, and its manifest without them."""
    kept = {name: text for name, text in tree.items() if not name.endswith(endings)}
    manifest = Manifest.from_json(kept.pop(MANIFEST_FILE))
    return with_manifest(kept, manifest)


def beside_runtime(tree: SourceTree) -> SourceTree:
    """Package of a kind that is shipped with the runtime, without copies of the runtime's files.

    Its NumPy module imports them from the runtime, which also supplies those that its C includes.
    """
    texts = {
        name: text.replace("from .batch_numpy import", "from kousoku.runtime.batch_numpy import")
        for name, text in tree.items()
    }
    return without(texts, *LIBRARIES)


def write_tree(folder: Path, tree: Mapping[str, str]) -> list[str]:
    """Write a folder, each file whole or not at all, and remove files that an older version left.

    Files that end in ``.gz`` are compressed, and are written where their content changes.
    Only files that the folder's own manifest lists are removed. The manifest is written last, so
    that a folder that was written half is recognised by its digests.

    Returns
    -------
    list of str
        The names of the files that changed.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    stale = _stale_files(folder, tree)
    changed = [name for name, text in tree.items() if _read(folder / name) != text]
    for name in changed:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / name, stored(name, tree[name]))
    for name in stale:
        (folder / name).unlink(missing_ok=True)
    return changed + stale


def check_tree(folder: Path, tree: Mapping[str, str]) -> list[str]:
    """Differences of a folder from the files that it should have, a line for each; empty if none.

    Each line says where the file differs, and why: it was edited by hand, or the plain source that
    it copies changed, or inputs of the package did, which manifests know by their digests. Files
    of others do not count: :func:`foreign_files`.
    """
    differences = []
    cause = causes(folder, tree)
    for name, text in tree.items():
        current = _read(folder / name)
        if current is None:
            is_there = (folder / name).exists()
            differences.append(f"{folder / name} {'is damaged' if is_there else 'is missing'}")
        elif current != text:
            differences.append(
                f"{folder / name} differs {_where(current, text)}; {cause(name, current)}"
            )
    stale = [folder / name for name in _stale_files(folder, tree)]
    return differences + [f"{path} is not generated any more" for path in stale if path.is_file()]


def foreign_files(folder: Path, tree: Mapping[str, str]) -> list[Path]:
    """Files and folders in a folder that the generator did not write, and would never remove.

    Those of Python or an operating system (hidden ones, ``__pycache__``) do not count.
    """
    known = {*tree, *_listed_files(folder)}
    subfolders = {name.partition("/")[0] for name in known if "/" in name}
    paths = [
        *folder.glob("*"),
        *(path for name in subfolders for path in (folder / name).glob("*")),
    ]
    known |= {*subfolders, *(f"{name}/__pycache__" for name in subfolders), "__pycache__"}
    return [
        path
        for path in sorted(paths)
        if path.relative_to(folder).as_posix() not in known and not path.name.startswith(".")
    ]


#: Texts for messages of inputs of a package that changed.
INPUTS = {
    "derivation": "the derivation (symbolic/)",
    "scene": "the scene",
    "composition": "how the scene is composed (codegen/)",
    "templates": "the templates (codegen/templates/)",
    "runtime": "the plain source that goes along (runtime/)",
}


def causes(folder: Path, tree: Mapping[str, str]) -> Callable[[str, str], str]:
    """Reasons why a file differs, by its name and its text."""
    new = json.loads(tree[MANIFEST_FILE])
    old = _listed(folder)
    listed, wanted = (dict(manifest.get("inputs", ())) for manifest in (old, new))
    changed = [
        f"{label}, {old.get(key, 'unknown')}, is {new.get(key)} now"
        for key, label in (("version", "the version of kousoku"), ("abi", "the ABI"))
        if old.get(key) != new.get(key)
    ]
    differs = [name for name in wanted if listed.get(name) != wanted[name]]
    if "scene" in differs:  # how it is composed follows from it
        differs = [name for name in differs if name != "composition"]
    changed += [INPUTS[name] for name in differs]
    reason = "changed: " + ", ".join(changed) if changed else "changed: what emits it (codegen/)"
    digests = dict(old.get("files", ()))

    def cause(name: str, current: str) -> str:
        if name != MANIFEST_FILE and sha256(current) != digests.get(name):
            return "it was edited after it was generated"
        origin, text = runtime_source(name)
        if tree[name] == text:
            return f"changed: {origin}"
        return reason

    return cause


def _read(path: Path) -> str | None:
    """Content of a file, None where it is missing or damaged."""
    try:
        return content(path.name, path.read_bytes()).decode()
    except (FileNotFoundError, ValueError):
        return None


def _stale_files(folder: Path, tree: Mapping[str, str]) -> list[str]:
    """Files that the manifest of a folder lists and that are not generated any more."""
    return sorted(set(_listed_files(folder)) - set(tree))


def _listed_files(folder: Path) -> list[str]:
    """Files that an older manifest lists, those outside the folder left out."""
    names = dict(_listed(folder)["files"])
    return [name for name in names if isinstance(name, str) and PLAIN.fullmatch(name)]


def _listed(folder: Path) -> dict[str, Any]:
    """Files and inputs in the manifest of a folder, of whatever version."""
    try:
        data = dict(json.loads(_read(folder / MANIFEST_FILE) or "{}"))
        pairs = {key: list(dict(data.get(key, ())).items()) for key in ("files", "inputs")}
    except (ValueError, TypeError, RecursionError):
        return {"files": [], "inputs": []}
    return data | pairs


def _where(current: str, wanted: str) -> str:
    """First line in which two texts differ, as text with an excerpt of both."""
    lines = zip(current.splitlines(), wanted.splitlines(), strict=False)
    differences = [(number, *pair) for number, pair in enumerate(lines, 1) if pair[0] != pair[1]]
    if not differences:
        return "in its length or its line ends"
    # A digest shows that something changed, and not what.
    number, old, new = next(
        (line for line in differences if not DIGEST.search(line[1])), differences[0]
    )
    pairs = enumerate(zip_longest(old, new))
    common = next(index for index, (a, b) in pairs if a != b)
    first = max(0, common - EXCERPT_LENGTH // 2) if common >= EXCERPT_LENGTH else 0
    parts = (("… " if first else "") + text[first : first + EXCERPT_LENGTH] for text in (old, new))
    return "from line {} on: {!r} instead of {!r}".format(number, *parts)
