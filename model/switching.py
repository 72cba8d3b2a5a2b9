"""What a formula of a motion does at certain times: where it switches, how fast it varies."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.expression import parse_expression
from kousoku.model.formulas import RATE, TIME
from kousoku.model.terms import Apply, Function, Number, add, names_of, neg, ordered

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.mechanism import System
    from kousoku.model.terms import Expression

#: Functions with a kink or a jump.
SWITCHES = frozenset({Function.MIN, Function.MAX, Function.ABS, Function.SIGN})
#: Functions of which those of their arguments may be looked at instead.
TRANSPARENT = frozenset({*SWITCHES, Function.ADD, Function.NEG, Function.MUL})


def formulas_of(system: System) -> Iterator[Expression]:
    """Yield all formulas of a system that may depend on time: forces, gravity, drivers."""
    texts = [text for force in system.forces for _, text in force.formulas]
    texts += [text for text in system.gravity_law if text]
    texts += [one.law for one in system.constraints if one.is_driver]
    values = [one.name for one in system.coordinates]
    names = {TIME, *(name for name, _ in system.parameters), *values}
    names.update(f"{name}{RATE}" for name in values)
    for text in dict.fromkeys(texts):
        yield parse_expression(text, names)


def switching_functions(formula: Expression) -> Iterator[Expression]:
    """Yield what is zero where a formula has a kink or a jump: of ``max(a, b)`` it is a − b."""
    for part in ordered(formula):
        if isinstance(part, Apply) and part.function in SWITCHES:
            first, *rest = part.args
            yield add(first, *map(neg, rest))


def varying_parts(formula: Expression) -> Iterator[Expression]:
    """Yield the smooth functions that a formula is a sum or an extreme of, polynomials not.

    Where they vary much faster than elsewhere, steps that were long enough step over it. Products
    and powers of them vary faster than they do: these are looked at as a whole.
    """
    varies: dict[int, bool] = {}
    for part in ordered(formula):
        own = isinstance(part, Apply) and not _is_transparent(part)
        args = part.args if isinstance(part, Apply) else ()
        varies[id(part)] = own or any(varies[id(arg)] for arg in args)
    stack, seen = [formula], set()
    while stack:
        part = stack.pop()
        if id(part) in seen or not (isinstance(part, Apply) and varies[id(part)]):
            continue
        seen.add(id(part))
        fast = [arg for arg in part.args if varies[id(arg)]]
        is_whole = part.function is Function.POW or (
            part.function is Function.MUL and len(fast) > 1
        )
        if is_whole or not _is_transparent(part):
            yield part
        else:
            stack.extend(reversed(fast))


def _is_transparent(part: Apply) -> bool:
    """Return whether a function of polynomials is one, but for kinks."""
    if part.function is Function.POW:
        exponent = part.args[1]
        return (
            isinstance(exponent, Number)
            and exponent.value.denominator == 1
            and (exponent.value.numerator >= 0)
        )
    if part.function is Function.DIV:
        return TIME not in names_of(part.args[1])
    return part.function in TRANSPARENT


def of_time(found: Iterator[Expression], system: System) -> tuple[Expression, ...]:
    """Return those of some formulas that depend on time and parameters only, each once."""
    fixed = {TIME, *(name for name, _ in system.parameters)}
    kept = []
    for one in found:
        names = names_of(one)
        if TIME in names and fixed.issuperset(names):
            kept.append(one)
    return tuple(dict.fromkeys(kept))
