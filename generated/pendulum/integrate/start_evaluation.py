"""Evaluation of a scene at time 0, as compiled solvers and those in NumPy make it for starts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import TypeAlias

    from .arithmetic import Array

    #: What a scene computes at q and v, time 0, by the names of ``places`` of ``motion.json``.
    Evaluate: TypeAlias = Callable[[Array, Array], Mapping[str, Array]]


#: What scenes may lack.
ABSENT_REGIONS = {"coordinates": (0, 0)}


def evaluated(
    call: Callable[[float, Array, Array, Array, Array], object],
    parameters: Array,
    work_size: int,
    places: Mapping[str, Sequence[int]],
) -> Evaluate:
    """Evaluation of a scene at time 0 of q (nq,) and v (nv,), in SI units.

    Parameters
    ----------
    call : callable
        ``evaluate`` of a solver: time, q, v, parameters, and the memory for work.
    parameters : (n,) array
        Those of the run.
    work_size : int
        How many numbers that memory has.
    places : mapping of str to (int, int)
        Where what is computed is in it, and how many numbers.
    """

    def evaluate(q: Array, v: Array) -> Mapping[str, Array]:
        work = np.zeros(work_size)
        call(0.0, np.ascontiguousarray(q), np.ascontiguousarray(v), parameters, work)
        return {name: work[at : at + n] for name, (at, n) in {**ABSENT_REGIONS, **places}.items()}

    return evaluate


def rates_of_rows(evaluate: Evaluate, q: Array, sizes: Array) -> Array:
    """Jacobian C_q (nv, n) of all n constraints, a row for each velocity, times its size.

    It is transposed: C_q times each of ``sizes`` (nv,) [m, 1], at q (nq,), in m or rad.
    """
    still = evaluate(q, np.zeros(len(sizes)))["C_dot"]
    return np.array([evaluate(q, u)["C_dot"] - still for u in np.diag(sizes)])
