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
        total, *rest = blocks
        for block in rest:
            total += block
        return (total,)


def summed(
    recorder: Recorder, parts: Sequence[SlotMatrix], into: SlotMatrix | None = None
) -> SlotMatrix:
    """Record the sum of blocks; return where it is.

    Parameters
    ----------
    recorder : Recorder
        The program, in the segment that needs it.
    parts : sequence of SlotMatrix
        One at least, all of one shape.
    into : SlotMatrix, optional
        Where it goes. Without it nothing is recorded of one part alone.
    """
    while len(parts) > CHUNK:
        parts = [
            recorder.call(VectorSum(), *parts[k : k + CHUNK])[0]
            for k in range(0, len(parts), CHUNK)
        ]
    if len(parts) == 1 and into is None:
        return parts[0]
    return recorder.call(VectorSum(), *parts, into=(into,))[0]
