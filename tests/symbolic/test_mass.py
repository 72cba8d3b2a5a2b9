"""Newton-Euler: mass points through the rigid body's kernel, and Lagrange's way to the same."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
import sympy
from sympy import S

from kousoku.model.errors import DerivationError
from kousoku.symbolic.components import dot, rotate
from kousoku.symbolic.mass import derive_mass_points
from kousoku.symbolic.mass_steps import OMEGA_B, P
from kousoku.symbolic.matrices import elements
from kousoku.symbolic.prove import prove, prove_steps
from kousoku.symbolic.ring import Ring

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.symbolic.derivation import Derivation, Function


def substituted(function: Function, values: dict[str, Any]) -> list[list[Any]]:
    """All outputs with the elements of some inputs replaced by formulas."""
    replaced = {
        s: value
        for q in function.inputs
        if q.name in values
        for s, value in zip(elements(q), values[q.name], strict=True)
    }
    return [
        [cell.subs(replaced, simultaneous=True) for cell in output.components]
        for output in function.outputs
    ]


def test_mass_points_go_through_the_rigid_body(derived: Callable[[str], Derivation]) -> None:
    inertia, resultant, whole = derived("mass_points").functions
    given = {
        output.quantity.name: list(output.components)
        for function in (inertia, resultant)
        for output in function.outputs
    }
    found = substituted(derived("rigid_body").functions[0], given)
    carrier = Ring(whole.inputs)
    for output, cells in zip(whole.outputs, found, strict=True):
        for cell, wanted in zip(cells, output.components, strict=True):
            assert carrier.is_equal(carrier.scalar(cell), carrier.scalar(wanted))


def test_mass_matrix_is_the_kinetic_energy_of_points_on_rotations(
    derived: Callable[[str], Derivation],
) -> None:
    """T = ½ Σ m |ṙ|² with ṙ = v + d(A s)/dt; Euler parameters of norm one."""
    whole = derived("mass_points").functions[2]
    matrix = sympy.Matrix(6, 6, list(whole.outputs[0].components))
    masses, flat, p = elements(whole.inputs[0]), elements(whole.inputs[1]), elements(P)
    omega = elements(OMEGA_B)
    v = sympy.symbols("v:3")
    half = sympy.Rational(1, 2)
    rates = [
        half * c
        for c in (
            -dot(p[1:], omega),
            p[0] * omega[0] + p[2] * omega[2] - p[3] * omega[1],
            p[0] * omega[1] + p[3] * omega[0] - p[1] * omega[2],
            p[0] * omega[2] + p[1] * omega[1] - p[2] * omega[0],
        )
    ]
    square = sum(e**2 for e in p)
    energy = S.Zero
    for k, m in enumerate(masses):
        place = rotate(p, flat[3 * k : 3 * k + 3])
        moving = [
            v[n] + sum(x.diff(e) * rate for e, rate in zip(p, rates, strict=True)) / square
            for n, x in enumerate(place)
        ]
        energy += m * dot(moving, moving)
    state = sympy.Matrix([*v, *omega])
    form = (state.T * matrix * state)[0]
    # norm one: the mixed part holds one A, the other parts none
    mixed = sum(2 * state[i] * matrix[i, j] * state[j] for i in range(3) for j in range(3, 6))
    form = form - mixed + mixed / square
    carrier = Ring(whole.inputs, scalars=v)
    assert carrier.is_equal(carrier.scalar(energy), carrier.scalar(form))


def test_any_number_of_points_can_be_derived() -> None:
    for n in (1, 2, 5):
        derivation = derive_mass_points(n)
        assert prove_steps(derivation) >= 3
        for function in derivation.functions:
            assert prove(function) > 0


def test_no_points_at_all_are_refused() -> None:
    with pytest.raises(DerivationError, match="0 mass points have no mass; give at least 1"):
        derive_mass_points(0)


def test_at_the_centre_of_mass_the_equations_part(derived: Callable[[str], Derivation]) -> None:
    function = derived("rigid_body").functions[0]
    matrix, right = substituted(function, {"r_AG_b": [S.Zero] * 3})
    cells = sympy.Matrix(6, 6, matrix)
    assert cells[:3, 3:] == sympy.zeros(3, 3)
    assert cells[3:, :3] == sympy.zeros(3, 3)
    assert right[:3] == [s for q in function.inputs if q.name == "F" for s in elements(q)]
