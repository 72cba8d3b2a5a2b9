"""Formulas as polynomials with exact numbers: their square factors and real roots.

A part that is no sum, product or whole power is a variable: ``sin(t)^2 - 2*sin(t) + 1`` is a
polynomial.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import isqrt
from typing import TYPE_CHECKING, NamedTuple

from kousoku.model.operations.expression import (
    LARGEST_BITS,
    ONE,
    Expression,
    add,
    apply,
    bits_of,
    div,
    mul,
    neg,
    number,
    ordered,
    power,
)
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

MOST_TERMS = 200
"""Terms of the longest polynomial that is written out."""

HIGHEST = 24
"""The highest power of it."""

Powers = tuple[int, ...]
Terms = dict[Powers, Fraction]
#: Of one variable: the factor of its n-th power at index n, the last one not zero.
Coefficients = tuple[Fraction, ...]


@dataclass(frozen=True, slots=True)
class Polynomial:
    """A sum of products of powers.

    Parameters
    ----------
    variables : tuple of Expression
        Bases of the powers.
    terms : mapping of tuple of int to Fraction
        The factor of each product, by the powers of the variables; none is zero.
    """

    variables: tuple[Expression, ...]
    terms: Mapping[Powers, Fraction]

    def expression(self) -> Expression:
        """Formula of the polynomial, the highest powers first."""
        terms = []
        for powers, factor in sorted(self.terms.items(), reverse=True):
            product = map(power, self.variables, map(number, powers))
            size = mul(number(abs(factor)), *product)
            terms.append(neg(size) if factor < 0 else size)
        return add(*terms)


class Squares(NamedTuple):
    """A product f a² b⁴ of even powers, and of a remaining factor.

    Parameters
    ----------
    rest : Expression
        f, which is not zero where the even powers are.
    powers : tuple of (Expression, int)
        The bases a, b with their even exponents.
    """

    rest: Expression
    powers: tuple[tuple[Expression, int], ...]


def polynomial_of(formula: Expression) -> Polynomial | None:
    """Formula as a polynomial; None where it is too long."""
    inner, stack = {id(formula)}, [formula]
    while stack:
        for arg in _args_of(stack.pop()):
            if id(arg) not in inner:
                inner.add(id(arg))
                stack.append(arg)
    parts = [part for part in ordered(formula) if id(part) in inner]
    atoms = (part for part in parts if part.value is None and not _is_sum(part))
    variables = tuple(dict.fromkeys(atoms))
    known: dict[int, Terms] = {}
    for part in parts:
        terms = _terms(part, variables, known)
        if terms is None or len(terms) > MOST_TERMS:
            return None
        if any(bits_of(factor) > LARGEST_BITS for factor in terms.values()):
            return None
        if any(sum(powers) > HIGHEST for powers in terms):
            return None
        known[id(part)] = terms
    return Polynomial(variables, known[id(formula)])


def square_part(formula: Expression) -> Squares | None:
    """Polynomial as a product with even powers; None where there are none.

    In one variable all are found, in several those of variables and a square of the remainder.
    """
    polynomial = polynomial_of(formula)
    if polynomial is None or not polynomial.terms or not polynomial.variables:
        return None
    split = _even_factors if len(polynomial.variables) == 1 else _even_variables
    rest, squares = split(polynomial.terms)
    if not squares:
        return None

    def expression_of(terms: Terms) -> Expression:
        return Polynomial(polynomial.variables, terms).expression()

    return Squares(
        expression_of(rest), tuple((expression_of(terms), count) for terms, count in squares)
    )


def _even_power(part: Expression) -> tuple[Expression, int] | None:
    """Base a and exponent n of a^n with an even n, or of a*a."""
    match part:
        case Expression(Op.MUL, (a, b)) if a == b:
            return a, 2
        case Expression(Op.POW, (a, Expression(value=Fraction() as count))) if count % 2 == 0:
            return a, int(count)
    return None


def root_of_even_power(part: Expression) -> tuple[Expression, Fraction] | None:
    """Base a and exponent n b of (a^n)^b with an even n and a b that is not whole."""
    exponent = root_exponent(part)
    even = None if exponent is None else _even_power(part.args[0])
    return None if exponent is None or even is None else (even[0], even[1] * exponent)


def root_exponent(part: Expression) -> Fraction | None:
    """Exponent b of a root, a^b where b is not whole; None of any other formula."""
    if part.op is Op.SQRT:
        return Fraction(1, 2)
    exponent = part.args[1].value if part.op is Op.POW else None
    return None if exponent is None or exponent.denominator == 1 else exponent


def with_squares_apart(part: Expression) -> Expression:
    """Root with the roots of squares in it apart: ``sqrt(x^2 - 2*x + 1)``, ``(x - 1)^2``.

    Written out it is known to half of its digits where it is near to zero, and is nowhere known to
    be an absolute value. Any other formula is returned as it is.
    """
    exponent = root_exponent(part)
    if exponent is None or _even_power(part.args[0]) or not (squares := _squares_of(part.args[0])):
        return part
    factors = (squares.rest, *(power(a, number(n)) for a, n in squares.powers))
    return mul(*(_root_of(factor, exponent) for factor in factors))


def _squares_of(part: Expression) -> Squares | None:
    """Even powers of a product unless it is negative, also if it is a quotient."""
    if part.op is Op.DIV and not _is_sum(part):
        above, below = part.args
        even = _even_power(above)
        squares = _squares_of(above) if even is None else Squares(ONE, (even,))
        return None if squares is None else squares._replace(rest=div(squares.rest, below))
    squares = square_part(part)
    is_negative = squares is not None and squares.rest.value is not None and squares.rest.value < 0
    return None if is_negative else squares


def _root_of(part: Expression, exponent: Fraction) -> Expression:
    """Root of a formula; of the square of a number that number."""
    if part.value is not None and exponent.denominator == 2:
        roots = [isqrt(size) for size in part.value.as_integer_ratio()]
        if [size * size for size in roots] == [*part.value.as_integer_ratio()]:
            return power(number(Fraction(*roots)), number(2 * exponent))
    if exponent == Fraction(1, 2):
        return apply(Op.SQRT, part)
    return power(part, number(exponent))


def is_never_zero(formula: Expression) -> bool:
    """Whether a formula is a polynomial in one variable that has no real root."""
    polynomial = polynomial_of(formula)
    if polynomial is None or len(polynomial.variables) != 1 or not polynomial.terms:
        return False
    chain = _sturm_chain(_coefficients(polynomial.terms))
    left, right = ([p[-1] * side ** (len(p) - 1) for p in chain] for side in (-1, 1))
    return _sign_changes(left) == _sign_changes(right)


def _is_power(part: Expression) -> bool:
    """Whether a power is a product, of none or more factors."""
    exponent = part.args[1].value
    return exponent is not None and exponent.denominator == 1 and 0 <= exponent <= HIGHEST


def _is_sum(part: Expression) -> bool:
    """Whether a formula is a sum or product of others."""
    match part.op:
        case Op.ADD | Op.NEG | Op.MUL:
            return True
        case Op.DIV:
            return bool(part.args[1].value)
        case Op.POW:
            return _is_power(part)
    return False


def _args_of(part: Expression) -> tuple[Expression, ...]:
    """Parts that a formula is a sum or product of."""
    if not _is_sum(part):
        return ()
    return part.args[:1] if part.op in {Op.POW, Op.DIV} else part.args


def _terms(
    part: Expression, variables: tuple[Expression, ...], known: Mapping[int, Terms]
) -> Terms | None:
    """Formula as a sum of products, where all its parts are; None where it is too long."""
    if part.value is not None:
        return {(0,) * len(variables): part.value} if part.value else {}
    if not _is_sum(part):
        return {tuple(int(variable == part) for variable in variables): Fraction(1)}
    args = [known[id(arg)] for arg in _args_of(part)]
    match part.op:
        case Op.ADD:
            total: Terms = {}
            for terms in args:
                total = _plus(total, terms)
            return total
        case Op.NEG:
            return {powers: -factor for powers, factor in args[0].items()}
        case Op.MUL:
            return _times(*args) if len(args[0]) * len(args[1]) <= MOST_TERMS**2 else None
        case Op.DIV:
            assert part.args[1].value is not None
            return {powers: factor / part.args[1].value for powers, factor in args[0].items()}
    exponent = part.args[1].value
    assert exponent is not None
    product: Terms = {(0,) * len(variables): Fraction(1)}
    for _ in range(int(exponent)):
        product = _times(product, args[0])
        if len(product) > MOST_TERMS:
            return None
    return product


def _plus(a: Terms, b: Terms) -> Terms:
    total = dict(a)
    for powers, factor in b.items():
        total[powers] = total.get(powers, Fraction(0)) + factor
    return {powers: factor for powers, factor in total.items() if factor}


def _times(a: Terms, b: Terms) -> Terms:
    product: Terms = {}
    for a_powers, x in a.items():
        for b_powers, y in b.items():
            powers = tuple(map(int.__add__, a_powers, b_powers))
            product[powers] = product.get(powers, Fraction(0)) + x * y
    return {powers: factor for powers, factor in product.items() if factor}


def _lowered(powers: Powers, by: Powers) -> Powers:
    return tuple(map(int.__sub__, powers, by))


def _root(terms: Terms) -> Terms | None:
    """Polynomial of which these are the square, the factor of the highest being one."""
    highest = max(terms)
    if any(n % 2 for n in highest):
        return None
    first = tuple(n // 2 for n in highest)
    root: Terms = {first: Fraction(1)}
    remainder = _plus(terms, {highest: Fraction(-1)})
    while remainder:
        powers = _lowered(max(remainder), first)
        # the next term of a root is lower than the one before, and no less than the square root
        if min(powers) < 0 or not powers < min(root) or len(root) > MOST_TERMS:
            return None
        half = remainder[max(remainder)] / 2
        twice = {m: 2 * factor for m, factor in root.items()} | {powers: half}
        remainder = _plus(remainder, _times(twice, {powers: -half}))
        root[powers] = half
    return root


def _coefficients(terms: Mapping[Powers, Fraction]) -> Coefficients:
    highest = max(terms)[0]
    return tuple(terms.get((n,), Fraction(0)) for n in range(highest + 1))


def _even_variables(terms: Mapping[Powers, Fraction]) -> tuple[Terms, list[tuple[Terms, int]]]:
    """Rest of a polynomial without even powers, and these, one for each variable."""
    least = tuple(map(min, zip(*terms, strict=True)))
    zeroth = (0,) * len(least)
    rest = {_lowered(powers, least): factor for powers, factor in terms.items()}
    squares: list[tuple[Terms, int]] = []
    odd = list(least)
    for k, count in enumerate(least):
        if count and count % 2 == 0:
            odd[k] = 0
            squares.append(({(*zeroth[:k], 1, *zeroth[k + 1 :]): Fraction(1)}, count))
    scale = rest[max(rest)]
    root = _root({powers: factor / scale for powers, factor in rest.items()})
    if root is not None and len(root) > 1:
        rest = {zeroth: scale}
        squares.append((root, 2))
    return _times(rest, {tuple(odd): Fraction(1)}), squares


def _even_factors(terms: Mapping[Powers, Fraction]) -> tuple[Terms, list[tuple[Terms, int]]]:
    """Rest of a polynomial without even powers, and these, by Yun's algorithm."""
    p = _coefficients(terms)
    rest: Coefficients = (p[-1],)
    squares: list[tuple[Terms, int]] = []
    common, count = _gcd(p, _derivative(p)), 1
    remaining = _divided(p, common)[0]
    while len(remaining) > 1:
        repeated = _gcd(remaining, common)
        simple = _divided(remaining, repeated)[0]  # the factors of that multiplicity
        simple = tuple(x / simple[-1] for x in simple)
        if count % 2:
            for _ in range(count):
                rest = _product(rest, simple)
        elif len(simple) > 1:
            squares.append((_univariate_terms(simple), count))
        remaining, common = repeated, _divided(common, repeated)[0]
        count += 1
    return _univariate_terms(rest), squares


