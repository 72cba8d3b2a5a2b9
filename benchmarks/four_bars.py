"""The N-four-bar A02 over 10 s, by kousoku and by Exudyn, as users of each would set it up."""

from __future__ import annotations

import math
import time
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.kit import required
from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.families import n_four_bar
from kousoku.runtime.dynamics import DynamicsSolver, load_dynamics
from kousoku.runtime.motion import rotated
from kousoku.runtime.options import RUNGE_KUTTA

if TYPE_CHECKING:
    from pathlib import Path

    from kousoku.runtime.motion import Motion

COUNT = 40
END = 10.0
#: Rows that are written where the motion is wanted as a table, also the sensor of Exudyn.
ROWS = 1001
#: x of B₀ at 10 s, from the elliptic functions of the crank angle.
WANTED_X = 0.180512226686728
WANTED = np.array([WANTED_X, math.sqrt(1 - WANTED_X**2)])
POSITION_LIMIT, ENERGY_LIMIT = 1e-6, 5e-6
#: Loosest first.
TOLERANCES = tuple(x * 10.0**n for n in range(-6, -12, -1) for x in (1, 0.5, 0.2))
EXUDYN_STEPS = 10_000
#: With 1 it does not pass the singular positions; this loses least energy (0.6 loses forty times).
SPECTRAL_RADIUS = 0.95
MASS, MOMENT, WEIGHT = 1.0, 1 / 12, 9.81
START_ENERGY = (COUNT + 1) * (MASS / 6 + WEIGHT / 2) + COUNT * (MASS / 2 + WEIGHT)


@dataclass(frozen=True, slots=True)
class Reached:
    """Where a run ended.

    Parameters
    ----------
    seconds : float
        What it took.
    position : float [m]
        Error of B₀ at the end.
    energy : float [J]
        Largest change of the energy that was seen.
    derivatives : int
        Evaluations of the accelerations, where they are counted.
    """

    seconds: float
    position: float
    energy: float
    derivatives: int = 0


def load(folder: Path, count: int = COUNT) -> DynamicsSolver:
    """Generate, compile and load the solver."""
    write_tree(folder, generate_dynamics(n_four_bar(count)))
    return load_dynamics(folder)


def cheapest(solver: DynamicsSolver) -> tuple[float, str] | None:
    """Return the loosest tolerance that reaches both limits, with the method that costs least."""
    found = []
    for method in RUNGE_KUTTA:
        for tolerance in TOLERANCES:
            reached = kousoku_run(solver, tolerance, method, ROWS)
            if reached.position <= POSITION_LIMIT and reached.energy <= ENERGY_LIMIT:
                found.append((reached.derivatives, tolerance, method))
                break
    return min(found)[1:] if found else None


def kousoku_run(solver: DynamicsSolver, tolerance: float, method: str, rows: int) -> Reached:
    """Run to the end and judge it by its rows; the time is that of ``simulate``, all of it."""
    start = time.perf_counter()
    motion = solver.simulate(END, samples=rows, tolerance=tolerance, method=method, checks=False)
    seconds = time.perf_counter() - start
    change = energies(motion) - START_ENERGY
    ended = motion.position["coupler_0"][-1, :2]
    return Reached(
        seconds,
        float(np.hypot(*(ended - WANTED))),
        float(np.abs(change).max()),
        motion.ledger.derivatives,
    )


def energies(motion: Motion) -> np.ndarray:
    """Return kinetic and potential energy of all rows, from the motion of the bars' ends."""
    total = np.zeros(len(motion))
    for name, x in motion.position.items():
        half = (0, 0.5, 0) if name.startswith("crank") else (0.5, 0, 0)
        arm = rotated(motion.orientation[name], np.tile(half, (len(x), 1)))
        omega = motion.angular_velocity[name]
        spin = rotated(motion.orientation[name], omega)
        v = motion.velocity[name] + np.cross(spin, arm)
        total += MASS / 2 * np.sum(v * v, axis=1) + MOMENT / 2 * np.sum(omega**2, axis=1)
        total += WEIGHT * (x + arm)[:, 1]
    return total


