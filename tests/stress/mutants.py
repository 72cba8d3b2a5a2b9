"""Mutants: small mistakes in what emits code and in what is emitted, and who notices them.

Each is made in a copy of the checkout, as :mod:`tests.mutants` makes it. ``kousoku verify`` is
asked first, then the tests of ``make quick``; as these neither compile nor make steps in NumPy, of
mistakes in the library and the composition then the tests of these in ``make test``. Of a mistake
that is answered, since it changes nothing, only verify is asked. The first case makes no mistake:
nobody may notice one.
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
from tests.stress.kit import ROOT, Fault, Finding, Outcome, Question, Size
from tests.stress.mutants_answered import ANSWERED

if TYPE_CHECKING:
    from collections.abc import Iterator
    from contextlib import AbstractContextManager

#: Scenes with events, with drivers and with a loop: beside the packages that are committed.
SCENES = ("bouncing_ball", "constant_velocity", "loop_free")
ALL = ("", *SCENES)
"""What ``kousoku verify`` is asked for all packages, and for these scenes."""
PATIENCE = 600.0
"""Seconds after which a command has no end; tests have twice as long."""

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
    tested : tuple of str
        Where tests lie that look at it and are not quick.
    """

    name: str
    patterns: tuple[str, ...]
    share: int
    verified: tuple[str, ...] = ()
    tested: tuple[str, ...] = ()

    def files(self) -> list[Path]:
        """Files, relative to the checkout."""
        found = [path for pattern in self.patterns for path in sorted(ROOT.glob(pattern))]
        return [path.relative_to(ROOT) for path in found if path.suffix in SUFFIXES]


SORTS = (
    Sort("generated kinds", ("generated/kinds/*/*.*",), 91),
    Sort("a generated linkage", ("generated/lever_crank/*.*",), 30),
    Sort("a generated solver of bodies", ("generated/pendulum/*.*",), 30),
    Sort(
        "the library",
        ("runtime/integrate/*", "runtime/kinematics/*", "runtime/lanes.h"),
        14,
        ALL,
        ("tests/runtime",),
    ),
    Sort("printers and passes", ("codegen/printers.py", "codegen/passes/*"), 10, ALL),
    Sort("templates", ("codegen/templates/**/*.jinja",), 10, ALL),
    Sort(
        "the composition",
        ("codegen/dynamics/**/*",),
        8,
        ("pendulum", *SCENES),
        ("tests/codegen/dynamics", "tests/runtime"),
    ),
    Sort("formulas", ("symbolic/*",), 7, ("",)),
)


