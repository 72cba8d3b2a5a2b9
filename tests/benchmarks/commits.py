"""Two commits: what this tree evaluates more often, emits more of, or takes longer for.

``make bench BASE=<commit>`` checks that commit out into a temporary folder and measures both trees
with caches of their own, in the same environment. Counts are exact and may not rise by more than
3 %.

Times are those of the processor, which other programs disturb less than the clock on the wall, and
are judged by how much the same code differs from itself. Each tree runs in two processes, so
that there are pairs of both kinds: two processes of one tree, and both trees. A repeat starts all
four anew, since where the system puts memory and code stays for the life of a process; they run in
turn. The spread is the largest ratio of a pair of one tree in all repeats, and at least 2 %. A time
is beyond it where the median ratio of the two trees, over the repeats, is. With three repeats there
are six pairs of one tree, and for a false alarm two ratios of three have to exceed them all on the
same side. On a busy machine pairs of both kinds are far apart, and less is found.
"""

from __future__ import annotations

import json
import math
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.progress import Progress

from kousoku.model.files.cache import write_atomically
from tests.benchmarks.kit import Size, duration, end_group, matches, table

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

ROOT = Path(__file__).parents[2]
SIDE = Path(__file__).with_name("commit_side.py")
#: The most that a count may rise, and the least that a time has to.
MORE, LEAST_SPREAD = 1.03, 1.02
REPEATS, QUICK_REPEATS = 5, 3
#: Seconds that each process runs in a round, most rounds, and most seconds of all of them: short
#: ones, so that some are not disturbed.
SLICE, ROUNDS, SPENT = 0.005, 20, 1.0
#: A second, but for scenes that move faster or that are large [s].
ENDS = {
    "andrews_squeezer": 0.05,
    "andrews_squeezer_a03": 0.05,
    "families/chain_100": 0.2,
    "families/chain_1000": 0.02,
    "families/n_four_bar_40": 1.0,
}
QUICK_SCENES = (
    *("pendulum", "loop_free", "heavy_top", "bricard", "andrews_squeezer", "engine"),
    *("families/chain_100", "families/n_four_bar_40"),
)
QUICK_KINDS = ("p2", "rigid_body", "spring_damper")
#: The scene whose way from empty caches is timed in each repeat.
COLD = "families/chain_10"


class CommitError(Exception):
    """A commit is not there, or git is not; the text says so."""


class CannotError(Exception):
    """A side cannot run what it opened; the text says why."""


Trees = dict[str, Path]
"""The folders of ``base`` and ``head``."""


@dataclass(frozen=True, slots=True)
class Count:
    """A number that a tree has exactly.

    Parameters
    ----------
    where, what : str
        The scene or the kind, and what is counted.
    base, head : float
        In both trees.
    """

    where: str
    what: str
    base: float
    head: float

    @property
    def is_worse(self) -> bool:
        """Whether it rose too much."""
        return self.head > MORE * self.base

    @property
    def is_better(self) -> bool:
        """Whether it fell as much."""
        return self.base > MORE * self.head

    def __str__(self) -> str:
        return f"{self.where}: {self.what} {self.base:g} -> {self.head:g}"


@dataclass(frozen=True, slots=True)
class Time:
    """Time that something takes.

    Parameters
    ----------
    what : str
        The scene or kernel, and how it is run.
    base, head : float [s]
        The fastest in both trees.
    ratios : list of float
        Of the two trees, repeat by repeat.
    same : list of float
        Of two processes of one tree, larger than one or smaller.
    """

    what: str
    base: float
    head: float
    ratios: list[float]
    same: list[float]

    @property
    def ratio(self) -> float:
        """The median ratio of the trees."""
        return statistics.median(self.ratios)

    @property
    def spread(self) -> float:
        """The largest ratio of two processes of one tree."""
        return max(LEAST_SPREAD, *(max(x, 1 / x) for x in self.same))

    @property
    def is_worse(self) -> bool:
        """Whether it takes longer, beyond the spread."""
        return self.ratio > self.spread

    @property
    def is_better(self) -> bool:
        """Whether it takes less time, beyond the spread."""
        return self.ratio < 1 / self.spread

    def __str__(self) -> str:
        return (
            f"{self.what}: {duration(self.base)} -> {duration(self.head)}, ratio {self.ratio:.3f},"
            f" spread {self.spread:.3f}"
        )


