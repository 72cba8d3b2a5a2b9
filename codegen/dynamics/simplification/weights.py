"""Scenes that drivers move, whose bodies need not weigh anything.

Where drivers and joints leave no freedom, positions, velocities and accelerations depend on no
mass. Equations are solved in a metric, though: bodies that lack a mass or a moment weigh something
there. What would depend on it is refused.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.composition.length import characteristic_length
from kousoku.codegen.dynamics.simplification.shapes import shape
from kousoku.codegen.dynamics.simplification.turned import turned
from kousoku.model.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    from kousoku.codegen.dynamics.analyse import Analysed
    from kousoku.model.mechanism import MovingBody, System

#: Outputs that depend on masses.
DEPEND = ("reactions", "energies")


@dataclass(frozen=True, slots=True)
class Weighted:
    """A system whose bodies all weigh something.

    Parameters
    ----------
    system : System
        The scene.
    missing : tuple of str
        Keys of what bodies lack and their motion may depend on.
    thin : tuple of str
        Those of them that belong to bodies whose mass lies on a line: one moment is zero.
    """

    system: System
    missing: tuple[str, ...] = ()
    thin: tuple[str, ...] = ()


def weighted(system: System, shift: int | None) -> Weighted:
    """Return a system with drivers whose bodies weigh something: 1 kg, and 1 kg · length².

    A system without drivers stays as it is, and so do masses and moments that are given.

    Parameters
    ----------
    system : System
        A scene.
    shift : int, optional
        Its plane, as :func:`~kousoku.codegen.dynamics.simplification.planar.plane_of` finds it.
    """
    if not any(one.is_driver for one in system.constraints):
        return Weighted(system)
    if all(body.mass > 0 and (body.is_point or min(body.inertia) > 0) for body in system.bodies):
        return Weighted(system)
    missing = tuple(_missing(system, shift))
    if not missing:
        return Weighted(system)
    length = characteristic_length(system)
    bodies = tuple(_filled(body, length) for body in system.bodies)
    keys = (f"bodies.{body.name}.inertia" for body in system.bodies if max(body.inertia) > 0)
    thin = tuple(key for key in keys if key in missing)
    return Weighted(replace(system, bodies=bodies), missing, thin)


def require_driven(found: Analysed, wanted: Collection[str]) -> None:
    """Refuse what depends on masses that are missing.

    Raises
    ------
    SceneError
        Drivers leave freedoms, or what is wanted depends on masses; the message names a body that
        lacks one.
    """
    if not found.missing:
        return
    key = found.missing[0]
    lack, give = "is missing", "give it"
    if key in found.thin:
        lack = "has a moment of zero, as of a rod without thickness, about an axis of turning"
        give = "give the body some thickness, as of a cylinder"
    more = f" (one of {len(found.missing)} such)" if len(found.missing) > 1 else ""
    if found.freedom.degrees > 0:
        raise SceneError(
            f"{lack}, and drivers leave {found.freedom.degrees} of the freedoms, whose motion"
            f" depends on it{more}; {give}, or drive them",
            key=key,
        )
    for name in DEPEND:
        if name in wanted:
            raise SceneError(
                f"asks for {name}, which depend on {key}, and it {lack}{more}; {give}, or"
                f" leave {name} out: positions, velocities and accelerations need no mass here",
                key="outputs",
            )


def _missing(system: System, shift: int | None) -> Iterator[str]:
    """Yield what bodies lack that their motion depends on."""
    for body in turned(system, shift or 0).bodies:
        _, columns = shape(body, is_planar=shift is not None)
        if body.mass <= 0:
            yield f"bodies.{body.name}.mass"
        elif any(body.inertia[k - 3] <= 0 for k in columns if k > 2):
            yield f"bodies.{body.name}.inertia"


def _filled(body: MovingBody, length: float) -> MovingBody:
    """Return a body with numbers in place of those that are missing."""
    mass = body.mass if body.mass > 0 else 1.0
    a, b, c = (moment if moment > 0 else float(mass) * length * length for moment in body.inertia)
    return replace(body, mass=mass, inertia=(a, b, c))
