"""rotation: rotation by Euler parameters.

Compiled where ``kousoku.runtime`` and a C compiler are there, else NumPy; decided at first use.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .kernels import orientation as orientation
    from .kernels import virtual_rotation as virtual_rotation
    from .kernels import point as point
    from .kernels import virtual_displacement as virtual_displacement
    from .kernels import orientation_rate as orientation_rate
    from .kernels import angular_velocity as angular_velocity
    from .kernels import euler_rates as euler_rates
    from .kernels import update as update

__all__ = [
    "orientation",
    "virtual_rotation",
    "point",
    "virtual_displacement",
    "orientation_rate",
    "angular_velocity",
    "euler_rates",
    "update",
]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = function = getattr(_library(), name)
    return function


def _library() -> Any:
    """Compiled kernels, or the module of the NumPy ones."""
    try:
        runtime = import_module("kousoku.runtime")
    except ModuleNotFoundError:
        return import_module(".kernels", __name__)
    return runtime.load(Path(__file__).parent)
