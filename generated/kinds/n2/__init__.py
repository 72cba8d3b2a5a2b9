"""n2: n2, vector perpendicular to the line between two points (dot-2, INPLANE).

Compiled where ``kousoku.runtime`` and a C compiler are there, else NumPy; decided at first use.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .kernels import constraint as constraint
    from .kernels import rates as rates
    from .kernels import reaction as reaction

__all__ = ["constraint", "rates", "reaction"]


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
