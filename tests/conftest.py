"""Fixtures that tests of several folders share."""

from __future__ import annotations

import difflib
import signal
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from kousoku.model.errors import NoCompilerError
from kousoku.runtime.toolchain import find_toolchain

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from kousoku.runtime.toolchain import Toolchain

TESTS = Path(__file__).parent


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden", action="store_true", help="write the golden files instead of comparing"
    )


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
    """Return this machine's C compiler; without one the test is skipped."""
    try:
        return find_toolchain()
    except NoCompilerError as error:
        pytest.skip(f"no C compiler: {error}")


@pytest.fixture(params=["numpy", "c"])
def backend(request: pytest.FixtureRequest) -> str:
    """Run a test once for each target; for C only where there is a compiler."""
    if request.param == "c":
        request.getfixturevalue("compiler")
    return str(request.param)


@pytest.fixture
def rng() -> np.random.Generator:
    """Return random numbers that are the same in every run."""
    return np.random.default_rng(1981)
