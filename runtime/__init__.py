"""Load, verify and run generated code; needs NumPy only."""

from kousoku.runtime.kernel import BoundKernel, Kernel
from kousoku.runtime.lanes import from_lanes, to_lanes
from kousoku.runtime.library import Library, load
from kousoku.runtime.report import Report, Row
from kousoku.runtime.verify import verify

__all__ = [
    "BoundKernel",
    "Kernel",
    "Library",
    "Report",
    "Row",
    "from_lanes",
    "load",
    "to_lanes",
    "verify",
]
