"""Parts that a scene does not need, step by step, and the structure of the rest.

A step compares two programs of the same scene: one that does without, and one that does not.
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
from kousoku.codegen.dynamics.redundancy.freedom import freedom_of
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
    from kousoku.codegen.dynamics.redundancy.freedom import Freedom
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
        What was done, and to what.
    rows, columns : int
        Rows of C_q and velocities.
    operations : int
        Scalar operations of all segments, each run once.
    bytes : int
        Of the workspace.
    """

    name: str
    detail: str
    rows: int = 0
    columns: int = 0
    operations: int = 0
    bytes: int = 0


@dataclass(frozen=True, slots=True, repr=False)
class Explanation:
    """Explanation of a solver: steps that the scene does not need, and the structure of the rest.

    Parameters
    ----------
    name : str
        The scene.
    steps : tuple of SavedStep
        In the order in which they are taken.
    segments : tuple of (str, int)
        Operations of each segment of the program.
    structure : Structure
        What remains.
    freedom : Freedom
        Degrees of freedom and dependent rows.
    removed : tuple of str
        The rows that depend on others, such as ``a: row 1 of p1_z``.
    drivers : tuple of str
        What prescribes motions.
    is_planar : bool
        Whether it is solved in a coordinate plane.
    """

    name: str
    steps: tuple[SavedStep, ...]
    segments: tuple[tuple[str, int], ...]
    structure: Structure
    freedom: Freedom
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
    """Explanation of a scene of bodies: steps that it does not need, and the structure of the rest.

    Parameters
    ----------
    scene : Scene
        A checked spatial scene.
    outputs : sequence of str, optional
        What is wanted beside positions and velocities; what the scene says unless given.

    Raises
    ------
    SceneError, AssemblyError
        As :func:`kousoku.codegen.dynamics.generate.generate_dynamics` raises them.
    """
    names = scene.outputs if outputs is None else outputs
    assembled = assemble_scene(scene, names).system
    wanted = (*LEDGER_OUTPUTS, *names)
    found = analyse(assembled, wanted)
    unlumped = _with_masses(assembled)
    system, freedom = found.system, found.freedom
    choice = choice_of(found, wanted)
    whole, program = choice.whole, choice.program
    prescribed = cheaper(choice.analysed, wanted, whole, PRESCRIBED)
    kept = whole if choice.analysed is found else compose(found, wanted)
    full = compose(with_all_rows(system, found.outline.plane), wanted) if freedom.dropped else kept
    final = inline(program)
    structure = structure_of(system, program)
    steps = [
        *_counted(system, program),
        *_compared(unlumped, found, full, wanted),
        _step("redundant rows removed", _of_rows(freedom), full, kept),
        *_out_of_plane(kept, whole),
        SavedStep("parts solved apart", f"{structure.parts} without a common moving body"),
        *_of_reduction(system, freedom, (whole, prescribed, program)),
        _step("straight-line code", _of_code(final, program), program, final),
        *_of_design(system, program),
    ]
    segments: dict[str, int] = {}
    for one in counts(final):
        segments[one.segment] = segments.get(one.segment, 0) + one.operations
    return Explanation(
        name=scene.name,
        steps=tuple(steps),
        segments=tuple(segments.items()),
        structure=structure,
        freedom=_freedom_unlumped(unlumped) if found.lumped else freedom,
        removed=tuple(
            f"{row.joint}: row {row.row} of {kind_name(system.constraints[row.instance].kind)}"
            for row in freedom.dropped
        ),
        drivers=drivers_of(system),
        is_planar=program.is_planar,
    )


def _freedom_unlumped(system: System) -> Freedom:
    """Freedom of a scene in which all bodies are apart."""
    found = with_all_rows(system, plane_of(system))
    return freedom_of(fixed_system(system), found.outline)


def _compared(
    unlumped: System, found: Analysed, full: Program, wanted: Sequence[str]
) -> Iterator[SavedStep]:
    """Steps that compare two programs, from one that leaves nothing out."""
    all_of = tuple(dict.fromkeys((*ALL, *wanted)))
    with_inertias = with_all_inertias(found.system)
    unfolded = compose(with_all_rows(_generic(_spinning(with_inertias)), None), all_of)
    if found.lumped:
        separate = compose(with_all_rows(_generic(_spinning(unlumped)), None), all_of)
        yield _step("bodies joined rigidly", _of_joints(found), separate, unfolded)
    else:
        yield SavedStep("bodies joined rigidly", _of_fixed(unlumped, wanted))
    spinning = compose(with_all_rows(_spinning(with_inertias), None), all_of)
    in_space = compose(with_all_rows(with_inertias, None), all_of)
    folded = structure_of(with_inertias, in_space)
    yield _step("zeros and ones folded", _of_elements(folded), unfolded, spinning)
    yield _step("gyroscopic terms", _of_moments(with_inertias), spinning, in_space)
    everything = compose(with_all_rows(found.system, found.outline.plane), all_of)
    yield _step("planar", _of_plane(found), in_space, everything)
    yield _step("outputs not wanted", _of_outputs(wanted), everything, full)


def _out_of_plane(kept: Program, program: Program) -> list[SavedStep]:
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


