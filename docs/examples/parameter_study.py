"""A study of parameters: one solver is generated and compiled, and runs with many lengths.

How large is the force in the pin of a piston, for cranks and rods of different lengths?
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import kousoku as ks

engine = ks.load(Path(__file__).parents[2] / "scenes" / "engine.toml")
turn = np.linspace(0.0, 2 * np.pi / 300, 181)
print("crank   rod     force in the pin")
for crank in (0.04, 0.05, 0.06):
    for rod in (0.12, 0.15, 0.2):
        run = engine.simulate(times=turn, parameters={"crank": crank, "rod": rod})
        force = np.linalg.norm(run.joint("pin").force, axis=1).max()
        print(f"{crank:.2f} m  {rod:.2f} m  {force:7.1f} N")
