"""Where an evaluation goes: projection, factorisation, equations, integrator; and chains alone."""

from __future__ import annotations

import tempfile
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.runtime.dynamics import DynamicsSolver
from kousoku.runtime.integrate.settings import KINEMATICS
from tests.benchmarks import aba, chains
from tests.benchmarks.kit import (
    BenchmarkTarget,
    Call,
    Case,
    Figures,
    Judged,
    PeerMissingError,
    Question,
    Record,
    Size,
    fastest_and_median,
    interleave,
    rounds_of,
    seconds_of,
    table,
)
from tests.benchmarks.problems.catalog import PROBLEMS
from tests.benchmarks.problems.problem import finished, loaded
from tests.benchmarks.race import MISSING, race
from tests.benchmarks.segments import (
    PARTS,
    SEGMENTS,
    SegmentLoop,
    Segments,
    seconds_of_parts,
    share_of_factors,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from kousoku.mechanism import Mechanism
    from kousoku.runtime.run import Run
    from tests.benchmarks.problems.problem import BenchmarkProblem
    from tests.benchmarks.race import Workers

#: Chains whose accelerations are compared with Pinocchio's, and one that is too long for it: its
#: data hold tensors with the third power of this, 32 GB; Featherstone's recursion stands for it.
CHAINS, LONG_CHAIN = (10, 100), 1000
OF_PINOCCHIO, EQUAL = 1.0, 1e-9
BY_LOOP, BY_CALL = "its algorithm, looped in C++", "its algorithm, called from Python"
FORWARD = "mj_forward, called from Python"
METHOD, TOLERANCE = "dop853", 1e-8
EACH = ("factorisations", "corrections", "refinements")
COLUMNS = ("projection", "factorisation", "equations", "others", "integrator")


def contests(size: Size) -> list[str]:
    """Contest for each problem, and one for each chain."""
    named = [name for name, one in PROBLEMS.items() if size.is_full or one.is_quick]
    counts = (*CHAINS, LONG_CHAIN) if size.is_full else CHAINS[:1]
    return [*named, *map(chain_name, (1, *counts))]


def chain_name(count: int) -> str:
    """Contest of the accelerations of a chain."""
    return f"accelerations of a chain of {count}"


def _chain_of(contest: str) -> int:
    """Bars of a contest, 0 where it is one of a problem."""
    return 0 if contest in PROBLEMS else int(contest.rpartition(" ")[2])


def run(contest: str, size: Size, workers: Workers) -> list[Record]:
    """Measure a contest: a problem here, a chain by all programs in turn."""
    if not _chain_of(contest):
        return list(measure(PROBLEMS[contest]))
    reason = ""
    if size.is_full and _chain_of(contest) in CHAINS:
        try:
            aba.build_loop()
        except PeerMissingError as error:
            reason = str(error)
    found = race(contest, cases(contest, size), workers, QUESTION.seconds)
    for one in found:
        if one.line == BY_LOOP and reason:
            one.note = f"{MISSING}{reason}"
    return found


# ---------------------------------------------------------------- problems


def measure(problem: BenchmarkProblem) -> Iterator[Record]:
    """Cost of an evaluation of a problem, part by part, and how often each is made."""
    mechanism = loaded(problem)
    solver = mechanism.solver
    if not isinstance(solver, DynamicsSolver):
        note = "a linkage of nodes has no such parts"
        yield Record(problem.name, "kousoku", "all", "", note=note)
        return
    method = None if solver.is_driven else METHOD
    options: dict[str, Any] = {"checks": False, "tolerance": TOLERANCE, "method": method}
    run = mechanism.begin([problem.end], **options)
    about = seconds_of(lambda: finished(run))
    made = _counts(run)
    evaluations = made["factorisations" if method is None else "derivatives"]
    with tempfile.TemporaryDirectory() as name:
        segments = Segments.of(solver, Path(name))
        again = segments.solver.begin([problem.end], **options)
        segments.counted()
        finished(again)
        calls = {key: count / evaluations for key, count in segments.counted().items()}
        loops = _loops(segments, mechanism, problem.end / 2, calls, options)
        runs: dict[str, Callable[[], object]] = {"all": lambda: finished(run), **loops}
        times = interleave(runs, max(2, rounds_of(about)))
    alone = {key: min(times[key]) / loop.rounds for key, loop in loops.items()}
    whole, median = fastest_and_median(times["all"], int(evaluations))
    names = (problem.name, "kousoku", "all", f"{method or KINEMATICS}, tolerance {TOLERANCE:.0e}")
    extra = {key: made[key] / evaluations for key in made} | {"evaluations": evaluations}
    rounds = len(times["all"])
    yield Record(*names, fastest=whole, median=median, rounds=rounds, extra=extra)
    share = share_of_factors(mechanism)
    for part, seconds in seconds_of_parts(calls, alone, share, whole).items():
        own = {key: calls[key] for key in PARTS.get(part, ()) if calls[key]}
        names = (problem.name, "kousoku", part, names[-1])
        yield Record(*names, fastest=seconds, median=seconds, rounds=rounds, extra=own)


def _loops(
    segments: Segments,
    mechanism: Mechanism,
    time: float,
    calls: dict[str, float],
    options: dict[str, Any],
) -> dict[str, SegmentLoop]:
    """Loops over all segments that are run, at the state of a time."""
    run = mechanism.begin([time], **options)
    finished(run)
    solver = segments.solver
    y = solver.state["y"].view(run.state).copy()
    parameters = np.array([value for _, value in solver.parameters])
    return {key: segments.alone(key, time, y, parameters) for key in SEGMENTS if calls[key]}


def _counts(run: Run) -> dict[str, float]:
    """Counts of a run, as its ledger has them."""
    ledger = run.motion().ledger
    names = ("steps", "rejected", "derivatives", *EACH)
    return {name: float(getattr(ledger, name)) for name in names}


# ---------------------------------------------------------------- chains


def cases(contest: str, size: Size) -> list[Case]:
    """Programs that compute the accelerations of a chain at the same states."""
    count = _chain_of(contest)
    if not count:
        return []
    ours = Case("kousoku", "geometry and acceleration", "", "kousoku", partial(_kousoku, count))
    called = Case("Pinocchio", BY_CALL, "", "scene", partial(_called, count))
    if count not in CHAINS:
        return [called] if count == 1 else [ours]
    found = [ours, called, Case("MuJoCo", FORWARD, "", "scene", partial(_forward, count))]
    if size.is_full:  # it takes a minute to compile
        found.append(Case("Pinocchio", BY_LOOP, "", "scene", partial(_looped, count)))
    return found


@cache
def _folder(name: str) -> Path:
    """Folder of this process, gone at its end."""
    _folders.append(tempfile.TemporaryDirectory())
    place = Path(_folders[-1].name) / name
    place.mkdir()
    return place


_folders: list[tempfile.TemporaryDirectory[str]] = []


def _call(entry: chains.Accelerations, count: int) -> Call:
    """Call that goes through all states; its times are those of a bar."""
    return Call(
        lambda: entry.run(1),
        lambda: Judged(chains.difference(entry.results(), chains.reference(count))),
        chains.STATES * count,
    )


def _kousoku(count: int) -> Call:
    entry = chains.kousoku_accelerations(count, _folder(f"chain_{count}"))
    call = _call(entry, count)

    def judge() -> Judged:
        """Compare with other programs, too: dense matrices lose digits in long chains."""
        theta, rate = chains.joint_states(count)
        found = chains.bars(theta, rate, chains.recursive(theta, rate))
        extra = {"recursion": chains.difference(entry.results(), (found.a, found.alpha_b))}
        if count in CHAINS:
            try:
                peer = aba.called(count)
            except PeerMissingError:
                return Judged(call.judge().error, extra)
            peer.run(1)
            extra["Pinocchio"] = chains.difference(entry.results(), peer.results())
        return Judged(None if count > max(CHAINS) else call.judge().error, extra)

    return Call(call.run, judge, call.count)


def _called(count: int) -> Call:
    return _call(aba.called(count), count)


def _forward(count: int) -> Call:
    return _call(aba.forward(count), count)


def _looped(count: int) -> Call:
    return _call(aba.looped(count), count)


# ---------------------------------------------------------------- the page


def targets(records: Sequence[Record]) -> list[BenchmarkTarget]:
    """Targets that the page promises of chains that were run."""
    found = []
    for contest in dict.fromkeys(one.contest for one in records):
        count = _chain_of(contest)
        ours = next((x for x in records if x.contest == contest and x.tool == "kousoku"), None)
        if count < 2 or ours is None:
            continue
        if count in CHAINS:
            value = _of_pinocchio(records, count)
            found.append(BenchmarkTarget(contest, "time over Pinocchio's", value, OF_PINOCCHIO))
            peer = ours.extra.get("Pinocchio")
            found.append(
                BenchmarkTarget(contest, "relative difference from Pinocchio", peer, EQUAL)
            )
        other = ours.extra.get("recursion")
        found.append(
            BenchmarkTarget(contest, "relative difference from the recursion", other, EQUAL)
        )
    return found


def _of_pinocchio(records: Sequence[Record], count: int) -> float | None:
    """Kousoku's time over Pinocchio's.

    Without the loop a call from Python stands for it; what the call itself takes is not counted:
    it is what a chain of one bar takes, less one of the bars of the long chain.
    """
    times = {(one.contest, one.tool, one.line): one.fastest for one in records if one.fastest}
    contest = chain_name(count)
    ours = times.get((contest, "kousoku", "geometry and acceleration"))
    looped = times.get((contest, "Pinocchio", BY_LOOP))
    called = times.get((contest, "Pinocchio", BY_CALL))
    alone = times.get((chain_name(1), "Pinocchio", BY_CALL))
    if ours and looped:
        return ours / looped
    if ours and called and alone:
        return ours * (count - 1) / (called * count - alone)
    return None


def body(records: Sequence[Record], _figures: Figures) -> str:
    """Tables: parts of evaluations, what a run makes of each, and chains."""
    parts, made, alone = [], [], []
    for contest in dict.fromkeys(one.contest for one in records):
        own = {one.line: one for one in records if one.contest == contest}
        if _chain_of(contest):
            alone += [_of_chain(one) for one in records if one.contest == contest]
            continue
        whole = own["all"]
        if whole.fastest is None:
            parts.append([contest, whole.note, *[""] * len(COLUMNS)])
            continue
        cells = [_part(own[name], whole) for name in COLUMNS]
        parts.append([contest, f"{whole.fastest * 1e9:.4g}", *cells])
        calls = own["projection"].extra | own["equations"].extra
        evaluations = whole.extra["evaluations"]
        made.append(
            [
                contest,
                f"{evaluations:.0f}",
                *(f"{whole.extra[name] * evaluations:.0f}" for name in ("steps", "rejected")),
                *(f"{whole.extra[name]:.3g}" for name in EACH),
                ", ".join(f"{name} {count:.3g}" for name, count in calls.items()),
            ]
        )
    heads = ("problem", "ns an evaluation", *COLUMNS)
    counted = ("problem", "evaluations", "steps", "rejected")
    more = (*(f"{name} of each" for name in EACH), "runs of segments")
    tables = [
        table(heads, parts) if parts else "",
        table((*counted, *more), made) if made else "",
        table(("accelerations of chains", "program", "ns a bar", "error"), alone) if alone else "",
    ]
    return "\n\n".join(filter(None, tables))


def _part(one: Record, whole: Record) -> str:
    if not one.fastest or not whole.fastest:
        return ""
    return f"{one.fastest * 1e9:.3g} ({100 * one.fastest / whole.fastest:.0f} %)"


def _of_chain(one: Record) -> list[str]:
    time = one.note or f"{(one.fastest or 0) * 1e9:.3g}"
    error = "" if one.error is None else f"{one.error:.1e}"
    beside = ", ".join(
        f"{value:.1e} from {name}" for name, value in one.extra.items() if name != "setup"
    )
    return [one.contest, f"{one.tool}, {one.line}", time, ", ".join(filter(None, (error, beside)))]


def words(records: Sequence[Record]) -> str:
    """Sentence on where evaluations go."""
    shares: dict[str, list[float]] = {}
    whole = {one.contest: one.fastest for one in records if one.line == "all" and one.fastest}
    for one in records:
        if one.contest in whole and one.line != "all" and one.fastest is not None:
            shares.setdefault(one.line, []).append(100 * one.fastest / whole[one.contest])
    if not shares:
        return ""
    told = [f"{min(x):.0f} to {max(x):.0f} % {part}" for part, x in shares.items() if max(x) >= 1]
    return f"Of an evaluation are {', '.join(told)}."


QUESTION = Question(
    title="Where an evaluation goes",
    asks="""\
What of an evaluation of the accelerations is projection, factorisation, equations and integrator?

Each problem runs to its end (dop853, tolerance 1e-8, no rows, no checks): its time divided by its
evaluations is an evaluation. A second build of the same source counts how often each segment is
run; the time of a segment is that of a loop over it alone, at the state half-way, in which each
call waits for the one before. Projection is position and velocity onto the constraints with the
geometry that it takes; the factors of C_q M⁻¹ C_qᵀ are made in the geometry, and take the part of
its time that they have of its operations; equations are accelerations with their refinement; the
integrator is what is left: sums of stages, estimates of errors, copies.

Accelerations of chains are computed at 16 states in turn. Pinocchio runs its articulated-body
algorithm in a loop in C++, compiled from its headers with `-O3 -march=native`, somewhat faster than
the code of its package; where that does not compile, and in the quick run, the call from Python
stands for it, less what a call takes for a chain of one bar. It works in joint coordinates; kousoku
starts from positions and orientations of all bars, and its time includes orientations, residuals,
Jacobians and factors. Both copy a state in and the result out. Beside the time stands the
difference from a solution with dense matrices in joint angles, which uses no code of either; in a
chain of 100 bars it is this solution that loses three digits.""",
    contests=contests,
    cases=cases,
    body=body,
    targets=targets,
    words=words,
    run=run,
)
