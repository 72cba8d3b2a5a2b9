"""Processes that run cases: one that a case ends, or that takes too long, is replaced.

The processor they run on is named here, too: the benchmarks use both.
"""

from __future__ import annotations

import os
import platform
import re
import signal
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any, Generic, TypeVar
from unittest.mock import patch

from kousoku.model.errors import NoCompilerError
from kousoku.runtime.toolchain import find_toolchain
from tests.stress.kit import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from multiprocessing.connection import Connection

    from tests.stress.kit import Question

Key = tuple[str, str]
"""A question's name, and a case's."""

Answered = tuple[Outcome, float]
"""The outcome of a case, and its processor time [s]."""

NOT_ASKED, ASKED = "not asked: no compiler is in reach", "asked without C: no compiler is in reach"
"""What cases that need a compiler count without one, and all others."""

SPAWN = get_context("spawn")
HAS_GROUPS = hasattr(os, "setpgid")

T = TypeVar("T")


class StoppedError(Exception):
    """What a case raises, or how it ended its process."""


def processor() -> str:
    """Name of the processor, as far as the system tells."""
    words = Path("/proc/cpuinfo")
    text = words.read_text(encoding="utf-8") if words.exists() else ""
    found = re.search(r"model name\s*:\s*(.+)", text)
    return found[1] if found else platform.processor() or platform.machine()


def has_compiler() -> bool:
    """Whether a compiler is in reach; one that is named and does not work raises an error."""
    try:
        find_toolchain()
    except NoCompilerError:
        return False
    return True


def run_case(name: str, case: str) -> Answered:
    """Run a case here; without a compiler in reach one that needs it is not, and all count it."""
    start, has_c = sum(os.times()[:4]), has_compiler()
    question: Question = import_module(f"tests.stress.{name}").QUESTION
    is_asked = has_c or not question.needs_compiler
    with patch.dict(os.environ):  # what a case sets, the next one does not see
        outcome = question.run(case) if is_asked else Outcome()
    if not has_c and NOT_ASKED not in outcome.counts:
        outcome.count(ASKED if is_asked else NOT_ASKED)
    return outcome, sum(os.times()[:4]) - start


def _serve(pipe: Connection, answer: Callable[[str, str], Any]) -> None:
    """Run the cases that come through a pipe until it is closed.

    The process and all that it starts are a group, where the system has groups.
    """
    if HAS_GROUPS:
        os.setpgid(0, 0)
    while True:
        try:
            name, case = pipe.recv()
        except (EOFError, ConnectionError):
            return
        with suppress(ConnectionError):  # the process that asked is gone
            try:
                pipe.send(answer(name, case))
            except Exception as error:
                pipe.send(f"{type(error).__name__}: {error}")


class Worker(Generic[T]):
    """A process that runs one case after the other, and one in its place when it is gone.

    Parameters
    ----------
    answer : callable
        Runs a case there, by the name of its question and its own; what it returns is no text.
    """

    def __init__(self, answer: Callable[[str, str], T]) -> None:
        self._answer, self._is_over = answer, False
        self._start()

    def _start(self) -> None:
        self._pipe, other = SPAWN.Pipe()
        # It may have children of its own: cases start and kill processes.
        self._process = SPAWN.Process(target=_serve, args=(other, self._answer))
        self._process.start()
        other.close()

    def run(self, name: str, case: str, seconds: float) -> T:
        """Run a case there.

        Raises
        ------
        StoppedError
            It raised something, ended its process, or took longer than so many seconds.
        """
        try:
            self._pipe.send((name, case))
            if not self._pipe.poll(seconds):
                self._replace()
                raise StoppedError(f"takes longer than {seconds:g} s")
            answer: T | str = self._pipe.recv()
        except (EOFError, OSError) as error:
            self._process.join()
            status = self._process.exitcode
            self._replace()
            raise StoppedError(f"ended its process, exit status {status}") from error
        if isinstance(answer, str):
            raise StoppedError(answer)
        return answer

    def _replace(self) -> None:
        self._end()
        if not self._is_over:
            self._start()

    def stop(self) -> None:
        """End the process and those that it started, whatever they do, and start no other."""
        self._is_over = True
        self._end()

    def _end(self) -> None:
        self._pipe.close()
        self._process.kill()
        if HAS_GROUPS and self._process.pid is not None:
            with suppress(ProcessLookupError):  # it has no group yet, or nobody is in it any more
                os.killpg(self._process.pid, signal.SIGKILL)
        self._process.join()


def run_cases(
    keys: Iterable[Key], seconds: dict[str, float], processes: int
) -> Iterator[tuple[Key, Answered | StoppedError]]:
    """Cases as they end, with their outcomes or why there is none.

    Parameters
    ----------
    keys : iterable of (str, str)
        The cases.
    seconds : dict of float
        The longest time that a case of a question may take.
    processes : int
        How many run at the same time.
    """
    workers = [Worker(run_case) for _ in range(processes)]
    idle: SimpleQueue[Worker[Answered]] = SimpleQueue()
    for worker in workers:
        idle.put(worker)

    def run(key: Key) -> Answered | StoppedError:
        worker = idle.get()
        try:
            return worker.run(*key, seconds[key[0]])
        except StoppedError as error:
            return error
        finally:
            idle.put(worker)

    threads = ThreadPoolExecutor(processes)
    try:
        running = {threads.submit(run, key): key for key in keys}
        for future in as_completed(running):
            yield running[future], future.result()
    finally:
        threads.shutdown(wait=False, cancel_futures=True)
        for worker in workers:
            worker.stop()
