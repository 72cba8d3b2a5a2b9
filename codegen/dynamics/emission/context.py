"""From a program to the context of the templates of its solver in C."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter
from textwrap import wrap
from typing import TYPE_CHECKING, get_type_hints

from kousoku.codegen.context_body import layout, output_text, straight_line
from kousoku.codegen.context_names import Namer
from kousoku.codegen.dynamics.emission.context_numbers import (
    Table,
    has_drivers,
    has_row_switch,
    is_driven,
    layout_sizes,
    mass_places,
    tables,
    unwrapped_angles,
    works,
)
from kousoku.codegen.dynamics.emission.slots import SCRATCH, Slots, slots_of
from kousoku.codegen.dynamics.recording.program import REGIONS, meaning_of
from kousoku.codegen.dynamics.redundancy.varying_rank import rank_rows
from kousoku.codegen.printers import C
from kousoku.model.errors import EmitError
from kousoku.model.lowering.root_functions import root_functions_of
from kousoku.model.operations.graph import literal
from kousoku.runtime.integrate.methods import METHODS, RungeKuttaMethod
from kousoku.runtime.integrate.scene_tables import DENSE
from kousoku.runtime.integrate.settings import KINEMATICS, Doubt, Settings, Status
from kousoku.runtime.integrate.state import Field, fields
from kousoku.runtime.integrate.trust import RunVerdict

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

    from kousoku.codegen.dynamics.recording.program import Program, Segment, Task
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.operations.kernel import Kernel


#: Tables whose rows have several numbers.
PAIRS = frozenset(
    {
        *("shifts", "orientations", "drivers", "starts", "parts", "events", "rank_rows"),
        *("narrow_scales", "feature_scales"),
    }
)
#: Counts and first slots by the features that they need; those of features that a scene lacks are
#: zeros in ``integrate/lacking.h``.
FEATURE_NUMBERS = {
    ("HAS_ROWS",): ("NC",),
    ("HAS_CONSTANTS",): ("CONSTANTS", "W_CONSTANTS"),
    ("HAS_PARAMETERS",): ("N_PARAMETERS", "W_PARAMETERS"),
    ("HAS_DESIGN",): ("N_DESIGN", "STARTS", "POSITIVE", "W_DESIGN"),
    ("HAS_WORKS",): ("WORKS",),
    ("HAS_UNWRAPPED_ANGLES",): ("UNWRAPPED_ANGLES", "UNWRAPPED_ANGLES_END"),
    ("HAS_MOMENTA",): ("MOMENTA", "W_MOMENTA"),
    ("HAS_RANK",): ("RANK_ROWS",),
    ("HAS_ROW_SWITCH", "HAS_DRIVERS"): ("DRIVERS",),
    ("HAS_REFINEMENT", "HAS_DRIVERS"): ("N_POWER", "W_MORE_POWER"),
    ("HAS_REFINEMENT", "HAS_REACTIONS"): ("W_MORE_LAM",),
    ("HAS_REACTIONS",): ("W_LAM",),
    ("HAS_COORDINATES",): ("N_SHOWN", "PER_SHOWN", "W_COORDINATES"),
    ("HAS_WRENCHES",): ("N_WRENCHES", "W_ALL_LAM", "W_WRENCHES"),
    ("HAS_SWITCHING",): ("N_SWITCHES", "N_FEATURES", "W_SPAN", "W_SWITCHES", "W_FEATURES"),
    ("HAS_GAPS",): ("N_GAPS", "W_GAPS"),
    ("HAS_BENDING",): ("N_LAWS", "W_LAW_SPAN", "W_LAWS"),
    ("HAS_CROSSING",): (
        *("N_CROSSINGS", "N_NARROW", "EVENTS", "N_POLES", "N_INFINITE"),
        *("W_RANGES", "W_CROSSINGS", "W_NARROW", "W_POLES"),
    ),
    ("HAS_BREAKS",): ("N_BREAKS", "W_BREAKS"),
    ("HAS_MEASURE",): ("N_MEASURES", "W_MEASURES"),
    ("HAS_DISTANCE",): ("N_LENGTHS", "N_DISTANCES", "W_LENGTHS", "W_DISTANCES"),
}
#: Width of the lines of tables.
TABLE_WIDTH = 92
#: The longest table that stands in the line of its name.
LONGEST_INLINE_TABLE = 50


@dataclass(frozen=True, slots=True)
class KernelText:
    """A kernel as a C function.

    Parameters
    ----------
    name : str
        ``kernel_3``; that of the segment where it is a whole segment, or a part of one.
    title : str
        Title of its results.
    operations : int
        Scalar operations of one call.
    pointers : tuple of str
        Declarations of the regions of the workspace ``w`` that it names, in lines; of a kernel that
        tasks call they are at their slots ``s``.
    statements : tuple of (str, str)
        Name and text of each intermediate value.
    results : tuple of (str, str)
        Element of an output, and its text.
    slots : int
        Count of the slots that a task of it lists.
    repeats : bool
        Whether there are several of its tasks in a row: loops take compilers a time.
    """

    name: str
    title: str
    operations: int
    pointers: tuple[str, ...]
    statements: tuple[tuple[str, str], ...]
    results: tuple[tuple[str, str], ...]
    slots: int
    repeats: bool


@dataclass(frozen=True, slots=True)
class SegmentText:
    """A segment as a C function.

    Parameters
    ----------
    name, meaning : str
        Its name, and what it reads and writes.
    contents : tuple of str
        Contents that were inlined into it, in lines.
    functions : tuple of KernelText
        Functions of the whole workspace that it is made of; none where it has tasks.
    table : str
        Its tasks: kernel and count, then the slots of each task with its owner, in lines.
    length : int
        Count of numbers in the table.
    """

    name: str
    meaning: str
    contents: tuple[str, ...]
    functions: tuple[KernelText, ...]
    table: str
    length: int

    @property
    def is_one(self) -> bool:
        """Whether it is one function."""
        return len(self.functions) == 1


@dataclass(frozen=True, slots=True)
class MethodText:
    """A Runge-Kutta method as C arrays."""

    name: str
    order: int
    stages: int
    all: int
    dense_rows: int
    work_rows: int
    work_scale: float
    arrays: tuple[tuple[str, str], ...]
    has_second_error: bool


@dataclass(frozen=True, slots=True)
class SolverContext:
    """Context of the templates of a solver in C.

    Parameters
    ----------
    name : str
        The scene; names begin with ``kousoku_<name>``.
    features : tuple of str
        Features of the scene that others may lack.
    sizes, places : str
        Enumerators, in lines: counts, and first slots of the regions.
    state : tuple of Field
        The layout of the state.
    kernels : tuple of KernelText
        Kernels that tasks call.
    segments : tuple of SegmentText
        In order.
    tables : mapping of str to str
        Initialisers of tables that have rows; their lines name the owners of these.
    length : str
        A length of the scene [m].
    closure_tolerance : str
        Residual of rows that are left out at most, relative to that length, or in radians.
    mass : str
        Mass of all bodies [kg].
    parts : tuple of str
        Regions that a row has beyond time, q and v.
    rows : int
        Count of constraints.
    parameter_names : tuple of str
        In the order of the values.
    is_driven, varies : bool
        Whether drivers determine the whole motion; whether numbers of the scene depend on
        parameters.
    """

    name: str
    features: tuple[str, ...]
    sizes: str
    places: str
    state: tuple[Field, ...]
    kernels: tuple[KernelText, ...]
    segments: tuple[SegmentText, ...]
    tables: Mapping[str, str]
    length: str
    closure_tolerance: str
    mass: str
    parts: tuple[str, ...]
    rows: int
    parameter_names: tuple[str, ...]
    is_driven: bool
    varies: bool

    @property
    def looks_at_rank(self) -> bool:
        """Whether the rank of rows is looked at where parameters are given."""
        return "HAS_RANK" in self.features

    @property
    def settings(self) -> tuple[tuple[str, list[str]], ...]:
        """Types and names of the fields of the settings of a run."""
        return _fields(Settings)

    @property
    def verdict(self) -> tuple[tuple[str, list[str]], ...]:
        """Types and names of the fields of the verdict on a run."""
        return _fields(RunVerdict)

    @property
    def doubts(self) -> tuple[Doubt, ...]:
        """Doubts that may speak against a run."""
        return tuple(Doubt)

    @property
    def statuses(self) -> tuple[Status, ...]:
        """Statuses that a call returns."""
        return tuple(Status)

    @property
    def methods(self) -> tuple[str, ...]:
        """The methods, in order."""
        return (*(method.name for method in METHODS), *[KINEMATICS] * self.is_driven)

    @property
    def meanings(self) -> Mapping[str, str]:
        """Meanings of the regions."""
        return REGIONS


def _fields(record: type) -> tuple[tuple[str, list[str]], ...]:
    """Fields of a record as C declares them: types, and names of neighbours."""
    types, known = {float: "double", int: "int"}, get_type_hints(record)
    return tuple((types[kind], list(names)) for kind, names in groupby(known, known.__getitem__))


def kernel_text(number: int, kernel: Kernel, *, repeats: bool) -> KernelText:
    """Kernel that tasks call as C."""
    quantities = (*kernel.inputs, *kernel.outputs)
    leaves = {(q.name, k): f"{q.name}[{k}]" for q in kernel.inputs for k in range(q.size)}
    elements = [[f"{q.name}[{k}]" for k in range(q.size)] for q in kernel.outputs]
    statements, results = _body(kernel, leaves, ["w", "s", *(q.name for q in quantities)], elements)
    types = (*["const double"] * len(kernel.inputs), *["double"] * len(kernel.outputs))
    written = " ".join(text for _, text in (*statements, *results))
    return KernelText(
        name=f"kernel_{number}",
        title=kernel.title,
        operations=kernel.operations.total(),
        pointers=_pointers(
            (kind, f"*restrict {q.name} = w + s[{k}]")
            for k, (kind, q) in enumerate(zip(types, quantities, strict=True))
            if k >= len(kernel.inputs) or f"{q.name}[" in written
        ),
        statements=statements,
        results=results,
        slots=len(quantities),
        repeats=repeats,
    )


def function_text(kernel: Kernel, task: Task, slots: Slots, name: str, title: str) -> KernelText:
    """Kernel of the whole workspace as C, with slots by the names of their regions.

    Raises
    ------
    EmitError
        It reads a slot that it writes: results are written one after the other.
    """
    read = {node.symbol[1] for node in kernel.nodes if node.symbol is not None}
    runs = zip(task.outputs, kernel.outputs, strict=True)
    targets = [[base + k for k in range(run.size)] for base, run in runs]
    written = {slot for run in targets for slot in run}
    if read & written:
        raise EmitError(f"{name}: the slots {sorted(read & written)} are read and written")
    leaves = {("x0", slot): slots.text(slot) for slot in read}
    regions = {slots.name(slot)[0]: "const double" for slot in sorted(read | written)}
    regions |= {slots.name(slot)[0]: "double" for slot in written}
    elements = [[slots.text(slot) for slot in run] for run in targets]
    statements, results = _body(kernel, leaves, ["w", *regions], elements)
    return KernelText(
        name=name,
        title=title,
        operations=kernel.operations.total(),
        pointers=_pointers(
            (kind, f"*{region} = w + W_{region.upper()}")
            for kind in ("const double", "double")
            for region, pointer_kind in regions.items()
            if pointer_kind == kind
        ),
        statements=statements,
        results=results,
        slots=0,
        repeats=False,
    )


def _pointers(pointers: Iterable[tuple[str, str]]) -> tuple[str, ...]:
    """Declarations of pointers, those of one type together in lines."""
    return tuple(
        f"{kind} {line.rstrip(',')};"
        for kind, same_kind in groupby(pointers, key=itemgetter(0))
        for line in in_lines((f"{text}," for _, text in same_kind), TABLE_WIDTH - 14).splitlines()
    )


def _body(
    kernel: Kernel,
    leaves: Mapping[tuple[str, int], str],
    names: Sequence[str],
    elements: Sequence[Sequence[str]],
) -> tuple[tuple[tuple[str, str], ...], tuple[tuple[str, str], ...]]:
    """Statements and results of a kernel.

    Parameters
    ----------
    kernel : Kernel
        The kernel.
    leaves : mapping of (str, int) to str
        The text of each element of an input.
    names : sequence of str
        Names that are taken.
    elements : sequence of sequence of str
        For each output the targets of its elements.
    """
    namer = Namer()
    for name in names:
        namer.keep(name)
    plan = layout(kernel, tuple(range(len(kernel.outputs))), leaves)
    statements, texts = straight_line(plan, C, leaves, namer)
    results: list[tuple[str, str]] = []
    for k, targets in enumerate(elements):
        results += zip(targets, output_text(kernel, k, "", texts).elements, strict=True)
    return tuple((s.name, s.text) for s in statements), tuple(results)


def runs_of(tasks: Sequence[Task]) -> Iterator[tuple[int, list[Task]]]:
    """Runs of tasks that follow each other and call one kernel."""
    for kernel, run in groupby(tasks, key=lambda task: task.kernel):
        yield kernel, list(run)


def task_rows(tasks: Sequence[Task]) -> Iterator[tuple[str, str]]:
    """Tasks as numbers with their owners: a run of one kernel begins with it and a count."""
    for kernel, run in runs_of(tasks):
        yield "", f"{kernel}, {len(run)},"
        for task in run:
            yield task.owner, " ".join(f"{slot}," for slot in (*task.inputs, *task.outputs))


def solver_context(
    program: Program, system: System, length: float, parts: Sequence[str]
) -> SolverContext:
    """Context of the templates of a solver.

    Parameters
    ----------
    program : Program
        Task lists, or the program that inlining made of them.
    system : System
        System that it was composed of.
    length : float [m]
        A length of the scene, to which corrections are compared.
    parts : sequence of str
        Regions that a row has beyond time, q and v.
    """
    segments, slots = (*program.segments, *program.on_demand), slots_of(program)
    solver_tables = tables(program, system, length, parts)
    counted = (
        "shifts",
        "orientations",
        "drivers",
        "starts",
        "positive",
        "parts",
        "events",
        "rank_rows",
    )
    counts = layout_sizes(program) | {name.upper(): len(solver_tables[name]) for name in counted}
    shown = len(system.shown) if "coordinates" in parts else 0
    counts |= {"N_SHOWN": shown, "PER_SHOWN": 3 if "v_dot" in parts else 2}
    row = 1 + sum(program.region(name).size for name in ("q", "v", *parts))
    bases = {region.name: region.base for region in program.regions}
    places = {f"W_{name.upper()}": base for name, base in bases.items()}
    places |= {f"W_{SCRATCH.upper()}": slots.bases[-1], "W_SIZE": program.size}
    slot_names = (
        name for names in FEATURE_NUMBERS.values() for name in names if name.startswith("W_")
    )
    places |= {name: 0 for name in slot_names if name not in places}
    features = _features(program, system, parts)
    kernels = () if program.is_inlined else program.kernels
    texts = {name: _table(table, name in PAIRS) for name, table in solver_tables.items()}
    texts["constants"] = _initialiser(in_lines(f"{literal(x)}," for x in program.constants))
    repeated = {
        kernel for segment in segments for kernel, run in runs_of(segment.tasks) if len(run) > 1
    }
    state = {"NY": counts["NQ"] + counts["NV"], "DENSE": DENSE, **counts}
    state["RANGED"] = counts["NQ"] + shown
    return SolverContext(
        name=program.name,
        features=features,
        sizes=enumerators(_with_features(counts, features) | {"ROW_SIZE": row}),
        places=enumerators(_with_features(places, features)),
        state=fields(state),
        kernels=tuple(
            kernel_text(k, kernel, repeats=k in repeated) for k, kernel in enumerate(kernels)
        ),
        segments=tuple(segment_text(program, segment, slots) for segment in segments),
        tables={name: text for name, text in texts.items() if text},
        length=repr(length),
        closure_tolerance=repr(system.closure_tolerance),
        mass=repr(total_mass(system)),
        parts=tuple(parts),
        rows=len(program.rows),
        parameter_names=tuple(name for name, _ in system.parameters),
        is_driven=is_driven(program, system),
        varies=bool(program.design),
    )


def total_mass(system: System) -> float:
    """Mass of all bodies, 1 where the scene gives none [kg]."""
    return sum(float(body.mass) for body in system.bodies) or 1.0


def _features(program: Program, system: System, parts: Sequence[str]) -> tuple[str, ...]:
    """Features that the scene has, and others may lack."""
    regions = {region.name for region in program.regions}
    segments = {segment.name for segment in (*program.segments, *program.on_demand)}
    features = {
        "HAS_ROWS": "position" in segments,
        "HAS_JOINT_COORDINATES": bool(program.satisfied),
        "HAS_DRIVERS": has_drivers(system),
        "IS_DRIVEN": is_driven(program, system),
        "HAS_PARAMETERS": bool(system.parameters),
        "HAS_CONSTANTS": bool(program.constants),
        "HAS_DESIGN": bool(program.design),
        "HAS_UNWRAPPED_ANGLES": bool(unwrapped_angles(program)),
        "HAS_WORKS": works(program) > 0,
        "HAS_MOMENTA": "momentum" in segments,
        "HAS_MISSES": program.has_misses,
        "HAS_ROW_SWITCH": has_row_switch(program),
        "HAS_RANK": bool(rank_rows(program, system)),
        "HAS_VARYING_MASSES": has_row_switch(program) and bool(mass_places(program, system)),
        "HAS_REFINEMENT": "refinement" in segments,
        "HAS_REACTIONS": "reactions" in regions,
        "SHARES_OUT": program.shares_out,
        "HAS_WRENCHES": "wrench" in segments,
        "HAS_ENERGIES": "energies" in parts,
        "HAS_COORDINATES": "coordinate" in segments,
        "ACCELERATES": not {"v_dot", "coordinates", "reactions"}.isdisjoint(parts),
        "HAS_SWITCHING": "switching" in segments,
        "HAS_GAPS": "gaps" in regions,
        "HAS_BENDING": "bending" in segments,
        "HAS_MEASURE": "measure" in segments,
        "HAS_DISTANCE": "distance" in segments,
        "HAS_CROSSING": "crossing" in segments,
        "HAS_BREAKS": "breaks" in regions,
        "HAS_FRACTIONAL_POWERS": root_functions_of(system).has_fractional_powers,
    }
    return tuple(name for name, is_present in features.items() if is_present)


def _with_features(numbers: Mapping[str, int], features: Collection[str]) -> dict[str, int]:
    """Counts, or first slots, without those of features that the scene lacks."""
    absent = {
        name
        for needed, names in FEATURE_NUMBERS.items()
        if not set(needed) <= set(features)
        for name in names
    }
    return {name: value for name, value in numbers.items() if name not in absent}


def segment_text(program: Program, segment: Segment, slots: Slots) -> SegmentText:
    """Segment as C."""
    name, tasks = segment.name, segment.tasks
    meaning = meaning_of(program, segment)
    if not program.is_inlined:
        rows = list(task_rows(tasks))
        length = sum(text.count(",") for _, text in rows)
        return SegmentText(name, meaning, (), (), _rows(rows), length)
    functions = [
        function_text(
            program.kernels[task.kernel],
            task,
            slots,
            name if len(tasks) == 1 else f"{name}_{k}",
            meaning if len(tasks) == 1 else f"part {k + 1} of {len(tasks)}",
        )
        for k, task in enumerate(tasks)
    ]
    return SegmentText(name, meaning, contents_of(segment), tuple(functions), "", 0)


def contents_of(segment: Segment) -> tuple[str, ...]:
    """Contents of a segment that was inlined, in lines."""
    return tuple(wrap("; ".join(segment.contents), TABLE_WIDTH, break_on_hyphens=False))


def method_text(method: RungeKuttaMethod) -> MethodText:
    """Method as C arrays."""
    flat = {
        "c": method.c,
        "a": [x for row in method.a for x in row],
        "error": method.errors[0],
        "dense": [x for row in method.dense for x in row],
    }
    if len(method.errors) > 1:
        flat["error_2"] = method.errors[1]
    if method.works:
        flat["works"] = [x for row in method.works for x in row]
    return MethodText(
        name=method.name,
        order=method.order,
        stages=method.stages,
        all=method.all,
        dense_rows=len(method.dense),
        work_rows=len(method.works),
        work_scale=method.work_scale,
        arrays=tuple((name, in_lines(f"{x!r}," for x in row)) for name, row in flat.items()),
        has_second_error=len(method.errors) > 1,
    )


def enumerators(values: Mapping[str, int]) -> str:
    """Enumerators of C, in lines."""
    return in_lines((f"{name} = {value}," for name, value in values.items()), TABLE_WIDTH)


def _table(table: Table, has_rows: bool) -> str:
    """Initialiser of a table: neighbours with one owner share a line, which names it."""
    texts = (
        (owner, f"{{{', '.join(map(str, x))}}}," if has_rows else f"{x!r},") for owner, x in table
    )
    return _initialiser(_rows(texts))


def _initialiser(lines: str) -> str:
    """Initialiser of an array, nothing of one that has no elements."""
    if not lines:
        return ""
    if "\n" in lines or len(lines) > LONGEST_INLINE_TABLE:
        return "{\n    " + lines.replace("\n", "\n    ") + "\n}"
    return f"{{ {lines} }}"


def _rows(rows: Iterable[tuple[str, str]]) -> str:
    """Rows in lines: neighbours with one owner share a line, which names it."""
    lines = []
    for owner, run in groupby(rows, key=lambda row: row[0]):
        text = in_lines((text for _, text in run), TABLE_WIDTH - 12)
        lines.append(f"{text} /* {owner} */" if owner else text)
    return "\n".join(lines)


def in_lines(items: Iterable[str], width: int = 96) -> str:
    """Items in lines that are no longer than ``width``, and hold one of them at least."""
    lines: list[str] = []
    line: list[str] = []
    length = -1
    for item in items:
        length += 1 + len(item)
        if length > width and line:
            lines.append(" ".join(line))
            line, length = [], len(item)
        line.append(item)
    return "\n".join([*lines, " ".join(line)])
