"""Status of an analysis at its end, and tolerances that decide it, as in ``status.h``.

They stand in both languages because each solver works alone: the C program without Python, the
NumPy solver without a compiler.
"""

from __future__ import annotations

from enum import IntEnum

#: A correction this small, relative to the largest length, leaves nothing to correct: Newton
#: squares it.
SETTLED = 2.0**-28
#: Corrections this small, relative to the largest length, are rounding.
ROUNDING_OF_POSITIONS = 2.0**-48
#: Below this pivot, of columns scaled to lengths, a block has a dead centre.
SINGULAR = 1e-7
#: Most that the Jacobian may turn along a step, relative to itself: at 1 it might be singular.
MOST_TILT = 0.75
#: Smallest part of a division that is stepped before the continuation gives up.
SMALLEST_STEP = 2.0**-24
#: Steps, good or not, from one row to the next before it gives up.
MOST_TRIES = 1_000_000


class AnalysisStatus(IntEnum):
    """Status of an analysis at its end."""

    GOOD = 0
    NOT_ASSEMBLED = 1
    ON_DEAD_CENTRE = 2
    OTHER_SIDE = 3
    DEAD_CENTRE = 4
    LIMIT_TOO_SMALL = 5
    NOT_FINITE = 6
    BAD_ARGUMENT = 7
    TOO_FAR = 8

    @property
    def message(self) -> str:
        """A sentence for people."""
        return MESSAGES[self]


MESSAGES = (
    "good",
    "the linkage cannot be assembled from the positions of the scene",
    "the positions of the scene lie on a dead centre, where the side is not clear",
    "the linkage assembles only on the other side of a dead centre than the scene shows",
    "a dead centre, or a change point, on the way",
    "the residual limit is smaller than rounding allows",
    "a number is not finite",
    "an option is not finite, not positive, or start is beyond first; or times do not ascend",
    "the inputs go too far, to the first row or from row to row: more than 1,000,000 steps",
)


class StopError(Exception):
    """An analysis that cannot go on."""

    def __init__(self, status: AnalysisStatus) -> None:
        super().__init__(status.message)
        self.status = status
