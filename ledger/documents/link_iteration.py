"""The iteration (26) to (28) as corrected, carried out for both mechanisms with 30 digits.

It is written from the paper alone, so that what is counted here is the paper's scheme and not the
project's solver: at each of 60 positions the matrix D and the second transfer function stay those
of the reference position until all deformations are at most 1e-13 cm.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import mpmath

from kousoku.ledger.documents.link_mechanisms import LEVER_CRANK, PISTON_CRANK
from kousoku.model.numbers.real import Real

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.ledger.documents.link_mechanisms import ExampleMechanism

#: mpmath with 30 digits, apart from the context that other code may set.
MP = mpmath.mp.clone()
MP.dps = 30
DIVISIONS = 60
RESIDUAL = "1e-13"

RealVector = list[Real]


@dataclass(frozen=True, slots=True)
class CrankTurn:
    """A full turn of the crank.

    Parameters
    ----------
    corrections : tuple of int
        How often (27) and (28) were applied, at each step.
    residual : float [cm]
        The largest deformation that is left.
    states : tuple
        At each position x, x′ and x″, the latter two by (22) and (23) there.
    """

    corrections: tuple[int, ...]
    residual: float
    states: tuple[tuple[RealVector, RealVector, RealVector], ...]

    @property
    def range(self) -> tuple[int, int]:
        """The smallest and the largest number of corrections."""
        return min(self.corrections), max(self.corrections)


@cache
def run(name: str, *, renews: bool = False) -> CrankTurn:
    """Turn the crank once.

    Parameters
    ----------
    name : str
        ``piston`` or ``lever``.
    renews : bool
        Whether each pass also computes x″ anew by (23), from the improved x′.
    """
    mechanism = {"piston": PISTON_CRANK, "lever": LEVER_CRANK}[name]
    x = _start(mechanism)
    inverse = _inverse(mechanism, x)
    states, counts, left = [(x, *_transfer(mechanism, x, inverse))], [], MP.mpf(0)
    for _ in range(DIVISIONS):
        x, count, residual = _step(mechanism, states[-1], inverse, renews=renews)
        inverse = _inverse(mechanism, x)
        counts.append(count)
        left = max(left, residual)
        states.append((x, *_transfer(mechanism, x, inverse)))
    return CrankTurn(tuple(counts), float(left), tuple(states))


def _step(
    mechanism: ExampleMechanism,
    state: tuple[RealVector, RealVector, RealVector],
    inverse: Sequence[RealVector],
    *,
    renews: bool,
) -> tuple[RealVector, int, Real]:
    """Go on by one division; return the position, how many corrections, and the residual."""
    x, first, second = state
    first = list(first)
    step = 2 * MP.pi / DIVISIONS
    count = 0
    while True:
        moved = [a + step * b + step**2 * c / 2 for a, b, c in zip(x, first, second, strict=True)]
        zeta = _deformations(mechanism, moved)
        residual = max(abs(e) for e in zeta)
        if residual <= MP.mpf(RESIDUAL):
            return moved, count, residual
        for k, u in zip(mechanism.unknown, _times(inverse, zeta), strict=True):
            first[k] -= u / step
        if renews:
            second = _second(mechanism, x, first, inverse)
        count += 1


def _transfer(
    mechanism: ExampleMechanism, x: RealVector, inverse: Sequence[RealVector]
) -> tuple[RealVector, RealVector]:
    """Transfer functions x′ and x″ by (22) and (23)."""
    crank = mechanism.names.index("ψ_11")
    first = [MP.mpf(0)] * len(x)
    first[crank] = MP.mpf(1)
    column = [row[crank] for row in _matrix(mechanism, x)]
    for k, value in zip(mechanism.unknown, _times(inverse, column), strict=True):
        first[k] = -value
    return first, _second(mechanism, x, first, inverse)


def _second(
    mechanism: ExampleMechanism, x: RealVector, first: RealVector, inverse: Sequence[RealVector]
) -> RealVector:
    second = [MP.mpf(0)] * len(x)
    changes = _times(inverse, _changes(mechanism, x, first))
    for k, value in zip(mechanism.unknown, changes, strict=True):
        second[k] = -value
    return second


def _times(matrix: Sequence[RealVector], vector: Sequence[Real]) -> RealVector:
    return [MP.fsum(a * b for a, b in zip(row, vector, strict=True) if a) for row in matrix]


def _inverse(mechanism: ExampleMechanism, x: RealVector) -> list[RealVector]:
    """Inverse of the columns of the unknowns; most of them is zero, and is passed by."""
    size = len(mechanism.unknown)
    rows = [
        [MP.mpf(row[column]) for column in mechanism.unknown]
        + [MP.mpf(int(column == k)) for column in range(size)]
        for k, row in enumerate(_matrix(mechanism, x))
    ]
    for k in range(size):
        sizes = [abs(row[k]) for row in rows[k:]]
        pivot = k + sizes.index(max(sizes))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [value / rows[k][k] if value else value for value in rows[k]]
        for other, row in enumerate(rows):
            if other != k and (factor := row[k]):
                rows[other] = [
                    a - factor * b if b else a for a, b in zip(row, rows[k], strict=True)
                ]
    return [row[size:] for row in rows]


# -- the link element ----------------------------------------------------------------------------


def _along(
    mechanism: ExampleMechanism, link: int, x: RealVector
) -> tuple[RealVector, Real, Real, Real]:
    """Coordinates x1 y1 β1 x2 y2 β2 of a link, the cosine and sine of its angle, and its length."""
    ends = [x[k] for k in mechanism.ends(link)]
    dx, dy = ends[3] - ends[0], ends[4] - ends[1]
    length = MP.hypot(dx, dy)
    return ends, dx / length, dy / length, length


def _deformations(mechanism: ExampleMechanism, x: RealVector) -> RealVector:
    """Deformations (5) to (7) of all links, angles within half a turn."""
    result = []
    for link, design in enumerate(mechanism.lengths, 1):
        ends, c, s, length = _along(mechanism, link, x)
        turns = [MP.cos(ends[k]) * s - MP.sin(ends[k]) * c for k in (2, 5)]
        points = [MP.cos(ends[k]) * c + MP.sin(ends[k]) * s for k in (2, 5)]
        first, second = (MP.atan2(a, b) for a, b in zip(turns, points, strict=True))
        result += [length - design, -first * design, second * design]
    return result


def _matrix(mechanism: ExampleMechanism, x: RealVector) -> list[RealVector]:
    """Matrix (15) of all links, assembled."""

    def element(link: int) -> list[RealVector]:
        _, c, s, _ = _along(mechanism, link, x)
        l0 = MP.mpf(mechanism.lengths[link - 1])
        return [[-c, -s, 0, c, s, 0], [-s, c, l0, s, -c, 0], [s, -c, 0, -s, c, -l0]]

    return mechanism.assembled(element)


def _changes(mechanism: ExampleMechanism, x: RealVector, slope: RealVector) -> RealVector:
    """Product D′ x′ of all links: D turns with the link, and its lower rows are over its length."""
    result = []
    for link, design in enumerate(mechanism.lengths, 1):
        _, c, s, length = _along(mechanism, link, x)
        ends = [slope[k] for k in mechanism.ends(link)]
        dx, dy = ends[3] - ends[0], ends[4] - ends[1]
        along, turn = c * dx + s * dy, (c * dy - s * dx) / length
        across = 2 * design * turn * along / length
        result += [length * turn**2, across, -across]
    return result


# -- where it starts -----------------------------------------------------------------------------


def _start(mechanism: ExampleMechanism) -> RealVector:
    """Position with the crank along the x axis."""
    lengths = [MP.mpf(length) for length in mechanism.lengths]
    nodes = [(MP.mpf(0), MP.mpf(0)), (lengths[0], MP.mpf(0))]
    if mechanism is PISTON_CRANK:
        nodes.append((lengths[0] + lengths[1], MP.mpf(0)))
    else:
        apart = lengths[3] - lengths[0]
        along = (lengths[1] ** 2 - lengths[2] ** 2 + apart**2) / (2 * apart)
        above = MP.sqrt(lengths[1] ** 2 - along**2)
        nodes += [(lengths[0] + along, above), (lengths[3], MP.mpf(0))]
    angles = []
    for first, second in mechanism.links:
        (x1, y1), (x2, y2) = nodes[first - 1], nodes[second - 1]
        angles += [MP.atan2(y2 - y1, x2 - x1)] * 2
    return [value for node in nodes for value in node] + angles
