"""A linear combination of two coordinates that is to be a given function of time.

A gear couples the angles of two joints, a rack a displacement and an angle, a screw the two of one
joint; a driver has one coordinate and a law. Value, Jacobian and γ of each coordinate are given, of
any kind. More than two are combined in turn: the value C of one combination is a coordinate.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sympy.matrices.expressions import BlockMatrix, Identity, MatrixSymbol

from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.derivation import Derivation, Function, Step, output_of
from kousoku.symbolic.matrices import (
    NamedMatrix,
    add,
    elements,
    mul,
    neg,
    symbol,
    transpose,
    vector,
)
from kousoku.symbolic.variation import Variation, coefficient, without

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.symbolic.sympy_types import SymbolicMatrix

TITLE = "linear_combination, coordinates coupled to each other (COUPLER, MOTION)"
SOURCE = "lecture 7.1, (7.10)"
COLUMNS = 12
BOTH = (1, 2)

FACTORS = {k: Quantity(f"c_{k}", (), "1", f"factor of coordinate {k}") for k in BOTH}
OFFSET = Quantity("c_0", (), "m, rad", "constant")
VALUES = {k: Quantity(f"u_{k}", (1,), "m, rad", f"value of coordinate {k}") for k in BOTH}
ROWS = {
    k: Quantity(f"J_{k}", (1, COLUMNS), "-, m", f"Jacobian of coordinate {k}, by its two bodies")
    for k in BOTH
}
GAMMAS = {
    k: Quantity(f"gamma_{k}", (1,), "m/s^2, rad/s^2", f"γ of coordinate {k}: ü = J dv/dt − γ")
    for k in BOTH
}
LAW = Quantity("f", (1,), "m, rad", "function of time")
LAW_DOT = Quantity("f_dot", (1,), "m/s, rad/s", "its first derivative")
LAW_DDOT = Quantity("f_ddot", (1,), "m/s^2, rad/s^2", "its second derivative")
LAM = Quantity("lam", (1,), "N, N m", "multiplier")

DELTAS = {k: vector(f"δq_{k}", COLUMNS) for k in BOTH}
VELOCITIES = {k: vector(f"v_{k}", COLUMNS) for k in BOTH}
ACCELERATIONS = {k: vector(f"v_{k}_dot", COLUMNS) for k in BOTH}
TURNING = {k: MatrixSymbol(f"J_{k}_dot", 1, COLUMNS) for k in BOTH}

DELTA = Variation({symbol(VALUES[k]): mul(symbol(ROWS[k]), DELTAS[k]) for k in BOTH}, {})
RATE = Variation(
    {
        **{symbol(VALUES[k]): mul(symbol(ROWS[k]), VELOCITIES[k]) for k in BOTH},
        **{symbol(ROWS[k]): TURNING[k] for k in BOTH},
        **{VELOCITIES[k]: ACCELERATIONS[k] for k in BOTH},
        symbol(LAW): symbol(LAW_DOT),
        symbol(LAW_DOT): symbol(LAW_DDOT),
    },
    {},
)


def _combined(terms: Sequence[SymbolicMatrix]) -> SymbolicMatrix:
    return add(*(mul(symbol(FACTORS[k]), term) for k, term in zip(BOTH, terms, strict=True)))


VALUE = add(
    _combined([symbol(VALUES[k]) for k in BOTH]),
    mul(symbol(OFFSET), Identity(1)),
    neg(symbol(LAW)),
)
JACOBIAN = tuple(coefficient(DELTA(VALUE), DELTAS[k]) for k in BOTH)
NU = neg(without(RATE(VALUE), *VELOCITIES.values()))
GAMMA = add(_combined([symbol(GAMMAS[k]) for k in BOTH]), symbol(LAW_DDOT))


def derive(_: str) -> Derivation:
    """Derivation of ``linear_combination``: c₁ u₁ + c₂ u₂ + c₀ − f(t) = 0 (1,) of coordinates u.

    u and f are lengths [m] or angles [rad]. The Jacobian J (1, 12) of each has columns δr in frame
    O and δθ′ in the body frame, of both its bodies. ν = ḟ, γ = c₁ γ₁ + c₂ γ₂ + f̈ with the γ of ü =
    J v̇ − γ.
    """
    functions = (_constraint(), _rates(), _reaction())
    return Derivation(
        "linear_combination", "linear_combination", TITLE, SOURCE, _steps(), functions
    )


def _steps() -> tuple[Step, ...]:
    rate, accelerated = RATE(VALUE), RATE(RATE(VALUE))
    left = {
        name: MatrixSymbol(name, 1, 1) for name in ("C", "δC", "C_dot", "nu", "C_ddot", "gamma")
    }
    forms = [
        add(*(mul(block, changes[k]) for k, block in zip(BOTH, JACOBIAN, strict=True)))
        for changes in (DELTAS, VELOCITIES)
    ]
    gammas = [NamedMatrix(f"gamma_{k}", neg(mul(TURNING[k], VELOCITIES[k]))) for k in BOTH]
    blocks = [
        Step(MatrixSymbol(f"C_{k}", 1, COLUMNS), block, f"coefficient of δq_{k}", "")
        for k, block in zip(BOTH, JACOBIAN, strict=True)
    ]
    return (
        Step(left["C"], VALUE, "the coordinates are coupled to each other and to time", ""),
        Step(left["δC"], DELTA(VALUE), "δu = J δq in each coordinate, at fixed time", "7.10"),
        Step(left["δC"], forms[0], "collected", ""),
        *blocks,
        Step(left["C_dot"], rate, "δ → d/dt: du/dt = J v, and the law changes", ""),
        Step(left["C_dot"], add(forms[1], neg(NU)), "collected: the Jacobian, and ν", ""),
        Step(left["nu"], NU, "dC/dt = C_q v − ν: minus what is left without velocities", ""),
        Step(left["C_ddot"], accelerated, "d/dt once more", ""),
        Step(
            left["gamma"],
            neg(without(accelerated, *ACCELERATIONS.values())),
            "d²C/dt² = C_q dv/dt − γ: minus what is left without accelerations",
            "",
        ),
        Step(left["gamma"], add(_combined(gammas), symbol(LAW_DDOT)), "γ = −(dJ/dt) v in each", ""),
    )


def _numbers(*quantities: Quantity) -> list[Any]:
    return [x for quantity in quantities for x in elements(quantity)]


def _constraint() -> Function:
    c_1, c_2, c_0, u_1, u_2, f = _numbers(*FACTORS.values(), OFFSET, *VALUES.values(), LAW)
    columns = "Jacobian; columns of coordinate 1, then those of coordinate 2"
    outputs = (
        output_of(
            Quantity("C", (1,), "m, rad", "constraint"), VALUE, [c_1 * u_1 + c_2 * u_2 + c_0 - f]
        ),
        output_of(
            Quantity("C_q", (1, 2 * COLUMNS), "-, m", columns),
            BlockMatrix([list(JACOBIAN)]),
            [c * x for c, k in ((c_1, 1), (c_2, 2)) for x in elements(ROWS[k])],
        ),
    )
    inputs = (*FACTORS.values(), OFFSET, *VALUES.values(), *ROWS.values(), LAW)
    formula = "C = c_1 u_1 + c_2 u_2 + c_0 − f"
    return Function(
        "constraint", f"{TITLE}: constraint and Jacobian", formula, SOURCE, inputs, outputs
    )


def _rates() -> Function:
    c_1, c_2, gamma_1, gamma_2 = _numbers(*FACTORS.values(), *GAMMAS.values())
    (first,), (second,) = elements(LAW_DOT), elements(LAW_DDOT)
    nu = Quantity("nu", (1,), "m/s, rad/s", "dC/dt = C_q v − nu")
    gamma = Quantity("gamma", (1,), "m/s^2, rad/s^2", "d²C/dt² = C_q dv/dt − gamma")
    outputs = (
        output_of(nu, NU, [first]),
        output_of(gamma, GAMMA, [c_1 * gamma_1 + c_2 * gamma_2 + second]),
    )
    inputs = (*FACTORS.values(), *GAMMAS.values(), LAW_DOT, LAW_DDOT)
    formula = "nu = df/dt, gamma = c_1 gamma_1 + c_2 gamma_2 + d²f/dt²"
    return Function("rates", f"{TITLE}: right-hand sides", formula, SOURCE, inputs, outputs)


def _reaction() -> Function:
    (lam,), c_1, c_2 = elements(LAM), *_numbers(*FACTORS.values())
    rows = [[mul(symbol(LAM)[0, 0], transpose(block))] for block in JACOBIAN]
    meaning = "C_qᵀλ: of the bodies of coordinate 1, then of those of coordinate 2"
    output = output_of(
        Quantity("reaction", (2 * COLUMNS,), "N, N m", meaning),
        BlockMatrix(rows),
        [lam * c * x for c, k in ((c_1, 1), (c_2, 2)) for x in elements(ROWS[k])],
    )
    inputs = (*FACTORS.values(), *ROWS.values(), LAM)
    return Function("reaction", f"{TITLE}: reaction", "C_qᵀλ", SOURCE, inputs, (output,))
