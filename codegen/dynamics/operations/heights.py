"""Heights of ends of forces and joints over a coordinate plane, and coordinates at the start."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.body_coordinates import NO_TURN, start
from kousoku.codegen.dynamics.operations.mechanics import frozen
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.numbers import precise
from kousoku.model.operations.arithmetic import FLOAT
from kousoku.model.operations.interpret import evaluate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.mechanics.multibody import ForceElement, Instance, RelativeCoordinate, System

#: Heights up to this part of the largest do not count: rounding.
FLAT = 1e-12


def is_level(heights: Sequence[float], sizes: Sequence[Sequence[float]]) -> bool:
    """Whether heights (n,) [m] are zero but for rounding of numbers of some sizes [m]."""
    largest = max(1.0, *(abs(x) for values in sizes for x in values))
    return max(map(abs, heights)) <= FLAT * largest


def heights_of_ends(
    system: System, one: ForceElement | RelativeCoordinate, normal: int
) -> list[float]:
    """Distances (n,) [m] of the ends from the centres of their bodies, s′·n, and from each other.

    n is the axis ``normal`` of frame O, which is that of all principal frames.
    """
    given = dict(one.constants)
    own = [
        given[f"s_{end}_b"][normal]
        for end, index in (("i", one.i), ("j", one.j))
        if index != GROUND_INDEX
    ]
    start_height, end_height = (height(system, one, end, normal) for end in "ij")
    return [*own, end_height - start_height]


def height(
    system: System, one: ForceElement | RelativeCoordinate | Instance, end: str, normal: int
) -> float:
    """Coordinate (r + A s′)·n, a scalar [m], frame O, of a spring's or joint's end at the start."""
    point = dict(one.constants)[f"s_{end}_b"]
    index = one.i if end == "i" else one.j
    if index == GROUND_INDEX:
        return point[normal]
    body = system.bodies[index]
    seen = precise.rotate(precise.quadruple(body.p), precise.triple(point))
    return body.r[normal] + float(seen[normal])


def at_start(system: System, one: RelativeCoordinate) -> float:
    """Value u, a scalar [m or rad], of a coordinate at the start, of an angle up to whole turns.

    It is C of its kind at r, p of the start in frame O: lecture 8.2, (8.9), (8.12) or |d| of (8.8).
    """
    return float(kernel_at_start(system, one)[0][0])


def kernel_at_start(
    system: System, one: Instance | RelativeCoordinate
) -> tuple[Sequence[float], Sequence[float]]:
    """C (rows,) [m or rad] and C_q, row by row, of a kind at r, p of the start in frame O."""
    inputs: dict[str, Sequence[float]] = dict(one.constants)
    for end, index in (("i", one.i), ("j", one.j)):
        ground = (0.0, 0.0, 0.0, *NO_TURN)
        position = ground if index == GROUND_INDEX else start(system.bodies[index])[0]
        inputs |= {f"r_{end}": position[:3], f"p_{end}": position[3:]}
    found = evaluate(frozen(one.kind, "constraint"), inputs, FLOAT)
    return found["C"], found["C_q"]
