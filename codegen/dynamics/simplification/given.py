"""Velocities at the start as a scene gives them, for runs that start elsewhere by parameters."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.assembly.driver_laws import law_at_start
from kousoku.model.errors import AssemblyError, SceneError
from kousoku.model.formulas import used_names
from kousoku.model.mechanism import GivenVelocity
from kousoku.model.varying import fixed_system

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.mechanism import Instance, System
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
    names = [name for name, _ in joined.parameters]
    laws = " ".join(one.law for one in joined.constraints)
    if not (moves and (_varies(joined) or used_names(laws, names))):
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


def require_held(written: System, placed: System) -> None:
    """Refuse to hold what a run with other parameters could not keep.

    Only assembly holds, and it takes the parameters of the scene. With others, drivers may begin
    elsewhere or at another rate, and bodies with other masses share velocities that do not fit.

    Parameters
    ----------
    written, placed : System
        Before and after assembly.

    Raises
    ------
    SceneError
        What is held depends on parameters; the message names the driver, or says that masses do.
    """
    held = (*written.held, *written.held_rates)
    reason = ""
    for one in written.constraints if held else ():
        value, rate = _moved_by_parameters(one, written.parameters)
        if value or (rate and written.held_rates):
            reason = f"drivers.{one.joint} begins {'elsewhere' if value else 'at another rate'}"
    pairs = zip(written.bodies, placed.bodies, strict=True)
    changed = any((a.v, a.omega_b) != (b.v, b.omega_b) for a, b in pairs)
    if written.held_rates and changed and _varies(written):
        reason = "masses share otherwise what velocities miss that do not fit"
    if reason:
        raise SceneError(
            "is kept by assembly with the parameters of the scene only, and with others"
            f" {reason}; leave it out, or give a number in place of the parameter",
            key=(written.held_rates or held)[0].joint,
        )


def _varies(system: System) -> bool:
    """Return whether parameters change numbers of a system."""
    return fixed_system(system) is not system


def _moved_by_parameters(
    driver: Instance, parameters: Sequence[tuple[str, float]]
) -> tuple[bool, bool]:
    """Return whether parameters change the value of a driver at the start, and its rate."""
    own, value, rate = law_at_start(driver, parameters), False, False
    for name in used_names(driver.law, [name for name, _ in parameters]):
        others = [(one, x + 0.5 if one == name else x) for one, x in parameters]
        try:
            there = law_at_start(driver, others)
        except AssemblyError:  # it is no number there
            return True, True
        value, rate = value or there.value != own.value, rate or there.rate != own.rate
    return value, rate
