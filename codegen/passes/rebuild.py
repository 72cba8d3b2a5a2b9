"""Kernels rebuilt in a fresh graph: the walk that every pass shares."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from kousoku.model.operations.graph import Graph, Op

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from kousoku.model.operations.graph import OperationNode
    from kousoku.model.operations.kernel import Kernel


def live_ids(nodes: Sequence[OperationNode[int]], wanted: Iterable[int]) -> list[int]:
    """Ids, in topological order, of all nodes that ``wanted`` needs."""
    is_live = [False] * len(nodes)
    for node in wanted:
        is_live[node] = True
    for node in range(len(nodes) - 1, -1, -1):
        if is_live[node]:
            for arg in nodes[node].args:
                is_live[arg] = True
    return [node for node, live in enumerate(is_live) if live]


def copy_node(graph: Graph, node: OperationNode[int], new_ids: Mapping[int, int]) -> int:
    """Copy of one node in ``graph``; its operands were copied before."""
    if node.op is Op.CONST:
        assert node.value is not None
        return graph.const(node.value)
    if node.op is Op.INPUT:
        assert node.symbol is not None
        return graph.input(*node.symbol)
    return graph.apply(node.op, [new_ids[arg] for arg in node.args])


def substitute(
    graph: Graph, kernel: Kernel, inputs: Mapping[str, Sequence[int]]
) -> dict[str, list[int]]:
    """Outputs of a kernel that is rebuilt in ``graph``, with nodes of it in place of the inputs.

    Returns
    -------
    dict of str to list of int
        For each output the nodes of its elements, row-major.
    """
    ids: dict[int, int] = {}
    for old, node in enumerate(kernel.nodes):
        if node.symbol is not None:
            name, index = node.symbol
            ids[old] = inputs[name][index]
        else:
            ids[old] = copy_node(graph, node, ids)
    return {
        quantity.name: [ids[node] for node in result]
        for quantity, result in zip(kernel.outputs, kernel.results, strict=True)
    }


def finish(kernel: Kernel, graph: Graph, new_ids: Mapping[int, int]) -> Kernel:
    """``kernel`` with the nodes of ``graph``: dead ones dropped, the others renumbered.

    Parameters
    ----------
    kernel : Kernel
        The kernel whose results and names are carried over.
    graph : Graph
        Graph that a pass built.
    new_ids : mapping of int to int
        For each old node that is still wanted its node in ``graph``.
    """
    results = tuple(tuple(new_ids[node] for node in result) for result in kernel.results)
    live = live_ids(graph.nodes, (node for result in results for node in result))
    compact = {old: new for new, old in enumerate(live)}
    nodes = tuple(
        graph.nodes[old].with_args(tuple([compact[arg] for arg in graph.nodes[old].args]))
        for old in live
    )
    return replace(
        kernel,
        nodes=nodes,
        results=tuple(tuple(compact[node] for node in result) for result in results),
        names=_carry_names(kernel, nodes, new_ids, compact),
    )


def drop_dead(kernel: Kernel) -> Kernel:
    """Kernel without the nodes that no output needs, built through the graph again."""
    graph = Graph()
    new_ids: dict[int, int] = {}
    for node in live_ids(kernel.nodes, (node for result in kernel.results for node in result)):
        new_ids[node] = copy_node(graph, kernel.nodes[node], new_ids)
    return finish(kernel, graph, new_ids)


def with_outputs(kernel: Kernel, names: Sequence[str]) -> Kernel:
    """Kernel of some outputs alone, without the nodes that only others need."""
    indices = {quantity.name: k for k, quantity in enumerate(kernel.outputs)}
    outputs = tuple(kernel.outputs[indices[name]] for name in names)
    results = tuple(kernel.results[indices[name]] for name in names)
    return drop_dead(replace(kernel, outputs=outputs, results=results))


def _carry_names(
    kernel: Kernel,
    nodes: Sequence[OperationNode[int]],
    new_ids: Mapping[int, int],
    compact: Mapping[int, int],
) -> tuple[tuple[int, str], ...]:
    """Names whose node is still an operation; the first name of a node wins."""
    names: dict[int, str] = {}
    for old, name in kernel.names:
        new = compact.get(new_ids.get(old, -1))
        if new is not None and nodes[new].op not in {Op.CONST, Op.INPUT}:
            names.setdefault(new, name)
    return tuple(sorted(names.items()))
