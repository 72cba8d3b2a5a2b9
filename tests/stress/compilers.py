"""Compilers, their levels, warnings and sanitizers; none at all; oldest and newest dependencies.

What is computed with each setting is computed by a process of its own, :mod:`compiled`, that has
the setting in its environment, and told as a digest of all bits.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from functools import cache
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

from kousoku.mechanism import Mechanism
from kousoku.runtime.toolchain import find_toolchain
from tests.stress.compiled import contracting, files_of
from tests.stress.kit import ROOT, Fault, Outcome, Question, Size

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager

WANTED = ("gcc", "clang", "zig cc")
OTHERS = tuple(f"{name}-{k}" for name in ("gcc", "clang") for k in range(11, 23))
#: The shipped flags first; what is added to them wins.
LEVELS = ("", "-O0 -fno-sanitize=undefined", "-O2 -fno-sanitize=undefined", "-Os -funroll-loops")
STRICT = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wshadow",
    "-Wconversion",
    "-Wdouble-promotion",
]
SANITIZED = "-g -O1 -fsanitize=address,undefined -fno-sanitize-recover=all"
#: What is computed: packages of kinds, committed scenes, and random ones by their numbers.
QUICK = ("kind point", "scene pendulum", "scene lever_crank")
SCENES = (
    *(
        "lever_crank",
        "engine",
        "loop_free",
        "constant_velocity",
        "bouncing_ball",
        "watt_six_bar",
        "bricard",
        "heavy_top",
    ),
    *("n_four_bar", "oldham_coupling", "gear_train", "andrews_squeezer"),
)
RANDOM = 4
#: Settings in which there is no compiler that works, and what kousoku's command must do.
BROKEN = {
    "switched off": {"KOUSOKU_CC": "none"},
    "not there": {"KOUSOKU_CC": "/nowhere/cc"},
    "does nothing": {"KOUSOKU_CC": "true"},
    "fails": {"KOUSOKU_CC": "false"},
    "knows no such flag": {"KOUSOKU_CFLAGS": "-fno-such-flag"},
    "not in PATH": {"PATH": "/nowhere", "CC": ""},
}


@cache
def compilers() -> dict[str, str]:
    """Compilers of this machine by name; another name of one is none."""
    found: dict[str, str] = {}
    for name in (*WANTED, *OTHERS):
        place = shutil.which(name.split()[0])
        if place is None and name == "zig cc" and find_spec("ziglang"):
            place = "ziglang"
        if place and os.path.realpath(place) not in found.values():
            found[name] = os.path.realpath(place)
    return found


def cases(size: Size) -> Iterator[str]:
    """Name what is computed, with which compiler, and what is looked at."""
    things = [*QUICK]
    if size.is_full:
        things += [f"kind {path.name}" for path in sorted((ROOT / "generated/kinds").glob("*/"))]
        things += [f"scene {name}" for name in SCENES]
        things += [f"random {k}" for k in range(size.seed, size.seed + size.examples(0, RANDOM))]
    yield "missing"
    for thing in dict.fromkeys(things):
        # In little time the first compiler alone takes a linkage.
        for name in compilers() if size.is_full or thing != QUICK[-1] else [*compilers()][:1]:
            yield f"bits|{name}|{thing}|{4 if size.is_full else 2}"
            yield f"warnings|{name}|{thing}"
        if size.is_full or thing == "scene pendulum":
            yield f"sanitizers|gcc|{thing}"
    for name in BROKEN:
        yield f"broken|{name}"
    if size.is_full:
        yield from ("dependencies|oldest", "dependencies|newest")


def run(case: str) -> Outcome:
    """Look at one thing."""
    outcome = Outcome()
    what, *words = case.split("|")
    LOOKS[what](outcome, *words)
    return outcome


def missing(outcome: Outcome) -> None:
    """Count the compilers that this machine lacks."""
    for name in WANTED:
        outcome.count(f"compilers looked for and not found: {name}", int(name not in compilers()))


def told(thing: str, environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    """Compute a thing in a process of its own, with a setting."""
    return subprocess.run(
        [sys.executable, "-m", "tests.stress.compiled", *thing.split()],
        cwd=ROOT,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def bits(outcome: Outcome, compiler: str, thing: str, levels: str) -> None:
    """Compare the bits of levels, and with those of the first compiler."""
    first = ""
    for name in dict.fromkeys((next(iter(compilers())), compiler)):
        for level in LEVELS[: int(levels)]:
            setting = {"KOUSOKU_CC": name, "KOUSOKU_CFLAGS": level}
            done = told(thing, setting)
            outcome.count("computed with a compiler and a level")
            if done.returncode:
                fail(outcome, f"{thing} does not compile or run", setting, thing, done)
            elif (first := first or done.stdout) != done.stdout:
                fail(outcome, f"{thing} has other bits", setting, thing, done)


def warnings(outcome: Outcome, compiler: str, thing: str) -> None:
    """Compile the sources with all warnings that are asked of them."""
    if (files := files_of(thing)) is None:
        return
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            (Path(folder) / name).parent.mkdir(parents=True, exist_ok=True)
            (Path(folder) / name).write_text(text, encoding="utf-8")
        sources = [name for name in files if name.endswith(".c") and "/" not in name]
        with patch.dict(os.environ, {"KOUSOKU_CC": compiler}):
            program = find_toolchain().command  # of a package, where it is in no folder of PATH
        for level, source in product(("-O0", "-O3"), sources):
            command = [*program, *STRICT, level, "-ffp-contract=off", "-c", source, "-o", "one.o"]
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
            number = len(re.findall(r"\b(?:warning|error):", done.stderr))
            place = f"{thing}, {compiler} {level}, {source}"
            outcome.measure("warnings (of a compilation)", number, place)
            outcome.count("sources compiled with all warnings")
            if number or done.returncode:
                outcome.find(f"{compiler} warns of {thing}", done.stderr[:400], " ".join(command))


def sanitizers(outcome: Outcome, compiler: str, thing: str) -> None:
    """Compute with sanitizers of addresses and of undefined behaviour."""
    command = [compiler, "-print-file-name=libasan.so"]
    if shutil.which(compiler) is None:
        outcome.count(f"sanitizers without {compiler}")
        return
    library = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    if not Path(library).is_absolute():
        outcome.count(f"{compiler} without sanitizers")
        return
    setting = {
        "KOUSOKU_CC": compiler,
        "KOUSOKU_CFLAGS": SANITIZED,
        "LD_PRELOAD": library,
        "ASAN_OPTIONS": "detect_leaks=0",
    }
    done = told(thing, setting)
    outcome.count("computed with sanitizers")
    if done.returncode or "runtime error" in done.stderr:
        fail(outcome, f"{thing} is not clean under sanitizers", setting, thing, done)


def broken(outcome: Outcome, name: str) -> None:
    """Move a scene without a compiler that works: with NumPy, or a message of what to do."""
    setting, scene = BROKEN[name], str(ROOT / "scenes" / "pendulum.toml")
    words = ["-m", "kousoku", "simulate", scene, "--end", "0.02", "--samples", "3"]
    done = subprocess.run(
        [sys.executable, *words],
        env={**os.environ, **setting},
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if name == "not in PATH" and find_spec("ziglang") and done.returncode == 0:
        outcome.count("a compiler that is not in PATH: that of a package computes")
        return
    outcome.count(f"a compiler that is broken: {['in NumPy', '', 'refused'][done.returncode % 3]}")
    is_good = done.returncode in {0, 2} and "Traceback" not in done.stderr
    if not is_good or not done.stderr.strip():
        fail(outcome, f"where the compiler {name} kousoku says too little", setting, "", done)
    elif done.returncode == 0 and "NumPy" not in done.stderr:
        fail(outcome, f"where the compiler {name} nobody says what computes", setting, "", done)


def dependencies(outcome: Outcome, which: str) -> None:
    """Install the oldest or newest dependencies that are allowed, verify, and compare the bits."""
    said = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wanted = said["project"]["dependencies"]
    if which == "oldest":
        wanted = [re.sub(r">=([\d.]+).*", r"==\1.*", one) for one in wanted]
    with tempfile.TemporaryDirectory(prefix="kousoku-stress-") as folder:
        python = Path(folder, "bin", "python")
        subprocess.run([sys.executable, "-m", "venv", folder], check=True, capture_output=True)
        pip = [str(python), "-m", "pip", "install", "--quiet", "--upgrade", *wanted]
        done = subprocess.run(pip, capture_output=True, text=True, check=False)
        if done.returncode:
            last = done.stderr.strip().splitlines()[-1]
            outcome.count(f"{which} dependencies cannot be installed here: {last[:80]}")
            return
        # What they emit and compile is theirs: no package of other versions is in their cache.
        own = {"PYTHONPATH": str(ROOT), "KOUSOKU_CACHE": str(Path(folder, "cache"))}
        for words in (["kousoku", "verify"], ["tests.stress.compiled", "scene", "loop_free"]):
            done = subprocess.run(
                [str(python), "-m", *words],
                cwd=ROOT,
                env={**os.environ, **own},
                capture_output=True,
                text=True,
                check=False,
            )
            outcome.count(f"{which} dependencies: commands")
            is_same = words[0] == "kousoku" or done.stdout == told("scene loop_free", {}).stdout
            if done.returncode or not is_same:
                fail(outcome, f"{which} dependencies: {words[0]} is wrong", {}, "", done)


def fail(
    outcome: Outcome,
    title: str,
    setting: dict[str, str],
    thing: str,
    done: subprocess.CompletedProcess[str],
) -> None:
    """Add a finding with what a process said."""
    said = " ".join(f"{name}='{value}'" for name, value in setting.items())
    command = f"(cd {{root}} && {said} python -m tests.stress.compiled {thing})"
    details = f"{said}: exit status {done.returncode}; {done.stdout[-200:]}{done.stderr[-400:]}"
    outcome.find(title, details, command.replace("{root}", "../../../.."))


LOOKS: dict[str, Callable[..., None]] = {
    "missing": missing,
    "bits": bits,
    "warnings": warnings,
    "sanitizers": sanitizers,
    "broken": broken,
    "dependencies": dependencies,
}


def careless() -> AbstractContextManager[object]:
    """Add to the sources of scenes a function in which a double becomes a float."""
    added = {"careless.c": "float careless(double);\nfloat careless(double x) { return x; }\n"}
    right: Any = vars(Mechanism)["files"]
    return patch.object(Mechanism, "files", property(lambda self: right.fget(self) | added))


QUESTION = Question(
    asks="the compilers of this machine at their levels, all warnings, sanitizers, compilers that"
    " do not work: are bits the same, is something warned of, is something not told?",
    in_full="that of all kinds and more scenes, and with the oldest and newest dependencies",
    cases=cases,
    run=run,
    faults=(
        Fault(
            "products and sums that are contracted",
            contracting,
            "bits|gcc|scene engine|2",
            "scene engine has other bits",
        ),
        Fault(
            "a source that is compiled with warnings",
            careless,
            "warnings|gcc|scene pendulum",
            "gcc warns of scene pendulum",
        ),
    ),
)
