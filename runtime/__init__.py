"""Load, verify and run generated code; needs NumPy only.

A kernel is opened by ``library`` and called by ``kernel``, ``arguments``, ``targets``, ``lanes``,
``plan`` and ``batch_numpy``; compiled by ``toolchain``, ``build`` and ``lock``.

A solver is opened by ``solver``: ``dynamics`` of bodies, with ``dynamics_targets``, and ``linkage``
of nodes; by ``sources``, ``importing`` and ``choice``, with parameters by ``design``. It is run by
``run``, with ``options``, ``saved`` and ``run_stop``; the ledger of a run is ``run_ledger``, with
``momenta`` and ``error_estimate``.

What is checked is told by ``report``: of kernels by ``verify``, with ``reference`` and
``evaluate``; of solvers by ``solver_verify``, ``dynamics_verify``, ``independent_verify``,
``function_bounds``, ``order`` and ``linkage_verify``. What users are told is put into words by
``messages``, and once by ``notice``.

Two folders travel along with generated solvers: ``integrate`` and ``kinematics``.
"""

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
