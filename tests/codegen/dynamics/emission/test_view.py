"""Solvers with many kernels: their text has no function that takes a compiler too long."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.read import scene_from_dict
from kousoku.runtime.dynamics import load_dynamics

if TYPE_CHECKING:
    from pathlib import Path

    from kousoku.runtime.toolchain import Toolchain

COUNT = 80


def text_of(count: int) -> dict[str, str]:
    """Return the folder of a body under forces; of many, each has kernels of its own."""
    forces = {
        f"f{k}": {
            **{"type": "force", "body": "p", "point": [k % 7, k % 3, 1]},
            "force": [f"{k}*sin({k}*t)", f"cos(t/{k})", 0],
        }
        for k in range(2, count + 2)
    }
    body = {"position": [0, 0, 0], "mass": 2, "inertia": {"xx": 90, "yy": 100, "zz": 110}}
    tree = {"name": "pushed", "unit": "m", "bodies": {"p": body}, "forces": forces}
    return generate_dynamics(scene_from_dict(tree), ("accelerations",))


@pytest.fixture(scope="module")
def many() -> dict[str, str]:
    return text_of(COUNT)


def test_groups_of_kernels_compute_what_each_kernel_does(
    compiler: Toolchain, tmp_path: Path, many: dict[str, str]
) -> None:
    write_tree(tmp_path, many)
    first = load_dynamics(tmp_path, target="c").simulate(0.5, samples=3, tolerance=1e-8)
    k, t = np.arange(2, COUNT + 2), first.time[:, None]
    wanted = np.stack([(k * np.sin(k * t)).sum(axis=1), np.cos(t / k).sum(axis=1)], axis=1) / 2
    np.testing.assert_allclose(first.acceleration["p"][:, :2], wanted, rtol=1e-13, atol=1e-12)
