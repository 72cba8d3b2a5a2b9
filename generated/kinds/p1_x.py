"""p1_x: the kernels of p1 with the rows that hold a′_x, under the names of any constraint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import p1

if TYPE_CHECKING:
    from .p1.kernels import constraint_x as constraint
    from .p1.kernels import rates_x as rates
    from .p1.kernels import reaction_x as reaction

__all__ = ["constraint", "rates", "reaction"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = function = getattr(p1, f"{name}_x")
    return function
