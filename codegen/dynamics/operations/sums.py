"""Sums of many blocks, a few at a time, so that no kernel grows with the count of bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.matrix import Matrix
    from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix
    from kousoku.codegen.dynamics.recording.traces import Trace

#: How many terms one task adds up.
CHUNK = 4


@dataclass(frozen=True, slots=True)
class VectorSum:
    """Sum of vectors. Blocks: the vectors (n,), of one frame and unit."""

    title: str = "sum"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Sum (n,), of their frame and unit."""
        total, *others = blocks
        for block in others:
            total += block
        return (total,)


def summed(
    recorder: Recorder, terms: Sequence[SlotMatrix], into: SlotMatrix | None = None
) -> SlotMatrix:
    """Sum of blocks, recorded.

    Parameters
    ----------
    recorder : Recorder
        The program, in the segment that needs it.
    terms : sequence of SlotMatrix
        One at least, all of one shape.
    into : SlotMatrix, optional
        Its slots. Without them nothing is recorded of one term alone.
    """
    while len(terms) > CHUNK:
        terms = [
            recorder.call(VectorSum(), *terms[k : k + CHUNK])[0]
            for k in range(0, len(terms), CHUNK)
        ]
    if len(terms) == 1 and into is None:
        return terms[0]
    return recorder.call(VectorSum(), *terms, into=(into,))[0]
