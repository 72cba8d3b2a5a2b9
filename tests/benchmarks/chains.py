"""Chains on alternating hinges: their states in joint angles, and what computes accelerations."""

from __future__ import annotations

import ctypes
import subprocess
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.reading.families import chain
from kousoku.runtime.dynamics import load_dynamics
from kousoku.runtime.toolchain import find_toolchain
from tests.benchmarks.rotations import composed, rotated

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


MASS = 1.0
#: Of a box of 1 m x 0.1 m x 0.1 m, about its centre and its axes [kg m²].
MOMENTS = np.array([0.02, 1.01, 1.01]) / 12
CENTRE = np.array([0.5, 0, 0])
ALONG = np.array([1.0, 0, 0])
#: Axes of the hinges in turn.
AXES = np.array([[0.0, 1, 0], [0, 0, 1]])
GRAVITY = np.array([0, 0, -9.81])
#: The states that a loop goes through, again and again.
STATES = 16

_DRIVER = """
#include "solver.c"
/* goes through the states many times: orientations, residuals, Jacobians, factors; then v dot */
void loop(size_t rounds, size_t states, const double *q, const double *v, double *v_dot, double *w)
{
    memcpy(w + W_CONSTANTS, constants, CONSTANTS * sizeof *w);
    for (size_t k = 0; k < rounds; ++k) {
        for (size_t s = 0; s < states; ++s) {
            memcpy(w + W_Q, q + s * NQ, NQ * sizeof *w);
            memcpy(w + W_V, v + s * NV, NV * sizeof *w);
            geometry(w);
            acceleration(w);
            memcpy(v_dot + s * NV, w + W_V_DOT, NV * sizeof *w);
        }
    }
}
"""


@dataclass(frozen=True, slots=True)
class Accelerations:
    """A program that computes the accelerations of a chain at the same states.

    Parameters
    ----------
    program : str
        Whose code.
    run : callable
        Goes through all states as often as it is told.
    results : callable
        Gives v̇ of the centres and ω̇′ of the bodies afterwards, each (states, bodies, 3).
    """

    program: str
    run: Callable[[int], object]
    results: Callable[[], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True, slots=True)
class Bars:
    """How the bars of a chain are and move, arrays over states and bars.

    Parameters
    ----------
    r, v, a : (states, bars, 3)
        Centre, its velocity and acceleration, in frame O.
    p : (states, bars, 4)
        Euler parameters.
    omega_b, alpha_b : (states, bars, 3)
        Angular velocity and its derivative, in the bar.
    """

    r: np.ndarray
    v: np.ndarray
    a: np.ndarray
    p: np.ndarray
    omega_b: np.ndarray
    alpha_b: np.ndarray


