"""The tiers of the tests, what is made once for all of them, and fixtures that folders share.

What a test asks for puts it into a tier: with the fixture ``compiler`` it compiles, with
``numpy_solver`` the solver of a scene makes steps in NumPy, in the folder ``release`` it is for a
release. A test that asks for less than it does fails. ``make test`` runs all but those for a
release. ``make quick`` leaves out also those that compile or make steps in NumPy, those that
``slow.txt`` lists, and of a test with many parameters all but its first two sets of them.
``make slow`` measures the tests and writes ``slow.txt``.
"""

from __future__ import annotations

import difflib
import hashlib
import os
import shutil
import signal
import tempfile
from collections import Counter
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import HealthCheck, settings
from msgspec.structs import astuple
from xdist.scheduler import LoadScopeScheduling

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.errors import NoCompilerError
from kousoku.runtime.dynamics_targets import NumpySolver
from kousoku.runtime.lock import locked
from kousoku.runtime.toolchain import find_toolchain

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterator

    from kousoku.model.records.scene import Scene
    from kousoku.runtime.toolchain import Toolchain
    from kousoku.symbolic.derivation import Derivation

TESTS = Path(__file__).parent
#: The mark that a fixture gives to all tests that ask for it.
MARKS = {
    "compiler": "compiles",
    "numpy_solver": "numpy_solver",
    "shipped_flags": "shipped_flags",
    "tiny": "extension",
    "warm_package": "extension",
}
#: What the compiler of a test without the fixture is called; its error says what is missing.
NOT_ASKED_FOR = "the fixture 'compiler' of the test"
#: Bits are the same without optimising, in a fifth of the compiler's time; the last flag wins. Zig
#: would look for undefined behaviour then.
QUICK_TO_COMPILE = "-O0 -fno-sanitize=undefined"
#: The Tiny C Compiler takes a twentieth of that, where it is installed. It makes no extensions of
#: Python, and no libraries without start-up code.
TINY_C = """#!/bin/sh
for word; do shift; [ "$word" = -nostartfiles ] || set -- "$@" "$word"; done
exec tcc "$@"
"""
#: Tests by their ids without parameters, of which a case took too long for ``make quick``.
SLOW = TESTS / "slow.txt"
TOO_LONG = 0.25
#: Files with tests of many seconds.
LONG = {"tests/release/test_stress.py", "tests/release/test_reproducibility.py"}
FOUND_SLOW = pytest.StashKey[set[str]]()
NOT_QUICK = {"compiles", "numpy_solver", "release"}
#: What ``make quick`` takes of a test with many sets of parameters.
CASES = 2


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden", action="store_true", help="write the golden files instead of comparing"
    )
    parser.addoption("--quick", action="store_true", help="what takes no compiler and little time")
    parser.addoption("--but-quick", action="store_true", help="what --quick leaves out")
    parser.addoption(
        "--record-slow", action="store_true", help=f"write {SLOW.name}; not with several processes"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Let all processes of a run share what they generate and compile, and remove it after."""
    config.stash[FOUND_SLOW] = set()
    # Examples are slow where the machine has more to do; the first one reads all sources.
    settings.register_profile(
        "kousoku", deadline=None, suppress_health_check=[HealthCheck.too_slow]
    )
    settings.load_profile("kousoku")
    if "KOUSOKU_TESTS_SHARE" not in os.environ:
        shared = tempfile.mkdtemp(prefix="kousoku-tests-")
        os.environ["KOUSOKU_TESTS_SHARE"] = shared
        os.environ.setdefault("KOUSOKU_CACHE", str(Path(shared, "cache")))
        if shutil.which("tcc") and "KOUSOKU_CC" not in os.environ:
            tiny = Path(shared, "tiny-c")
            tiny.write_text(TINY_C, encoding="utf-8")
            tiny.chmod(0o755)
            os.environ["KOUSOKU_TESTS_TINY_C"] = str(tiny)
        config.add_cleanup(lambda: shutil.rmtree(shared, ignore_errors=True))


def together(nodeid: str) -> str:
    """Key that tests of one process have in common: their file, and what fixtures make for it.

    In long files only tests with the same first parameter share anything.
    """
    file = nodeid.partition("::")[0]
    return nodeid.partition("-")[0] if file in LONG else file


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> LoadScopeScheduling:
    """Scheduler that distributes the tests to processes."""
    scheduler = LoadScopeScheduling(config, log)
    scheduler._split_scope = together
    return scheduler


def long_first(items: list[pytest.Item]) -> None:
    """Order tests so that at the end no process waits long for another one."""
    files = [item.nodeid.partition("::")[0] for item in items]
    counts = Counter(files)
    order = sorted(range(len(items)), key=lambda k: (files[k] not in LONG, -counts[files[k]]))
    items[:] = [items[k] for k in order]


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark tests by what they ask for and by where they are, and choose the quick ones."""
    for item in items:
        for fixture in MARKS.keys() & set(getattr(item, "fixturenames", ())):
            item.add_marker(MARKS[fixture])
        if TESTS / "release" in item.path.parents:
            item.add_marker("release")
    if hasattr(config, "workerinput"):
        long_first(items)
    if config.getoption("--quick") or config.getoption("--but-quick"):
        slow, seen = set(SLOW.read_text(encoding="utf-8").split()), Counter[str]()
        chosen: dict[bool, list[pytest.Item]] = {True: [], False: []}
        for item in items:
            name = item.nodeid.partition("[")[0]
            is_quick = name not in slow and not marks_of(item) & NOT_QUICK
            seen[name] += is_quick
            chosen[is_quick and seen[name] <= CASES].append(item)
        wanted = config.getoption("--quick")
        config.hook.pytest_deselected(items=chosen[not wanted])
        items[:] = chosen[wanted]


def marks_of(item: pytest.Item) -> set[str]:
    """Names of a test's marks."""
    return {mark.name for mark in item.iter_markers()}


def processor_time() -> float:
    """Seconds that this process and those that it waited for have computed."""
    return sum(os.times()[:4])


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Take from a test what it has not asked for: the compiler, and steps in NumPy."""
    marks, start = marks_of(item), processor_time()
    with pytest.MonkeyPatch.context() as patch:
        if not marks & {"release", "shipped_flags"} and "KOUSOKU_CFLAGS" not in os.environ:
            if "KOUSOKU_TESTS_TINY_C" in os.environ and "extension" not in marks:
                patch.setenv("KOUSOKU_CC", os.environ["KOUSOKU_TESTS_TINY_C"])
            else:
                patch.setenv("KOUSOKU_CFLAGS", QUICK_TO_COMPILE)
        if not marks & {"release", "compiles"}:
            patch.setenv("KOUSOKU_CC", NOT_ASKED_FOR)
        if not marks & {"release", "numpy_solver"}:
            patch.setattr(NumpySolver, "run", _refuse_steps)
        result = yield
    if not marks & NOT_QUICK and processor_time() - start > TOO_LONG:
        item.config.stash[FOUND_SLOW].add(item.nodeid.partition("[")[0])
    return result


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Write the list of slow tests, where that is asked for."""
    if session.config.getoption("--record-slow"):
        names = session.config.stash[FOUND_SLOW]
        SLOW.write_text("\n".join([*sorted(names), ""]), encoding="utf-8", newline="\n")


def _refuse_steps(*_: object) -> None:
    pytest.fail("a test that makes steps in NumPy needs the fixture 'numpy_solver'", pytrace=False)


@pytest.fixture(scope="session")
def derived() -> Callable[[str], Derivation]:
    """``derive`` with a memory."""
    # SymPy takes a third of a second to import, and most tests need none of it.
    from kousoku.symbolic import derive

    return cache(derive)


@pytest.fixture
def empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folder of a cache that nothing is in yet; it is made when it is first written to."""
    monkeypatch.setenv("KOUSOKU_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def interrupts() -> Iterator[None]:
    """Let SIGINT raise KeyboardInterrupt, also where the tests were started in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def golden(request: pytest.FixtureRequest) -> Callable[[str], None]:
    """Compare a text with ``tests/golden/<test module>/<test name>.txt``."""
    folder = TESTS / "golden" / request.path.stem
    path = folder / f"{request.node.name}.txt"

    def check(text: str) -> None:
        if request.config.getoption("--update-golden"):
            folder.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8", newline="\n")
            return
        wanted = path.read_text(encoding="utf-8") if path.exists() else ""
        difference = difflib.unified_diff(
            wanted.splitlines(keepends=True), text.splitlines(keepends=True), "committed", "now"
        )
        if text != wanted:
            pytest.fail(
                f"{path.name} differs; if that is meant:"
                f" pytest --update-golden {request.node.nodeid}\n{''.join(difference)}",
                pytrace=False,
            )

    return check


@pytest.fixture(scope="session")
def compiler() -> Toolchain:
    """Compiler of C on this machine, as it is for users; without one the test is skipped."""
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("KOUSOKU_CFLAGS", raising=False)
        if "KOUSOKU_TESTS_TINY_C" in os.environ:
            patch.delenv("KOUSOKU_CC", raising=False)
        try:
            return find_toolchain()
        except NoCompilerError as error:
            pytest.skip(f"no C compiler: {error}")


@pytest.fixture
def shipped_flags() -> None:
    """Compile with the flags that users have; no other test of ``make test`` does.

    These are the bits of C and NumPy, the committed packages, and what is compiled by hand with
    ``compiler.compile_command``.
    """


@pytest.fixture
def numpy_solver() -> None:
    """Let the solver of a scene of bodies make steps in NumPy, 100 to 200 times slower than C."""


@pytest.fixture(params=["numpy", pytest.param("c", marks=pytest.mark.compiles)])
def backend(request: pytest.FixtureRequest) -> str:
    """Run a test of kernels once for each target; for C only where there is a compiler."""
    if request.param == "c":
        request.getfixturevalue("compiler")
    return str(request.param)


@pytest.fixture(scope="session")
def shared_tree() -> Callable[[str, object, Callable[[], dict[str, str]]], Path]:
    """Folder by its name and its key, made by the first of all tests that wants it."""

    def find(name: str, key: object, make: Callable[[], dict[str, str]]) -> Path:
        digest = hashlib.sha256(repr(key).encode()).hexdigest()[:24]
        shelf = Path(os.environ["KOUSOKU_TESTS_SHARE"], digest)
        with locked(shelf.with_suffix(".lock"), until=shelf.exists):
            if not shelf.exists():
                work = Path(tempfile.mkdtemp(dir=shelf.parent))
                write_tree(work / name, make())
                work.rename(shelf)
        return shelf / name

    return find


@pytest.fixture(scope="session")
def bodies_folder(shared_tree: Callable[..., Path]) -> Callable[..., Path]:
    """Folder of the solver of a scene of bodies, generated once for its outputs."""

    def folder(scene: Scene, outputs: tuple[str, ...] = (), **options: Any) -> Path:
        key = ("bodies", astuple(scene), outputs, options)
        return shared_tree(scene.name, key, lambda: generate_dynamics(scene, outputs, **options))

    return folder


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers that are the same in every run."""
    return np.random.default_rng(1981)


@pytest.fixture
def bead() -> dict[str, Any]:
    """Tables of a bead on the x axis, new for each test."""
    return {
        "name": "bead",
        "unit": "cm",
        "parameters": {"at": 1.0},
        "bodies": {"bead": {"position": [0, 0, 0], "point": True, "mass": 1}},
        "coordinates": {"x": {"body": "bead", "along": [1, 0, 0]}},
    }
