"""Scenes that drivers move, whose bodies need no masses.

Where drivers and joints leave no freedom, positions, velocities and accelerations depend on no
mass. Equations are solved in a metric, though: bodies that lack a mass or a moment get one there.
Results that would depend on it are refused.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.body_coordinates import shape
from kousoku.codegen.dynamics.operations.characteristic_length import characteristic_length
from kousoku.codegen.dynamics.simplification.axis_permutation import permuted, shift_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.codegen.dynamics.simplification.axis_permutation import Plane
    from kousoku.model.mechanics.multibody import MovingBody, System


@dataclass(frozen=True, slots=True)
class PlaceholderMasses:
    """A system whose bodies all have masses.

    Parameters
    ----------
    system : System
        The scene.
    missing : tuple of str
        Keys of the masses and moments that bodies lack and that their motion may depend on.
    thin : tuple of str
        Those of bodies whose mass lies on a line: one moment is zero.
    """

    system: System
    missing: tuple[str, ...] = ()
    thin: tuple[str, ...] = ()


def with_placeholder_masses(system: System, plane: Plane | None) -> PlaceholderMasses:
    """System with drivers whose bodies all have a mass m [kg] and moments I = m ℓ² (3,) [kg m²].

    A system without drivers stays as it is, and so do masses and moments that are given. I is in
    the principal frame. Where other bodies have masses m is the largest of them, so that ratios of
    masses do not depend on units; where none has one it is 1 kg.

    Parameters
    ----------
    system : System
        A scene; ℓ [m] is its length.
    plane : Plane, optional
        Its plane, as :func:`~kousoku.codegen.dynamics.simplification.planarity.plane_of` finds it.
    """
    if not any(c.is_driver for c in system.constraints):
        return PlaceholderMasses(system)
    if all(body.mass > 0 and (body.is_point or min(body.inertia) > 0) for body in system.bodies):
        return PlaceholderMasses(system)
    missing = tuple(_missing(system, plane))
    if not missing:
        return PlaceholderMasses(system)
    length = characteristic_length(system)
    mass = max(float(body.mass) for body in system.bodies) or 1.0
    bodies = tuple(_filled(body, mass, length) for body in system.bodies)
    keys = (f"bodies.{body.name}.inertia" for body in system.bodies if max(body.inertia) > 0)
    thin = tuple(key for key in keys if key in missing)
    return PlaceholderMasses(replace(system, bodies=bodies), missing, thin)


def _missing(system: System, plane: Plane | None) -> Iterator[str]:
    """Keys of masses and moments that bodies lack and their motion depends on."""
    for body in permuted(system, shift_of(plane)).bodies:
        _, columns = shape(body, is_planar=plane is not None)
        if body.mass <= 0:
            yield f"bodies.{body.name}.mass"
        elif any(body.inertia[k - 3] <= 0 for k in columns if k > 2):
            yield f"bodies.{body.name}.inertia"


def _filled(body: MovingBody, mass: float, length: float) -> MovingBody:
    """Body with a mass [kg] and moments in place of those that are missing."""
    m = body.mass if body.mass > 0 else mass
    a, b, c = (moment if moment > 0 else float(m) * length * length for moment in body.inertia)
    return replace(body, mass=m, inertia=(a, b, c))
