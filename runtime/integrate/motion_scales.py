"""Scales of a motion so far: its largest rate, its extent, the energy that moves.

Errors of steps, of works and of the balance of energy are relative to these.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .arithmetic import larger, smaller
from .settings import NOTHING_MOVES

if TYPE_CHECKING:
    from .arithmetic import Array
    from .scene_tables import SceneTables, Work
    from .settings import Settings
    from .state import State

#: Scale of velocity errors, beside the velocities: the running maximum speed, clamped to between
#: NOTHING_MOVES over the longest step so far and this number over the step, in lengths of the scene
#: or radians. Below the lower bound speeds are rounding; it is no larger in a short step, as the
#: rates of what does move are not.
USUAL_STEP_MOTION = 0.05


def fastest(end: Array, state: State, work: Work) -> float:
    """Largest speed so far and at the end (ny,) of a step, in lengths and radians [1/s]."""
    size_of, nq = work.w.size_of, work.scene.nq
    return larger(larger(state.fastest, size_of(state.y[nq:])), size_of(end[nq:]))


def usual_rate(h: float, end: Array, state: State, work: Work) -> float:
    """Rate that rates of a step are compared with, in lengths of the scene and radians [1/s].

    It is that of the motion up to the end (ny,) of a step of h [s], the same in all units of time.
    """
    speed = fastest(end, state, work)
    return smaller(USUAL_STEP_MOTION / h, larger(NOTHING_MOVES / larger(state.stride, h), speed))


def note_motion(h: float, end: Array, state: State, work: Work) -> None:
    """Note what later steps are compared with, at the end (ny,) of one of h [s]."""
    state.fastest = fastest(end, state, work)
    state.stride = larger(state.stride, h)


def note_extent(end: Array, work: Work, state: State) -> None:
    """Note the ranges of coordinates, also of those that rows show, at the end (ny,) of a step."""
    scene, w = work.scene, work.w
    reached = np.concatenate((end[: scene.nq], w.coordinates[:: scene.per_shown]))
    state.lowest[:] = np.where(reached < state.lowest, reached, state.lowest)
    state.highest[:] = np.where(reached > state.highest, reached, state.highest)


def usual_energy(rate: float, scene: SceneTables) -> float:
    """Energy [J] of all bodies where they move at such a rate [1/s]."""
    return scene.mass * (scene.length * rate) * (scene.length * rate) / 2.0


def energy_of_works(h: float, end: Array, moved: float, state: State, work: Work) -> float:
    """Energy [J] that errors of works are compared with, where so much [J] has moved in h [s].

    It is that of all bodies at the usual rate up to the end (ny,), or the energy that has moved if
    that is less: where one body is fast, heavy ones may stand. It is no less than that of all
    bodies at a rate that counts as rest.
    """
    usual = usual_energy(usual_rate(h, end, state, work), work.scene)
    least = usual_energy(NOTHING_MOVES / larger(state.stride, h), work.scene)
    return smaller(usual, larger(least, moved))


def energy_balance(q: Array, work: Work, state: State) -> float:
    """Change of energy [J] since the start that no work explains; works are in q (nq,)."""
    balance = work.w.energies[0] + work.w.energies[1] - state.energy
    for done in q[work.scene.nq - work.scene.works : work.scene.nq]:
        balance -= done
    return float(balance)


def energy_moved(q: Array, work: Work, state: State) -> float:
    """Kinetic energy, change of potential energy since the start, and all works [J].

    Works are in q (nq,). That of every step counts, whatever rows are written.
    """
    kinetic, potential = work.w.energies
    moved = kinetic + abs(potential - state.potential)
    for done in q[work.scene.nq - work.scene.works : work.scene.nq]:
        moved += abs(done)
    return float(moved)


def note_moved(s: Settings, moved: float, state: State) -> None:
    """Note the energy that has moved at the end of a step that is kept."""
    state.moved = larger(state.moved, moved)
    if s.checks:
        state.energy_moved = larger(state.energy_moved, moved)
