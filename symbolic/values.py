"""Values of a derivation at given numbers, exactly: from its components, without a kernel."""

from __future__ import annotations

from fractions import Fraction
from numbers import Rational
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np
import sympy

from kousoku.model.errors import DerivationError
from kousoku.model.text import near_name
from kousoku.symbolic.matrices import elements

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.model.files.quantity import Quantity
    from kousoku.symbolic.derivation import Derivation, DerivedOutput

#: Digits to which a root, a sine or an angle is computed before it is rounded to a double.
DIGITS = 40


def values_at(
    derivation: Derivation, numbers: Mapping[str, Any], outputs: Sequence[str] | None
) -> dict[str, Any]:
    """Values for :meth:`kousoku.symbolic.derivation.Derivation.at`."""
    inputs = derivation.inputs
    for name in numbers:
        _require("input", name, derivation, inputs)
    wanted = _wanted(derivation, set(numbers), outputs)
    symbols: dict[Any, Any] = {}
    sorts: set[str] = set()
    for name, value in numbers.items():
        cells = _cells(f"{derivation.name}.at: {name}", inputs[name], value)
        sorts |= {_sort(cell) for cell in cells}
        symbols |= zip(elements(inputs[name]), map(_exact, cells), strict=True)
    finish = _finish(sorts)
    known: dict[Any, Any] = symbols
    arrays = {}
    for output in wanted:
        values = [finish(_value(x, known)) for x in output.components]
        array = np.empty(len(values), dtype=float if "float" in sorts else object)
        array[:] = values
        arrays[output.quantity.name] = array.reshape(output.quantity.shape)
    return arrays


def _wanted(
    derivation: Derivation, given: set[str], names: Sequence[str] | None
) -> list[DerivedOutput]:
    """Outputs that are asked for, or all for which the given inputs suffice."""
    where = f"{derivation.name}.at"
    if isinstance(names, str):
        names = (names,)
    for name in names or ():
        _require("output", name, derivation, derivation.outputs)
    wanted: list[DerivedOutput] = []
    used: set[str] = set()
    lacking: dict[str, tuple[dict[str, None], list[str]]] = {}
    for function in derivation.functions:
        needs = {quantity.name: None for quantity in function.inputs}
        asked = [o for o in function.outputs if names is None or o.quantity.name in names]
        missing = [name for name in needs if name not in given]
        if asked and not missing:
            wanted += asked
            used |= needs.keys()
        elif asked:
            lacking[", ".join(o.quantity.name for o in asked)] = (needs, missing)
    # Inputs that are given and unused were meant for outputs that lack another input.
    unused = given - used
    short = {
        outputs: missing
        for outputs, (needs, missing) in lacking.items()
        if names is not None or not wanted or unused & needs.keys()
    }
    if short:
        outputs, missing = min(short.items(), key=lambda item: len(item[1]))
        raise DerivationError(
            f"{where}: {outputs} cannot be had without {', '.join(missing)}; give it"
        )
    return wanted


def _require(what: str, name: str, derivation: Derivation, known: Mapping[str, Any]) -> None:
    if name not in known:
        raise DerivationError(
            f"{derivation.name}.at: no {what} {name!r}: there are {', '.join(known)}"
            f"{near_name(name, known)}"
        )


def _cells(where: str, quantity: Quantity, value: Any) -> list[Any]:
    """Cells of a list of numbers, row by row."""
    if isinstance(value, sympy.MatrixBase):
        value = value.tolist() if len(quantity.shape) > 1 else list(value)
    try:
        array = np.array(value, dtype=object)
    except ValueError:
        array = np.empty((0, 0, 0))
    if array.shape != quantity.shape:
        got = "rows of unequal length" if array.ndim == 3 else f"shape {array.shape}"
        raise DerivationError(f"{where} has {got}; wanted {quantity.shape}, {quantity.meaning}")
    cells: list[Any] = array.ravel().tolist()
    for cell in cells:
        if not _sort(cell):
            raise DerivationError(
                f"{where}: {cell!r} is not a finite real number; wanted a float, an integer, a "
                "fraction, mpmath's mpf or an exact number of SymPy"
            )
    return cells


def _sort(x: Any) -> str:
    """Sort of a number; nothing where it is none, or not finite."""
    if isinstance(x, sympy.Expr):
        if isinstance(x, sympy.Float):
            return "float"
        return "exact" if x.is_number and x.is_real else ""
    if isinstance(x, mpmath.mpf):
        return "mpf" if mpmath.isfinite(x) else ""
    if isinstance(x, float | np.floating):
        return "float" if np.isfinite(x) else ""
    return "exact" if isinstance(x, Rational) and not isinstance(x, bool) else ""


def _exact(x: Any) -> Any:
    """Number as SymPy's exact one; a float is the fraction that it stands for."""
    match x:
        case mpmath.mpf():
            return sympy.Rational(x.man) * sympy.Integer(2) ** x.exp
        case sympy.Float():
            return sympy.Rational(x)
        case sympy.Expr():
            return x
        case float() | np.floating():
            return sympy.Rational(*x.as_integer_ratio())
    return sympy.Rational(int(x.numerator), int(x.denominator))


def _value(x: Any, known: dict[Any, Any]) -> Any:
    """Value of a formula; repeated parts are computed once."""
    value = known.get(x)
    if value is None:
        value = known[x] = x.func(*(_value(arg, known) for arg in x.args)) if x.args else x
    return value


def _finish(sorts: set[str]) -> Callable[[Any], Any]:
    if "float" in sorts:
        return _float
    return _mpf if "mpf" in sorts else lambda x: x


def _float(x: Any) -> float:
    """Nearest double."""
    if not x.is_real:  # a pole, or no real root
        return np.nan
    exact = x if x.is_Rational else sympy.Rational(sympy.N(x, DIGITS))
    try:
        return float(Fraction(int(exact.p), int(exact.q)))
    except OverflowError:
        return float(np.copysign(np.inf, int(exact.p)))


def _mpf(x: Any) -> Any:
    """Nearest number of mpmath's working precision."""
    return mpmath.mpf(sympy.N(x, mpmath.mp.dps + 10)) if x.is_real else mpmath.nan
