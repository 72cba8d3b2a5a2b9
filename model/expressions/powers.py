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
    found = _powers_of(part)
    if found is None or not any(one.cancels and names_of(base) for base, one in found.items()):
        return None
    factors = [pair for base, one in found.items() for pair in _written(base, one)]
    above, below = (
        mul(*(one for one, is_below in factors if is_below is side)) for side in (False, True)
    )
    return above if below == ONE else div(above, below)


def _written(base: Expression, one: SignedPower) -> Iterator[tuple[Expression, bool]]:
    """Factors of a power, and whether each is divided by."""
    if base == MINUS:
        if not one.is_size:
            yield base, False
        return
    if base.value is not None:
        one = SignedPower.of(0, one.exponent)
    if not (one.cancels and names_of(base)):
        size = base if base.value is not None else apply(Op.ABS, base)
        for kept, exponent in ((base, Fraction(one.power)), (size, one.size)):
            if exponent:
                yield power(kept, number(abs(exponent))), exponent < 0
        return
    left = one.exponent
    if not one.is_size:
        yield base if left >= 1 else apply(Op.SIGN, base), False
        left -= left >= 1
    is_even = left.denominator == 1 and left % 2 == 0
    yield power(base if is_even else apply(Op.ABS, base), number(left)), False


def _powers_of(part: Expression) -> Powers | None:
    """Formula as a product of powers; None where it is too long."""
    found: Powers = {}
    stack, count = [(part, 1)], 0
    while stack:
        one, exponent = stack.pop()
        count += 1
        if count > MOST_FACTORS:
            return None
        match one:
            case Expression(Op.MUL, args):
                stack += ((arg, exponent) for arg in reversed(args))
            case Expression(Op.DIV, (a, b)):
                stack += ((b, -exponent), (a, exponent))
            case Expression(Op.NEG, (a,)):
                stack += ((a, exponent), (MINUS, 1))
            case _:
                for base, own in _single(one).items():
                    _multiply(found, base, own.raised(Fraction(exponent)))
    return found


def _multiply(powers: Powers, base: Expression, by: SignedPower) -> None:
    powers[base] = powers[base].times(by) if base in powers else by


def _single(part: Expression) -> Powers:
    """Powers in a formula that is no product."""
    found: Powers | None = None
    match part:
        case Expression(value=Fraction() as value) if value < 0 and value != -1:
            found = {MINUS: ITSELF, number(-value): ITSELF}
        case Expression(Op.ABS, (a,)):
            found = _powers_of(a)
            found = None if found is None else {b: one.sized() for b, one in found.items()}
        case Expression(Op.SQRT, (a,)):
            found = _raised(_powers_of(a), Fraction(1, 2))
        case Expression(Op.POW, (a, Expression(value=Fraction() as exponent))):
            found = _raised(_powers_of(a), exponent)
        case Expression(Op.EXP, (a,)):
            found = _exponential(a)
        case Expression(Op.ADD):
            found = _powers_of_sum(part)
    return {part: ITSELF} if found is None else found


@lru_cache(maxsize=1024)
def _powers_of_sum(part: Expression) -> Powers | None:
    """Powers in a polynomial: squares that it is a product of, and its highest factor apart.

    So it is known where it is written otherwise: 1 - t is −(t - 1).
    """
    squares = square_part(part)
    if squares is not None:
        return _powers_of(mul(squares.rest, *(power(a, number(n)) for a, n in squares.powers)))
    found = polynomial_of(part)
    if found is None or not found.terms:
        return None
    order = sorted(range(len(found.variables)), key=lambda k: found.variables[k].key)
    terms = {tuple(powers[k] for k in order): factor for powers, factor in found.terms.items()}
    highest = terms[max(terms)]
    scaled = {powers: factor / highest for powers, factor in terms.items()}
    base = Polynomial(tuple(found.variables[k] for k in order), scaled).expression()
    return {base: ITSELF, **_single(number(highest))}


def _raised(powers: Powers | None, exponent: Fraction) -> Powers | None:
    """Power of a product; None where its factors must not come apart."""
    is_whole = exponent.denominator == 1
    if powers is None or not all(is_whole or _is_positive(*pair) for pair in powers.items()):
        return None
    return {base: one.raised(exponent) for base, one in powers.items()}


def _is_positive(base: Expression, one: SignedPower) -> bool:
    return one.is_size or (base.value is not None and base.value > 0)


def _exponential(a: Expression) -> Powers | None:
    """Powers in an exponential, of what its summands have logarithms of."""
    found: Powers = {}
    others = []
    for term in a.args if a.op is Op.ADD else (a,):
        own = _logarithm(term)
        if own is None:
            others.append(term)
            continue
        for base, one in own.items():
            _multiply(found, base, one)
    if found and others:
        _multiply(found, apply(Op.EXP, add(*others)), ITSELF)
    return found or None


def _logarithm(term: Expression) -> Powers | None:
    """Powers in the exponential of a multiple of a logarithm."""
    inside, exponent = None, Fraction(1)
    for base, one in (_powers_of(term) or {}).items():
        if base.value is not None and one.size.denominator == 1:
            exponent *= base.value**one.power * abs(base.value) ** int(one.size)
        elif base.op is Op.LOG and one == ITSELF and inside is None:
            inside = base.args[0]
        else:
            return None
    found = None if inside is None else _powers_of(inside)
    if found is None or not all(_is_positive(*pair) for pair in found.items()):
        return None  # where what a logarithm is of is negative it has no value
    return _raised(found, exponent)
