"""The start as a scene gives it, for runs whose parameters move the start."""

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

    It does where they change numbers of the scene, or what drivers prescribe: assembled positions
    and velocities fit with the parameters of the scene only.

    Parameters
    ----------
    scene : Scene
        The records of its file.
    written, joined : System
        System before assembly; and after it, with rigid groups of bodies as one.
    """
    names = [name for name, _ in joined.parameters]
    laws = " ".join(instance.law for instance in joined.constraints)
    if not (_varies(joined) or used_names(laws, names)):
        return ()
    starts = []
    for body, lowered in zip(scene.bodies.values(), written.bodies, strict=True):
        axes = fixed(lowered.axes_b)
        starts.append(
            WrittenStart(
                () if written.held else body.position,
                to_quaternion(precise.compose(normalised(lowered.p), normalised(axes))),
                body.velocity,
                body.angular_velocity_b or body.angular_velocity or REST,
                lowered.spins_in_o,
                (lowered.mass, *lowered.inertia, *lowered.origin_b, *lowered.axes_b),
            )
        )
    return tuple(starts)


def require_held(written: System, placed: System) -> None:
    """Refuse to hold coordinates that a run with other parameters could not keep.

    Only assembly holds coordinates, and it takes the parameters of the scene. With others, drivers
    may begin elsewhere or at another rate, and bodies of other masses share corrections otherwise.

    Parameters
    ----------
    written, placed : System
        System before and after assembly.

    Raises
    ------
    SceneError
        A held coordinate depends on parameters; the message names the driver, or the masses.
    """
    held = (*written.held, *written.held_rates)
    reason = ""
    for driver in written.constraints if held else ():
        value, rate = _moved_by_parameters(driver, written.parameters)
        if value or (rate and written.held_rates):
            reason = f"drivers.{driver.joint} begins {'elsewhere' if value else 'at another rate'}"
    pairs = [*zip(written.bodies, placed.bodies, strict=True)]
    moved = written.held and any((a.r, a.p) != (b.r, b.p) for a, b in pairs)
    faster = written.held_rates and any((a.v, a.omega_b) != (b.v, b.omega_b) for a, b in pairs)
    if (moved or faster) and _varies(written):
        level = "positions" if moved else "velocities"
        reason = f"masses share otherwise what {level} miss that do not fit"
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
    law, value, rate = law_at_start(driver, parameters), False, False
    for name in used_names(driver.law, [name for name, _ in parameters]):
        shifted_parameters = [(other, x + 0.5 if other == name else x) for other, x in parameters]
        try:
            shifted = law_at_start(driver, shifted_parameters)
        except AssemblyError:  # the law is no number there
            return True, True
        value, rate = value or shifted.value != law.value, rate or shifted.rate != law.rate
    return value, rate
