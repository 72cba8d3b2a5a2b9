"""From a constraint between two bodies to all that a solver needs of it, on both levels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sympy import S, Symbol
from sympy.matrices.expressions import BlockMatrix, MatrixSymbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.errors import DerivationError
from kousoku.model.quantity import Quantity
from kousoku.symbolic.bodies import (
    COLUMNS,
    CONFIGURATION,
    DELTA,
    MOTION,
    PRODUCT_RULE,
    RATE,
    motion_flow,
    unit_flows,
)
from kousoku.symbolic.derivation import Derivation, Function, Output, Step
from kousoku.symbolic.matrices import (
    Matrix,
    Named,
    add,
    coefficient_and_factors,
    elements,
    is_zero,
    mul,
    neg,
    symbol,
    transpose,
)
from kousoku.symbolic.variation import abbreviate, coefficient, orthogonality, rewrite, without

if TYPE_CHECKING:
    from collections.abc import Sequence


@dataclass(frozen=True, slots=True)
class Constraint:
    """A constraint equation C = 0 between bodies i and j, on both levels.

    Parameters
    ----------
    name, kind, title, source, formula : str
        As in :class:`kousoku.symbolic.derivation.Derivation` and ``Function``.
    unit : str
        Unit of C: ``m``, or ``-`` where C is a product of axes.
    steps : tuple of Step
        From the lecture's equation to ``value``.
    value : Matrix
        C, a column.
    components : tuple of sympy.Expr
        C as polynomials of the input components.
    names : tuple of Named
        What ``value`` abbreviates.
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
    names: tuple[Named, ...] = ()

    @property
    def lam(self) -> Quantity:
        """The multipliers, dual to C."""
        unit = "N" if self.unit == "m" else "N m"
        return Quantity("lam", (len(self.components),), unit, "multipliers, one for each row of C")


@dataclass(frozen=True, slots=True)
class Forms:
    """The matrix level of a constraint, collected.

    Parameters
    ----------
    variation, rate, acceleration : Matrix
        δC, Ċ and C̈ as the product rule leaves them.
    jacobian : tuple of Matrix
        The coefficients of δr^i, δθ′^i, δr^j, δθ′^j.
    nu, gamma : Matrix
        Ċ = C_q v − ν and C̈ = C_q v̇ − γ.
    reaction : tuple of Matrix
        The blocks of C_qᵀλ.
    stiffness : tuple of tuple of Matrix
        For each block of the reaction its coefficients of δr^i, δθ′^i, δr^j, δθ′^j.
    """

    variation: Matrix
    rate: Matrix
    acceleration: Matrix
    jacobian: tuple[Matrix, ...]
    nu: Matrix
    gamma: Matrix
    reaction: tuple[Matrix, ...]
    stiffness: tuple[tuple[Matrix, ...], ...]


def collect(c: Constraint) -> Forms:
    """Apply δ and d/dt to a constraint and collect the linear forms.

    Raises
    ------
    DerivationError
        Ċ or C̈ has other coefficients than δC.
    """

    def blocks(x: Matrix, symbols: Sequence[Matrix]) -> tuple[Matrix, ...]:
        collected = (coefficient(x, symbol) for symbol in symbols)
        return tuple(abbreviate(rewrite(block, orthogonality), *c.names) for block in collected)

    variation, rate = DELTA(c.value), RATE(c.value)
    acceleration = RATE(rate)
    jacobian = blocks(variation, [column.delta for column in COLUMNS])
    velocities = [column.velocity for column in COLUMNS]
    accelerations = [column.acceleration for column in COLUMNS]
    for form, symbols in ((rate, velocities), (acceleration, accelerations)):
        if blocks(form, symbols) != jacobian:
            raise DerivationError(f"{c.name}: the coefficients of {form} are not the Jacobian")
    reaction = tuple(_weighted(block, symbol(c.lam)) for block in jacobian)
    return Forms(
        variation,
        rate,
        acceleration,
        jacobian,
        neg(without(rate, *velocities)),
        abbreviate(neg(without(acceleration, *accelerations)), *c.names),
        reaction,
        tuple(blocks(DELTA(f), [column.delta for column in COLUMNS]) for f in reaction),
    )


def _weighted(block: Matrix, lam: Matrix) -> Matrix:
    """Return blockᵀ λ; a single multiplier is a number and goes to the vector on the right."""
    if lam.shape[0] > 1 or is_zero(block):
        return mul(transpose(block), lam)
    scalar, factors = coefficient_and_factors(transpose(block))
    sign = -1 if scalar.could_extract_minus_sign() else 1
    weighted = Named("b", mul(sign * scalar * lam[0, 0], factors[-1]))
    return mul(sign, *factors[:-1], weighted)


def derive_constraint(c: Constraint) -> Derivation:
    """Return all that is derived of a constraint: Jacobian, right-hand sides, reaction."""
    forms = collect(c)
    return Derivation(
        name=c.name,
        kind=c.kind,
        title=c.title,
        source=c.source,
        steps=(*c.steps, *_jacobian_steps(c, forms), *_rate_steps(c, forms), *_force_steps(forms)),
        functions=_functions(c, forms),
    )


def _jacobian_steps(c: Constraint, forms: Forms) -> tuple[Step, ...]:
    left = MatrixSymbol("δC", *c.value.shape)
    form = add(*(mul(block, x.delta) for block, x in zip(forms.jacobian, COLUMNS, strict=True)))
    blocks = (
        Step(_block("C", x.name, block), block, f"coefficient of {_spoken(x.name)}", "")
        for block, x in zip(forms.jacobian, COLUMNS, strict=True)
    )
    return (
        Step(left, PRODUCT_RULE(c.value), "product rule; a′ and s′ are constant", "7.10"),
        Step(left, forms.variation, "δA = A δθ′~", "7.16"),
        Step(left, form, "u~ v = −v~ u, a number is its own transpose; collected", "7.19"),
        *blocks,
    )


