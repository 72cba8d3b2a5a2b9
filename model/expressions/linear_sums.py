"""Bounds of linear sums of quantities that move together, as y − x of two bodies in one direction.

Intervals forget that both move: y − x may be anywhere between the least y less the largest x and
the reverse. Between two times, h apart, a quantity x within bounds of the width w, whose rate is
within δ of ρ, is on a line through the middle of both but for

    |x(t) − x_m − ρ (t − t_m)| ≤ ½ (w − |ρ| h) + δ h,

so that Σ c x is within ½ |Σ c ρ| h + Σ |c| (½ (w − |ρ| h) + δ h) of its middle.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

from kousoku.model.expressions.enclosure import Bounds, enclosure
from kousoku.model.operations.expression import (
    ONE,
    ZERO,
    Expression,
    add,
    apply,
    div,
    mul,
    names_of,
    neg,
    number,
    ordered,
    symbol,
)
from kousoku.model.operations.graph import Op

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

HALF = number(Fraction(1, 2))

Coefficients = dict[str, Expression]
"""Coefficients of a linear formula by the names that vary; what else it adds is left out."""


class LinearSum(NamedTuple):
    """Sum that is linear in two quantities or more that vary.

    Parameters
    ----------
    name : str
        What stands for it in formulas; its rate follows that.
    formula : Expression
        As it is written.
    coefficients : dict of Expression
        By the names that vary.
    """

    name: str
    formula: Expression
    coefficients: Coefficients

    @property
    def rate(self) -> str:
        """The name of its rate."""
        return f"{self.name}.rate"

    def bounds(
        self, time: str, rates: Mapping[str, Expression], spans: Mapping[str, Bounds]
    ) -> dict[str, Bounds]:
        """Bounds of it and its rate between two times.

        Parameters
        ----------
        time : str
            The name of the time.
        rates : mapping of str to Expression
            The rate of each name that varies, where it is known.
        spans : mapping of str to Bounds
            What bounds each name that varies, and each name in these rates.
        """
        h = add(spans[time].most, neg(spans[time].least))
        rate = add(*(mul(c, rates[name]) for name, c in self.coefficients.items()))
        linear = _linear_forms(rate, spans.keys())[id(rate)]
        is_known = linear is not None and rates.keys() >= linear.keys()
        return {
            self.name: _bounds(self.formula, self.coefficients, h, rates, spans),
            self.rate: _bounds(rate, linear, h, rates, spans)
            if linear is not None and is_known
            else enclosure(rate, spans),
        }


def _bounds(
    formula: Expression,
    coefficients: Coefficients,
    h: Expression,
    rates: Mapping[str, Expression],
    spans: Mapping[str, Bounds],
) -> Bounds:
    """Bounds of a linear sum between two times that are h [s] apart."""
    middles = {name: Bounds(*[_middle(spans[name])] * 2) for name in coefficients}
    middle = enclosure(formula, middles).least
    slope, spread = ZERO, ZERO
    for name, c in coefficients.items():
        span, rate = spans[name], enclosure(rates[name], spans)
        slope = add(slope, mul(c, _middle(rate)))
        if rate.is_point:  # of time
            continue
        width = add(span.most, neg(span.least))
        straight = mul(apply(Op.ABS, _middle(rate)), h)
        curve = mul(HALF, add(rate.most, neg(rate.least)), h)
        off = add(mul(HALF, apply(Op.MAX, add(width, neg(straight)), ZERO)), curve)
        spread = add(spread, mul(apply(Op.ABS, c), off))
    reach = add(mul(HALF, apply(Op.ABS, slope), h), spread)
    least, most = enclosure(formula, spans)
    return Bounds(
        apply(Op.MAX, add(middle, neg(reach)), least), apply(Op.MIN, add(middle, reach), most)
    )


def _middle(span: Bounds) -> Expression:
    return span.least if span.is_point else mul(HALF, add(span.least, span.most))


def without_linear_sums(
    formula: Expression, rates: Mapping[str, Expression]
) -> tuple[Expression, tuple[LinearSum, ...]]:
    """Formula with names for its largest linear sums of two quantities or more.

    Parameters
    ----------
    formula : Expression
        The formula.
    rates : mapping of str to Expression
        The rate of each name that varies.
    """
    sums: dict[Expression, LinearSum] = {}
    known: dict[int, Expression] = {}
    forms = _linear_forms(formula, rates.keys())
    for node in ordered(formula):
        coefficients = forms[id(node)]
        if node.op is Op.ADD and coefficients is not None and len(coefficients) > 1:
            if node not in sums:
                sums[node] = LinearSum(f".sum{len(sums)}", node, coefficients)
            known[id(node)] = symbol(sums[node].name)
        elif node.args:
            known[id(node)] = apply(node.op, *(known[id(arg)] for arg in node.args))
        else:
            known[id(node)] = node
    substituted = known[id(formula)]
    used = {*names_of(substituted)}  # not sums in larger ones
    return substituted, tuple(linear for linear in sums.values() if linear.name in used)


def _linear_forms(formula: Expression, varying: Collection[str]) -> dict[int, Coefficients | None]:
    """Coefficients of each part of a formula, None if it is not linear, by the part's id."""
    forms: dict[int, Coefficients | None] = {}
    for node in ordered(formula):
        args = [forms[id(arg)] for arg in node.args]
        form: Coefficients | None = None
        if not node.args:
            form = {node.name: ONE} if node.name in varying else {}
        elif not any(args) and None not in args:
            form = {}
        elif node.op is Op.ADD and None not in args:
            form = {}
            for terms in args:
                for name, c in (terms or {}).items():
                    form[name] = add(form.get(name, ZERO), c)
        elif node.op is Op.NEG and args[0] is not None:
            form = {name: neg(c) for name, c in args[0].items()}
        elif node.op is Op.DIV and args[0] is not None and args[1] == {}:
            form = {name: div(c, node.args[1]) for name, c in args[0].items()}
        elif node.op is Op.MUL and None not in args and sum(map(bool, args)) == 1:
            k = next(k for k, terms in enumerate(args) if terms)
            others = mul(*(arg for n, arg in enumerate(node.args) if n != k))
            form = {name: mul(c, others) for name, c in (args[k] or {}).items()}
        forms[id(node)] = form
    return forms
