#!/usr/bin/env python3
"""The tasks of a checkout: ``python tasks.py demo``, ``python tasks.py test`` and others.

They need Python 3.11 or newer and nothing else, on Linux, macOS and Windows; ``make demo`` calls
the same. All that is installed goes into ``.venv``, made on first use.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
PYTHON = BIN / ("python.exe" if os.name == "nt" else "python")
OLDEST = (3, 11)
#: Exit status where a command is cut by hand, and how often that is tried before it is ended.
CUT, PATIENT = 130, 4
#: What a link of ``kousoku/`` leads to; a checkout without links has text files in their place.
SOURCES = ("codegen", "generated", "kousoku", "ledger", "model", "runtime", "symbolic")

KOUSOKU = ("-m", "kousoku")
PYTEST = ("-m", "pytest", "--quiet")
# tests/conftest.py says which process runs a test, and when.
PARALLEL = (*PYTEST, "--numprocesses", "auto", "--dist", "loadscope", "--no-loadscope-reorder")

#: Extras that are installed, commands, and what is said first. A command is arguments of Python,
#: or clang-format; the last may be ``> file``. TESTS stands for what follows the name of the task.
TASKS: dict[str, tuple[str, list[tuple[str, ...]], str]] = {
    "demo": (
        "plot",
        [
            (*KOUSOKU, "derive", "p2"),
            (*KOUSOKU, "generate"),
            (*KOUSOKU, "verify"),
            ("docs/examples/demo.py",),
        ],
        "derives a constraint, generates and verifies all packages, moves a closed loop in space:"
        " 90 s on two cores the first time, 20 s then",
    ),
    "quick": (
        "test",
        [(*PARALLEL, "--quick", "TESTS")],
        "the tests for while you work, without a compiler: a minute on two cores",
    ),
    "test": (
        "test",
        [(*PARALLEL, "-m", "not release", "TESTS")],
        "all that must hold on a user's machine: 5 minutes on two cores",
    ),
    "release-test": (
        "test,browser",
        [(*PARALLEL, "-m", "release", "TESTS")],
        "besides: all proofs, notebooks, packaging, reproducibility: 6 minutes on two cores",
    ),
    "slow": (
        "test",
        [(*PYTEST, "-m", "not (compiles or numpy_solver or release)", "--record-slow", "TESTS")],
        "measures which tests take too long for quick: 5 minutes",
    ),
    "stress": (
        "test",
        [("-m", "tests.stress")],
        "looks for what breaks kousoku: two minutes on two cores, hours with FULL=1",
    ),
    "environment": (
        "test,lint,plot,browser",
        [],
        "installs at once what the other tasks need: a minute",
    ),
    "lint": (
        "lint",
        [
            ("-m", "ruff", "check", "."),
            ("-m", "ruff", "format", "--check", "."),
            ("clang-format", "--dry-run", "-Werror", "runtime/*/*.h"),
        ],
        "how Python and C are written: 5 s",
    ),
    "types": ("test,lint", [("-m", "mypy")], "checks the types: a minute"),
    "generate-check": (
        "plot",
        [(*KOUSOKU, "generate", "--check")],
        "derives all kinds: is generated/ what the generator emits today? 80 s the first time",
    ),
    "notebook": (
        "notebook",
        [("-m", "jupyter", "lab", "notebooks/first_mechanism.ipynb")],
        "opens the first mechanism in Jupyter",
    ),
    "notebooks": (
        "test",
        [(*PYTEST, "tests/release/test_notebooks.py")],
        "executes the notebooks again and compares their outputs: 2 minutes",
    ),
    "ledger": (
        "test",
        [
            ("-m", "kousoku.ledger.index"),
            (*KOUSOKU, "ledger", "--latex", "> docs/ledger.tex"),
            (*KOUSOKU, "ledger", "--markdown", "> docs/ledger.md"),
            (*PYTEST, "--update-golden", "tests/ledger/test_proofs.py"),
        ],
        "writes the ledger's index and pages anew, after its entries: a minute",
    ),
    "bench": (
        "bench",
        [("-m", "tests.benchmarks")],
        "run time against error, beside other tools: 3 minutes on two cores, an hour with FULL=1",
    ),
    "compiler": ("compiler", [], "installs a C compiler as a Python package: 20 s"),
    "clean": ("", [], "removes .venv, build, dist and plots"),
}


def main(arguments: list[str]) -> int:
    """Run one task, and return its exit status."""
    if not arguments or arguments[0] not in TASKS:
        wanted = "\n".join(f"  {name:15} {task[2]}" for name, task in TASKS.items())
        print("usage: python tasks.py TASK [TESTS]\n" + wanted, file=sys.stderr)
        return 0 if arguments[:1] in (["--help"], ["-h"]) else 2
    name, tests = arguments[0], arguments[1:] or ["tests"]
    extras, commands, about = TASKS[name]
    if arguments[1:] and not any("TESTS" in command for command in commands):
        print(f"tasks.py {name}: takes no arguments, got {arguments[1:]}", file=sys.stderr)
        return 2
    os.chdir(ROOT)
    print(f"{name}: {about}", flush=True)
    if name == "clean":
        for folder in (VENV, ROOT / "build", ROOT / "dist", ROOT / "plots"):
            shutil.rmtree(folder, ignore_errors=True)
        return 0
    start = time.monotonic()
    status = install(extras.split(","))
    for command in commands:
        status = status or run(command, tests)
    took = time.monotonic() - start
    print(f"{name}: {'failed' if status else 'done'} after {took:.0f} s", flush=True)
    return status


def run(command: tuple[str, ...], tests: list[str]) -> int:
    """Run a command of a task in ``.venv``, and return its exit status."""
    words = []
    for word in command:
        words += tests if word == "TESTS" else files(word) if "*" in word else [word]
    target = words.pop()[2:] if words[-1].startswith("> ") else ""
    shown = words[1:] if words[:2] == list(KOUSOKU) else ["python", *words]
    is_program = words[0] == "clang-format"
    print("$", *(command if is_program else shown), flush=True)
    line = [str(BIN / words[0]), *words[1:]] if is_program else [str(PYTHON), *words]
    # Lines that a task prints come at once, and are UTF-8 also where a console is not.
    environment = dict(os.environ, PYTHONUNBUFFERED="1", PYTHONUTF8="1")
    # Tests start many processes: what Python compiled for one serves all that follow.
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    if not target:
        return ended(subprocess.Popen(line, env=environment))
    with Path(target).open("w", encoding="utf-8", newline="\n") as file:
        return ended(subprocess.Popen(line, env=environment, stdout=file))


def ended(process: subprocess.Popen[bytes]) -> int:
    """Return the exit status of a command once it has ended.

    Ctrl-C reaches the command, too, which then puts in order what it began: it is waited for, as
    `subprocess.call` does no longer than a quarter of a second.
    """
    for n in range(PATIENT):
        try:
            status = process.wait()
        except KeyboardInterrupt:
            continue
        return status or (CUT if n else 0)
    process.kill()
    return CUT


def install(extras: list[str]) -> int:
    """Make ``.venv`` and install kousoku with extras, where that is not done; return the status."""
    wanted = digest()
    stamps = [VENV / f".has-{extra}" for extra in extras]
    if PYTHON.exists() and all(s.exists() and s.read_text() == wanted for s in stamps):
        return 0
    if not PYTHON.exists():
        found = python_for_venv()
        if found is None:
            print(
                f"kousoku needs Python {OLDEST[0]}.{OLDEST[1]} or newer, this is"
                f" {sys.version.split()[0]}; run tasks.py with a newer one, or name it:"
                " make PYTHON=/path/to/python3",
                file=sys.stderr,
            )
            return 2
        print(f"making .venv with {found}", flush=True)
        if subprocess.call([found, "-m", "venv", "--clear", str(VENV)]):
            print("no venv: on Debian and Ubuntu: apt install python3-venv", file=sys.stderr)
            return 2
    print(f"installing kousoku[{','.join(extras)}] into .venv: 30 s", flush=True)
    command = [str(PYTHON), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    status = subprocess.call([*command, "--editable", f".[{','.join(extras)}]"])
    if status == 0:
        for stamp in stamps:
            stamp.write_text(wanted)
    return status


def has_links() -> bool:
    """Whether git made the links of ``kousoku/``, which type checkers and editors follow."""
    return (ROOT / "kousoku" / "model").is_dir()


def digest() -> str:
    """Digest of what decides whether kousoku is installed again.

    That is ``pyproject.toml``; and where there are no links, all sources: what type checkers follow
    then is a second tree of files, which does not see new and replaced ones by itself.
    """
    total = hashlib.sha256((ROOT / "pyproject.toml").read_bytes())
    if not has_links():
        for folder in SOURCES:
            for path in sorted((ROOT / folder).rglob("*")):
                if path.is_file() and "__pycache__" not in path.parts:
                    total.update(str(path.relative_to(ROOT)).encode())
                    total.update(path.read_bytes())
    return total.hexdigest()


def files(pattern: str) -> list[str]:
    """Files of the checkout that a pattern stands for."""
    return sorted(path.as_posix() for path in Path().glob(pattern))


def python_for_venv() -> str | None:
    """Python that is new enough: this one, or one of the PATH."""
    if sys.version_info >= OLDEST:
        return sys.executable
    for name in ("python3.14", "python3.13", "python3.12", "python3.11", "python3", "python"):
        found = shutil.which(name)
        check = f"import sys; sys.exit(sys.version_info < {OLDEST})"
        if found and subprocess.call([found, "-c", check], stderr=subprocess.DEVNULL) == 0:
            return found
    return None


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(CUT)
