"""Problem: a scene for kousoku, digits to judge by, and the forms that peers get."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import kousoku as ks
from tests.benchmarks.kit import Call, Case, Judged, Kind

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.mechanism import Mechanism
    from kousoku.model.numbers.real import Array
    from kousoku.model.records.scene import Output
    from tests.benchmarks.kit import Size
    from tests.benchmarks.peers.equations import StateEquations

    Runs = tuple[Callable[[], object], Callable[[], Array]]

FOLDER = Path(__file__).with_name("digits")
SCENES = Path(__file__).parents[3] / "scenes"
#: Of kousoku, and of peers with tolerances.
FULL = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12)
QUICK = (1e-4, 1e-7, 1e-12)
#: What a tolerance of 1e-12 has to give, where errors grow no more than so many times; how much
#: motions magnify them, from ``python -m tests.benchmarks.problems.growth``.
PROMISED, USUAL_GROWTH = 1e-10, 100.0
GROWTH = {
    "pendulum": 19.0,
    "andrews": 93.0,
    "n_four_bar_2": 730.0,
    "n_four_bar_40": 710.0,
    "n_four_bar_200": 690.0,
    "n_four_bar_1000": 710.0,  # not measured: that of the same motion with fewer bars
    "heavy_top": 270.0,
    "free_body": 30.0,
    "flipping_body": 2e7,
    "small_pendulum": 8.7,
    "chain_2": 230.0,
    "chain_10": 20.0,
    "chain_30": 1.7,
    "governor": 2.6,
    "slider_crank": 57.0,
    "bricard": 460.0,
    "driven_pendulum": 15.0,
}
#: How many times are judged; the line with a table writes more.
TIMES, ROWS = 100, 200


@dataclass(frozen=True, slots=True)
class Digits:
    """Right positions at 100 times.

    Parameters
    ----------
    times : (100,) array [s]
        From the first after 0 to the end.
    positions : (100, k) array [m]
        Of the points that are judged.
    reactions : (100, m) array, optional
        What is judged beside them.
    """

    times: Array
    positions: Array
    reactions: Array | None = None

    @classmethod
    def read(cls, name: str) -> Digits:
        """Read the committed digits of a problem."""
        data = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
        found = data.get("reactions")
        return cls(
            np.array(data["times"]),
            np.array(data["positions"]),
            None if found is None else np.array(found),
        )

    def judged(
        self, positions: Array, length: float, reactions: Array | None, **extra: float
    ) -> Judged:
        """Largest errors of all times, of positions relative to a length."""
        error = float(np.abs(positions - self.positions).max()) / length
        if reactions is not None and self.reactions is not None and reactions.size:
            scale = float(np.abs(self.reactions).max())
            extra["reactions"] = float(np.abs(reactions - self.reactions).max()) / scale
        return Judged(error, extra)


@dataclass(frozen=True, slots=True)
class BenchmarkProblem:
    """One motion, posed to all tools.

    Parameters
    ----------
    name : str
        Of its contest and its digits.
    title : str
        What moves, in a few words.
    scene : callable
        Returns what :func:`kousoku.load` takes.
    observe : callable
        Returns the positions that are judged, of a result of kousoku, (rows, k).
    length : float [m]
        Errors of positions are relative to it.
    end : float [s]
        The last time.
    forms : tuple of callable
        Hand-written equations; the digits are those of the first, and the others agree.
    published : dict of tuple
        By time, the first positions that others published; NaN for what they did not.
    agreed : float
        How well forms agree, and published digits are met, relative to the length.
    reactions : callable, optional
        Returns the reactions that are judged, of a result.
    peers : callable
        Returns the cases of all peers.
    methods : tuple of str
        kousoku's methods here.
    is_quick : bool
        Whether the quick run has it.
    is_large : bool
        Whether a run takes seconds, so that the default method stands for all.
    """

    name: str
    title: str
    scene: Callable[[], Any]
    observe: Callable[[Any], Array]
    length: float
    end: float
    forms: tuple[Callable[[], StateEquations], ...]
    peers: Callable[[BenchmarkProblem, Size], list[Case]]
    published: Mapping[float, tuple[float, ...]] = field(default_factory=dict)
    agreed: float = 1e-12
    reactions: Callable[[Any], Array] | None = None
    methods: tuple[str, ...] = ("dopri5", "dop853")
    is_quick: bool = False
    is_large: bool = False

    @property
    def promised(self) -> float:
        """The error at a tolerance of 1e-12: 1e-10, more where the motion magnifies it further."""
        return PROMISED * max(1.0, GROWTH.get(self.name, 0.0) / USUAL_GROWTH)

    def digits(self) -> Digits:
        """Digits that are right."""
        return Digits.read(self.name)

    def cases(self, size: Size) -> list[Case]:
        """Cases of kousoku and of all peers."""
        return [*kousoku_cases(self, size), *self.peers(self, size)]


def reaction_norms(joints: Sequence[str], result: Any) -> Array:
    """Norms of the forces of joints, (rows, joints), of a result of kousoku."""
    forces = [result.joint(name).force for name in joints]
    found: Array = np.linalg.norm(np.stack(forces, axis=1), axis=2)
    return found


def tolerances(size: Size) -> Sequence[float]:
    """Tolerances that are measured."""
    return FULL if size.is_full else QUICK


def kousoku_cases(problem: BenchmarkProblem, size: Size) -> list[Case]:
    """Kousoku's lines: every method and the default, a table of rows, and the C alone."""
    has_all = size.is_full and not problem.is_large
    method = problem.methods[-1] if has_all else None
    name = method or "auto"
    lines: list[tuple[str, str | None, str]] = [
        ("auto", None, "end"),
        *((one, one, "end") for one in problem.methods if has_all),
        *([(f"{name}, {ROWS} rows", method, "rows")] if size.is_full else []),
        (f"{name}, C alone", method, "c"),
    ]
    return [
        Case(
            "kousoku",
            line,
            f"tolerance {tolerance:.0e}",
            "kousoku",
            partial(kousoku_call, problem, method, tolerance, what),
        )
        for line, method, what in lines
        for tolerance in tolerances(size)
    ]


