"""Kinks, jumps and poles of formulas of a motion, and parts of them that vary fast."""

from __future__ import annotations

from fractions import Fraction
from functools import reduce
from itertools import chain, product
from math import isfinite, pi, prod
from typing import TYPE_CHECKING

from kousoku.model.expressions.derivative import derivative
from kousoku.model.expressions.exponentials import without_overflow
from kousoku.model.expressions.formulas import TIME
from kousoku.model.expressions.polynomials import (
    is_never_zero,
    root_exponent,
    root_of_even_power,
    square_part,
)
from kousoku.model.expressions.ranges import fraction_of, range_of
from kousoku.model.operations.expression import (
    ONE,
    ZERO,
    Expression,
    add,
    apply,
    mul,
    names_of,
    neg,
    number,
    ordered,
    power,
    replaced,
    symbol,
)
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Iterator, Mapping


#: Functions with a kink or a jump.
SWITCHES = frozenset({Op.MIN, Op.MAX, Op.ABS, Op.SIGN})
#: Powers from this exponent on have two derivatives where their base is zero.
SMOOTH = 2
#: Polynomials up to this degree vary no faster than the stages of a step see: (1 - t^2)^n is a hill
#: of a width of 1.7/sqrt(n) in an interval of 2, a third of it for n = 6.
HIGHEST = 12
#: Products of sums are watched term by term if there are no more.
MOST_TERMS = 16
#: Functions with a jump, or that jump through infinity.
JUMPING = frozenset({Op.SIGN, Op.TAN, Op.ATAN2})
#: Functions that are bounded where their argument is infinite, too.
BOUNDED = frozenset({Op.SIGN, Op.SIN, Op.COS, Op.ATAN, Op.ATAN2})
#: Functions that may go smoothly through a place where their argument is infinite.
COMPRESSING = frozenset({Op.ATAN, Op.ATAN2, Op.DIV, Op.EXP, Op.POW})
#: Functions whose arguments may be watched in their place.
TRANSPARENT = frozenset({*SWITCHES, Op.ADD, Op.NEG, Op.MUL})


def square(a: Expression) -> Expression:
    """Square of an expression."""
    return mul(a, a)


def squares_of(formula: Expression) -> Iterator[Expression]:
    """Squares of distances in a formula: never negative, they may come down to zero.

    They stand in roots or in divisors: x/sqrt(x^2 + y^2) turns round, and ``atan2(y, x)``.
    """
    for part in ordered(formula):
        candidates: Iterable[Expression] = ()
        radicand = None  # the root has no value where this is negative
        match part:
            case Expression(Op.ATAN2, (a, b)):
                candidates = (add(square(a), square(b)),)
            case Expression(Op.SQRT | Op.LOG, (a,)) if even_root(part) is None:
                candidates, radicand = _zero_crossings(a), a
            case Expression(Op.DIV, (_, a)):
                candidates = _zero_crossings(a)
            case Expression(Op.POW, (a, Expression(value=power))) if even_root(part) is None:
                if power is None or power.denominator > 1:
                    candidates, radicand = _zero_crossings(a), a
                elif power < 0:
                    candidates = _zero_crossings(a)
        for candidate in candidates:
            if (candidate == radicand or range_of(candidate)[0] >= 0.0) and may_be_zero(candidate):
                yield candidate


def switching_functions(formula: Expression) -> Iterator[Expression]:
    """Functions that are zero where a formula kinks or jumps: of ``max(a, b)`` it is a − b.

    ``abs(a)*a`` has neither, and is as large on both sides; ``sqrt(a^2)`` is ``abs(a)``;
    ``atan(1/a)`` jumps where a is zero, and ``atan2(a, b)`` where b is negative there.
    """
    smooth = {id(factor) for part in ordered(formula) for factor in _signed_squares(part)}
    divided = {id(factor) for part in ordered(formula) for factor in _divided_magnitudes(part)}
    for part in ordered(formula):
        if part.op in SWITCHES and (id(part) not in smooth or id(part) in divided):
            first, *rest = part.args
            yield add(first, *map(neg, rest))
        elif (root := even_root(part)) is not None and root[1] < SMOOTH:
            yield root[0]
        else:
            yield from _angle_jumps(part)


