"""Systems to test with, and a dense solution of their equations from the shipped kinds."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from kousoku.codegen.kernel_json import load_frozen
from kousoku.model.mechanics.multibody import GROUND_INDEX, Instance, MovingBody, System
from kousoku.model.operations.arithmetic import FLOAT
from kousoku.model.operations.interpret import evaluate

GRAVITY = (0.0, 0.0, -9.81)
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def body(name: str, r: Any, p: Any = (1.0, 0.0, 0.0, 0.0), **other: Any) -> MovingBody:
    """Rigid body of 1.3 kg, or what ``other`` says."""
    given: dict[str, Any] = {
        "mass": 1.3,
        "inertia": (0.2, 0.3, 0.25),
        "is_point": False,
        "v": (0.0, 0.0, 0.0),
        "omega_b": (0.0, 0.0, 0.0),
        "origin_b": (0.0, 0.0, 0.0),
        "axes_b": (1.0, 0.0, 0.0, 0.0),
    }
    return MovingBody(name=name, r=tuple(r), p=tuple(p), **given | other)


def point(joint: str, i: int, j: int, s_i: Any, s_j: Any) -> Instance:
    constants = (("s_i_b", tuple(s_i)), ("s_j_b", tuple(s_j)))
    return Instance(joint, "point", i, j, constants)


def parallel(joint: str, i: int, j: int, axis: Any, other: Any | None = None) -> Instance:
    """p1 of two axes, each an axis of its frame."""
    kind = f"p1_{'xyz'[max(range(3), key=lambda k: abs(axis[k]))]}"
    constants = (("a_i_b", tuple(axis)), ("a_j_b", tuple(other or axis)))
    return Instance(joint, kind, i, j, constants)


def revolute(joint: str, i: int, j: int, s_i: Any, s_j: Any, axis: Any) -> list[Instance]:
    return [point(joint, i, j, s_i, s_j), parallel(joint, i, j, axis)]


def chain(count: int, gravity: Any = GRAVITY) -> System:
    """Rods of one metre along x, turning about y and z in turn, stretched out."""
    bodies, constraints = [], []
    for k in range(count):
        bodies.append(body(f"b{k}", (k + 0.5, 0.0, 0.0)))
        before = (0.0, 0.0, 0.0) if k == 0 else (0.5, 0.0, 0.0)
        axis = Z if k % 2 else Y
        constraints += revolute(f"j{k}", k - 1, k, before, (-0.5, 0.0, 0.0), axis)
    return System(f"chain{count}", 1.0, tuple(bodies), tuple(constraints), gravity)


def four_bars(count: int) -> System:
    """A02: ``count`` loops of rods of one metre, upright, moving in the xy-plane."""
    upright = (math.cos(math.pi / 4), 0.0, 0.0, math.sin(math.pi / 4))
    rod = {"mass": 1.0, "inertia": (1 / 12, 1 / 12, 1 / 12)}
    bodies, constraints = [], []
    for k in range(count + 1):
        bodies.append(body(f"rod{k}", (k, 0.5, 0.0), upright, **rod))
        ends = (float(k), 0.0, 0.0), (-0.5, 0.0, 0.0)
        constraints += revolute(f"ground{k}", GROUND_INDEX, k, *ends, Z)
    for k in range(count):
        coupler = count + 1 + k
        bodies.append(body(f"coupler{k}", (k + 0.5, 1.0, 0.0), **rod))
        left, right = (-0.5, 0.0, 0.0), (0.5, 0.0, 0.0)
        constraints += revolute(f"left{k}", k, coupler, right, left, Z)
        constraints += revolute(f"right{k}", coupler, k + 1, right, right, Z)
    return System(f"bars{count}", 1.0, tuple(bodies), tuple(constraints), (0.0, -9.81, 0.0))


def four_bars_state(count: int, angle: float, rate: float) -> dict[str, Any]:
    """A02 with its rods at an angle from +x, turning at a rate."""
    along, across = np.array([math.cos(angle), math.sin(angle), 0.0]), np.array(Z)
    turned = [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]
    speed = rate * np.cross(across, along)
    rods, couplers = range(count + 1), range(count)
    feet = [np.array([k, 0.0, 0.0]) for k in rods] + [
        np.array([k + 0.5, 0.0, 0.0]) for k in couplers
    ]
    part = [0.5] * (count + 1) + [1.0] * count
    return {
        "r": np.array([foot + x * along for foot, x in zip(feet, part, strict=True)]),
        "p": np.array([turned] * (count + 1) + [[1.0, 0.0, 0.0, 0.0]] * count),
        "v": np.array([x * speed for x in part]),
        "omega_b": np.array([rate * across] * (count + 1) + [0.0 * across] * count),
    }


def planar_pendulum(count: int, offset: float = 0.0) -> System:
    """Rods along x that turn about z, each ``offset`` above the one before."""
    bodies, constraints = [], []
    for k in range(count):
        bodies.append(body(f"b{k}", (k + 0.5, 0.0, k * offset)))
        before = (0.0, 0.0, -0.5 * offset) if k == 0 else (0.5, 0.0, 0.5 * offset)
        after = (-0.5, 0.0, -0.5 * offset)
        constraints += revolute(f"j{k}", k - 1, k, before, after, Z)
    return System("pendulum", 1.0, tuple(bodies), tuple(constraints), (0.0, -9.81, 0.0))


def heavy_top() -> System:
    """Top on a spherical joint, one moment of inertia equal to another."""
    top = body("top", (0.0, 0.0, 1.0), inertia=(0.2, 0.2, 0.1))
    joint = point("tip", GROUND_INDEX, 0, (0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    return System("top", 1.0, (top,), (joint,), GRAVITY)


def point_on_rod() -> System:
    """Point that a rod of 1.5 m holds to the ground, and another one below it."""
    rest = {"is_point": True, "inertia": (0.0, 0.0, 0.0)}
    bodies = (body("upper", (1.5, 0.0, 0.0), **rest), body("lower", (2.5, 0.0, 0.5), **rest))
    nowhere = (("s_i_b", (0.0, 0.0, 0.0)), ("s_j_b", (0.0, 0.0, 0.0)))
    rods = (
        Instance("first", "distance", GROUND_INDEX, 0, (*nowhere, ("length", (1.5,)))),
        Instance("second", "distance", 0, 1, (*nowhere, ("length", (1.25,)))),
    )
    return System("points", 1.0, bodies, rods, GRAVITY)


def mixed() -> System:
    """Four bodies on a universal, a cylindrical, a fixed and a spherical joint of a tree."""
    tilted = (0.6, 0.0, 0.8)
    bodies = tuple(body(f"b{k}", (k, 0.5 * k, 0.1)) for k in range(4))
    cross = (("a_i_b", tilted), ("a_j_b", Y))
    slide = (("a_i_b", tilted), ("s_i_b", (0.1, 0.2, 0.3)), ("s_j_b", (-0.5, 0.0, 0.25)))
    keep = (("a_i_b", X), ("a_j_b", Y))
    constraints = (
        point("universal", GROUND_INDEX, 0, (0.2, 0.0, 0.0), (-0.5, 0.1, 0.0)),
        Instance("universal", "n1", GROUND_INDEX, 0, cross),
        parallel("cylinder", 0, 1, tilted, Y),
        Instance("cylinder", "p2_z", 0, 1, slide),
        point("weld", 1, 2, (0.5, 0.0, 0.0), (-0.5, 0.0, 0.0)),
        parallel("weld", 1, 2, Z),
        Instance("weld", "n1", 1, 2, keep),
        point("ball", 0, 3, (0.5, 0.5, 0.0), (-0.5, 0.0, 0.0)),
    )
    return System("mixed", 1.0, bodies, constraints, GRAVITY)


def star(count: int) -> System:
    """Body that holds ``count`` others on revolute joints, and nothing holds it."""
    bodies = [body("hub", (0.0, 0.0, 0.0))]
    constraints = []
    for k in range(count):
        angle = 2.0 * math.pi * k / count
        place = (math.cos(angle), math.sin(angle), 0.0)
        bodies.append(body(f"arm{k}", tuple(1.5 * x for x in place)))
        inner = tuple(-0.5 * x for x in place)
        constraints += revolute(f"j{k}", 0, k + 1, place, inner, Y)
    return System(f"star{count}", 1.0, tuple(bodies), tuple(constraints), GRAVITY)


def random_state(system: System, rng: np.random.Generator) -> dict[str, Any]:
    """Any positions and velocities, Euler parameters of norm one; points do not turn."""
    n = len(system.bodies)
    p = rng.normal(size=(n, 4))
    state = {
        "r": rng.normal(size=(n, 3)),
        "p": p / np.linalg.norm(p, axis=1)[:, None],
        "v": rng.normal(size=(n, 3)),
        "omega_b": rng.normal(size=(n, 3)),
    }
    for k, one in enumerate(system.bodies):
        if one.is_point:
            state["p"][k], state["omega_b"][k] = (1.0, 0.0, 0.0, 0.0), 0.0
    return state


def dense(system: System, state: dict[str, Any], loads: Any | None = None) -> tuple[Any, Any, Any]:
    """v̇ (n, 6), λ and C by NumPy, from the kinds as they are shipped.

    Parameters
    ----------
    system : System
        The bodies and constraints.
    state : dict
        ``r`` (n, 3), ``p`` (n, 4), ``v`` (n, 3) and ``omega_b`` (n, 3).
    loads : (n, 6) array, optional
        Force in frame O and torque in the body frame on each body, beside gravity.
    """
    n = 6 * len(system.bodies)
    mass, force = np.zeros((n, n)), np.zeros(n)
    for k, moving in enumerate(system.bodies):
        own = slice(6 * k, 6 * k + 6)
        inertia = (1.0, 1.0, 1.0) if moving.is_point else moving.inertia
        found = frozen_kernel(
            "rigid_body",
            "newton_euler",
            mass=[moving.mass],
            r_AG_b=[0.0] * 3,
            I_A_b=np.diag(inertia).ravel(),
            p=state["p"][k],
            omega_b=state["omega_b"][k],
            F=moving.mass * np.array(system.gravity),
            N_b=[0.0] * 3,
        )
        mass[own, own], force[own] = found["M"].reshape(6, 6), found["h"]
    if loads is not None:
        force += np.ravel(loads)
    rows, gammas, residuals = [], [], []
    for one in system.constraints:
        inputs = dict(one.constants)
        for end, index in (("i", one.i), ("j", one.j)):
            inputs |= ends(state, end, index)
        jacobian = frozen_kernel(one.kind, "constraint", **inputs)
        rates = frozen_kernel(one.kind, "rates", **inputs)
        block = np.zeros((len(jacobian["C"]), n + 12))
        halves = np.split(jacobian["C_q"].reshape(-1, 12), 2, axis=1)
        for index, part in zip((one.i, one.j), halves, strict=True):
            at = n if index == GROUND_INDEX else 6 * index
            block[:, at : at + 6] += part
        rows.append(block[:, :n])
        gammas.append(rates["gamma"])
        residuals.append(jacobian["C"])
    return solved(system, mass, force, np.vstack(rows), np.hstack(gammas), np.hstack(residuals))


def solved(
    system: System, mass: Any, force: Any, rows: Any, gamma: Any, residual: Any
) -> tuple[Any, Any, Any]:
    """Solve the dense equations; points have three columns, and least λ where rows repeat."""
    kept = [
        6 * k + c for k, one in enumerate(system.bodies) for c in range(3 if one.is_point else 6)
    ]
    a, c = mass[np.ix_(kept, kept)], rows[:, kept]
    matrix = np.block([[a, c.T], [c, np.zeros((len(c), len(c)))]])
    answer = np.linalg.lstsq(matrix, np.hstack([force[kept], gamma]), rcond=1e-11)[0]
    full = np.zeros(len(force))
    full[kept] = answer[: len(kept)]
    return full.reshape(-1, 6), answer[len(kept) :], residual


def ends(state: dict[str, Any], end: str, index: int) -> dict[str, Any]:
    zero = [0.0] * 3
    if index == GROUND_INDEX:
        values = [zero, [1.0, 0.0, 0.0, 0.0], zero, zero]
    else:
        values = [state[name][index] for name in ("r", "p", "v", "omega_b")]
    names = (f"r_{end}", f"p_{end}", f"v_{end}", f"omega_{end}_b")
    return dict(zip(names, values, strict=True))


def frozen_kernel(package: str, name: str, **inputs: Any) -> dict[str, Any]:
    kernel = next(one for one in load_frozen(package).kernels if one.name == name)
    lists = {key: [float(x) for x in value] for key, value in inputs.items()}
    return {key: np.array(value) for key, value in evaluate(kernel, lists, FLOAT).items()}


@pytest.fixture
def mechanisms() -> SimpleNamespace:
    """Systems and what they are compared with."""
    return SimpleNamespace(
        body=body,
        point=point,
        parallel=parallel,
        revolute=revolute,
        chain=chain,
        four_bars=four_bars,
        four_bars_state=four_bars_state,
        planar_pendulum=planar_pendulum,
        heavy_top=heavy_top,
        point_on_rod=point_on_rod,
        mixed=mixed,
        star=star,
        random_state=random_state,
        dense=dense,
        ends=ends,
        frozen_kernel=frozen_kernel,
    )
