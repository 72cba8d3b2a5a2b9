"""References as they are stored: high and low double, and the unit of their error."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.real import SMALLEST_SUBNORMAL

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from kousoku.model.numbers.dual import Dual

#: u, the rounding of a double.
UNIT_ROUNDOFF = CONTEXT.mpf(2) ** -53
#: A derivative below this, at numbers of order one, is zero up to rounding of 50 digits.
NEGLIGIBLE = CONTEXT.mpf(10) ** -40


def columns(
    elements: Sequence[Dual], numbers: Mapping[Any, Any], nonfinite: Collection[Any]
) -> dict[str, object]:
    """``high``, ``low`` and ``unit`` of the elements of an output, as lists.

    Parameters
    ----------
    elements : sequence of Dual
        The elements that are not identically zero.
    numbers : mapping
        The value of each input that a gradient names.
    nonfinite : collection
        The inputs that are not finite: elements that depend on one have ``high`` None.
    """
    rows = [_row(element, numbers, nonfinite) for element in elements]
    return {name: [row[k] for row in rows] for k, name in enumerate(("high", "low", "unit"))}


def _row(
    element: Dual, numbers: Mapping[Any, Any], nonfinite: Collection[Any]
) -> tuple[float | None, float, float]:
    """High, low and unit u (|f| + Σ |x ∂f/∂x|) of one number."""
    depends_on_nonfinite = any(
        abs(element.gradient.get(entry, 0)) > NEGLIGIBLE for entry in nonfinite
    )
    if depends_on_nonfinite or CONTEXT.isnan(element.value):
        return None, 0.0, SMALLEST_SUBNORMAL
    high = float(element.value)
    low = float(element.value - high)
    size = abs(element.value) + sum(abs(numbers[k] * x) for k, x in element.gradient.items())
    unit = max(float(f"{float(UNIT_ROUNDOFF * size):.2e}"), SMALLEST_SUBNORMAL)
    return high, float(f"{low:.4e}"), unit
