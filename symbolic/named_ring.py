"""A ring in which names stand for themselves: an identity for all values holds for theirs.

Without it a quotient of sums in many Euler parameters would be multiplied out. An equality that is
found here holds; an inequality may not, as the values may have relations that the names lack.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import sympy

from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.matrices import Divisor, NamedMatrix, NamedScalar, elements
from kousoku.symbolic.ring import Ring

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from kousoku.symbolic.fractions import Fraction

#: A sum of at most so many products is multiplied out, to see whether a name stands for it.
MOST_PRODUCTS = 30_000


class NamedRing(Ring):
    """A ring with a generator for each element of the given names.

    Parameters
    ----------
    quantities, matrices
        As of :class:`Ring`.
    names : Collection of NamedMatrix, NamedScalar or OrientationMatrix
        Names that stand for themselves; a mapping to the values of the elements in ``plain``.
    plain : Ring, optional
        The ring of the quantities alone. With it, a sum whose value is that of a name, or a
        multiple of it, is replaced by the name: so both levels of a derivation come to hold it.
    """

    def __init__(
        self,
        quantities: Sequence[Quantity],
        names: Collection[Any],
        *,
        matrices: Mapping[str, Any] | None = None,
        is_unit: bool = False,
        plain: Ring | None = None,
    ) -> None:
        extra = [Quantity(f"name {k}", _shape(name), "", "") for k, name in enumerate(names)]
        super().__init__([*quantities, *extra], matrices, is_unit=is_unit)
        self._cancelled = None  # divisors are names, and names are not divided
        self._plain = plain
        self._values: dict[frozenset[Any], tuple[Any, Fraction]] = {}
        for name, quantity in zip(names, extra, strict=True):
            cells = [self.scalar(x) for x in elements(quantity)]
            if isinstance(names, Mapping):
                for k, value in enumerate(names[name]):
                    if value:
                        self._values.setdefault(_key(value), (value.LC, cells[k]))
                    cells[k] = self._multiple(value) or cells[k]
            if _is_number(name):
                self._scalars[name] = cells[0]
            else:
                width = quantity.shape[1]
                self._memo[name] = [cells[k : k + width] for k in range(0, len(cells), width)]

    def _multiple(self, value: Any) -> Fraction | None:
        """Value as a multiple of a name, if it is one."""
        if not value:
            return self._number(sympy.S.Zero)
        leading, cell = self._values.get(_key(value), (None, None))
        if cell is None:
            return None
        return self._number(sympy.Rational(*_ratio(value.LC / leading))) * cell

    def _scalar(self, x: Any) -> Fraction:
        if self._plain is not None and isinstance(x, sympy.Add) and _products(x) <= MOST_PRODUCTS:
            known = self._multiple(self._plain.scalar(x).numerator)
            if known is not None:
                return known
        return super()._scalar(x)

    def _number(self, x: Any) -> Fraction:
        return super()._scalar(x)


def polynomial_names(plain: Ring, x: Any) -> dict[Any, list[Any]]:
    """Names in an expression whose values are polynomials, and these values."""
    values_of = {}
    for name in _sorted(x.atoms(NamedMatrix, NamedScalar)):
        if _is_free_of_roots(name):
            values = [_as_polynomial(cell) for cell in plain.cells(name)]
            if None not in values:
                values_of[name] = values
    return values_of


def _is_free_of_roots(x: Any) -> bool:
    roots = [power for power in x.atoms(sympy.Pow) if not power.exp.is_Integer]
    return not roots and not x.atoms(sympy.atan2, sympy.sin, sympy.cos)


def _as_polynomial(x: Fraction) -> Any:
    """Fraction as a polynomial, or None if it is not one."""
    quotient, remainder = x.numerator.div(x.denominator)
    return None if remainder else quotient


def _sorted(names: Any) -> list[Any]:
    return sorted(names, key=str)


def shared(x: Any, y: Any, *sorts: type) -> list[Any]:
    """Names, or nodes of other sorts, that both expressions hold."""
    return _sorted(x.atoms(*sorts) & y.atoms(*sorts))


def _key(value: Any) -> frozenset[Any]:
    """Key that all multiples of a polynomial have in common."""
    return frozenset(value.monic().items())  # a polynomial that was added to keeps its old hash


def _is_number(name: Any) -> bool:
    return isinstance(name, NamedScalar | Divisor)


def _shape(name: Any) -> tuple[int, int]:
    return (1, 1) if _is_number(name) else (int(name.shape[0]), int(name.shape[1]))


def _ratio(x: Any) -> tuple[int, int]:
    return int(x.numerator), int(x.denominator)


def _products(x: Any) -> float:
    """Bound on the number of products of a polynomial that is multiplied out."""
    if isinstance(x, sympy.Add):
        return sum(_products(arg) for arg in x.args)
    if isinstance(x, sympy.Mul):
        return math.prod(_products(arg) for arg in x.args)
    if isinstance(x, sympy.Pow):
        return _products(x.base) ** int(x.exp) if x.exp.is_Integer and x.exp > 0 else math.inf
    return math.inf if x.args else 1
