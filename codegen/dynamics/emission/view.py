"""From a program to what the templates of its solver fill in."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.emission.runge_kutta import METHODS, Method
from kousoku.codegen.dynamics.emission.view_numbers import (
    driver_places,
    floors,
    has_drivers,
    has_fallback,
    is_driven,
    positive_places,
    shift_slots,
    sizes,
    slots,
    start_places,
    turn_slots,
    weight_places,
    weights,
)
from kousoku.codegen.dynamics.recording.program import ON_DEMAND, REGIONS, SEGMENTS
from kousoku.codegen.graph import literal
from kousoku.codegen.printers import C
from kousoku.codegen.view_body import layout, output_text, straight_line
from kousoku.codegen.view_names import Namer

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from kousoku.codegen.dynamics.recording.program import Program, Segment, Task
    from kousoku.codegen.kernel import Kernel
    from kousoku.model.mechanism import System


#: Kernels that one function runs, and how many there are in a group where they are more.
MOST_CASES, GROUP = 128, 64


@dataclass(frozen=True, slots=True)
class KernelText:
    """A kernel as a C function of runs of slots.

    Parameters
    ----------
    name : str
        ``kernel_3``.
    parameters : str
        ``const double *restrict x0, …, double *restrict y0, …``.
    operations : int
        What one call costs.
    statements : tuple of (str, str)
        Name and text of each intermediate value.
    results : tuple of (str, str)
        Element of an output, and its text.
    call : str
        The arguments, taken from the slots ``s`` of a task on the workspace ``w``.
    slots : int
        How many slots a task of it lists.
    unused : tuple of str
        Parameters that the text does not name.
    """

    name: str
    parameters: str
    operations: int
    statements: tuple[tuple[str, str], ...]
    results: tuple[tuple[str, str], ...]
    call: str
    slots: int
    unused: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SegmentText:
    """The tasks of a segment as a table: kernel, count, then the slots of each task.

    Parameters
    ----------
    name, meaning : str
        As in ``SEGMENTS``.
    table : str
        The numbers, in lines.
    length : int
        Count of numbers.
    is_on_demand : bool
        Whether evaluations leave it out.
    """

    name: str
    meaning: str
    table: str
    length: int
    is_on_demand: bool


@dataclass(frozen=True, slots=True)
class MethodText:
    """A Runge-Kutta method as C arrays."""

    name: str
    order: int
    stages: int
    all: int
    dense_rows: int
    arrays: tuple[tuple[str, str], ...]
    has_second_error: bool


@dataclass(frozen=True, slots=True)
class DynamicsView:
    """All that the solver's text is made of.

    Parameters
    ----------
    name : str
        The scene; names begin with ``kousoku_<name>``.
    sizes : tuple of (str, int)
        Constants of the text: ``NQ``, ``W_Q`` ….
    kernels, segments, methods : tuple
        In order.
    constants : str
        The numbers of the scene, in lines.
    is_length : str
        For each velocity 1 where it moves, 0 where it turns.
    floors : str
        For each component of the state what its error is compared with when it is zero.
    shifts, turns : str
        Rows of indices: of a length in q and v; of Euler parameters in q, their turn in v, their
        count.
    shift_count, turn_count : int
        How many rows.
    length : str
        A length of the scene [m].
    energy : str
        Of all bodies where they move by that length in a second [J].
    parts : tuple of str
        Regions that a row has beyond time, q and v.
    rows : int
        Count of constraints.
    parameters : str
        Values of the parameters unless a run is given others, in lines.
    parameter_names : tuple of str
        Their names, in this order.
    has_drivers, is_driven : bool
        Whether there are drivers, and whether they determine the whole motion.
    refines : bool
        Whether there are loops, in which rows may become dependent.
    has_fallback : bool
        Whether rows that are left out take over where those that are kept lose rank.
    weights : str
        The diagonal of M⁻¹, in lines.
    weighs : str
        Where they are in the design, -1 where they are fixed; empty where all are.
    drivers : str
        Rows of indices: of each row of a driver, and of its work in q.
    driver_count : int
        How many rows.
    varies : bool
        Whether numbers of the scene depend on parameters.
    starts : str
        Rows of indices: in (q, v) of what depends on parameters at the start, and in the design.
    positive : str
        Indices in the design of numbers that must be positive.
    start_count, positive_count : int
        How many.
    """

    name: str
    sizes: tuple[tuple[str, int], ...]
    kernels: tuple[KernelText, ...]
    segments: tuple[SegmentText, ...]
    methods: tuple[MethodText, ...]
    constants: str
    is_length: str
    floors: str
    shifts: str
    turns: str
    shift_count: int
    turn_count: int
    length: str
    energy: str
    parts: tuple[str, ...]
    rows: int
    parameters: str
    parameter_names: tuple[str, ...]
    has_drivers: bool
    is_driven: bool
    refines: bool
    has_fallback: bool
    weights: str
    weighs: str
    drivers: str
    driver_count: int
    varies: bool
    starts: str
    start_count: int
    positive: str
    positive_count: int

    @property
    def accelerates(self) -> bool:
        """Whether a row takes what geometry and accelerations leave."""
        return any(part in self.parts for part in ("v_dot", "coordinates", "reactions"))

    @property
    def momenta(self) -> bool:
        """Whether some momentum should not change."""
        return dict(self.sizes)["MOMENTA"] > 0

    @property
    def fits(self) -> bool:
        """Whether bodies are put onto joints with the ground."""
        return dict(self.sizes)["FITS"] > 0

    @property
    def leads(self) -> bool:
        """Whether parameters may change where bodies or drivers begin."""
        return self.varies or (self.has_drivers and bool(self.parameter_names))

    @property
    def numbered(self) -> tuple[tuple[int, KernelText], ...]:
        """The kernels, each with its number."""
        return tuple(enumerate(self.kernels))

    @property
    def groups(self) -> tuple[tuple[tuple[int, KernelText], ...], ...]:
        """The kernels in groups, none where they are few: each group is a function of its own.

        A compiler takes a time for a function that grows with the square of its cases.
        """
        if len(self.kernels) <= MOST_CASES:
            return ()
        starts = range(0, len(self.kernels), GROUP)
        return tuple(self.numbered[start : start + GROUP] for start in starts)

    @property
    def meanings(self) -> Mapping[str, str]:
        """What the regions hold."""
        return REGIONS


def kernel_text(number: int, kernel: Kernel) -> KernelText:
    """Return a kernel as C."""
    names = [quantity.name for quantity in (*kernel.inputs, *kernel.outputs)]
    leaves = {(q.name, k): f"{q.name}[{k}]" for q in kernel.inputs for k in range(q.size)}
    namer = Namer()
    for name in names:
        namer.keep(name)
    plan = layout(kernel, tuple(range(len(kernel.outputs))), leaves)
    statements, texts = straight_line(plan, C, leaves, namer)
    results = []
    for k, quantity in enumerate(kernel.outputs):
        elements = output_text(kernel, k, quantity.name, texts).elements
        results += [(f"{quantity.name}[{n}]", text) for n, text in enumerate(elements)]
    reads = [f"const double *restrict {quantity.name}" for quantity in kernel.inputs]
    writes = [f"double *restrict {quantity.name}" for quantity in kernel.outputs]
    written = " ".join([*(s.text for s in statements), *(text for _, text in results)])
    return KernelText(
        name=f"kernel_{number}",
        parameters=in_lines(f"{item}," for item in reads + writes).rstrip(","),
        operations=kernel.operations.total(),
        statements=tuple((s.name, s.text) for s in statements),
        results=tuple(results),
        call=in_lines((f"w + s[{k}]," for k in range(len(names))), 76).rstrip(","),
        slots=len(names),
        unused=tuple(q.name for q in kernel.inputs if f"{q.name}[" not in written),
    )


def task_table(tasks: Sequence[Task]) -> list[int]:
    """Return tasks as numbers: for each run of one kernel its number, the count, the slots."""
    numbers: list[int] = []
    for kernel, run in groupby(tasks, key=lambda task: task.kernel):
        same = list(run)
        numbers += [kernel, len(same)]
        for task in same:
            numbers += [*task.inputs, *task.outputs]
    return numbers


def dynamics_view(
    program: Program, system: System, length: float, parts: Sequence[str] = ()
) -> DynamicsView:
    """Return what the templates get.

    Parameters
    ----------
    program : Program
        Task lists, or what inlining made of them.
    system : System
        What it was composed of.
    length : float [m]
        A length of the scene, to which corrections are compared.
    parts : sequence of str
        Regions that a row has beyond time, q and v.
    """
    shifts, turns = shift_slots(program), turn_slots(program)
    lengths = {k for pair in shifts for k in pair}
    drivers = driver_places(program, system)
    weighs = weight_places(program, system) if has_fallback(program) else []
    starts, positive = start_places(program), positive_places(program)
    q, v = (slots(program, name) for name in ("q", "v"))
    return DynamicsView(
        name=program.name,
        sizes=tuple(sizes(program, parts)),
        kernels=tuple(kernel_text(k, kernel) for k, kernel in enumerate(program.kernels)),
        segments=tuple(map(_segment, (*program.segments, *program.on_demand))),
        methods=tuple(map(_method, METHODS.values())),
        constants=_numbers(literal(value) for value in program.constants),
        is_length=_numbers(int(slot in lengths) for slot in v),
        floors=_numbers(map(repr, floors(program, length))),
        shifts=_rows([a - q[0], b - v[0]] for a, b in shifts),
        turns=_rows([a - q[0], b - v[0], n] for a, b, n in turns),
        shift_count=len(shifts),
        turn_count=len(turns),
        length=repr(length),
        energy=repr(sum(float(body.mass) for body in system.bodies) * length**2 / 2 or 1.0),
        parts=tuple(parts),
        rows=len(program.rows),
        parameters=_numbers(repr(value) for _, value in system.parameters),
        parameter_names=tuple(name for name, _ in system.parameters),
        has_drivers=has_drivers(system),
        is_driven=is_driven(program, system),
        refines=any(segment.name == "refinement" for segment in program.on_demand),
        has_fallback=has_fallback(program),
        weights=_numbers(repr(float(x)) for x in weights(program, system)),
        weighs=_numbers(weighs) if weighs else "",
        drivers=_rows(drivers),
        driver_count=len(drivers),
        varies=bool(program.design),
        starts=_rows(starts),
        start_count=len(starts),
        positive=_numbers(positive),
        positive_count=len(positive),
    )


def _segment(segment: Segment) -> SegmentText:
    name, table = segment.name, task_table(segment.tasks)
    meaning = (SEGMENTS | ON_DEMAND)[name]
    return SegmentText(name, meaning, _numbers(table), len(table), name in ON_DEMAND)


def _method(method: Method) -> MethodText:
    flat = {
        "c": method.c,
        "a": [x for row in method.a for x in row],
        "error": method.errors[0],
        "dense": [x for row in method.dense for x in row],
    }
    if len(method.errors) > 1:
        flat["error_2"] = method.errors[1]
    return MethodText(
        name=method.name,
        order=method.order,
        stages=method.stages,
        all=len(method.a),
        dense_rows=len(method.dense),
        arrays=tuple((name, _numbers(map(repr, row))) for name, row in flat.items()),
        has_second_error=len(method.errors) > 1,
    )


def _numbers(items: Iterable[object]) -> str:
    return in_lines(f"{item}," for item in items) or "0,"


def _rows(rows: Iterable[Sequence[int]]) -> str:
    texts = [f"{{{', '.join(map(str, row))}}}," for row in rows]
    return in_lines(texts) or "{0},"


def in_lines(items: Iterable[str], width: int = 96) -> str:
    """Return items in lines that are no longer than ``width``, and hold one of them at least."""
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
