"""The steps of "three mass points": from Newton's law of each point to the 6×6 form."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sympy.matrices.expressions import BlockMatrix, Identity, MatrixSymbol, ZeroMatrix

from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.derivation import Step
from kousoku.symbolic.matrices import OrientationMatrix, add, mul, neg, skew, symbol, transpose
from kousoku.symbolic.variation import Variation, coefficient, without

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.symbolic.mass import BodyTerms
    from kousoku.symbolic.sympy_types import Scalar, SymbolicMatrix

P = Quantity("p", (4,), "-", "Euler parameters of the body, scalar first")
OMEGA_B = Quantity("omega_b", (3,), "rad/s", "angular velocity, body frame")
A = OrientationMatrix(symbol(P))
OMEGA = symbol(OMEGA_B)
R, V, ACCELERATION, OMEGA_DOT = (
    MatrixSymbol(name, 3, 1) for name in ("r", "v", "v_dot", "omega_b_dot")
)
RATE = Variation({R: V, V: ACCELERATION, OMEGA: OMEGA_DOT}, {A.p: OMEGA})
"""Time derivative, d/dt."""


def balance_steps(
    masses: Sequence[Scalar], places: Sequence[SymbolicMatrix], body: BodyTerms
) -> tuple[Step, ...]:
    """Steps from one point, (position), to the sums over all points, (moment-balance)."""
    positions = [add(R, mul(A, s)) for s in places]
    accelerations = [RATE(RATE(x)) for x in positions]
    into = transpose(A)
    pairs = list(zip(masses, accelerations, strict=True))
    momentum = add(*(mul(m, a) for m, a in pairs))
    moment = add(*(mul(m, skew(s), into, a) for (m, a), s in zip(pairs, places, strict=True)))
    return (
        *_one_point("1", positions[0]),
        *_definitions(body),
        *_collected_force(momentum, body),
        *_collected_torque(moment, body),
    )


def motion_steps(body: BodyTerms) -> tuple[Step, ...]:
    """Steps of a body given by mass, centre and inertia, up to (moment-balance)."""
    centre = add(R, mul(A, MatrixSymbol("r_AG_b", 3, 1)))
    momentum = mul(body.mass, RATE(RATE(centre)))
    left = MatrixSymbol("H_dot", 3, 1)
    why = "as for mass points, whose sums these are: equals N′"
    return (
        *_one_point("G", centre),
        *_collected_force(momentum, body),
        Step(left, _torque(body), why, "moment-balance"),
    )


def _one_point(name: str, position: SymbolicMatrix) -> tuple[Step, ...]:
    acceleration = RATE(RATE(position))
    unknowns = ACCELERATION, OMEGA_DOT
    linear, angular = (mul(coefficient(acceleration, x), x) for x in unknowns)
    left = MatrixSymbol(f"a_{name}", 3, 1)
    return (
        Step(MatrixSymbol(f"r_{name}", 3, 1), position, "a point fixed in frame A", "position"),
        Step(
            MatrixSymbol(f"v_{name}", 3, 1), RATE(position), "d/dt, dA/dt = A ω′~", "velocity, 5.16"
        ),
        Step(left, acceleration, "d/dt once more", "acceleration, 5.16"),
        Step(
            left,
            add(linear, angular, without(acceleration, *unknowns)),
            "u~ v = −v~ u: collected",
            "swapped-velocity",
        ),
    )


def _definitions(body: BodyTerms) -> tuple[Step, ...]:
    return (
        Step(body.mass, body.mass.value, "total mass", "total-mass"),
        Step(
            MatrixSymbol("c", 3, 1), body.moment.value, "first moment, mass r_AG", "centre-of-mass"
        ),
        Step(
            MatrixSymbol("I_A", 3, 3), body.inertia.value, "J_k = s′_k~ᵀ s′_k~: inertia", "inertia"
        ),
        Step(
            MatrixSymbol("F", 3, 1),
            body.force.value,
            "internal forces cancel in pairs",
            "total-force",
        ),
        Step(
            MatrixSymbol("N_b", 3, 1),
            body.torque.value,
            "and so do their torques",
            "torque-definition",
        ),
        *_second_moment(body),
    )


def _second_moment(body: BodyTerms) -> tuple[Step, ...]:
    if body.second is None:
        return ()
    rule = "second moment: I_A = tr(K) I − K, so that ω′~ I_A ω′ = −ω′~ K ω′"
    return (Step(MatrixSymbol("K", 3, 3), body.second.value, rule, ""),)


def _collected_force(momentum: SymbolicMatrix, body: BodyTerms) -> tuple[Step, ...]:
    arm, spin = skew(body.moment), skew(OMEGA)
    left = MatrixSymbol("P_dot", 3, 1)
    collected = add(
        mul(body.mass, ACCELERATION),
        neg(mul(A, arm, OMEGA_DOT)),
        mul(A, spin, spin, body.moment),
    )
    turned = add(
        mul(body.mass, ACCELERATION),
        neg(mul(A, arm, OMEGA_DOT)),
        neg(mul(A, spin, arm, OMEGA)),
    )
    return (
        Step(left, momentum, "Newton, summed over all that moves: equals F", "force-sum"),
        Step(left, collected, "with the total mass and the first moment", ""),
        Step(left, turned, "ω′~ c = −c~ ω′", "summary-force-balance"),
    )


def _collected_torque(moment: SymbolicMatrix, body: BodyTerms) -> tuple[Step, ...]:
    left = MatrixSymbol("H_dot", 3, 1)
    return (
        Step(left, moment, "times s′_k~ Aᵀ and summed: equals N′", "moment-sum"),
        Step(left, _torque(body), "AᵀA = I and s~ ω~ ω~ s = ω~ s~ᵀ s~ ω", "moment-balance"),
    )


def _torque(body: BodyTerms) -> SymbolicMatrix:
    """Torque N′ = c~ Aᵀ r̈ + I_A ω̇′ + ω′~ I_A ω′ (3, 1) [N m], in the body frame."""
    return add(
        mul(skew(body.moment), transpose(A), ACCELERATION),
        mul(body.inertia, OMEGA_DOT),
        mul(skew(OMEGA), body.inertia, OMEGA),
    )


def reduction_steps(
    mass: Scalar, inertia: SymbolicMatrix, force: SymbolicMatrix, torque: SymbolicMatrix
) -> tuple[Step, ...]:
    """Steps to the form where the origin is the centre of mass, r_AG = 0: (reduced-matrix-form)."""
    zero = ZeroMatrix(3, 3)
    return (
        Step(
            MatrixSymbol("M_G", 6, 6),
            BlockMatrix([[mul(mass, Identity(3)), zero], [zero, inertia]]),
            "r_AG = 0: force and torque part",
            "reduced-matrix-form",
        ),
        Step(
            MatrixSymbol("h_G", 6, 1),
            BlockMatrix([[force], [add(torque, neg(mul(skew(OMEGA), inertia, OMEGA)))]]),
            "r_AG = 0: Newton-Euler",
            "reduced-matrix-form",
        ),
    )
