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
    parts = [factor * coordinates.value(place) for place, factor in terms]
    offset = -precise.total(parts)
    if not isinstance(offset, Traced) and abs(offset) <= NOISE * sum(map(abs, parts)):
        offset = CONTEXT.mpf(0)
    return combination(name, terms, offset, coordinates)


def combination(
    name: str, terms: Sequence[tuple[int, High]], offset: High, coordinates: CoordinateList
) -> Instance:
    """Instance Σ factor · coordinate + offset = 0; coordinates are their places."""
    records = [coordinates.record(place) for place, _ in terms]
    bodies = dict.fromkeys(body for record in records for body in (record.i, record.j))
    i, j = coordinates.ends(terms[0][0])
    units = [coordinates.unit_of(place)[0] for place, _ in terms]
    return Instance(
        name,
        COMBINATION,
        i,
        j,
        terms=tuple(Term(place, precise.double(factor)) for place, factor in terms),
        others=tuple(body for body in bodies if body not in (i, j)),
        offset=precise.double(offset),
        unit="m" if "m" in units else "rad",
    )