@dataclass(slots=True)
class Times:
    """The seconds of all processes, by what ran: of each repeat two of the base and two of this."""

    found: dict[str, list[tuple[list[float], list[float]]]] = field(default_factory=dict)

    def add(self, what: str, base: list[float], head: list[float]) -> None:
        """Add a repeat."""
        self.found.setdefault(what, []).append((base, head))

    def judged(self) -> list[Time]:
        """Comparisons with their ratios."""
        return [
            Time(
                what,
                min(min(base) for base, _ in repeats),
                min(min(head) for _, head in repeats),
                [min(head) / min(base) for base, head in repeats],
                [one[1] / one[0] for both in repeats for one in both],
            )
            for what, repeats in self.found.items()
        ]


@dataclass(slots=True)
class Comparison:
    """Comparison of two commits.

    Parameters
    ----------
    counts, times : list of Count, list of Time
        What both trees have.
    moved : dict of float
        By how much bodies of a scene are elsewhere in the end.
    left_out : dict of str
        What cannot be compared, and why.
    opened : list of str
        What was.
    """

    counts: list[Count] = field(default_factory=list)
    times: list[Time] = field(default_factory=list)
    moved: dict[str, float] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    opened: list[str] = field(default_factory=list)

    @property
    def worse(self) -> list[Count | Time]:
        """Quantities that rose too much."""
        every: list[Count | Time] = [*self.counts, *self.times]
        return [one for one in every if one.is_worse]

    @property
    def better(self) -> list[Count | Time]:
        """Quantities that fell clearly."""
        every: list[Count | Time] = [*self.counts, *self.times]
        return [one for one in every if one.is_better]


