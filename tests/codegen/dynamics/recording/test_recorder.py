"""The recorder: one pattern, one kernel; what is known needs no slot."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix, zeros

if TYPE_CHECKING:
    from kousoku.codegen.dynamics.recording.matrix import Matrix
    from kousoku.codegen.dynamics.recording.traces import Trace


@dataclass(frozen=True, slots=True)
class Product:
    """A test operation: a matrix times a matrix, and the calls that were traced."""

    title: str = "product"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        return (blocks[0] @ blocks[1],)


@dataclass(frozen=True, slots=True)
class Difference:
    """A test operation: a − b and b − a."""

    title: str = "difference"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        a, b = blocks
        return a - b, b - a


def recorder() -> Recorder:
    fresh = Recorder()
    fresh.begin("geometry")
    return fresh


def test_what_is_known_without_computing_leaves_no_kernel() -> None:
    rec = recorder()
    full = SlotMatrix(rec.region("m", 4).entries, 2, 2)
    assert rec.call(Product(), full, SlotMatrix((1, 0, 0, 1), 2, 2)) == (full,)
    assert rec.call(Product(), full, zeros(2, 1)) == (zeros(2, 1),)
    assert rec.kernels == []
    assert rec.segments == [("geometry", [])]


def test_equal_patterns_share_a_kernel_and_other_zeros_do_not() -> None:
    rec = recorder()
    full = [SlotMatrix(rec.region(f"m{k}", 4).entries, 2, 2) for k in range(3)]
    rec.call(Product(), full[0], full[1])
    rec.call(Product(), full[1], full[2])
    assert len(rec.kernels) == 1
    rec.call(Product(), full[0], SlotMatrix((*full[1].entries[:3], 0), 2, 2))
    rec.call(Product(), full[0], full[0])
    assert len(rec.kernels) == 3


def test_ones_and_zeros_fold_and_copies_have_no_slot() -> None:
    rec = recorder()
    x = rec.region("x", 2)
    (result,) = rec.call(Product(), SlotMatrix((0, 1, -1, 0), 2, 2), x)
    assert result.entries == (x.entries[1], -x.entries[0])
    (nothing,) = rec.call(Product(), SlotMatrix((0, 0), 1, 2), x)
    assert nothing.entries == (0,)
    assert rec.segments[0][1] == []


def test_a_result_and_its_negative_share_a_slot() -> None:
    rec = recorder()
    a, b = rec.region("a", 1), rec.region("b", 1)
    first, second = rec.call(Difference(), a, b)
    assert first.entries[0] == -second.entries[0]
    assert len(rec.kernels[0].results[0]) == 1


def test_equal_numbers_are_stored_once_and_zeros_and_ones_never() -> None:
    rec = recorder()
    first = rec.constant([0.5, 0, Fraction(1, 3), -1])
    second = rec.constant([1, 0.5, Fraction(1, 3)])
    assert first.entries[1] == 0
    assert first.entries[3] == -1
    assert second.entries == (1, first.entries[0], first.entries[2])
    assert rec.constants == [Fraction(1, 2), Fraction(1, 3)]
