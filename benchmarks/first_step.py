"""From a chain's scene to its first step, in a process of its own: first_step.py BARS.

It says when the first step is made, and then, for each line that it is sent, how long a step takes
per bar. The caller measures the process and gives it an empty compile cache.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.families import chain
from kousoku.runtime.dynamics import load_dynamics

#: A time that the first step reaches, and two later ones [s]; between these the steps are as long
#: as they may be, for every number of bars.
FIRST, SHORT, LONG = 1e-6, 0.2, 0.6
TOLERANCE, STEP = 1e-6, 4e-3
#: So many bars are moved at least when a step is timed, by a short chain again and again.
BARS = 1000


@dataclass(frozen=True, slots=True)
class Started:
    """A process that has made its first step and times later ones when it is asked.

    Parameters
    ----------
    seconds : float
        From its begin to the first step.
    process : subprocess.Popen
        The process; it ends with its input.
    """

    seconds: float
    process: subprocess.Popen[str]

    def per_bar(self) -> float:
        """Return the seconds of a step per bar, timed now."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        print(file=self.process.stdin, flush=True)
        return float(self.process.stdout.readline())

    def end(self) -> None:
        """Let the process end."""
        self.process.communicate()


def started(count: int) -> Started:
    """Return a process of a chain that has made its first step, with an empty compile cache."""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "KOUSOKU_CACHE": cache}
        command = [sys.executable, __file__, str(count)]
        start = time.perf_counter()
        process = subprocess.Popen(
            command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert process.stdout is not None
        process.stdout.readline()
        return Started(time.perf_counter() - start, process)


def main() -> None:
    """Generate, compile, load, make one step, tell, and time more when asked."""
    count = int(sys.argv[1])
    with tempfile.TemporaryDirectory() as name:
        write_tree(Path(name), generate_dynamics(chain(count)))
        solver = load_dynamics(name)

        def timed(end: float) -> tuple[float, int]:
            start = time.perf_counter()
            motion = solver.simulate(
                times=[end], tolerance=TOLERANCE, largest_step=STEP, method="dop853", checks=False
            )
            return time.perf_counter() - start, motion.ledger.steps

        timed(FIRST)
        print("moved", flush=True)
        for _ in sys.stdin:
            found = []
            for _ in range(max(1, BARS // count)):
                (long, more), (short, few) = timed(LONG), timed(SHORT)
                found.append((long - short) / (more - few) / count)
            print(statistics.median(found), flush=True)


if __name__ == "__main__":
    main()
