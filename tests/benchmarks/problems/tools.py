"""The cases of peers, each at several settings, as their documentation advises."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from tests.benchmarks.kit import Call, Case, Judged, Kind
from tests.benchmarks.peers import casadi, exudyn, heyoka, mujoco, pinocchio, scipy
from tests.benchmarks.problems.problem import equation_cases

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.model.numbers.real import Array
    from tests.benchmarks.kit import Size
    from tests.benchmarks.peers.equations import StateEquations
    from tests.benchmarks.problems.problem import BenchmarkProblem, Runs
    from tests.benchmarks.problems.tree import Tree

#: Tolerances; a Taylor series errs by more than its own where it is loose.
STEPPERS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
TAYLOR = (1e-4, 1e-7, 1e-10, 1e-12, 1e-15)
FEW, FEW_TAYLOR = (1e-6, 1e-8, 1e-10), (1e-7, 1e-10, 1e-15)
#: Steps to the end; multiples of the number of times that are judged.
STEPS = (1_000, 5_000, 20_000, 100_000)
FEW_STEPS = (1_000, 10_000)
#: MuJoCo's methods: of order 4, and of order 1 for what is stiff.
MUJOCO = ("RK4", "implicit")


def equation_lines(
    problem: BenchmarkProblem,
    size: Size,
    form: str,
    kind: Kind,
    make: Callable[[], StateEquations],
    *,
    is_stiff: bool = False,
    is_long: bool = False,
    has_multipliers: bool = False,
    tolerances: Sequence[float] = TAYLOR,
) -> list[Case]:
    """Lines of heyoka, SciPy and CasADi on equations that are given.

    Code of equations that are long is compact in heyoka: inlined it compiles for minutes. Where
    that takes half a minute, too, heyoka gets fewer tolerances.
    """
    taylor = [("heyoka", "Taylor", partial(heyoka.runs, compact=is_long))]
    steppers: list[tuple[str, str, Callable[[StateEquations, float, Array], Runs]]]
    steppers = [("SciPy", "DOP853", scipy.runs)]
    if is_stiff:
        steppers = [
            ("SciPy", "LSODA", partial(scipy.runs, method="LSODA")),
            ("SciPy", "Radau", partial(scipy.runs, method="Radau")),
        ]
    if size.is_full:
        steppers.append(("CasADi", "CVODES", casadi.cvodes))
        if has_multipliers:
            steppers.append(("CasADi", "IDAS", casadi.idas))
    return [
        *equation_cases(
            problem, form, kind, make, taylor, tolerances if size.is_full else FEW_TAYLOR
        ),
        *equation_cases(problem, form, kind, make, steppers, STEPPERS if size.is_full else FEW),
    ]


def tree_lines(
    problem: BenchmarkProblem,
    size: Size,
    tree: Tree,
    *,
    steps: Sequence[int] = STEPS,
    is_stiff: bool = False,
    is_singular: bool = False,
    is_redundant: bool = False,
) -> list[Case]:
    """Lines of tools that start from bodies and joints."""
    counts = steps if size.is_full else FEW_STEPS
    cases = []
    for method in MUJOCO if size.is_full and not is_stiff else MUJOCO[is_stiff:][:1]:
        cases += stepped(problem, "MuJoCo", method, counts, partial(_mujoco, tree, method))
    if size.is_full and not is_stiff:  # DOP853 is explicit
        form = "constraintDynamics" if tree.loops else "ABA"
        cases += [
            Case(
                "Pinocchio",
                f"{form} and DOP853",
                f"tolerance {tolerance:.0e}",
                "scene",
                partial(
                    called, problem, partial(_pinocchio, tree, tolerance, is_redundant=is_redundant)
                ),
            )
            for tolerance in STEPPERS
        ]
    if size.is_full:
        lines = ["generalised alpha, index 3", "trapezoidal, index 2"]
        lines += [] if tree.loops or is_stiff else list(exudyn.EXPLICIT)
        if is_singular:  # the trapezoidal rule does not pass there, and takes minutes to tell
            lines, counts = lines[:1], FEW_STEPS
        for line in lines:
            make = partial(_exudyn, tree, line, is_tight=not is_singular)
            cases += stepped(problem, "Exudyn", line, counts[: len(STEPS) - 1], make)
    return cases


def _mujoco(tree: Tree, method: str, steps: int, times: Array) -> Runs:
    return mujoco.runs(tree, method, steps, times)


def _exudyn(tree: Tree, line: str, steps: int, times: Array, *, is_tight: bool) -> Runs:
    return exudyn.runs(tree, line, steps, times, is_tight=is_tight)


def _pinocchio(tree: Tree, tolerance: float, times: Array, *, is_redundant: bool) -> Runs:
    return pinocchio.runs(tree, tolerance, times, is_redundant=is_redundant)


def stepped(
    problem: BenchmarkProblem,
    tool: str,
    line: str,
    counts: Sequence[int],
    make: Callable[[int, Array], Runs],
) -> list[Case]:
    """Line of a tool with steps of one length."""
    return [
        Case(
            tool,
            line,
            f"{count} steps",
            "scene",
            partial(called, problem, partial(make, count)),
        )
        for count in counts
    ]


def called(problem: BenchmarkProblem, make: Callable[[Array], Runs]) -> Call:
    """Run of a tool that gives the positions that are judged."""
    digits = problem.digits()
    run, positions = make(digits.times)

    def judge() -> Judged:
        return digits.judged(positions(), problem.length, None)

    return Call(run, judge)