def cases(size: Size) -> Iterator[str]:
    """Name the control, then mutants: quick ones in arithmetic, which verify alone must notice."""
    if not size.is_full:
        sort, draw = SORTS[0], random.Random(size.seed)
        files = [path for path in sort.files() if path.name == "expressions.h"]
        chosen = [draw.choice(files) for _ in range(size.examples(2, 0))]
        yield " ".join(["control verify", *dict.fromkeys(path.parent.name for path in chosen)])
        for number, path in enumerate(chosen):
            yield f"verify {path.as_posix()} {number}"
        return
    yield "control all"
    for sort in SORTS:
        draw, files = random.Random(f"{size.seed} {sort.name}"), sort.files()
        weights = [sum(1 for _ in mutants.candidates_of(path)) for path in files]
        for number in range(-(-sort.share * size.examples(0, 200) // 200)):
            yield f"all {draw.choices(files, weights)[0].as_posix()} {size.seed}.{number}"


@cache
def temporary() -> Path:
    """Folder of this process, gone at its end."""
    folder = tempfile.mkdtemp(prefix="kousoku-mutants-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


def copy() -> Path:
    """Copy of the checkout without the last mistake."""
    folder = mutants.copied(temporary() / "checkout")
    for path, old, new in SPOILT:
        text = (folder / path).read_text(encoding="utf-8")
        (folder / path).write_text(text.replace(old, new), encoding="utf-8", newline="\n")
    return folder


def run(case: str) -> Outcome:
    """Make one mistake, and ask who notices it; or none."""
    if case.startswith("control "):
        return control(case)
    stage, path, number = case.split()
    outcome, mutant = Outcome(), mutants.one_of(Path(path), random.Random(f"{path} {number}"))
    if mutant is None:
        outcome.count("files without anything to change")
        return outcome
    sort = next(sort for sort in SORTS if Path(path) in sort.files())
    survivor = Finding(
        title_of(mutant),
        f"{mutant.path.as_posix()}, line {mutant.line}",
        f"python -m tests.stress mutants --case '{case}'",
    )
    is_answered = QUESTION.reason_of(survivor) is not None  # tests take long to notice nothing
    by = made_in(copy(), mutant, sort, "verify" if is_answered else stage)
    outcome.count(f"{sort.name}: {by or 'not noticed'}")
    if not by:
        outcome.findings.append(survivor)
    return outcome


def control(case: str) -> Outcome:
    """Ask who notices a mistake where none is made: what notices one anyway proves nothing."""
    outcome, folder, by = Outcome(), copy(), ""
    _, stage, *kinds = case.split()
    if stage == "all" and not is_good(folder, "generate"):
        by = "by generate"
    elif not is_good(folder, "verify", *([f"generated/kinds/{kind}" for kind in kinds] or ALL)):
        by = "by verify"
    elif stage == "all":
        every = dict.fromkeys(tests for sort in SORTS for tests in sort.tested)
        by = noticed_by_tests(folder, tuple(every))
    outcome.count(f"no mistake: {by or 'not noticed'}")
    if by:
        outcome.find(
            f"where no mistake is made one is noticed {by}",
            "what is noticed is not the mistake",
            f"python -m tests.stress mutants --case '{case}'",
        )
    return outcome


def title_of(mutant: Mutant) -> str:
    """Title of the finding that a mistake is not noticed."""
    line = (ROOT / mutant.path).read_text(encoding="utf-8").splitlines()[mutant.line - 1]
    change = f"{mutant.old.strip()!r} -> {mutant.new.strip()!r}"
    return f"{answered_as(mutant.path)}: {change} in {line.strip()!r} is not noticed"


def answered_as(path: Path) -> str:
    """File that answers name: the one that this is a copy of, or of any kind."""
    folder, *rest = path.parts
    if folder == "generated" and rest[0] == "kinds":
        return Path(folder, "kinds", "*", *rest[2:]).as_posix()
    source = Path("runtime", *rest[1:])
    if folder == "generated" and (ROOT / source).is_file():
        text = (ROOT / source).read_text(encoding="utf-8")
        if text == (ROOT / path).read_text(encoding="utf-8"):
            return source.as_posix()
    return path.as_posix()


def made_in(folder: Path, mutant: Mutant, sort: Sort, stage: str) -> str:
    """Command or tests that notice a mistake in a copy of the checkout; "" if none do."""
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
    return noticed_by_tests(folder, sort.tested)


def noticed_by_tests(folder: Path, tested: tuple[str, ...]) -> str:
    """Tests that notice a mistake: the quick ones, then all of some folders."""
    for tier, tests in {"quick": ("tests",), "test": tested}.items():
        if tests and mutants.run(folder, [*mutants.TIERS[tier], *tests], 2 * PATIENCE):
            return f"by make {tier}"
    return ""


def copies_of(path: Path, text: str) -> list[Path]:
    """Paths of a file and of its copies in generated folders."""
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
    """Whether a command of kousoku ends well in a copy of the checkout."""
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


def wrong_before() -> AbstractContextManager[object]:
    """Have a mistake in the checkout before one is made."""
    spoilt = ("generated/kinds/n1/expressions.h", " + ", " - ")
    return patch(f"{__name__}.SPOILT", (spoilt,))


def blinded() -> AbstractContextManager[object]:
    """Let ``verify`` take every error."""
    spoilt = ("runtime/report.py", "return not self.problems", "return True")
    return patch(f"{__name__}.SPOILT", (spoilt,))


QUESTION = Question(
    asks="small mistakes in generated files: who notices them?",
    in_full="that of formulas, passes, printers, templates and the library, too: does `kousoku"
    " verify` notice them, of those that it takes `make quick`, and of those in the library and in"
    " the composition that this takes too their tests of `make test`",
    cases=cases,
    run=run,
    faults=(
        Fault(
            "`verify` takes every error",
            blinded,
            "verify generated/kinds/n1/expressions.h 1",
            "generated/kinds/*/expressions.h",
        ),
        Fault(
            "a checkout that is wrong before a mistake is made",
            wrong_before,
            "control verify n1",
            "where no mistake is made one is noticed by verify",
        ),
    ),
    known=ANSWERED,
    seconds=6 * PATIENCE,
)
