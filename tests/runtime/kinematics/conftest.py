"""A four-bar of two blocks written by hand, in Python and in C: the library without the generator.

Block 1 is the crank's end A, known by alpha. Block 2 are the angles of coupler and rocker, by the
vector loop A + b (cos φ, sin φ) = D + c (cos ψ, sin ψ).
"""

from __future__ import annotations

import ctypes
import math
import subprocess
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.runtime.kinematics.mechanism import Block, Curve, Input, Link, Mechanism, Unknown
from kousoku.runtime.kinematics.rows import Run, empty_rows
from kousoku.runtime.kinematics.solve import solve
from kousoku.runtime.linkage import record_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.kinematics.mechanism import Array
    from kousoku.runtime.kinematics.rows import Rows
    from kousoku.runtime.toolchain import Toolchain

SOURCE = Path(__file__).parent / "four_bar.c"
LIBRARY = Path(__file__).parents[3] / "runtime"
RUN = Run(
    method=0,
    max_iterations=50,
    limit=1e-12,
    divisions=12,
    rows=13,
    origin=(0.0,),
    span=(0.0,),
    turns=(1,),
    rate=(1.0,),
    rate_dot=(0.0,),
)


def arrow(length: float, angle: float) -> Array:
    return length * np.array([math.cos(angle), math.sin(angle)])


A = (((1, 1.0),), ((2, 1.0),))
"""Where the end of the crank stands."""


def arm(length: float, place: int, ends: Any = ((), ())) -> tuple[Curve, Curve]:
    """Return what the direction of a link does to both rows of a block."""
    x, y = ends
    first, second = (Curve(row, length, x, y, True, ((place, 1.0),)) for row in range(2))
    return first, second


@dataclass(frozen=True)
class FourBar:
    """Lengths [cm], and the angles of coupler and rocker near the first position [rad]."""

    crank: float
    coupler: float
    rocker: float
    frame: float
    phi: float
    psi: float

    @property
    def mechanism(self) -> Mechanism:
        lengths = (self.crank, self.coupler, self.rocker)
        nodes = (("O", "A"), ("A", "B"), ("D", "B"))
        return Mechanism(
            unit="cm",
            length=self.frame,
            outputs=("velocities", "accelerations", "angles"),
            nodes=("A", "B"),
            links=tuple(
                Link(f"l{k + 1}", *nodes[k], length=length) for k, length in enumerate(lengths)
            ),
            inputs=(Input("alpha", "rad", scale=self.crank),),
            unknowns=(
                Unknown("A.x", start=self.crank, scale=1.0, is_angle=False),
                Unknown("A.y", start=0.0, scale=1.0, is_angle=False),
                Unknown("phi", start=self.phi, scale=self.coupler, is_angle=True),
                Unknown("psi", start=self.psi, scale=self.rocker, is_angle=True),
            ),
            blocks=(
                Block(
                    unknowns=slice(0, 2),
                    links=("l1",),
                    known=(0,),
                    curves=arm(self.crank, 0, A),
                ),
                Block(
                    unknowns=slice(2, 4),
                    links=("l2", "l3"),
                    known=(1, 2),
                    curves=(*arm(self.coupler, 3, A), *arm(self.rocker, 4)),
                ),
            ),
        )

    def position_1(self, known: Array, x: Array, outputs: tuple[str, ...] = ()) -> Any:
        epsilon = x - arrow(self.crank, known[0])
        return (epsilon,) if outputs else (epsilon, np.eye(2))

    def velocity_1(self, known: Array, x: Array, known_dot: Array) -> Any:
        return (arrow(self.crank, known[0] + math.pi / 2) * known_dot[0],)

    def acceleration_1(
        self, known: Array, x: Array, known_dot: Array, x_dot: Array, known_ddot: Array
    ) -> Any:
        across = arrow(self.crank, known[0] + math.pi / 2)
        return (across * known_ddot[0] - arrow(self.crank, known[0]) * known_dot[0] ** 2,)

    def position_2(self, known: Array, x: Array, outputs: tuple[str, ...] = ()) -> Any:
        end = arrow(self.rocker, x[1]) + np.array([self.frame, 0])
        epsilon = known + arrow(self.coupler, x[0]) - end
        across = (arrow(self.coupler, x[0] + math.pi / 2), -arrow(self.rocker, x[1] + math.pi / 2))
        return (epsilon,) if outputs else (epsilon, np.stack(across, axis=1))

    def velocity_2(self, known: Array, x: Array, known_dot: Array) -> Any:
        return (-known_dot,)

    def acceleration_2(
        self, known: Array, x: Array, known_dot: Array, x_dot: Array, known_ddot: Array
    ) -> Any:
        phi, psi = x_dot**2
        return (arrow(self.coupler, x[0]) * phi - arrow(self.rocker, x[1]) * psi - known_ddot,)

    def nodes(self, alpha: Array, x: Array, _: Array, x1: Array, __: Array, x2: Array) -> Any:
        across, out = arrow(self.rocker, x[3] + math.pi / 2), arrow(self.rocker, x[3])
        b = out + np.array([self.frame, 0])
        return (
            np.stack((x[:2], b)),
            np.stack((x1[:2], across * x1[3])),
            np.stack((x2[:2], across * x2[3] - out * x1[3] ** 2)),
        )

    def angles(self, alpha: Array, x: Array, a1: Array, x1: Array, a2: Array, x2: Array) -> Any:
        motions = ((alpha, x), (a1, x1), (a2, x2))
        return tuple(np.array([given[0], *own[2:]]) for given, own in motions)


