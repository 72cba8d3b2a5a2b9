"""Mutants: small mistakes that are made in sources on purpose, and the tests that notice them.

``python tests/mutants.py runtime/integrate --run 20 --tier test`` makes 20 of all mistakes that the
rules below find in a folder, one at a time in a copy of the checkout, runs the tests until one
fails, and prints for each mistake which test that was. A mistake that no test notices survives:
a test is missing there, or the code says something that does not matter. With
``--tier quick test`` only what the first tier does not notice goes through the second.

The choice is the same for the same sources and the same ``--seed``; ``--list`` prints all mistakes.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).parents[1]
SUFFIXES = {".py", ".c", ".h", ".jinja"}
TIERS = {"quick": ["--quick"], "test": ["-m", "not release"], "release": []}

#: What is no code: comments, also where a template begins one that another one goes on with,
#: strings, lines of the preprocessor and of templates.
NO_CODE = re.compile(
    r'"""[\s\S]*?"""|/\*[\s\S]*?\*/|(?m:^ \*(?:[ /][^\n]*)?$)|//[^\n]*'
    r"|(?m:^[ \t]*#[^\n]*)|#[^\n]*"
    r'|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|\{[%#][\s\S]*?[%#]\}'
)
OPERATORS = {
    **{" + ": " - ", " - ": " + ", " * ": " / ", " / ": " * ", " += ": " -= ", " -= ": " += "},
    **{" < ": " <= ", " <= ": " < ", " > ": " >= ", " >= ": " > ", " == ": " != ", " != ": " == "},
    **{" && ": " || ", " || ": " && ", " and ": " or ", " or ": " and "},
}
OPERATOR = re.compile("|".join(map(re.escape, sorted(OPERATORS, key=len, reverse=True))))
#: A sign in front of a value, a number, a call with simple arguments, and a statement of one line.
SIGN = re.compile(r"(?<=[=(,] )-(?=[\w(])|(?<=\()-(?=[\w(])|(?<=return )-(?=[\w(])")
NUMBER = re.compile(r"(?<![\w.\[])(\d+\.?\d*(?:[eE][-+]?\d+)?)(?![\w.\]])")
CALL = re.compile(r"(?<!def )\b\w+\(([^(),=\n]+), ([^(),=\n]+)(?=[,)])")
STATEMENT = re.compile(
    r"(?m)(?<=^)[ \t]+(?:[^\n;:{}]+ [-+*/]?= [^\n;:{}]+|[\w.>-]+\([^\n;{}]*\));$"
)
TYPES = re.compile(r"\b(const|double|int|size_t|void|static|struct|unsigned|return|import)\b")


@dataclass(frozen=True, slots=True)
class Mutant:
    """A part of a file, and what stands in its place.

    Parameters
    ----------
    path : Path
        The file, relative to the checkout.
    start, end, line : int
        The part of its text, and the line of its start.
    new, old : str
        What is written there, and what stood there.
    """

    path: Path
    start: int
    end: int
    new: str
    line: int
    old: str

    def of(self, text: str) -> str:
        """Text of the file with the mistake."""
        return text[: self.start] + self.new + text[self.end :]

    def __str__(self) -> str:
        return f"{self.path}:{self.line}  {self.old.strip()!r} -> {self.new.strip()!r}"


def mutants_of(path: Path) -> Iterator[Mutant]:
    """Mistakes that the rules find in a file."""
    return filter(is_possible, candidates_of(path))


def one_of(path: Path, draw: random.Random) -> Mutant | None:
    """Mistake of a file, or None if there is none."""
    candidates = [*candidates_of(path)]
    draw.shuffle(candidates)
    return next(filter(is_possible, candidates), None)


def candidates_of(path: Path) -> Iterator[Mutant]:
    """Mistakes that the rules find in a file, with those that are no Python any more."""
    text = (ROOT / path).read_text(encoding="utf-8")
    # As long as the text, so that places are the same; line ends stay for what takes whole lines.
    code = NO_CODE.sub(lambda found: re.sub(r"[^\n]", "\0", found[0]), text)
    for start, end, new in [*changes(code), *(dropped(text) if path.suffix == ".py" else ())]:
        line = text.count("\n", 0, start) + 1
        mutant = Mutant(path, start, end, new, line, text[start:end])
        if "\0" not in code[start:end]:
            yield mutant


def changes(code: str) -> Iterator[tuple[int, int, str]]:
    """Places in a code and what may stand there."""
    for found in OPERATOR.finditer(code):
        yield *found.span(), OPERATORS[found[0]]
    for found in SIGN.finditer(code):
        yield *found.span(), ""
    for found in NUMBER.finditer(code):
        yield *found.span(), "1" if float(found[0]) == 0.0 else f"(2 * {found[0]})"
    for found in CALL.finditer(code):
        if found[1] != found[2] and not TYPES.search(found[0]):
            yield found.start(1), found.end(2), f"{found[2]}, {found[1]}"
    for found in STATEMENT.finditer(code):
        if not TYPES.search(found[0]):
            yield *found.span(), " ;"


def dropped(text: str) -> Iterator[tuple[int, int, str]]:
    """Statements of one line in Python that give no name its first value."""
    starts = [0, *(found.end() for found in re.finditer("\n", text))]
    for node in (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.stmt)):
        is_set = isinstance(node, ast.Assign) and not isinstance(node.targets[0], ast.Name)
        is_call = isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
        if is_set or is_call or isinstance(node, ast.AugAssign):
            line = starts[node.lineno - 1]
            if node.lineno == node.end_lineno and text[line : starts[node.lineno]].isascii():
                yield line + node.col_offset, line + (node.end_col_offset or 0), "pass"


def is_possible(mutant: Mutant) -> bool:
    """Whether a file of Python can still be parsed."""
    try:
        if mutant.path.suffix == ".py":
            ast.parse(mutant.of((ROOT / mutant.path).read_text(encoding="utf-8")))
    except SyntaxError:
        return False
    return True


def copied(folder: Path) -> Path:
    """Copy of all files of the checkout that git knows or would add.

    What the folder has of them already is written anew.
    """
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).exists() and not (folder / name).is_symlink():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name, follow_symlinks=False)
    return folder


def run(folder: Path, options: list[str], seconds: float | None) -> str:
    """First test that fails in a copy, or what else went wrong; "" if all pass."""
    cache = folder.parent / "cache"  # what a mistake does not change is compiled once for all
    settings = {"PYTHONPATH": str(folder), "KOUSOKU_CACHE": str(cache), "PYTHONHASHSEED": "0"}
    command = [sys.executable, "-m", "pytest", "-x", "--quiet", "-p", "no:cacheprovider", *options]
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            env={**os.environ, **settings},
            capture_output=True,
            text=True,
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return "(no end)"
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.M)
    return failed[1] if failed else "" if done.returncode == 0 else "(no test ran)"


def main() -> int:
    """Make mistakes, and print which of them are noticed; return how many are not."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("paths", nargs="+", help="files and folders of sources")
    parser.add_argument("--list", action="store_true", help="print all mistakes and make none")
    parser.add_argument("--run", type=int, default=10, metavar="N", help="how many are made")
    parser.add_argument("--seed", type=int, default=1981)
    parser.add_argument("--tier", choices=TIERS, nargs="+", default=["quick"])
    parser.add_argument("--tests", nargs="*", default=["tests"], help="files or folders of tests")
    parser.add_argument("--processes", default="2", help="of pytest")
    given = parser.parse_args()
    found = [ROOT / path for path in given.paths]
    files = [p for path in found for p in (sorted(path.rglob("*")) if path.is_dir() else [path])]
    sources = [path.relative_to(ROOT) for path in files if path.suffix in SUFFIXES]
    mutants = [mutant for path in sources for mutant in mutants_of(path)]
    if given.list:
        print(*mutants, sep="\n")
        return 0
    common = ["--numprocesses", given.processes, *given.tests]
    tiers = {name: [*TIERS[name], *common] for name in given.tier}
    chosen = random.Random(given.seed).sample(mutants, min(given.run, len(mutants)))
    survived = 0
    with tempfile.TemporaryDirectory(prefix="kousoku-mutants-") as temporary:
        folder, patience = copied(Path(temporary, "checkout")), {}
        for tier, options in tiers.items():
            start = time.monotonic()
            if wrong := run(folder, options, None):
                sys.exit(f"the tests fail without any mistake: {wrong}")
            patience[tier] = 60.0 + 3.0 * (time.monotonic() - start)
        for mutant in chosen:
            whole = (ROOT / mutant.path).read_text(encoding="utf-8")
            (folder / mutant.path).write_text(mutant.of(whole), encoding="utf-8", newline="\n")
            found_by = ((t, run(folder, options, patience[t])) for t, options in tiers.items())
            tier, by = next(((tier, by) for tier, by in found_by if by), ("", ""))
            (folder / mutant.path).write_text(whole, encoding="utf-8", newline="\n")
            survived += not by
            print(f"{f'{tier:8}' if by else 'SURVIVED'}  {mutant}  {by}", flush=True)
    print(f"{len(chosen) - survived} of {len(chosen)} are noticed, out of {len(mutants)}")
    return min(survived, 1)


if __name__ == "__main__":
    sys.exit(main())
