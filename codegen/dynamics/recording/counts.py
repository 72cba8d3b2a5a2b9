"""Costs of a program: tasks and operations, by segment and kind of task."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from kousoku.codegen.dynamics.recording.program import Program


@dataclass(frozen=True, slots=True)
class TaskCount:
    """Tasks of one kind in one segment.

    Parameters
    ----------
    segment, title : str
        The segment, and the title of the tasks.
    kernels : int
        How many different kernels they call.
    tasks : int
        How many tasks there are.
    operations : int
        Scalar operations of all of them together.
    """

    segment: str
    title: str
    kernels: int
    tasks: int
    operations: int


def counts(program: Program) -> tuple[TaskCount, ...]:
    """Costs in the order of the program; divide by its bodies for the cost of a body."""
    costs = [kernel.operations.total() for kernel in program.kernels]
    task_counts = []
    for segment in program.segments:
        kernels: dict[str, list[int]] = {}
        for task in segment.tasks:
            kernels.setdefault(program.kernels[task.kernel].title, []).append(task.kernel)
        task_counts += [
            TaskCount(segment.name, title, len(set(used)), len(used), sum(costs[k] for k in used))
            for title, used in kernels.items()
        ]
    return tuple(task_counts)


def operations(program: Program) -> int:
    """Number of operations that it takes to run all segments once."""
    return sum(count.operations for count in counts(program))
