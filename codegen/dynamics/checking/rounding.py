"""Unit of error of solvers: how far rounding can move the results of a program.

The unit of a result y is u Σ |z ∂y/∂z| with u = 2⁻⁵³, over all numbers z that the program takes or
computes. To first order, no rounding of these numbers moves y by more. Near states with dependent
rows it grows, because the derivatives do.

The derivatives are computed backward from the results, operation by operation, for many results at
once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kousoku.model.operations.arithmetic import FLOAT
from kousoku.model.operations.differentials import slopes_of
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
    from kousoku.codegen.dynamics.recording.program import Task
    from kousoku.model.numbers.real import Array
    from kousoku.model.operations.graph import OperationNode
    from kousoku.model.operations.kernel import Kernel

#: u, the rounding of a double.
UNIT_ROUNDOFF = 2.0**-53
#: Count of results whose adjoints are computed together.
SLOTS_AT_ONCE = 512
#: Operations that libraries round to within two units or so.
FUNCTIONS = frozenset({Op.SIN, Op.COS, Op.ATAN2, Op.EXP, Op.LOG})
#: Operations that are not rounded.
UNROUNDED = frozenset({Op.NEG, Op.ABS, Op.MAX, Op.INPUT})


@dataclass(frozen=True, slots=True)
class ExecutedTask:
    """Task that was run.

    Parameters
    ----------
    task : Task
        The task.
    values : list of float
        Values of all nodes of its kernel.
    """

    task: Task
    values: list[float]


def run_and_keep(workspace: ProgramInterpreter, segments: Sequence[str]) -> list[ExecutedTask]:
    """Run segments as :meth:`ProgramInterpreter.run` does, and keep the values of all nodes."""
    tasks = [task for name in segments for task in workspace.program.segment(name).tasks]
    return [ExecutedTask(task, list(map(float, workspace.execute(task)))) for task in tasks]


def units(
    workspace: ProgramInterpreter, steps: Sequence[ExecutedTask], slots: Sequence[int]
) -> list[float]:
    """Units of error u Σ |z ∂y/∂z| of some slots y, u = 2⁻⁵³, each in the unit of its slot.

    Parameters
    ----------
    workspace : ProgramInterpreter
        Workspace in which the steps were run. No slot was written twice.
    steps : sequence of ExecutedTask
        Tasks and values, as :func:`run_and_keep` returned them.
    slots : sequence of int
        The results.
    """
    sizes: list[float] = []
    for first in range(0, len(slots), SLOTS_AT_ONCE):
        sizes += _batch_units(workspace, steps, slots[first : first + SLOTS_AT_ONCE])
    return sizes


def _batch_units(
    workspace: ProgramInterpreter, steps: Sequence[ExecutedTask], slots: Sequence[int]
) -> list[float]:
    adjoints: dict[int, Array] = {}
    for k, slot in enumerate(slots):
        adjoints.setdefault(slot, np.zeros(len(slots)))[k] = 1.0
    total = np.zeros(len(slots))
    with np.errstate(all="ignore"):  # where a result is not finite its unit is not either
        for step in reversed(steps):
            _propagate(workspace.program.kernels[step.task.kernel], step, adjoints, total)
        for slot, adjoint in adjoints.items():
            total += np.abs(adjoint) * abs(float(workspace.values[slot]))
    return [float(x) for x in UNIT_ROUNDOFF * total]


def _propagate(
    kernel: Kernel, step: ExecutedTask, adjoints: dict[int, Array], total: Array
) -> None:
    """Bring adjoints from the outputs of a task to its inputs, and count its roundings."""
    node_adjoints: dict[int, Array] = {}
    for base, result in zip(step.task.outputs, kernel.results, strict=True):
        for k, node in enumerate(result):
            if (adjoint := adjoints.pop(base + k, None)) is not None:
                _accumulate(node_adjoints, node, adjoint)
    bases = dict(zip((q.name for q in kernel.inputs), step.task.inputs, strict=True))
    for node in reversed(range(len(kernel.nodes))):
        adjoint = node_adjoints.pop(node, None)
        if adjoint is None:
            continue
        operation, value = kernel.nodes[node], step.values[node]
        if operation.symbol is not None:
            name, offset = operation.symbol
            _accumulate(adjoints, bases[name] + offset, adjoint)
        elif value and (weight := _roundings(operation)):
            total += np.abs(adjoint) * (weight * abs(value))
        partials = _partials(operation, value, step.values)
        for arg, factor in zip(operation.args, partials, strict=True):
            if factor:
                _accumulate(node_adjoints, arg, adjoint * factor)


def _accumulate(table: dict[int, Array], index: int, adjoint: Array) -> None:
    present = table.get(index)
    table[index] = adjoint if present is None else present + adjoint


def _roundings(node: OperationNode[int]) -> int:
    """Number of roundings that a node costs."""
    if node.op is Op.CONST:
        return int(node.value is not None and float(node.value) != node.value)
    if node.op in UNROUNDED:
        return 0
    return 2 if node.op in FUNCTIONS else 1


def _partials(node: OperationNode[int], value: float, values: Sequence[float]) -> tuple[float, ...]:
    """Partial derivatives of a node, by each of its arguments."""
    if not node.args:
        return ()
    return slopes_of(node.op, value, [values[arg] for arg in node.args], FLOAT)