class Process:
    """A process of a side.

    Parameters
    ----------
    side : str
        ``base`` or ``head``.
    tree, cache : Path
        The tree that it imports, and its cache.
    """

    def __init__(self, side: str, tree: Path, cache: Path) -> None:
        self.side = side
        self._process = subprocess.Popen(
            [sys.executable, "-P", str(SIDE), str(tree)],
            cwd=cache.parent,
            env={**os.environ, "PYTHONPATH": str(tree), "KOUSOKU_CACHE": str(cache)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,  # what cuts this process does not cut it, too: end() does
        )

    def ask(self, **command: Any) -> dict[str, Any]:
        """Answer to a command.

        Raises
        ------
        RuntimeError
            The process ended.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        print(json.dumps(command), file=self._process.stdin, flush=True)
        said = self._process.stdout.readline()
        if not said:
            raise RuntimeError(f"the process of {self.side} ended: {self._process.wait()}")
        found: dict[str, Any] = json.loads(said)
        return found

    def cold(self) -> float | None:
        """Seconds of loading a scene from empty caches, None where it cannot."""
        found = self.ask(**scene(COLD), cold=True)
        return None if "cannot" in found else float(found["seconds"])

    def end(self) -> None:
        """End it, and the compiler that it may have started."""
        end_group(self._process)


@contextmanager
def checked_out(commit: str) -> Iterator[Path]:
    """Give a folder with the tree of a commit.

    Raises
    ------
    CommitError
        There is no such commit, or no git.
    """
    with tempfile.TemporaryDirectory(prefix="kousoku-base-") as name:
        tree = Path(name) / "tree"
        try:
            git("worktree", "add", "--detach", "--quiet", str(tree), commit)
            yield tree
        finally:
            with uncut(), suppress(CommitError):  # where it was not added
                git("worktree", "remove", "--force", "--force", str(tree))


@contextmanager
def uncut() -> Iterator[None]:
    """Let nobody cut a block by hand: it puts the repository in order."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def git(*words: str) -> str:
    """Output of git.

    Raises
    ------
    CommitError
        It fails; its message is passed on.
    """
    try:
        done = subprocess.run(
            ["git", *words], cwd=ROOT, capture_output=True, text=True, check=False
        )
    except OSError as error:
        raise CommitError(f"BASE needs git: {error}") from error
    if done.returncode:
        raise CommitError(f"git {words[0]}: {done.stderr.strip()}")
    return done.stdout.strip()


def scenes(size: Size) -> list[str]:
    """Committed scenes that are compared."""
    if not size.is_full:
        return list(QUICK_SCENES)
    folder = ROOT / "scenes"
    found = [*folder.glob("*.toml"), *folder.glob("families/*.toml")]
    return sorted(path.relative_to(folder).with_suffix("").as_posix() for path in found)


def kinds(size: Size) -> list[str]:
    """Committed kinds that are compared."""
    folder = ROOT / "generated" / "kinds"
    every = sorted(path.parent.name for path in folder.glob("*/manifest.json"))
    return every if size.is_full else [name for name in every if name in QUICK_KINDS]


def scene(name: str) -> dict[str, Any]:
    """Command that opens a scene."""
    file = str(ROOT / "scenes" / f"{name}.toml")
    return {"do": "scene", "name": name, "file": file, "end": ENDS.get(name, 1.0)}


def names(size: Size) -> list[str]:
    """Names of all that is compared."""
    return [*scenes(size), *kinds(size)]


def commands(size: Size, only: Sequence[str]) -> list[dict[str, Any]]:
    """Commands that processes open: scenes as this tree has them, and its own kinds."""
    opens = {name: scene(name) for name in scenes(size)}
    opens |= {name: {"do": "kernels", "package": name} for name in kinds(size)}
    wanted = [name for name in opens if not only or any(matches(word, name) for word in only)]
    return [opens[name] for name in wanted]


def compare(
    trees: Trees,
    size: Size,
    only: Sequence[str] = (),
    tell: Callable[[str], object] = lambda _: None,
) -> Comparison:
    """Differences between two trees, of scenes and kinds whose names have such a word."""
    found, times = Comparison(), Times()
    opens = commands(size, only)
    repeats = REPEATS if size.is_full else QUICK_REPEATS
    with tempfile.TemporaryDirectory(prefix="kousoku-two-") as name:
        for k in range(repeats):
            with ExitStack() as stack:
                about = f"repeat {k + 1} of {repeats}"
                order = ("base", "head") * 2 if k % 2 else ("head", "base") * 2
                started = []
                for n, side in enumerate(order):
                    tell(f"{about}: process {n + 1} of 4")
                    cache = Path(name) / f"cache_{side}"
                    process = Process(side, trees[side], cache)
                    stack.callback(process.end)
                    cold = Process(side, trees[side], Path(name) / f"cold_{k}_{n}")
                    try:
                        started.append((process, cold.cold()))
                    finally:
                        cold.end()
                _add(times, f"{COLD}: from empty caches", started)
                running = [process for process, _ in started]
                items = _opened(found, running, opens)
                for what in items:
                    tell(f"{about}: {what}")
                    try:
                        _add(times, what, _timed(what, running))
                    except CannotError as error:
                        found.left_out[what] = str(error)
    found.times = times.judged()
    return found


def _add(times: Times, what: str, found: Sequence[tuple[Process, float | None]]) -> None:
    """Add what all four processes took, if all did it."""
    by_side: dict[str, list[float]] = {"base": [], "head": []}
    for process, seconds in found:
        if seconds is not None:
            by_side[process.side].append(seconds)
    if len(by_side["base"]) == len(by_side["head"]) == 2:
        times.add(what, by_side["base"], by_side["head"])


def _opened(
    found: Comparison, running: Sequence[Process], opens: Sequence[dict[str, Any]]
) -> list[str]:
    """Let all processes open all scenes and kinds, and return what all of them can run."""
    items: list[str] = []
    for command in opens:
        name = command.get("name", command.get("package", ""))
        answers: dict[str, list[dict[str, Any]]] = {"base": [], "head": []}
        for process in running:
            # Counts are the same in each process: the first of each tree finds them.
            is_first = not answers[process.side] and name not in found.opened
            answers[process.side].append(process.ask(**command, counted=is_first))
        refused = {side: own[0]["cannot"] for side, own in answers.items() if "cannot" in own[0]}
        if refused:
            found.left_out[name] = "; ".join(f"{side}: {why}" for side, why in refused.items())
            continue
        base, head = answers["base"][0], answers["head"][0]
        if name not in found.opened:
            found.opened.append(name)
            both = [key for key in base["counts"] if key in head["counts"]]
            pairs = (Count(name, x, base["counts"][x], head["counts"][x]) for x in both)
            found.counts += pairs
            if base["end"] and len(base["end"]) == len(head["end"]):
                pairs_of_ends = zip(base["end"], head["end"], strict=True)
                found.moved[name] = max(abs(x - y) for x, y in pairs_of_ends)
        items += [what for what in base["runs"] if what in head["runs"]]
    return items


def _timed(what: str, running: Sequence[Process]) -> list[tuple[Process, float | None]]:
    """Fastest of several rounds of each process, all in turn.

    Raises
    ------
    CannotError
        One of them cannot run it, such as a commit from before an option.
    """
    about = min(_seconds(running[0], what, 1) for _ in range(2))
    count = max(1, int(SLICE / about))
    rounds = max(2, min(ROUNDS, int(SPENT / max(about, SLICE))))
    fastest = [math.inf] * len(running)
    for r in range(rounds):
        for n in range(len(running)):
            k = (n + r) % len(running)
            fastest[k] = min(fastest[k], _seconds(running[k], what, count))
    return list(zip(running, fastest, strict=True))


def _seconds(process: Process, what: str, count: int) -> float:
    """Seconds of a call, of so many."""
    answer = process.ask(do="time", what=what, count=count)
    if "cannot" in answer:
        raise CannotError(f"{process.side}: {answer['cannot']}")
    return float(answer["seconds"])


def page_of(found: Comparison, names: Mapping[str, str], took: float) -> str:
    """Page of all that was found, in Markdown."""
    counts = [
        [one.where, one.what, f"{one.base:g}", f"{one.head:g}", _percent(one.head, one.base)]
        for one in found.counts
        if one.base != one.head
    ]
    times = [
        [
            one.what,
            duration(one.base),
            duration(one.head),
            f"{one.ratio:.3f}",
            f"{one.spread:.3f}",
            "**slower**" if one.is_worse else "faster" if one.is_better else "",
        ]
        for one in found.times
    ]
    moved = {name: x for name, x in found.moved.items() if x}
    parts = [
        f"# {names['head']} beside {names['base']}",
        f"{took / 60:.1f} min; {len(found.counts)} counts, {len(found.times)} times.",
        "Counts that differ:" if counts else "All counts are the same.",
        table(("", "count", "base", "this", ""), counts) if counts else "",
        table(("time", "base", "this", "ratio", "spread", ""), times) if times else "",
    ]
    if moved:
        told = ", ".join(f"{name} {x:.1e}" for name, x in moved.items())
        parts.append(f"Bodies are elsewhere in the end, by so many lengths of the scene: {told}.")
    parts += [f"Not compared: {name}: {why}" for name, why in found.left_out.items()]
    parts += [f"better: {one}" for one in found.better]
    parts += [f"WORSE: {one}" for one in found.worse]
    verdict = "nothing is worse" if found.opened else "nothing can be compared"
    parts.append("something is worse" if found.worse else verdict)
    return "\n\n".join(filter(None, parts)) + "\n"


def _percent(head: float, base: float) -> str:
    return f"{100 * (head / base - 1):+.1f} %" if base else ""


def main(commit: str, size: Size, only: Sequence[str], build: Path) -> int:
    """Compare this tree with a commit, print and write what was found, and return the status."""
    start = time.monotonic()
    name = git("log", "-1", "--format=%h %s", "--end-of-options", commit, "--")
    here = git("log", "-1", "--format=%h %s", "HEAD")
    dirty = " with changes" if git("status", "--porcelain") else ""
    names = {"base": name, "head": f"{here}{dirty}"}
    with checked_out(commit) as tree, Progress() as progress:
        bar = progress.add_task("", total=None)

        def tell(text: str) -> None:
            progress.update(bar, description=text[:60].ljust(60))

        found = compare({"base": tree, "head": ROOT}, size, only, tell)
    page = page_of(found, names, time.monotonic() - start)
    build.mkdir(parents=True, exist_ok=True)
    write_atomically(build / "commits.md", page.encode())
    data = names | asdict(found)
    write_atomically(build / "commits.json", json.dumps(data, indent=0).encode())
    print(page)
    return int(bool(found.worse) or not found.opened)
