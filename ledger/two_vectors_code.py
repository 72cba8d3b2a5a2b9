"""What ties lecture 8.2 to the code: the derived C and C_q are what the equations say."""

from __future__ import annotations

from functools import cache, partial
from typing import TYPE_CHECKING

from sympy.matrices.expressions import BlockMatrix, MatAdd
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.ledger.checks import equal
from kousoku.ledger.proof import value_of
from kousoku.ledger.two_vectors import offset, words
from kousoku.model.rows import ROWS
from kousoku.symbolic import derive
from kousoku.symbolic.bodies import COLUMNS, A
from kousoku.symbolic.matrices import add, mul, skew, transpose
from kousoku.symbolic.variation import coefficient

if TYPE_CHECKING:
    from kousoku.ledger.entry import Check
    from kousoku.ledger.vocabulary import Value
    from kousoku.symbolic.derivation import Output


@cache
def outputs(package: str) -> dict[str, Output]:
    """Return what the code derives of a constraint: ``C`` and ``C_q``, on both levels."""
    return {o.quantity.name: o for o in derive(package).functions[0].outputs}


def derived(package: str, output: str) -> Value:
    """Return ``C`` or ``C_q`` as the code derives it, on the matrix level."""
    return outputs(package)[output].expression


def packages(kind: str) -> tuple[tuple[str, str], ...]:
    """Return the code's packages of a kind, each with the axis that chooses its rows."""
    return ((kind, ""),) if kind.startswith("n") else tuple((f"{kind}_{x}", x) for x in ROWS)


def selection(axis: str) -> Value:
    """Return S, which keeps the two rows that hold the component of an axis."""
    return ImmutableDenseMatrix([[int(k == row) for k in range(3)] for row in ROWS[axis]])


def in_code(kind: str, latex: str) -> tuple[Check, ...]:
    """Return the checks that the code's C is what a chain that ends in zero says.

    Of p1 and p2 the code turns c into the frame of i and keeps two rows: C = S A_iᵀ c.
    """
    return tuple(
        equal(
            f"the code's {package} has C = {'S A_iᵀ c, c being ' if axis else ''}this",
            offset,
            partial(derived, package, "C"),
            partial(_kept, axis, latex),
        )
        for package, axis in packages(kind)
    )


def varied_in_code(kind: str, latex: str) -> tuple[Check, ...]:
    """Return the checks that the code's C_q is what a chain that ends in zero says.

    Of p1 and p2 the rows are turned: δ(A_iᵀ c) = A_iᵀ δc − δθ̃′ A_iᵀ c, whose last term vanishes
    where c = 0.
    """
    text = "S (A_iᵀ δc − δθ̃′ A_iᵀ c), δc being "
    return tuple(
        equal(
            f"the code's {package} has C_q δq = {text if axis else ''}this",
            offset,
            partial(derived, package, "C_q"),
            partial(_jacobian, kind, axis, latex),
        )
        for package, axis in packages(kind)
    )


def _last(latex: str) -> Value:
    """Return the last side of a chain before its zero."""
    return value_of(latex, words(), -2)


def _kept(axis: str, latex: str) -> Value:
    return _turned(axis, _last(latex)) if axis else _last(latex)


def _turned(axis: str, x: Value) -> Value:
    """Return S A_iᵀ x, term by term."""
    terms = x.args if isinstance(x, MatAdd) else (x,)
    return add(*(mul(selection(axis), transpose(A["i"]), term) for term in terms))


def _jacobian(kind: str, axis: str, latex: str) -> Value:
    """Return the coefficients of δr^i, δθ′^i, δr^j, δθ′^j side by side."""
    blocks = []
    for column in COLUMNS:
        block = coefficient(_last(latex), column.delta)
        if axis:
            block = _turned(axis, block)
        if axis and column.name == "θ_i":  # −δθ̃′ A_iᵀ c
            turned_c = mul(transpose(A["i"]), words().meanings[f"C^({kind})"])
            block = add(block, mul(selection(axis), skew(turned_c)))
        blocks.append(block)
    return BlockMatrix([blocks])
