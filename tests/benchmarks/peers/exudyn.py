"""Exudyn: bodies and joints with multipliers, or a tree in joint coordinates; steps of one length.

A body's reference point is its centre of mass; trees are its ``ObjectKinematicTree``.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from tests.benchmarks.kit import required
from tests.benchmarks.problems.tree import GROUND, frames, slopes

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.numbers.real import Array
    from tests.benchmarks.problems.tree import Point, Tree

#: Numerical damping of generalised alpha: 1 is none, and passes no singular position.
SPECTRAL_RADIUS = 0.95
#: From so many bodies on its sparse solver is faster.
SPARSE = 20
#: Its solvers by the names of lines.
SOLVERS = {
    "generalised alpha, index 3": "GeneralizedAlpha",
    "trapezoidal, index 2": "TrapezoidalIndex2",
    "RK44": "RK44",
    "RK67": "RK67",
}
EXPLICIT = ("RK44", "RK67")


def is_planar(tree: Tree) -> bool:
    """Whether all links move in the plane x, y."""
    return all(link.joint in ("z", "slide x", "slide y") for link in tree.links)


class ExudynModel:
    """A model and the sensors of its observed points.

    Parameters
    ----------
    tree : Tree
        The mechanism.
    is_tree : bool
        Whether in joint coordinates.
    """

    def __init__(self, tree: Tree, *, is_tree: bool) -> None:
        self.exudyn, self.items = required("exudyn"), required("exudyn.itemInterface")
        self.tree = tree
        self._container = self.exudyn.SystemContainer()
        self.system = self._container.AddSystem()
        self._ground = self.system.AddObject(self.items.ObjectGround())
        self._where = frames(tree, np.array(tree.q))
        if is_tree:
            self._as_tree()
        else:
            self._as_bodies()
        for spring in tree.springs:
            markers = [self._marker(point) for point in (spring.a, spring.b)]
            self.system.AddObject(
                self.items.ObjectConnectorSpringDamper(
                    markerNumbers=markers,
                    stiffness=spring.stiffness,
                    damping=spring.damping,
                    referenceLength=spring.free_length,
                )
            )
        for loop in tree.loops:
            rows = [int(axis in loop.rows) for axis in "xyz"]
            self._join(self._marker(loop.a), self._marker(loop.b), [*rows, 0, 0, 0])
        self.sensors = [
            self.system.AddSensor(
                self.items.SensorMarker(
                    markerNumber=self._marker(point),
                    storeInternal=True,
                    writeToFile=False,
                    outputVariableType=self.exudyn.OutputVariableType.Position,
                )
            )
            for point in tree.observed
        ]
        self.system.Assemble()

    def _as_tree(self) -> None:
        tree, exu, count = self.tree, self.exudyn, len(self.tree.links)
        node = self.system.AddNode(
            self.items.NodeGenericODE2(
                referenceCoordinates=[0.0] * count,
                initialCoordinates=list(tree.q),
                initialCoordinates_t=list(tree.v),
                numberOfODE2Coordinates=count,
            )
        )
        kinds = [
            f"{'Prismatic' if link.is_slide else 'Revolute'}{'XYZ'[link.axis]}"
            for link in tree.links
        ]
        self._object = self.system.AddObject(
            self.items.ObjectKinematicTree(
                nodeNumber=node,
                jointTypes=[getattr(exu.JointType, kind) for kind in kinds],
                linkParents=[link.parent for link in tree.links],
                jointTransformations=exu.Matrix3DList([np.eye(3)] * count),
                jointOffsets=exu.Vector3DList([list(link.at) for link in tree.links]),
                linkInertiasCOM=exu.Matrix3DList([np.diag(link.inertia) for link in tree.links]),
                linkCOMs=exu.Vector3DList([list(link.center) for link in tree.links]),
                linkMasses=[link.mass for link in tree.links],
                baseOffset=[0.0] * 3,
                gravity=list(tree.gravity),
                linkForces=exu.Vector3DList([np.zeros(3)] * count),
                linkTorques=exu.Vector3DList([np.zeros(3)] * count),
                jointForceVector=[tree.torques.get(k, 0.0) for k in range(count)],
            )
        )
        self._marker = self._marker_of_tree

    def _marker_of_tree(self, point: Point) -> int:
        link, place = point
        if link == GROUND:
            return self._marker_of_ground(point)
        return int(
            self.system.AddMarker(
                self.items.MarkerKinematicTreeRigid(
                    objectNumber=self._object, linkNumber=link, localPosition=list(place)
                )
            )
        )

    def _marker_of_ground(self, point: Point) -> int:
        return int(
            self.system.AddMarker(
                self.items.MarkerBodyRigid(bodyNumber=self._ground, localPosition=list(point[1]))
            )
        )

    def _as_bodies(self) -> None:
        tree = self.tree
        add = self._planar if is_planar(tree) else self._spatial
        self._bodies = [add(k) for k in range(len(tree.links))]
        self._marker = self._marker_of_body
        for k, link in enumerate(tree.links):
            ends = self._marker((link.parent, link.at)), self._marker((k, (0.0, 0.0, 0.0)))
            turns, shifts = [1, 1, 1], [1, 1, 1]
            (shifts if link.is_slide else turns)[link.axis] = 0
            if is_planar(tree):
                turns[:2], shifts[2] = [0, 0], 0
            if is_planar(tree) and not link.is_slide:
                self.system.AddObject(self.items.ObjectJointRevolute2D(markerNumbers=list(ends)))
            else:
                self._join(*ends, [*shifts, *turns])
            if k in tree.torques:
                axis = [0.0, 0.0, 0.0]
                axis[link.axis] = tree.torques[k]
                marker = self._marker((k, (0.0, 0.0, 0.0)))
                self.system.AddLoad(
                    self.items.LoadTorqueVector(markerNumber=marker, loadVector=axis)
                )

    def _marker_of_body(self, point: Point) -> int:
        link, place = point
        if link == GROUND:
            return self._marker_of_ground(point)
        at = np.array(place) - self.tree.links[link].center
        return int(
            self.system.AddMarker(
                self.items.MarkerBodyRigid(bodyNumber=self._bodies[link], localPosition=at)
            )
        )

    def _moves(self, k: int) -> tuple[Array, Array, Array]:
        """Place and velocity of a link's centre of mass, and its angular velocity."""
        tree, link = self.tree, self.tree.links[k]
        place = self._where[0][k] + self._where[1][k] @ link.center
        velocity = np.array(tree.v) @ slopes(tree, (k, link.center), self._where)
        omega, above = np.zeros(3), k
        while above != GROUND:
            one = tree.links[above]
            if not one.is_slide:
                omega = omega + self._where[1][above][:, one.axis] * tree.v[above]
            above = one.parent
        return place, velocity, omega

    def _planar(self, k: int) -> int:
        link, (place, velocity, omega) = self.tree.links[k], self._moves(k)
        angle = float(np.arctan2(self._where[1][k][1, 0], self._where[1][k][0, 0]))
        node = self.system.AddNode(
            self.items.NodeRigidBody2D(
                referenceCoordinates=[*place[:2], angle],
                initialVelocities=[*velocity[:2], omega[2]],
            )
        )
        body = self.system.AddObject(
            self.items.ObjectRigidBody2D(
                nodeNumber=node, physicsMass=link.mass, physicsInertia=link.inertia[2]
            )
        )
        marker = self.system.AddMarker(self.items.MarkerBodyMass(bodyNumber=body))
        self.system.AddLoad(
            self.items.LoadMassProportional(markerNumber=marker, loadVector=list(self.tree.gravity))
        )
        return int(body)

    def _spatial(self, k: int) -> int:
        link, (place, velocity, omega) = self.tree.links[k], self._moves(k)
        utilities = required("exudyn.utilities")
        return int(
            self.system.CreateRigidBody(
                referencePosition=place,
                inertia=utilities.RigidBodyInertia(
                    mass=link.mass, inertiaTensor=np.diag(link.inertia)
                ),
                referenceRotationMatrix=self._where[1][k],
                gravity=list(self.tree.gravity),
                initialVelocity=list(velocity),
                initialAngularVelocity=list(omega),
                nodeType=self.exudyn.NodeType.RotationEulerParameters,
            )
        )

    def _join(self, a: int, b: int, axes: list[int]) -> None:
        """Keep two markers together in some directions; turns are seen from the first."""
        self.system.AddObject(self.items.GenericJoint(markerNumbers=[a, b], constrainedAxes=axes))


