"""Where and how fast a run begins, beside the file that has its parameters."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from kousoku.codegen.dynamics.assembly.pose import normalised
from kousoku.codegen.dynamics.redundancy.nearly import with_consistent_start
from kousoku.model.expressions.design_numbers import read_formulas, with_numbers
from kousoku.model.lowering.system import system_of
from kousoku.model.numbers import precise
from kousoku.model.records.problems import Problems

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.mechanics.multibody import MovingBody, System
    from kousoku.model.records.scene import Scene
    from kousoku.runtime.integrate.motion import Motion


def folded(scene: Scene, given: Mapping[str, float]) -> Scene:
    """Scene with the numbers that some parameters make in place of its formulas."""
    values = dict(scene.parameters) | dict(given)
    other = msgspec.structs.replace(scene, parameters=values, name=f"{scene.name}_folded")
    return with_numbers(read_formulas(other, Problems()))


def missed(
    scene: Scene, given: Mapping[str, float], motion: Motion, *, is_there: bool = False
) -> tuple[float, float]:
    """By how much a run begins elsewhere, and faster, than the file with its parameters.

    Parameters
    ----------
    scene : Scene
        As it is read.
    given : mapping of str to float
        The parameters of the run.
    motion : Motion
        The run, from time 0.
    is_there : bool
        Whether bodies of the file are written where the run has them, with the velocities of the
        scene, instead of where the scene has them.

    Returns
    -------
    float
        The largest distance, relative to the scene's length.
    float
        The largest difference of a velocity, relative to the largest of the scene: lengths by
        the scene's length.
    """
    system = system_of(folded(scene, given), ())
    length, unit = motion.layout.length, system.unit
    if is_there:
        bodies = tuple(_placed(body, unit, motion) for body in system.bodies)
        system = replace(system, bodies=bodies)
    placed = with_consistent_start(system)
    found = _written(placed)
    speeds = [x for _, *rates in _written(system) + found for x in _sizes(rates, length)]
    lengths, rates = [0.0], [0.0]
    for body, (origin, velocity, spin) in zip(placed.bodies, found, strict=True):
        lengths.append(_far(origin, unit * motion.position[body.name][0]) / length)
        rates.append(_far(velocity, unit * motion.velocity[body.name][0]) / length)
        if not body.is_point:
            rates.append(_far(spin, motion.angular_velocity[body.name][0]))
    return max(lengths), max(rates) / (max(speeds) or 1.0)


def _placed(body: MovingBody, unit: float, motion: Motion) -> MovingBody:
    """Body where a run begins, with the velocity that the scene gives."""
    origin = precise.triple((unit * motion.position[body.name][0]).tolist())
    if body.is_point:
        return replace(body, r=_vector(origin))
    frame = normalised(motion.orientation[body.name][0].tolist())
    before = normalised(body.p)
    p = precise.compose(frame, precise.conjugate(normalised(body.axes_b)))
    arm, omega = precise.triple(body.origin_b), precise.triple(body.omega_b)
    velocity = precise.add(
        precise.triple(body.v), precise.rotate(before, precise.cross(omega, arm))
    )
    if body.spins_in_o:
        omega = precise.rotate_back(p, precise.rotate(before, omega))
    turning = precise.rotate(p, precise.cross(omega, arm))
    return replace(
        body,
        r=_vector(precise.subtract(origin, precise.rotate(p, arm))),
        p=_vector(p),
        v=_vector(precise.subtract(velocity, turning)),
        omega_b=_vector(omega),
    )


def _written(system: System) -> list[tuple[Any, Any, Any]]:
    """Of each body the origin, its velocity, and the angular velocity in its frame."""
    found = []
    for body in system.bodies:
        p, axes = normalised(body.p), normalised(body.axes_b)
        arm, omega = precise.triple(body.origin_b), precise.triple(body.omega_b)
        origin = precise.add(precise.triple(body.r), precise.rotate(p, arm))
        turning = precise.rotate(p, precise.cross(omega, arm))
        velocity = precise.add(precise.triple(body.v), turning)
        found.append((origin, velocity, precise.rotate_back(axes, omega)))
    return found


def _sizes(rates: Any, length: float) -> list[float]:
    velocity, spin = rates
    return [float(precise.length(velocity)) / length, float(precise.length(spin))]


def _far(exact: Any, found: Any) -> float:
    return float(np.abs(np.array([float(x) for x in exact]) - found).max())


def _vector(values: Any) -> Any:
    return tuple(map(float, values))