def _univariate_terms(p: Coefficients) -> Terms:
    return {(n,): x for n, x in enumerate(p) if x}


def _sturm_chain(p: Coefficients) -> list[Coefficients]:
    chain = [p, _derivative(p)] if len(p) > 1 else [p]
    while len(chain[-1]) > 1:
        remainder = _divided(chain[-2], chain[-1])[1]
        if not remainder:
            break
        size = abs(remainder[-1])
        chain.append(tuple(-x / size for x in remainder))
    return chain


def _sign_changes(values: Sequence[Fraction]) -> int:
    """Number of sign changes along a list."""
    return sum(a * b < 0 for a, b in pairwise(values))


def _derivative(p: Coefficients) -> Coefficients:
    return tuple(n * x for n, x in enumerate(p))[1:]


def _product(a: Coefficients, b: Coefficients) -> Coefficients:
    product = [Fraction(0)] * (len(a) + len(b) - 1)
    for n, x in enumerate(a):
        for m, y in enumerate(b):
            product[n + m] += x * y
    return tuple(product)


def _divided(a: Coefficients, b: Coefficients) -> tuple[Coefficients, Coefficients]:
    """Quotient and remainder; an empty one is zero."""
    remainder, quotient = list(a), [Fraction(0)] * max(len(a) - len(b) + 1, 0)
    for n in reversed(range(len(quotient))):
        quotient[n] = remainder[n + len(b) - 1] / b[-1]
        for m, y in enumerate(b):
            remainder[n + m] -= quotient[n] * y
    while remainder and remainder[-1] == 0:
        remainder.pop()
    return tuple(quotient), tuple(remainder)


def _gcd(a: Coefficients, b: Coefficients) -> Coefficients:
    """Greatest common divisor, the factor of its highest power one."""
    while b:
        a, b = b, _divided(a, b)[1]
        b = tuple(x / b[-1] for x in b)
    return tuple(x / a[-1] for x in a)
