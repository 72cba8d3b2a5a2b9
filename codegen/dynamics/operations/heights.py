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

#: Heights up to this part of the largest size are zeros but for rounding.
FLAT = 1e-12


def is_level(heights: Sequence[float], sizes: Sequence[Sequence[float]]) -> bool:
    """Whether heights (n,) [m] are zero but for rounding of numbers of some sizes [m]."""
    largest = max(1.0, *(abs(x) for values in sizes for x in values))
    return max(map(abs, heights)) <= FLAT * largest


def heights_of_ends(
    system: System, element: ForceElement | RelativeCoordinate, normal: int
) -> list[float]:
    """Distances (n,) [m] of the ends from the centres of their bodies, s′·n, and from each other.

    n is the axis ``normal`` of frame O, which is that of all principal frames.
    """
    constants = dict(element.constants)
    heights = [
        constants[f"s_{end}_b"][normal]
        for end, index in (("i", element.i), ("j", element.j))
        if index != GROUND_INDEX
    ]
    start_height, end_height = (height(system, element, end, normal) for end in "ij")
    return [*heights, end_height - start_height]


def height(
    system: System, element: ForceElement | RelativeCoordinate | Instance, end: str, normal: int
) -> float:
    """Coordinate (r + A s′)·n, a scalar [m], frame O, of a spring's or joint's end at the start."""
    point = dict(element.constants)[f"s_{end}_b"]
    index = element.i if end == "i" else element.j
    if index == GROUND_INDEX:
        return point[normal]
    body = system.bodies[index]
    rotated = precise.rotate(precise.quadruple(body.p), precise.triple(point))
    return body.r[normal] + float(rotated[normal])


def at_start(system: System, coordinate: RelativeCoordinate) -> float:
    """Value u, a scalar [m or rad], of a coordinate at the start, of an angle up to whole turns.

    It is C of its kind at r, p of the start in frame O: lecture 8.2, (8.9), (8.12) or |d| of (8.8).
    """
    return float(kernel_at_start(system, coordinate)[0][0])


def kernel_at_start(
    system: System, instance: Instance | RelativeCoordinate
) -> tuple[Sequence[float], Sequence[float]]:
    """C (rows,) [m or rad] and C_q, row by row, of a kind at r, p of the start in frame O."""
    inputs: dict[str, Sequence[float]] = dict(instance.constants)
    for end, index in (("i", instance.i), ("j", instance.j)):
        ground = (0.0, 0.0, 0.0, *NO_TURN)
        position = ground if index == GROUND_INDEX else start(system.bodies[index])[0]
        inputs |= {f"r_{end}": position[:3], f"p_{end}": position[3:]}
    outputs = evaluate(frozen(instance.kind, "constraint"), inputs, FLOAT)
    return outputs["C"], outputs["C_q"]