def _counted(system: System, program: Program) -> list[SavedStep]:
    """Steps that leave nothing to compare with: avoided operations are counted."""
    shipped = shipped_kinds()
    kinds = [one.kind for one in system.constraints]
    kinds += [one.kind for one in system.coordinates] + [one.kind for one in system.forces]
    used = [name for name in dict.fromkeys(kinds) if name in shipped]
    own = [kind_name(name) for name in dict.fromkeys(kinds) if is_own(name)]
    of_own = f"; of one's own: {', '.join(own)}" if own else ""
    used_of = f"{len(used)} of {len(shipped)} used: {', '.join(used) or 'none'}{of_own}"
    grounded = sum(GROUND_INDEX in one.bodies for one in system.constraints)
    return [
        SavedStep("kinds not used", used_of),
        SavedStep("ground has no columns", f"{grounded} constraints with the ground", columns=6),
        SavedStep(
            "mass blocks inverted beforehand",
            f"{len(system.bodies)} constant diagonal blocks",
            operations=program.region("v").size,
        ),
    ]


def _with_masses(system: System) -> System:
    """System with bodies that all weigh something, which one of many need not do."""
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
            replace(one, constants=_without_zeros(one.constants)) for one in system.constraints
        ),
        coordinates=tuple(
            replace(one, constants=_without_zeros(one.constants)) for one in system.coordinates
        ),
    )


def _without_zeros(constants: Constants) -> Constants:
    numbers = (GOLDEN * k % 1.0 for k in count(1))
    return tuple(
        (name, tuple(next(numbers) if x in {-1.0, 0.0, 1.0} else x for x in values))
        for name, values in constants
    )


def _of_design(system: System, program: Program) -> list[SavedStep]:
    """Numbers that parameters change, and the cost of changing them."""
    if not program.design:
        return []
    setup = replace(program, segments=(program.segment("setup"),))
    numbers = program.region("design").size
    known = [name for name, _ in system.parameters]
    used = [name for name in known if name in program.design.names]
    detail = f"{numbers} from {', '.join(used)}: {operations(setup)} operations, once in a run"
    return [SavedStep("numbers that stay arguments", detail)]


def _of_joints(found: Analysed) -> str:
    bodies = len(found.system.carried)
    return f"{', '.join(found.lumped)} left out: {bodies} bodies move as {len(found.system.bodies)}"


def _of_fixed(system: System, wanted: Sequence[str]) -> str:
    if not fixed_joints(fixed_system(system)):
        return "no fixed joint"
    if not fixed_joints(system):
        return "parameters move them against each other"
    return "their reactions are wanted" if "reactions" in wanted else "not where it costs more"


def _of_moments(system: System) -> str:
    """Say of how many bodies moments are equal, so that (I₂ − I₃)/I₁ and its like are zero."""
    ratios = [gyroscopic_ratios(body, range(6)) for body in system.bodies if not body.is_point]
    gone = sum(ratio == 0 for own in ratios for ratio in own)
    return f"{gone} of {3 * len(ratios)} are zero in space: equal moments of inertia"


def _of_reduction(
    system: System, freedom: Freedom, programs: tuple[Program, Program, Program]
) -> list[SavedStep]:
    """Saving by the coordinates of joints with the ground.

    ``programs`` are without that, with bodies that drivers lead, and with all.
    """
    whole, prescribed, program = programs
    return [
        _step(
            "prescribed bodies evaluated",
            _of_drivers(system, prescribed, freedom),
            whole,
            prescribed,
        ),
        _step(
            "dependent coordinates eliminated",
            _of_ground(system, prescribed, program),
            prescribed,
            program,
        ),
    ]


def _of_drivers(system: System, prescribed: Program, freedom: Freedom) -> str:
    """Say which bodies drivers lead: their positions are formulas of the time."""
    drivers = drivers_of(system)
    if not drivers:
        return "no driver"
    led = _bodies_of(system, prescribed) or "no body that hangs on the ground alone"
    found = f"{', '.join(drivers)}: {led}"
    return found if freedom.degrees else f"{found}; nothing is left to integrate"


def _of_ground(system: System, prescribed: Program, program: Program) -> str:
    """Say which bodies have the velocities that their joint with the ground leaves."""
    if program.left_out:
        return "rows depend on others: all are needed"
    names = _bodies_of(system, program, prescribed)
    return f"{names}: by what the ground leaves free" if names else "cheaper for no body"


def _bodies_of(system: System, program: Program, without: Program | None = None) -> str:
    """Names of bodies that are put onto joints."""
    known = without.satisfied if without else ()
    rows = (system.constraints[row.instance] for row in program.satisfied if row not in known)
    bodies = dict.fromkeys(max(one.bodies) for one in rows)
    names = [system.bodies[k].name for k in bodies]
    return listed(names)


def _of_elements(structure: Structure) -> str:
    return f"{structure.elements} of {structure.dense} elements of C_q are not zero in space"


def _of_plane(found: Analysed) -> str:
    return (
        "proven to stay in a coordinate plane" if found.outline.is_planar else "not in such a plane"
    )


def _of_outputs(wanted: Sequence[str]) -> str:
    left = [name for name in ALL if name not in wanted]
    return f"{', '.join(left)} not computed" if left else "all are wanted"


def _of_rows(freedom: Freedom) -> str:
    if not freedom.dropped:
        return "not looked for in all parts" if freedom.unknown else "none depends on others"
    names = dict.fromkeys(row.joint for row in freedom.dropped)
    return f"of {', '.join(names)}"


def _of_code(final: Program, program: Program) -> str:
    return "loops over equal tasks stay" if final is program else "all tasks on one graph"
