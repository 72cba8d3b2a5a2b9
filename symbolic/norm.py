"""Euler parameters have norm one: a constraint by the parameters themselves."""

from __future__ import annotations

from typing import Any

import sympy
from sympy import S
from sympy.matrices.expressions import Identity, MatrixSymbol

from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.components import dot
from kousoku.symbolic.derivation import Derivation, Function, Step, output_of
from kousoku.symbolic.matrices import add, elements, mul, neg, symbol, transpose
from kousoku.symbolic.variation import Variation, coefficient, without

TITLE, SOURCE = "norm, Euler parameters of norm one", "lecture 7.1, (4.3)"
P = Quantity("p", (4,), "-", "Euler parameters, scalar first")
P_DOT = Quantity("p_dot", (4,), "1/s", "their time derivatives")
LAM = Quantity("lam", (1,), "N m", "multiplier")
DELTA_P, P_DDOT = MatrixSymbol("δp", 4, 1), MatrixSymbol("p_ddot", 4, 1)
DELTA = Variation({symbol(P): DELTA_P}, {})
RATE = Variation({symbol(P): symbol(P_DOT), symbol(P_DOT): P_DDOT}, {})

VALUE = add(mul(transpose(symbol(P)), symbol(P)), neg(Identity(1)))
JACOBIAN = coefficient(DELTA(VALUE), DELTA_P)
NU = neg(without(RATE(VALUE), symbol(P_DOT)))
GAMMA = neg(without(RATE(RATE(VALUE)), P_DDOT))
REACTION = mul(symbol(LAM)[0, 0], transpose(JACOBIAN))
REACTION_Q = coefficient(DELTA(REACTION), DELTA_P)


def derive_norm() -> Derivation:
    """Derivation of p·p − 1 = 0 (1,) [-], lecture 7.1, (4.3), by δp and dp/dt.

    p (4,) [-] takes components in the body frame to frame O by A(p).
    """
    return Derivation(
        "norm", "norm", TITLE, SOURCE, _steps(), (_constraint(), _rates(), _reaction())
    )


def _steps() -> tuple[Step, ...]:
    variation, rate = MatrixSymbol("δC", 1, 1), MatrixSymbol("C_dot", 1, 1)
    return (
        Step(MatrixSymbol("C", 1, 1), VALUE, "Euler parameters have norm one", "4.3"),
        Step(variation, DELTA(VALUE), "product rule; a number is its own transpose", ""),
        Step(variation, mul(JACOBIAN, DELTA_P), "collected", ""),
        Step(MatrixSymbol("C_p", 1, 4), JACOBIAN, "coefficient of δp", ""),
        Step(rate, RATE(VALUE), "δ → d/dt", ""),
        Step(rate, mul(JACOBIAN, symbol(P_DOT)), "collected", ""),
        Step(MatrixSymbol("nu", 1, 1), NU, "dC/dt = C_q dp/dt − ν", ""),
        Step(MatrixSymbol("C_ddot", 1, 1), RATE(RATE(VALUE)), "d/dt once more", ""),
        Step(MatrixSymbol("gamma", 1, 1), GAMMA, "minus what is left without d²p/dt²", ""),
        Step(MatrixSymbol("f", 4, 1), REACTION, "C_qᵀλ", ""),
        Step(MatrixSymbol("δf", 4, 1), DELTA(REACTION), "δ at fixed λ", ""),
        Step(MatrixSymbol("f_p", 4, 4), REACTION_Q, "coefficient of δp", ""),
    )


def _scalar() -> Any:
    return sum((e**2 for e in elements(P)), S.NegativeOne)


def _row() -> list[Any]:
    return [sympy.diff(_scalar(), e) for e in elements(P)]


def _constraint() -> Function:
    outputs = (
        output_of(Quantity("C", (1,), "-", "constraint"), VALUE, [_scalar()]),
        output_of(Quantity("C_q", (1, 4), "-", "Jacobian; columns δp"), JACOBIAN, _row()),
    )
    title = f"{TITLE}: constraint and Jacobian"
    return Function("constraint", title, "C = p·p − 1", SOURCE, (P,), outputs)


def _rates() -> Function:
    velocity = dot(_row(), elements(P_DOT))
    gamma = -dot([velocity.diff(e) for e in elements(P)], elements(P_DOT))
    outputs = (
        output_of(Quantity("nu", (1,), "1/s", "velocity right-hand side"), NU, [S.Zero]),
        output_of(Quantity("gamma", (1,), "1/s^2", "acceleration right-hand side"), GAMMA, [gamma]),
    )
    formula = "dC/dt = C_q p_dot − nu, d²C/dt² = C_q dp_dot/dt − gamma"
    return Function("rates", f"{TITLE}: right-hand sides", formula, SOURCE, (P_DOT,), outputs)


def _reaction() -> Function:
    forces = [elements(LAM)[0] * row for row in _row()]
    derivatives = [f.diff(e) for f in forces for e in elements(P)]
    outputs = (
        output_of(Quantity("reaction", (4,), "N m", "C_qᵀλ, dual to δp"), REACTION, forces),
        output_of(
            Quantity("reaction_q", (4, 4), "N m", "its derivative by p at fixed λ"),
            REACTION_Q,
            derivatives,
        ),
    )
    title = f"{TITLE}: reaction and its derivative"
    return Function("reaction", title, "C_qᵀλ and (C_qᵀλ)_q", SOURCE, (P, LAM), outputs)
