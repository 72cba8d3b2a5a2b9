"""A spring and damper between two points: tension, generalised forces and energy.

A tension T, here k (l − l⁰) + c dl/dt, does the virtual work −T δl. The coefficient of each
virtual displacement in it is the generalised force, so that it is dual to the columns of every
Jacobian. Where the points coincide there is no line between them; the force is then zero, as its
limit is without free length and damping.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import sympy
from sympy import Rational
from sympy.matrices.expressions import BlockMatrix, Identity, MatrixSymbol

from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.bodies import (
    BODIES,
    COLUMNS,
    CONFIGURATION,
    DELTA,
    MOTION,
    RATE,
    SYMBOLS,
    A,
    motion_flow,
    unit_flows,
)
from kousoku.symbolic.components import dot
from kousoku.symbolic.derivation import Derivation, DerivedOutput, Function, Step, output_of
from kousoku.symbolic.joints import parts_of_motion, point_offset, relative_motion
from kousoku.symbolic.matrices import (
    Divisor,
    Dot,
    NamedMatrix,
    NamedScalar,
    add,
    elements,
    mul,
    neg,
    skew,
    symbol,
    transpose,
)
from kousoku.symbolic.pairs import turning_seen_from
from kousoku.symbolic.variation import coefficient

if TYPE_CHECKING:
    from kousoku.symbolic.sympy_types import SymbolicMatrix

TITLE = "spring_damper, spring and damper between two points (TSDA)"
SOURCE = "lecture 8.2, (8.8)"
LENGTH = Quantity("l", (), "m", "distance of the points")
LENGTH_RATE = Quantity("l_dot", (), "m/s", "its time derivative")
TENSION = Quantity("T", (), "N", "tension: it draws the points together")
STIFFNESS = Quantity("stiffness", (), "N/m", "k, tension by elongation")
DAMPING = Quantity("damping", (), "N s/m", "c, tension by rate of elongation")
FREE_LENGTH = Quantity("free_length", (), "m", "l⁰, length without tension")

LAW_INPUTS = (LENGTH, LENGTH_RATE, STIFFNESS, DAMPING, FREE_LENGTH)
PLACES = tuple(q for q in CONFIGURATION if q.name[0] in "rps")

#: Motion of each body, and of j less that of i.
OF_BODY, RELATIVE = {body: parts_of_motion(body) for body in BODIES}, relative_motion()
#: The vector between the points: zero to the last bit where the bodies are in the same place.
D = NamedMatrix("d", add(RELATIVE["r"], RELATIVE["s"]))
#: d without the point on the body itself: from the origin of i, and to the origin of j.
FROM_OWN_ORIGIN = {
    "i": NamedMatrix("d_i", add(RELATIVE["r"], OF_BODY["j"]["s"])),
    "j": NamedMatrix("d_j", add(RELATIVE["r"], neg(OF_BODY["i"]["s"]))),
}
L = NamedScalar("l", sympy.sqrt(Dot(D, D)))
#: One, and zero where the points coincide; one divided by l, and zero there.
APART = NamedScalar("apart", L / Divisor(L))
INVERSE = NamedScalar("g", APART / Divisor(L))
ALONG = NamedMatrix("n", mul(INVERSE, D))
D_RATE = NamedMatrix("d_dot", RATE(D))
ELONGATION = symbol(LENGTH) - symbol(FREE_LENGTH)
LAW = symbol(STIFFNESS) * ELONGATION + symbol(DAMPING) * symbol(LENGTH_RATE)
ENERGY = Rational(1, 2) * symbol(STIFFNESS) * ELONGATION**2


def derive(_: str) -> Derivation:
    """Derivation of ``spring_damper``: T = k (l − l⁰) + c dl/dt [N] along d, (8.8), by −T δl.

    Length l = |d| (1,) [m]; generalised force (12,): of i, then of j, a force [N] in frame O and a
    torque [N m] in the body frame.
    """
    return Derivation(
        "spring_damper", "spring_damper", TITLE, SOURCE, _steps(), (_length(), _law(), _force())
    )


def length_rate() -> tuple[SymbolicMatrix, SymbolicMatrix]:
    """Rate dl/dt = h l / d·d, zero where d is, and h / l; h = d·v + r·w + s_i·(Ω_i × s_j).

    The rate is (1, 1) [m/s], the vectors (3,) are in frame O. Without an index they are those of j
    less those of i; Ω_i is the angular velocity of i less that of j, seen from j, so that nothing
    is lost of a turn about the line to the point. Each term is small where the bodies move
    together, and none holds the part that a point far from its own origin adds to d·ḋ and takes
    from it.
    """
    # Named, so that it does not wait for the angular velocity.
    seen = NamedMatrix("s_seen", mul(transpose(A["j"]), OF_BODY["i"]["s"]))
    by_turning = mul(transpose(seen), skew(turning_seen_from("j").omega), SYMBOLS["s_j_b"])
    by_origins = mul(transpose(D), RELATIVE["v"])
    by_points = mul(transpose(RELATIVE["r"]), RELATIVE["w"])
    half_square_rate = NamedMatrix("h", add(by_origins, by_points, by_turning))
    return mul(L / Divisor(Dot(D, D)), half_square_rate), mul(1 / L, half_square_rate)


def generalised_forces() -> tuple[SymbolicMatrix, ...]:
    """Force on i in frame O, torque in the frame of i, and those of j: −T ∂l/∂q, (3, 1) [N], [N m].

    In a torque T s̃′Aᵀd / l the point's own arm drops out, (A s′)ᵀA s̃′ = 0, and with it digits
    where the point is far from its origin.
    """
    forces = []
    tension = symbol(TENSION)
    for body, sign in zip(BODIES, (1, -1), strict=True):
        turning = mul(skew(SYMBOLS[f"s_{body}_b"]), transpose(A[body]), FROM_OWN_ORIGIN[body])
        arm = NamedMatrix(f"m_{body}", mul(INVERSE, turning))
        forces += [mul(sign * tension, ALONG), mul(sign * tension, arm)]
    return tuple(forces)


def _steps() -> tuple[Step, ...]:
    variation, rate = MatrixSymbol("δl", 1, 1), MatrixSymbol("l_dot", 1, 1)
    delta = mul(transpose(ALONG), DELTA(D))
    steps = [
        Step(MatrixSymbol("d", 3, 1), D.value, "vector between the points", "8.8"),
        Step(L, L.value, "its length", ""),
        Step(MatrixSymbol("n", 3, 1), ALONG.value, "its direction", ""),
        Step(variation, mul(1 / L, transpose(D), DELTA(D)), "l δl = dᵀδd", ""),
        Step(variation, delta, "n = d/l, and δA = A δθ̃′", "7.16"),
        Step(MatrixSymbol("d_dot", 3, 1), D_RATE.value, "δ → d/dt", "5.16"),
        Step(rate, mul(Dot(ALONG, D_RATE), Identity(1)), "dl/dt = nᵀ dd/dt", ""),
        Step(rate, length_rate()[1], "s·w = 0 in each body, and (x × y)·z = x·(y × z)", ""),
        Step(MatrixSymbol("T", 1, 1), mul(LAW, Identity(1)), "spring and damper, linear", ""),
        Step(MatrixSymbol("V", 1, 1), mul(ENERGY, Identity(1)), "energy of the spring", ""),
    ]
    for column, force in zip(COLUMNS, generalised_forces(), strict=True):
        left = MatrixSymbol(f"f_{column.name}", 3, 1)
        beside = neg(mul(symbol(TENSION), transpose(coefficient(delta, column.delta))))
        steps += [
            Step(left, beside, f"−T δl, coefficient of {column.delta.name}", ""),
            Step(left, force, "d resolved; (A s′)ᵀA s~′ = 0 for the point's own arm", ""),
        ]
    return tuple(steps)


def _component_length() -> Any:
    offset = point_offset()
    return sympy.sqrt(dot(offset, offset))


def _number(quantity: Quantity, expression: Any, component: Any) -> DerivedOutput:
    return output_of(quantity, mul(expression, Identity(1)), [component])


def _zero_at_pole(output: DerivedOutput) -> DerivedOutput:
    """Output that is zero where the points coincide."""
    return replace(output, at_pole=0.0)


def _length() -> Function:
    length = _component_length()
    rate, plain = length_rate()
    components = [motion_flow()(length)]
    return Function(
        "length",
        f"{TITLE}: length and its rate",
        "l = |d|, dl/dt = d·(dd/dt)/l",
        SOURCE,
        (*PLACES, *MOTION),
        (
            _zero_at_pole(_number(replace(LENGTH, shape=(1,)), L, length)),
            _zero_at_pole(
                output_of(replace(LENGTH_RATE, shape=(1,)), rate, components, (plain,)),
            ),
        ),
    )


def _law() -> Function:
    length, rate, k, c, free = (elements(q)[0] for q in LAW_INPUTS)
    energy = Quantity("V", (1,), "N m", "energy of the spring")
    return Function(
        "law",
        f"{TITLE}: tension and energy, linear",
        "T = k (l − l⁰) + c dl/dt, V = ½ k (l − l⁰)²",
        SOURCE,
        LAW_INPUTS,
        (
            _number(replace(TENSION, shape=(1,)), LAW, k * length - k * free + c * rate),
            _number(energy, ENERGY, k * (length**2 - 2 * length * free + free**2) / 2),
        ),
    )


def _force() -> Function:
    length, (tension,) = _component_length(), elements(TENSION)
    meaning = "force in frame O and torque in the body frame, of i, then of j"
    components = [-tension * flow(length) for flow in unit_flows()]
    forces = BlockMatrix([[f] for f in generalised_forces()])
    return Function(
        "force",
        f"{TITLE}: generalised force",
        "f = −T dl/d(δr, δθ′)",
        SOURCE,
        (*PLACES, TENSION),
        (
            _zero_at_pole(
                output_of(Quantity("force", (12,), "N, N m", meaning), forces, components)
            ),
        ),
    )
