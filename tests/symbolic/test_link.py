"""The link element: (15) at the reference, wrapped angles, and the true transfer functions."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import pytest
import sympy
from sympy import Matrix, Rational, diff, symbols

from kousoku.symbolic.link_element import LENGTH, OFFSET, X
from kousoku.symbolic.matrices import elements
from kousoku.symbolic.ring import Ring

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.symbolic.derivation import Derivation


def test_jacobian_is_the_derivative_of_the_wrapped_deformations(
    derived: Callable[[str], Derivation],
) -> None:
    function = derived("link").functions[0]
    epsilon, jacobian = (output.components for output in function.outputs)
    carrier = Ring(function.inputs)
    for row, value in enumerate(epsilon):
        for column, x in enumerate(elements(X)):
            found = carrier.scalar(diff(value, x))
            assert carrier.is_equal(found, carrier.scalar(jacobian[6 * row + column]))


def at(derivation: Derivation, output: int, x: list[float], length: float) -> list[float]:
    components = derivation.functions[0].outputs[output].components
    values = [*x, length, 0.0, 0.0]
    names = [*elements(X), *elements(LENGTH), *elements(OFFSET)]
    return [float(v) for v in sympy.lambdify(names, list(components), "math")(*values)]


def test_jacobian_at_the_reference_is_the_printed_one(derived: Callable[[str], Derivation]) -> None:
    beta, length = 0.7, 3.0
    c, s = math.cos(beta), math.sin(beta)
    x = [1.0, 2.0, beta, 1 + length * c, 2 + length * s, beta]
    printed = [
        *(-c, -s, 0, c, s, 0),
        *(-s, c, length, s, -c, 0),
        *(s, -c, 0, -s, c, -length),
    ]
    assert at(derived("link"), 0, x, length) == pytest.approx([0, 0, 0], abs=1e-15)
    assert at(derived("link"), 1, x, length) == pytest.approx(printed, abs=1e-15)


@pytest.mark.parametrize("turns", [-3, -1, 1, 2])
def test_angles_are_wrapped(turns: int, derived: Callable[[str], Derivation]) -> None:
    beta = 3.0
    x = [0.0, 0.0, beta + 0.1 + 2 * math.pi * turns, math.cos(beta), math.sin(beta), beta - 0.2]
    assert at(derived("link"), 0, x, 1.0) == pytest.approx([0, 0.1, 0.2], abs=1e-14)


def transferred(derivation: Derivation, left: str, values: dict[str, Any]) -> Any:
    """Step of the method evaluated with explicit matrices."""
    (step,) = (s for s in derivation.steps if str(getattr(s.left, "name", "")) == left)
    replaced = {
        s: sympy.ImmutableMatrix(values[s.name]) for s in step.right.atoms(sympy.MatrixSymbol)
    }
    terms = step.right.args if isinstance(step.right, sympy.MatAdd) else (step.right,)
    total = None
    for term in terms:
        product = sympy.Integer(1)
        for factor in term.args:
            product = product * _explicit(factor, replaced)
        total = product if total is None else total + product
    return total


def _explicit(factor: Any, replaced: dict[Any, Any]) -> Any:
    if isinstance(factor, sympy.Inverse):
        product = sympy.Integer(1)
        for part in factor.arg.args:
            product = product * replaced[part]
        return product.inv()
    return replaced.get(factor, factor)


def test_transfer_functions_keep_the_linkage_together(
    derived: Callable[[str], Derivation],
) -> None:
    """A point on a circle: x² + y² = 1 driven by x = sin α, D = (2x, 2y)."""
    alpha = symbols("alpha")
    x, y = sympy.sin(alpha), sympy.cos(alpha)
    at_alpha = {alpha: sympy.asin(Rational(3, 5))}
    d = Matrix([[2 * x, 2 * y]])
    values = {
        "D": d.subs(at_alpha),
        "D′": d.diff(alpha).subs(at_alpha),
        "L_1": Matrix([0, 1]),
        "L_2": Matrix([1, 0]),
        "x′_2": Matrix([diff(x, alpha)]).subs(at_alpha),
    }
    first = transferred(derived("link"), "x′_1", values)
    assert first == Matrix([diff(y, alpha)]).subs(at_alpha)


def test_second_transfer_function_is_the_second_derivative(
    derived: Callable[[str], Derivation],
) -> None:
    """The same circle driven by its x, so that x″_2 = 0: y = √(1 − x²)."""
    x = symbols("x", positive=True)
    y = sympy.sqrt(1 - x**2)
    d = Matrix([[2 * x, 2 * y]])
    place = {x: Rational(3, 5)}
    values = {
        "D": d.subs(place),
        "D′": d.diff(x).subs(place),
        "L_1": Matrix([0, 1]),
        "x′": Matrix([1, diff(y, x)]).subs(place),
    }
    second = transferred(derived("link"), "x″_1", values)
    assert second == Matrix([diff(y, x, 2)]).subs(place)
