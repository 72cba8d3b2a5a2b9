"""Fractions of polynomials, and the norms that are divided out of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence


class SparsePolynomial(Protocol):
    """A polynomial of SymPy's sparse rings, as a type: SymPy is untyped."""

    @property
    def ring(self) -> Any:
        """Ring that it is an element of."""

    @property
    def is_one(self) -> bool:
        """Whether it is 1."""

    @property
    def is_generator(self) -> bool:
        """Whether it is a generator of its ring."""

    def __add__(self, other: Any, /) -> Any: ...
    def __sub__(self, other: Any, /) -> Any: ...
    def __mul__(self, other: Any, /) -> Any: ...
    def __rmul__(self, other: Any, /) -> Any: ...
    def __pow__(self, other: int, /) -> Any: ...
    def __neg__(self) -> Any: ...
    def __bool__(self) -> bool: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __iter__(self) -> Iterator[tuple[int, ...]]: ...
    def __setitem__(self, powers: tuple[int, ...], value: Any, /) -> None: ...

    def coeffs(self) -> list[Any]:
        """The coefficients of its monomials."""

    def terms(self) -> list[tuple[tuple[int, ...], Any]]:
        """Its monomials, each with its coefficient."""

    def div(self, other: Any, /) -> tuple[Any, Any]:
        """Quotient and remainder."""


@dataclass(frozen=True, slots=True)
class Fraction:
    """A fraction of two polynomials; common factors stay."""

    numerator: SparsePolynomial
    denominator: SparsePolynomial

    def __add__(self, other: Fraction) -> Fraction:
        if self.denominator == other.denominator:
            return Fraction(self.numerator + other.numerator, self.denominator)
        if not self.numerator:
            return other
        if not other.numerator:
            return self
        for a, b in ((self, other), (other, self)):
            factor, remainder = a.denominator.div(b.denominator)
            if not remainder:  # powers of one norm, say
                return Fraction(a.numerator + b.numerator * factor, a.denominator)
        return Fraction(
            self.numerator * other.denominator + other.numerator * self.denominator,
            self.denominator * other.denominator,
        )

    def cancelled(self, norms: Sequence[Norm] | None) -> Fraction:
        """Fraction without norms that divide both parts.

        Where there are none, without its denominator if that divides; None changes nothing.
        """
        if norms is None:
            return self
        if not norms and self.denominator != self.denominator.ring.one:
            if not _may_divide(self.denominator, self.numerator):
                return self
            quotient, remainder = self.numerator.div(self.denominator)
            return self if remainder else Fraction(quotient, self.denominator.ring.one)
        numerator, denominator = self.numerator, self.denominator
        for norm in norms:
            while denominator != denominator.ring.one:
                reduced = norm.divide(denominator)
                quotient = None if reduced is None else norm.divide(numerator)
                if reduced is None or quotient is None:
                    break
                numerator, denominator = quotient, reduced
        return Fraction(numerator, denominator)

    def __sub__(self, other: Fraction) -> Fraction:
        return self + Fraction(-other.numerator, other.denominator)

    def __mul__(self, other: Fraction) -> Fraction:
        return Fraction(self.numerator * other.numerator, self.denominator * other.denominator)

    def __rmul__(self, number: int) -> Fraction:
        return Fraction(number * self.numerator, self.denominator)


def _may_divide(divisor: SparsePolynomial, dividend: SparsePolynomial) -> bool:
    """Whether the first and the last monomial of a divisor divide those of a dividend.

    End monomials of a product are the products of those of its factors.
    """
    order = dividend.ring.order
    return not dividend or all(
        all(m <= n for m, n in zip(end(divisor, key=order), end(dividend, key=order), strict=True))
        for end in (min, max)
    )


@dataclass(frozen=True, slots=True)
class Norm:
    """A polynomial g² + s, g a generator that s does not hold, such as p·p."""

    index: int
    s: SparsePolynomial

    def divide(self, x: SparsePolynomial) -> SparsePolynomial | None:
        """Quotient x / (g² + s), or None where that is no polynomial: long division in g."""
        coefficients: dict[int, SparsePolynomial] = {}
        for powers, value in x.terms():
            k = powers[self.index]
            coefficient = coefficients.setdefault(k, x.ring.zero)
            coefficient[(*powers[: self.index], 0, *powers[self.index + 1 :])] = value
        quotient = x.ring.zero
        for k in range(max(coefficients, default=0), 1, -1):
            leading = coefficients.get(k)
            if leading:
                coefficients[k - 2] = coefficients.get(k - 2, x.ring.zero) - self.s * leading
                quotient += leading * x.ring.gens[self.index] ** (k - 2)
        return None if coefficients.get(0) or coefficients.get(1) else quotient