def jumping_functions(formula: Expression) -> Iterator[Expression]:
    """Switching functions that are zero where a formula jumps, or may do so."""
    divided = {id(factor) for part in ordered(formula) for factor in _divided_magnitudes(part)}
    for part in ordered(formula):
        if part.op is Op.SIGN or id(part) in divided:
            yield part.args[0]
        else:
            yield from _angle_jumps(part)


def _angle_jumps(part: Expression) -> Iterator[Expression]:
    """Functions that are zero where an angle jumps."""
    if part.op is Op.ATAN2 and range_of(part.args[1])[0] < 0.0:
        yield from filter(may_be_zero, _sign_changing_factors(part.args[0]))
    elif part.op is Op.ATAN:
        yield from _divisors_of(part)


def _divisors_of(formula: Expression) -> Iterator[Expression]:
    """Divisors in a formula that may be zero."""
    for part in ordered(formula):
        if part.op is Op.DIV:
            yield from filter(may_be_zero, _zero_crossings(part.args[1]))


def edges_of(formula: Expression) -> Iterator[Expression]:
    """Functions that are negative where a root, a logarithm or an arc sine has no value."""
    for part in ordered(formula):
        edge = None
        if part.op in {Op.SQRT, Op.LOG}:
            edge = part.args[0]
        elif part.op is Op.POW:
            a, exponent = part.args[0], part.args[1].value
            edge = a if exponent is None or exponent.denominator > 1 else None
        elif part.op in {Op.ASIN, Op.ACOS}:
            least, most = range_of(part.args[0])
            edge = None if -1.0 <= least <= most <= 1.0 else _inside(part.args[0])
        if edge is not None and range_of(edge)[0] < 0.0:
            yield edge


def _inside(a: Expression) -> Expression:
    """Function that is positive where a number has an arc sine."""
    return add(ONE, neg(apply(Op.ABS, a)))


def even_root(part: Expression) -> tuple[Expression, Fraction] | None:
    """Base a and exponent b of a root of an even power of a, which is abs(a) to the power b."""
    root = root_of_even_power(part)
    return None if root is None or root[1] % 2 == 0 else root


def has_fractional_power(formula: Expression, varying: Collection[str]) -> bool:
    """Whether a formula has a fractional power, below two, of a base that varies and may be zero.

    So do arc sines and arc cosines at their ends, and functions of a logarithm may.
    """
    for part in ordered(formula):
        if not part.args or not _changes(part.args[0], varying):
            continue
        exponent, even = root_exponent(part), even_root(part)
        exponent = exponent if even is None else even[1]
        is_power = exponent is not None and exponent < SMOOTH  # below zero beside a zero, too
        is_power = is_power or (part.op is Op.POW and part.args[1].value is None)
        if (is_power or part.op is Op.LOG) and may_be_zero(part.args[0]):
            return True
        if part.op in {Op.ASIN, Op.ACOS} and may_be_zero(_inside(part.args[0])):
            return True
    return False


def breaks_of_law(law: Expression) -> Iterator[Expression]:
    """Functions that are zero where the law of a driver or a derivative of it may jump."""
    yield from switching_functions(law)
    for part in ordered(law):
        singular = _singular_function(part)
        if singular is not None:
            yield from filter(may_be_zero, _sign_changing_factors(singular))


def poles_of(
    formula: Expression, varying: Collection[str], *, in_divisors: bool = True
) -> Iterator[Expression]:
    """Functions that are zero where a formula may be infinite, as far as it varies.

    Where a divisor is infinite the quotient is zero, but its bounds are lost.
    """
    for part in _unbounded_parts(formula, varying, in_divisors=in_divisors):
        singular = None
        if part.op in {Op.DIV, Op.LOG}:
            singular = _singular_function(part) or part.args[0]
        elif part.op is Op.TAN:
            least, most = range_of(part.args[0])
            singular = None if -pi / 2 < least <= most < pi / 2 else _singular_function(part)
        elif part.op is Op.POW:
            exponent = part.args[1].value
            singular = part.args[0] if exponent is None or exponent <= 0 else None
        for zero in _zero_crossings(singular) if singular is not None else ():
            if may_be_zero(zero) and _changes(zero, varying):
                yield zero


