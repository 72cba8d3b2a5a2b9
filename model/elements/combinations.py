"""Rows that combine coordinates, as screws, constant velocity joints and couplings have."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.mechanics.constraints import COMBINATION
from kousoku.model.mechanics.multibody import Instance, Term
from kousoku.model.numbers import precise
from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.traced import NOISE, Traced

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.lowering.coordinates import CoordinateList
    from kousoku.model.numbers.precise import High


def as_written(
    name: str, terms: Sequence[tuple[int, High]], coordinates: CoordinateList
) -> Instance:
    """Combination that is zero at the positions as they are written."""
    summands = [factor * coordinates.value(index) for index, factor in terms]
    offset = -precise.total(summands)
    if not isinstance(offset, Traced) and abs(offset) <= NOISE * sum(map(abs, summands)):
        offset = CONTEXT.mpf(0)
    return combination(name, terms, offset, coordinates)


def combination(
    name: str, terms: Sequence[tuple[int, High]], offset: High, coordinates: CoordinateList
) -> Instance:
    """Instance Σ factor · coordinate + offset = 0; terms are (index, factor)."""
    records = [coordinates.record(index) for index, _ in terms]
    bodies = dict.fromkeys(body for record in records for body in (record.i, record.j))
    i, j = coordinates.ends(terms[0][0])
    units = [coordinates.unit_of(index)[0] for index, _ in terms]
    return Instance(
        name,
        COMBINATION,
        i,
        j,
        terms=tuple(Term(index, precise.double(factor)) for index, factor in terms),
        others=tuple(body for body in bodies if body not in (i, j)),
        offset=precise.double(offset),
        unit="m" if "m" in units else "rad",
    )
