"""From a program to the context of the template of its solver in Python.

The tasks of a segment stand level by level: tasks of one level do not need each other, so that
those of one kernel can run together, on arrays whose last axis is the task.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from itertools import groupby
from operator import itemgetter
from typing import TYPE_CHECKING

from kousoku.codegen.context_body import layout, live_nodes, output_text, straight_line
from kousoku.codegen.context_names import Namer
from kousoku.codegen.dynamics.emission.context import (
    contents_of,
    in_lines,
    total_mass,
)
from kousoku.codegen.dynamics.emission.context_numbers import (
    Table,
    added,
    has_drivers,
    has_row_switch,
    tables,
    unwrapped_angles,
    works,
)
from kousoku.codegen.dynamics.emission.slots import Slots, slots_of
from kousoku.codegen.dynamics.recording.program import levels, meaning_of
from kousoku.codegen.printers import NUMPY, Printer
from kousoku.model.lowering.root_functions import root_functions_of
from kousoku.model.operations.graph import Op, literal
from kousoku.runtime.integrate.scene_tables import SceneTables

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from kousoku.codegen.dynamics.recording.program import Program, Segment
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.operations.kernel import Kernel

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
    """Kernel as a function from a list of values to a list of values.

    Parameters
    ----------
    name : str
        ``kernel_3``, or the name of the segment that it is, or is a part of.
    title : str
        Title of its results.
    operations : int
        Scalar operations of one task.
    inputs : tuple of str
        The names of the values that it reads.
    statements : tuple of (str, str)
        Name and text of each intermediate value.
    results : tuple of str
        The texts of the values that it writes, each with its target.
    runs : int
        Count of the runs of slots that a task lists.
    reads, writes : str
        Run, and index in the run, of each value that it reads and writes.
    """

    name: str
    title: str
    operations: int
    inputs: tuple[str, ...]
    statements: tuple[tuple[str, str], ...]
    results: tuple[str, ...]
    runs: int
    reads: str
    writes: str


@dataclass(frozen=True, slots=True)
class PythonSegment:
    """Tasks of a segment, level by level: kernel, count, then the slots of each task.

    Parameters
    ----------
    name, meaning : str
        Its name, and what it reads and writes.
    contents : tuple of str
        Contents that were inlined into it, in lines.
    table : str
        The numbers, in lines that end with the owner of a task.
    """

    name: str
    meaning: str
    contents: tuple[str, ...]
    table: str


@dataclass(frozen=True, slots=True)
class NumpyContext:
    """Context of the templates of the solver in Python.

    Parameters
    ----------
    name : str
        Name of the scene.
    numbers : tuple of (str, str)
        Short fields of the scene's record whose values are not the defaults: name and text.
    regions : tuple of (str, int, int)
        Name, first slot and size of those that are not empty.
    kernels, segments : tuple
        In order.
    tables : mapping of str to str
        Tables that have rows, in lines that end with the owners of their rows.
    """

    name: str
    numbers: tuple[tuple[str, str], ...]
    regions: tuple[tuple[str, int, int], ...]
    kernels: tuple[PythonKernel, ...]
    segments: tuple[PythonSegment, ...]
    tables: Mapping[str, str]


def numpy_context(
    program: Program, system: System, length: float, parts: Sequence[str] = ()
) -> NumpyContext:
    """Context of the template of the solver in Python.

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
    counted = unwrapped_angles(program)
    numbers = {
        "length": length,
        "closure_tolerance": system.closure_tolerance,
        "mass": total_mass(system),
        "work_size": program.size,
        "parts": tuple(parts),
        "added": added(program),
        "works": works(program),
        "unwrapped_angles": (counted.start, counted.stop),
        "has_joint_coordinates": bool(program.satisfied),
        "has_drivers": has_drivers(system),
        "has_misses": program.has_misses,
        "has_row_switch": has_row_switch(program),
        "has_fractional_powers": root_functions_of(system).has_fractional_powers,
    }
    lacking = {field.name: field.default for field in fields(SceneTables)}
    texts = {"constants": _numbers(map(literal, program.constants))} | {
        name: _table(table)
        for name, table in tables(program, system, length, parts).items()
        if name != "parts"
    }
    return NumpyContext(
        name=program.name,
        numbers=tuple(
            (name, repr(value).replace("'", '"'))  # as Python's formatters write it
            for name, value in numbers.items()
            if value != lacking[name]
        ),
        regions=regions_of(program),
        kernels=tuple(python_kernels(program)),
        segments=tuple(
            python_segment(program, segment) for segment in (*program.segments, *program.on_demand)
        ),
        tables={name: text for name, text in texts.items() if text},
    )


