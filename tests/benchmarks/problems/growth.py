"""Tell how motions magnify errors: python -m tests.benchmarks.problems.growth [PROBLEM ...].

States of a motion are moved a little, as joints allow, relative to the length of the problem and
to the largest velocities; where bodies are later tells by how much that has grown. Beside it stands
the error that a tolerance of 1e-12 gives, and how much it may be.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.runtime.integrate.motion import Motion
from tests.benchmarks.problems.catalog import PROBLEMS
from tests.benchmarks.problems.problem import GROWTH, TIMES, kousoku_call, loaded

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.mechanism import Mechanism
    from kousoku.model.numbers.real import Array
    from tests.benchmarks.problems.problem import BenchmarkProblem

#: How far states are moved; what errors of runs make of it is a part of 1e-3.
MOVE = 1e-9
OPTIONS: dict[str, Any] = {"tolerance": 1e-13, "method": "dop853"}
TIGHT = 1e-12
#: Of the times that are judged, states at each of so many are moved, in so many directions; of
#: those positions alone, velocities alone, or both are moved.
EVERY, DIRECTIONS = 5, 9
MOVED = ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0))


def growth(problem: BenchmarkProblem) -> float:
    """Largest later distance of positions, in lengths of the problem, over the first.

    The first one is what assembly leaves of a move: a motion of few bodies and the same one of many
    have the same figure. Where drivers lead only the start is moved: a run begins at time 0.
    """
    mechanism, rng = loaded(problem), np.random.default_rng(1981)
    times = problem.end * np.arange(TIMES + 1) / TIMES
    motion = _moved(mechanism, times=times)
    states = [motion.state(k) for k in range(TIMES)]
    speeds = np.max([np.abs(v) for _, _, v in states], axis=0)
    sizes = problem.length, _largest(motion.velocity), _largest(motion.angular_velocity)
    largest = 0.0
    for time, q, v in states[: 1 if mechanism.scene.drivers else None : EVERY]:
        later = times[times >= time] - time
        usual = _moved(mechanism, times=later, q0=q, v0=v)
        for k in range(DIRECTIONS):
            turn, push = (
                MOVE * part * rng.choice([-1.0, 1.0], len(x))
                for part, x in zip(MOVED[k % len(MOVED)], (q, v), strict=True)
            )
            start = {"q0": q + problem.length * turn, "v0": v + speeds * push}
            moved = _moved(mechanism, times=later, **start)
            apart = float(np.abs(problem.observe(moved) - problem.observe(usual)).max())
            largest = max(largest, apart / problem.length / _first(usual, moved, sizes))
    return largest


def _moved(mechanism: Mechanism, **options: Any) -> Motion:
    motion = mechanism.simulate(**options, **OPTIONS)
    assert isinstance(motion, Motion)
    return motion


def _largest(vectors: Mapping[str, Array]) -> float:
    return max(float(np.abs(x).max()) for x in vectors.values())


def _first(usual: Motion, moved: Motion, sizes: tuple[float, float, float]) -> float:
    """Distance of the first rows of two motions: lengths, angles and velocities."""
    found = [0.0]
    for name, position in usual.position.items():
        p, other = usual.orientation[name][0], moved.orientation[name][0]
        gaps = (
            moved.position[name][0] - position[0],
            moved.velocity[name][0] - usual.velocity[name][0],
            moved.angular_velocity[name][0] - usual.angular_velocity[name][0],
        )
        found += [
            float(np.abs(x).max()) / size for x, size in zip(gaps, sizes, strict=True) if size
        ]
        found.append(2.0 * min(float(np.linalg.norm(p - sign * other)) for sign in (1, -1)))
    return max(found)


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
