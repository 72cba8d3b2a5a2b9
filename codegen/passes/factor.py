"""Common factors of sums, taken out: a·b + a·c becomes a·(b + c)."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from kousoku.codegen.passes.rebuild import copy_node, finish, live_ids
from kousoku.model.operations.graph import Graph, Op

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.model.operations.kernel import Kernel

    #: A sign and the nodes of the factors.
    Term = tuple[int, tuple[int, ...]]

SUMS = frozenset({Op.ADD, Op.SUB})


def factor(kernel: Kernel) -> Kernel:
    """Kernel with common factors taken out of sums, the factor of most terms first.

    A factor that is taken out of k terms saves k − 1 multiplications. Sums and products that
    something else uses, or that have a name, stay as they are.
    """
    live = live_ids(kernel.nodes, (node for result in kernel.results for node in result))
    inner = _used_inside_only(kernel, live)
    graph = Graph()
    new_ids: dict[int, int] = {}
    for node in live:
        if kernel.nodes[node].op in SUMS and inner.get(node) not in SUMS:
            terms = [
                (sign, tuple(new_ids[x] for x in _factors(kernel, term, inner)))
                for sign, term in _terms(kernel, node, inner)
            ]
            if _commonest_factor(terms) is not None:
                new_ids[node] = _factored_sum(graph, terms)
                continue
        new_ids[node] = copy_node(graph, kernel.nodes[node], new_ids)
    return finish(kernel, graph, new_ids)


def _used_inside_only(kernel: Kernel, live: Sequence[int]) -> dict[int, Op]:
    """Nameless nodes with one use, and the operation that uses them."""
    users: dict[int, Op] = {}
    uses = Counter(node for result in kernel.results for node in result)
    uses.update(node for node, _ in kernel.names)
    for node in live:
        for arg in kernel.nodes[node].args:
            uses[arg] += 1
            users[arg] = kernel.nodes[node].op
    return {node: op for node, op in users.items() if uses[node] == 1}


def _terms(kernel: Kernel, root: int, inner: Mapping[int, Op]) -> list[tuple[int, int]]:
    """Signs and terms of a sum, from left to right."""
    terms = []
    stack = [(1, root)]
    while stack:
        sign, node = stack.pop()
        op, args = kernel.nodes[node].op, kernel.nodes[node].args
        if op in SUMS and (node == root or inner.get(node) in SUMS):
            stack.append((sign if op is Op.ADD else -sign, args[1]))
            stack.append((sign, args[0]))
        else:
            terms.append((sign, node))
    return terms


def _factors(kernel: Kernel, term: int, inner: Mapping[int, Op]) -> list[int]:
    """Factors of a product that only its sum uses, from left to right."""
    factors = []
    stack = [term]
    while stack:
        node = stack.pop()
        if kernel.nodes[node].op is Op.MUL and node in inner:
            stack.extend(reversed(kernel.nodes[node].args))
        else:
            factors.append(node)
    return factors


def _commonest_factor(terms: Sequence[Term]) -> int | None:
    """Factor of most products, of equals the one that was computed first."""
    counts = Counter(
        node for _, factors in terms if len(factors) > 1 for node in dict.fromkeys(factors)
    )
    best = min(counts, key=lambda node: (-counts[node], node), default=None)
    return best if best is not None and counts[best] > 1 else None


def _factored_sum(graph: Graph, terms: Sequence[Term]) -> int:
    """Node of a sum with common factors taken out; a group takes the position of its first term."""
    common = _commonest_factor(terms)
    if common is None:
        total = graph.const(0)
        for sign, factors in terms:
            product = graph.const(1)
            for node in factors:
                product = graph.mul(product, node)
            total = graph.add(total, product) if sign > 0 else graph.sub(total, product)
        return total
    inside: list[Term] = []
    outside: list[Term] = []
    insertion = 0
    for sign, factors in terms:
        if common in factors and len(factors) > 1:
            index = factors.index(common)
            insertion = insertion if inside else len(outside)
            inside.append((sign, factors[:index] + factors[index + 1 :]))
        else:
            outside.append((sign, factors))
    outside.insert(insertion, (1, (common, _factored_sum(graph, inside))))
    return _factored_sum(graph, outside)
