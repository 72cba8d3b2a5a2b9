"""The planar link element of Yamada and Tatsumi (1981), and the method that is built on it.

The kernel ``deformation`` takes the coordinates ``x`` = x1 y1 β1 x2 y2 β2 of the two ends (2), the
design length ``length`` = l0 (8), and ``offset``, the angles of the end coordinates β1, β2 from the
link at design (zero where β is the link's own angle). It gives the three deformations ``epsilon``
(5)–(7), whose angles are wrapped into (−π, π], and ``D`` = ∂ε/∂x at any position, which is (15)
where l = l0. The kernel ``rate`` takes ``x``, ``x_dot`` (a derivative by time or by α) and
``length``, and gives ``D_dot`` and the product ``D_dot_x_dot`` that the second transfer function
(23) needs. ε1 and its row use no angle, so that they are free of atan2 once the rest is dropped.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import sympy
from sympy import Rational, Symbol
from sympy.matrices.expressions import BlockMatrix, Identity, Inverse, MatrixSymbol, ZeroMatrix
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.quantity import Quantity
from kousoku.symbolic.components import dot
from kousoku.symbolic.derivation import Derivation, Function, Output, Step
from kousoku.symbolic.matrices import (
    Dot,
    Matrix,
    Named,
    NamedScalar,
    add,
    elements,
    mul,
    neg,
    symbol,
    transpose,
)
from kousoku.symbolic.variation import coefficient

if TYPE_CHECKING:
    from collections.abc import Sequence

X = Quantity("x", (6,), "m, rad", "x1 y1 β1 x2 y2 β2 of the ends, frame O, (2)")
X_DOT = Quantity("x_dot", (6,), "m/s, rad/s", "derivative of x along the motion")
LENGTH = Quantity("length", (), "m", "design length l0, (8)")
OFFSET = Quantity("offset", (2,), "rad", "angles of β1 and β2 from the link at design")
SOURCE = "Yamada and Tatsumi 1981"
TITLE = "planar link element"

DELTA_X = MatrixSymbol("δx", 6, 1)
ENDS = ImmutableDenseMatrix([[-1, 0, 0, 1, 0, 0], [0, -1, 0, 0, 1, 0]])
QUARTER_TURN = ImmutableDenseMatrix([[0, -1], [1, 0]])
FIRST_ANGLE = ImmutableDenseMatrix([[0, 0, 1, 0, 0, 0]])
SECOND_ANGLE = ImmutableDenseMatrix([[0, 0, 0, 0, 0, 1]])

L0 = Symbol("length")
#: From end 1 to end 2; its length l; the unit vectors along and across the link.
D = Named("d", mul(Named("N", ENDS), symbol(X)))
L = NamedScalar("l", sympy.sqrt(Dot(D, D)))
ALONG = Named("n", mul(1 / L, D))
ACROSS = Named("t", mul(Named("J", QUARTER_TURN), ALONG))
D_RATE = Named("d_dot", mul(Named("N", ENDS), symbol(X_DOT)))
L_RATE = NamedScalar("l_dot", Dot(ALONG, D_RATE))
BETA_RATE = NamedScalar("beta_dot", Dot(ACROSS, D_RATE) / L)


def derive(package: str) -> Derivation:
    """Return the derivation of ``link``."""
    return Derivation(
        name=package,
        kind="link",
        title=TITLE,
        source=SOURCE,
        steps=(*_element_steps(), *_assembly_steps(), *_method_steps()),
        functions=(_deformation(), _rate()),
    )


def _variations() -> tuple[Matrix, Matrix, Matrix]:
    """Return δε1, δε2, δε3: δl = nᵀδd and l δβ = tᵀδd."""
    delta_d = mul(Named("N", ENDS), DELTA_X)
    angle = mul(L0 / L, transpose(ACROSS), delta_d)
    first, second = (
        mul(L0, Named(f"b{k}", row), DELTA_X) for k, row in ((1, FIRST_ANGLE), (2, SECOND_ANGLE))
    )
    return mul(transpose(ALONG), delta_d), add(first, neg(angle)), add(angle, neg(second))


def _jacobian() -> Matrix:
    """Return D = ∂ε/∂x, by collecting δx."""
    return BlockMatrix([[coefficient(row, DELTA_X)] for row in _variations()])


def _jacobian_rate() -> Matrix:
    """Return Ḋ with ṅ = β̇ t, ṫ = −β̇ n, l̇ = nᵀḋ, l β̇ = tᵀḋ."""
    ends = Named("N", ENDS)
    turned = add(mul(BETA_RATE, transpose(ALONG)), mul(L_RATE / L, transpose(ACROSS)))
    row = mul(L0 / L, turned, ends)
    return BlockMatrix([[mul(BETA_RATE, transpose(ACROSS), ends)], [row], [neg(row)]])


def _angle_to_link(k: int, x: Sequence[Any], offset: Sequence[Any]) -> Any:
    """Return β_k − offset_k − β in (−π, π], as the angle between two directions."""
    theta = x[3 * k + 2] - offset[k]
    dx, dy = x[3] - x[0], x[4] - x[1]
    c, s = sympy.cos(theta), sympy.sin(theta)
    return sympy.atan2(s * dx - c * dy, c * dx + s * dy)


def _deformation() -> Function:
    x, offset = ([symbol(q)[k, 0] for k in range(q.size)] for q in (X, OFFSET))
    epsilon = ImmutableDenseMatrix(
        [
            [L - L0],
            [L0 * _angle_to_link(0, x, offset)],
            [-L0 * _angle_to_link(1, x, offset)],
        ]
    )
    components = [_stretch() - L0]
    components.extend(
        sign * L0 * _angle_to_link(k, elements(X), elements(OFFSET))
        for k, sign in ((0, 1), (1, -1))
    )
    return Function(
        "deformation",
        f"{TITLE}: deformations and their derivatives",
        "epsilon = (l − l0, (β1 − β) l0, (β − β2) l0), D = ∂ε/∂x",
        f"{SOURCE}, (5)–(15)",
        (X, LENGTH, OFFSET),
        (
            _output(Quantity("epsilon", (3,), "m", "deformations"), epsilon, components),
            _output(
                Quantity("D", (3, 6), "-, m/rad", "derivatives of epsilon by x"),
                _jacobian(),
                _component_jacobian(),
            ),
        ),
    )


def _rate() -> Function:
    velocities = dict(zip(elements(X), elements(X_DOT), strict=True))
    rates = [
        sum(sympy.diff(cell, x) * v for x, v in velocities.items())
        for cell in _component_jacobian()
    ]
    products = [dot(rates[6 * row : 6 * row + 6], elements(X_DOT)) for row in range(3)]
    first = mul(L * BETA_RATE**2, Identity(1))
    second = mul(2 * L0 * BETA_RATE * L_RATE / L, Identity(1))
    return Function(
        "rate",
        f"{TITLE}: derivative along the motion",
        "D_dot = dD/dt, D_dot_x_dot = D_dot x_dot",
        f"{SOURCE}, (23)",
        (X, LENGTH, X_DOT),
        (
            _output(
                Quantity("D_dot", (3, 6), "1/s, m/s/rad", "derivative of D along the motion"),
                _jacobian_rate(),
                rates,
            ),
            _output(
                Quantity("D_dot_x_dot", (3,), "m/s^2", "D_dot times x_dot"),
                BlockMatrix([[first], [second], [neg(second)]]),
                products,
            ),
        ),
    )


def _output(quantity: Quantity, expression: Matrix, scalars: Sequence[Any]) -> Output:
    return Output(quantity, expression, ImmutableDenseMatrix(len(scalars), 1, list(scalars)))


def _stretch() -> Any:
    x = elements(X)
    return sympy.sqrt((x[3] - x[0]) ** 2 + (x[4] - x[1]) ** 2)


def _component_jacobian() -> list[Any]:
    """Differentiate (5)–(7) with β = atan2(dy, dx); wrapping changes no derivative."""
    x = elements(X)
    beta = sympy.atan2(x[4] - x[1], x[3] - x[0])
    rows = (_stretch(), (x[2] - beta) * L0, (beta - x[5]) * L0)
    return [sympy.diff(row, coordinate) for row in rows for coordinate in x]


def _element_steps() -> tuple[Step, ...]:
    beta = Symbol("beta")
    x, offset = symbol(X), symbol(OFFSET)
    names = [f"epsilon_{k}" for k in (1, 2, 3)]
    first, second = (x[3 * k + 2, 0] - offset[k, 0] for k in (0, 1))
    dx, dy = x[3, 0] - x[0, 0], x[4, 0] - x[1, 0]
    deltas = [MatrixSymbol(f"δε_{k}", 1, 1) for k in (1, 2, 3)]
    forms = _variations()
    variations = (
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
    return (
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
        *variations,
        *rows,
        *spelled,
        *_rate_steps(),
    )


def _rate_steps() -> tuple[Step, ...]:
    rows = list(_jacobian_rate().blocks[:, 0])
    return (
        Step(L_RATE, L_RATE.value, "δ → d/dt", ""),
        Step(BETA_RATE, BETA_RATE.value, "δ → d/dt", ""),
        *(
            Step(MatrixSymbol(f"D_{k}_dot", 1, 6), row, "n changes by t dβ, t by −n dβ", "")
            for k, row in enumerate(rows, 1)
        ),
    )


def _assembly_steps() -> tuple[Step, ...]:
    m, n, k = sympy.symbols("m n k", integer=True, positive=True)
    whole, u = MatrixSymbol("D", m, n), MatrixSymbol("u", n, 1)
    element, place = MatrixSymbol("D_e", 3, 6), MatrixSymbol("B_e", 6, n)
    unknown, known = MatrixSymbol("L_1", n, m), MatrixSymbol("L_2", n, k)
    u1, u2 = MatrixSymbol("u_1", m, 1), MatrixSymbol("u_2", k, 1)
    rigid = Step(
        mul(element, place, u),
        ZeroMatrix(3, 1),
        "links are rigid: ε = 0 for every element e, whose ends are x_e = B_e x",
        "16",
    )
    return (
        rigid,
        Step(mul(whole, u), ZeroMatrix(m, 1), "assembly: the rows D_e B_e of all elements", "17"),
        Step(u, add(mul(unknown, u1), mul(known, u2)), "partition: unknown and known", "18, 19"),
        Step(
            add(mul(whole, unknown, u1), mul(whole, known, u2)),
            ZeroMatrix(m, 1),
            "(19) in (17)",
            "20",
        ),
        Step(u1, neg(mul(_solved(whole, unknown), whole, known, u2)), "solved", "21"),
    )


def _solved(whole: Matrix, unknown: Matrix) -> Matrix:
    return Inverse(mul(whole, unknown))


def _method_steps() -> tuple[Step, ...]:
    m, n, k = sympy.symbols("m n k", integer=True, positive=True)
    whole, slope = MatrixSymbol("D", m, n), MatrixSymbol("D′", m, n)
    unknown, known = MatrixSymbol("L_1", n, m), MatrixSymbol("L_2", n, k)
    first, second = MatrixSymbol("x′", n, 1), MatrixSymbol("x″", n, 1)
    x1, x2 = MatrixSymbol("x′_1", m, 1), MatrixSymbol("x′_2", k, 1)
    residual, correction = MatrixSymbol("zeta", m, 1), MatrixSymbol("u^*", m, 1)
    rate, acceleration, step = Symbol("alpha_dot"), Symbol("alpha_ddot"), Symbol("Δα")
    inverse = _solved(whole, unknown)
    return (
        Step(x1, neg(mul(inverse, whole, known, x2)), "first transfer function, x′ = dx/dα", "22"),
        Step(first, add(mul(unknown, x1), mul(known, x2)), "all coordinates", "19"),
        Step(
            add(mul(slope, first), mul(whole, second)),
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
        Step(MatrixSymbol("x_dot", n, 1), mul(rate, first), "velocity: chain rule", "24"),
        Step(
            MatrixSymbol("x_ddot", n, 1),
            add(mul(rate**2, second), mul(acceleration, first)),
            "acceleration: chain rule",
            "25",
        ),
        Step(
            MatrixSymbol("x_adj", n, 1),
            add(
                MatrixSymbol("x_ref", n, 1),
                mul(step, first),
                mul(step**2 * Rational(1, 2), second),
            ),
            "predictor",
            "26",
        ),
        Step(correction, neg(mul(inverse, residual)), "corrector: ζ is ε at x_adj", "27"),
        Step(
            MatrixSymbol("x′_new", n, 1),
            add(first, mul(1 / step, unknown, correction)),
            "the correction enters the slope, and (26) is repeated",
            "28",
        ),
    )
