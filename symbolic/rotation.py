"""The rotation itself, lecture 7.1: orientation, virtual rotation, angular velocity, update."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import sympy
from sympy import Integer, Rational, S
from sympy.matrices.expressions import BlockMatrix, Identity, MatrixSymbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.components import Flow, compose, dot, half_turn, plus, rotate
from kousoku.symbolic.derivation import Derivation, Function, Step, output_of
from kousoku.symbolic.matrices import (
    Dot,
    NamedMatrix,
    OrientationMatrix,
    add,
    elements,
    mul,
    neg,
    quadratic_form,
    skew,
    symbol,
    transpose,
)
from kousoku.symbolic.sympy_types import as_matrix
from kousoku.symbolic.variation import Variation, coefficient

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.symbolic.sympy_types import SymbolicMatrix

R = Quantity("r", (3,), "m", "position of the body frame's origin, frame O")
P = Quantity("p", (4,), "-", "Euler parameters, scalar first")
P_DOT = Quantity("p_dot", (4,), "1/s", "their time derivatives")
S_B = Quantity("s_b", (3,), "m", "point fixed in the body, body frame")
DR = Quantity("dr", (3,), "m", "virtual displacement of the origin, frame O")
DTHETA_B = Quantity("dtheta_b", (3,), "rad", "virtual rotation, body frame")
OMEGA_B = Quantity("omega_b", (3,), "rad/s", "angular velocity, body frame")

A = OrientationMatrix(symbol(P))
DELTA = Variation({symbol(R): symbol(DR)}, {symbol(P): symbol(DTHETA_B)})
RATE = Variation({}, {symbol(P): symbol(OMEGA_B)})
#: The scalar and the vector part of the Euler parameters.
E0 = symbol(P)[0, 0]
VECTOR_PART = ImmutableDenseMatrix([[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
E = NamedMatrix("e", mul(VECTOR_PART, symbol(P)))
#: Under the root of θ² + TINY the angle never vanishes, and sin(θ/2)/θ is right to rounding.
TINY = Rational(1, 10**300)
SOURCE = "lecture 7.1"


def derive(package: str) -> Derivation:
    """Derivation of ``rotation``, lecture 7.1: A(p) (3, 3), δA = A δθ̃′ (7.16), ṗ = ½ p∘(0, ω′).

    A [-] takes components in the body frame to frame O; δθ′ (3,) [rad] and ω′ (3,) [rad/s], (5.16),
    are in the body frame.
    """
    return Derivation(
        name=package,
        kind="rotation",
        title="rotation by Euler parameters",
        source=SOURCE,
        steps=(*_variation_steps(), *_motion_steps()),
        functions=(
            _orientation(),
            _virtual_rotation(),
            _point(),
            _virtual_displacement(),
            _orientation_rate(),
            _angular_velocity(),
            _euler_rates(),
            _update(),
        ),
    )


def _conjugate(p: Sequence[Any]) -> list[Any]:
    return [p[0], -p[1], -p[2], -p[3]]


def _along(theta: Quantity) -> Flow:
    p, change = elements(P), half_turn(elements(P), elements(theta))
    return Flow(dict(zip(p, change, strict=True)), (*p, *elements(theta)))


def _orientation() -> Function:
    p = elements(P)
    columns = []
    for k in range(3):
        unit = [S.Zero] + [Integer(k == n) for n in range(3)]
        columns.append([sympy.expand(x) for x in compose(compose(p, unit), _conjugate(p))[1:]])
    cells = [column[row] for row in range(3) for column in columns]
    quantity = Quantity("A", (3, 3), "-", "orientation, body components to frame O")
    formula = "A = (e0² − e·e) I + 2 e e^T + 2 e0 e~"
    outputs = (output_of(quantity, A, cells),)
    return Function("orientation", "orientation", formula, "lecture 7.1, (4.3)", (P,), outputs)


def _virtual_rotation() -> Function:
    p, flow = elements(P), _along(DTHETA_B)
    change = [flow(cell) for row in quadratic_form(p) for cell in row]
    spatial = compose(half_turn(p, elements(DTHETA_B)), _conjugate(p))[1:]
    return Function(
        "virtual_rotation",
        "virtual rotation in both frames",
        "δA = A δθ′~, δθ = A δθ′",
        "lecture 7.1, (7.16) and (7.15)",
        (P, DTHETA_B),
        (
            output_of(
                Quantity("dA", (3, 3), "-", "variation of the orientation"), DELTA(A), change
            ),
            output_of(
                Quantity("dtheta", (3,), "rad", "virtual rotation, frame O"),
                mul(A, symbol(DTHETA_B)),
                [2 * x for x in spatial],
            ),
        ),
    )


def _point() -> Function:
    quantity = Quantity("r_P", (3,), "m", "position of the point, frame O")
    scalars = plus(elements(R), rotate(elements(P), elements(S_B)))
    expression = add(symbol(R), mul(A, symbol(S_B)))
    outputs = (output_of(quantity, expression, scalars),)
    return Function(
        "point", "point of a body", "r_P = r + A s′", "lecture 7.1, (4.28)", (R, P, S_B), outputs
    )


def _collected_displacement() -> SymbolicMatrix:
    """Displacement δr − A s′~ δθ′, by collecting δ(r + A s′)."""
    change = DELTA(add(symbol(R), mul(A, symbol(S_B))))
    terms = (mul(coefficient(change, x), x) for x in (symbol(DR), symbol(DTHETA_B)))
    return add(*terms)


def _virtual_displacement() -> Function:
    flow = _along(DTHETA_B)
    moved = [flow(x) for x in rotate(elements(P), elements(S_B))]
    quantity = Quantity("dr_P", (3,), "m", "virtual displacement of the point, frame O")
    return Function(
        "virtual_displacement",
        "virtual displacement of a point",
        "δr_P = δr − A s′~ δθ′",
        "lecture 7.1, (7.19)",
        (DR, P, DTHETA_B, S_B),
        (output_of(quantity, _collected_displacement(), plus(elements(DR), moved)),),
    )


def _orientation_rate() -> Function:
    flow = _along(OMEGA_B)
    scalars = [flow(cell) for row in quadratic_form(elements(P)) for cell in row]
    quantity = Quantity("A_dot", (3, 3), "1/s", "time derivative of the orientation")
    return Function(
        "orientation_rate",
        "time derivative of the orientation",
        "dA/dt = A ω′~",
        "lecture 7.1, (5.16)",
        (P, OMEGA_B),
        (output_of(quantity, RATE(A), scalars),),
    )


def _spin(sign: int) -> SymbolicMatrix:
    """Vector part of p̄∘ṗ (sign −1) or ṗ∘p̄ (sign +1)."""
    e_dot = NamedMatrix("e_dot", mul(VECTOR_PART, symbol(P_DOT)))
    return add(mul(E0, e_dot), mul(-symbol(P_DOT)[0, 0], E), mul(sign, skew(E), e_dot))


def _angular_velocity() -> Function:
    p, p_dot = elements(P), elements(P_DOT)
    square = sum((x**2 for x in p), S.Zero)
    body = compose(_conjugate(p), p_dot)[1:]
    frame = compose(p_dot, _conjugate(p))[1:]
    norm = Dot(symbol(P), symbol(P))
    return Function(
        "angular_velocity",
        "angular velocity from the rates of the Euler parameters",
        "ω′ = 2 (e0 de/dt − e de0/dt − e~ de/dt) / (p·p), ω = A ω′",
        "lecture 7.1, (5.16)",
        (P, P_DOT),
        (
            output_of(
                Quantity("omega_b", (3,), "rad/s", "angular velocity, body frame"),
                mul(2 / norm, _spin(-1)),
                [2 * x / square for x in body],
            ),
            output_of(
                Quantity("omega", (3,), "rad/s", "angular velocity, frame O"),
                mul(2, _spin(1)),
                [2 * x for x in frame],
            ),
        ),
    )


def _turned(theta: SymbolicMatrix) -> SymbolicMatrix:
    """Product p∘(0, θ)."""
    return as_matrix(
        BlockMatrix([[neg(mul(transpose(E), theta))], [add(mul(E0, theta), mul(skew(E), theta))]])
    )


def _euler_rates() -> Function:
    quantity = Quantity("p_dot", (4,), "1/s", "rates of the Euler parameters")
    return Function(
        "euler_rates",
        "rates of the Euler parameters from the angular velocity",
        "dp/dt = ½ p∘(0, ω′)",
        "lecture 7.1, (5.16)",
        (P, OMEGA_B),
        (
            output_of(
                quantity,
                mul(Rational(1, 2), _turned(symbol(OMEGA_B))),
                half_turn(elements(P), elements(OMEGA_B)),
            ),
        ),
    )


def _update() -> Function:
    theta, p, t = symbol(DTHETA_B), elements(P), elements(DTHETA_B)
    angle = sympy.sqrt(Dot(theta, theta) + TINY)
    c, s = sympy.cos(angle / 2), sympy.sin(angle / 2) / angle
    rotated = NamedMatrix("w", add(mul(c, symbol(P)), mul(s, _turned(theta))))
    norm = sympy.sqrt(Dot(rotated, rotated))
    length = sympy.sqrt(dot(t, t) + TINY)
    half = [sympy.cos(length / 2), *(sympy.sin(length / 2) / length * x for x in t)]
    new = compose(p, half)
    size = sympy.sqrt(sum((x**2 for x in new), S.Zero))
    quantity = Quantity("p_new", (4,), "-", "Euler parameters after the rotation, of norm one")
    return Function(
        "update",
        "rotation update",
        "p_new = w / |w|, w = p∘(cos(θ/2), δθ′ sin(θ/2)/θ), θ = |δθ′|",
        "lecture 7.1, (7.16)",
        (P, DTHETA_B),
        (output_of(quantity, mul(1 / norm, rotated), [x / size for x in new]),),
    )


def _variation_steps() -> tuple[Step, ...]:
    point, change = MatrixSymbol("r_P", 3, 1), MatrixSymbol("δr_P", 3, 1)
    delta_a, theta_b = MatrixSymbol("δA", 3, 3), symbol(DTHETA_B)
    theta = NamedMatrix("δθ", mul(A, theta_b))
    s = NamedMatrix("s", mul(A, symbol(S_B)))
    dr, s_b = symbol(DR), symbol(S_B)
    into = transpose(A)
    quadratic = add(
        mul(E0**2 - Dot(E, E), Identity(3)), mul(2, E, transpose(E)), mul(2 * E0, skew(E))
    )
    return (
        Step(MatrixSymbol("e", 3, 1), E.value, "vector part of the Euler parameters", ""),
        Step(A, quadratic, "orientation, in Euler parameters of any norm", ""),
        Step(point, add(symbol(R), mul(A, s_b)), "a point fixed in the body", "4.28"),
        Step(change, add(dr, mul(delta_a, s_b)), "product rule; s′ is constant", "7.10"),
        Step(mul(A, into), Identity(3), "A is orthogonal", "4.3"),
        Step(
            mul(A, transpose(delta_a)),
            neg(mul(delta_a, into)),
            "its variation: δA Aᵀ is skew-symmetric",
            "7.11, 7.12",
        ),
        Step(skew(theta), mul(delta_a, into), "this skew matrix defines δθ", "7.13"),
        Step(delta_a, mul(skew(theta), A), "times A from the right", "7.14"),
        Step(theta, mul(A, theta_b), "the same vector in the body frame", "7.15"),
        Step(skew(theta), mul(A, skew(theta_b), into), "w~ = A v~ Aᵀ for w = A v", "4.20"),
        Step(delta_a, DELTA(A), "AᵀA = I", "7.16"),
        Step(skew(theta_b), mul(into, delta_a), "times Aᵀ from the left", "7.17"),
        Step(change, add(dr, mul(skew(theta), s)), "(7.14) in (7.10)", "7.18"),
        Step(change, DELTA(add(symbol(R), mul(A, s_b))), "(7.16) in (7.10)", "7.19"),
        Step(change, _collected_displacement(), "u~ v = −v~ u", "7.19"),
        Step(
            mul(delta_a, s_b), neg(mul(A, skew(s_b), theta_b)), "the part of the rotation", "7.20"
        ),
    )


def _motion_steps() -> tuple[Step, ...]:
    omega_b, p, p_dot = symbol(OMEGA_B), symbol(P), symbol(P_DOT)
    rate, norm = MatrixSymbol("A_dot", 3, 3), Dot(p, p)
    spin = mul(2 / norm, _spin(-1))
    turned = mul(Rational(1, 2), _turned(omega_b))
    theta = symbol(DTHETA_B)
    angle = sympy.Symbol("θ")
    return (
        Step(rate, RATE(A), "δ → d/dt: the virtual rotation becomes ω′", "5.16"),
        Step(p_dot, turned, "A(p) obeys (5.16) when p turns so: ½ p∘(0, ω′)", "5.16"),
        Step(MatrixSymbol("omega_b", 3, 1), spin, "solved for ω′, with p̄∘p = p·p", ""),
        Step(MatrixSymbol("omega", 3, 1), mul(2, _spin(1)), "ω = A ω′", "7.15"),
        Step(
            MatrixSymbol("w", 4, 1),
            add(mul(sympy.cos(angle / 2), p), mul(sympy.sin(angle / 2) / angle, _turned(theta))),
            "a finite rotation by δθ′ on the right; θ is its length",
            "7.16",
        ),
        Step(
            MatrixSymbol("p_new", 4, 1),
            mul(
                1 / sympy.sqrt(Dot(MatrixSymbol("w", 4, 1), MatrixSymbol("w", 4, 1))),
                MatrixSymbol("w", 4, 1),
            ),
            "brought back to norm one",
            "4.3",
        ),
    )
