"""Distances that drivers prescribe: their own, and those that couplings make of their laws."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

from kousoku.model.numbers import precise
from kousoku.model.numbers.traced import Traced, at_scene
from kousoku.model.operations.expression import add, mul, number
from kousoku.model.text import in_words

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from kousoku.model.mechanics.multibody import Instance, System
    from kousoku.model.numbers.precise import High
    from kousoku.model.operations.expression import Expression

#: Factors up to this part of the largest in their row count as zero: rounding of doubles leaves as
#: much of factors that cancel, as where gears drive each other in a circle.
NO_FACTOR = 1e-12


class DrivenLength(NamedTuple):
    """A distance that is a function of time.

    Parameters
    ----------
    coordinate : int
        Its index in the system.
    law : Expression
        The function, in the unit of the scene.
    driver : str
        Name of the driver that prescribes it, and the joints and drivers that do so with it.
    """

    coordinate: int
    law: Expression
    driver: str


class _Row(NamedTuple):
    """Linear combination of rows: factors of coordinates, and the multiplier of each row."""

    factors: Mapping[int, High]
    multipliers: Mapping[int, High]

    def times(self, factor: High) -> _Row:
        """Multiple of it."""
        return _Row(*({k: factor * x for k, x in part.items()} for part in self))

    def plus(self, other: _Row) -> _Row:
        """Sum with another one."""
        return _Row(*map(_sum, self, other))

    def without(self, index: int, pivot: _Row) -> _Row:
        """Row without a coordinate: minus a multiple of a pivot row, whose factor of it is 1."""
        factor = self.factors.get(index)
        if factor is None:
            return self
        reduced = self.plus(pivot.times(-factor))
        return reduced._replace(factors={k: x for k, x in reduced.factors.items() if k != index})

    def cleaned(self, size: float) -> _Row:
        """Row without factors that are rounding of numbers of such a size."""
        factors = {k: x for k, x in self.factors.items() if abs(at_scene(x)) > NO_FACTOR * size}
        return self._replace(factors=factors)


def _sum(a: Mapping[int, High], b: Mapping[int, High]) -> dict[int, High]:
    return {**a, **b, **{k: a[k] + b[k] for k in a.keys() & b.keys()}}


def driven_lengths(system: System, laws: Mapping[int, Expression]) -> Iterator[DrivenLength]:
    """Distances of a system that drivers determine.

    Parameters
    ----------
    system : System
        The scene.
    laws : mapping of int to Expression
        Parsed laws of drivers, by the indices of these among the constraints.
    """
    originals = _originals(system)
    drivers = {originals[system.constraints[k].terms[0].coordinate]: k for k in laws}
    distances = [k for k, coordinate in enumerate(system.coordinates) if coordinate.is_distance]
    coupled = {}
    if not {originals[k] for k in distances} <= drivers.keys():
        coupled = _determined(system.constraints, originals)
    for index, original in zip(distances, map(originals.__getitem__, distances), strict=True):
        if original in drivers:
            k = drivers[original]
            yield DrivenLength(index, laws[k], system.constraints[k].joint)
        elif original in coupled:
            yield _coupled(index, coupled[original], system, laws)


def _originals(system: System) -> list[int]:
    """Index of the first coordinate that measures the same as each; angles count turns.

    A driver of a point adds such coordinates.
    """
    first: dict[tuple[object, ...], int] = {}
    return [
        first.setdefault((u.kind, u.i, u.j, u.constants, index * u.counts_turns), index)
        for index, u in enumerate(system.coordinates)
    ]


def _coupled(
    index: int, multipliers: Mapping[int, High], system: System, laws: Mapping[int, Expression]
) -> DrivenLength:
    """Distance that rows determine together: u = Σ multiplier · (unit · law − offset)."""
    terms, unit = [], precise.number(system.unit)
    least = NO_FACTOR * max(float(abs(at_scene(x))) for x in multipliers.values())
    multipliers = {k: x for k, x in multipliers.items() if abs(at_scene(x)) > least}
    for k, multiplier in multipliers.items():
        row, factor = system.constraints[k], multiplier / unit
        terms.append(_formula(-(factor * precise.number(row.offset))))
        if k in laws:
            terms.append(mul(_formula(factor * precise.number(row.law_unit)), laws[k]))
    keys = dict.fromkeys(
        ("drivers." if k in laws else "joints.") + system.constraints[k].joint
        for k in sorted(multipliers, key=lambda k: k not in laws)
    )
    first, *others = keys
    driver = f"{first} with {in_words(others)}" if others else first
    return DrivenLength(index, add(*terms), driver.removeprefix("drivers."))


def _formula(value: High) -> Expression:
    """Formula of a number, which a run computes in doubles."""
    return value.expression if isinstance(value, Traced) else number(Fraction(float(value)))


def _determined(
    constraints: Sequence[Instance], originals: Sequence[int]
) -> dict[int, Mapping[int, High]]:
    """Multipliers of the rows that determine one coordinate, by its index.

    By Gauss-Jordan elimination.
    """
    pivots: dict[int, _Row] = {}
    for k, constraint in enumerate(constraints):
        if not constraint.is_combination:
            continue
        row = _Row({}, {k: precise.number(1.0)})
        for term in constraint.terms:
            row = row.plus(_Row({originals[term.coordinate]: precise.number(term.factor)}, {}))
        size = max(abs(float(term.factor)) for term in constraint.terms)
        for index, pivot in pivots.items():
            row = row.without(index, pivot)
        row = row.cleaned(size)
        if not row.factors:
            continue  # other rows imply it
        index = max(row.factors, key=lambda index: float(abs(at_scene(row.factors[index]))))
        row = row.times(1 / row.factors[index])
        pivots = {k: pivot.without(index, row).cleaned(1.0) for k, pivot in pivots.items()}
        pivots[index] = row
    return {k: row.multipliers for k, row in pivots.items() if row.factors.keys() == {k}}
