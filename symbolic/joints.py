"""The constraints that every joint needs beside those of lecture 8.2: point, distance, norm."""

from __future__ import annotations

from typing import Any

import sympy
from sympy import Rational, S
from sympy.matrices.expressions import Identity, MatrixSymbol, ZeroMatrix
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.quantity import Quantity
from kousoku.symbolic.bodies import COMPONENTS, SYMBOLS
from kousoku.symbolic.components import dot, plus, rotate, subtract
from kousoku.symbolic.constraint import Constraint, derive_constraint
from kousoku.symbolic.derivation import Derivation, Function, Output, Step
from kousoku.symbolic.matrices import add, elements, mul, neg, symbol, transpose
from kousoku.symbolic.pairs import D
from kousoku.symbolic.variation import Variation, coefficient, without


def derive(package: str) -> Derivation:
    """Return the derivation of ``point``, ``distance`` or ``norm``."""
    if package == "norm":
        return _norm()
    return derive_constraint(_point() if package == "point" else _distance())


def _d_components() -> list[Any]:
    x = COMPONENTS
    ends = [plus(x[f"r_{body}"], rotate(x[f"p_{body}"], x[f"s_{body}_b"])) for body in "ij"]
    return subtract(ends[1], ends[0])


def _point() -> Constraint:
    left = MatrixSymbol("C", 3, 1)
    return Constraint(
        name="point",
        kind="point",
        title="point, two points coincident (SPHERICAL)",
        source="lecture 8.2, (8.8)",
        formula="C = d = r_j + A_j s′_j − r_i − A_i s′_i",
        unit="m",
        steps=(
            Step(left, D, "the vector between the points vanishes", "8.7"),
            Step(left, D.value, "in frame O", "8.8"),
        ),
        value=D.value,
        components=tuple(_d_components()),
    )


def _distance() -> Constraint:
    length = SYMBOLS["length"]
    square = mul(length**2, Identity(1))
    value = mul(Rational(1, 2) / length, add(mul(transpose(D), D), neg(square)))
    left = MatrixSymbol("C", 1, 1)
    d = _d_components()
    return Constraint(
        name="distance",
        kind="distance",
        title="distance, two points at a given distance",
        source="lecture 8.2, (8.8)",
        formula="C = (d·d − length²) / (2 length), d = r_j + A_j s′_j − r_i − A_i s′_i",
        unit="m",
        steps=(
            Step(MatrixSymbol("d", 3, 1), D.value, "vector between the points", "8.8"),
            Step(left, value, "the squares agree; divided by 2 length, so that C is a length", ""),
        ),
        value=value,
        components=((dot(d, d) - length**2) / (2 * length),),
        names=(D,),
    )


def _norm() -> Derivation:
    """Derive p·p − 1 = 0, whose coordinates are the Euler parameters themselves."""
    p, p_dot = (
        Quantity("p", (4,), "-", "Euler parameters, scalar first"),
        Quantity("p_dot", (4,), "1/s", "their time derivatives"),
    )
    lam = Quantity("lam", (1,), "N m", "multiplier")
    x, v, a, dp = (
        symbol(p),
        symbol(p_dot),
        MatrixSymbol("p_ddot", 4, 1),
        MatrixSymbol("δp", 4, 1),
    )
    value = add(mul(transpose(x), x), neg(Identity(1)))
    delta, rate = Variation({x: dp}, {}), Variation({x: v, v: a}, {})
    jacobian = coefficient(delta(value), dp)
    nu = neg(without(rate(value), v))
    gamma = neg(without(rate(rate(value)), a))
    reaction = mul(symbol(lam)[0, 0], transpose(jacobian))
    reaction_q = coefficient(delta(reaction), dp)
    e, e_dot = elements(p), elements(p_dot)
    scalar = sum((c**2 for c in e), S.NegativeOne)
    rows = [sympy.diff(scalar, c) for c in e]
    velocity = dot(rows, e_dot)
    forces = [elements(lam)[0] * row for row in rows]
    steps = (
        Step(MatrixSymbol("C", 1, 1), value, "Euler parameters have norm one", "4.3"),
        Step(MatrixSymbol("δC", 1, 1), delta(value), "product rule", ""),
        Step(MatrixSymbol("δC", 1, 1), mul(jacobian, dp), "collected", ""),
        Step(MatrixSymbol("C_p", 1, 4), jacobian, "coefficient of δp", ""),
        Step(MatrixSymbol("nu", 1, 1), nu, "dC/dt = C_q dp/dt − ν", ""),
        Step(MatrixSymbol("C_ddot", 1, 1), rate(rate(value)), "d/dt twice", ""),
        Step(MatrixSymbol("gamma", 1, 1), gamma, "minus what is left without d²p/dt²", ""),
        Step(MatrixSymbol("f", 4, 1), reaction, "C_qᵀλ", ""),
        Step(MatrixSymbol("δf", 4, 1), delta(reaction), "δ at fixed λ", ""),
    )

    def output(quantity: Quantity, expression: Any, scalars: list[Any]) -> Output:
        return Output(quantity, expression, ImmutableDenseMatrix(len(scalars), 1, scalars))

    title, source = "norm, Euler parameters of norm one", "lecture 7.1, (4.3)"
    functions = (
        Function(
            "constraint",
            f"{title}: constraint and Jacobian",
            "C = p·p − 1",
            source,
            (p,),
            (
                output(Quantity("C", (1,), "-", "constraint"), value, [scalar]),
                output(Quantity("C_q", (1, 4), "-", "Jacobian; columns δp"), jacobian, rows),
            ),
        ),
        Function(
            "rates",
            f"{title}: right-hand sides",
            "dC/dt = C_q p_dot − nu, d²C/dt² = C_q dp_dot/dt − gamma",
            source,
            (p_dot,),
            (
                output(Quantity("nu", (1,), "1/s", "velocity right-hand side"), nu, [S.Zero]),
                output(
                    Quantity("gamma", (1,), "1/s^2", "acceleration right-hand side"),
                    gamma,
                    [-dot([velocity.diff(c) for c in e], e_dot)],
                ),
            ),
        ),
        Function(
            "reaction",
            f"{title}: reaction and its derivative",
            "C_qᵀλ and (C_qᵀλ)_q",
            source,
            (p, lam),
            (
                output(Quantity("reaction", (4,), "N m", "C_qᵀλ, dual to δp"), reaction, forces),
                output(
                    Quantity("reaction_q", (4, 4), "N m", "its derivative by p at fixed λ"),
                    reaction_q,
                    [f.diff(c) for f in forces for c in e],
                ),
            ),
        ),
    )
    assert nu == ZeroMatrix(1, 1)
    return Derivation("norm", "norm", title, source, steps, functions)
