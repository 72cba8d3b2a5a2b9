"""A constraint on the matrix level: δ and d/dt applied, linear forms collected, line by line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sympy import postorder_traversal
from sympy.matrices.expressions import MatrixSymbol

from kousoku.model.errors import DerivationError
from kousoku.model.quantity import Quantity
from kousoku.symbolic.bodies import COLUMNS, DELTA, PRODUCT_RULE, RATE
from kousoku.symbolic.derivation import Step
from kousoku.symbolic.matrices import (
    Matrix,
    Named,
    add,
    coefficient_and_factors,
    is_zero,
    mul,
    neg,
    symbol,
    transpose,
)
from kousoku.symbolic.variation import abbreviate, coefficient, orthogonality, rewrite, without

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


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
    rule : callable, optional
        A rewriting of products that holds for this constraint, applied to the Jacobian blocks.
    gamma : Step, optional
        γ in a form that keeps more digits than what the product rule leaves, and why it is equal.
    inputs : tuple of Quantity
        What the constraint takes beside the arrays of both bodies, e.g. a given angle; constant in
        time. ``symbolic.matrices`` gives the ``symbol`` and the ``elements`` of each.
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
    rule: Callable[[Matrix], Matrix | None] = orthogonality
    gamma: Step | None = None
    inputs: tuple[Quantity, ...] = ()

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
        square = (rewrite(block, orthogonality) for block in collected)
        return tuple(abbreviate(rewrite(block, c.rule), *c.names) for block in square)

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
    vector = factors[-1]
    suffix = vector.name[1:] if isinstance(vector, Named) and vector.name.startswith("d_") else ""
    weighted = Named(f"b{suffix}", mul(sign * scalar * lam[0, 0], vector))
    return mul(sign, *factors[:-1], weighted)


def steps(c: Constraint, forms: Forms) -> tuple[Step, ...]:
    """Return the steps from C to its Jacobian, right-hand sides, reaction and its derivative."""
    return (*_jacobian_steps(c, forms), *_rate_steps(c, forms), *_force_steps(forms))


def with_abbreviations(lines: Sequence[Step]) -> tuple[Step, ...]:
    """Return the steps, each name that none of them defines written out before its first use."""
    defined = {step.left.name for step in lines if isinstance(step.left, MatrixSymbol)}
    complete: list[Step] = []
    for step in lines:
        for x in postorder_traversal(step.right):
            if isinstance(x, Named) and x.name not in defined:
                defined.add(x.name)
                left = MatrixSymbol(x.name, *x.shape)
                complete.append(Step(left, x.value, "abbreviation", ""))
        complete.append(step)
    return tuple(complete)


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
        *(() if c.gamma is None else (c.gamma,)),
    )


def _force_steps(forms: Forms) -> tuple[Step, ...]:
    weighted = dict.fromkeys(
        factor
        for f in forms.reaction
        for factor in coefficient_and_factors(f)[1]
        if isinstance(factor, Named) and factor.name[0] == "b"
    )
    text = "abbreviation: the vector times its multiplier"
    steps = [Step(_block(*_letter_and_index(b.name), b), b.value, text, "") for b in weighted]
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


def _letter_and_index(name: str) -> tuple[str, str]:
    letter, _, index = name.partition("_")
    return letter, index


def _spoken(name: str) -> str:
    kind, body = name.split("_")
    return f"δ{kind}{'′' * (kind == 'θ')}_{body}"
