"""Turns of angles at the start: those of their drivers, counted to all digits."""

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

    The angle of the scene and the value that the driver prescribes at t = 0 agree up to whole
    turns. An angle that other combinations need, too, such as those of gears, counts as it is
    written: with other turns the driven bodies are at other positions.
    """
    instances = (*system.constraints, *system.held)
    users = Counter(term.coordinate for instance in instances for term in instance.terms)
    near: dict[int, float] = {}
    for driver in system.constraints:
        driven = driver.terms[0].coordinate if driver.is_driver and len(driver.terms) == 1 else -1
        if driven >= 0 and system.coordinates[driven].counts_turns and users[driven] == 1:
            law = law_at_start(driver, system.parameters).value
            wanted = (law - precise.number(driver.offset)) / precise.number(driver.terms[0].factor)
            near[driven] = float(wanted)
    coordinates = tuple(
        replace(c, near=near.get(k, c.near)) for k, c in enumerate(system.coordinates)
    )
    return system if coordinates == system.coordinates else replace(system, coordinates=coordinates)


def unwrapped(system: System) -> System:
    """System whose angles count from the values that they have, rounded once."""
    if not any(c.counts_turns for c in system.coordinates):
        return system
    rows = Residuals.of(system, ())
    near = rows.counted(Pose.of(system.bodies, system.coordinates)).near
    coordinates = tuple(
        replace(c, near=float(near[k])) if c.counts_turns else c
        for k, c in enumerate(system.coordinates)
    )
    return system if coordinates == system.coordinates else replace(system, coordinates=coordinates)
