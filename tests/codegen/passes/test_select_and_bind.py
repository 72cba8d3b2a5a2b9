"""Dead code by outputs, and inputs bound to exact numbers."""

from fractions import Fraction

import pytest

from kousoku.codegen.graph import Graph, Op
from kousoku.codegen.kernel import Kernel
from kousoku.codegen.passes.bind import bind
from kousoku.codegen.passes.select import select_outputs
from kousoku.model.errors import EmitError
from kousoku.model.quantity import Quantity


def quantity(name: str, *shape: int) -> Quantity:
    return Quantity(name, shape, "m", "")


@pytest.fixture
def kernel() -> Kernel:
    """Squared length and sum of a vector scaled by s, the length among them."""
    graph = Graph()
    s = graph.input("s", 0)
    x = [graph.mul(s, graph.input("x", k)) for k in range(3)]
    squared = graph.sum(graph.mul(a, a) for a in x)
    results = ((squared,), (graph.sum(x),), (graph.sqrt(squared),))
    return Kernel(
        name="lengths",
        title="",
        formula="",
        source="",
        inputs=(quantity("x", 3), quantity("s")),
        outputs=(quantity("squared"), quantity("sum"), quantity("length")),
        nodes=tuple(graph.nodes),
        results=results,
        names=((x[0], "x_s"), (squared, "squared")),
    )


def constant(kernel: Kernel, output: int) -> Fraction:
    (node,) = kernel.results[output]
    value = kernel.nodes[node].value
    assert value is not None
    return value


def test_selecting_keeps_the_order_of_the_kernel_and_all_inputs(kernel: Kernel) -> None:
    selected = select_outputs(kernel, ["length", "sum"])
    assert [q.name for q in selected.outputs] == ["sum", "length"]
    assert selected.inputs == kernel.inputs


def test_selecting_drops_what_only_the_others_need(kernel: Kernel) -> None:
    assert select_outputs(kernel, ["sum"]).operations == {Op.MUL: 3, Op.ADD: 2}
    assert Op.SQRT not in select_outputs(kernel, ["squared"]).operations


def test_names_follow_their_nodes_and_vanish_with_them(kernel: Kernel) -> None:
    selected = select_outputs(kernel, ["sum"])
    ((node, name),) = selected.names
    assert name == "x_s"
    assert selected.nodes[node].op is Op.MUL


def test_selecting_an_unknown_output_says_which_there_are(kernel: Kernel) -> None:
    with pytest.raises(EmitError, match="no output area; it has squared, sum, length"):
        select_outputs(kernel, ["area"])


def test_binding_all_inputs_leaves_exact_numbers(kernel: Kernel) -> None:
    bound = bind(kernel, {"x": [1, 2, 0.1], "s": [Fraction(1, 3)]})
    assert bound.inputs == ()
    assert constant(bound, 0) == (5 + Fraction(0.1) ** 2) / 9
    assert constant(bound, 1) == (3 + Fraction(0.1)) / 3


def test_binding_zeros_and_ones_removes_operations(kernel: Kernel) -> None:
    bound = bind(kernel, {"x": [None, 0, 0], "s": [1]})
    assert [q.name for q in bound.inputs] == ["x"]
    assert bound.operations == {Op.MUL: 1, Op.SQRT: 1}


def test_a_root_of_a_square_is_exact(kernel: Kernel) -> None:
    bound = bind(kernel, {"x": [3, 4, 0], "s": [Fraction(1, 7)]})
    assert constant(bound, 2) == Fraction(5, 7)


def test_a_root_is_rounded_once_far_beyond_doubles(kernel: Kernel) -> None:
    root = constant(bind(kernel, {"x": [1, 1, 0], "s": [1]}), 2)
    assert 0 < abs(root**2 - 2) < Fraction(1, 2**195)


def test_angle_functions_of_constants_fold() -> None:
    graph = Graph()
    angle = graph.input("angle", 0)
    back = graph.atan2(graph.sin(angle), graph.cos(angle))
    kernel = Kernel(
        "k", "", "", "", (quantity("angle"),), (quantity("back"),), tuple(graph.nodes), ((back,),)
    )
    for number in (0, Fraction(1, 3), -1):
        (node,) = bind(kernel, {"angle": [number]}).nodes
        assert node.value is not None
        assert abs(node.value - number) < Fraction(1, 2**195)


def test_a_division_by_a_bound_zero_stays_for_the_target_to_report() -> None:
    graph = Graph()
    ratio = graph.div(graph.input("a", 0), graph.input("b", 0))
    kernel = Kernel(
        "k",
        "",
        "",
        "",
        (quantity("a"), quantity("b")),
        (quantity("ratio"),),
        tuple(graph.nodes),
        ((ratio,),),
    )
    assert bind(kernel, {"b": [0]}).operations == {Op.DIV: 1}


def test_binding_an_unknown_input_or_a_wrong_count_is_refused(kernel: Kernel) -> None:
    with pytest.raises(EmitError, match="no input y to bind; it has x, s"):
        bind(kernel, {"y": [1]})
    with pytest.raises(EmitError, match="input x of kernel lengths has 3 elements, got 2"):
        bind(kernel, {"x": [1, 2]})
