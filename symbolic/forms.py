"""A constraint on the matrix level: δ and d/dt applied, linear forms collected, line by line."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from sympy import postorder_traversal
from sympy.matrices.expressions import MatrixSymbol

from kousoku.model.errors import DerivationError
from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.bodies import COLUMNS, DELTA, PRODUCT_RULE, RATE
from kousoku.symbolic.derivation import Step
from kousoku.symbolic.matrices import (
    NamedMatrix,
    add,
    coefficient_and_factors,
    is_zero,
    mul,
    neg,
    symbol,
    transpose,
)
from kousoku.symbolic.sympy_types import as_matrix
from kousoku.symbolic.variation import abbreviate, coefficient, orthogonality, rewrite, without

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.symbolic.bodies import JacobianColumns
    from kousoku.symbolic.sympy_types import SymbolicMatrix

VARIATIONS = tuple(column.delta for column in COLUMNS)


@dataclass(frozen=True, slots=True)
class Plain:
    """The chain rule, in the polynomials that a value is a function of, each with a name.

    Both levels have these in common: nothing needs to be multiplied out.

    Parameters
    ----------
    jacobian, second
        As of :class:`ClosedForm`: columns δr [m] in frame O, δθ′ [rad] in the body frame.
    gamma : SymbolicMatrix (1, 1)
        γ of C̈ = C_q v̇ − γ [unit of C/s²].
    """

    jacobian: tuple[SymbolicMatrix, ...]
    second: tuple[tuple[SymbolicMatrix, ...], ...]
    gamma: SymbolicMatrix


@dataclass(frozen=True, slots=True)
class ClosedForm:
    """Short forms of the derivatives of a value that is no polynomial.

    The result of the product rule is longer, and loses digits. The multiplier comes last in the
    reaction, so that no number is rounded to a subnormal one and then multiplied.

    Parameters
    ----------
    jacobian : tuple of SymbolicMatrix (1, 3)
        The coefficients of δr^i, δθ′^i, δr^j, δθ′^j in δC = C_q δq: δr [m] in frame O, δθ′ [rad] in
        the body frame.
    second : tuple of tuple of SymbolicMatrix (3, 3)
        δ of each of them, transposed, by the same four.
    rules : tuple of str
        Why the Jacobian equals the coefficients of δC; the rule of its variation.
    plain : Plain
        Longer forms that prove these.
    lines : tuple of Step
        Steps on the way to γ.
    through : tuple of SymbolicMatrix (1, 1)
        Forms between γ and its plain one.
    """

    jacobian: tuple[SymbolicMatrix, ...]
    second: tuple[tuple[SymbolicMatrix, ...], ...]
    rules: tuple[str, str]
    plain: Plain
    lines: tuple[Step, ...]
    through: tuple[SymbolicMatrix, ...] = ()


@dataclass(frozen=True, slots=True)
class Constraint:
    """A constraint equation C = 0 (m,) between bodies i and j, on both levels.

    It is of positions r (3,) [m] in frame O, Euler parameters p (4,) and vectors in the body
    frames.

    Parameters
    ----------
    name, kind, title, source, formula : str
        As in :class:`kousoku.symbolic.derivation.Derivation` and ``Function``.
    unit : str
        Unit of C: ``m``, or ``-`` where C is a product of axes.
    steps : tuple of Step
        From the lecture's equation to ``value``.
    value : SymbolicMatrix (m, 1)
        C, a column.
    components : tuple of sympy.Expr, (m,)
        C as polynomials of the input components.
    names : tuple of NamedMatrix
        Abbreviations that the derivatives of ``value`` are written with.
    rule : callable, optional
        A rewriting of products that holds for this constraint, applied to the Jacobian blocks.
    gamma : Step, optional
        γ of C̈ = C_q v̇ − γ in a form that loses fewer digits than the result of the product rule,
        and why it is equal.
    inputs : tuple of Quantity
        Inputs of the constraint beside the arrays of both bodies, e.g. a given angle; constant in
        time. ``symbolic.matrices`` gives the ``symbol`` and the ``elements`` of each.
    closed : ClosedForm, optional
        Of a value that is no polynomial: the forms of its derivatives that are emitted.
    at_pole : mapping of str to float
        By output, as :attr:`kousoku.symbolic.derivation.DerivedOutput.at_pole`.
    """

    name: str
    kind: str
    title: str
    source: str
    formula: str
    unit: str
    steps: tuple[Step, ...]
    value: SymbolicMatrix
    components: tuple[Any, ...]
    names: tuple[NamedMatrix, ...] = ()
    rule: Callable[[SymbolicMatrix], SymbolicMatrix | None] = orthogonality
    gamma: Step | None = None
    inputs: tuple[Quantity, ...] = ()
    closed: ClosedForm | None = None
    at_pole: Mapping[str, float] = field(default_factory=dict)

    @property
    def lam(self) -> Quantity:
        """The multipliers λ (m,) [N or N m], dual to C: λᵀδC is work, and C_qᵀλ the reaction."""
        unit = "N" if self.unit == "m" else "N m"
        return Quantity("lam", (len(self.components),), unit, "multipliers, one for each row of C")


@dataclass(frozen=True, slots=True)
class Forms:
    """The matrix level of a constraint, collected: δr [m] in frame O, δθ′ [rad] in the body frame.

    Parameters
    ----------
    variation, rate, acceleration : SymbolicMatrix (m, 1)
        δC, Ċ and C̈ as the product rule leaves them.
    collected, jacobian : tuple of SymbolicMatrix (m, 3)
        The coefficients of δr^i, δθ′^i, δr^j, δθ′^j, as collected and as emitted.
    nu, gamma : SymbolicMatrix (m, 1)
        Ċ = C_q v − ν [unit of C/s] and C̈ = C_q v̇ − γ [unit of C/s²].
    reaction : tuple of SymbolicMatrix (3, 1)
        The blocks of C_qᵀλ: force [N] in frame O and torque [N m] in the body frame, of i, then of
        j.
    stiffness : tuple of tuple of SymbolicMatrix (3, 3)
        For each block of the reaction its coefficients of δr^i, δθ′^i, δr^j, δθ′^j.
    """

    variation: SymbolicMatrix
    rate: SymbolicMatrix
    acceleration: SymbolicMatrix
    collected: tuple[SymbolicMatrix, ...]
    jacobian: tuple[SymbolicMatrix, ...]
    nu: SymbolicMatrix
    gamma: SymbolicMatrix
    reaction: tuple[SymbolicMatrix, ...]
    stiffness: tuple[tuple[SymbolicMatrix, ...], ...]


def collect(c: Constraint) -> Forms:
    """Linear forms of a constraint: δ and d/dt applied to it, their coefficients collected.

    δC = C_q δq, Ċ = C_q v − ν and C̈ = C_q v̇ − γ by the product rule and lecture 7.1, (7.16) and
    (5.16); C_q in blocks (m, 3) by δr [m] in frame O and δθ′ [rad] in the body frame.

    Raises
    ------
    DerivationError
        Ċ or C̈ has other coefficients than δC.
    """
    variation, rate = DELTA(c.value), RATE(c.value)
    acceleration = RATE(rate)
    collected = blocks_of(variation, c.rule, c.names)
    velocities = [column.velocity for column in COLUMNS]
    accelerations = [column.acceleration for column in COLUMNS]
    for form, symbols in ((rate, velocities), (acceleration, accelerations)):
        if blocks_of(form, c.rule, c.names, symbols) != collected:
            raise DerivationError(f"{c.name}: the coefficients of {form} are not the Jacobian")
    reaction = _reaction(c, collected)
    return Forms(
        variation,
        rate,
        acceleration,
        collected,
        collected if c.closed is None else c.closed.jacobian,
        neg(without(rate, *velocities)),
        abbreviate(neg(without(acceleration, *accelerations)), *c.names),
        reaction,
        _stiffness(c, reaction),
    )


def _reaction(c: Constraint, jacobian: Sequence[SymbolicMatrix]) -> tuple[SymbolicMatrix, ...]:
    if c.closed is None:
        known: dict[str, SymbolicMatrix] = {}
        return tuple(_weighted(block, symbol(c.lam), known) for block in jacobian)
    factor = symbol(c.lam)[0, 0]
    return tuple(mul(factor, transpose(block)) for block in c.closed.jacobian)


def _stiffness(
    c: Constraint, reaction: Sequence[SymbolicMatrix]
) -> tuple[tuple[SymbolicMatrix, ...], ...]:
    if c.closed is None:
        return tuple(blocks_of(DELTA(f), c.rule, c.names) for f in reaction)
    factor = symbol(c.lam)[0, 0]
    return tuple(tuple(mul(factor, block) for block in line) for line in c.closed.second)


def blocks_of(
    x: SymbolicMatrix,
    rule: Callable[[SymbolicMatrix], SymbolicMatrix | None] = orthogonality,
    names: Sequence[NamedMatrix] = (),
    symbols: Sequence[SymbolicMatrix] = VARIATIONS,
) -> tuple[SymbolicMatrix, ...]:
    """Coefficients of ``symbols`` in a linear form, rewritten and abbreviated."""
    collected = (coefficient(x, symbol) for symbol in symbols)
    square = (rewrite(block, orthogonality) for block in collected)
    return tuple(abbreviate(rewrite(block, rule), *names) for block in square)


def curvature(x: SymbolicMatrix) -> SymbolicMatrix:
    """Second rate d²x/dt² (n, 1) without accelerations, as the product rule leaves it.

    Of C it is −γ [unit of C/s²], in the frame of x, at v [m/s] in frame O and ω′ [rad/s] in the
    body frame.
    """
    return without(RATE(RATE(x)), *(column.acceleration for column in COLUMNS))


def name_blocks(letter: str, blocks: Sequence[SymbolicMatrix]) -> tuple[SymbolicMatrix, ...]:
    """Blocks of a row, each that is not zero with a name of its own."""
    return tuple(
        block if is_zero(block) else NamedMatrix(f"{letter}_{_index(x)}", block)
        for block, x in zip(blocks, COLUMNS, strict=True)
    )


def name_lines(
    letter: str, lines: Sequence[Sequence[SymbolicMatrix]]
) -> tuple[tuple[SymbolicMatrix, ...], ...]:
    """Blocks of a second derivative, each that is not zero with a name of its own."""
    return tuple(
        name_blocks(f"{letter}_{_index(x)}", line) for x, line in zip(COLUMNS, lines, strict=True)
    )


def less_products(
    second: Sequence[Sequence[SymbolicMatrix]],
    *rows: tuple[Sequence[SymbolicMatrix], Sequence[SymbolicMatrix]],
) -> tuple[tuple[SymbolicMatrix, ...], ...]:
    """Second derivative less the products uᵀv of the rows u and v."""
    return tuple(
        tuple(
            add(block, *(neg(mul(transpose(u[m]), v[n])) for u, v in rows))
            for n, block in enumerate(line)
        )
        for m, line in enumerate(second)
    )


def _index(column: JacobianColumns) -> str:
    return column.name.replace("θ", "theta")


def _weighted(
    block: SymbolicMatrix, lam: SymbolicMatrix, named_vectors: dict[str, SymbolicMatrix]
) -> SymbolicMatrix:
    """Product blockᵀ λ; a single multiplier is a number and goes to the vector on the right.

    Such vectors are added to ``named_vectors`` by name: another vector gets another name.
    """
    if lam.shape[0] > 1 or is_zero(block):
        return mul(transpose(block), lam)
    scalar, factors = coefficient_and_factors(transpose(block))
    sign = -1 if scalar.could_extract_minus_sign() else 1
    vector = factors[-1]
    suffix = (
        vector.name[1:] if isinstance(vector, NamedMatrix) and vector.name.startswith("d_") else ""
    )
    value = mul(sign * scalar * lam[0, 0], vector)
    names = (f"b{suffix}", *(f"b_{number}" for number in range(2, len(COLUMNS) + 2)))
    name = next(name for name in names if named_vectors.setdefault(name, value) == value)
    return mul(sign, *factors[:-1], NamedMatrix(name, value))


def steps(c: Constraint, forms: Forms) -> tuple[Step, ...]:
    """Steps from C to its Jacobian, right-hand sides, reaction and its derivative."""
    return (*_jacobian_steps(c, forms), *_rate_steps(c, forms), *_force_steps(c, forms))


def with_abbreviations(lines: Sequence[Step]) -> tuple[Step, ...]:
    """Steps, each name that none of them defines written out before its first use."""
    defined = {step.left.name for step in lines if isinstance(step.left, MatrixSymbol)}
    complete: list[Step] = []
    for step in lines:
        for x in postorder_traversal(step.right):
            if isinstance(x, NamedMatrix) and x.name not in defined:
                defined.add(x.name)
                left = MatrixSymbol(x.name, *x.shape)
                complete.append(Step(left, x.value, "abbreviation", ""))
        complete.append(step)
    return tuple(complete)


def _jacobian_steps(c: Constraint, forms: Forms) -> tuple[Step, ...]:
    left = MatrixSymbol("δC", *c.value.shape)
    form = add(*(mul(block, x.delta) for block, x in zip(forms.collected, COLUMNS, strict=True)))
    blocks = []
    for block, final, x in zip(forms.collected, forms.jacobian, COLUMNS, strict=True):
        name = final.name if isinstance(final, NamedMatrix) else f"C_{x.name}"
        letter = MatrixSymbol(name, *block.shape)
        blocks.append(Step(letter, block, f"coefficient of {_spoken(x.name)}", ""))
        if final != block and c.closed is not None and isinstance(final, NamedMatrix):
            blocks.append(Step(letter, final.value, c.closed.rules[0], ""))
    return (
        Step(left, PRODUCT_RULE(c.value), "product rule; a′ and s′ are constant", "7.10"),
        Step(left, forms.variation, "δA = A δθ′~", "7.16"),
        Step(left, form, "u~ v = −v~ u, a number is its own transpose; collected", "7.19"),
        *blocks,
    )


def _rate_steps(c: Constraint, forms: Forms) -> tuple[Step, ...]:
    rate, acceleration = (MatrixSymbol(f"C_{dots}", *c.value.shape) for dots in ("dot", "ddot"))
    form = add(*(mul(block, x.velocity) for block, x in zip(forms.collected, COLUMNS, strict=True)))
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
        *(() if c.closed is None else c.closed.lines),
        *(() if c.gamma is None else (c.gamma,)),
    )


def _force_steps(c: Constraint, forms: Forms) -> tuple[Step, ...]:
    weighted = dict.fromkeys(
        factor
        for f in forms.reaction
        for factor in coefficient_and_factors(f)[1]
        if isinstance(factor, NamedMatrix) and factor.name[0] == "b"
    )
    text = "abbreviation: the vector times its multiplier"
    steps = [Step(_block(*_letter_and_index(b.name), b), b.value, text, "") for b in weighted]
    rule = "" if c.closed is None else f"; {c.closed.rules[1]}"
    for k, (f, x) in enumerate(zip(forms.reaction, COLUMNS, strict=True)):
        text = f"block of C_qᵀλ dual to {_spoken(x.name)}"
        steps.append(Step(_block("f", x.name, f), f, text, ""))
        for block, y in zip(forms.stiffness[k], COLUMNS, strict=True):
            if not is_zero(block):
                left = _block("f", f"{x.name},{y.name}", block)
                text = f"δ at fixed λ, coefficient of {_spoken(y.name)}{rule}"
                steps.append(Step(left, block, text, "7.16"))
    return tuple(steps)


def _block(letter: str, name: str, block: SymbolicMatrix) -> SymbolicMatrix:
    return as_matrix(MatrixSymbol(f"{letter}_{name}" if name else letter, *block.shape))


def _letter_and_index(name: str) -> tuple[str, str]:
    letter, _, index = name.partition("_")
    return letter, index


def _spoken(name: str) -> str:
    kind, body = name.split("_")
    return f"δ{kind}{'′' * (kind == 'θ')}_{body}"
