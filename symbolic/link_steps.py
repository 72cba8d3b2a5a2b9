"""The steps of Yamada and Tatsumi (1981): the element, the assembly, and their method."""

from __future__ import annotations

from typing import TYPE_CHECKING

import sympy
from sympy import Rational, Symbol
from sympy.matrices.expressions import Inverse, MatrixSymbol, ZeroMatrix
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.symbolic.derivation import Step
from kousoku.symbolic.link_element import (
    ACROSS,
    ALONG,
    BETA_RATE,
    DELTA_X,
    L0,
    L_RATE,
    OFFSET,
    D,
    L,
    X,
    jacobian_rate,
    variations,
)
from kousoku.symbolic.matrices import NamedScalar, add, mul, neg, symbol
from kousoku.symbolic.sympy_types import as_matrix
from kousoku.symbolic.variation import coefficient

if TYPE_CHECKING:
    from kousoku.symbolic.sympy_types import SymbolicMatrix


def element_steps() -> tuple[Step, ...]:
    """Steps from (5)–(7) to D and its derivative along the motion."""
    beta = Symbol("beta")
    x, offset = symbol(X), symbol(OFFSET)
    names = [f"epsilon_{k}" for k in (1, 2, 3)]
    first, second = (x[3 * k + 2, 0] - offset[k, 0] for k in (0, 1))
    dx, dy = x[3, 0] - x[0, 0], x[4, 0] - x[1, 0]
    return (
        *_reference_steps(),
        Step(Symbol(names[0]), L - L0, "elongation", "5"),
        Step(Symbol(names[1]), (first - beta) * L0, "turn of end 1 against the link", "6"),
        Step(Symbol(names[2]), (beta - second) * L0, "turn of end 2 against the link", "7"),
        Step(MatrixSymbol("d", 2, 1), D.value, "from end 1 to end 2; N picks the places", "9"),
        Step(L, L.value, "length now", "9"),
        Step(
            MatrixSymbol("n", 2, 1),
            ALONG.value,
            "unit vector (cos β, sin β) along the link",
            "12, 13",
        ),
        Step(MatrixSymbol("t", 2, 1), ACROSS.value, "a quarter turn on from n", ""),
        Step(beta, sympy.atan2(dy, dx), "angle of the link", "12, 13"),
        *_jacobian_steps(),
        *_rate_steps(),
    )


def _reference_steps() -> tuple[Step, ...]:
    """Steps (1)–(3), (8), (10) and (11): the reference position."""
    reference, beta = MatrixSymbol("x_0", 6, 1), Symbol("beta_0")
    x = [reference[k, 0] for k in range(6)]
    length = sympy.sqrt((x[3] - x[0]) ** 2 + (x[4] - x[1]) ** 2)
    return (
        Step(symbol(X), add(reference, MatrixSymbol("u", 6, 1)), "reference, displaced", "1, 2, 3"),
        Step(L0, length, "length of the link at the reference", "8"),
        Step(beta, sympy.atan2(x[4] - x[1], x[3] - x[0]), "its angle there", "10, 11"),
        Step(
            symbol(OFFSET),
            ImmutableDenseMatrix([[x[2] - beta], [x[5] - beta]]),
            "angles of the ends from the link there, zero in the paper",
            "1",
        ),
    )


def _jacobian_steps() -> tuple[Step, ...]:
    deltas = [MatrixSymbol(f"δε_{k}", 1, 1) for k in (1, 2, 3)]
    forms = variations()
    changes = (
        Step(delta, form, why, source)
        for delta, form, why, source in zip(
            deltas,
            forms,
            ("δl = nᵀ δd", "l δβ = tᵀ δd; l0 and the offsets are constant", "the other end"),
            ("14", "14", "14"),
            strict=True,
        )
    )
    rows = (
        Step(
            MatrixSymbol(f"D_{k}", 1, 6),
            coefficient(form, DELTA_X),
            f"row {k}: coefficient of δx",
            "15",
        )
        for k, form in enumerate(forms, 1)
    )
    cos, sin = NamedScalar("cos β", ALONG[0, 0]), NamedScalar("sin β", ALONG[1, 0])
    turn = L0 / L
    printed = (
        [-cos, -sin, 0, cos, sin, 0],
        [-turn * sin, turn * cos, L0, turn * sin, -turn * cos, 0],
        [turn * sin, -turn * cos, 0, -turn * sin, turn * cos, -L0],
    )
    spelled = (
        Step(
            MatrixSymbol(f"D_{k}", 1, 6),
            ImmutableDenseMatrix([row]),
            f"row {k} spelled out: at the reference l = l0",
            "15",
        )
        for k, row in enumerate(printed, 1)
    )
    return (*changes, *rows, *spelled)


def _rate_steps() -> tuple[Step, ...]:
    rows = list(jacobian_rate().blocks[:, 0])
    return (
        Step(L_RATE, L_RATE.value, "δ → d/dt", ""),
        Step(BETA_RATE, BETA_RATE.value, "δ → d/dt", ""),
        *(
            Step(MatrixSymbol(f"D_{k}_dot", 1, 6), row, "n changes by t dβ, t by −n dβ", "")
            for k, row in enumerate(rows, 1)
        ),
    )


