"""Accelerations of the chains by peers: Pinocchio in a loop in C++ or from Python, and MuJoCo."""

from __future__ import annotations

import ctypes
import hashlib
import subprocess
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.files.cache import cache_folder
from kousoku.runtime.toolchain import find_toolchain
from tests.benchmarks.chains import (
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
from tests.benchmarks.kit import PeerMissingError, required
from tests.benchmarks.loops import cpp_compiler, eigen, started

if TYPE_CHECKING:
    from collections.abc import Callable

SOURCE = Path(__file__).with_name("pinocchio_loop.cpp")
#: The longest time of its compiler [s].
PATIENCE = 240.0
#: Pinocchio's own flags; its list of joints is longer than Boost's prepared headers.
_FLAGS = (
    *("-std=c++17", "-O3", "-march=native", "-DNDEBUG", "-shared", "-fPIC"),
    *("-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS"),
)


def loop_library() -> Path:
    """Folder that the loop is compiled to: another one for another Pinocchio or compiler.

    Raises
    ------
    PeerMissingError
        Pinocchio, Eigen or a C++ compiler is not there.
    """
    found = hashlib.sha256(SOURCE.read_bytes())
    found.update(repr((_command(), version("pin"))).encode())
    return cache_folder() / "bench" / found.hexdigest()[:32] / "pinocchio_loop.so"


def _command() -> list[str]:
    """Compiler with its flags."""
    prefix = Path(required("pinocchio").__file__).parents[4]
    command = [*cpp_compiler(find_toolchain().command), *_FLAGS]
    command += [f"-I{prefix / 'include'}", f"-isystem{eigen()}", str(SOURCE)]
    return [*command, f"-L{prefix / 'lib'}", "-lpinocchio_default", f"-Wl,-rpath,{prefix / 'lib'}"]


def build_loop() -> None:
    """Compile the loop with the headers that come with Pinocchio's package; it takes a minute.

    Raises
    ------
    PeerMissingError
        What it needs is not there, or it does not compile in time.
    """
    library = loop_library()
    if library.exists():
        return
    library.parent.mkdir(parents=True, exist_ok=True)
    begun = library.with_suffix(".begun")
    with started([*_command(), "-o", str(begun)]) as process:
        try:
            _, said = process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            raise PeerMissingError(f"{SOURCE.name} compiles for more than {PATIENCE:g} s") from None
    if process.returncode:
        raise PeerMissingError(f"{SOURCE.name} does not compile: {said[-500:]}")
    begun.rename(library)


def looped(count: int) -> Accelerations:
    """Pinocchio's accelerations through the loop.

    Raises
    ------
    PeerMissingError
        It was not compiled.
    """
    library = loop_library()
    if not library.exists():
        raise PeerMissingError(f"{SOURCE.name} was not compiled")
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
    """Chain as Pinocchio's model, built joint by joint."""
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
    """Pinocchio's accelerations, each through a call from Python."""
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
    """Chain as MuJoCo's model, body by body: XML may not be nested so deeply."""
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
    """MuJoCo's accelerations, each through a call from Python."""
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
