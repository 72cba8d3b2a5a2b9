"""Solvers with many kernels: their text has no function that takes a compiler too long."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from kousoku.codegen.dynamics.emission.context import FEATURE_NUMBERS
from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.dynamics.recording.program import REGIONS
from kousoku.codegen.generate import write_tree
from kousoku.model.reading.read import read_scene, scene_from_dict
from kousoku.runtime.dynamics import load_dynamics
from tests.programs import STRICT, compiled

if TYPE_CHECKING:
    from kousoku.runtime.toolchain import Toolchain

COUNT = 80
ROOT = Path(__file__).parents[4]
LACKING = ROOT / "runtime" / "integrate" / "lacking.h"
#: Scenes that have most of what others lack.
SCENES = ("bouncing_ball", "bricard", "engine", "pendulum")
OUTPUTS = ("accelerations", "reactions", "energies")


def text_of(count: int) -> dict[str, str]:
    """Folder of a body under forces; of many, each has kernels of its own."""
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


def test_what_comes_with_a_part_is_zero_in_the_library_where_a_scene_lacks_it() -> None:
    text = LACKING.read_text(encoding="utf-8").partition("#define ROOM")[2]
    blocks = re.findall(r"#if(?:ndef (\w+)| !\((\w+) && (\w+)\))\n(.*?)#endif", text, re.DOTALL)
    zeros = {
        tuple(filter(None, needed)): set(re.findall(r"#define (\w+) 0", body)) - set(needed)
        for *needed, body in blocks
    }
    assert {needed: names for needed, names in zeros.items() if names} == {
        needed: set(names) for needed, names in FEATURE_NUMBERS.items()
    }


@pytest.mark.parametrize("name", SCENES)
def test_a_solver_is_strict_c_and_says_nothing_of_what_its_scene_lacks(
    compiler: Toolchain, tmp_path: Path, name: str
) -> None:
    files = generate_dynamics(read_scene(ROOT / "scenes" / f"{name}.toml"), OUTPUTS)
    write_tree(tmp_path, files)
    flags = ("-std=c99", *STRICT, "-O0", "-c", "solver.c", "-o", "solver.o")
    compiled(compiler, tmp_path, *flags)
    text = files["solver.c"]
    parts = set(re.findall(r"#define (\w+) 1\n", text))
    assert parts <= set(re.findall(r"#ifndef (\w+)", LACKING.read_text(encoding="utf-8")))
    for needed, names in FEATURE_NUMBERS.items():
        for count in names:
            assert (f" {count} = " in text) == parts.issuperset(needed)
    assert not re.search(r"\{ (\{?0\}?|\(void\)w;) \}", text)
    assert ("IS_DRIVEN" in parts) == ("integrate/kinematics.h" in files)
    assert ("IS_DRIVEN" in parts) == ("integrate/kinematics.py" in files)
    for end in ("h", "py"):
        assert ("HAS_BREAKS" in parts) == (f"integrate/breaks.{end}" in files)
        cuts = f"integrate/cuts.{end}" in files
        assert cuts != parts.isdisjoint({"HAS_DISTANCE", "HAS_BREAKS"})
    tables = files["solver.py"].partition("TABLES = {")[2]
    assert not re.search(r'": """\n\n|=False|, 0\),', tables)


@pytest.mark.parametrize("name", SCENES)
def test_the_heading_of_a_function_names_the_regions_that_it_writes(name: str) -> None:
    files = generate_dynamics(read_scene(ROOT / "scenes" / f"{name}.toml"), OUTPUTS)
    assert not [line for line in files["solver.h"].splitlines() if line[100:]]
    parts = re.split(r"\n(?=/\* )", files["solver.c"])
    found = [
        re.match(r"/\* \w+: .*-> (.*); \d+ operations?(.*)", part, re.DOTALL) for part in parts
    ]
    for heading, body in (one.groups() for one in found if one):
        named = {part.split()[0].strip(":") for part in heading.split(", ")} & REGIONS.keys()
        assert named == {*re.findall(r"\n    (\w+)\[\d+\] = ", body)} - {"scratch"}, heading
