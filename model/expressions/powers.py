"""Products of powers of numbers and of their sizes, in which a quotient cancels.

``y*abs(y)/y^2`` is y¹⁻² |y|¹, and so is ``y*exp(-0.5*log(y^2))`` y¹ |y|⁻¹: both are the sign of y.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING

from kousoku.model.expressions.polynomials import Polynomial, polynomial_of, square_part
from kousoku.model.operations.expression import (
    ONE,
    Expression,
    add,
    apply,
    div,
    mul,
    names_of,
    number,
    power,
)
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Iterator

MOST_FACTORS = 200
"""Factors of the longest product that is looked at."""


@dataclass(frozen=True, slots=True)
class SignedPower:
    """Power bᵖ |b|ˢ of a base b.

    Parameters
    ----------
    power : int
        p.
    size : Fraction
        s.
    is_above, is_below : bool
        Whether some factor of it has a positive exponent, and some a negative one.
    has_size : bool
        Whether some factor of it is one of |b|.
    """

    power: int
    size: Fraction
    is_above: bool
    is_below: bool
    has_size: bool

    @classmethod
    def of(cls, power_: int, size: Fraction) -> SignedPower:
        """Power that is a single factor."""
        exponent = power_ + size
        return cls(power_, size, exponent > 0, exponent < 0, bool(size))

    @property
    def exponent(self) -> Fraction:
        """Exponent p + s of its size."""
        return self.power + self.size

    @property
    def is_size(self) -> bool:
        """Whether it is never negative."""
        return self.power % 2 == 0

    def times(self, other: SignedPower) -> SignedPower:
        """Product with another power of the same base."""
        return SignedPower(
            self.power + other.power,
            self.size + other.size,
            self.is_above or other.is_above,
            self.is_below or other.is_below,
            self.has_size or other.has_size,
        )

    def raised(self, exponent: Fraction) -> SignedPower:
        """Power of it: with an exponent that is no whole number it has to be a size."""
        is_whole = exponent.denominator == 1
        power_ = int(self.power * exponent) if is_whole else 0
        size = self.exponent * exponent - power_
        above, below = self.is_above, self.is_below
        if exponent < 0:
            above, below = below, above
        return SignedPower(power_, size, above, below, self.has_size or not is_whole)

    def sized(self) -> SignedPower:
        """Size of it."""
        return SignedPower(0, self.exponent, self.is_above, self.is_below, has_size=True)

    @property
    def cancels(self) -> bool:
        """Whether quotients in it cancel so far that it is bounded near zero: a kink or jump."""
        is_quotient = self.is_above and self.is_below and self.has_size
        return is_quotient and (self.exponent > 0 or (self.exponent == 0 and not self.is_size))


Powers = dict[Expression, SignedPower]
ITSELF = SignedPower.of(1, Fraction(0))
MINUS = number(-1)


def without_quotient(part: Expression) -> Expression | None:
    """Product in which quotients of numbers and their sizes have cancelled; None where none do."""
    powers = _powers_of(part)
    if powers is None or not any(p.cancels and names_of(base) for base, p in powers.items()):
        return None
    factors = [pair for base, signed in powers.items() for pair in _written(base, signed)]
    above, below = (
        mul(*(factor for factor, is_below in factors if is_below is side)) for side in (False, True)
    )
    return above if below == ONE else div(above, below)


def _written(base: Expression, signed: SignedPower) -> Iterator[tuple[Expression, bool]]:
    """Factors of a power, and whether each is divided by."""
    if base == MINUS:
        if not signed.is_size:
            yield base, False
        return
    if base.value is not None:
        signed = SignedPower.of(0, signed.exponent)
    if not (signed.cancels and names_of(base)):
        size = base if base.value is not None else apply(Op.ABS, base)
        for factor, exponent in ((base, Fraction(signed.power)), (size, signed.size)):
            if exponent:
                yield power(factor, number(abs(exponent))), exponent < 0
        return
    remaining = signed.exponent
    if not signed.is_size:
        yield base if remaining >= 1 else apply(Op.SIGN, base), False
        remaining -= remaining >= 1
    is_even = remaining.denominator == 1 and remaining % 2 == 0
    yield power(base if is_even else apply(Op.ABS, base), number(remaining)), False


def _powers_of(part: Expression) -> Powers | None:
    """Formula as a product of powers; None where it is too long."""
    powers: Powers = {}
    stack, count = [(part, 1)], 0
    while stack:
        factor, exponent = stack.pop()
        count += 1
        if count > MOST_FACTORS:
            return None
        match factor:
            case Expression(Op.MUL, args):
                stack += ((arg, exponent) for arg in reversed(args))
            case Expression(Op.DIV, (a, b)):
                stack += ((b, -exponent), (a, exponent))
            case Expression(Op.NEG, (a,)):
                stack += ((a, exponent), (MINUS, 1))
            case _:
                for base, signed in _single(factor).items():
                    _multiply(powers, base, signed.raised(Fraction(exponent)))
    return powers


def _multiply(powers: Powers, base: Expression, by: SignedPower) -> None:
    powers[base] = powers[base].times(by) if base in powers else by


def _single(part: Expression) -> Powers:
    """Powers in a formula that is no product."""
    powers: Powers | None = None
    match part:
        case Expression(value=Fraction() as value) if value < 0 and value != -1:
            powers = {MINUS: ITSELF, number(-value): ITSELF}
        case Expression(Op.ABS, (a,)):
            powers = _powers_of(a)
            powers = None if powers is None else {b: signed.sized() for b, signed in powers.items()}
        case Expression(Op.SQRT, (a,)):
            powers = _raised(_powers_of(a), Fraction(1, 2))
        case Expression(Op.POW, (a, Expression(value=Fraction() as exponent))):
            powers = _raised(_powers_of(a), exponent)
        case Expression(Op.EXP, (a,)):
            powers = _exponential(a)
        case Expression(Op.ADD):
            powers = _powers_of_sum(part)
    return {part: ITSELF} if powers is None else powers


@lru_cache(maxsize=1024)
def _powers_of_sum(part: Expression) -> Powers | None:
    """Powers in a polynomial: squares that it is a product of, and its highest factor apart.

    So it is known where it is written otherwise: 1 - t is −(t - 1).
    """
    squares = square_part(part)
    if squares is not None:
        return _powers_of(mul(squares.rest, *(power(a, number(n)) for a, n in squares.powers)))
    polynomial = polynomial_of(part)
    if polynomial is None or not polynomial.terms:
        return None
    order = sorted(range(len(polynomial.variables)), key=lambda k: polynomial.variables[k].key)
    terms = {tuple(powers[k] for k in order): factor for powers, factor in polynomial.terms.items()}
    highest = terms[max(terms)]
    scaled = {powers: factor / highest for powers, factor in terms.items()}
    base = Polynomial(tuple(polynomial.variables[k] for k in order), scaled).expression()
    return {base: ITSELF, **_single(number(highest))}


def _raised(powers: Powers | None, exponent: Fraction) -> Powers | None:
    """Power of a product; None where its factors must not come apart."""
    is_whole = exponent.denominator == 1
    if powers is None or not all(is_whole or _is_positive(*pair) for pair in powers.items()):
        return None
    return {base: signed.raised(exponent) for base, signed in powers.items()}


def _is_positive(base: Expression, signed: SignedPower) -> bool:
    return signed.is_size or (base.value is not None and base.value > 0)


def _exponential(a: Expression) -> Powers | None:
    """Powers in an exponential, of the arguments of logarithms in its exponent."""
    powers: Powers = {}
    others = []
    for term in a.args if a.op is Op.ADD else (a,):
        of_term = _logarithm(term)
        if of_term is None:
            others.append(term)
            continue
        for base, signed in of_term.items():
            _multiply(powers, base, signed)
    if powers and others:
        _multiply(powers, apply(Op.EXP, add(*others)), ITSELF)
    return powers or None


def _logarithm(term: Expression) -> Powers | None:
    """Powers in the exponential of a multiple of a logarithm."""
    argument, exponent = None, Fraction(1)
    for base, signed in (_powers_of(term) or {}).items():
        if base.value is not None and signed.size.denominator == 1:
            exponent *= base.value**signed.power * abs(base.value) ** int(signed.size)
        elif base.op is Op.LOG and signed == ITSELF and argument is None:
            argument = base.args[0]
        else:
            return None
    powers = None if argument is None else _powers_of(argument)
    if powers is None or not all(_is_positive(*pair) for pair in powers.items()):
        return None  # a logarithm of a negative number has no value
    return _raised(powers, exponent)