PLAIN = FourBar(crank=30.0, coupler=60.0, rocker=80.0, frame=100.0, phi=1.3, psi=2.3)


@pytest.fixture
def four_bar() -> FourBar:
    """Return a crank and rocker."""
    return PLAIN


@pytest.fixture(scope="session")
def compiled(
    compiler: Toolchain, tmp_path_factory: pytest.TempPathFactory
) -> Callable[..., ctypes.CDLL]:
    """Return the same four-bar in C."""
    known: dict[FourBar, ctypes.CDLL] = {}
    folder = tmp_path_factory.mktemp("four_bar")

    def build(bar: FourBar = PLAIN) -> ctypes.CDLL:
        if bar not in known:
            library = folder / f"four_bar_{len(known)}.so"
            flags = [f"-D{name}={value!r}".upper() for name, value in asdict(bar).items()]
            flags += [f"-I{LIBRARY}", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
            command = compiler.compile_command([str(SOURCE)], str(library), flags)
            subprocess.run(command, check=True)
            known[bar] = ctypes.CDLL(str(library))
        return known[bar]

    return build


@pytest.fixture
def analysed(request: pytest.FixtureRequest, backend: str) -> Callable[..., Rows]:
    """Return the rows of a four-bar, from either language; options are fields of the run."""

    def in_c(bar: FourBar, run: Run) -> Rows:
        library = request.getfixturevalue("compiled")(bar)
        rows = empty_rows(bar.mechanism, run.rows)
        record = record_of(run, rows)
        assert library.test_run_size() == ctypes.sizeof(record)
        memory = ctypes.create_string_buffer(library.test_workspace_size())
        rows.status = library.test_solve(ctypes.byref(record), memory)
        rows.done, rows.block = record.done, record.block
        rows.reached = np.array(record.reached[:])
        return rows

    def in_python(bar: FourBar, run: Run) -> Rows:
        kernels: Any = bar
        return solve(bar.mechanism, kernels, run)

    def analyse(lengths: dict[str, float], **options: Any) -> Rows:
        bar, run = FourBar(**lengths), replace(RUN, **options)
        return in_c(bar, run) if backend == "c" else in_python(bar, run)

    return analyse
