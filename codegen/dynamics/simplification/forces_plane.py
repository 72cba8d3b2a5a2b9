"""Forces that lead a system out of a coordinate plane that it starts in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.elements.force_facets import facets_of
from kousoku.codegen.dynamics.operations.heights import FLAT, height
from kousoku.codegen.dynamics.simplification.axis_permutation import NORMAL
from kousoku.model.lowering.parametric import fixed_system
from kousoku.model.numbers.varying import is_varying

if TYPE_CHECKING:
    from kousoku.model.mechanics.multibody import ForceElement, Instance, RelativeCoordinate, System


def leaves_plane(system: System, force: ForceElement, normal: int) -> bool:
    """Whether a force of a system that starts in a coordinate plane leads out of it.

    Parameters
    ----------
    system : System
        The scene.
    force : ForceElement
        One of its forces.
    normal : int
        Axis normal to the plane, the same in all principal frames.
    """
    return facets_of(force).leaves_plane(system, normal)


def is_flat(system: System, normal: int | None) -> bool:
    """Whether centres of mass, joints and gravity lie in one plane of the motion.

    Then no joint of a planar scene has a force or torque that leads out of it.

    Parameters
    ----------
    system : System
        The scene.
    normal : int, optional
        Axis normal to its plane, None where it moves in space.
    """
    if normal is None or not system.bodies:
        return False
    system = fixed_system(system)
    heights = [body.r[normal] for body in system.bodies]
    combined = {term.coordinate for instance in system.constraints for term in instance.terms}
    connected: list[Instance | RelativeCoordinate] = list(system.constraints)
    connected += [system.coordinates[k] for k in sorted(combined)]
    for source in connected:
        ends = [name for name, _ in source.constants if name in {"s_i_b", "s_j_b"}]
        heights += (height(system, source, name[2], normal) for name in ends)
    if any(leaves_plane(system, force, normal) for force in system.forces):
        return False
    spread = max(heights) - min(heights)
    return not system.has_gravity(normal) and spread <= FLAT * max(1.0, *map(abs, heights))


def leaves_with_parameters(system: System) -> bool:
    """Whether parameters change the component of a point or axis normal to the xy-plane."""
    vectors = [pair for c in system.constraints for pair in c.constants]
    vectors += [pair for c in system.coordinates for pair in c.constants]
    vectors += [pair for force in system.forces for pair in force.constants]
    crossing = (values[NORMAL] for _, values in vectors if len(values) == 3)
    in_plane = [k for k in range(3) if k != NORMAL]
    turned = (body.axes_b[1 + k] for body in system.bodies for k in in_plane)
    origins = (body.origin_b[NORMAL] for body in system.bodies)
    return any(map(is_varying, (*crossing, *turned, *origins)))
