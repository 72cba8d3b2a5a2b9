"""From a scene of bodies to the folder of its solver; SymPy is never started."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.assembly.moved import changes_of_assembly
from kousoku.codegen.dynamics.checking.reference import solver_references
from kousoku.codegen.dynamics.checking.run import Workspace
from kousoku.codegen.dynamics.composition.bodies import thickened
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.emission.emit import emit_dynamics
from kousoku.codegen.dynamics.emission.motion_data import is_flat
from kousoku.codegen.dynamics.recording.inline import inline
from kousoku.codegen.dynamics.redundancy.closure import notes_of_freedom
from kousoku.codegen.dynamics.redundancy.freedom import Freedom, by_instance, freedom_of, kept_rows
from kousoku.codegen.dynamics.redundancy.given_rank import notes_of_rank
from kousoku.codegen.dynamics.redundancy.nearly import put_together
from kousoku.codegen.dynamics.redundancy.out_of_plane import held_twice
from kousoku.codegen.dynamics.redundancy.own_rows import repeated_rows, require_own_rows_implied
from kousoku.codegen.dynamics.redundancy.unmoved import require_unmoved_rows_hold
from kousoku.codegen.dynamics.simplification.given_start import given_start, require_held
from kousoku.codegen.dynamics.simplification.merge import merged
from kousoku.codegen.dynamics.simplification.reduced_program import reduced
from kousoku.codegen.dynamics.simplification.weights import require_driven, weighted
from kousoku.model.about import About
from kousoku.model.errors import SceneError
from kousoku.model.held import require_kept, without_held
from kousoku.model.manifest import REFERENCE_FILE
from kousoku.model.system import system_of
from kousoku.model.varying import fixed_system
from kousoku.runtime.integrate.given_start import notes_of
from kousoku.runtime.integrate.result import key_of, listed

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanism import System
    from kousoku.model.scene import Scene


#: What every solver has for the ledger of its runs.
LEDGER = ("checks", "energies")
#: Rows are dependent when one pivot is smaller than this part of another.
DEPENDENT = 1e-12


def generate_dynamics(
    scene: Scene, outputs: Sequence[str] | None = None, *, references: bool = False
) -> dict[str, str]:
    """Return the folder of the solver of a scene of bodies.

    Parameters
    ----------
    scene : Scene
        A checked spatial scene.
    outputs : sequence of str, optional
        What is wanted of ``accelerations``, ``reactions`` and ``energies``, beside positions and
        velocities; what the scene says unless given.
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
    made = composed(scene, wanted)
    program, system = made.program, made.system
    more = {}
    if references:
        more[REFERENCE_FILE] = solver_references(program, system, made.written)
    return emit_dynamics(inline(program), system, wanted, more, made.about)


@dataclass(frozen=True, slots=True)
class Composed:
    """What a solver is emitted from.

    Parameters
    ----------
    program, system : Program, System
        What is computed, and of what.
    degrees : int
        Degrees of freedom.
    about : About
        What is told of the scene.
    written : System
        The scene after assembly, before anything is simplified.
    """

    program: Program
    system: System
    degrees: int
    about: About
    written: System


def composed(scene: Scene, wanted: Sequence[str]) -> Composed:
    """Return what a scene of bodies becomes before it is emitted; all that is wrong is found here.

    Parameters
    ----------
    scene : Scene
        A checked spatial scene.
    wanted : sequence of str
        What is computed.

    Raises
    ------
    SceneError, AssemblyError
        As of :func:`generate_dynamics`.
    """
    given = system_of(scene, wanted)
    require_kept(given)
    placed = put_together(given)
    require_held(given, placed)
    found = weighted(merged(without_held(placed), wanted).system)
    outline = outlined(found.system, (*LEDGER, *wanted))
    freedom = outline.freedom
    if freedom.degrees:
        start = given_start(scene, given, outline.system)
        outline = outline._replace(system=replace(outline.system, given=start))
    require_driven(found, freedom, wanted)
    made = (with_reactions if "reactions" in wanted else of_outline)((*LEDGER, *wanted), outline)
    program = reduced(made.system, (*LEDGER, *wanted), made.program)
    program = replace(program, is_weighed=not found.missing)
    changes = changes_of_assembly(given, placed)
    notes = (
        *notes_of(changes, given.unit, scene.unit),
        *notes_of_freedom(made.system, freedom),
        *_of_reactions(program),
        *notes_of_rank(program, made.system),
    )
    about = replace(About.of(scene, notes), moved=tuple([one.body, *one.sizes] for one in changes))
    return Composed(program, made.system, freedom.degrees, about, without_held(placed))


