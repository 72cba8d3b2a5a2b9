"""Tell how motions magnify errors: python -m benchmarks.problems.growth [PROBLEM ...].

States of a motion are moved a little, relative to the length of the problem and to the largest
velocities; where bodies are later tells by how much that has grown. Beside it stands the error
that a tolerance of 1e-12 gives, and how much it may be.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.problems.catalog import PROBLEMS
from benchmarks.problems.problem import GROWTH, TIMES, kousoku_call, loaded

if TYPE_CHECKING:
    import numpy.typing as npt

    from benchmarks.problems.problem import Problem

    Array = npt.NDArray[np.float64]

#: How far states are moved; what errors of runs make of it is a part of 1e-3.
MOVE = 1e-9
OPTIONS: dict[str, Any] = {"tolerance": 1e-13, "method": "dop853"}
TIGHT = 1e-12
#: Of the times that are judged, states at each of so many are moved, in so many directions.
EVERY, DIRECTIONS = 10, 2


def growth(problem: Problem) -> float:
    """Return the largest later distance of positions, in lengths of the problem, over the move.

    Where drivers lead only the start is moved: a run begins at time 0.
    """
    mechanism, rng = loaded(problem), np.random.default_rng(1981)
    times = problem.end * np.arange(TIMES + 1) / TIMES
    motion = mechanism.simulate(times=times, **OPTIONS)
    states = [motion.state(k) for k in range(TIMES)]
    speeds = np.max([np.abs(v) for _, _, v in states], axis=0)
    largest = 0.0
    for time, q, v in states[: 1 if mechanism.scene.drivers else None : EVERY]:
        later = times[times >= time] - time

        def positions(q0: Array, v0: Array, later: Array = later) -> Array:
            return problem.observe(mechanism.simulate(times=later, q0=q0, v0=v0, **OPTIONS))

        usual = positions(q, v)
        for _ in range(DIRECTIONS):
            turn, push = (rng.choice([-MOVE, MOVE], len(x)) for x in (q, v))
            moved = positions(q + problem.length * turn, v + speeds * push)
            largest = max(largest, float(np.abs(moved - usual).max()) / problem.length / MOVE)
    return largest


def main() -> None:
    """Tell it of the problems that are named, or of all that are not large."""
    parser = argparse.ArgumentParser(description=__doc__)
    usual = [name for name, problem in PROBLEMS.items() if not problem.is_large]
    parser.add_argument("problems", nargs="*", default=usual, metavar="PROBLEM")
    for name in parser.parse_args().problems:
        problem = PROBLEMS[name]
        errors = [
            f"{method} {kousoku_call(problem, method, TIGHT, 'end').judge().error:.1e}"
            for method in problem.methods
        ]
        grown = f"errors grow {growth(problem):.2g} times ({GROWTH.get(name, 'none')} noted)"
        print(f"{name}: {grown}; at {TIGHT:g} {', '.join(errors)}, promised {problem.promised:.1e}")


if __name__ == "__main__":
    main()