def assembly_steps() -> tuple[Step, ...]:
    """Steps (16)–(21): all elements together, parted into unknown and known."""
    m, n, k = sympy.symbols("m n k", integer=True, positive=True)
    jacobian, u = MatrixSymbol("D", m, n), MatrixSymbol("u", n, 1)
    element, selection = MatrixSymbol("D_e", 3, 6), MatrixSymbol("B_e", 6, n)
    unknown, known = MatrixSymbol("L_1", n, m), MatrixSymbol("L_2", n, k)
    u1, u2 = MatrixSymbol("u_1", m, 1), MatrixSymbol("u_2", k, 1)
    rigid = Step(
        mul(element, selection, u),
        ZeroMatrix(3, 1),
        "links are rigid: ε = 0 for every element e, whose ends are x_e = B_e x",
        "16",
    )
    return (
        rigid,
        Step(
            mul(jacobian, u), ZeroMatrix(m, 1), "assembly: the rows D_e B_e of all elements", "17"
        ),
        Step(u, add(mul(unknown, u1), mul(known, u2)), "partition: unknown and known", "18, 19"),
        Step(
            add(mul(jacobian, unknown, u1), mul(jacobian, known, u2)),
            ZeroMatrix(m, 1),
            "(19) in (17)",
            "20",
        ),
        Step(u1, neg(mul(_solved(jacobian, unknown), jacobian, known, u2)), "solved", "21"),
    )


def _solved(jacobian: SymbolicMatrix, unknown: SymbolicMatrix) -> SymbolicMatrix:
    return as_matrix(Inverse(mul(jacobian, unknown)))


def method_steps() -> tuple[Step, ...]:
    """Steps (22)–(28): transfer functions, predictor and corrector."""
    return (*_transfer_steps(), *_motion_steps(), *_iteration_steps())


def _transfer_steps() -> tuple[Step, ...]:
    m, n, k = sympy.symbols("m n k", integer=True, positive=True)
    jacobian, slope = MatrixSymbol("D", m, n), MatrixSymbol("D′", m, n)
    unknown, known = MatrixSymbol("L_1", n, m), MatrixSymbol("L_2", n, k)
    first, second = MatrixSymbol("x′", n, 1), MatrixSymbol("x″", n, 1)
    x1, x2 = MatrixSymbol("x′_1", m, 1), MatrixSymbol("x′_2", k, 1)
    inverse = _solved(jacobian, unknown)
    return (
        Step(
            x1, neg(mul(inverse, jacobian, known, x2)), "first transfer function, x′ = dx/dα", "22"
        ),
        Step(first, add(mul(unknown, x1), mul(known, x2)), "all coordinates", "19"),
        Step(
            add(mul(slope, first), mul(jacobian, second)),
            ZeroMatrix(m, 1),
            "d/dα of D x′ = 0, with D′ = dD/dα at this position",
            "",
        ),
        Step(
            MatrixSymbol("x″_1", m, 1),
            neg(mul(inverse, slope, first)),
            "second transfer function: x″_2 = 0; D′ acts on all of x′",
            "23",
        ),
    )


def _motion_steps() -> tuple[Step, ...]:
    n = sympy.symbols("n", integer=True, positive=True)
    first, second = MatrixSymbol("x′", n, 1), MatrixSymbol("x″", n, 1)
    rate, acceleration = Symbol("alpha_dot"), Symbol("alpha_ddot")
    return (
        Step(MatrixSymbol("x_dot", n, 1), mul(rate, first), "velocity: chain rule", "24"),
        Step(
            MatrixSymbol("x_ddot", n, 1),
            add(mul(rate**2, second), mul(acceleration, first)),
            "acceleration: chain rule",
            "25",
        ),
    )


def _iteration_steps() -> tuple[Step, ...]:
    m, n = sympy.symbols("m n", integer=True, positive=True)
    jacobian, unknown = MatrixSymbol("D", m, n), MatrixSymbol("L_1", n, m)
    first, second = MatrixSymbol("x′", n, 1), MatrixSymbol("x″", n, 1)
    reference, step = MatrixSymbol("x_ref", n, 1), Symbol("Δα")
    residual, correction = MatrixSymbol("zeta", m, 1), MatrixSymbol("u^*", m, 1)
    return (
        Step(
            MatrixSymbol("x_adj", n, 1),
            add(reference, mul(step, first), mul(step**2 * Rational(1, 2), second)),
            "predictor",
            "26",
        ),
        Step(
            correction,
            neg(mul(_solved(jacobian, unknown), residual)),
            "corrector: ζ is ε at x_adj",
            "27",
        ),
        Step(
            MatrixSymbol("x′_new", n, 1),
            add(first, mul(1 / step, unknown, correction)),
            "the correction enters the slope, and (26) is repeated",
            "28",
        ),
    )