def regions_of(program: Program) -> tuple[tuple[str, int, int], ...]:
    """Name, first slot and size of the regions that are not empty."""
    return tuple(
        (region.name, region.base, region.size) for region in program.regions if region.size
    )


def python_kernels(program: Program) -> Iterator[PythonKernel]:
    """Kernels by number; those of the whole workspace name slots by their regions."""
    if not program.is_inlined:
        for k, kernel in enumerate(program.kernels):
            yield python_kernel(f"kernel_{k}", kernel)
        return
    slots = slots_of(program)
    outputs = {
        task.kernel: task.outputs
        for segment in (*program.segments, *program.on_demand)
        for task in segment.tasks
    }
    for k, kernel in enumerate(program.kernels):
        yield python_kernel(kernel.name, kernel, slots, outputs[k])


def python_kernel(
    name: str, kernel: Kernel, slots: Slots | None = None, targets: Sequence[int] = ()
) -> PythonKernel:
    """Kernel as a function in Python: it unpacks only the inputs that it reads.

    Parameters
    ----------
    name : str
        Name of the function.
    kernel : Kernel
        The kernel.
    slots : Slots, optional
        The regions of the workspace, of a kernel that takes all of it.
    targets : sequence of int
        First slot of each output of such a kernel.
    """
    outputs = tuple(range(len(kernel.outputs)))
    runs = {quantity.name: k for k, quantity in enumerate(kernel.inputs)}
    symbols = (kernel.nodes[node].symbol for node in live_nodes(kernel, outputs))
    read = sorted((runs[symbol[0]], symbol[1], symbol) for symbol in symbols if symbol)
    leaves = {
        symbol: "{}_{}".format(*slots.name(index)) if slots else f"x{run}_{index}"
        for run, index, symbol in read
    }
    namer = Namer()
    for taken in ("m", "x", *leaves.values()):
        namer.keep(taken)
    # line by line as in C
    in_c = {x: slots.text(x[1]) if slots else f"{x[0]}[{x[1]}]" for x in leaves}
    plan = layout(kernel, outputs, in_c)
    statements, texts = straight_line(plan, PYTHON, leaves, namer)
    results: list[str] = []
    for k, quantity in enumerate(kernel.outputs):
        elements = output_text(kernel, k, "", texts).elements
        destinations = [
            slots.text(targets[k] + n) if slots else f"{quantity.name}[{n}]"
            for n in range(len(elements))
        ]
        results += map(_with_target, elements, destinations)
    return PythonKernel(
        name=name,
        title=kernel.title,
        operations=kernel.operations.total(),
        inputs=tuple(leaves.values()),
        statements=tuple((s.name, s.text) for s in statements),
        results=tuple(results),
        runs=len(kernel.inputs) + len(kernel.outputs),
        reads=_numbers(x for run, index, _ in read for x in (run, index)),
        writes=_numbers(
            x
            for run, quantity in enumerate(kernel.outputs, len(kernel.inputs))
            for index in range(quantity.size)
            for x in (run, index)
        ),
    )


def _with_target(text: str, target: str) -> str:
    """Item of a list, with its target as a comment if that fits into a line."""
    line = f"{text},  # {target}"
    return line if len(line) <= 92 else f"{text},"


def python_segment(program: Program, segment: Segment) -> PythonSegment:
    """Tasks of a segment as a table in text."""
    lines: list[str] = []
    for level in levels(program, segment):
        by_kernel: dict[int, list[int]] = {}
        for index in level:
            by_kernel.setdefault(segment.tasks[index].kernel, []).append(index)
        for kernel, indices in by_kernel.items():
            lines.append(f"{kernel} {len(indices)}")
            for index in indices:
                task = segment.tasks[index]
                slots = _numbers((*task.inputs, *task.outputs))
                fits = len(slots) + len(task.owner) + 3 <= 100
                lines += [f"{slots} # {task.owner}"] if task.owner and fits else [slots]
    meaning = meaning_of(program, segment)
    return PythonSegment(segment.name, meaning, contents_of(segment), "\n".join(lines))


def _table(table: Table) -> str:
    """Table in lines, each with the name of its owner: rows of one number share a line."""
    lines = []
    for owner, run in groupby(table, key=itemgetter(0)):
        rows = [row for _, row in run]
        if isinstance(rows[0], tuple):
            lines += [f"{' '.join(map(str, row))} # {owner}" for row in rows]
        else:
            lines.append(f"{in_lines(map(repr, rows), 80)} # {owner}")
    return "\n".join(lines)


def _numbers(items: Iterable[object]) -> str:
    """Numbers in lines, with blanks between them."""
    return in_lines(map(str, items), 96)