def joint_states(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Angles and rates of all hinges, (states, bars) each."""
    rng = np.random.default_rng(count)
    return rng.uniform(-1, 1, (STATES, count)), rng.uniform(-1, 1, (STATES, count))


def bars(theta: np.ndarray, rate: np.ndarray, change: np.ndarray) -> Bars:
    """Motion of a chain from its hinges: angles, rates and their derivatives."""
    found: list[tuple[np.ndarray, ...]] = []
    n = len(theta)
    p, zero = np.tile([1.0, 0, 0, 0], (n, 1)), np.zeros((n, 3))
    x = u = b = omega = alpha = zero
    for k in range(theta.shape[1]):
        if k:
            arm = rotated(p, np.tile(ALONG, (n, 1)))
            x, u, b = _carried(arm, (x, u, b), omega, alpha)
        hinge = rotated(p, np.tile(AXES[k % 2], (n, 1)))
        alpha = alpha + hinge * change[:, k : k + 1]
        alpha = alpha + np.cross(omega, hinge * rate[:, k : k + 1])
        omega = omega + hinge * rate[:, k : k + 1]
        half = theta[:, k : k + 1] / 2
        p = composed(p, np.hstack([np.cos(half), np.sin(half) * AXES[k % 2]]))
        arm = rotated(p, np.tile(CENTRE, (n, 1)))
        back = p * [1, -1, -1, -1]
        centre = _carried(arm, (x, u, b), omega, alpha)
        found.append((*centre, p, rotated(back, omega), rotated(back, alpha)))
    return Bars(*(np.stack(arrays, axis=1) for arrays in zip(*found, strict=True)))


def _carried(
    arm: np.ndarray, point: tuple[np.ndarray, ...], omega: np.ndarray, alpha: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, velocity and acceleration at the end of an arm from a point."""
    x, u, b = point
    swept = np.cross(omega, arm)
    return x + arm, u + swept, b + np.cross(alpha, arm) + np.cross(omega, swept)


def dense(theta: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """θ̈ of one state by d'Alembert's principle with dense matrices: no constraints."""
    count = len(theta)
    states = np.tile(theta, (count + 1, 1)), np.tile(rate, (count + 1, 1))
    moved = bars(*states, np.vstack([np.zeros(count), np.eye(count)]))
    reach, turn = moved.a[1:] - moved.a[0], moved.alpha_b[1:] - moved.alpha_b[0]
    omega = moved.omega_b[0]
    force = MASS * (GRAVITY - moved.a[0])
    torque = -MOMENTS * moved.alpha_b[0] - np.cross(omega, MOMENTS * omega)
    mass = MASS * np.einsum("ikc,jkc->ij", reach, reach)
    mass += np.einsum("ikc,c,jkc->ij", turn, MOMENTS, turn)
    right = np.einsum("ikc,kc->i", reach, force) + np.einsum("ikc,kc->i", turn, torque)
    return np.linalg.solve(mass, right)


def recursive(theta: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Accelerations θ̈ of all states by Featherstone's recursion: articulated inertias, in each bar.

    Motions are (turning, shifting at the hinge), forces (moment about the hinge, force).
    """
    states, count = theta.shape
    spatial = _inertia_at_the_hinge()
    ups, biases, pushes = [], [], []
    motion = np.zeros((states, 6))
    for k in range(count):
        axis = np.append(AXES[k % 2], np.zeros(3))
        ups.append(_from_bar_before(theta[:, k], AXES[k % 2], ALONG * bool(k)))
        joint = rate[:, k : k + 1] * axis
        motion = np.einsum("sij,sj->si", ups[-1], motion) + joint
        biases.append(np.einsum("sij,sj->si", _swept(motion), joint))
        pushes.append(-np.einsum("sji,sj->si", _swept(motion), motion @ spatial))
    inertia, push = np.zeros((states, 6, 6)), np.zeros((states, 6))
    solved: list[tuple[np.ndarray, ...]] = []
    for k in reversed(range(count)):
        inertia, push, part = inertia + spatial, push + pushes[k], AXES[k % 2].argmax()
        column, pivot = inertia[:, :, part], inertia[:, part, part]
        solved.append((column / pivot[:, None], -push[:, part] / pivot))
        along, right = solved[-1]
        inertia = inertia - column[:, :, None] * along[:, None, :]
        push = push + np.einsum("sij,sj->si", inertia, biases[k]) + column * right[:, None]
        inertia = np.einsum("sji,sjk,skl->sil", ups[k], inertia, ups[k])
        push = np.einsum("sji,sj->si", ups[k], push)
    change = np.zeros_like(theta)
    motion = np.tile(np.append(np.zeros(3), -GRAVITY), (states, 1))
    for k, (along, right) in enumerate(reversed(solved)):
        motion = np.einsum("sij,sj->si", ups[k], motion) + biases[k]
        change[:, k] = right - np.einsum("si,si->s", along, motion)
        motion[:, AXES[k % 2].argmax()] += change[:, k]
    return change


def _crossed(vector: np.ndarray) -> np.ndarray:
    """Matrices that multiply as the vectors do crosswise."""
    return np.cross(vector[..., None, :], np.eye(3)).swapaxes(-1, -2)


def _swept(motion: np.ndarray) -> np.ndarray:
    """Matrices of the product of motions; their transpose, negative, is for forces."""
    found = np.zeros((len(motion), 6, 6))
    found[:, :3, :3] = found[:, 3:, 3:] = _crossed(motion[:, :3])
    found[:, 3:, :3] = _crossed(motion[:, 3:])
    return found


def _from_bar_before(theta: np.ndarray, axis: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Matrices that take motions at the hinge before to those at this one."""
    half = theta[:, None] / 2
    turn = np.hstack([np.cos(half), -np.sin(half) * axis])
    matrix = np.stack([rotated(turn, np.tile(e, (len(theta), 1))) for e in np.eye(3)], axis=2)
    found = np.zeros((len(theta), 6, 6))
    found[:, :3, :3] = found[:, 3:, 3:] = matrix
    found[:, 3:, :3] = -matrix @ _crossed(arm)
    return found


def _inertia_at_the_hinge() -> np.ndarray:
    """Inertia of a bar, (6, 6)."""
    arm, found = _crossed(CENTRE), np.zeros((6, 6))
    found[:3, :3] = np.diag(MOMENTS) - MASS * arm @ arm
    found[:3, 3:], found[3:, :3] = MASS * arm, -MASS * arm
    found[3:, 3:] = MASS * np.eye(3)
    return found


def reference(count: int) -> tuple[np.ndarray, np.ndarray]:
    """v̇ of the centres and ω̇′ by the dense matrices."""
    theta, rate = joint_states(count)
    change = np.array([dense(*state) for state in zip(theta, rate, strict=True)])
    found = bars(theta, rate, change)
    return found.a, found.alpha_b


def difference(got: tuple[np.ndarray, np.ndarray], wanted: tuple[np.ndarray, np.ndarray]) -> float:
    """Largest difference, relative to the largest number."""
    pairs = list(zip(got, wanted, strict=True))
    return max(float(np.abs(a - b).max() / np.abs(b).max()) for a, b in pairs)


def kousoku_accelerations(count: int, folder: Path) -> Accelerations:
    """Generate the solver of a chain, and a loop over the two segments that accelerations take."""
    files = generate_dynamics(chain(count))
    write_tree(folder, files | {"driver.c": _DRIVER})
    library = folder / f"chain_{count}.so"
    command = find_toolchain().compile_command([str(folder / "driver.c")], str(library))
    subprocess.run(command, check=True)
    exported = ctypes.CDLL(str(library))
    solver = load_dynamics(folder)
    theta, rate = joint_states(count)
    q, v = _coordinates(solver.bodies, bars(theta, rate, np.zeros_like(theta)), solver.q, solver.v)
    v_dot = np.zeros_like(v)
    size = exported[f"kousoku_{solver.name}_work_size"]
    size.restype = ctypes.c_size_t
    work = np.zeros(size())

    def run(rounds: int) -> None:
        arrays = [ctypes.c_void_p(array.ctypes.data) for array in (q, v, v_dot, work)]
        exported.loop(ctypes.c_size_t(rounds), ctypes.c_size_t(STATES), *arrays)

    return Accelerations("kousoku", run, lambda: _accelerations(solver.bodies, v_dot))


def _coordinates(
    bodies: Any, motion: Bars, q_start: np.ndarray, v_start: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates q and v of all states: centres and principal frames."""
    q, v = np.tile(q_start, (STATES, 1)), np.tile(v_start, (STATES, 1))
    for k, body in enumerate(bodies):
        axes = np.tile(body.axes_b, (STATES, 1))
        q[:, list(body.r)] = motion.r[:, k]
        q[:, list(body.p)] = composed(motion.p[:, k], axes * [1, -1, -1, -1])
        v[:, list(body.v)] = motion.v[:, k]
        v[:, list(body.omega_b)] = rotated(axes, motion.omega_b[:, k])
    return q, v


def _accelerations(bodies: Any, v_dot: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    linear, angular = [], []
    for body in bodies:
        back = np.tile(body.axes_b, (STATES, 1)) * [1, -1, -1, -1]
        linear.append(v_dot[:, list(body.v)])
        angular.append(rotated(back, v_dot[:, list(body.omega_b)]))
    return np.stack(linear, axis=1), np.stack(angular, axis=1)
