"""A body about a fixed point in tools that start from scenes: their joints are quaternions."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from tests.benchmarks.kit import required
from tests.benchmarks.peers.exudyn import SOLVERS, set_up
from tests.benchmarks.peers.scipy import solved

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.numbers.real import Array
    from tests.benchmarks.problems.top import Top

    Runs = tuple[Callable[[], object], Callable[[], Array]]

WEIGHT = 9.81
#: Exudyn's lines: those of index 3 and 2 hold it by a spherical joint.
EXUDYN = ("generalised alpha, index 3", "trapezoidal, index 2", "RK44", "RK67")


def axes_of(p: Array) -> Array:
    """Axes of the body, (9,), of Euler parameters of any length."""
    a, b, c, d = p / np.sqrt(p @ p)
    return np.array(
        [
            *(a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)),
            *(2 * (b * c - a * d), a * a - b * b + c * c - d * d, 2 * (c * d + a * b)),
            *(2 * (b * d + a * c), 2 * (c * d - a * b), a * a - b * b - c * c + d * d),
        ]
    )


def mujoco(top: Top, method: str, steps: int, times: Array) -> Runs:
    """Run of MuJoCo: a ball joint."""
    mj = required("mujoco")

    def words(numbers: Any) -> str:
        return " ".join(repr(float(x)) for x in numbers)

    model = mj.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 {-WEIGHT}"/><worldbody><body><joint type="ball"/>'
        f'<inertial pos="{words(top.center)}" mass="{top.mass}"'
        f' diaginertia="{words(top.inertia)}"/></body></worldbody></mujoco>'
    )
    model.opt.timestep = float(times[-1]) / steps
    model.opt.integrator = getattr(mj.mjtIntegrator, f"mjINT_{method.upper()}")
    data = mj.MjData(model)

    def begin() -> None:
        mj.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = [1.0, 0, 0, 0], top.omega

    def run() -> None:
        begin()
        mj.mj_step(model, data, steps)

    def positions() -> Array:
        begin()
        rows = []
        for _ in times:
            mj.mj_step(model, data, steps // len(times))
            rows.append(axes_of(np.array(data.qpos)))
        return np.array(rows)

    return run, positions


def pinocchio(top: Top, tolerance: float, times: Array) -> Runs:
    """Run of Pinocchio's accelerations with the rate of its quaternion."""
    pin = required("pinocchio")
    model = pin.Model()
    model.gravity.linear = np.array([0, 0, -WEIGHT])
    place = pin.SE3.Identity()
    joint = model.addJoint(0, pin.JointModelSpherical(), place, "point")
    inertia = pin.Inertia(top.mass, np.array(top.center), np.diag(top.inertia))
    model.appendBodyToJoint(joint, inertia, place)
    data, none = model.createData(), np.zeros(3)

    def rate(_t: float, x: Array) -> Array:
        q, w = x[:4], x[4:]  # the scalar comes last
        change = pin.aba(model, data, q, w, none)
        turned = 0.5 * (q[3] * w + np.cross(q[:3], w))
        return np.array([*turned, -0.5 * (q[:3] @ w), *change])

    run, states = solved(rate, np.array([0, 0, 0, 1.0, *top.omega]), tolerance, times)
    return run, lambda: np.array([axes_of(x[[3, 0, 1, 2]]) for x in states()])


def exudyn(top: Top, line: str, steps: int, times: Array) -> Runs:
    """Run of Exudyn: a spherical joint, or for explicit steps held coordinates."""
    exu, items = required("exudyn"), required("exudyn.itemInterface")
    utilities = required("exudyn.utilities")
    is_explicit = "index" not in line
    container = exu.SystemContainer()
    system = container.AddSystem()
    moments = np.diag(top.about_point if is_explicit else top.inertia)
    place = np.zeros(3) if is_explicit else np.array(top.center)
    kinds = exu.NodeType
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        ground = system.CreateGround()
        body = system.CreateRigidBody(
            referencePosition=place,
            inertia=utilities.RigidBodyInertia(mass=top.mass, inertiaTensor=moments),
            gravity=[0, 0, 0 if is_explicit else -WEIGHT],
            initialVelocity=np.cross(top.omega, place),
            initialAngularVelocity=list(top.omega),
            nodeType=kinds.RotationRotationVector if is_explicit else kinds.RotationEulerParameters,
        )
    if not is_explicit:
        system.CreateSphericalJoint(bodyNumbers=[ground, body], position=[0, 0, 0])
    elif top.is_held:
        marker = system.AddMarker(
            items.MarkerBodyRigid(bodyNumber=body, localPosition=list(top.center))
        )
        weight = [0, 0, -top.mass * WEIGHT]
        system.AddLoad(items.LoadForceVector(markerNumber=marker, loadVector=weight))
        fixed = system.AddNode(items.NodePointGround())
        first = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=fixed, coordinate=0))
        node = system.GetObject(body)["nodeNumber"]
        for k in range(3):
            other = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=k))
            system.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[first, other]))
    sensor = system.AddSensor(
        items.SensorBody(
            bodyNumber=body,
            storeInternal=True,
            writeToFile=False,
            outputVariableType=exu.OutputVariableType.RotationMatrix,
        )
    )
    system.Assemble()
    solver = getattr(exu.DynamicSolverType, SOLVERS[line])
    end = float(times[-1])

    def go(period: float, _kept: Any = container) -> None:
        options = set_up(line, steps, end, period)
        if not system.SolveDynamic(
            options, solverType=solver, updateInitialValues=False, storeSolver=False
        ):
            raise ArithmeticError("Exudyn gives up")

    def positions() -> Array:
        go(end / len(times))
        table = system.GetSensorStoredData(sensor)[-len(times) :, 1:]
        columns: Array = table.reshape(-1, 3, 3).swapaxes(1, 2).reshape(-1, 9)
        return columns

    return (lambda: go(end)), positions