def loaded(problem: BenchmarkProblem) -> Mechanism:
    """Mechanism, with reactions where they are judged."""
    outputs: list[Output] = ["reactions"] if problem.reactions else []
    return ks.load(problem.scene(), outputs=outputs, target="c")


def kousoku_call(
    problem: BenchmarkProblem, method: str | None, tolerance: float, what: str
) -> Call:
    """Run of kousoku: to the end by the door, with a table of rows, or the C alone."""
    mechanism, digits = loaded(problem), problem.digits()
    end = float(digits.times[-1])
    options: dict[str, Any] = {"tolerance": tolerance}
    if method is not None:
        options["method"] = method

    def judge() -> Judged:
        result = mechanism.simulate(times=digits.times, **options)
        ledger = result.ledger
        counts = {
            "steps": float(ledger.steps),
            "rejected": float(ledger.rejected),
            "evaluations": float(ledger.derivatives),
            "factorisations": float(ledger.factorisations),
        }
        if ledger.energy_error is not None:
            counts["energy"] = ledger.energy_error
        reactions = problem.reactions(result) if problem.reactions else None
        return digits.judged(problem.observe(result), problem.length, reactions, **counts)

    if what == "c":
        run = mechanism.begin(times=[end], checks=False, **options)
        return Call(lambda: finished(run), judge)
    if what == "rows":
        return Call(lambda: mechanism.simulate(end, samples=ROWS, **options), judge)
    return Call(lambda: mechanism.simulate(times=[end], **options), judge)


def finished(run: Any) -> None:
    """Run the C alone: it starts over and goes to the end, and makes no tables."""
    run.restart()
    while (status := run.advance(10**9, 10**6)) > 0:
        pass
    if status < 0:
        run.finish()  # raises, and says why


def equation_cases(
    problem: BenchmarkProblem,
    form: str,
    kind: Kind,
    make: Callable[[], StateEquations],
    tools: Sequence[tuple[str, str, Callable[[StateEquations, float, Array], Runs]]],
    settings: Sequence[float],
) -> list[Case]:
    """Cases of equations that are given, for tools by name, line and what runs them."""
    return [
        Case(
            tool,
            f"{line}, {form}",
            f"tolerance {tolerance:.0e}",
            kind,
            partial(equation_call, problem, make, run, tolerance),
        )
        for tool, line, run in tools
        for tolerance in settings
    ]


@lru_cache(maxsize=4)
def written(make: Callable[[], StateEquations]) -> StateEquations:
    """Equations, written and compiled once for all tolerances of a tool."""
    return make()


def equation_call(
    problem: BenchmarkProblem,
    make: Callable[[], StateEquations],
    run: Callable[[StateEquations, float, Array], Runs],
    tolerance: float,
) -> Call:
    """Run of a tool on equations."""
    digits, equations = problem.digits(), written(make)
    call, states = run(equations, tolerance, digits.times)

    def judge() -> Judged:
        positions, energy, reactions = equations.judge()(np.vstack([equations.start, states()]))
        extra = {"energy": float(np.abs(energy - energy[0]).max())} if energy.size else {}
        return digits.judged(positions[1:], problem.length, reactions[1:], **extra)

    return Call(call, judge)