class Independent(NamedTuple):
    """A program without rows that depend on others, or the outline of one with all rows.

    Parameters
    ----------
    program : Program
        As :func:`compose` returns it.
    freedom : Freedom
        Degrees of freedom, and the rows that were left out.
    system : System
        The scene, where all other rows hold.
    """

    program: Program
    freedom: Freedom
    system: System


def _of_reactions(program: Program) -> Iterator[str]:
    """Yield notes on what leads out of the plane: not unique, or not computed."""
    joints = program.unique_in_plane
    if joints:
        names = listed([key_of(name) for name in joints])
        yield (
            f"not unique: of force and torque of {names} only what leads out of the"
            " plane; what acts in the plane is unique"
        )
    if program.only_in_plane:
        yield (
            "not computed, and NaN: what leads out of the plane of forces and torques of joints,"
            f" since in space {program.only_in_plane}"
        )


def outlined(system: System, wanted: Sequence[str], *, may_be_planar: bool = True) -> Independent:
    """Return the outline of an assembled system, and which of its rows depend on others."""
    outline = compose(system, wanted, may_be_planar=may_be_planar, is_outline=True)
    fixed = fixed_system(system)
    require_unmoved_rows_hold(fixed, outline)
    freedom = freedom_of(fixed, outline)
    require_own_rows_implied(fixed, freedom, is_planar=outline.is_planar)
    freedom = replace(freedom, idle=(*freedom.idle, *repeated_rows(fixed, freedom)))
    if freedom.closed:
        system = assemble(system, [(row.instance, row.row) for row in freedom.dropped])
    return Independent(outline, freedom, system)


def of_outline(wanted: Sequence[str], outline: Independent) -> Independent:
    """Return the program of an outline, without the rows that depend on others."""
    program, freedom, system = outline
    rows, sets, idle = None, None, None
    if freedom.dropped:
        rows, idle = kept_rows(freedom, program), by_instance(freedom.idle)
        sets = freedom.shared
    made = compose(
        system, wanted, rows=rows, dependent=sets, idle=idle, may_be_planar=program.is_planar
    )
    return outline._replace(program=made)


def independent(
    system: System, wanted: Sequence[str], *, may_be_planar: bool = True
) -> Independent:
    """Return the program of an assembled system without rows that depend on others."""
    return of_outline(wanted, outlined(system, wanted, may_be_planar=may_be_planar))


def with_reactions(wanted: Sequence[str], outline: Independent) -> Independent:
    """Return the program that finds the forces of all joints, and knows which are not unique.

    Parameters
    ----------
    wanted : sequence of str
        What is computed.
    outline : Independent
        As :func:`outlined` returned it: where its scene moves in a plane and forces lead out of
        that, a program in space takes its place.

    Returns
    -------
    Independent
        In a plane, joints that are named because of what leads out of it only are named apart.
    """
    freedom, system = outline.freedom, outline.system
    if not outline.program.is_planar:
        made = of_outline(wanted, outline)
        return made._replace(program=_not_unique(made.program, freedom))
    in_plane = dict.fromkeys((*freedom.not_unique, *freedom.unknown))
    found, why = None, ""
    if not is_flat(outline.program, system):
        try:
            found = _in_space(system, wanted)
        except SceneError as error:  # rows depend on each other in another way, or too many
            why = f"{error.key}: {error.problem}"
    if found is None:
        found = of_outline(wanted, outline)
        twice = held_twice(fixed_system(system), found.program)
        program = replace(found.program, not_unique=twice, only_in_plane=why)
        found = found._replace(program=program)
    others = tuple(name for name in found.program.not_unique if name not in in_plane)
    own = tuple(one for one in found.freedom.undetermined if one[0] in in_plane)
    named = replace(
        found.program, not_unique=tuple(in_plane), undetermined=own, unique_in_plane=others
    )
    return found._replace(program=named)


def _in_space(system: System, wanted: Sequence[str]) -> Independent:
    """Return the program in space of a scene that moves in a plane; SceneError if there is none."""
    made = independent(thickened(system), wanted, may_be_planar=False)
    program = _not_unique(made.program, made.freedom)
    if not _is_regular(program):
        raise SceneError("rows that are kept depend on each other at the start")
    return made._replace(program=program, system=system)


def _not_unique(program: Program, freedom: Freedom) -> Program:
    return replace(
        program,
        not_unique=(*freedom.not_unique, *freedom.unknown),
        undetermined=freedom.undetermined,
    )


def _is_regular(program: Program) -> bool:
    """Return whether the rows that a program keeps are independent at the start."""
    workspace = Workspace(program)
    try:
        workspace.run("geometry")
    except ZeroDivisionError:  # a pivot is exactly zero
        return False
    pivots = workspace["pivots"]
    return not pivots or min(pivots) > DEPENDENT * max(pivots)
