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

    over: SparsePolynomial
    under: SparsePolynomial

    def __add__(self, other: Fraction) -> Fraction:
        if self.under == other.under:
            return Fraction(self.over + other.over, self.under)
        if not self.over:
            return other
        if not other.over:
            return self
        for one, two in ((self, other), (other, self)):
            times, rest = one.under.div(two.under)
            if not rest:  # powers of one norm, say
                return Fraction(one.over + two.over * times, one.under)
        return Fraction(self.over * other.under + other.over * self.under, self.under * other.under)

    def cancelled(self, norms: Sequence[Norm] | None) -> Fraction:
        """Fraction without norms that divide both parts.

        Where there are none, without its denominator if that divides; None changes nothing.
        """
        if norms is None:
            return self
        if not norms and self.under != self.under.ring.one:
            if not _may_divide(self.under, self.over):
                return self
            quotient, rest = self.over.div(self.under)
            return self if rest else Fraction(quotient, self.under.ring.one)
        over, under = self.over, self.under
        for norm in norms:
            while under != under.ring.one:
                less = norm.divide(under)
                quotient = None if less is None else norm.divide(over)
                if less is None or quotient is None:
                    break
                over, under = quotient, less
        return Fraction(over, under)

    def __sub__(self, other: Fraction) -> Fraction:
        return self + Fraction(-other.over, other.under)

    def __mul__(self, other: Fraction) -> Fraction:
        return Fraction(self.over * other.over, self.under * other.under)

    def __rmul__(self, number: int) -> Fraction:
        return Fraction(number * self.over, self.under)


def _may_divide(under: SparsePolynomial, over: SparsePolynomial) -> bool:
    """Whether the first and the last monomial of a polynomial divide those of another.

    Those of a product are the products of those of its factors.
    """
    order = over.ring.order
    return not over or all(
        all(
            less <= more
            for less, more in zip(end(under, key=order), end(over, key=order), strict=True)
        )
        for end in (min, max)
    )


@dataclass(frozen=True, slots=True)
class Norm:
    """A polynomial g² + s, g a generator that s does not hold, such as p·p."""

    place: int
    rest: SparsePolynomial

    def divide(self, x: SparsePolynomial) -> SparsePolynomial | None:
        """Quotient x / (g² + s), or None where that is no polynomial: long division in g."""
        parts: dict[int, SparsePolynomial] = {}
        for powers, value in x.terms():
            k = powers[self.place]
            part = parts.setdefault(k, x.ring.zero)
            part[(*powers[: self.place], 0, *powers[self.place + 1 :])] = value
        quotient = x.ring.zero
        for k in range(max(parts, default=0), 1, -1):
            over = parts.get(k)
            if over:
                parts[k - 2] = parts.get(k - 2, x.ring.zero) - self.rest * over
                quotient += over * x.ring.gens[self.place] ** (k - 2)
        return None if parts.get(0) or parts.get(1) else quotient
