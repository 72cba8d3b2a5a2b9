"""A four-bar of two blocks written by hand, in Python and in C: the library without the generator.

Block 1 is the crank's end A, known by alpha. Block 2 are the angles of coupler and rocker, by the
vector loop A + b (cos φ, sin φ) = D + c (cos ψ, sin ψ).
"""

from __future__ import annotations

import ctypes
import math
import subprocess
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.runtime.kinematics.rows import RunRequest, empty_rows
from kousoku.runtime.kinematics.solve import solve
from kousoku.runtime.kinematics.tables import (
    Block,
    Curve,
    InputRecord,
    LinkageTables,
    LinkRecord,
    Unknown,
)
from kousoku.runtime.linkage import record_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.kinematics.rows import Rows
    from kousoku.runtime.kinematics.tables import Array
    from kousoku.runtime.toolchain import Toolchain

    Regions = dict[str, Array]

SOURCE = Path(__file__).parent / "four_bar.c"
LIBRARY = Path(__file__).parents[3] / "runtime"
RUN = RunRequest(
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


#: The regions of the workspace, as in four_bar.c.
SIZES = {
    **{"alpha": 1, "x": 4, "alpha_dot": 1, "x_dot": 4, "alpha_ddot": 1, "x_ddot": 4},
    **{"epsilon": 2, "D": 4, "nu": 2, "gamma": 2},
    **dict.fromkeys(("position", "velocity", "acceleration"), 4),
    **dict.fromkeys(("angle", "angle_dot", "angle_ddot"), 3),
}
BASES = dict(zip(SIZES, accumulate(SIZES.values(), initial=0), strict=False))
ORDERS = ("position", "velocity", "acceleration")
SEGMENTS = (*(f"{order}_{block}" for block in (1, 2) for order in ORDERS), "nodes", "angles")


def on_workspace(segment: Callable[[Regions], None], slots: Array) -> None:
    """Run a segment that takes the workspace region by region."""
    segment({name: slots[BASES[name] : BASES[name] + n] for name, n in SIZES.items()})


A = (((1, 1.0),), ((2, 1.0),))
"""Where the end of the crank stands."""


def arm(length: float, place: int, ends: Any = ((), ())) -> tuple[Curve, Curve]:
    """Part of the direction of a link in both rows of a block."""
    x, y = ends
    first, second = (Curve(row, length, x, y, True, ((place, 1.0),)) for row in range(2))
    return first, second


@dataclass(frozen=True)
class FourBar:
    """Lengths [cm], and the angles of coupler, rocker and crank near the first position [rad]."""

    crank: float
    coupler: float
    rocker: float
    frame: float
    phi: float
    psi: float
    alpha: float = 0.0

    @property
    def mechanism(self) -> LinkageTables:
        lengths = (self.crank, self.coupler, self.rocker)
        nodes = (("O", "A"), ("A", "B"), ("D", "B"))
        return LinkageTables(
            unit="cm",
            length=self.frame,
            outputs=("velocities", "accelerations", "angles"),
            nodes=("A", "B"),
            links=tuple(
                LinkRecord(f"l{k + 1}", *nodes[k], length=length)
                for k, length in enumerate(lengths)
            ),
            inputs=(InputRecord("alpha", "rad", scale=self.crank, start=self.alpha),),
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
                    curves=arm(self.crank, 0, A),
                ),
                Block(
                    unknowns=slice(2, 4),
                    links=("l2", "l3"),
                    curves=(*arm(self.coupler, 3, A), *arm(self.rocker, 4)),
                ),
            ),
            work_size=sum(SIZES.values()),
            regions={name: (BASES[name], n) for name, n in SIZES.items()},
            segments={name: partial(on_workspace, getattr(self, name)) for name in SEGMENTS},
        )

    def position_1(self, w: Regions) -> None:
        w["epsilon"][:] = w["x"][:2] - arrow(self.crank, w["alpha"][0])
        w["D"][:] = [1.0, 0.0, 0.0, 1.0]

    def velocity_1(self, w: Regions) -> None:
        w["nu"][:] = arrow(self.crank, w["alpha"][0] + math.pi / 2) * w["alpha_dot"][0]

    def acceleration_1(self, w: Regions) -> None:
        (alpha,), (rate,), (rate_dot,) = w["alpha"], w["alpha_dot"], w["alpha_ddot"]
        across = arrow(self.crank, alpha + math.pi / 2)
        w["gamma"][:] = across * rate_dot - arrow(self.crank, alpha) * rate**2

    def position_2(self, w: Regions) -> None:
        *end, phi, psi = w["x"]
        goal = arrow(self.rocker, psi) + np.array([self.frame, 0])
        w["epsilon"][:] = end + arrow(self.coupler, phi) - goal
        across = arrow(self.coupler, phi + math.pi / 2), -arrow(self.rocker, psi + math.pi / 2)
        w["D"][:] = np.stack(across, axis=1).ravel()

    def velocity_2(self, w: Regions) -> None:
        w["nu"][:] = -w["x_dot"][:2]

    def acceleration_2(self, w: Regions) -> None:
        *_, phi, psi = w["x"]
        *_, phi_dot, psi_dot = w["x_dot"]
        bent = arrow(self.coupler, phi) * phi_dot**2 - arrow(self.rocker, psi) * psi_dot**2
        w["gamma"][:] = bent - w["x_ddot"][:2]

    def nodes(self, w: Regions) -> None:
        x, x1, x2 = w["x"], w["x_dot"], w["x_ddot"]
        across, out = arrow(self.rocker, x[3] + math.pi / 2), arrow(self.rocker, x[3])
        w["position"][:] = *x[:2], *(out + np.array([self.frame, 0]))
        w["velocity"][:] = *x1[:2], *(across * x1[3])
        w["acceleration"][:] = *x2[:2], *(across * x2[3] - out * x1[3] ** 2)

    def angles(self, w: Regions) -> None:
        for suffix in ("", "_dot", "_ddot"):
            w[f"angle{suffix}"][:] = w[f"alpha{suffix}"][0], *w[f"x{suffix}"][2:]


PLAIN = FourBar(crank=30.0, coupler=60.0, rocker=80.0, frame=100.0, phi=1.3, psi=2.3)


@pytest.fixture
def four_bar() -> FourBar:
    """Crank and rocker."""
    return PLAIN


@pytest.fixture(scope="session")
def compiled(
    compiler: Toolchain, tmp_path_factory: pytest.TempPathFactory
) -> Callable[..., ctypes.CDLL]:
    """The same four-bar in C."""
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
    """Rows of a four-bar, from either language; options are fields of the run."""

    def in_c(bar: FourBar, run: RunRequest) -> Rows:
        library = request.getfixturevalue("compiled")(bar)
        rows = empty_rows(bar.mechanism, run.rows)
        record = record_of(run, rows)
        assert library.test_run_size() == ctypes.sizeof(record)
        size = library.test_workspace_size()
        memory = ctypes.create_string_buffer(b"\xff" * size, size)  # of no meaning: all are NaN
        rows.status = library.test_solve(ctypes.byref(record), memory)
        rows.done, rows.block = record.done, record.block
        rows.reached = np.array(record.reached[:])
        return rows

    def in_python(bar: FourBar, run: RunRequest) -> Rows:
        return solve(bar.mechanism, run)

    def analyse(lengths: dict[str, float], **options: Any) -> Rows:
        bar, run = FourBar(**lengths), replace(RUN, **options)
        return in_c(bar, run) if backend == "c" else in_python(bar, run)

    return analyse
