"""Formulas as graphs: the same numbers as Python's own, and exact derivatives."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from kousoku.codegen.expressions import to_graph
from kousoku.model.errors import ExpressionError, FreezeError
from kousoku.model.expressions.derivative import derivative
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.files.quantity import Quantity
from kousoku.model.numbers.digits import CONTEXT, HIGH
from kousoku.model.operations.arithmetic import FLOAT, Arithmetic
from kousoku.model.operations.expression import ZERO, ordered
from kousoku.model.operations.graph import Graph, Op
from kousoku.model.operations.interpret import ARRAY, evaluate
from kousoku.model.operations.kernel import Kernel

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.operations.expression import Expression

NAMES = ("t", "x")
QUANTITIES = tuple(Quantity(name, (), "-", "") for name in NAMES)

#: A formula as it is written, and what Python makes of it; its third argument scales all numbers.
Pair = tuple[str, "Callable[[float, float, float], float]"]

ONE_ARGUMENT: dict[str, Callable[[float], float]] = {
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "asin": math.asin,
    "acos": math.acos,
    "atan": math.atan,
    "sqrt": math.sqrt,
    "exp": math.exp,
    "log": math.log,
    "abs": abs,
    # A zero keeps its own sign, as in NumPy and C: an angle of atan2 depends on it.
    "sign": lambda x: math.copysign((x > 0) - (x < 0), x),
}
TWO_ARGUMENTS: dict[str, Callable[[float, float], float]] = {
    "atan2": math.atan2,
    "min": min,
    "max": max,
}


def kernel_of(*expressions: Expression) -> Kernel:
    """Kernel that computes some formulas of t and x."""
    graph = Graph()
    leaves = {name: graph.input(name, 0) for name in NAMES}
    results = tuple((to_graph(expression, graph, leaves),) for expression in expressions)
    outputs = tuple(Quantity(f"y{k}", (), "-", "") for k in range(len(results)))
    return Kernel("f", "", "", "", QUANTITIES, outputs, tuple(graph.nodes), results)


def values(expressions: list[Expression], t: Any, x: Any, numbers: Arithmetic[Any]) -> list[Any]:
    """Values of some formulas."""
    outputs = evaluate(kernel_of(*expressions), {"t": [t], "x": [x]}, numbers)
    return [value for (value,) in outputs.values()]


def value(text: str, t: float = 0.0, x: float = 0.0) -> float:
    return float(values([parse_expression(text, NAMES)], t, x, FLOAT)[0])


def joined(parts: tuple[str, Pair, Pair]) -> Pair:
    """Two formulas joined by an operator, or as arguments of a function."""
    sign, (a, f), (b, g) = parts
    if sign in TWO_ARGUMENTS:
        h = TWO_ARGUMENTS[sign]
        return f"{sign}({a}, {b})", lambda *at: h(f(*at), g(*at))
    python: dict[str, Callable[[float, float], float]] = {
        "+": lambda u, v: u + v,
        "-": lambda u, v: u - v,
        "*": lambda u, v: u * v,
        "/": lambda u, v: u / v,
    }
    return f"({a}) {sign} ({b})", lambda *at: python[sign](f(*at), g(*at))


def applied(parts: tuple[str, Pair]) -> Pair:
    name, (a, f) = parts
    return f"{name}({a})", lambda *at: ONE_ARGUMENT[name](f(*at))


def power(base: float, exponent: Fraction) -> float:
    """Python's power, but of -0 with a root: sqrt keeps its sign, which pow drops."""
    if base == 0.0 and math.copysign(1.0, base) < 0.0 and exponent.denominator > 1:
        raise ValueError("the sign of a root of -0")
    return math.pow(base, float(exponent))


def raised(parts: tuple[Pair, Fraction]) -> Pair:
    (a, f), exponent = parts
    shown = str(float(exponent))
    return f"({a})^{shown}", lambda *at: power(f(*at), exponent)


def extended(inner: st.SearchStrategy[Pair]) -> st.SearchStrategy[Pair]:
    exponents = st.sampled_from([Fraction(n, 4) for n in range(-12, 24) if n])
    return (
        st.tuples(st.sampled_from([*"+-*/", *TWO_ARGUMENTS]), inner, inner).map(joined)
        | st.tuples(st.sampled_from(sorted(ONE_ARGUMENT)), inner).map(applied)
        | st.tuples(inner, exponents).map(raised)
        | inner.map(lambda pair: (f"-({pair[0]})", lambda *at: -pair[1](*at)))
    )


