"""How short rows become lanes, and lanes rows again, by shuffles of two vectors.

Rows of k numbers lie end to end in k vectors, each as long as there are rows. For even k the
numbers with even place part from those with odd place, which leaves two problems half as long.
For odd k the places of one number of all rows, modulo the length of a vector, are all different:
blending puts them into one vector, and one permutation sorts them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence


@dataclass(frozen=True, slots=True)
class RowsView:
    """The moves of rows of one size.

    Parameters
    ----------
    size : int
        Numbers in a row.
    moves : tuple of str
        Statements of C for vectors longer than a row; none where no vector is.
    """

    size: int
    moves: tuple[str, ...]


#: Rows of this size are at least as long as any vector.
LONGEST = 8


class _Moves:
    """Writes one shuffle after the other."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def shuffle(self, a: str, b: str, pick: str, *indices: int) -> str:
        name = f"a{len(self.lines)}"
        k, e, s = (*indices, 0)[:3]
        self.lines.append(f"const vec {name} = SHUFFLE({a}, {b}, {pick}, {k}, {e}, {s});")
        return name

    def part(self, vectors: Sequence[str]) -> list[str]:
        """Return number 0 of all rows, number 1 of all rows, and so on."""
        k = len(vectors)
        if k == 1:
            return list(vectors)
        if k % 2 == 0:
            pairs = list(zip(vectors[::2], vectors[1::2], strict=True))
            halves = [
                self.part([self.shuffle(a, b, "UNZIP", k, e) for a, b in pairs]) for e in (0, 1)
            ]
            return [name for names in zip(*halves, strict=True) for name in names]
        taken = []
        for e in range(k):
            name = vectors[0]
            for s in range(1, k):
                name = self.shuffle(name, vectors[s], "TAKE", k, e, s)
            taken.append(self.shuffle(name, name, "SORT", k, e))
        return taken

    def join(self, numbers: Sequence[str]) -> list[str]:
        """Return the rows end to end: the way back."""
        k = len(numbers)
        if k == 1:
            return list(numbers)
        if k % 2 == 0:
            pairs = zip(self.join(numbers[::2]), self.join(numbers[1::2]), strict=True)
            return [self.shuffle(a, b, "ZIP", k, e) for a, b in pairs for e in (0, 1)]
        spread = [self.shuffle(x, x, "SPREAD", k, e) for e, x in enumerate(numbers)]
        rows = []
        for e in range(k):
            name = spread[0]
            for s in range(1, k):
                name = self.shuffle(name, spread[s], "GIVE", k, e, s)
            rows.append(name)
        return rows


def load_view(size: int) -> RowsView:
    """Return how rows at ``x`` become the vectors ``y``."""
    moves = _Moves()
    if size >= LONGEST:
        return RowsView(size, ())
    ends = moves.part([f"v{k}" for k in range(size)])
    begin = [f"const vec v{k} = *(const vec *)(x + {k} * LANES);" for k in range(size)]
    finish = [f"y[{k}] = {name};" for k, name in enumerate(ends)]
    return RowsView(size, (*begin, *moves.lines, *finish))


def store_view(size: int) -> RowsView:
    """Return how the vectors ``y`` become rows at ``x``."""
    moves = _Moves()
    if size >= LONGEST:
        return RowsView(size, ())
    ends = moves.join([f"y[{k}]" for k in range(size)])
    finish = [f"*(vec *)(x + {k} * LANES) = {name};" for k, name in enumerate(ends)]
    return RowsView(size, (*moves.lines, *finish))
