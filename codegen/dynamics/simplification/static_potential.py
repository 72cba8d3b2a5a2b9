"""The potential energy of what does not move, and is left out of a program."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.design import start_of
from kousoku.model import precise
from kousoku.model.mechanism import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.codegen.dynamics.simplification.composite import Placement
    from kousoku.model.mechanism import ForceElement, System
    from kousoku.model.precise import High


def static_potential(system: System, placements: Mapping[int, Placement]) -> float:
    """Potential energy of bodies that stand still and of forces in one body [J].

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
        is_fixed = force.has_potential and not force.formulas and force.coordinate < 0
        if is_fixed and placements[force.i].carrier == placements[force.j].carrier:
            total += _stored(force, placements)
    return precise.double(total)


def _stored(force: ForceElement, placements: Mapping[int, Placement]) -> High:
    """Energy ½ k (l − l⁰)² of a spring in one body, −F·r of a force on the ground."""
    given = dict(force.constants)
    end = precise.triple(placements[force.j].point(given["s_j_b"]))
    if force.kind == "force":
        return -precise.dot(precise.triple(given["force"]), end)
    start = precise.triple(placements[force.i].point(given["s_i_b"]))
    length = precise.length(precise.subtract(end, start))
    (stiffness,), (free,) = given["stiffness"], given["free_length"]
    return precise.number(stiffness) * (length - precise.number(free)) ** 2 / 2
