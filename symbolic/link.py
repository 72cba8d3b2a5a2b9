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
from sympy.matrices.expressions import BlockMatrix, Identity
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.components import dot
from kousoku.symbolic.derivation import Derivation, Function, output_of
from kousoku.symbolic.link_element import (
    BETA_RATE,
    L0,
    L_RATE,
    LENGTH,
    OFFSET,
    X_DOT,
    L,
    X,
    jacobian,
    jacobian_rate,
)
from kousoku.symbolic.link_steps import assembly_steps, element_steps, method_steps
from kousoku.symbolic.matrices import elements, mul, neg, symbol

if TYPE_CHECKING:
    from collections.abc import Sequence


SOURCE = "Yamada and Tatsumi 1981"
TITLE = "planar link element"


def derive(package: str) -> Derivation:
    """Derivation of ``link``: ε = 0 (3,) [m] of Yamada and Tatsumi (1981), (5)–(7), D and Ḋ.

    x = (x1, y1, β1, x2, y2, β2) [m, rad] are the ends in frame O, (2); D = ∂ε/∂x (3, 6) [-, m/rad],
    (15).
    """
    return Derivation(
        name=package,
        kind="link",
        title=TITLE,
        source=SOURCE,
        steps=(*element_steps(), *assembly_steps(), *method_steps()),
        functions=(_deformation(), _rate()),
    )


def _angle_to_link(k: int, x: Sequence[Any], offset: Sequence[Any]) -> Any:
    """Angle β_k − offset_k − β in (−π, π], as the angle between two directions."""
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
            output_of(Quantity("epsilon", (3,), "m", "deformations"), epsilon, components),
            output_of(
                Quantity("D", (3, 6), "-, m/rad", "derivatives of epsilon by x"),
                jacobian(),
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
            output_of(
                Quantity("D_dot", (3, 6), "1/s, m/s/rad", "derivative of D along the motion"),
                jacobian_rate(),
                rates,
            ),
            output_of(
                Quantity("D_dot_x_dot", (3,), "m/s^2", "D_dot times x_dot"),
                BlockMatrix([[first], [second], [neg(second)]]),
                products,
            ),
        ),
    )


def _stretch() -> Any:
    x = elements(X)
    return sympy.sqrt((x[3] - x[0]) ** 2 + (x[4] - x[1]) ** 2)


def _component_jacobian() -> list[Any]:
    """Differentiate (5)–(7) with β = atan2(dy, dx); wrapping changes no derivative."""
    x = elements(X)
    beta = sympy.atan2(x[4] - x[1], x[3] - x[0])
    rows = (_stretch(), (x[2] - beta) * L0, (beta - x[5]) * L0)
    return [sympy.diff(row, coordinate) for row in rows for coordinate in x]
