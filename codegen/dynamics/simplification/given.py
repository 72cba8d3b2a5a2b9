"""Velocities at the start as a scene gives them, for runs that start elsewhere by parameters."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from kousoku.model.formulas import used_names
from kousoku.model.mechanism import GivenVelocity
from kousoku.model.varying import fixed_system

if TYPE_CHECKING:
    from kousoku.model.mechanism import System
    from kousoku.model.scene import Scene

REST = (0.0, 0.0, 0.0)


def given_velocities(scene: Scene, written: System, joined: System) -> tuple[GivenVelocity, ...]:
    """Return the velocities of all bodies as written, if those at the start depend on parameters.

    They do where parameters change places or masses, or what drivers prescribe, and something
    moves: what assembly made of the velocities fits with the parameters of the scene only.

    Parameters
    ----------
    scene : Scene
        What its file says.
    written, joined : System
        Before assembly; and after it, with bodies that are joined rigidly as one.
    """
    moves = any(any((*body.v, *body.omega_b)) for body in (*written.bodies, *joined.bodies))
    if not (moves and _start_varies(joined)):
        return ()
    carriers = [one.carrier for one in joined.carried] or range(len(joined.bodies))
    count = Counter(carriers)
    found = []
    for body, own, carrier in zip(scene.bodies.values(), written.bodies, carriers, strict=True):
        is_shared = carrier >= 0 and count[carrier] > 1
        weight = (own.mass, *own.inertia, *own.origin_b, *own.axes_b) if is_shared else ()
        spin = body.angular_velocity_b or body.angular_velocity or REST
        found.append(GivenVelocity(body.velocity, spin, own.spins_in_o, weight))
    return tuple(found)


def _start_varies(system: System) -> bool:
    """Return whether parameters change numbers of a system, or what drivers prescribe."""
    names = [name for name, _ in system.parameters]
    laws = " ".join(one.law for one in system.constraints)
    return fixed_system(system) is not system or bool(used_names(laws, names))
