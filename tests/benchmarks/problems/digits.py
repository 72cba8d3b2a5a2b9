"""Write the digits of problems: python -m tests.benchmarks.problems.digits [PROBLEM ...].

Hand-written equations are integrated by heyoka's Taylor series in quadruple precision. Nothing of
kousoku takes part. Every problem has two forms of its equations, which must agree; and where
others have published digits, those must be met.
"""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING

import numpy as np

from tests.benchmarks.kit import required
from tests.benchmarks.peers.heyoka import translated
from tests.benchmarks.problems.catalog import PROBLEMS
from tests.benchmarks.problems.problem import FOLDER, TIMES

if TYPE_CHECKING:
    from kousoku.model.numbers.real import Array
    from tests.benchmarks.peers.equations import StateEquations
    from tests.benchmarks.problems.problem import BenchmarkProblem

TOLERANCE = 1e-26


def integrated(equations: StateEquations, times: Array) -> tuple[Array, Array, Array]:
    """Positions, energies and reactions at times; states come from quadruple precision."""
    hy = required("heyoka")
    variables, rates = translated(equations.explicit, equations.x)
    made = hy.taylor_adaptive(
        list(zip(variables, rates, strict=True)),
        [hy.real128(x) for x in equations.start.tolist()],
        tol=hy.real128(TOLERANCE),
        fp_type=hy.real128,
        compact_mode=True,
    )
    grid = [hy.real128(0), *(hy.real128(t) for t in times.tolist())]
    outcome, *_, rows = made.propagate_grid(grid)
    if outcome != hy.taylor_outcome.time_limit:
        raise ArithmeticError(f"heyoka stops: {outcome}")
    return equations.judge()(rows[1:].astype(np.float64))


def write(problem: BenchmarkProblem) -> None:
    """Write the digits of a problem.

    Raises
    ------
    ArithmeticError
        Two forms of its equations do not agree, or published digits are not met.
    """
    times = problem.end * np.arange(1, TIMES + 1) / TIMES
    first, *others = problem.forms
    positions, energy, reactions = integrated(first(), times)
    if energy.size:
        drift = float(np.ptp(energy))
        print(f"{problem.name}: energy changes by {drift:.1e} of {abs(energy).max():.3g} J")
    for k, form in enumerate(others, 2):
        found = integrated(form(), times)
        difference = float(np.abs(found[0] - positions).max()) / problem.length
        print(f"{problem.name}: form {k} of its equations differs by {difference:.1e}")
        if not difference <= problem.agreed:
            raise ArithmeticError(f"{problem.name}: form {k} does not agree")
        reactions = reactions if reactions.size else found[2]
    for time, wanted in problem.published.items():
        row = int(np.argmin(np.abs(times - time)))
        apart = np.abs(positions[row, : len(wanted)] - wanted)
        difference = float(np.nanmax(apart)) / problem.length
        print(f"{problem.name}: published digits at {time:g} s differ by {difference:.1e}")
        if not (difference <= problem.agreed and abs(times[row] - time) < 1e-12):
            raise ArithmeticError(f"{problem.name}: published digits at {time:g} s are not met")
    data = {"times": times.tolist(), "positions": positions.tolist()}
    if reactions.size:
        data["reactions"] = reactions.tolist()
    text = json.dumps(data).replace("], [", "],\n[")
    (FOLDER / f"{problem.name}.json").write_text(text + "\n", encoding="utf-8")


def main() -> None:
    """Write those that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("problems", nargs="*", default=[*PROBLEMS], metavar="PROBLEM")
    for name in parser.parse_args().problems:
        write(PROBLEMS[name])


if __name__ == "__main__":
    main()
