"""Steps that simplify the equations of a scene, and the structure of those that remain.

A step compares two programs of the same scene, one before it and one after it.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from itertools import count
from typing import TYPE_CHECKING, Any

from kousoku.codegen.dynamics.analyse import PRESCRIBED, analyse, with_all_rows
from kousoku.codegen.dynamics.assembled import assemble_scene
from kousoku.codegen.dynamics.choose import cheaper, choice_of
from kousoku.codegen.dynamics.composition.auxiliary import drivers_of
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.explanation.structure import GOLDEN, structure_of
from kousoku.codegen.dynamics.explanation.text import explanation_text
from kousoku.codegen.dynamics.generate import LEDGER_OUTPUTS
from kousoku.codegen.dynamics.operations.body_coordinates import with_all_inertias
from kousoku.codegen.dynamics.recording.counts import counts, operations
from kousoku.codegen.dynamics.recording.inline import inline
from kousoku.codegen.dynamics.redundancy.freedom import mobility_of
from kousoku.codegen.dynamics.simplification.body_blocks import gyroscopic_ratios
from kousoku.codegen.dynamics.simplification.planarity import plane_of
from kousoku.codegen.dynamics.simplification.rigid_groups import fixed_joints
from kousoku.codegen.kernel_json import shipped_kinds
from kousoku.model.lowering.parametric import fixed_system
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.records.own_kind import is_own, kind_name
from kousoku.model.text import counted
from kousoku.runtime.messages import listed

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.codegen.dynamics.analyse import Analysed
    from kousoku.codegen.dynamics.explanation.structure import Structure
    from kousoku.codegen.dynamics.operations.placement import Constants
    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.codegen.dynamics.redundancy.freedom import Mobility
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.records.scene import Scene

#: Everything that can be computed.
ALL = (*LEDGER_OUTPUTS, "reactions")
BYTES = 8


@dataclass(frozen=True, slots=True)
class SavedStep:
    """Saving of one step.

    Parameters
    ----------
    name, detail : str
        Simplification, and the parts of the scene that it concerns.
    rows, columns : int
        Rows of C_q and velocities.
    operations : int
        Scalar operations of all segments, each run once.
    bytes : int
        Bytes of the workspace.
    """

    name: str
    detail: str
    rows: int = 0
    columns: int = 0
    operations: int = 0
    bytes: int = 0


@dataclass(frozen=True, slots=True, repr=False)
class Explanation:
    """Explanation of a solver: savings by each step, and the structure of what remains.

    Parameters
    ----------
    name : str
        Name of the scene.
    steps : tuple of SavedStep
        Savings, in the order of the steps.
    segments : tuple of (str, int)
        Operations of each segment of the program.
    structure : Structure
        Structure of the equations that remain.
    freedom : Mobility
        Degrees of freedom and dependent rows.
    removed : tuple of str
        The rows that depend on others, such as ``a: row 1 of p1_z``.
    drivers : tuple of str
        Drivers, which prescribe motions.
    is_planar : bool
        Whether it is solved in a coordinate plane.
    """

    name: str
    steps: tuple[SavedStep, ...]
    segments: tuple[tuple[str, int], ...]
    structure: Structure
    freedom: Mobility
    removed: tuple[str, ...]
    drivers: tuple[str, ...]
    is_planar: bool

    def __str__(self) -> str:
        return explanation_text(self)

    def __repr__(self) -> str:
        return (
            f"<Explanation of {self.name}: {counted(self.freedom.degrees, 'degree')} of freedom,"
            f" {counted(self.structure.rows, 'row')}; print() shows what each step saves>"
        )

    def as_data(self) -> dict[str, Any]:
        """Explanation as data, ready for JSON."""
        freedom = self.freedom
        return {
            "name": self.name,
            "is_planar": self.is_planar,
            "steps": [asdict(step) for step in self.steps],
            "segments": dict(self.segments),
            "structure": asdict(self.structure),
            "freedom": asdict(freedom)
            | {"degrees": freedom.degrees, "not_unique": list(freedom.not_unique)},
            "removed": list(self.removed),
            "drivers": list(self.drivers),
        }


def explain(scene: Scene, outputs: Sequence[str] | None = None) -> Explanation:
    """Explanation of a scene of bodies: savings by each step, and the structure of what remains.

    Parameters
    ----------
    scene : Scene
        A checked spatial scene.
    outputs : sequence of str, optional
        Outputs beside positions and velocities; unless given, those of the scene.

    Raises
    ------
    SceneError, AssemblyError
        As :func:`kousoku.codegen.dynamics.generate.generate_dynamics` raises them.
    """
    names = scene.outputs if outputs is None else outputs
    assembled = assemble_scene(scene, names).system
    wanted = (*LEDGER_OUTPUTS, *names)
    analysed = analyse(assembled, wanted)
    unlumped = _with_masses(assembled)
    system, freedom = analysed.system, analysed.mobility
    choice = choice_of(analysed, wanted)
    absolute, program = choice.absolute, choice.program
    prescribed = cheaper(choice.analysed, wanted, absolute, PRESCRIBED)
    kept = absolute if choice.analysed is analysed else compose(analysed, wanted)
    full = (
        compose(with_all_rows(system, analysed.outline.plane), wanted) if freedom.dropped else kept
    )
    inlined = inline(program)
    structure = structure_of(system, program)
    steps = [
        *_counted_steps(system, program),
        *_compared_steps(unlumped, analysed, full, wanted),
        _step("redundant rows removed", _rows_detail(freedom), full, kept),
        *_out_of_plane_steps(kept, absolute),
        SavedStep("parts solved apart", f"{structure.parts} without a common moving body"),
        *_reduction_steps(system, freedom, (absolute, prescribed, program)),
        _step("straight-line code", _code_detail(inlined, program), program, inlined),
        *_design_steps(system, program),
    ]
    segments: dict[str, int] = {}
    for cost in counts(inlined):
        segments[cost.segment] = segments.get(cost.segment, 0) + cost.operations
    return Explanation(
        name=scene.name,
        steps=tuple(steps),
        segments=tuple(segments.items()),
        structure=structure,
        freedom=_freedom_unlumped(unlumped) if analysed.lumped else freedom,
        removed=tuple(
            f"{row.joint}: row {row.row} of {kind_name(system.constraints[row.instance].kind)}"
            for row in freedom.dropped
        ),
        drivers=drivers_of(system),
        is_planar=program.is_planar,
    )


def _freedom_unlumped(system: System) -> Mobility:
    """Mobility of a scene whose bodies are all separate."""
    analysed = with_all_rows(system, plane_of(system))
    return mobility_of(fixed_system(system), analysed.outline)


def _compared_steps(
    unlumped: System, analysed: Analysed, full: Program, wanted: Sequence[str]
) -> Iterator[SavedStep]:
    """Steps that compare two programs, beginning with the one that leaves nothing out."""
    all_outputs = tuple(dict.fromkeys((*ALL, *wanted)))
    with_inertias = with_all_inertias(analysed.system)
    unfolded = compose(with_all_rows(_generic(_spinning(with_inertias)), None), all_outputs)
    if analysed.lumped:
        separate = compose(with_all_rows(_generic(_spinning(unlumped)), None), all_outputs)
        yield _step("bodies joined rigidly", _lumping_detail(analysed), separate, unfolded)
    else:
        yield SavedStep("bodies joined rigidly", _fixed_detail(unlumped, wanted))
    spinning = compose(with_all_rows(_spinning(with_inertias), None), all_outputs)
    in_space = compose(with_all_rows(with_inertias, None), all_outputs)
    folded = structure_of(with_inertias, in_space)
    yield _step("zeros and ones folded", _elements_detail(folded), unfolded, spinning)
    yield _step("gyroscopic terms", _moments_detail(with_inertias), spinning, in_space)
    everything = compose(with_all_rows(analysed.system, analysed.outline.plane), all_outputs)
    yield _step("planar", _plane_detail(analysed), in_space, everything)
    yield _step("outputs not wanted", _outputs_detail(wanted), everything, full)


def _out_of_plane_steps(kept: Program, program: Program) -> list[SavedStep]:
    """Cost of reactions that the motion in a plane does not determine."""
    if program.is_planar == kept.is_planar:
        return []
    return [_step("reactions out of the plane", "wanted: solved in space", kept, program)]


def _step(name: str, detail: str, before: Program, after: Program) -> SavedStep:
    columns = _columns(before) - _columns(after)
    return SavedStep(
        name=name,
        detail=detail,
        rows=len(before.rows) - len(after.rows),
        columns=columns,
        operations=operations(before) - operations(after),
        bytes=BYTES * (before.size - after.size),
    )


def _columns(program: Program) -> int:
    """Number of columns of C_q, or of C_q R."""
    return program.region("v").size - len(program.satisfied)


def _counted_steps(system: System, program: Program) -> list[SavedStep]:
    """Steps without a program to compare with: their avoided operations are counted."""
    shipped = shipped_kinds()
    kinds = [instance.kind for instance in system.constraints]
    kinds += [coordinate.kind for coordinate in system.coordinates]
    kinds += [force.kind for force in system.forces]
    used = [name for name in dict.fromkeys(kinds) if name in shipped]
    own_kinds = [kind_name(name) for name in dict.fromkeys(kinds) if is_own(name)]
    own_text = f"; of one's own: {', '.join(own_kinds)}" if own_kinds else ""
    kinds_text = f"{len(used)} of {len(shipped)} used: {', '.join(used) or 'none'}{own_text}"
    grounded = sum(GROUND_INDEX in instance.bodies for instance in system.constraints)
    return [
        SavedStep("kinds not used", kinds_text),
        SavedStep("ground has no columns", f"{grounded} constraints with the ground", columns=6),
        SavedStep(
            "mass blocks inverted beforehand",
            f"{len(system.bodies)} constant diagonal blocks",
            operations=program.region("v").size,
        ),
    ]


def _with_masses(system: System) -> System:
    """System whose bodies all have mass and inertia, 1 kg where there is no mass."""
    bodies = tuple(replace(body, mass=body.mass or 1.0) for body in system.bodies)
    return with_all_inertias(replace(system, bodies=bodies))


def _spinning(system: System) -> System:
    """System with bodies of three different moments, to compare with."""
    return replace(
        system,
        bodies=tuple(
            replace(body, inertia=(x, 0.9 * x, 0.7 * x))
            for body, x in ((body, float(max(body.inertia))) for body in system.bodies)
        ),
    )


def _generic(system: System) -> System:
    """System with points and axes in which nothing is zero or one, to compare with."""
    return replace(
        system,
        constraints=tuple(
            replace(instance, constants=_without_zeros(instance.constants))
            for instance in system.constraints
        ),
        coordinates=tuple(
            replace(coordinate, constants=_without_zeros(coordinate.constants))
            for coordinate in system.coordinates
        ),
    )


def _without_zeros(constants: Constants) -> Constants:
    numbers = (GOLDEN * k % 1.0 for k in count(1))
    return tuple(
        (name, tuple(next(numbers) if x in {-1.0, 0.0, 1.0} else x for x in values))
        for name, values in constants
    )


def _design_steps(system: System, program: Program) -> list[SavedStep]:
    """Numbers that parameters change, and the cost of changing them."""
    if not program.design:
        return []
    setup = replace(program, segments=(program.segment("setup"),))
    numbers = program.region("design").size
    known = [name for name, _ in system.parameters]
    used = [name for name in known if name in program.design.names]
    detail = f"{numbers} from {', '.join(used)}: {operations(setup)} operations, once in a run"
    return [SavedStep("numbers that stay arguments", detail)]


def _lumping_detail(analysed: Analysed) -> str:
    bodies, lumped = len(analysed.system.carried), len(analysed.system.bodies)
    return f"{', '.join(analysed.lumped)} left out: {bodies} bodies move as {lumped}"


def _fixed_detail(system: System, wanted: Sequence[str]) -> str:
    if not fixed_joints(fixed_system(system)):
        return "no fixed joint"
    if not fixed_joints(system):
        return "parameters move them against each other"
    return "their reactions are wanted" if "reactions" in wanted else "not where it costs more"


def _moments_detail(system: System) -> str:
    """Text of the count of ratios (I₂ − I₃)/I₁ and alike that are zero, as moments are equal."""
    ratios = [gyroscopic_ratios(body, range(6)) for body in system.bodies if not body.is_point]
    zeros = sum(ratio == 0 for row in ratios for ratio in row)
    return f"{zeros} of {3 * len(ratios)} are zero in space: equal moments of inertia"


def _reduction_steps(
    system: System, freedom: Mobility, programs: tuple[Program, Program, Program]
) -> list[SavedStep]:
    """Savings by the coordinates of joints with the ground.

    ``programs`` are the one without them, the one with them for driven bodies, and the final one.
    """
    absolute, prescribed, program = programs
    return [
        _step(
            "prescribed bodies evaluated",
            _drivers_detail(system, prescribed, freedom),
            absolute,
            prescribed,
        ),
        _step(
            "dependent coordinates eliminated",
            _ground_detail(system, prescribed, program),
            prescribed,
            program,
        ),
    ]


def _drivers_detail(system: System, prescribed: Program, freedom: Mobility) -> str:
    """Text of the bodies that drivers lead: their positions are formulas of the time."""
    drivers = drivers_of(system)
    if not drivers:
        return "no driver"
    driven = _reduced_bodies(system, prescribed) or "no body that hangs on the ground alone"
    text = f"{', '.join(drivers)}: {driven}"
    return text if freedom.degrees else f"{text}; nothing is left to integrate"


def _ground_detail(system: System, prescribed: Program, program: Program) -> str:
    """Text of the bodies that have the velocities that their joint with the ground leaves."""
    if program.left_out:
        return "rows depend on others: all are needed"
    names = _reduced_bodies(system, program, prescribed)
    return f"{names}: by what the ground leaves free" if names else "cheaper for no body"


def _reduced_bodies(system: System, program: Program, without: Program | None = None) -> str:
    """Names of bodies in coordinates of joints, those of another program left out."""
    excluded = without.satisfied if without else ()
    rows = (system.constraints[row.instance] for row in program.satisfied if row not in excluded)
    bodies = dict.fromkeys(max(instance.bodies) for instance in rows)
    names = [system.bodies[k].name for k in bodies]
    return listed(names)


def _elements_detail(structure: Structure) -> str:
    return f"{structure.elements} of {structure.dense} elements of C_q are not zero in space"


def _plane_detail(analysed: Analysed) -> str:
    return (
        "proven to stay in a coordinate plane"
        if analysed.outline.is_planar
        else "not in such a plane"
    )


def _outputs_detail(wanted: Sequence[str]) -> str:
    omitted = [name for name in ALL if name not in wanted]
    return f"{', '.join(omitted)} not computed" if omitted else "all are wanted"


def _rows_detail(freedom: Mobility) -> str:
    if not freedom.dropped:
        return "not looked for in all parts" if freedom.unknown else "none depends on others"
    names = dict.fromkeys(row.joint for row in freedom.dropped)
    return f"of {', '.join(names)}"


def _code_detail(inlined: Program, program: Program) -> str:
    return "loops over equal tasks stay" if inlined is program else "all tasks on one graph"
