"""A kernel: one function of named arrays, as a frozen graph."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.model.operations.graph import EXACT_OPS, Op, OperationNode

if TYPE_CHECKING:
    from kousoku.model.files.quantity import Quantity


@dataclass(frozen=True, slots=True)
class Kernel:
    """Named arrays in, named arrays out, and the scalar operations between them.

    Parameters
    ----------
    name : str
        The kernel's name inside its package, e.g. ``constraint``.
    title : str
        What it computes, in one line.
    formula : str
        The defining equation as plain text.
    source : str
        Where the equation stands, e.g. ``lecture 8.2, (8.16)``.
    inputs, outputs : tuple of Quantity
        In the order of the arguments.
    nodes : tuple of OperationNode
        In topological order.
    results : tuple of tuple of int
        For each output the node ids of its elements, row-major.
    names : tuple of (int, str)
        Names of intermediate nodes that mean something, e.g. ``A_i_11``.
    """

    name: str
    title: str
    formula: str
    source: str
    inputs: tuple[Quantity, ...]
    outputs: tuple[Quantity, ...]
    nodes: tuple[OperationNode[int], ...]
    results: tuple[tuple[int, ...], ...]
    names: tuple[tuple[int, str], ...] = ()

    @property
    def operations(self) -> Counter[Op]:
        """Count of each operation that runs, constants and inputs left out."""
        counts = Counter(node.op for node in self.nodes)
        del counts[Op.CONST], counts[Op.INPUT]
        return counts

    @property
    def is_exact(self) -> bool:
        """Whether IEEE 754 fixes every bit of the result."""
        return all(op in EXACT_OPS for op in self.operations)

    def nonzero(self, output: int) -> tuple[int, ...]:
        """Flat indices of an output's elements that are not identically zero."""
        return tuple(
            k for k, node in enumerate(self.results[output]) if self.nodes[node].value != 0
        )


@dataclass(frozen=True, slots=True)
class Package:
    """Kernels that are emitted together, into one folder under ``generated/``.

    Parameters
    ----------
    name : str
        Folder and C prefix, an identifier such as ``p2_z``.
    title : str
        Subject of the kernels, in one line.
    regenerate : str
        The command that makes the folder again.
    kernels : tuple of Kernel
        In the order of the text.
    choices : tuple of str
        Of a kind with several choices of its rows: endings of the names of its kernels, such as
        ``x`` of ``constraint_x``; they have the same arguments, and share what they compute alike.
    """

    name: str
    title: str
    regenerate: str
    kernels: tuple[Kernel, ...]
    choices: tuple[str, ...] = ()

    @property
    def families(self) -> tuple[tuple[Kernel, ...], ...]:
        """The kernels, those that differ in the choice of rows only together."""
        if not self.choices:
            return tuple((kernel,) for kernel in self.kernels)
        count = len(self.kernels) // len(self.choices)
        return tuple(self.kernels[k::count] for k in range(count))
