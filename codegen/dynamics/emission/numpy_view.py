"""From a program to what the template of its solver in Python fills in.

The tasks of a segment stand level by level: tasks of one level do not need each other, so that
those of one kernel can run together, on arrays whose last axis is the task.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.emission.runge_kutta import METHODS, Method
from kousoku.codegen.dynamics.emission.view import in_lines
from kousoku.codegen.dynamics.emission.view_numbers import (
    floors,
    positive_places,
    shift_slots,
    start_places,
    turn_slots,
)
from kousoku.codegen.dynamics.recording.program import ON_DEMAND, SEGMENTS, levels
from kousoku.codegen.graph import Op, literal
from kousoku.codegen.printers import NUMPY, Printer
from kousoku.codegen.view_body import layout, live_nodes, output_text, straight_line
from kousoku.codegen.view_names import Namer

if TYPE_CHECKING:
    from collections.abc import Iterable

    from kousoku.codegen.dynamics.recording.program import Program, Segment
    from kousoku.codegen.kernel import Kernel

#: A kernel gets the functions of floats or those of arrays, as its argument ``m``.
PYTHON = Printer(
    NUMPY.operators,
    {
        Op.SQRT: "m.sqrt",
        Op.SIN: "m.sin",
        Op.COS: "m.cos",
        Op.ATAN2: "m.atan2",
        Op.EXP: "m.exp",
        Op.LOG: "m.log",
        Op.ABS: "m.fabs",
        Op.MAX: "m.fmax",
    },
)


@dataclass(frozen=True, slots=True)
class PythonKernel:
    """A kernel as a function from a list of values to a list of values.

    Parameters
    ----------
    name : str
        ``kernel_3``.
    operations : int
        What one task costs.
    inputs : tuple of str
        The names of the values that it reads.
    statements : tuple of (str, str)
        Name and text of each intermediate value.
    results : tuple of str
        The texts of the values that it writes.
    runs : int
        How many runs of slots a task lists.
    reads, writes : str
        Run, and place in it, of each value that it reads and writes.
    """

    name: str
    operations: int
    inputs: tuple[str, ...]
    statements: tuple[tuple[str, str], ...]
    results: tuple[str, ...]
    runs: int
    reads: str
    writes: str


@dataclass(frozen=True, slots=True)
class PythonSegment:
    """The tasks of a segment, level by level: kernel, count, then the slots of each task.

    Parameters
    ----------
    name, meaning : str
        As in ``SEGMENTS``.
    table : str
        The numbers, in lines.
    is_on_demand : bool
        Whether evaluations leave it out.
    """

    name: str
    meaning: str
    table: str
    is_on_demand: bool


@dataclass(frozen=True, slots=True)
class PythonMethod:
    """A Runge-Kutta method as tables of numbers; ``a`` and ``dense`` row after row."""

    name: str
    order: int
    stages: int
    all: int
    dense_rows: int
    c: str
    a: str
    error: str
    error_2: str
    dense: str


@dataclass(frozen=True, slots=True)
class NumpyView:
    """What the text of the solver in Python is made of beside the ``DynamicsView``.

    Parameters
    ----------
    kernels, segments, methods : tuple
        In order.
    constants, is_length, floors, shifts, turns, starts, positive : str
        Tables of numbers, in lines, as in the ``DynamicsView``.
    """

    kernels: tuple[PythonKernel, ...]
    segments: tuple[PythonSegment, ...]
    methods: tuple[PythonMethod, ...]
    constants: str
    is_length: str
    floors: str
    shifts: str
    turns: str
    starts: str
    positive: str


def numpy_view(program: Program, length: float) -> NumpyView:
    """Return what the template gets.

    Parameters
    ----------
    program : Program
        Task lists, or what inlining made of them.
    length : float [m]
        A length of the scene, to which corrections are compared.
    """
    q, v = program.region("q"), program.region("v")
    shifts, turns = shift_slots(program), turn_slots(program)
    lengths = {slot for pair in shifts for slot in pair}
    return NumpyView(
        kernels=tuple(python_kernel(k, kernel) for k, kernel in enumerate(program.kernels)),
        segments=tuple(
            _segment(program, segment) for segment in (*program.segments, *program.on_demand)
        ),
        methods=tuple(map(_method, METHODS.values())),
        constants=_table(map(literal, program.constants)),
        is_length=_table(int(v.base + k in lengths) for k in range(v.size)),
        floors=_table(map(repr, floors(program, length))),
        shifts=_table(x for a, b in shifts for x in (a - q.base, b - v.base)),
        turns=_table(x for a, b, n in turns for x in (a - q.base, b - v.base, n)),
        starts=_table(x for pair in start_places(program) for x in pair),
        positive=_table(positive_places(program)),
    )


def python_kernel(number: int, kernel: Kernel) -> PythonKernel:
    """Return a kernel as a function in Python: it unpacks only what it reads."""
    outputs = tuple(range(len(kernel.outputs)))
    runs = {quantity.name: k for k, quantity in enumerate(kernel.inputs)}
    symbols = (kernel.nodes[node].symbol for node in live_nodes(kernel, outputs))
    read = sorted((runs[symbol[0]], symbol[1], symbol) for symbol in symbols if symbol)
    leaves = {symbol: f"x{run}_{place}" for run, place, symbol in read}
    namer = Namer()
    for name in ("m", "x", *leaves.values()):
        namer.keep(name)
    plan = layout(kernel, outputs, leaves)
    statements, texts = straight_line(plan, PYTHON, leaves, namer)
    results = (output_text(kernel, k, "", texts).elements for k in outputs)
    return PythonKernel(
        name=f"kernel_{number}",
        operations=kernel.operations.total(),
        inputs=tuple(leaves.values()),
        statements=tuple((s.name, s.text) for s in statements),
        results=tuple(text for elements in results for text in elements),
        runs=len(kernel.inputs) + len(kernel.outputs),
        reads=_table(x for run, place, _ in read for x in (run, place)),
        writes=_table(
            x
            for run, quantity in enumerate(kernel.outputs, len(kernel.inputs))
            for place in range(quantity.size)
            for x in (run, place)
        ),
    )


def _segment(program: Program, segment: Segment) -> PythonSegment:
    numbers: list[int] = []
    for level in levels(program, segment):
        equal: dict[int, list[int]] = {}
        for place in level:
            equal.setdefault(segment.tasks[place].kernel, []).append(place)
        for kernel, places in equal.items():
            numbers += [kernel, len(places)]
            for place in places:
                numbers += [*segment.tasks[place].inputs, *segment.tasks[place].outputs]
    name = segment.name
    meaning = (SEGMENTS | ON_DEMAND)[name]
    return PythonSegment(name, meaning, _table(numbers), name in ON_DEMAND)


def _method(method: Method) -> PythonMethod:
    return PythonMethod(
        name=method.name,
        order=method.order,
        stages=method.stages,
        all=len(method.a),
        dense_rows=len(method.dense),
        c=_table(map(repr, method.c)),
        a="\n".join(_table(map(repr, row)) for row in method.a if row),
        error=_table(map(repr, method.errors[0])),
        error_2=_table(repr(x) for row in method.errors[1:] for x in row),
        dense="\n".join(_table(map(repr, row)) for row in method.dense),
    )


def _table(items: Iterable[object]) -> str:
    """Return numbers in lines, with blanks between them."""
    return in_lines(map(str, items), 100)
