"""One operation while it is traced, and the kernel that its trace becomes."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.matrix import Matrix
from kousoku.codegen.passes.rebuild import copy_node, substitute
from kousoku.model.files.quantity import Quantity
from kousoku.model.numbers.real import SMALLEST_SUBNORMAL
from kousoku.model.operations.graph import Graph, Op, OperationNode
from kousoku.model.operations.kernel import Kernel

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    #: Kind and code of each entry of a result: ``number`` with 0 or ±1, ``leaf`` and ``fresh`` slot
    #: with ±(index + 1). And the shape of the result.
    Codes = tuple[tuple[tuple[str, int], ...], int, int]


#: Number that a kernel adds to a divisor that may be zero: its inverse is infinite, and 0 · ∞ no
#: number.
ADDED = Fraction(SMALLEST_SUBNORMAL)
#: Number that is added here, where factors are taken out: its inverse is finite, and it changes no
#: sum with a length above 10⁻²⁸⁵.
ADDED_HERE = Fraction(1, 2**1000)


def with_finite_quotients(kernel: Kernel) -> Kernel:
    """Kernel whose divisors have an inverse, also where they are zero."""
    added = {k for k, x in enumerate(kernel.nodes) if x.op is Op.CONST and x.value == ADDED}
    if not added:
        return kernel
    nodes = [
        OperationNode(x.op, value=ADDED_HERE) if k in added else x
        for k, x in enumerate(kernel.nodes)
    ]
    return replace(kernel, nodes=tuple(nodes))


class Trace:
    """The graph of one operation.

    Parameters
    ----------
    lengths : sequence of int
        Lengths of the runs that it reads; leaves are numbered run by run.
    """

    def __init__(self, lengths: Sequence[int]) -> None:
        self.graph = Graph()
        self.lengths = tuple(lengths)
        self._leaves = [
            self.graph.input(f"x{run}", place)
            for run, length in enumerate(lengths)
            for place in range(length)
        ]
        self.numbers = {node: place for place, node in enumerate(self._leaves)}
        self._known: dict[int, int] = {}

    def leaf(self, code: int) -> int:
        """Node of an entry: 0, ±1, or ±(leaf + 2)."""
        if -1 <= code <= 1:
            return self.graph.const(code)
        node = self._leaves[abs(code) - 2]
        return node if code > 0 else self.graph.neg(node)

    def matrix(self, codes: Sequence[int], height: int, width: int) -> Matrix:
        """Matrix of entries that are coded as in :meth:`leaf`."""
        nodes = [self.leaf(code) for code in codes]
        rows = tuple(tuple(nodes[k * width : (k + 1) * width]) for k in range(height))
        return Matrix(self.graph, rows, width)

    def inline(self, kernel: Kernel, inputs: Mapping[str, Sequence[int]]) -> dict[str, list[int]]:
        """Rebuild a frozen kernel here; return the nodes of its outputs, row by row."""
        return substitute(self.graph, with_finite_quotients(kernel), inputs)

    def is_known(self, nodes: Iterable[int], leaves: Iterable[int]) -> None:
        """State that ``nodes`` were computed before: they are read, not computed again."""
        for node, leaf in zip(nodes, leaves, strict=True):
            if self.graph.nodes[node].args and node != leaf:
                self._known[node] = leaf

    def rebuilt(self, results: Sequence[Matrix]) -> tuple[Graph, list[list[int]]]:
        """Graph of the nodes that ``results`` need beyond known ones, and their nodes in it."""
        graph = Graph()
        new: dict[int, int] = {}
        order = self._needed(node for result in results for node in result.flat)
        for node in order:
            known = self._known.get(node)
            if known is None:
                new[node] = copy_node(graph, self.graph.nodes[node], new)
            else:
                new[node] = new[known]
        return graph, [[new[node] for node in result.flat] for result in results]

    def _needed(self, roots: Iterable[int]) -> list[int]:
        """Nodes that are needed in an order in which they can be built: leaves first."""
        nodes = self.graph.nodes
        needed: dict[int, None] = {}
        stack = list(roots)
        while stack:
            node = stack.pop()
            if node in needed:
                continue
            needed[node] = None
            known = self._known.get(node)
            stack.extend(nodes[node].args if known is None else (known,))
        return sorted(needed, key=lambda node: (self._depth(nodes[node]), node))

    def _depth(self, node: OperationNode[int]) -> int:
        """Depth of a node: 0 of leaves, 1 of the negatives of leaves, 2 of all else."""
        if not node.args:
            return 0
        return 1 if node.op is Op.NEG and node.args[0] in self.numbers else 2


def traced_kernel(
    trace: Trace, title: str, results: Sequence[Matrix], pinned: Sequence[bool]
) -> tuple[Kernel, tuple[int, ...], int, tuple[Codes, ...]]:
    """Kernel of a trace.

    Parameters
    ----------
    trace : Trace
        The operation.
    title : str
        Title of its results.
    results : sequence of Matrix
        Its results.
    pinned : sequence of bool
        Which results are written in full, each to slots of its own; those beyond the last are not.

    Returns
    -------
    kernel : Kernel
        Its first output, if any, has the new entries of the results that are not pinned; then
        follow the results that are.
    used : tuple of int
        Indices of the runs that it reads: its inputs.
    fresh : int
        Count of slots of that first output.
    codes : tuple of Codes
        Codes of the entries of the results.
    """
    graph, nodes = trace.rebuilt(results)
    pins = [k < len(pinned) and pinned[k] for k in range(len(results))]
    sorter = _Sorter(graph, trace)
    codes = tuple(
        (
            tuple(("number", 0) if pin else sorter.code(node) for node in flat),
            len(result.rows),
            result.width,
        )
        for flat, result, pin in zip(nodes, results, pins, strict=True)
    )
    outputs = [tuple(sorter.fresh)] if sorter.fresh else []
    outputs += [tuple(flat) for flat, pin in zip(nodes, pins, strict=True) if pin and flat]
    kernel, used = _compact(graph, title, trace.lengths, outputs)
    return kernel, used, len(sorter.fresh), codes


class _Sorter:
    """Sort the entries of results into numbers, copies, and new nodes."""

    def __init__(self, graph: Graph, trace: Trace) -> None:
        self.graph = graph
        self.fresh: dict[int, int] = {}
        self._leaves: dict[tuple[str, int], int] = {}
        for run, length in enumerate(trace.lengths):
            for place in range(length):
                self._leaves[f"x{run}", place] = len(self._leaves)

    def code(self, node: int) -> tuple[str, int]:
        entry = self.graph.nodes[node]
        if entry.value is not None and abs(entry.value) <= 1 and entry.value.denominator == 1:
            return "number", int(entry.value)
        if entry.symbol is not None:
            return "leaf", self._leaves[entry.symbol] + 1
        if entry.op is Op.NEG:
            kind, place = self.code(entry.args[0])
            return kind, -place
        if entry.op is Op.SUB:
            turned = self.graph.sub(entry.args[1], entry.args[0])
            if turned in self.fresh:
                return "fresh", -self.fresh[turned] - 1
        place = self.fresh.setdefault(node, len(self.fresh))
        return "fresh", place + 1


def _compact(
    graph: Graph, title: str, lengths: Sequence[int], outputs: Sequence[Sequence[int]]
) -> tuple[Kernel, tuple[int, ...]]:
    """Kernel of the nodes that ``outputs`` need, without name, and the runs that it reads."""
    order = _in_order(graph, outputs)
    symbols = [graph.nodes[node].symbol for node in order]
    runs_read = {name for name, _ in filter(None, symbols)}
    used = tuple(k for k in range(len(lengths)) if f"x{k}" in runs_read)
    renamed = {f"x{k}": f"x{number}" for number, k in enumerate(used)}
    kept = Graph()
    ids: dict[int, int] = {}
    for node, symbol in zip(order, symbols, strict=True):
        if symbol is None:
            ids[node] = copy_node(kept, graph.nodes[node], ids)
        else:
            ids[node] = kept.input(renamed[symbol[0]], symbol[1])
    kernel = Kernel(
        name="",
        title=title,
        formula="",
        source="",
        inputs=tuple(
            Quantity(f"x{number}", (lengths[k],), "", "run of slots")
            for number, k in enumerate(used)
        ),
        outputs=tuple(
            Quantity(f"y{k}", (len(output),), "", "run of slots")
            for k, output in enumerate(outputs)
        ),
        nodes=tuple(kept.nodes),
        results=tuple(tuple(ids[node] for node in output) for output in outputs),
    )
    return kernel, used


def _in_order(graph: Graph, outputs: Sequence[Sequence[int]]) -> list[int]:
    """Nodes that outputs need, each after its operands and near where it is first used."""
    done: dict[int, None] = {}
    stack = [node for output in reversed(outputs) for node in reversed(output)]
    while stack:
        node = stack[-1]
        missing = [arg for arg in reversed(graph.nodes[node].args) if arg not in done]
        if missing:
            stack.extend(missing)
        else:
            done[stack.pop()] = None
    return list(done)