TIME: Pair = ("t", lambda t, _x, _s: t)
LEAVES: st.SearchStrategy[Pair] = st.one_of(
    st.just(TIME),
    st.just(("x", lambda _t, x, _s: x)),
    st.just(("pi", lambda _t, _x, s: math.pi * s)),
    st.integers(1, 400).map(lambda n: (str(n / 100), lambda _t, _x, s: n / 100 * s)),
)
FORMULAS = st.recursive(LEAVES, extended, max_leaves=7)
POINTS = st.floats(-3, 3).map(lambda number: round(number, 3))


def python_value(pair: Pair, t: float, x: float) -> tuple[float, float]:
    """Python's value, and how far small changes of all numbers move it."""
    try:
        value = pair[1](t, x, 1.0)
        moved = [pair[1](t * (1 + e), x * (1 - e), 1 + 2 * e) for e in (1e-12, -1e-12)]
    except (ArithmeticError, ValueError):
        assume(False)
        raise
    spread = max(abs(value - other) for other in moved)
    assume(abs(value) < 1e12 and spread < 1e-6)
    return value, spread


def parsed(pair: Pair) -> Expression:
    try:
        return parse_expression(pair[0], NAMES)
    except ExpressionError:
        assume(False)
        raise


@settings(max_examples=500, deadline=None)
@given(FORMULAS, POINTS, POINTS)
@example(joined(("atan2", TIME, applied(("sign", TIME)))), -0.0, 0.0)
def test_a_formula_has_the_value_that_python_gives_it(pair: Pair, t: float, x: float) -> None:
    wanted, spread = python_value(pair, t, x)
    with np.errstate(all="ignore"):
        (got,) = values([parsed(pair)], np.float64(t), np.float64(x), ARRAY)
    assert got == pytest.approx(wanted, rel=1e-9, abs=1e-9 + spread)


@settings(max_examples=300, deadline=None)
@given(FORMULAS, POINTS, POINTS, st.sampled_from(NAMES))
def test_derivatives_are_those_of_differences_in_50_digits(
    pair: Pair, t: float, x: float, name: str
) -> None:
    python_value(pair, t, x)
    expression = parsed(pair)
    step = CONTEXT.mpf("1e-20")
    point = {"t": CONTEXT.mpf(t) + step / 3, "x": CONTEXT.mpf(x) - step / 7}
    try:
        (got,) = values([derivative(expression, name)], point["t"], point["x"], HIGH)
        moved = [point | {name: point[name] + way * step} for way in (-2, -1, 1, 2)]
        ends = [values([expression], at["t"], at["x"], HIGH)[0] for at in moved]
    except (ArithmeticError, ValueError, TypeError, AttributeError):
        assume(False)  # a step beyond an end of the domain: mpmath goes on with complex numbers
        raise
    assume(all(isinstance(end, CONTEXT.mpf) for end in (got, *ends)))
    slopes = [(ends[2] - ends[1]) / (2 * step), (ends[3] - ends[0]) / (4 * step)]
    assume(abs(slopes[0]) < 1e9 and abs(slopes[1] - slopes[0]) < 1e-15)
    assert abs(got - slopes[0]) < 1e-9 * (1 + abs(got))


@pytest.mark.parametrize(
    ("text", "slope"),
    [
        ("t^3 - 2*t", lambda t: 3 * t**2 - 2),
        ("sin(2*t)", lambda t: 2 * math.cos(2 * t)),
        ("t^t", lambda t: t**t * (math.log(t) + 1)),
        ("2^t", lambda t: 2**t * math.log(2)),
        ("atan2(t, 2)", lambda t: 2 / (4 + t * t)),
        ("abs(t - 5)", lambda _: -1.0),
        ("max(t^2, 3*t)", lambda _: 3.0),
        ("min(t^2, 3*t)", lambda t: 2 * t),
        ("asin(t/4) + acos(t/4)", lambda _: 0.0),
        ("sign(t)*t", lambda _: 1.0),
        ("x*exp(-x)", lambda _: 0.0),
    ],
)
def test_derivatives_that_are_known(text: str, slope: Callable[[float], float]) -> None:
    formula = derivative(parse_expression(text, NAMES), "t")
    for t in (0.3, 1.25, 2.9):
        (got,) = values([formula], t, 0.5, FLOAT)
        assert got == pytest.approx(slope(t), rel=1e-14, abs=1e-14)