def _rate_steps(c: Constraint, forms: Forms) -> tuple[Step, ...]:
    rate, acceleration = (MatrixSymbol(f"C_{dots}", *c.value.shape) for dots in ("dot", "ddot"))
    form = add(*(mul(block, x.velocity) for block, x in zip(forms.jacobian, COLUMNS, strict=True)))
    return (
        Step(rate, forms.rate, "δ → d/dt: dA/dt = A ω′~", "5.16"),
        Step(rate, form, "collected: the coefficients are the Jacobian", "7.19"),
        Step(
            MatrixSymbol("nu", *c.value.shape),
            forms.nu,
            "dC/dt = C_q v − ν: minus what is left without velocities",
            "",
        ),
        Step(acceleration, forms.acceleration, "d/dt once more", "5.16"),
        Step(
            MatrixSymbol("gamma", *c.value.shape),
            forms.gamma,
            "d²C/dt² = C_q dv/dt − γ: minus what is left without accelerations",
            "",
        ),
    )


def _force_steps(forms: Forms) -> tuple[Step, ...]:
    weighted = next(
        (name for f in forms.reaction for name in f.atoms(Named) if name.name == "b"), None
    )
    steps = []
    if weighted is not None:
        text = "abbreviation: the vector times its multiplier"
        steps.append(Step(_block("b", "", weighted), weighted.value, text, ""))
    for f, x, row in zip(forms.reaction, COLUMNS, forms.stiffness, strict=True):
        steps.append(
            Step(_block("f", x.name, f), f, f"block of C_qᵀλ dual to {_spoken(x.name)}", "")
        )
        steps.extend(
            Step(
                _block("f", f"{x.name},{y.name}", block),
                block,
                f"δ at fixed λ, coefficient of {_spoken(y.name)}",
                "7.16",
            )
            for block, y in zip(row, COLUMNS, strict=True)
            if not is_zero(block)
        )
    return tuple(steps)


def _block(letter: str, name: str, block: Matrix) -> Matrix:
    return MatrixSymbol(f"{letter}_{name}" if name else letter, *block.shape)


def _spoken(name: str) -> str:
    kind, body = name.split("_")
    return f"δ{kind}{'′' * (kind == 'θ')}_{body}"


def _functions(c: Constraint, forms: Forms) -> tuple[Function, ...]:
    lam, m = c.lam, len(c.components)
    flows, motion = unit_flows(), motion_flow()
    jacobian = [flow(x) for x in c.components for flow in flows]
    reaction = [
        sum((factor * x for factor, x in zip(elements(lam), jacobian[k::12], strict=True)), S.Zero)
        for k in range(12)
    ]
    is_length = c.unit == "m"
    rate_unit = "m" if is_length else "1"

    def output(quantity: Quantity, x: Matrix, scalars: Sequence[Any]) -> Output:
        return Output(quantity, x, ImmutableDenseMatrix(len(scalars), 1, list(scalars)))

    constraint = (
        output(Quantity("C", (m,), c.unit, "constraint"), c.value, c.components),
        output(
            Quantity(
                "C_q",
                (m, 12),
                "-, m" if is_length else "1/m, -",
                "Jacobian; columns δr_i, δθ′_i, δr_j, δθ′_j",
            ),
            BlockMatrix([list(forms.jacobian)]),
            jacobian,
        ),
    )
    rates = (
        output(
            Quantity("nu", (m,), f"{rate_unit}/s", "dC/dt = C_q v − nu"), forms.nu, [S.Zero] * m
        ),
        output(
            Quantity("gamma", (m,), f"{rate_unit}/s^2", "d²C/dt² = C_q dv/dt − gamma"),
            forms.gamma,
            [-motion(motion(x)) for x in c.components],
        ),
    )
    forces = (
        output(
            Quantity(
                "reaction",
                (12,),
                "N, N m",
                "C_qᵀλ: force in frame O and torque in the body frame, of i, then of j",
            ),
            BlockMatrix([[f] for f in forms.reaction]),
            reaction,
        ),
        output(
            Quantity(
                "reaction_q",
                (12, 12),
                "N/m, N, N m",
                "(C_qᵀλ)_q at fixed λ; columns δr_i, δθ′_i, δr_j, δθ′_j",
            ),
            BlockMatrix([list(row) for row in forms.stiffness]),
            [flow(f) for f in reaction for flow in flows],
        ),
    )
    return (
        _function(c, "constraint", "constraint and Jacobian", c.formula, constraint),
        _function(
            c, "rates", "right-hand sides", "dC/dt = C_q v − nu, d²C/dt² = C_q dv/dt − gamma", rates
        ),
        _function(c, "reaction", "reaction and its derivative", "C_qᵀλ and (C_qᵀλ)_q", forces, lam),
    )


def _function(
    c: Constraint,
    name: str,
    title: str,
    formula: str,
    outputs: tuple[Output, ...],
    *extra: Quantity,
) -> Function:
    used = {
        str(atom.name)
        for output in outputs
        for atom in output.expression.atoms(Symbol, MatrixSymbol)
    }
    inputs = tuple(q for q in (*CONFIGURATION, *MOTION) if q.name in used)
    return Function(name, f"{c.title}: {title}", formula, c.source, (*inputs, *extra), outputs)
