"""A study of parameters: one solver is generated and compiled, and runs with many lengths.

How large is the force in the pin of a piston, for cranks and rods of different lengths?
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.read import read_scene
from kousoku.runtime.dynamics import load_dynamics

scene = read_scene(Path(__file__).parents[2] / "scenes" / "engine.toml")
with tempfile.TemporaryDirectory() as place:
    folder = Path(place) / scene.name
    write_tree(folder, generate_dynamics(scene))
    engine = load_dynamics(folder)
    turn = np.linspace(0.0, 2 * np.pi / 300, 181)
    print("crank   rod     force in the pin")
    for crank in (0.04, 0.05, 0.06):
        for rod in (0.12, 0.15, 0.2):
            motion = engine.simulate(times=turn, parameters={"crank": crank, "rod": rod})
            force = np.linalg.norm(motion.force["pin"], axis=1).max()
            print(f"{crank:.2f} m  {rod:.2f} m  {force:7.1f} N")