def _unbounded_parts(
    formula: Expression, varying: Collection[str], *, in_divisors: bool
) -> Iterator[Expression]:
    """Parts of a formula, but not the arguments of functions that are always bounded."""
    stack, seen = [formula], set()
    while stack:
        part = stack.pop()
        if id(part) not in seen:
            seen.add(id(part))
            yield part
            args = part.args
            if part.op in BOUNDED or (part.op is Op.EXP and not _grows(part, varying)):
                args = ()
            elif not in_divisors and part.op is Op.DIV:
                args = args[:1]
            elif not in_divisors and part.op is Op.POW and _sign(args[1]) < 0:
                args = ()
            stack.extend(reversed(args))


def summands(formula: Expression) -> Iterator[Expression]:
    """Summands of a formula, but for their signs: a product may be finite where a factor is not."""
    for term in _signed_summands(formula):
        yield term.args[0] if term.op is Op.NEG else term


def _signed_summands(formula: Expression) -> Iterator[Expression]:
    """Summands of a formula with their signs."""
    if formula.op is Op.ADD:
        yield from chain.from_iterable(map(_signed_summands, formula.args))
    elif formula.op is Op.NEG:
        yield from map(neg, _signed_summands(formula.args[0]))
    else:
        yield formula


def _zero_crossings(formula: Expression) -> Iterator[Expression]:
    """Functions that change sign where a formula is zero: its factors, and radicands."""
    match formula:
        case Expression(Op.MUL, args):
            yield from chain.from_iterable(map(_zero_crossings, args))
        case Expression(Op.NEG | Op.ABS | Op.SQRT | Op.DIV, (a, *_)):
            yield from _zero_crossings(a)
        case Expression(Op.POW, (a, Expression(value=Fraction() as b))) if b > 0:
            yield from _zero_crossings(a)
        case _:
            yield from _sign_changing_factors(formula)


def _sign_changing_factors(formula: Expression) -> tuple[Expression, ...]:
    """Factors of a formula that change sign where it is zero: 1 - 2*t + t^2 only touches zero."""
    squares = square_part(formula)
    return (formula,) if squares is None else (squares.rest, *(a for a, _ in squares.powers))


def _singular_function(part: Expression) -> Expression | None:
    """Function that is zero where a formula, or a derivative of it, is infinite or jumps."""
    match part:
        case Expression(Op.SQRT | Op.LOG, (a,)):
            return a if even_root(part) is None else None
        case Expression(Op.DIV, (_, b)):
            return b
        case Expression(Op.POW, (a, Expression(value=exponent))):
            if exponent is None or exponent < 0:
                return a
            is_root = exponent.denominator > 1 and exponent < SMOOTH
            return a if is_root and even_root(part) is None else None
        case Expression(Op.TAN, (a,)):
            return apply(Op.COS, a)
        case Expression(Op.ASIN | Op.ACOS, (a,)):
            return _inside(a)
        case Expression(Op.ATAN2, (a, b)):
            return apply(Op.MAX, apply(Op.ABS, a), b)
    return None


def may_be_zero(expression: Expression) -> bool:
    """Whether a formula may be zero, as far as the ranges of its functions tell.

    Of polynomials in one variable it is known.
    """
    least, most = range_of(expression)
    return least <= 0.0 <= most and not is_never_zero(expression)


def varies(formula: Expression) -> bool:
    """Whether a formula depends on the time."""
    return TIME in names_of(formula)


def with_rates(law: Expression) -> tuple[Expression, ...]:
    """Law of a driver and its first and second derivative by the time."""
    law = without_overflow(law)
    rate = derivative(law, TIME)
    return law, rate, derivative(rate, TIME)


def may_jump(formula: Expression, varying: Collection[str]) -> bool:
    """Whether a formula may jump where names vary, also through infinity.

    A quotient does so where its divisor may be zero, as far as :func:`may_be_zero` tells.
    """
    jumps = filter(is_jump, ordered(formula))
    singular = (_singular_function(jump) or jump for jump in jumps)  # a sign may be zero itself
    return any(may_be_zero(f) and _changes(f, varying) for f in singular)


