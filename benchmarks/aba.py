"""Accelerations of the chains by peers: Pinocchio in a loop in C++ or from Python, and MuJoCo."""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.chains import (
    ALONG,
    AXES,
    CENTRE,
    GRAVITY,
    MASS,
    MOMENTS,
    STATES,
    Accelerations,
    bars,
    joint_states,
)
from benchmarks.kit import MissingError, required
from benchmarks.loops import cpp_compiler, eigen
from kousoku.runtime.toolchain import find_toolchain

if TYPE_CHECKING:
    from collections.abc import Callable

#: Pinocchio's own flags; its list of joints is longer than Boost's prepared headers.
_FLAGS = (
    *("-std=c++17", "-O3", "-march=native", "-DNDEBUG", "-shared", "-fPIC"),
    *("-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS"),
)


def build_loop(folder: Path) -> Path:
    """Compile the loop with the headers that come with Pinocchio's package; it takes a minute.

    Raises
    ------
    MissingError
        Pinocchio, Eigen or a C++ compiler is not there.
    """
    prefix = Path(required("pinocchio").__file__).parents[4]
    library = folder / "pinocchio_loop.so"
    source = Path(__file__).with_name("pinocchio_loop.cpp")
    command = [*cpp_compiler(find_toolchain().command), *_FLAGS]
    command += [f"-I{prefix / 'include'}", f"-isystem{eigen()}", "-o", str(library), str(source)]
    command += [f"-L{prefix / 'lib'}", "-lpinocchio_default", f"-Wl,-rpath,{prefix / 'lib'}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise MissingError(f"{source.name} does not compile:\n{done.stderr[-2000:]}")
    return library


def looped(count: int, library: Path) -> Accelerations:
    """Return Pinocchio's accelerations through the loop."""
    exported = ctypes.CDLL(str(library))
    exported.chain_new.restype = ctypes.c_void_p
    numbers = [CENTRE, MOMENTS, GRAVITY]
    chain = ctypes.c_void_p(
        exported.chain_new(
            ctypes.c_size_t(count), ctypes.c_double(MASS), *(_address(x) for x in numbers)
        )
    )
    theta, rate = joint_states(count)
    change = np.zeros_like(theta)

    def run(rounds: int) -> None:
        exported.chain_loop(
            chain,
            ctypes.c_size_t(rounds),
            ctypes.c_size_t(STATES),
            *(_address(x) for x in (theta, rate, change)),
        )

    return Accelerations("Pinocchio, C++ loop", run, _of_bodies(theta, rate, change))


def model_of(count: int) -> Any:
    """Return a chain as Pinocchio's model, built joint by joint."""
    pinocchio = required("pinocchio")
    model: Any = pinocchio.Model()
    model.gravity.linear = GRAVITY
    parent = 0
    for k in range(count):
        place = pinocchio.SE3.Identity()
        place.translation = ALONG * bool(k)
        joint = pinocchio.JointModelRZ() if k % 2 else pinocchio.JointModelRY()
        parent = model.addJoint(parent, joint, place, f"joint_{k}")
        bar = pinocchio.Inertia(MASS, CENTRE, np.diag(MOMENTS))
        model.appendBodyToJoint(parent, bar, pinocchio.SE3.Identity())
    return model


def called(count: int) -> Accelerations:
    """Return Pinocchio's accelerations, each through a call from Python."""
    pinocchio, model = required("pinocchio"), model_of(count)
    data, torque = model.createData(), np.zeros(count)
    theta, rate = joint_states(count)
    change = np.zeros_like(theta)

    def run(rounds: int) -> None:
        aba = pinocchio.aba
        for _ in range(rounds):
            for k in range(STATES):
                change[k] = aba(model, data, theta[k], rate[k], torque)

    return Accelerations("Pinocchio, from Python", run, _of_bodies(theta, rate, change))


def mujoco_model(count: int) -> Any:
    """Return a chain as MuJoCo's model, body by body: XML may not be nested so deeply."""
    mujoco = required("mujoco")
    spec = mujoco.MjSpec()
    spec.option.gravity = GRAVITY
    spec.memory = 1 << 30
    body = spec.worldbody
    for k in range(count):
        body = body.add_body(pos=ALONG * bool(k), mass=MASS, ipos=CENTRE, inertia=MOMENTS)
        body.explicitinertial = True
        body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=AXES[k % 2])
    return spec.compile()


def forward(count: int) -> Accelerations:
    """Return MuJoCo's accelerations, each through a call from Python."""
    mujoco, model = required("mujoco"), mujoco_model(count)
    data = mujoco.MjData(model)
    theta, rate = joint_states(count)
    change = np.zeros_like(theta)

    def run(rounds: int) -> None:
        for _ in range(rounds):
            for k in range(STATES):
                data.qpos[:], data.qvel[:] = theta[k], rate[k]
                mujoco.mj_forward(model, data)
                change[k] = data.qacc

    return Accelerations("MuJoCo, from Python", run, _of_bodies(theta, rate, change))


def _of_bodies(
    theta: np.ndarray, rate: np.ndarray, change: np.ndarray
) -> Callable[[], tuple[np.ndarray, np.ndarray]]:
    def results() -> tuple[np.ndarray, np.ndarray]:
        found = bars(theta, rate, change)
        return found.a, found.alpha_b

    return results


def _address(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
