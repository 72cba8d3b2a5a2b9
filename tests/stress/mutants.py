"""Mutants: small mistakes in what emits code and in what is emitted, and who notices them.

Each is made in a copy of the checkout, as :mod:`tests.mutants` makes it. ``kousoku verify`` is
asked first, then the tests of ``make quick``.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import random
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING
from unittest.mock import patch

from tests import mutants
from tests.mutants import SUFFIXES, Mutant
from tests.stress.kit import ROOT, Fault, Outcome, Question, Size
from tests.stress.mutants_answered import ANSWERED

if TYPE_CHECKING:
    from collections.abc import Iterator
    from contextlib import AbstractContextManager

#: Scenes with events, with drivers and with a loop: beside the packages that are committed.
SCENES = ("bouncing_ball", "constant_velocity", "loop_free")
PATIENCE = 1800.0
"""Seconds after which a command has no end."""

#: Files that are wrong in the copy of the checkout: path, what stands there, what is written.
SPOILT: tuple[tuple[str, str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class Sort:
    """A sort of sources.

    Parameters
    ----------
    name : str
        What they are.
    patterns : tuple of str
        Where they lie.
    share : int
        How many of 200 mutants are made in them.
    verified : tuple of str
        What ``kousoku verify`` looks at; the folder itself unless given.
    """

    name: str
    patterns: tuple[str, ...]
    share: int
    verified: tuple[str, ...] = ()

    def files(self) -> list[Path]:
        """Return the files, relative to the checkout."""
        found = [path for pattern in self.patterns for path in sorted(ROOT.glob(pattern))]
        return [path.relative_to(ROOT) for path in found if path.suffix in SUFFIXES]


SORTS = (
    Sort("generated kinds", ("generated/kinds/*/*.*",), 70),
    Sort("a generated linkage", ("generated/lever_crank/*.*",), 25),
    Sort("a generated solver of bodies", ("generated/pendulum/*.*",), 30),
    Sort(
        "the library",
        ("runtime/integrate/*", "runtime/kinematics/*", "runtime/lanes.h"),
        40,
        ("", *SCENES),
    ),
    Sort("printers and passes", ("codegen/printers.py", "codegen/passes/*"), 8, ("", *SCENES)),
    Sort("templates", ("codegen/templates/**/*.jinja",), 10, ("", *SCENES)),
    Sort("the composition", ("codegen/dynamics/**/*",), 10, ("pendulum", *SCENES)),
    Sort("formulas", ("symbolic/*",), 7, ("",)),
)


def cases(size: Size) -> Iterator[str]:
    """Name mutants: of the quick size in pure arithmetic, which verify alone must notice."""
    if not size.is_full:
        sort, draw = SORTS[0], random.Random(size.seed)
        files = [path for path in sort.files() if path.name == "expressions.h"]
        for number in range(size.examples(8, 0)):
            yield f"verify {draw.choice(files).as_posix()} {number}"
        return
    for sort in SORTS:
        draw, files = random.Random(f"{size.seed} {sort.name}"), sort.files()
        weights = [sum(1 for _ in mutants.candidates_of(path)) for path in files]
        for number in range(-(-sort.share * size.examples(0, 200) // 200)):
            yield f"all {draw.choices(files, weights)[0].as_posix()} {size.seed}.{number}"


@cache
def temporary() -> Path:
    """Return a folder of this process, gone at its end."""
    folder = tempfile.mkdtemp(prefix="kousoku-mutants-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


def copy() -> Path:
    """Return a copy of the checkout without the last mistake."""
    folder = mutants.copied(temporary() / "checkout")
    for path, old, new in SPOILT:
        text = (folder / path).read_text(encoding="utf-8")
        (folder / path).write_text(text.replace(old, new), encoding="utf-8", newline="\n")
    return folder


def run(case: str) -> Outcome:
    """Make one mistake, and ask who notices it."""
    stage, path, number = case.split()
    outcome, mutant = Outcome(), mutants.one_of(Path(path), random.Random(f"{path} {number}"))
    if mutant is None:
        outcome.count("files without anything to change")
        return outcome
    sort = next(sort for sort in SORTS if Path(path) in sort.files())
    by = made_in(copy(), mutant, sort, stage)
    outcome.count(f"{sort.name}: {by or 'not noticed'}")
    if not by:
        line = (ROOT / mutant.path).read_text(encoding="utf-8").splitlines()[mutant.line - 1]
        outcome.find(
            f"{mutant.path.name}: {mutant.old.strip()!r} -> {mutant.new.strip()!r} in"
            f" {line.strip()!r} is not noticed",
            f"{mutant.path.as_posix()}, line {mutant.line}",
            f"python -m tests.stress mutants --case '{case}'",
        )
    return outcome


def made_in(folder: Path, mutant: Mutant, sort: Sort, stage: str) -> str:
    """Return who notices a mistake in a copy of the checkout; "" if nobody does."""
    whole = (ROOT / mutant.path).read_text(encoding="utf-8")
    is_emitted = mutant.path.parts[0] in {"codegen", "symbolic"}
    for path in [mutant.path] if is_emitted else copies_of(mutant.path, whole):
        (folder / path).write_text(mutant.of(whole), encoding="utf-8", newline="\n")
        seal(folder / path)
    if is_emitted and not is_good(folder, "generate"):
        return "by generate"
    package = Path(*mutant.path.parts[: 3 if "kinds" in mutant.path.parts else 2])
    if not is_good(folder, "verify", *(sort.verified or (str(package),))):
        return "by verify"
    if stage == "verify":
        return ""
    return "by make quick" if mutants.run(folder, ["--quick", "tests"], PATIENCE) else ""


def copies_of(path: Path, text: str) -> list[Path]:
    """Return a file and what generated folders have of it."""
    same = [
        found.relative_to(ROOT)
        for found in ROOT.glob(f"generated/**/{path.name}")
        if path.parts[0] == "runtime" and found.read_text(encoding="utf-8") == text
    ]
    return [path, *same]


def seal(path: Path) -> None:
    """Write the digest of a generated file into its manifest: what is left is what it computes."""
    for folder in path.parents[:2]:
        if (manifest := folder / "manifest.json").exists():
            said, name = manifest.read_text(encoding="utf-8"), path.relative_to(folder).as_posix()
            start = said.index(f'"{name}"') + len(name) + 2
            first = said.index('"', start) + 1
            digest = hashlib.sha256(path.read_bytes()).hexdigest()
            sealed = said[:first] + digest + said[first + len(digest) :]
            manifest.write_text(sealed, encoding="utf-8", newline="\n")


def is_good(folder: Path, *words: str) -> bool:
    """Return whether a command of kousoku ends well in a copy of the checkout."""
    environment = {
        "PYTHONPATH": str(folder),
        "KOUSOKU_CACHE": str(folder.parent / "cache"),
        "KOUSOKU_CFLAGS": "-O0",
    }
    try:
        done = subprocess.run(
            [sys.executable, "-m", "kousoku", *words],
            cwd=folder,
            env={**os.environ, **environment},
            capture_output=True,
            timeout=PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


def blinded() -> AbstractContextManager[object]:
    """Let ``verify`` take every error."""
    spoilt = ("runtime/report.py", "return not self.problems", "return True")
    return patch(f"{__name__}.SPOILT", (spoilt,))


QUESTION = Question(
    asks="small mistakes in formulas, passes, printers, templates, library and generated files:"
    " who notices them, `kousoku verify`, and of those that it takes `make quick`?",
    cases=cases,
    run=run,
    faults=(
        Fault("`verify` takes every error", blinded, "verify generated/kinds/n1/expressions.h 1"),
    ),
    known=ANSWERED,
    seconds=PATIENCE,
)
