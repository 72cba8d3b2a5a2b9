"""p1: p1, two vectors parallel (parallel-1, PARALLEL AXES).

Compiled where ``kousoku.runtime`` and a C compiler are there, else NumPy; decided at first use.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .kernels import constraint_x as constraint_x
    from .kernels import constraint_y as constraint_y
    from .kernels import constraint_z as constraint_z
    from .kernels import rates_x as rates_x
    from .kernels import rates_y as rates_y
    from .kernels import rates_z as rates_z
    from .kernels import reaction_x as reaction_x
    from .kernels import reaction_y as reaction_y
    from .kernels import reaction_z as reaction_z

__all__ = [
    "constraint_x",
    "constraint_y",
    "constraint_z",
    "rates_x",
    "rates_y",
    "rates_z",
    "reaction_x",
    "reaction_y",
    "reaction_z",
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
