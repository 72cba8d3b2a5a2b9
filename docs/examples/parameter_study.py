"""A study of parameters: one solver is generated and compiled, and runs with many lengths.

How large is the force in the pin of a piston, for cranks and rods of different lengths?
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.builder import SceneBuilder
from kousoku.runtime.dynamics import load_dynamics

Z = (0, 0, 1)

scene = (
    SceneBuilder("engine", unit="m")
    .parameter("crank", 0.05)
    .parameter("rod", 0.15)
    .parameter("speed", 300)
    .body(
        "shaft",
        position=(0, 0, 0),
        mass=2,
        inertia={"xx": 0.01, "yy": 0.01, "zz": 0.01},
    )
    .body(
        "conrod",
        position=(0.05, 0, 0),
        rods=[{"mass": "4*rod", "ends": ((0, 0, 0), ("rod", 0, 0))}],
    )
    .body(
        "piston",
        position=(0.2, 0, 0),
        mass=0.4,
        inertia={"xx": 1e-4, "yy": 1e-4, "zz": 1e-4},
    )
    .joint("bearing", type="revolute", bodies=("ground", "shaft"), at=(0, 0, 0), axis=Z)
    .joint(
        "crankpin",
        type="revolute",
        bodies=("shaft", "conrod"),
        points=(("crank", 0, 0), (0, 0, 0)),
        axes=(Z, Z),
    )
    .joint(
        "pin",
        type="revolute",
        bodies=("conrod", "piston"),
        points=(("rod", 0, 0), (0, 0, 0)),
        axes=(Z, Z),
    )
    .joint(
        "cylinder",
        type="prismatic",
        bodies=("ground", "piston"),
        points=((0, 0, 0), (0, 0, 0)),
        axes=((1, 0, 0), (1, 0, 0)),
    )
    .driver("motor", joint="bearing", value="speed*t")
    .outputs("reactions")
    .build()
)

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
