"""Choice among several programs of a system, where only composing them tells the better one.

Joint coordinates save rows, and may cost operations: both programs are counted. Forces of joints
that lead out of a plane need equations in space: where these fail, only components in the plane
are computed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.analyse import ANY, ranked, with_joint_coordinates
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.operations.body_coordinates import with_all_inertias
from kousoku.codegen.dynamics.recording.counts import counts
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.redundancy.out_of_plane import held_twice
from kousoku.codegen.dynamics.simplification.forces_plane import is_flat
from kousoku.codegen.dynamics.simplification.ground_joints import is_worth
from kousoku.model.errors import SceneError
from kousoku.model.lowering.parametric import fixed_system

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.analyse import Analysed
    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.codegen.dynamics.redundancy.freedom import Mobility

#: Segments that every stage of a step runs: their cost decides, whatever the outputs are.
STAGE_SEGMENTS = frozenset({"geometry", "position", "move", "velocity", "acceleration"})
#: Rows are dependent when one pivot is smaller than this part of another, or its inverse, which is
#: what is compared: of the sixteen digits of a double such a pivot has four at most.
DEPENDENT_PIVOT_RATIO = 1e-12


@dataclass(frozen=True, slots=True)
class Choice:
    """Program of a scene, and the program in absolute coordinates that it was compared with.

    Parameters
    ----------
    analysed : Analysed
        System that both are composed from: the scene as analysed, or with all inertias for forces
        that lead out of its plane.
    absolute : Program
        The program without joint coordinates.
    program : Program
        The one that costs less.
    """

    analysed: Analysed
    absolute: Program
    program: Program


def choice_of(analysed: Analysed, wanted: Sequence[str]) -> Choice:
    """Program of an analysed system, chosen.

    Parameters
    ----------
    analysed : Analysed
        The scene, without joint coordinates.
    wanted : sequence of str
        Outputs that are computed.
    """
    if "reactions" in wanted:
        chosen, absolute = with_reactions(analysed, wanted)
    else:
        chosen, absolute = analysed, compose(analysed, wanted)
    absolute = replace(absolute, has_masses=not analysed.missing)
    return Choice(chosen, absolute, cheaper(chosen, wanted, absolute))


def cheaper(
    analysed: Analysed, wanted: Sequence[str], program: Program, most_free: int = ANY
) -> Program:
    """Program in joint coordinates where it costs less, or else the program without.

    Joint coordinates are not tried where rows depend on others: there all rows are needed, to watch
    them and to take over. And not in a large scene with few bodies at the ground, unless drivers
    lead these.

    Parameters
    ----------
    analysed : Analysed
        The scene, without joint coordinates.
    wanted : sequence of str
        Outputs that are computed.
    program : Program
        The program of the scene without joint coordinates.
    most_free : int
        Most velocities that a joint may leave to a body.
    """
    if analysed.left_out or not is_worth(analysed.system, analysed.outline.rows):
        return program
    reduced = with_joint_coordinates(analysed, most_free)
    if not reduced.transformations:
        return program
    candidate = compose(reduced, wanted)
    if _cost(candidate) >= _cost(program):
        return program
    return replace(
        candidate,
        has_masses=program.has_masses,
        not_unique=program.not_unique,
        undetermined=program.undetermined,
        unique_in_plane=program.unique_in_plane,
        only_in_plane=program.only_in_plane,
    )


def _cost(program: Program) -> int:
    return sum(cost.operations for cost in counts(program) if cost.segment in STAGE_SEGMENTS)


def with_reactions(analysed: Analysed, wanted: Sequence[str]) -> tuple[Analysed, Program]:
    """Program that computes the forces of all joints, and knows which are not unique.

    Parameters
    ----------
    analysed : Analysed
        The scene: where it moves in a plane and forces lead out of that, equations in space replace
        its equations in the plane.
    wanted : sequence of str
        Outputs that are computed.

    Returns
    -------
    Analysed, Program
        The system that was composed, and the program. Of a scene in a plane, joints whose forces
        are not unique only out of the plane are listed apart.
    """
    mobility, system = analysed.mobility, analysed.system
    if not analysed.outline.is_planar:
        return analysed, _named(compose(analysed, wanted), mobility)
    in_plane = dict.fromkeys((*mobility.not_unique, *mobility.unknown))
    composed, obstacle = None, ""
    if not is_flat(system, analysed.outline.normal):
        try:
            composed = _in_space(analysed, wanted)
        except SceneError as error:  # rows depend on each other in another way, or too many
            obstacle = f"{error.key}: {error.problem}"
    if composed is None:
        program = compose(analysed, wanted)
        doubly_held = held_twice(fixed_system(system), program)
        composed = analysed, replace(program, not_unique=doubly_held, only_in_plane=obstacle)
    chosen, program = composed
    others = tuple(name for name in program.not_unique if name not in in_plane)
    undetermined = tuple(pair for pair in chosen.mobility.undetermined if pair[0] in in_plane)
    return chosen, replace(
        program, not_unique=tuple(in_plane), undetermined=undetermined, unique_in_plane=others
    )


def _in_space(analysed: Analysed, wanted: Sequence[str]) -> tuple[Analysed, Program]:
    """Program in space of a scene that moves in a plane; SceneError if there is none."""
    spatial = ranked(with_all_inertias(analysed.system), None)
    program = _named(compose(spatial, wanted), spatial.mobility)
    if not _is_regular(program):
        raise SceneError("rows that are kept depend on each other at the start")
    return spatial, program


def _named(program: Program, mobility: Mobility) -> Program:
    """Program with the joints whose reactions are not unique."""
    return replace(
        program,
        not_unique=(*mobility.not_unique, *mobility.unknown),
        undetermined=mobility.undetermined,
    )


def _is_regular(program: Program) -> bool:
    """Whether the rows that a program keeps are independent at the start."""
    workspace = ProgramInterpreter(program)
    try:
        workspace.run("geometry")
    except ZeroDivisionError:  # a pivot is exactly zero
        return False
    pivots = workspace["pivots"]
    return not pivots or min(pivots) > DEPENDENT_PIVOT_RATIO * max(pivots)
