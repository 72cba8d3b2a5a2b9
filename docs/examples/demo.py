"""Closed loops in space: a redundant constraint found, a motion, the force in a pin, a page.

Six links on six revolute joints: by count Bricard's linkage cannot move, and yet it does.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import kousoku as ks

root = Path(__file__).parents[2]

bricard = ks.load(root / "scenes" / "bricard.toml")
print(bricard)
for joint, unit in bricard.solver.left_out:
    print(f"redundant: a constraint of joint {joint} [{unit}] follows from the others")
turning = bricard.simulate(6, samples=601)
print(turning.ledger)

loop = ks.load(root / "scenes" / "loop_free.toml")
print(loop)
run = loop.simulate(2, parameters={"mass": 2})
force = np.linalg.norm(run.joint("a").force, axis=1)
print(f"force in the pin a: at most {force.max():.3f} N, at {run.time[force.argmax()]:.3f} s")

page = root / "plots" / "bricard.html"
page.parent.mkdir(exist_ok=True)
turning.animate(page)
print(f"a page that moves, open it in a browser: {page}")
