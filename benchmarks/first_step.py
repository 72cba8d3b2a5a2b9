"""From a chain's scene to its first step, in a process of its own: first_step.py BARS.

It says when the first step is made, and then how long a step takes, per bar. The caller measures
the process and gives it an empty compile cache.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.model.families import chain
from kousoku.runtime.dynamics import load_dynamics

#: A time that the first step reaches, and two later ones [s]; between these the steps are as long
#: as they may be, for every number of bars.
FIRST, SHORT, LONG = 1e-6, 0.2, 0.6
TOLERANCE, STEP = 1e-6, 4e-3
#: Least rounds; so many that all bars together are enough to be timed.
ROUNDS, BARS = 5, 1000


def measured(count: int) -> tuple[float, float]:
    """Return the seconds of the process to the first step, and of a later step per bar."""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "KOUSOKU_CACHE": cache}
        command = [sys.executable, __file__, str(count)]
        start = time.perf_counter()
        with subprocess.Popen(
            command, env=environment, stdout=subprocess.PIPE, text=True
        ) as process:
            assert process.stdout is not None
            process.stdout.readline()
            seconds = time.perf_counter() - start
            per_bar = float(process.stdout.readline())
    return seconds, per_bar


def main() -> None:
    """Generate, compile, load, make one step, tell, and time more."""
    count = int(sys.argv[1])
    with tempfile.TemporaryDirectory() as name:
        for file, text in generate_dynamics(chain(count)).items():
            (Path(name) / file).write_text(text, encoding="utf-8", newline="\n")
        solver = load_dynamics(name)

        def timed(end: float) -> tuple[float, int]:
            start = time.perf_counter()
            motion = solver.simulate(
                times=[end], tolerance=TOLERANCE, largest_step=STEP, method="dop853", checks=False
            )
            return time.perf_counter() - start, motion.ledger.steps

        timed(FIRST)
        print("moved", flush=True)
        rounds = []
        for _ in range(max(ROUNDS, BARS // count)):
            (long, more), (short, few) = timed(LONG), timed(SHORT)
            rounds.append((long - short) / (more - few) / count)
        print(statistics.median(rounds), flush=True)


if __name__ == "__main__":
    main()
