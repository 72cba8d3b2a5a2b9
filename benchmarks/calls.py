"""Overhead of a call from Python: python benchmarks/calls.py [--check].

Two-row p2 with its seven inputs and two outputs as separate float64 arrays, shapes and types
checked, ``out=`` given; and the same arrays bound. Exit status 1 with --check if a target is
missed.
"""

from __future__ import annotations

import argparse
import sys
import timeit
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kousoku.runtime import load

if TYPE_CHECKING:
    from collections.abc import Callable

PACKAGE = "p2"
ROUNDS = 15
CALLS = 20_000
#: Microseconds a call.
TARGETS = {"call with out=": 2.0, "bound call": 0.6}


def microseconds(function: Callable[[], object]) -> float:
    """Return the time of a call in the best of several rounds."""
    return min(timeit.repeat(function, number=CALLS, repeat=ROUNDS)) / CALLS * 1e6


def main() -> int:
    """Measure, print, and compare with the targets."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="exit 1 if a target is missed")
    arguments = parser.parse_args()
    folder = Path(str(files("kousoku.generated") / "kinds" / PACKAGE))
    kernel = load(folder, target="c").constraint_z
    rng = np.random.default_rng(1981)
    a, b, c, d, e, f, g = (rng.standard_normal(q.shape) for q in kernel.manifest.inputs)
    out = tuple(np.empty(q.shape) for q in kernel.manifest.outputs)
    times = {
        "call with out=": microseconds(lambda: kernel(a, b, c, d, e, f, g, out=out)),
        "call that allocates": microseconds(lambda: kernel(a, b, c, d, e, f, g)),
        "call for one output": microseconds(lambda: kernel(a, b, c, d, e, f, g, outputs=("C",))),
        "bound call": microseconds(kernel.bind(a, b, c, d, e, f, g, out=out)),
    }
    missed = []
    for name, time in times.items():
        target = TARGETS.get(name)
        print(f"{name:20} {time:6.3f} µs" + (f"   target {target} µs" if target else ""))
        if target is not None and time >= target:
            missed.append(name)
    for name in missed:
        print(f"missed: {name}", file=sys.stderr)
    return 1 if missed and arguments.check else 0


if __name__ == "__main__":
    sys.exit(main())
