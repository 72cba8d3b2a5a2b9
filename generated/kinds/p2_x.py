"""p2_x: the kernels of p2 with the rows that hold a′_x, under the names of any constraint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import p2

if TYPE_CHECKING:
    from .p2.kernels import constraint_x as constraint
    from .p2.kernels import rates_x as rates
    from .p2.kernels import reaction_x as reaction

__all__ = ["constraint", "rates", "reaction"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = function = getattr(p2, f"{name}_x")
    return function
