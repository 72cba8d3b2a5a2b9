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

#: Factors count as zero that are no more than this part of the largest in their row: rounding of
#: doubles leaves as much of what cancels, as where gears drive each other in a circle.
NO_FACTOR = 1e-12


class DrivenLength(NamedTuple):
    """A distance that is a function of time.

    Parameters
    ----------
    coordinate : int
        Its place in the system.
    law : Expression
        The function, in the unit of the scene.
    driver : str
        Name of the driver that prescribes it, and what else does with it.
    """

    coordinate: int
    law: Expression
    driver: str


class _Row(NamedTuple):
    """A sum of rows: factors of coordinates, and how often each row is in it."""

    factors: Mapping[int, High]
    shares: Mapping[int, High]

    def times(self, factor: High) -> _Row:
        """Multiple of it."""
        return _Row(*({k: factor * x for k, x in part.items()} for part in self))

    def plus(self, other: _Row) -> _Row:
        """Sum with another one."""
        return _Row(*map(_sum, self, other))

    def without(self, place: int, pivot: _Row) -> _Row:
        """Row without a coordinate, whose factor in another one is 1."""
        factor = self.factors.get(place)
        if factor is None:
            return self
        left = self.plus(pivot.times(-factor))
        return left._replace(factors={k: x for k, x in left.factors.items() if k != place})

    def cleaned(self, size: float) -> _Row:
        """Row without factors that are rounding of such a size."""
        kept = {k: x for k, x in self.factors.items() if abs(at_scene(x)) > NO_FACTOR * size}
        return self._replace(factors=kept)


def _sum(a: Mapping[int, High], b: Mapping[int, High]) -> dict[int, High]:
    return {**a, **b, **{k: a[k] + b[k] for k in a.keys() & b.keys()}}


def driven_lengths(system: System, laws: Mapping[int, Expression]) -> Iterator[DrivenLength]:
    """Distances of a system that drivers determine.

    Parameters
    ----------
    system : System
        The scene.
    laws : mapping of int to Expression
        Parsed laws of drivers, by the places of these among the constraints.
    """
    places = _first_places(system)
    own = {places[system.constraints[k].terms[0].coordinate]: k for k in laws}
    lengths = [k for k, one in enumerate(system.coordinates) if one.is_distance]
    coupled = {}
    if not {places[k] for k in lengths} <= own.keys():
        coupled = _determined(system.constraints, places)
    for place, first in zip(lengths, map(places.__getitem__, lengths), strict=True):
        if first in own:
            yield DrivenLength(place, laws[own[first]], system.constraints[own[first]].joint)
        elif first in coupled:
            yield _coupled(place, coupled[first], system, laws)


def _first_places(system: System) -> list[int]:
    """Place of the first coordinate that is the same as each, by another name; angles count turns.

    A driver of a point has such ones.
    """
    found: dict[tuple[object, ...], int] = {}
    return [
        found.setdefault((one.kind, one.i, one.j, one.constants, place * one.counts_turns), place)
        for place, one in enumerate(system.coordinates)
    ]


def _coupled(
    place: int, shares: Mapping[int, High], system: System, laws: Mapping[int, Expression]
) -> DrivenLength:
    """Distance that rows determine together: u = Σ share · (unit · law − offset)."""
    terms, unit = [], precise.number(system.unit)
    least = NO_FACTOR * max(float(abs(at_scene(share))) for share in shares.values())
    shares = {k: share for k, share in shares.items() if abs(at_scene(share)) > least}
    for k, share in shares.items():
        row, part = system.constraints[k], share / unit
        terms.append(_formula(-(part * precise.number(row.offset))))
        if k in laws:
            terms.append(mul(_formula(part * precise.number(row.law_unit)), laws[k]))
    keys = dict.fromkeys(
        ("drivers." if k in laws else "joints.") + system.constraints[k].joint
        for k in sorted(shares, key=lambda k: k not in laws)
    )
    first, *others = keys
    driver = f"{first} with {in_words(others)}" if others else first
    return DrivenLength(place, add(*terms), driver.removeprefix("drivers."))


def _formula(value: High) -> Expression:
    """Formula of a number, which a run computes in doubles."""
    return value.expression if isinstance(value, Traced) else number(Fraction(float(value)))


def _determined(
    constraints: Sequence[Instance], places: Sequence[int]
) -> dict[int, Mapping[int, High]]:
    """Shares of rows that are one coordinate alone, by its place.

    By the elimination of Gauss and Jordan.
    """
    pivots: dict[int, _Row] = {}
    for k, one in enumerate(constraints):
        if not one.is_combination:
            continue
        row = _Row({}, {k: precise.number(1.0)})
        for term in one.terms:
            row = row.plus(_Row({places[term.coordinate]: precise.number(term.factor)}, {}))
        size = max(abs(float(term.factor)) for term in one.terms)
        for place, pivot in pivots.items():
            row = row.without(place, pivot)
        row = row.cleaned(size)
        if not row.factors:
            continue  # others imply it
        place = max(row.factors, key=lambda place: float(abs(at_scene(row.factors[place]))))
        row = row.times(1 / row.factors[place])
        pivots = {other: one.without(place, row).cleaned(1.0) for other, one in pivots.items()}
        pivots[place] = row
    return {place: row.shares for place, row in pivots.items() if row.factors.keys() == {place}}
