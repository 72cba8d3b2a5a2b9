"""p1_z: the kernels of p1 with the rows that hold a′_z, under the names of any constraint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import p1

if TYPE_CHECKING:
    from .p1.kernels import constraint_z as constraint
    from .p1.kernels import rates_z as rates
    from .p1.kernels import reaction_z as reaction

__all__ = ["constraint", "rates", "reaction"]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = function = getattr(p1, f"{name}_z")
    return function