def is_jump(part: Expression) -> bool:
    """Whether the last function of a formula is one that may jump, also to infinity."""
    if part.op is Op.DIV:
        return part.args[1].value is None
    if part.op is Op.POW:
        exponent = part.args[1].value
        return exponent is None or exponent < 0
    return part.op in JUMPING


def _signed_squares(part: Expression) -> Iterator[Expression]:
    """Factors ``abs(a)`` of a product that has a factor a, too."""
    factors = list(_factors(part))
    for factor in factors if len(factors) > 1 else ():
        if factor.op is Op.ABS:
            (inside,) = factor.args
            if inside in factors:
                yield factor


def _divided_magnitudes(part: Expression) -> Iterator[Expression]:
    """Absolute values in a dividend that share a name with a divisor that may be zero."""
    if part.op is not Op.DIV or part.args[1].value is not None:
        return
    names = set(names_of(part.args[1]))
    sizes = [size for size in ordered(part.args[0]) if size.op is Op.ABS]
    if sizes and may_be_zero(part.args[1]):
        yield from (size for size in sizes if not names.isdisjoint(names_of(size)))


def _factors(part: Expression) -> Iterator[Expression]:
    """Factors of a product, but for their signs."""
    while part.op in {Op.MUL, Op.NEG}:
        if part.op is Op.MUL:
            yield part.args[1]
        part = part.args[0]
    yield part


def varying_parts(
    formula: Expression, varying: Collection[str]
) -> Iterator[tuple[Expression, Expression]]:
    """Smooth functions whose sum or extreme a formula is, except polynomials of low degree.

    Where they vary much faster than elsewhere, a step of the usual length may skip it. Products and
    powers of them vary faster than they do: these are taken as a whole. A narrow part may also hide
    behind a wide one in the argument of a function, as in sin(x + exp(-u²)/100): what is smooth in
    such a sum is taken, too.
    Names that are not among the varying ones do not change in a run. With each function comes the
    constant that it is multiplied by, so that their product is in the unit of the formula.
    """
    varies: dict[int, bool] = {}
    degrees: dict[int, Fraction] = {}
    made: list[Expression] = []
    opened: dict[int, Expression] = {}  # what is looked into of a part that is times a slope

    def is_varying(formula: Expression) -> bool:
        made.append(formula)  # as long as it is there no other has its id
        for part in ordered(formula) if id(formula) not in varies else ():
            degree = degrees[id(part)] = _degree_of(part, varying, degrees)
            is_fast = bool(part.args) and (degree > HIGHEST or not _is_transparent(part, varying))
            is_fast = is_fast and degree > 0
            varies[id(part)] = is_fast or any(varies[id(arg)] for arg in part.args)
        return varies[id(formula)]

    stack, seen = [(formula, ONE)], set()
    while stack:
        part, factor = stack.pop()
        if (id(part), factor) in seen or not is_varying(part):
            continue
        seen.add((id(part), factor))
        terms = _distributed(part, is_varying)
        if len(terms) > 1:
            stack.extend((term, factor) for term in reversed(terms))
            continue
        fast = [arg for arg in part.args if varies[id(arg)]]
        slow = [arg for arg in part.args if not varies[id(arg)]]
        changes = any(name in varying for arg in slow for name in names_of(arg))
        is_whole = part.op is Op.POW or (part.op is Op.MUL and (changes or len(fast) != 1))
        if is_whole or not _is_transparent(part, varying):
            yield part, factor
            inside = opened.get(id(part), part)
            for term, slope in reversed([*_hidden_terms(inside, varying, is_varying)]):
                made.append(mul(slope, term))
                opened[id(made[-1])] = term
                stack.append((made[-1], factor))
            continue
        if part.op in {Op.MUL, Op.DIV}:
            factor = apply(part.op, factor, *slow)
        stack.extend((arg, factor) for arg in reversed(fast))


