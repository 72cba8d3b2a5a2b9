"""The recorder: operations on blocks of slots become kernels and tasks.

An operation is traced once for each *pattern* of its blocks: which entries are 0 or ±1, which are
the same slot, and where a run of consecutive slots ends. All further calls with that pattern are
looked up, so that a thousand equal joints cost one trace.

An entry of a block is coded as one number: 0, 1 and −1 are themselves, s + 2 is what is in slot s,
and −(s + 2) is its negative. There are a thousand entries for each body: with an object for each
slot a chain of 500 bodies takes an eighth longer, half of it to collect garbage.
"""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Protocol

from kousoku.codegen.dynamics.recording.program import Region, Segment, Task
from kousoku.codegen.dynamics.recording.traces import Trace, traced_kernel
from kousoku.model.numbers import precise
from kousoku.model.numbers.digits import exact as exactly
from kousoku.model.numbers.traced import Traced
from kousoku.model.numbers.varying import is_varying

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from fractions import Fraction

    from kousoku.codegen.dynamics.recording.matrix import Matrix
    from kousoku.codegen.dynamics.recording.traces import Codes
    from kousoku.model.numbers.precise import High
    from kousoku.model.operations.kernel import Kernel

    #: For each block its entries, coded with leaves instead of slots, and its shape.
    OperandPattern = tuple[tuple[tuple[int, ...], int, int], ...]

#: Slots of constants are counted from here while the rest of the workspace grows.
CONSTANTS = 1 << 40
#: Slots of numbers that depend on parameters.
DESIGN = 1 << 41
#: How many traces are kept for the next program.
MOST_TRACES = 1024
#: The kernel of a call that computes nothing.
NO_KERNEL = -1


@dataclass(frozen=True, slots=True)
class SlotMatrix:
    """A matrix of entries of the workspace.

    Parameters
    ----------
    entries : tuple of int
        Coded as in :mod:`kousoku.codegen.dynamics.recording.recorder`, row by row.
    height, width : int
        Count of rows and columns.
    """

    entries: tuple[int, ...]
    height: int
    width: int

    @property
    def T(self) -> SlotMatrix:
        """The transpose."""
        entries = tuple(x for k in range(self.width) for x in self.entries[k :: self.width])
        return SlotMatrix(entries, self.width, self.height)

    def __neg__(self) -> SlotMatrix:
        entries = tuple(-x for x in self.entries)
        return SlotMatrix(entries, self.height, self.width)

    def part(self, start: int, count: int) -> SlotMatrix:
        """Column of some entries of a column, one after the other."""
        return SlotMatrix(self.entries[start : start + count], count, 1)


def column(entries: Sequence[int]) -> SlotMatrix:
    """Entries as one column."""
    return SlotMatrix(tuple(entries), len(entries), 1)


def zeros(height: int, width: int) -> SlotMatrix:
    """Matrix of structural zeros."""
    return SlotMatrix((0,) * (height * width), height, width)


def slot_of(entry: int) -> int:
    """Slot that an entry stands for: it is neither 0 nor ±1."""
    return entry - 2


def _slots(base: int, size: int) -> SlotMatrix:
    return column(range(base + 2, base + size + 2))


