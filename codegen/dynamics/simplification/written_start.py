"""The start as a scene gives it, for runs that start elsewhere because of their parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.assembly.driver_laws import law_at_start
from kousoku.codegen.dynamics.assembly.pose import normalised
from kousoku.model.errors import AssemblyError, SceneError
from kousoku.model.expressions.formulas import used_names
from kousoku.model.lowering.parametric import fixed_system
from kousoku.model.mechanics.frames import to_quaternion
from kousoku.model.mechanics.multibody import WrittenStart
from kousoku.model.numbers import precise
from kousoku.model.numbers.varying import fixed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.mechanics.multibody import Instance, System
    from kousoku.model.records.scene import Scene

REST = (0.0, 0.0, 0.0)


def written_start(scene: Scene, written: System, joined: System) -> tuple[WrittenStart, ...]:
    """Bodies as written, if the start depends on parameters.

    It does where they change numbers of the scene, or what drivers prescribe: what assembly made
    of positions and velocities fits with the parameters of the scene only.

    Parameters
    ----------
    scene : Scene
        What its file says.
    written, joined : System
        Before assembly; and after it, with bodies that are joined rigidly as one.
    """
    names = [name for name, _ in joined.parameters]
    if not (_varies(joined) or used_names(" ".join(one.law for one in joined.constraints), names)):
        return ()
    found = []
    for body, own in zip(scene.bodies.values(), written.bodies, strict=True):
        axes = fixed(own.axes_b)
        found.append(
            WrittenStart(
                () if written.held else body.position,
                to_quaternion(precise.compose(normalised(own.p), normalised(axes))),
                body.velocity,
                body.angular_velocity_b or body.angular_velocity or REST,
                own.spins_in_o,
                (own.mass, *own.inertia, *own.origin_b, *own.axes_b),
            )
        )
    return tuple(found)


def require_held(written: System, placed: System) -> None:
    """Refuse to hold coordinates that a run with other parameters could not keep.

    Only assembly holds, and it takes the parameters of the scene. With others, drivers may begin
    elsewhere or at another rate, and bodies with other masses share what does not fit.

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
    pairs = [*zip(written.bodies, placed.bodies, strict=True)]
    moved = written.held and any((a.r, a.p) != (b.r, b.p) for a, b in pairs)
    faster = written.held_rates and any((a.v, a.omega_b) != (b.v, b.omega_b) for a, b in pairs)
    if (moved or faster) and _varies(written):
        what = "positions" if moved else "velocities"
        reason = f"masses share otherwise what {what} miss that do not fit"
    if reason:
        raise SceneError(
            "is kept by assembly with the parameters of the scene only, and with others"
            f" {reason}; leave it out, or give a number in place of the parameter",
            key=(written.held_rates or held)[0].joint,
        )


def _varies(system: System) -> bool:
    """Whether parameters change numbers of a system."""
    return fixed_system(system) is not system


def _moved_by_parameters(
    driver: Instance, parameters: Sequence[tuple[str, float]]
) -> tuple[bool, bool]:
    """Whether parameters change the value of a driver at the start, and its rate."""
    own, value, rate = law_at_start(driver, parameters), False, False
    for name in used_names(driver.law, [name for name, _ in parameters]):
        others = [(one, x + 0.5 if one == name else x) for one, x in parameters]
        try:
            there = law_at_start(driver, others)
        except AssemblyError:  # it is no number there
            return True, True
        value, rate = value or there.value != own.value, rate or there.rate != own.rate
    return value, rate
