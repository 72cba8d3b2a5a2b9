"""Kernels built by hand, for tests of the stages behind freezing."""

from collections.abc import Sequence

import pytest

from kousoku.model.files.quantity import Quantity
from kousoku.model.operations.graph import Graph
from kousoku.model.operations.kernel import Kernel, Package


def body_vector(graph: Graph, p: Sequence[int], a_b: Sequence[int]) -> list[int]:
    """A(p) a' with A(p) = (e0² − e·e) I + 2 e eᵀ + 2 e0 ẽ."""
    e0, *e = p
    two = graph.const(2)
    half = graph.sub(graph.mul(e0, e0), graph.sum(graph.mul(x, x) for x in e))
    along = graph.mul(two, graph.sum(map(graph.mul, e, a_b)))
    turned = []
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        across = graph.sub(graph.mul(e[i], a_b[j]), graph.mul(e[j], a_b[i]))
        straight = graph.add(graph.mul(half, a_b[k]), graph.mul(along, e[k]))
        turned.append(graph.add(straight, graph.mul(graph.mul(two, e0), across)))
    return turned


@pytest.fixture
def n1() -> Kernel:
    """Build C = a_i · a_j of the kind n1, with the vector of body i beside it."""
    graph = Graph()
    inputs = (
        Quantity("p_i", (4,), "-", "Euler parameters of body i"),
        Quantity("a_i_b", (3,), "-", "vector of body i, in the frame of i"),
        Quantity("p_j", (4,), "-", "Euler parameters of body j"),
        Quantity("a_j_b", (3,), "-", "vector of body j, in the frame of j"),
    )
    p_i, a_i_b, p_j, a_j_b = ([graph.input(q.name, k) for k in range(q.size)] for q in inputs)
    a_i = body_vector(graph, p_i, a_i_b)
    a_j = body_vector(graph, p_j, a_j_b)
    value = graph.sum(map(graph.mul, a_i, a_j))
    return Kernel(
        name="constraint",
        title="the two vectors stay at right angles",
        formula="C = a_i · a_j",
        source="lecture 8.2, (8.5)",
        inputs=inputs,
        outputs=(
            Quantity("C", (1,), "-", "the constraint"),
            Quantity("a_i", (3,), "-", "vector of body i, in frame O"),
        ),
        nodes=tuple(graph.nodes),
        results=((value,), tuple(a_i)),
        names=tuple((node, f"a_i_{k + 1}") for k, node in enumerate(a_i)),
    )


@pytest.fixture
def n1_package(n1: Kernel) -> Package:
    """Put the kernel in a package, as it is emitted."""
    return Package("n1", "dot-1, PERPENDICULAR", "kousoku generate n1", (n1,))
