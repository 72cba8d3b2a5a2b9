"""Which forces lead a system out of a coordinate plane that it starts in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.forces import SPRING
from kousoku.codegen.dynamics.operations.mechanics import frozen
from kousoku.codegen.dynamics.simplification.shapes import NO_TURN, start
from kousoku.model import precise
from kousoku.model.arithmetic import FLOAT
from kousoku.model.interpret import evaluate
from kousoku.model.mechanism import GROUND_INDEX
from kousoku.model.varying import fixed_system, is_varying

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.mechanism import Coordinate, ForceElement, Instance, System

#: Heights up to this part of the largest do not count: rounding.
FLAT = 1e-12


def leaves_plane(system: System, force: ForceElement, normal: int) -> bool:
    """Whether a force of a system that starts in a coordinate plane leads out of it.

    Parameters
    ----------
    system : System
        The scene.
    force : ForceElement
        One of its forces.
    normal : int
        Which axis is normal to the plane; it is so in all principal frames.
    """
    given = dict(force.constants)
    if force.coordinate >= 0:
        return _coordinate_leaves(system, force, normal)
    if force.kind in {"torque", "torque_b"}:
        return any(x for values in given.values() for k, x in enumerate(values) if k != normal)
    if force.kind == SPRING:
        heights = _ends(system, force, normal)
    elif any(values[normal] for name, values in given.items() if name != "s_j_b"):
        return True
    else:
        heights = [given["s_j_b"][normal]]
    return not _is_flat(heights, list(given.values()))


def is_flat(system: System, normal: int | None) -> bool:
    """Whether centres of mass, joints and gravity lie in one plane of the motion.

    Then no joint of a planar scene has a force or torque that leads out of it.

    Parameters
    ----------
    system : System
        The scene.
    normal : int, optional
        Which axis is normal to its plane, None where it moves in space.
    """
    if normal is None or not system.bodies:
        return False
    system = fixed_system(system)
    heights = [body.r[normal] for body in system.bodies]
    combined = {term.coordinate for one in system.constraints for term in one.terms}
    connected: list[Instance | Coordinate] = list(system.constraints)
    connected += [system.coordinates[place] for place in sorted(combined)]
    for one in connected:
        ends = [name for name, _ in one.constants if name in {"s_i_b", "s_j_b"}]
        heights += (_height(system, one, name[2], normal) for name in ends)
    if any(leaves_plane(system, force, normal) for force in system.forces):
        return False
    spread = max(heights) - min(heights)
    return not system.has_gravity(normal) and spread <= FLAT * max(1.0, *map(abs, heights))


def _is_flat(heights: Sequence[float], sizes: Sequence[Sequence[float]]) -> bool:
    largest = max(1.0, *(abs(x) for values in sizes for x in values))
    return max(map(abs, heights)) <= FLAT * largest


def _ends(system: System, one: ForceElement | Coordinate, normal: int) -> list[float]:
    """Distances of the ends from the centres of their bodies and from each other."""
    given = dict(one.constants)
    own = [
        given[f"s_{end}_b"][normal]
        for end, index in (("i", one.i), ("j", one.j))
        if index != GROUND_INDEX
    ]
    start_height, end_height = (_height(system, one, end, normal) for end in "ij")
    return [*own, end_height - start_height]


def _height(
    system: System, one: ForceElement | Coordinate | Instance, end: str, normal: int
) -> float:
    """Coordinate of an end of a spring or a joint at the start."""
    point = dict(one.constants)[f"s_{end}_b"]
    index = one.i if end == "i" else one.j
    if index == GROUND_INDEX:
        return point[normal]
    body = system.bodies[index]
    w, x, y, z = map(precise.number, body.p)
    seen = precise.rotate((w, x, y, z), precise.triple(point))
    return body.r[normal] + float(seen[normal])


def leaves_with_parameters(system: System, normal: int) -> bool:
    """Whether some point or axis has a component across a plane that parameters change."""
    vectors = [pair for one in system.constraints for pair in one.constants]
    vectors += [pair for one in system.coordinates for pair in one.constants]
    vectors += [pair for one in system.forces for pair in one.constants]
    crossing = (values[normal] for _, values in vectors if len(values) == 3)
    others = [k for k in range(3) if k != normal]
    turned = (body.axes_b[1 + k] for body in system.bodies for k in others)
    origins = (body.origin_b[normal] for body in system.bodies)
    return any(map(is_varying, (*crossing, *turned, *origins)))


def _coordinate_leaves(system: System, force: ForceElement, normal: int) -> bool:
    """Whether a force along a coordinate leads out of the plane.

    A coordinate whose axes are in the plane, and whose points are level with the centres of mass,
    does not; an angle does not either. Across the plane, motions in the plane do not change a
    coordinate: a spring that has no force at the start then has none for good.
    """
    one = system.coordinates[force.coordinate]
    given = dict(one.constants)
    axes = [values for name, values in given.items() if not name.startswith("s_")]
    heights = [abs(axis[normal]) for axis in axes]
    if one.kind in {"length", "n2"} and max(heights, default=0.0) <= FLAT:
        return not _is_flat(_ends(system, one, normal), list(given.values()))
    is_across = [height >= 1.0 - FLAT for height in heights]
    if one.kind in {"n1", "angle"} and (max(heights) <= FLAT or all(is_across)):
        return False
    is_fixed = one.kind in {"n1", "n2"} and sum(is_across) == 1
    is_fixed = is_fixed and all(x <= FLAT or x >= 1.0 - FLAT for x in heights)
    if force.kind == "along" or force.law or force.formulas or not is_fixed:
        return True
    free = dict(force.constants)["free"][0]
    size = max(abs(x) for values in given.values() for x in values)
    return abs(_at_start(system, one) - free) > FLAT * max(1.0, size)


def _at_start(system: System, one: Coordinate) -> float:
    inputs: dict[str, Sequence[float]] = dict(one.constants)
    for end, index in (("i", one.i), ("j", one.j)):
        ground = (0.0, 0.0, 0.0, *NO_TURN)
        position = ground if index == GROUND_INDEX else start(system.bodies[index])[0]
        inputs |= {f"r_{end}": position[:3], f"p_{end}": position[3:]}
    return float(evaluate(frozen(one.kind, "constraint"), inputs, FLOAT)["C"][0])
