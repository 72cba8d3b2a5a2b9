"""Every output of every kind is proved equal on both levels, and wrong ones are rejected."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import pytest
from sympy import Symbol, cos, sin, sqrt
from sympy.matrices.expressions import BlockMatrix
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.errors import DerivationError
from kousoku.model.files.quantity import Quantity
from kousoku.symbolic import KINDS
from kousoku.symbolic.bodies import COLUMNS, COMPONENTS, SYMBOLS, A, motion_flow
from kousoku.symbolic.components import Flow, half_turn
from kousoku.symbolic.matrices import elements, mul, neg, skew, symbol, transpose
from kousoku.symbolic.prove import prove, prove_steps
from kousoku.symbolic.ring import Ring

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.symbolic.derivation import Derivation, DerivedOutput, Function

PACKAGES = [package for kind in KINDS.values() for package in kind.packages]
#: One of each sort of formulas is proved with all other tests, and every kind for a release.
ALWAYS = ("rotation", "n2", "point", "norm", "link", "mass_points", "rigid_body")
MARKED = [
    package if package in ALWAYS else pytest.param(package, marks=pytest.mark.release)
    for package in PACKAGES
]
CONSTRAINTS = ["n1", "n2", "p1_x", "p1_y", "p1_z", "p2_x", "p2_y", "p2_z", "point", "distance"]


@pytest.mark.parametrize("package", MARKED)
def test_both_levels_of_every_output_are_equal(
    package: str, derived: Callable[[str], Derivation]
) -> None:
    for function in derived(package).functions:
        assert prove(function) == sum(output.quantity.size for output in function.outputs)


@pytest.mark.parametrize("package", MARKED)
def test_every_line_follows_from_those_before(
    package: str, derived: Callable[[str], Derivation]
) -> None:
    count = prove_steps(derived(package))
    assert count >= 2


def negated(output: DerivedOutput) -> DerivedOutput:
    """Output with the sign of its first element that is not zero turned."""
    values = list(output.components)
    place = next(k for k, value in enumerate(values) if value != 0)
    values[place] = -values[place]
    return replace(output, components=ImmutableDenseMatrix(len(values), 1, values))


@pytest.mark.parametrize("package", MARKED)
def test_one_wrong_sign_in_any_output_is_rejected(
    package: str, derived: Callable[[str], Derivation]
) -> None:
    for function in derived(package).functions:
        for output in function.outputs:
            if all(value == 0 for value in output.components):
                continue  # ν has no sign to turn
            with pytest.raises(DerivationError, match=f"differ in {output.quantity.name},"):
                prove(replace(function, outputs=(negated(output),)))


@pytest.mark.parametrize("package", MARKED)
def test_a_derivation_with_a_line_negated_does_not_follow(
    package: str, derived: Callable[[str], Derivation]
) -> None:
    derivation = derived(package)
    lefts = [step.left for step in derivation.steps]
    last = max(k for k, left in enumerate(lefts) if left in lefts[:k])
    steps = list(derivation.steps)
    steps[last] = replace(steps[last], right=neg(steps[last].right))
    with pytest.raises(DerivationError, match=f"step {last + 1} does not follow"):
        prove_steps(replace(derivation, steps=tuple(steps)))


def with_jacobian_block(function: Function, block: Any) -> Function:
    output = function.outputs[1]
    blocks = [output.expression.blocks[0, k] for k in range(len(COLUMNS))]
    blocks[3] = block
    changed = replace(output, expression=BlockMatrix([blocks]))
    return replace(function, outputs=(function.outputs[0], changed))


def test_printed_coefficient_of_n1_is_rejected_and_the_true_one_accepted(
    derived: Callable[[str], Derivation],
) -> None:
    function = derived("n1").functions[0]
    a_i, a_j = SYMBOLS["a_i_b"], SYMBOLS["a_j_b"]
    true = neg(mul(transpose(a_i), transpose(A["i"]), A["j"], skew(a_j)))
    printed = neg(mul(transpose(a_i), transpose(A["j"]), A["j"], skew(a_j)))  # (8.11)
    assert prove(with_jacobian_block(function, true)) == 13
    with pytest.raises(DerivationError, match="differ in C_q, element 9"):
        prove(with_jacobian_block(function, printed))


@pytest.mark.parametrize("package", CONSTRAINTS)
def test_rates_hold_at_any_state_on_and_off_the_constraint(
    package: str, derived: Callable[[str], Derivation]
) -> None:
    assert_rates_hold(derived(package), at_point=None)


@pytest.mark.parametrize("package", ["angle", "length"])
@pytest.mark.parametrize("start", [2, 5, 11])
def test_rates_hold_at_rational_states_where_the_value_is_no_polynomial(
    package: str, start: int, derived: Callable[[str], Derivation]
) -> None:
    assert_rates_hold(derived(package), at_point=start)


def assert_rates_hold(derivation: Derivation, at_point: int | None) -> None:
    """Assert dC/dt = C_q v − ν and d²C/dt² = C_q dv/dt − γ, everywhere or at rational numbers."""
    constraint, rates, _ = derivation.functions
    values = constraint.outputs[0].components
    jacobian = constraint.outputs[1].components
    nu, gamma = (output.components for output in rates.outputs)
    accelerations = [symbol_ for c in COLUMNS for symbol_ in _components_of(c.acceleration.name)]
    velocities = [symbol_ for c in COLUMNS for symbol_ in COMPONENTS[c.velocity.name]]
    scalars = _symbols(derivation) + velocities + accelerations
    at = (
        None
        if at_point is None
        else [Fraction(7 * k % 13 - 6, at_point) for k in range(len(scalars))]
    )
    carrier = Ring([], scalars=scalars, at=at)
    once = motion_flow()
    twice = _accelerated(velocities, accelerations)
    for row, value in enumerate(values):
        line = jacobian[12 * row : 12 * row + 12]
        rate = once(value)
        found = sum(c * v for c, v in zip(line, velocities, strict=True)) - nu[row]
        assert carrier.is_equal(carrier.scalar(rate), carrier.scalar(found))
        found = sum(c * a for c, a in zip(line, accelerations, strict=True)) - gamma[row]
        assert carrier.is_equal(carrier.scalar(twice(rate)), carrier.scalar(found))


def _components_of(name: str) -> list[Any]:
    return list(elements(Quantity(name, (3,), "", "")))


def _symbols(derivation: Derivation) -> list[Any]:
    names = dict.fromkeys(q for function in derivation.functions for q in function.inputs)
    return [s for q in names for s in elements(q) if not q.name.startswith(("v_", "omega_"))]


def _accelerated(velocities: Sequence[Any], accelerations: Sequence[Any]) -> Flow:
    change: dict[Any, Any] = dict(zip(velocities, accelerations, strict=True))
    for body in "ij":
        change.update(zip(COMPONENTS[f"r_{body}"], COMPONENTS[f"v_{body}"], strict=True))
        p = COMPONENTS[f"p_{body}"]
        change.update(zip(p, half_turn(p, COMPONENTS[f"omega_{body}_b"]), strict=True))
    return Flow(change, ())


def test_derivative_of_the_reaction_is_in_general_not_symmetric(
    derived: Callable[[str], Derivation],
) -> None:
    function = derived("p2_z").functions[2]
    cells = function.outputs[1].components
    carrier = Ring(function.inputs)
    pairs = [(cells[12 * i + j], cells[12 * j + i]) for i in range(12) for j in range(i)]
    differ = [not carrier.is_equal(carrier.scalar(a), carrier.scalar(b)) for a, b in pairs]
    assert any(differ)
    assert not all(differ)


def test_ring_knows_roots_and_circles() -> None:
    x, y = Symbol("x"), Symbol("y")
    carrier = Ring([], scalars=[x, y])

    def same(a: Any, b: Any) -> bool:
        return carrier.is_equal(carrier.scalar(a), carrier.scalar(b))

    assert same(sqrt(x + y) ** 2, x + y)
    assert same(1 / sqrt(x + y), sqrt(x + y) / (x + y))
    assert same(cos(x / y) ** 4 - sin(x / y) ** 4, 1 - 2 * sin(x / y) ** 2)
    assert not same(sqrt(x + y), x + y)
    assert not same(sin(x), cos(x))
    assert not same(sin(x), sin(y))


def test_symbol_of_scalar_and_array_name_their_elements() -> None:
    assert [str(s) for s in elements(Quantity("s_i_b", (3,), "m", ""))] == [
        "s_i_b[0]",
        "s_i_b[1]",
        "s_i_b[2]",
    ]
    assert [str(s) for s in elements(Quantity("length", (), "m", ""))] == ["length"]
    assert symbol(Quantity("I_A_b", (3, 3), "kg m^2", "")).shape == (3, 3)
