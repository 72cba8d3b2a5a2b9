"""Passes keep the meaning exactly, never cost an operation, and say what they did."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kousoku.codegen.kernel_json import load_frozen
from kousoku.codegen.passes.factor import factor
from kousoku.codegen.passes.optimise import PASSES, optimise
from kousoku.codegen.passes.rebuild import drop_dead
from kousoku.codegen.passes.trace import most_alive, run_passes
from kousoku.model.files.quantity import Quantity
from kousoku.model.operations.arithmetic import EXACT
from kousoku.model.operations.graph import Graph, Op
from kousoku.model.operations.interpret import evaluate
from kousoku.model.operations.kernel import Kernel

if TYPE_CHECKING:
    from collections.abc import Callable

X = Quantity("x", (5,), "m", "")
KINDS = ("n1", "n2", "p1_x", "p2_z")


def kernel_of(graph: Graph, *results: int, names: tuple[tuple[int, str], ...] = ()) -> Kernel:
    output = Quantity("f", (len(results),), "m", "")
    return Kernel("k", "", "", "", (X,), (output,), tuple(graph.nodes), (results,), names)


@pytest.fixture
def graph() -> Graph:
    return Graph()


@pytest.fixture
def x(graph: Graph) -> list[int]:
    return [graph.input("x", k) for k in range(X.size)]


@st.composite
def kernels(draw: st.DrawFn) -> Kernel:
    """Draw a kernel of sums and products that share their parts."""
    graph = Graph()
    nodes = [graph.input("x", k) for k in range(X.size)] + [graph.const(2)]
    build = {"add": graph.add, "sub": graph.sub, "mul": graph.mul}
    for _ in range(draw(st.integers(1, 25))):
        verb = draw(st.sampled_from(sorted(build)))
        a, b = (draw(st.sampled_from(nodes)) for _ in range(2))
        nodes.append(build[verb](a, b))
    results = draw(st.lists(st.sampled_from(nodes), min_size=1, max_size=3))
    return kernel_of(graph, *results)


@given(kernels())
def test_every_pass_keeps_the_exact_value_and_costs_nothing(kernel: Kernel) -> None:
    point = {"x": [Fraction(n, 7) for n in (3, -5, 11, 2, -1)]}
    for one in PASSES:
        better = one(kernel)
        assert evaluate(better, point, EXACT) == evaluate(kernel, point, EXACT)
        assert better.operations.total() <= kernel.operations.total()


@given(kernels())
def test_optimising_twice_changes_nothing_more(kernel: Kernel) -> None:
    once, _ = optimise(kernel)
    assert optimise(once)[0].operations == once.operations


@pytest.mark.parametrize("name", KINDS)
def test_kinds_keep_their_exact_values(name: str) -> None:
    for kernel in load_frozen(name).kernels:
        point = {
            q.name: [Fraction((7 * k + len(q.name)) % 11 - 5, 3) for k in range(q.size)]
            for q in kernel.inputs
        }
        better, _ = optimise(kernel)
        assert evaluate(better, point, EXACT) == evaluate(kernel, point, EXACT)


def test_dead_operations_are_dropped_and_the_rest_renumbered(graph: Graph, x: list[int]) -> None:
    graph.mul(x[3], x[4])
    kernel = drop_dead(kernel_of(graph, graph.add(x[0], x[1])))
    assert [node.op for node in kernel.nodes] == [Op.INPUT, Op.INPUT, Op.ADD]
    assert kernel.results == ((2,),)


def test_a_common_factor_is_taken_out(graph: Graph, x: list[int]) -> None:
    a, b, c, d, e = x
    terms = [graph.mul(a, b), graph.mul(c, d), graph.neg(graph.mul(a, c)), graph.mul(e, a)]
    kernel = drop_dead(kernel_of(graph, graph.sum(terms)))
    assert kernel.operations == {Op.MUL: 4, Op.ADD: 2, Op.SUB: 1}
    assert factor(kernel).operations == {Op.MUL: 2, Op.ADD: 2, Op.SUB: 1}


def test_factors_are_taken_out_of_what_is_left_too(graph: Graph, x: list[int]) -> None:
    a, b, c, d, e = x
    ab = graph.mul(a, b)
    kernel = kernel_of(graph, graph.sum([graph.mul(ab, c), graph.mul(graph.mul(a, d), b), e]))
    assert kernel.operations == {Op.MUL: 4, Op.ADD: 2}
    assert factor(kernel).operations == {Op.MUL: 2, Op.ADD: 2}


def test_a_product_that_something_else_uses_stays(graph: Graph, x: list[int]) -> None:
    shared = graph.mul(x[0], x[1])
    kernel = kernel_of(graph, graph.add(shared, graph.mul(x[0], x[2])), shared)
    assert factor(kernel).operations == kernel.operations


def test_a_product_that_has_a_name_stays(graph: Graph, x: list[int]) -> None:
    named = graph.mul(x[0], x[1])
    total = graph.add(named, graph.mul(x[0], x[2]))
    kernel = factor(kernel_of(graph, total, names=((named, "power"),)))
    assert kernel.operations == {Op.MUL: 2, Op.ADD: 1}
    assert [name for _, name in kernel.names] == ["power"]


def test_sums_without_common_factors_keep_their_order(graph: Graph, x: list[int]) -> None:
    total = graph.add(graph.add(x[0], x[1]), graph.add(x[2], graph.mul(x[3], x[4])))
    kernel = drop_dead(kernel_of(graph, total))
    assert factor(kernel) == kernel


def test_most_alive_counts_what_is_needed_later(graph: Graph, x: list[int]) -> None:
    a, b = graph.mul(x[0], x[1]), graph.mul(x[2], x[3])
    kernel = kernel_of(graph, graph.add(a, b))
    assert most_alive(kernel) == 2
    power = x[0]
    for factor_ in x[1:]:  # a product lives until the next one is there
        power = graph.mul(power, factor_)
    assert most_alive(kernel_of(graph, power)) == 2
    assert most_alive(kernel_of(Graph())) == 0


def test_the_trace_names_each_pass_and_what_it_saved(graph: Graph, x: list[int]) -> None:
    graph.mul(x[3], x[4])
    kernel = kernel_of(graph, graph.add(graph.mul(x[0], x[1]), graph.mul(x[0], x[2])))
    better, trace = optimise(kernel)
    assert [record.name for record in trace] == ["drop_dead", "factor"]
    assert [(r.operations_before, r.operations_after) for r in trace] == [(4, 3), (3, 2)]
    assert [record.bytes_after for record in trace] == [16, 8]
    assert better.operations == {Op.MUL: 1, Op.ADD: 1}


def test_a_pass_that_is_added_runs_after_those_before_it(graph: Graph, x: list[int]) -> None:
    seen = []

    def spy(name: str) -> Callable[[Kernel], Kernel]:
        def one(kernel: Kernel) -> Kernel:
            seen.append(name)
            return kernel

        one.__name__ = name
        return one

    _, trace = run_passes(kernel_of(graph, x[0]), (spy("first"), spy("second")))
    assert seen == [record.name for record in trace] == ["first", "second"]
