"""Two bodies i and j: their arrays on both levels, and the operators δ and d/dt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sympy import S
from sympy.matrices.expressions import MatrixSymbol

from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.components import Flow, half_turn
from kousoku.symbolic.matrices import OrientationMatrix, elements, symbol, vector
from kousoku.symbolic.variation import Variation

if TYPE_CHECKING:
    from kousoku.symbolic.sympy_types import Letter

BODIES = ("i", "j")


def _of_body(body: str) -> tuple[Quantity, ...]:
    return (
        Quantity(f"r_{body}", (3,), "m", f"position of body {body}, frame O"),
        Quantity(f"p_{body}", (4,), "-", f"Euler parameters of body {body}, scalar first"),
        Quantity(f"a_{body}_b", (3,), "-", f"axis fixed in body {body}, frame of {body}"),
        Quantity(f"s_{body}_b", (3,), "m", f"point fixed in body {body}, frame of {body}"),
    )


def _motion_of_body(body: str) -> tuple[Quantity, ...]:
    return (
        Quantity(f"v_{body}", (3,), "m/s", f"velocity of the origin of body {body}, frame O"),
        Quantity(
            f"omega_{body}_b", (3,), "rad/s", f"angular velocity of body {body}, frame of {body}"
        ),
    )


CONFIGURATION = (*_of_body("i"), *_of_body("j"), Quantity("length", (), "m", "given distance"))
MOTION = (*_motion_of_body("i"), *_motion_of_body("j"))

#: Matrix-level symbols and component-level symbols of every input, by name.
SYMBOLS: dict[str, Any] = {q.name: symbol(q) for q in (*CONFIGURATION, *MOTION)}
COMPONENTS: dict[str, tuple[Any, ...]] = {q.name: elements(q) for q in (*CONFIGURATION, *MOTION)}
A = {body: OrientationMatrix(SYMBOLS[f"p_{body}"]) for body in BODIES}


@dataclass(frozen=True, slots=True)
class JacobianColumns:
    """A block of columns of a Jacobian: three coordinates of one body, as in lecture 7.1, (7.19).

    Parameters
    ----------
    name : str
        ``r_i`` or ``θ_i``.
    delta, velocity, acceleration : Letter (3, 1)
        δr [m] in frame O or δθ′ [rad] in the body frame, and its counterparts when δ is d/dt, once
        and twice: lecture 7.1, (variation-and-rate).
    """

    name: str
    delta: Letter
    velocity: Letter
    acceleration: Letter


def _column(body: str, *, is_rotation: bool) -> JacobianColumns:
    name = f"omega_{body}_b" if is_rotation else f"v_{body}"
    return JacobianColumns(
        f"θ_{body}" if is_rotation else f"r_{body}",
        vector(f"δθ_{body}_b" if is_rotation else f"δr_{body}"),
        SYMBOLS[name],
        vector(f"{name}_dot"),
    )


#: In the order of the Jacobian's columns: δr^i, δθ′^i, δr^j, δθ′^j.
COLUMNS = tuple(
    _column(body, is_rotation=is_rotation) for body in BODIES for is_rotation in (False, True)
)
TRANSLATIONS = {SYMBOLS[f"r_{body}"]: COLUMNS[2 * k].delta for k, body in enumerate(BODIES)}
#: The product rule alone: δA is not yet resolved.
PRODUCT_RULE = Variation(
    TRANSLATIONS, {SYMBOLS[f"p_{body}"]: MatrixSymbol(f"δA_{body}", 3, 3) for body in BODIES}
)
DELTA = Variation(
    TRANSLATIONS,
    {SYMBOLS[f"p_{body}"]: COLUMNS[2 * k + 1].delta for k, body in enumerate(BODIES)},
)
RATE = Variation(
    {
        **{SYMBOLS[f"r_{body}"]: SYMBOLS[f"v_{body}"] for body in BODIES},
        **{column.velocity: column.acceleration for column in COLUMNS},
    },
    {SYMBOLS[f"p_{body}"]: SYMBOLS[f"omega_{body}_b"] for body in BODIES},
)

EULER = (*COMPONENTS["p_i"], *COMPONENTS["p_j"])
SPINS = (*COMPONENTS["omega_i_b"], *COMPONENTS["omega_j_b"])


def unit_flows() -> tuple[Flow, ...]:
    """Derivatives (12,) along δr^i, δθ′^i, δr^j, δθ′^j, one for each component.

    δr [m] is in frame O, δθ′ [rad] in the body frame: δp = ½ p∘(0, δθ′), by lecture 7.1, (7.16).
    """
    flows: list[Flow] = []
    for body in BODIES:
        r, p = COMPONENTS[f"r_{body}"], COMPONENTS[f"p_{body}"]
        flows.extend(Flow({x: S.One}, EULER) for x in r)
        for k in range(3):
            theta = [S.One if k == n else S.Zero for n in range(3)]
            flows.append(Flow(dict(zip(p, half_turn(p, theta), strict=True)), EULER))
    return tuple(flows)


def motion_flow() -> Flow:
    """Time derivative [1/s] on the component level at constant v and ω′; lecture 7.1, (5.16).

    ṙ = v (3,) [m/s] in frame O, ṗ = ½ p∘(0, ω′) (4,) with ω′ [rad/s] in the body frame.
    """
    change: dict[Any, Any] = {}
    for body in BODIES:
        change.update(zip(COMPONENTS[f"r_{body}"], COMPONENTS[f"v_{body}"], strict=True))
        p = COMPONENTS[f"p_{body}"]
        change.update(zip(p, half_turn(p, COMPONENTS[f"omega_{body}_b"]), strict=True))
    return Flow(change, (*EULER, *SPINS))
