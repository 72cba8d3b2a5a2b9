"""Certificate of a step: what it says of the tube is so, wherever it says it."""

from __future__ import annotations

import ctypes
import re
import subprocess
from typing import TYPE_CHECKING

import numpy as np
import pytest

from kousoku.codegen.linkage.generate import generate_linkage
from kousoku.model.reading.read import scene_from_toml
from kousoku.runtime.kinematics.assembly import assemble as place
from kousoku.runtime.kinematics.block_equations import LinkageCoordinates
from kousoku.runtime.kinematics.certificate import Certifier, CubicTube
from kousoku.runtime.kinematics.continuation import Continuation
from kousoku.runtime.kinematics.status import MOST_TILT
from kousoku.runtime.kinematics.tables import Block, Curve, InputRecord, LinkageTables, Unknown
from kousoku.runtime.linkage import load_linkage

if TYPE_CHECKING:
    from pathlib import Path

    from kousoku.runtime.kinematics.tables import Array
    from kousoku.runtime.linkage import LinkageSolver
    from kousoku.runtime.toolchain import Toolchain

SIX_BAR = """
name = "six_bar"
unit = "m"
[nodes]
O1 = { at = [0.0, 0.0], fixed = true }
O3 = { at = [0.38, 0.0], fixed = true }
O6 = { at = [-0.26, -1.17], fixed = true }
A = { at = [0.504, 0.0226] }
B = { at = [-0.901, -0.910] }
P = { at = [0.472, -0.691] }
Q = { at = [-0.570, -1.499] }
[links]
k = { nodes = ["O6", "Q"] }
l1 = { nodes = ["O1", "A"] }
l3 = { nodes = ["O3", "B"] }
ab = { nodes = ["A", "B"] }
bp = { nodes = ["B", "P"] }
pa = { nodes = ["P", "A"] }
rod = { nodes = ["P", "Q"] }
[inputs]
alpha = { link = "k", about = "O6", turns = 1 }
"""
#: The same with an angle of two links that are one, in the same block as all positions.
RIGID = (
    SIX_BAR.replace('bp = { nodes = ["B", "P"] }\n', "")
    + """
[rigid]
plate = { at = "A", links = ["ab", "pa"], angle = 0.94 }
"""
)
#: A crank that moves a slider, blocks one after the other; in a step of 6° from where it begins its
#: rod turns and turns back.
PISTON = """
name = "piston"
unit = "m"
[nodes]
O = { at = [0, 0], fixed = true }
A = { at = [0.0523359562, 0.9986295348] }
S = { at = [3, 0.5] }
[links]
crank = { nodes = ["O", "A"] }
rod = { nodes = ["A", "S"] }
[sliders]
ram = { node = "S", through = [0, 0.5], direction = [1, 0] }
[inputs]
alpha = { link = "crank", about = "O", from = "87 deg", turns = 1 }
"""
#: A slider moves the end of a rod, which moves a rocker: lengths alone.
RAM = """
name = "ram"
unit = "m"
[nodes]
O = { at = [0, 0], fixed = true }
A = { at = [0.2, 1] }
S = { at = [2, 2] }
[links]
rocker = { nodes = ["O", "A"] }
rod = { nodes = ["A", "S"] }
[sliders]
ram = { node = "S", through = [2, 2], direction = [3, 1] }
[inputs]
stroke = { slider = "ram", from = 0, to = -1.5 }
"""
#: How far the Jacobians of the blocks turn along a way to a position; radii go into the way.
IN_C = """
#include "solver.c"
void tilts_of(const double *alpha, const double *x, CubicTube *way, double residual, double *tilts);
void tilts_of(const double *alpha, const double *x, CubicTube *way, double residual, double *tilts)
{
    static Workspace w;
    double ignored[LARGEST_BLOCK];
    look_at(&w, alpha, x);
    for (size_t number = 0; number < BLOCKS; ++number) {
        evaluate(number, &w, ignored);
        tilts[number] = tilt_of(number, &w, way, residual);
    }
}
"""
SCENES = {"six_bar": SIX_BAR, "rigid": RIGID, "piston": PISTON, "ram": RAM}


