"""Trace of a pass: the record that ``kousoku explain`` prints; nothing of it is emitted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.model.operations.kernel import Kernel

BYTES_OF_A_DOUBLE = 8


@dataclass(frozen=True, slots=True)
class PassRecord:
    """One pass over one kernel.

    Parameters
    ----------
    name : str
        The verb of the pass.
    operations_before, operations_after : int
        All operations but constants and inputs.
    bytes_after : int
        The largest number of intermediate results that are alive at once, times eight.
    """

    name: str
    operations_before: int
    operations_after: int
    bytes_after: int


PassTrace = tuple[PassRecord, ...]


def run_passes(
    kernel: Kernel, passes: Sequence[Callable[[Kernel], Kernel]]
) -> tuple[Kernel, PassTrace]:
    """Apply passes one after the other, and record the savings of each."""
    records = []
    for apply_pass in passes:
        result = apply_pass(kernel)
        records.append(
            PassRecord(
                name=apply_pass.__name__,
                operations_before=kernel.operations.total(),
                operations_after=result.operations.total(),
                bytes_after=BYTES_OF_A_DOUBLE * most_alive(result),
            )
        )
        kernel = result
    return kernel, tuple(records)


def without_sharing(kernel: Kernel) -> int:
    """Count of operations if every use of a value computed it again."""
    sizes: list[int] = []
    for node in kernel.nodes:
        sizes.append(sum(sizes[arg] for arg in node.args) + (1 if node.args else 0))
    return sum(sizes[node] for result in kernel.results for node in result)


def most_alive(kernel: Kernel) -> int:
    """Largest number of intermediate results that are alive at once.

    A result is alive from where it is computed to its last use; one that is an output goes to
    memory at once. Inputs and constants are in memory.
    """
    last_use = {arg: k for k, node in enumerate(kernel.nodes) for arg in node.args}
    ends = dict.fromkeys(range(len(kernel.nodes)), 0)
    alive = most = 0
    for k, node in enumerate(kernel.nodes):
        if node.args:
            if last_use.get(k, k) > k:
                alive += 1
                ends[last_use[k]] += 1
            most = max(most, alive)
        alive -= ends[k]
    return most
