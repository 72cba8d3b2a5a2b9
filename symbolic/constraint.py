"""From a constraint between two bodies to all that a solver needs of it, on both levels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sympy import S
from sympy.matrices.expressions import BlockMatrix, ZeroMatrix
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.quantity import Quantity
from kousoku.symbolic.components import Flow, half_turn
from kousoku.symbolic.derivation import Derivation, Function, Output, Step
from kousoku.symbolic.matrices import (
    Matrix,
    Orientation,
    elements,
    mul,
    neg,
    symbol,
    transpose,
    vector,
)
from kousoku.symbolic.variation import Variation, coefficient, without

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

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
A = {body: Orientation(SYMBOLS[f"p_{body}"]) for body in BODIES}


@dataclass(frozen=True, slots=True)
class Constraint:
    """A constraint equation C = 0 between bodies i and j, on both levels.

    Parameters
    ----------
    name, kind, title, source, formula : str
        As in :class:`kousoku.symbolic.derivation.Derivation` and ``Function``.
    unit : str
        Unit of C.
    steps : tuple of Step
        From the lecture's equation to ``value``.
    value : Matrix
        C, a column.
    components : tuple of sympy.Expr
        C as polynomials of the input components.
    """

    name: str
    kind: str
    title: str
    source: str
    formula: str
    unit: str
    steps: tuple[Step, ...]
    value: Matrix
    components: tuple[Any, ...]

    @property
    def n_rows(self) -> int:
        """Count of equations."""
        return len(self.components)


COLUMNS = tuple(
    (f"{kind}_{body}", vector(f"δr_{body}" if kind == "r" else f"δθ_{body}_b"), quantity)
    for body in BODIES
    for kind, quantity in (("r", f"v_{body}"), ("θ", f"omega_{body}_b"))
)
DELTA = Variation(
    {SYMBOLS["r_i"]: COLUMNS[0][1], SYMBOLS["r_j"]: COLUMNS[2][1]},
    {SYMBOLS["p_i"]: COLUMNS[1][1], SYMBOLS["p_j"]: COLUMNS[3][1]},
)
ACCELERATIONS = tuple(vector(f"{name}_dot") for _, _, name in COLUMNS)
RATE = Variation(
    {
        SYMBOLS["r_i"]: SYMBOLS["v_i"],
        SYMBOLS["r_j"]: SYMBOLS["v_j"],
        **{SYMBOLS[name]: dot for (_, _, name), dot in zip(COLUMNS, ACCELERATIONS, strict=True)},
    },
    {SYMBOLS["p_i"]: SYMBOLS["omega_i_b"], SYMBOLS["p_j"]: SYMBOLS["omega_j_b"]},
)


def derive_constraint(c: Constraint) -> Derivation:
    """Return all that is derived of a constraint: Jacobian, right-hand sides, reaction."""
    blocks = [coefficient(DELTA(c.value), delta) for _, delta, _ in COLUMNS]
    jacobian = BlockMatrix([blocks])
    acceleration = RATE(RATE(c.value))
    gamma = neg(without(acceleration, *ACCELERATIONS))
    lam = Quantity("lam", (c.n_rows,), "N", "multipliers, one for each row of C")
    reaction = [mul(transpose(block), symbol(lam)) for block in blocks]
    stiffness = [[coefficient(DELTA(f), delta) for _, delta, _ in COLUMNS] for f in reaction]
    scalars = _Components(c, elements(lam))
    m = c.n_rows
    constraint = _function(
        c,
        "constraint",
        "constraint and Jacobian",
        (
            Output(Quantity("C", (m,), c.unit, "constraint"), c.value, _column(c.components)),
            Output(
                Quantity("C_q", (m, 12), c.unit, "Jacobian"), jacobian, _column(scalars.jacobian)
            ),
        ),
    )
    rates = _function(
        c,
        "rates",
        "right-hand sides",
        (
            Output(
                Quantity("nu", (m,), f"{c.unit}/s", "velocity right-hand side"),
                ZeroMatrix(m, 1),
                _column([S.Zero] * m),
            ),
            Output(
                Quantity("gamma", (m,), f"{c.unit}/s^2", "acceleration right-hand side"),
                gamma,
                _column(scalars.gamma),
            ),
        ),
    )
    reactions = _function(
        c,
        "reaction",
        "reaction and its derivative",
        (
            Output(
                Quantity("reaction", (12,), "N, N m", "C_q^T lam"),
                BlockMatrix([[f] for f in reaction]),
                _column(scalars.reaction),
            ),
            Output(
                Quantity("reaction_q", (12, 12), "N/m, N, N m", "derivative at fixed lam"),
                BlockMatrix(stiffness),
                _column(scalars.reaction_q),
            ),
        ),
        lam,
    )
    return Derivation(
        name=c.name,
        kind=c.kind,
        title=c.title,
        source=c.source,
        steps=c.steps,
        functions=(constraint, rates, reactions),
    )


def _column(values: Sequence[Any]) -> ImmutableDenseMatrix:
    return ImmutableDenseMatrix(len(values), 1, list(values))


def _function(
    c: Constraint, name: str, title: str, outputs: tuple[Output, ...], *extra: Quantity
) -> Function:
    used = {
        str(atom.name)
        for output in outputs
        for atom in output.expression.atoms(type(SYMBOLS["length"]), type(SYMBOLS["r_i"]))
    }
    inputs = tuple(q for q in (*CONFIGURATION, *MOTION) if q.name in used)
    return Function(name, f"{c.title}: {title}", c.formula, c.source, (*inputs, *extra), outputs)


class _Components:
    """The outputs of a constraint by differentiating its polynomial."""

    def __init__(self, c: Constraint, lam: Sequence[Any]) -> None:
        self._c = c
        small = [*COMPONENTS["p_i"], *COMPONENTS["p_j"]]
        units: list[dict[Any, Any]] = []
        for body in BODIES:
            r, p = COMPONENTS[f"r_{body}"], COMPONENTS[f"p_{body}"]
            units.extend({r[k]: S.One} for k in range(3))
            for k in range(3):
                theta = [S.One if k == n else S.Zero for n in range(3)]
                units.append(dict(zip(p, half_turn(p, theta), strict=True)))
        flows = [Flow(unit, small) for unit in units]
        rows = [[flow(x) for flow in flows] for x in c.components]
        self.jacobian = [value for row in rows for value in row]
        self.reaction = [
            sum((lam[m] * rows[m][k] for m in range(c.n_rows)), S.Zero) for k in range(12)
        ]
        self.reaction_q = [flow(f) for f in self.reaction for flow in flows]
        motion = Flow(_motion(), [*small, *COMPONENTS["omega_i_b"], *COMPONENTS["omega_j_b"]])
        self.velocity = [motion(x) for x in c.components]
        self.gamma = [-motion(x) for x in self.velocity]


def _motion() -> Mapping[Any, Any]:
    change: dict[Any, Any] = {}
    for body in BODIES:
        change.update(zip(COMPONENTS[f"r_{body}"], COMPONENTS[f"v_{body}"], strict=True))
        p = COMPONENTS[f"p_{body}"]
        change.update(zip(p, half_turn(p, COMPONENTS[f"omega_{body}_b"]), strict=True))
    return change
