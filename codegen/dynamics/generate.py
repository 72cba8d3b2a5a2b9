"""Stages from a scene of bodies to the folder of its solver; SymPy is never started.

``assemble_scene``: Scene → Assembled
    SI units, principal frames, instances of kinds; at a start that joints and drivers allow.
``analyse``: System → Analysed
    Fewer bodies, the plane, masses, rows and ranks: decisions before composition.
``written_start``: Scene, System → bodies as written
    Where the start depends on parameters.
``require_driven``: Analysed
    Refused in words where outputs depend on masses that are missing.
``choice_of``: Analysed → Choice
    Composed; the cheaper one of two programs that solve it.
``solver_references``: Program, System → text
    States with results in 50 digits, if wanted.
``inline``: Program → Program
    Small ones in one function a segment.
``emit_dynamics``: Program → {file: text}
    The folder.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.analyse import analyse, require_driven
from kousoku.codegen.dynamics.assembled import assemble_scene
from kousoku.codegen.dynamics.assembly.changes import changes_of_assembly
from kousoku.codegen.dynamics.checking.reference import solver_references
from kousoku.codegen.dynamics.choose import choice_of
from kousoku.codegen.dynamics.emission.emit import emit_dynamics
from kousoku.codegen.dynamics.operations.characteristic_length import characteristic_length
from kousoku.codegen.dynamics.operations.heights import height
from kousoku.codegen.dynamics.recording.inline import inline
from kousoku.codegen.dynamics.redundancy.closure import notes_of_freedom
from kousoku.codegen.dynamics.redundancy.varying_rank import notes_of_rank
from kousoku.codegen.dynamics.simplification.written_start import written_start
from kousoku.model.files.manifest import REFERENCE_FILE
from kousoku.model.lowering.about import About
from kousoku.model.lowering.parametric import fixed_system
from kousoku.model.records.dotted_keys import join
from kousoku.runtime.integrate.assembled_start import notes_of
from kousoku.runtime.messages import listed, scene_key

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanics.multibody import ForceElement, RelativeCoordinate, System
    from kousoku.model.records.scene import Scene


#: Distances of no more than this part of the scene's length are rounding of assembly.
NO_LENGTH = 1e-12
#: Outputs that every solver has for the ledgers of its runs.
LEDGER_OUTPUTS = ("checks", "energies")


def generate_dynamics(
    scene: Scene, outputs: Sequence[str] | None = None, *, references: bool = False
) -> dict[str, str]:
    """Folder of the solver of a scene of bodies.

    Parameters
    ----------
    scene : Scene
        A checked spatial scene.
    outputs : sequence of str, optional
        Those of ``accelerations``, ``reactions`` and ``energies`` that are computed beside
        positions and velocities; the scene's unless given.
    references : bool
        Whether the folder has reference values, which ``kousoku verify`` compares with; that takes
        a second for some ten bodies.

    Returns
    -------
    dict of str to str
        File name and text.

    Raises
    ------
    SceneError
        The scene asks for what dynamics does not honour; the message names it.
    AssemblyError
        Its bodies do not fit together near the positions that it gives.
    """
    wanted = scene.outputs if outputs is None else outputs
    composed = compose_scene(scene, wanted)
    program, system = composed.program, composed.system
    data = {}
    if references:
        data[REFERENCE_FILE] = solver_references(program, system, composed.written)
    return emit_dynamics(inline(program), system, wanted, data, composed.about)


@dataclass(frozen=True, slots=True)
class Composed:
    """System and program that a solver is emitted from.

    Parameters
    ----------
    program, system : Program, System
        Program, and the system that it was composed of.
    degrees : int
        Degrees of freedom.
    about : About
        Facts about the scene, for its user.
    written : System
        The scene after assembly, before anything is simplified.
    """

    program: Program
    system: System
    degrees: int
    about: About
    written: System


def compose_scene(scene: Scene, wanted: Sequence[str]) -> Composed:
    """Scene of bodies before it is emitted; all its faults are found here.

    Parameters
    ----------
    scene : Scene
        A checked spatial scene.
    wanted : sequence of str
        Outputs that are computed.

    Raises
    ------
    SceneError, AssemblyError
        As of :func:`generate_dynamics`.
    """
    start = assemble_scene(scene, wanted)
    analysed = analyse(start.system, wanted)
    if analysed.mobility.degrees:
        written = written_start(scene, start.written_system, analysed.system)
        analysed = replace(analysed, system=replace(analysed.system, written_starts=written))
    require_driven(analysed, wanted)
    program = choice_of(analysed, (*LEDGER_OUTPUTS, *wanted)).program
    changes = changes_of_assembly(start.written_system, start.placed)
    notes = (
        *notes_of(changes, start.written_system.unit, scene.unit),
        *notes_of_freedom(analysed.system, analysed.mobility),
        *_notes_of_reactions(program),
        *_notes_of_distances(start.placed),
        *notes_of_rank(program, analysed.system),
    )
    moved = tuple([change.body, *change.sizes] for change in changes)
    about = replace(About.of(scene, notes), moved=moved)
    return Composed(program, analysed.system, analysed.mobility.degrees, about, start.system)


def _notes_of_distances(system: System) -> Iterator[str]:
    """Notes on forces along a distance that is zero at the start, where it has no direction."""
    fixed = fixed_system(system)
    limit = NO_LENGTH * characteristic_length(fixed)
    for force in fixed.forces:
        ends: ForceElement | RelativeCoordinate = force
        if force.coordinate >= 0 and fixed.coordinates[force.coordinate].is_distance:
            ends = fixed.coordinates[force.coordinate]
        elif not force.needs_direction:
            continue
        heights = [[height(fixed, ends, end, axis) for end in "ij"] for axis in range(3)]
        if max(abs(j - i) for i, j in heights) <= limit:
            yield (
                f"{join('forces', force.name)}: its ends are in one place at the start, where it"
                " has no direction and does nothing, until something parts them"
            )


def _notes_of_reactions(program: Program) -> Iterator[str]:
    """Notes on reactions that lead out of the plane: not unique, or not computed."""
    joints = program.unique_in_plane
    if joints:
        names = listed([scene_key(name) for name in joints])
        yield (
            f"not unique: of force and torque of {names} only what leads out of the"
            " plane; what acts in the plane is unique"
        )
    if program.only_in_plane:
        yield (
            "not computed, and NaN: what leads out of the plane of forces and torques of joints,"
            f" since in space {program.only_in_plane}"
        )