def set_up(
    line: str, steps: int, end: float, period: float, links: int = 1, *, is_tight: bool = True
) -> Any:
    """Settings of a run that lets sensors write so often.

    Newton's tolerances are tightened, or short steps would not pay; not where constraints lose
    rank on the way, which it then does not pass.
    """
    exu = required("exudyn")
    found = exu.SimulationSettings()
    found.solutionSettings.writeSolutionToFile = False
    found.solutionSettings.sensorsWritePeriod = period
    found.displayStatistics = found.displayComputationTime = False
    integration = found.timeIntegration
    integration.endTime = end
    integration.numberOfSteps = steps
    integration.verboseMode = 0
    integration.automaticStepSize = False
    alpha = integration.generalizedAlpha
    alpha.spectralRadius = SPECTRAL_RADIUS
    alpha.computeInitialAccelerations = True
    alpha.useIndex2Constraints = alpha.useNewmark = "index 2" in line
    integration.newton.useModifiedNewton = True
    if is_tight:
        integration.newton.relativeTolerance = 1e-10
        integration.newton.absoluteTolerance = 1e-12
    if links >= SPARSE:
        found.linearSolverType = exu.LinearSolverType.EigenSparse
    return found


def runs(
    tree: Tree, line: str, steps: int, times: Array, *, is_tight: bool = True
) -> tuple[Callable[[], object], Callable[[], Array]]:
    """Functions that run to the end, and that give the observed positions at all times."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        has_cross = not all(link.mass for link in tree.links)
        system = ExudynModel(tree, is_tree=line in EXPLICIT or has_cross)
    solver = getattr(system.exudyn.DynamicSolverType, SOLVERS[line])
    end = float(times[-1])

    def go(period: float) -> None:
        links = len(tree.links)
        options = set_up(line, steps, end, period, links, is_tight=is_tight)
        done = system.system.SolveDynamic(
            options, solverType=solver, updateInitialValues=False, storeSolver=False
        )
        if not done:
            raise ArithmeticError("Exudyn gives up")

    def positions() -> Array:
        go(end / len(times))
        axes = [1 + "xyz".index(axis) for axis in tree.axes]
        tables = [system.system.GetSensorStoredData(sensor) for sensor in system.sensors]
        rows = [table[-len(times) :][:, axes] for table in tables]
        return np.hstack(rows)

    return (lambda: go(end)), positions
