"""The component level in 50 digits, with derivatives."""

import pytest
import sympy
from sympy import atan2, cos, sin, sqrt

from kousoku.codegen.freeze_components import freeze_components
from kousoku.codegen.points import curved_inputs, degrees, infinite_points
from kousoku.codegen.sha256_random import Sha256Random
from kousoku.model.errors import FreezeError
from kousoku.model.files.quantity import Quantity
from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.dual import evaluate_dual
from kousoku.model.operations.kernel import Kernel
from kousoku.symbolic.derivation import DerivedOutput, Function
from kousoku.symbolic.matrices import elements

X = Quantity("x", (2,), "m", "")
Y = Quantity("y", (), "rad", "")
(x0, x1), (y,) = elements(X), elements(Y)
PLACES = {x0: ("x", 0), x1: ("x", 1), y: ("y", 0)}


def frozen(*components: sympy.Expr) -> Kernel:
    quantity = Quantity("f", (len(components),), "-", "")
    output = DerivedOutput(quantity, sympy.S.Zero, sympy.ImmutableDenseMatrix(components))
    return freeze_components(Function("f", "", "", "", (X, Y), (output,)))


FORMULAS = [
    x0**2 * x1 - 3 * y / 7,
    sqrt(x0**2 + x1**2),
    x0 / (x1 * y) ** 3,
    sin(x0 * y) * cos(x1 - y),
    atan2(x1, x0 + y),
    (x0 + x1) ** sympy.Rational(-3, 2),
]


@pytest.mark.parametrize("formula", FORMULAS, ids=str)
def test_value_and_derivatives_have_fifty_digits(formula: sympy.Expr) -> None:
    point = {"x": [1.25, 0.375], "y": [0.7]}
    (dual,) = evaluate_dual(frozen(formula), point)["f"]
    numbers = {x0: 1.25, x1: 0.375, y: 0.7}
    exact = {symbol: sympy.Rational(number) for symbol, number in numbers.items()}
    for symbol in (None, x0, x1, y):
        wanted = formula if symbol is None else formula.diff(symbol)
        got = dual.value if symbol is None else dual.gradient.get(PLACES[symbol], 0)
        number = CONTEXT.mpf(str(sympy.N(wanted.subs(exact), 60)))
        assert abs(got - number) < CONTEXT.mpf(10) ** -46


def test_equal_expressions_are_evaluated_once() -> None:
    once = frozen(x0 + x1)
    assert len(frozen(x0 + x1, sin(x0 + x1)).nodes) == len(once.nodes) + 1


def test_an_unknown_function_is_refused_by_name() -> None:
    with pytest.raises(FreezeError, match="a exp"):
        frozen(sympy.exp(x0))


def test_degrees_are_those_of_the_largest_intermediate_result() -> None:
    assert degrees(frozen((x0 + x1) ** 2 * x0 + x1, 1 / y**2)) == {"x": 3, "y": 2}
    assert degrees(frozen(sqrt(x0**2 + x1**2))) == {"x": 2, "y": 1}


def test_only_arrays_under_roots_quotients_and_angles_are_curved() -> None:
    assert curved_inputs(frozen(x0**2 * y)) == ()
    assert curved_inputs(frozen(x0 * sin(y))) == ("y",)
    assert curved_inputs(frozen(y * sqrt(x0))) == ("x",)


def test_a_quotient_or_an_angle_has_limits_at_infinity() -> None:
    def count(formula: sympy.Expr) -> int:
        return len(infinite_points(frozen(formula), Sha256Random("s")))

    assert count(1 / x0) == count(atan2(x0, x1)) == 1  # NaN, and neither infinity
    assert count(sqrt(x0) * sin(y)) == 3


def test_a_root_that_is_not_real_is_an_error() -> None:
    with pytest.raises(ArithmeticError, match="root"):
        evaluate_dual(frozen(sqrt(x0)), {"x": [-1.0, 1.0], "y": [0.0]})


def test_a_pole_is_an_error() -> None:
    with pytest.raises(ZeroDivisionError):
        evaluate_dual(frozen(1 / (x0 - x1)), {"x": [1.0, 1.0], "y": [0.0]})
