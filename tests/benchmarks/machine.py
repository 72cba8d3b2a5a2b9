"""The machine that measures, and all programs with their versions."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version

from kousoku.model.errors import KousokuError
from kousoku.runtime.toolchain import find_toolchain
from tests.stress.workers import processor

PROGRAMS = (
    *("kousoku", "numpy", "scipy", "sympy", "casadi", "heyoka", "exudyn", "mujoco", "pin"),
    "symforce",
)


def compiler() -> str:
    """C compiler with its version and the flags that ship."""
    try:
        found = find_toolchain()
    except KousokuError as error:
        return f"none: {error}"
    return f"{found.name} {' '.join(found.flags)}"


def versions() -> dict[str, str]:
    """Versions of what is installed."""
    found = {}
    for name in PROGRAMS:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def machine() -> dict[str, str]:
    """Machine and what runs there, by name."""
    programs = ", ".join(f"{name} {number}" for name, number in versions().items())
    return {
        "processor": f"{processor()}, {os.cpu_count()} processors",
        "system": f"{platform.system()} {platform.release()}",
        "compiler": compiler(),
        "Python": platform.python_version(),
        "programs": programs,
    }