def _hidden_terms(
    formula: Expression, varying: Collection[str], is_varying: Callable[[Expression], bool]
) -> Iterator[tuple[Expression, Expression]]:
    """Terms that vary fast beside others in arguments of functions, and in factors of products.

    Beside a constant, too: 1 + exp(-u²)/10 is large beside what its hill adds. Not where they may
    overflow, or be infinite while the function is not, as in the pulses 1/(exp(u) + exp(-u)) and
    atan(u + 1/u²): the function is watched itself, and those factors of the term that are finite.
    With each comes the slope of its function.
    """
    for function in ordered(formula):
        if function.op is Op.MUL:  # what is multiplied by a constant is an argument itself
            factors = [x for x in _factors(function) if _changes(x, varying)]
            arguments = factors if len(factors) > 1 else []
        elif _is_transparent(function, varying) and function.op is not Op.POW:
            continue
        else:
            arguments = [*function.args]
        for argument in arguments:
            addends = []
            for addend, others in _addends(argument, varying):
                terms = _distributed(addend, is_varying)
                for k, term in enumerate(terms):
                    addends.append((term, add(others, *terms[:k], *terms[k + 1 :])))
            is_beside = len(addends) > 1 or _is_offset(function, argument, varying)
            for term, others in addends if is_beside else ():
                if is_varying(term) and _is_watchable(term, function, varying):
                    yield term, _slope_at(others, function, argument, varying)
                elif is_varying(term):
                    above = fraction_of(term)[1]
                    constant = mul(*(factor for factor in above if not _changes(factor, varying)))
                    for factor in above:
                        if is_varying(factor) and _is_watchable(factor, function, varying):
                            yield factor, constant


def _is_watchable(term: Expression, function: Expression, varying: Collection[str]) -> bool:
    """Whether a term in an argument is finite wherever the function is, and does not overflow.

    Parameters may have any sign, or be above zero as they mostly are: w² + (x − c)² is no pole.
    """
    for form in map(without_overflow, (term, _with_numbers(term, varying))):
        may_be_infinite = any(poles_of(form, varying, in_divisors=False))
        is_finite = function.op not in COMPRESSING or not may_be_infinite
        if is_finite and not _grows(form, varying):
            return True
    return False


def _is_offset(function: Expression, argument: Expression, varying: Collection[str]) -> bool:
    """Whether a function is not zero where an argument is, so that a hill in it adds to a size."""
    if function.op is Op.EXP:  # exp(-u²) is zero where u is large, and shows how it varies itself
        even = [factor for factor in _factors(argument) if _is_even(factor)]
        return all(isfinite(end) for factor in even for end in _range_as_told(factor, varying))
    if function.op is Op.ATAN2:  # so does atan2(sin(x), cos(x)): waves are no hills
        wave = argument.args[0] if argument.op is Op.ABS else argument
        is_alone = sum(_changes(arg, varying) for arg in function.args) == 1
        return is_alone or wave.op not in {Op.SIN, Op.COS}
    is_second = function.op in {Op.DIV, Op.POW} and argument is not function.args[0]
    return is_second or function.op in {Op.COS, Op.ACOS}


def _slope_at(
    others: Expression, function: Expression, argument: Expression, varying: Collection[str]
) -> Expression:
    """Slope of a power or an exponential where its argument is the others' sum.

    Of other functions, and where the slope may be infinite, it is taken as one.
    """
    exponent = function.args[1].value if function.op is Op.POW else None
    slope = ONE
    if function.op is Op.EXP:
        slope = apply(Op.EXP, others)
    elif exponent is not None and exponent.denominator == 1 and argument is function.args[0]:
        slope = mul(number(exponent), power(others, number(exponent - 1)))
    return ONE if any(poles_of(slope, varying)) else slope


def _addends(
    formula: Expression, varying: Collection[str]
) -> Iterator[tuple[Expression, Expression]]:
    """Terms of a sum, also of one that is multiplied by a constant, or has a kink.

    With each comes what is left of the formula without it.
    """
    if formula.op in {Op.ADD, Op.NEG, Op.ABS, Op.MIN, Op.MAX}:
        args = formula.args
        for k, arg in enumerate(args):
            for term, others in _addends(arg, varying):
                yield term, apply(formula.op, *args[:k], others, *args[k + 1 :])
        return
    if formula.op in {Op.MUL, Op.DIV}:
        first, second = formula.args
        is_first, is_second = (_changes(arg, varying) for arg in (first, second))
        if is_first and not is_second:
            for term, others in _addends(first, varying):
                yield apply(formula.op, term, second), apply(formula.op, others, second)
            return
        if is_second and not is_first and formula.op is Op.MUL:
            for term, others in _addends(second, varying):
                yield mul(first, term), mul(first, others)
            return
    yield formula, ZERO