@pytest.fixture(scope="module", params=SCENES)
def folder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Package of a linkage."""
    return emitted(SCENES[request.param], tmp_path_factory.mktemp(request.param))


def emitted(scene: str, folder: Path) -> Path:
    """Folder with the package of a linkage."""
    for name, text in generate_linkage(scene_from_toml(scene)).items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def solver(folder: Path) -> LinkageSolver:
    """Solver of a linkage, whose tables the certificate reads."""
    return load_linkage(folder, target="numpy")


class Step:
    """A step of a linkage over a part of its turn, as the solver takes it, uncertified."""

    def __init__(self, solver: LinkageSolver, divisions: float) -> None:
        self.solver = solver
        run = solver.request(divisions=1)
        self.way = Continuation(solver.mechanism, run)
        place(self.way.newton, self.way.position)
        self.begin = self.way.position
        self.way.motion_at(0)
        _, self.pace = run.inputs_of(0)
        self.part = 1 / divisions
        self.end = self.at(1.0)

    def cubics(self) -> CubicTube:
        """Way of the step, with the factors of its end at hand."""
        predicted = self.begin.x + self.part * (self.way.x1 + 0.5 * self.part * self.way.x2)
        self.evaluate(self.end)
        none = np.zeros_like(self.pace)
        return self.way._tube(self.part, self.pace, none, self.end.x - predicted)

    def evaluate(self, position: LinkageCoordinates) -> None:
        """Have the factors of a position at hand."""
        self.way.newton.equations.place(position)
        for block in self.way.newton.blocks:
            block.evaluate()

    def at(self, s: float) -> LinkageCoordinates:
        """Position at s, by small steps."""
        x, count = self.begin.x.copy(), 25
        for k in range(1, count + 1):
            alpha = self.begin.alpha + self.pace * (self.part * s * k / count)
            self.way.newton.full(alpha, x)
        return LinkageCoordinates(alpha, x)

    def jacobian(self, number: int, position: LinkageCoordinates) -> Array:
        """Jacobian of a block; rows of arms do not turn with these, but are at the end.

        An arm's two rows are along it and across it, which means the same equations.
        """
        self.way.newton.equations.place(position)
        matrix = self.way.newton.blocks[number].jacobian()
        off = np.concatenate(position) - np.concatenate(self.end)
        curves = self.solver.mechanism.blocks[number].curves
        for arm in [curve for curve in curves if curve.is_arm][::2]:
            turned = sum(factor * off[place] for place, factor in arm.angle)
            c, s = np.cos(turned), np.sin(turned)
            rows = slice(arm.row, arm.row + 2)
            matrix[rows] = np.array([[c, s], [-s, c]]) @ matrix[rows]
        return matrix


@pytest.mark.parametrize("divisions", [300.0, 60.0])
def test_what_the_certificate_says_of_the_tube_is_so(
    solver: LinkageSolver, divisions: float
) -> None:
    """Solutions are within its radius of the cubics, Jacobians turn at most as it says."""
    step = Step(solver, divisions)
    way, blocks = step.cubics(), step.way.newton.blocks
    pairs = zip(step.way._certifiers, blocks, strict=True)
    tilts = np.array([one.tilt(block, way, 0.0) for one, block in pairs])
    assert max(tilts) <= MOST_TILT
    inputs = len(step.pace)
    off, turned = np.zeros_like(way.radius), np.zeros(len(blocks))
    for s in np.linspace(0.0, 1.0, 9):
        found = step.at(s)
        cubic = step.begin.x + (way.first * s + way.second * s * s + way.third * s**3)[inputs:]
        off[inputs:] = np.maximum(off[inputs:], np.abs(found.x - cubic))
        for number, block in enumerate(blocks):
            there = step.jacobian(number, step.end)
            change = np.linalg.solve(there, step.jacobian(number, found) - there)
            change *= block.scale[:, np.newaxis] / block.scale
            turned[number] = max(turned[number], np.abs(change).sum(axis=1).max())
    assert (off <= way.radius + 1e-13 * solver.mechanism.length).all()
    assert (turned <= tilts + 1e-12).all()
    # It says hardly more than what is.
    most = np.max(off[inputs:] / np.maximum(way.radius[inputs:], 1e-12))
    assert most >= 0.5
    if turned.any():
        assert max(turned) >= 0.1 * max(tilts)


@pytest.mark.parametrize("size", [0.1, 10.0])
def test_a_linkage_of_another_size_turns_as_much(size: float, tmp_path: Path) -> None:
    """Angles count as lengths: those of links that are longer move more."""

    def enlarged(found: re.Match[str]) -> str:
        return f"at = [{size * float(found[1])}, {size * float(found[2])}]"

    tilts = []
    for name, scene in (("one", RIGID), ("other", re.sub(r"at = \[(.*), (.*)\]", enlarged, RIGID))):
        step = Step(load_linkage(emitted(scene, tmp_path / name), target="numpy"), 60.0)
        way, blocks = step.cubics(), step.way.newton.blocks
        pairs = zip(step.way._certifiers, blocks, strict=True)
        tilts.append([one.tilt(block, way, 0.0) for one, block in pairs])
    np.testing.assert_allclose(tilts[1], tilts[0], rtol=1e-6, atol=1e-12)


def test_condition_is_the_norm_of_the_inverse(solver: LinkageSolver) -> None:
    rows = solver.rows(solver.request(divisions=12))
    step = Step(solver, 12.0)
    for row, position in ((0, step.begin), (1, step.end)):
        norms = []
        step.end = position
        for number, block in enumerate(step.way.newton.blocks):
            inverse = np.linalg.inv(step.jacobian(number, position))
            norms.append(np.abs(inverse * block.scale[:, np.newaxis]).sum(axis=1).max())
        assert rows.condition[row] == pytest.approx(max(norms), rel=1e-9)


@pytest.mark.parametrize(
    ("a", "b", "c"), [(0.5, 0, 0), (0, 0.5, 0), (1, 0.5, 0), (0.2, 0, 0.4), (0.3, -0.4, 0.2)]
)
def test_an_arm_is_left_by_cubics_as_little_as_is_said(a: float, b: float, c: float) -> None:
    """A direction whose angle goes by a cubic, beside the cubics of its x and y."""
    s = np.linspace(0.0, 1.0, 101)
    turn = np.exp(1j * (a * s + b * s**2 + c * s**3))
    rates = 1j * a, 1j * b - a * a / 2  # of e^(iβ) at s = 0
    rest = turn[-1] - 1 - sum(rates)
    left = np.abs(turn - (1 + rates[0] * s + rates[1] * s**2 + rest * s**3)).max()
    block = Block(slice(0, 1), (), (Curve(0, 2.0, (), (), True, ((0, 1.0),)),))
    angle = (InputRecord("beta", "rad", 1.0, start=0.0),)
    unknown = (Unknown("x", 0.0, 1.0, is_angle=False),)
    mechanism = LinkageTables("m", 2.0, (), (), (), angle, unknown, (block,), 0, {}, {})
    first, second, third = (np.array([x, 0.0]) for x in (a, b, c))
    way = CubicTube(first, second, third, np.zeros(2))
    error = float(Certifier(mechanism, block)._arms(way)[0, 0])
    assert 0.01 * error <= 2.0 * left <= error


def test_c_says_of_a_tube_what_numpy_says(
    solver: LinkageSolver, folder: Path, compiler: Toolchain, rng: np.random.Generator
) -> None:
    """Also of ways that nothing leads along, and where what is known is off."""
    (folder / "tilts.c").write_text(IN_C, encoding="utf-8")
    library = str(folder / "tilts.so")
    flags = [f"-I{folder}", "-O0"]
    command = compiler.compile_command([str(folder / "tilts.c")], library, flags)
    subprocess.run(command, check=True)
    tilts_of = ctypes.CDLL(library).tilts_of
    step = Step(solver, 60.0)
    blocks, certifiers = step.way.newton.blocks, step.way._certifiers
    end, places = step.end, len(step.pace) + len(step.end.x)
    for size in (1e-3, 0.03, 0.3):
        first, second, third = (size ** (k + 1) * rng.normal(size=places) for k in range(3))
        way = CubicTube(first, second, third, np.zeros(places))
        way.radius[: len(step.pace)] = size**4
        given = np.ravel(way)
        tilts = []
        step.evaluate(end)
        for block, one in zip(blocks, certifiers, strict=True):
            tilts.append(one.tilt(block, way, 1e-9))
        found = np.zeros(len(blocks))
        numbers = [np.ctypeslib.as_ctypes(array) for array in (end.alpha, end.x, given, found)]
        tilts_of(*numbers[:3], ctypes.c_double(1e-9), numbers[3])
        np.testing.assert_allclose(found, tilts, rtol=1e-9)
        np.testing.assert_allclose(given[-places:], way.radius, rtol=1e-9)