class Exudyn:
    """Planar rigid bodies and revolute joints, generalised-alpha with 10,000 steps.

    Its sparse solver is chosen: with the dense one it takes four times as long.
    """

    def __init__(self) -> None:
        self.exudyn: Any = required("exudyn")
        self.items: Any = required("exudyn.itemInterface")

    def run(self) -> Reached:
        """Build, run and judge it; the time is that of ``SolveDynamic``."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            system, bodies, sensor = self._build()
            settings = self._settings()
            start = time.perf_counter()
            system.SolveDynamic(settings)
            seconds = time.perf_counter() - start
            ended = system.GetSensorStoredData(sensor)[-1, 1:3]
            change = sum(self._energy(system, body) for body in bodies) - START_ENERGY
        return Reached(seconds, float(np.hypot(*(ended - WANTED))), abs(float(change)))

    def _build(self) -> tuple[Any, list[int], int]:
        items = self.items
        self._container = self.exudyn.SystemContainer()
        system = self._container.AddSystem()
        ground = system.AddObject(items.ObjectGround())
        cranks = [self._bar(system, (k, 0.5, math.pi / 2), (0.5, 0, -1)) for k in range(COUNT + 1)]
        couplers = [self._bar(system, (k + 0.5, 1, 0), (1, 0, 0)) for k in range(COUNT)]
        for k, crank in enumerate(cranks):
            self._joint(system, (ground, (k, 0, 0)), (crank, (-0.5, 0, 0)))
        for k, coupler in enumerate(couplers):
            for side, end in enumerate((-0.5, 0.5)):
                self._joint(system, (cranks[k + side], (0.5, 0, 0)), (coupler, (end, 0, 0)))
        sensor = system.AddSensor(
            items.SensorBody(
                bodyNumber=cranks[0],
                localPosition=[0.5, 0, 0],
                storeInternal=True,
                writeToFile=False,
                outputVariableType=self.exudyn.OutputVariableType.Position,
            )
        )
        system.Assemble()
        return system, cranks + couplers, int(sensor)

    def _bar(self, system: Any, place: tuple[float, ...], velocity: tuple[float, ...]) -> int:
        items = self.items
        node = system.AddNode(
            items.NodeRigidBody2D(referenceCoordinates=place, initialVelocities=velocity)
        )
        body = system.AddObject(items.ObjectRigidBody2D(mass=MASS, inertia=MOMENT, nodeNumber=node))
        middle = system.AddMarker(items.MarkerBodyPosition(bodyNumber=body))
        system.AddLoad(items.LoadForceVector(markerNumber=middle, loadVector=[0, -WEIGHT, 0]))
        return int(body)

    def _joint(self, system: Any, *ends: tuple[int, tuple[float, ...]]) -> None:
        items = self.items
        markers = [
            system.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=point))
            for body, point in ends
        ]
        system.AddObject(items.ObjectJointRevolute2D(markerNumbers=markers))

    def _settings(self) -> Any:
        settings = self.exudyn.SimulationSettings()
        settings.linearSolverType = self.exudyn.LinearSolverType.EigenSparse
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = END / (ROWS - 1)
        integration = settings.timeIntegration
        integration.numberOfSteps = EXUDYN_STEPS
        integration.endTime = END
        integration.verboseMode = 0
        integration.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
        integration.newton.useModifiedNewton = True
        return settings

    def _energy(self, system: Any, body: int) -> float:
        kinds = self.exudyn.OutputVariableType
        names = (kinds.Velocity, kinds.AngularVelocity, kinds.Position)
        v, omega, x = (system.GetObjectOutputBody(body, name, [0, 0, 0]) for name in names)
        return float(MASS / 2 * v @ v + MOMENT / 2 * omega @ omega + WEIGHT * x[1])
