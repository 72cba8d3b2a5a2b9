"""On which turn angles are at the start: that of their drivers, counted to all digits."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.assembly.driver_laws import law_at_start
from kousoku.codegen.dynamics.assembly.pose import Pose
from kousoku.codegen.dynamics.assembly.residuals import Residuals
from kousoku.model.numbers import precise

if TYPE_CHECKING:
    from kousoku.model.mechanics.multibody import System


def wound_as_driven(system: System) -> System:
    """System whose driven angles θ + 2πk [rad] count from the turn on which their drivers start.

    The angle of the scene and what the driver prescribes at t = 0 are the same place up to whole
    turns. An angle that other combinations need, too, such as those of gears, counts as it is
    written: other turns of it are other places of what it drives.
    """
    instances = (*system.constraints, *system.held)
    users = Counter(term.coordinate for one in instances for term in one.terms)
    near: dict[int, float] = {}
    for one in system.constraints:
        driven = one.terms[0].coordinate if one.is_driver and len(one.terms) == 1 else -1
        if driven >= 0 and system.coordinates[driven].counts_turns and users[driven] == 1:
            law = law_at_start(one, system.parameters).value
            wanted = (law - precise.number(one.offset)) / precise.number(one.terms[0].factor)
            near[driven] = float(wanted)
    coordinates = tuple(
        replace(one, near=near.get(k, one.near)) for k, one in enumerate(system.coordinates)
    )
    return system if coordinates == system.coordinates else replace(system, coordinates=coordinates)


def unwrapped(system: System) -> System:
    """System whose angles count from the values that they have, rounded once."""
    if not any(one.counts_turns for one in system.coordinates):
        return system
    rows = Residuals.of(system, ())
    near = rows.counted(Pose.of(system.bodies, system.coordinates)).near
    coordinates = tuple(
        replace(one, near=float(near[k])) if one.counts_turns else one
        for k, one in enumerate(system.coordinates)
    )
    return system if coordinates == system.coordinates else replace(system, coordinates=coordinates)