class Operation(Protocol):
    """Operation that can be traced: hashable, so that equal ones share their kernels."""

    @property
    def title(self) -> str:
        """Title of its results, in one line; kernels and counts are named after it."""

    def __hash__(self) -> int:
        """Hash that equal operations share."""

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Results in terms of the nodes of ``blocks``."""


@dataclass(frozen=True, slots=True)
class _CallLayout:
    """Layout of a call: its kernel, and how its results are made of slots."""

    kernel: int
    used: tuple[int, ...]
    fresh: int
    results: tuple[Codes, ...]


class Recorder:
    """A program while it grows."""

    def __init__(self) -> None:
        self.kernels: list[Kernel] = []
        self.segments: list[tuple[str, list[Task]]] = []
        self.regions: list[Region] = []
        self.constants: list[Fraction] = []
        self.design: dict[str, tuple[int, Traced]] = {}
        self._owner = ""
        self._size = 0
        self._pool: dict[tuple[Fraction, ...], int] = {}
        self._columns: dict[tuple[High, ...], SlotMatrix] = {}
        self._layouts: dict[object, _CallLayout] = {}
        self._kernel_ids: dict[object, int] = {}

    def region(self, name: str, size: int) -> SlotMatrix:
        """Set aside a named part of the workspace; return it as a column."""
        base = self._allocate(size)
        self.regions.append(Region(name, base, size))
        return _slots(base, size)

    def design_part(self, first: int, count: int) -> SlotMatrix:
        """Column of some of the numbers that depend on parameters, in their order."""
        return _slots(DESIGN + first, count)

    def known(self, name: str) -> SlotMatrix:
        """Region that was set aside."""
        base, size = next((x.base, x.size) for x in self.regions if x.name == name)
        return _slots(base, size)

    def begin(self, name: str) -> None:
        """Begin a segment; tasks are recorded into it from now on."""
        self.segments.append((name, []))

    @contextmanager
    def of(self, owner: str) -> Iterator[None]:
        """Name the body, joint, force or driver that the tasks recorded now belong to."""
        before, self._owner = self._owner, owner
        yield
        self._owner = before

    def constant(self, values: Sequence[High]) -> SlotMatrix:
        """Column of numbers; equal columns of numbers are stored once.

        Those that depend on parameters are in the region ``design``, each formula once.
        """
        key = tuple(values)
        if key not in self._columns:
            self._columns[key] = self._new_constant(key)
        return self._columns[key]

    def _new_constant(self, values: Sequence[High]) -> SlotMatrix:
        numbers = [precise.number(value) if is_varying(value) else value for value in values]
        exact = [x if isinstance(x, Traced) else exactly(x) for x in numbers]
        fixed = [x for x in exact if not isinstance(x, Traced)]
        stored = tuple(value for value in fixed if abs(value) not in {0, 1})
        if stored not in self._pool:
            self._pool[stored] = CONSTANTS + len(self.constants)
            self.constants.extend(stored)
        slot = self._pool[stored]
        entries = []
        for value in exact:
            if isinstance(value, Traced):
                index, _ = self.design.setdefault(value.expression.key, (len(self.design), value))
                entries.append(DESIGN + index + 2)
            elif abs(value) in {0, 1}:
                entries.append(int(value))
            else:
                entries.append(slot + 2)
                slot += 1
        return column(entries)

    def call(
        self, operation: Operation, *blocks: SlotMatrix, into: Sequence[SlotMatrix | None] = ()
    ) -> tuple[SlotMatrix, ...]:
        """Record a call of an operation.

        Parameters
        ----------
        operation : Operation
            Operation that is computed.
        *blocks : SlotMatrix
            Its operands.
        into : sequence of SlotMatrix or None
            For each result the consecutive slots where it must be written, or None where any
            place will do; results beyond the last go to any place.

        Returns
        -------
        tuple of SlotMatrix
            The results. Entries that are 0, ±1, or an entry of the input up to its sign have no
            slot of their own.
        """
        pattern, leaves, bases, lengths = pattern_of(blocks)
        pinned = tuple(block is not None for block in into)
        key = (operation, pattern, tuple(lengths), pinned)
        layout = self._layouts.get(key)
        if layout is None:
            layout = self._layouts[key] = self._layout_of(operation, pattern, lengths, pinned)
        base = self._allocate(layout.fresh)
        outputs = [base] if layout.fresh else []
        outputs += [
            slot_of(block.entries[0]) for block in into if block is not None and block.entries
        ]
        if outputs:
            inputs = tuple(bases[run] for run in layout.used)
            self.segments[-1][1].append(Task(layout.kernel, inputs, tuple(outputs), self._owner))
        results = [
            SlotMatrix(
                tuple(self._entry(kind, x, leaves, base) for kind, x in entries), height, width
            )
            for entries, height, width in layout.results
        ]
        for k, block in enumerate(into):
            if block is not None:
                results[k] = block
        return tuple(results)

    def finish(self) -> tuple[list[Segment], list[Region], int]:
        """Segments and regions with the constants behind all else, and the size."""
        regions, size = list(self.regions), self._size
        bases = {}
        for first, name, count in (
            (DESIGN, "design", len(self.design)),
            (CONSTANTS, "constants", len(self.constants)),
        ):
            bases[first] = size - first
            if count or first == CONSTANTS:
                regions.append(Region(name, size, count))
            size += count

        def moved(slots: tuple[int, ...]) -> tuple[int, ...]:
            return tuple(
                x + bases[DESIGN if x >= DESIGN else CONSTANTS] if x >= CONSTANTS else x
                for x in slots
            )

        segments = [
            Segment(
                name,
                tuple(
                    replace(task, inputs=moved(task.inputs), outputs=moved(task.outputs))
                    for task in tasks
                ),
            )
            for name, tasks in self.segments
        ]
        return segments, regions, size

    def _allocate(self, count: int) -> int:
        base = self._size
        self._size += count
        return base

    def _entry(self, kind: str, x: int, leaves: Sequence[int], base: int) -> int:
        """Code of a result: x is a code over leaves, fresh slots or constants."""
        if kind == "number" or not x:
            return x
        sign, place = (1, x - 1) if x > 0 else (-1, -x - 1)
        slot = leaves[place] if kind == "leaf" else base + place
        return sign * (slot + 2)

    def _layout_of(
        self,
        operation: Operation,
        pattern: OperandPattern,
        lengths: Sequence[int],
        pinned: tuple[bool, ...],
    ) -> _CallLayout:
        kernel, used, fresh, codes = _traced_kernel(operation, pattern, tuple(lengths), pinned)
        number = self._kernel_id(kernel) if kernel.outputs else NO_KERNEL
        return _CallLayout(number, used, fresh, codes)

    def _kernel_id(self, kernel: Kernel) -> int:
        key = (kernel.nodes, kernel.results, kernel.inputs, kernel.title)
        if key not in self._kernel_ids:
            self._kernel_ids[key] = len(self.kernels)
            self.kernels.append(replace(kernel, name=f"k{len(self.kernels)}"))
        return self._kernel_ids[key]


@lru_cache(maxsize=MOST_TRACES)
def _traced_kernel(
    operation: Operation,
    pattern: OperandPattern,
    lengths: tuple[int, ...],
    pinned: tuple[bool, ...],
) -> tuple[Kernel, tuple[int, ...], int, tuple[Codes, ...]]:
    """Trace an operation once for all programs: a scene is composed again without some rows."""
    trace = Trace(lengths)
    results = operation(trace, *(trace.matrix(*block) for block in pattern))
    return traced_kernel(trace, operation.title, results, pinned)


def pattern_of(
    blocks: Sequence[SlotMatrix],
) -> tuple[OperandPattern, list[int], list[int], list[int]]:
    """Pattern that decides a trace, and the slots that differ between its calls.

    Returns
    -------
    pattern : tuple
        For each block its entries, coded with leaves instead of slots, and its shape.
    leaves : list of int
        The slots by first occurrence.
    bases, lengths : list of int
        The runs that these slots form; no run goes from one block into the next.
    """
    numbers: dict[int, int] = {}
    bases: list[int] = []
    lengths: list[int] = []
    pattern = []
    for block in blocks:
        previous = -2
        codes = []
        for x in block.entries:
            if -1 <= x <= 1:
                codes.append(x)
                continue
            slot = abs(x) - 2
            number = numbers.get(slot)
            if number is None:
                number = numbers[slot] = len(numbers)
                if slot == previous + 1:
                    lengths[-1] += 1
                else:
                    bases.append(slot)
                    lengths.append(1)
                previous = slot
            codes.append(number + 2 if x > 0 else -number - 2)
        pattern.append((tuple(codes), block.height, block.width))
    return tuple(pattern), list(numbers), bases, lengths
