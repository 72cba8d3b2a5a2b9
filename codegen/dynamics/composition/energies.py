"""The segment ``energy``: kinetic and potential energy of all bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.elements.force_facets import facets_of
from kousoku.codegen.dynamics.operations.mechanics import Energy
from kousoku.codegen.dynamics.operations.sums import summed
from kousoku.codegen.dynamics.recording.design import number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.composition.record_forces import ForceRecorder
    from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix
    from kousoku.codegen.dynamics.simplification.body_blocks import BodyBlocks
    from kousoku.model.mechanics.multibody import System


def record_energies(
    recorder: Recorder, system: System, bodies: Sequence[BodyBlocks], forces: ForceRecorder
) -> None:
    """Record the energies (2,) [J] of bodies, and of forces that have a potential.

    T = Σ ½ m v·v + ½ ω′·I′ω′ and V = −Σ m g·r + Σ V_f, with v, g, r in frame O, ω′ and I′ in the
    principal frames.

    Parameters
    ----------
    recorder : Recorder
        The program.
    system : System
        The scene.
    bodies : sequence of BodyBlocks
        Blocks of its bodies.
    forces : ForceRecorder
        Recorder of its forces.
    """
    target = recorder.region("energies", 2)
    recorder.begin("energy")
    gravity = forces.gravity(system)
    shares: list[SlotMatrix] = []
    for body, blocks in zip(system.bodies, bodies, strict=True):
        mass = number(body.mass)
        halves = recorder.constant([mass / 2] * 3 + [number(x) / 2 for x in body.inertia])
        weight = forces.weight(system, gravity, mass)
        shares += recorder.call(Energy(), blocks.r, blocks.v_r, blocks.omega_b, halves, weight)
    for force in system.forces:
        if force.has_potential:
            shares.append(facets_of(force).energy(forces))
    if system.static_potential:
        shares.append(recorder.constant((0, system.static_potential)))
    summed(recorder, shares, target)
