"""The potential energy of bodies that do not move, and are left out of a program."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.elements.force_facets import facets_of
from kousoku.codegen.dynamics.recording.design import start_of
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.numbers import precise

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.codegen.dynamics.operations.placement import Placement
    from kousoku.model.mechanics.multibody import System


def static_potential(system: System, placements: Mapping[int, Placement]) -> float:
    """Potential energy, a number [J], of bodies that stand still and of forces in one body.

    V = −Σ m g·r + Σ V_f with g (3,) [m/s²] and r (3,) [m] in frame O.

    Parameters
    ----------
    system : System
        The scene, before bodies are joined.
    placements : mapping of int to Placement
        What carries each body.
    """
    gravity = precise.triple(system.gravity)
    total = precise.number(0.0)
    for k, body in enumerate(system.bodies):
        if placements[k].carrier == GROUND_INDEX:
            total -= precise.number(body.mass) * precise.dot(gravity, start_of(body)[0])
    for force in system.forces:
        i, j = placements[force.i], placements[force.j]
        if force.has_potential and not force.formulas and i.carrier == j.carrier:
            total += facets_of(force).resting_energy(i, j)
    return precise.double(total)
