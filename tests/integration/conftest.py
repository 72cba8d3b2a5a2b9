"""Solvers of scenes, generated once in a session, and exact planar geometry in 50 digits."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from mpmath import MPContext
from msgspec.structs import astuple

from kousoku.codegen.linkage.generate import generate_linkage
from kousoku.model.reading.read import read_scene, scene_from_toml
from kousoku.runtime.dynamics import DynamicsSolver, load_dynamics
from kousoku.runtime.linkage import LinkageSolver, load_linkage

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.records.scene import Scene
    from kousoku.runtime.toolchain import Toolchain

    Mover = Callable[..., DynamicsSolver]

FOLDER = Path(__file__).parent
SCENES = Path(__file__).parents[2] / "scenes"


@pytest.fixture(scope="session")
def folder_of(shared_tree: Callable[..., Path]) -> Callable[[Scene], Path]:
    """Folder of a linkage's solver, without what ``verify`` compares it with."""
    return lambda scene: shared_tree(
        scene.name, ("linkage", astuple(scene)), lambda: generate_linkage(scene)
    )


@pytest.fixture
def solver_in(folder_of: Callable[[Scene], Path]) -> Callable[..., LinkageSolver]:
    """Linkage's solver, by its file in ``scenes/`` or by its text, for a target."""

    def load(text: str, target: Any) -> LinkageSolver:
        if text in {path.stem for path in SCENES.glob("*.toml")}:
            scene = read_scene(SCENES / f"{text}.toml")
        else:
            scene = scene_from_toml(text)
        return load_linkage(folder_of(scene), target=target)

    return load


@pytest.fixture
def solver(
    solver_in: Callable[..., LinkageSolver], compiler: Toolchain
) -> Callable[[str], LinkageSolver]:
    """Linkage's solver in C: ``test_linkage_targets.py`` has that NumPy does the same."""
    return lambda text: solver_in(text, "c")


@pytest.fixture(scope="session")
def adams_samples() -> dict[str, Any]:
    """Samples that ADAMS prints of its cases, by case and time."""
    samples: dict[str, Any] = json.loads((FOLDER / "adams_samples.json").read_text("utf-8"))
    return samples


@pytest.fixture(scope="session")
def mover(bodies_folder: Callable[..., Path], compiler: Toolchain) -> Mover:
    """Solver of a scene of bodies, by its file in ``scenes/`` or as it is, in C."""
    known: dict[tuple[str, tuple[str, ...]], DynamicsSolver] = {}

    def load(scene: str | Scene, outputs: tuple[str, ...] = ()) -> DynamicsSolver:
        name = scene if isinstance(scene, str) else repr(astuple(scene))
        key = name, outputs
        if key not in known:
            found = read_scene(SCENES / f"{scene}.toml") if isinstance(scene, str) else scene
            known[key] = load_dynamics(bodies_folder(found, outputs))
        return known[key]

    return load


Point = tuple[Any, Any]


class Plane:
    """Circles, links and derivatives in 50 digits: what solvers are compared with."""

    mp = MPContext()
    mp.dps = 50
    #: Step of differences: their error is its fourth power.
    step = mp.mpf(10) ** -10

    def turned(self, center: Point, length: Any, angle: Any) -> Point:
        """End of a link that starts at ``center``."""
        return center[0] + length * self.mp.cos(angle), center[1] + length * self.mp.sin(angle)

    def meet(self, a: Point, ra: Any, b: Point, rb: Any, side: int) -> Point:
        """Point where two circles meet, left (1) or right (-1) of the way from a to b."""
        ra, rb = self.mp.mpf(ra), self.mp.mpf(rb)
        dx, dy = b[0] - a[0], b[1] - a[1]
        square = dx * dx + dy * dy
        along = (ra**2 - rb**2 + square) / (2 * square)
        across = side * self.mp.sqrt(ra**2 / square - along * along)
        return a[0] + along * dx - across * dy, a[1] + along * dy + across * dx

    def motion(self, place: Callable[[Any], Point], time: Any) -> tuple[Point, Point, Point]:
        """Position, velocity and acceleration of a point at a time."""
        values = [place(time + k * self.step) for k in range(-2, 3)]

        def weighted(weights: tuple[int, ...], order: int) -> Point:
            x, y = (
                sum(w * value[axis] for w, value in zip(weights, values, strict=True))
                / (12 * self.step**order)
                for axis in (0, 1)
            )
            return x, y

        return values[2], weighted((1, -8, 0, 8, -1), 1), weighted((-1, 16, -30, 16, -1), 2)

    def error(self, got: Any, wanted: Point) -> float:
        """Distance of a computed point from the exact one."""
        x, y = (self.mp.mpf(float(a)) - b for a, b in zip(got, wanted, strict=True))
        return float(self.mp.hypot(x, y))


@pytest.fixture(scope="session")
def plane() -> Plane:
    """Exact planar geometry."""
    return Plane()