def _grows(formula: Expression, varying: Collection[str]) -> bool:
    """Whether an exponential in a formula may overflow: no hill as exp(-u²), no wave."""
    for part in ordered(formula):
        exponent = part.args[-1] if part.op in {Op.EXP, Op.POW} else None
        if exponent is None or not _changes(exponent, varying):
            continue
        if not isfinite(_range_as_told(exponent, varying)[1]):
            terms = [x for x in _signed_summands(exponent) if _changes(x, varying)]
            if not any(_sign(x) <= 0 and _makes_well(x) for x in terms):
                return True
    return False


def _with_numbers(formula: Expression, varying: Collection[str]) -> Expression:
    """Formula with a number in place of each name that does not vary: all differ, near to 1."""
    fixed = [name for name in names_of(formula) if name not in varying]
    for k, name in enumerate(fixed):
        formula = replaced(formula, symbol(name), number(1 + Fraction(1, 97 + k)))
    return formula


def _range_as_told(formula: Expression, varying: Collection[str]) -> tuple[float, float]:
    """Least and greatest value of a formula where parameters are as usual."""
    return range_of(_with_numbers(formula, varying))


def _makes_well(term: Expression) -> bool:
    """Whether a term is large on both sides; a logarithm of exponentials on that of each."""
    _, factors, _ = fraction_of(term)
    return _is_even(term) or any(factor.op is Op.LOG_SUM for factor in factors)


def _sign(formula: Expression) -> int:
    """Sign of a formula, which may be zero, too; 0 where it is not known."""
    least, most = range_of(formula)
    return int(least >= 0.0) - int(most <= 0.0)


def _is_even(part: Expression) -> bool:
    """Whether a product has an even power as a factor, or an absolute value."""
    _, factors, _ = fraction_of(part)
    for factor, count in factors.items():
        power = factor.args[1].value if factor.op is Op.POW else None
        is_power = power is not None and power % 2 == 0
        is_product = factor.op in {Op.MUL, Op.DIV, Op.NEG}
        if is_power or count % 2 == 0 or factor.op is Op.ABS or (is_product and _is_even(factor)):
            return True
    return False


def _distributed(formula: Expression, is_varying: Callable[[Expression], bool]) -> list[Expression]:
    """Terms of a product with sums of what varies fast and of what does not, but for their signs.

    In such a sum a narrow part would hide behind a wide factor: x (1 + exp(−u²)/100). Other
    formulas are their own term.
    """
    if formula.op is not Op.MUL:
        return [formula]
    sums = []
    for factor in _factors(formula):
        terms = list(summands(factor))
        is_sum = len(terms) > 1 and any(map(is_varying, terms))
        sums.append(terms if is_sum else [factor])
    if not 1 < prod(map(len, sums)) <= MOST_TERMS:
        return [formula]
    return [reduce(mul, factors) for factors in product(*sums)]


def _changes(formula: Expression, varying: Collection[str]) -> bool:
    """Whether a formula depends on one of the names that vary."""
    return not set(varying).isdisjoint(names_of(formula))


def _degree_of(
    part: Expression, varying: Collection[str], degrees: Mapping[int, Fraction]
) -> Fraction:
    """Degree of a polynomial in what varies; of other functions that of their arguments."""
    arg_degrees = [degrees[id(arg)] for arg in part.args]
    if part.op is Op.MUL:
        return sum(arg_degrees, Fraction(0))
    if part.op is Op.POW and part.args[1].value is not None:
        return arg_degrees[0] * max(part.args[1].value, Fraction(1))
    return max(arg_degrees, default=Fraction(_changes(part, varying)))


def _is_transparent(part: Expression, varying: Collection[str]) -> bool:
    """Whether a function of polynomials is a polynomial, but for kinks."""
    if part.op is Op.POW:
        exponent = part.args[1].value
        return exponent is not None and exponent.denominator == 1 and exponent >= 0
    if part.op is Op.DIV:
        return not any(name in varying for name in names_of(part.args[1]))
    return part.op in TRANSPARENT