CANCELLING = (
    "5*(t - 5)/sqrt((t - 5)^2 + 1e-6)",
    "(t - 5)*((t - 5)^2 + x^2)^(-0.5)",
    "(t - 5)*(2/sqrt((t - 5)*(t - 5) + x))",
    "(1 + (t - 5)/sqrt((t - 5)^2 + 1e-6))/2",
    "-t/(t + 1e-3)",
    "(t^2 - 1)/(t^2 + 1)",
    "(t - 5)^3/(1 + (t - 5)^3)",
)
"""Quotients that hardly change where t is large."""


@pytest.mark.parametrize("text", CANCELLING)
def test_derivatives_of_quotients_keep_their_digits(text: str) -> None:
    formula = parse_expression(text, NAMES)
    first = derivative(formula, "t")
    for t in (0.25, 4.75, 6.0, 1e4):
        with CONTEXT.workdps(80):
            wanted = CONTEXT.diff(lambda t: values([formula], t, CONTEXT.mpf("0.5"), HIGH)[0], t)
        (got,) = values([first], t, 0.5, FLOAT)
        assert abs(got - wanted) <= 1e-14 * abs(wanted)


def test_derivatives_of_quotients_in_quotients_grow_with_them() -> None:
    sizes = []
    for depth in (12, 24):
        text = "t"
        for _ in range(depth):
            text = f"t/(1 + {text})"
        sizes.append(len(ordered(derivative(parse_expression(text, NAMES), "t"))))
    assert sizes[1] < 3 * sizes[0]


def test_the_derivative_at_a_kink_is_the_mean_of_both_sides() -> None:
    slopes = [derivative(parse_expression(text, NAMES), "t") for text in KINKS]
    assert values(slopes, 0.0, 0.0, FLOAT) == [0.0, 1.0, 1.0, 0.0]


KINKS = ("abs(t)", "max(t, t - x) + 0*x", "max(2*t, 0)", "sign(t)")


def test_what_does_not_depend_on_the_name_has_no_derivative() -> None:
    assert derivative(parse_expression("sin(x)^2/log(x)", NAMES), "t") == ZERO


def test_whole_powers_are_products_and_halves_are_roots() -> None:
    operations = kernel_of(parse_expression("t^13", NAMES)).operations
    assert operations == {Op.MUL: 5}
    operations = kernel_of(parse_expression("t^-2.5", NAMES)).operations
    assert operations == {Op.MUL: 2, Op.SQRT: 1, Op.DIV: 1}
    assert Op.EXP in kernel_of(parse_expression("t^0.3", NAMES)).operations


def test_the_sign_is_exact_for_the_smallest_numbers_too() -> None:
    for t in (5e-324, 1e-310, 1.0, 1e300):
        assert value("sign(t)", t) == 1
        assert value("sign(t)", -t) == -1
    assert value("sign(t)", 0.0) == 0


def test_the_minimum_keeps_all_digits_of_the_smaller_number() -> None:
    assert value("min(t, x)", 1e20, 0.1) == 0.1


def test_second_derivatives_of_a_long_formula_stay_small() -> None:
    formula = parse_expression("*".join(["sin(t)"] * 50), NAMES)
    second = derivative(derivative(formula, "t"), "t")
    assert kernel_of(second).operations.total() < 1000


def test_arrays_are_evaluated_at_once() -> None:
    t = np.linspace(-1, 1, 5)
    (got,) = values([parse_expression("max(abs(t), 0.4)*exp(t)", NAMES)], t, t, ARRAY)
    np.testing.assert_allclose(got, np.maximum(np.abs(t), 0.4) * np.exp(t), rtol=1e-15)


def test_a_name_without_a_node_is_refused() -> None:
    graph = Graph()
    with pytest.raises(FreezeError, match="the name t has no node; there are x"):
        to_graph(parse_expression("t + x", NAMES), graph, {"x": graph.input("x", 0)})


def test_a_constant_beyond_the_doubles_is_refused() -> None:
    graph = Graph()
    expression = parse_expression("((p^64)^64)^64", ("p",))
    with pytest.raises(FreezeError, match="too large for a double"):
        to_graph(expression, graph, {"p": graph.const(10)})
    small = to_graph(expression, graph, {"p": graph.const(Fraction(1, 10))})
    assert graph.value(small) == 0
