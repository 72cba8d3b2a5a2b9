"""Report of what `verify` found."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from kousoku.model.errors import VerifyError

if TYPE_CHECKING:
    from collections.abc import Iterable

#: The largest error that is taken for rounding, in units.
LIMIT = 4.0


@dataclass(frozen=True, slots=True)
class Row:
    """The worst error of one output in one way of calling.

    Parameters
    ----------
    kernel, output : str
        The kernel, and its output.
    way : str
        ``"C"``, ``"C batch"``, ``"C lanes"``, ``"NumPy"`` or ``"NumPy batch"``.
    worst : float
        In units; infinite where a number that is not finite stands for a finite one or the other
        way round, or something for an identical zero.
    element : tuple of int
        Index in the output.
    point : int
        Index of the point.
    label : str
        Why that point is there.
    inputs : tuple of (str, str)
        Names and numbers of the inputs there.
    got, wanted : float
        What was computed; the reference, NaN for "must not be finite".
    limit : float
        Largest allowed error there, in units.
    """

    kernel: str
    output: str
    way: str
    worst: float
    element: tuple[int, ...]
    point: int
    label: str
    inputs: tuple[tuple[str, str], ...]
    got: float
    wanted: float
    limit: float = LIMIT

    @property
    def ok(self) -> bool:
        """Whether the error is rounding."""
        return self.worst <= self.limit

    def __str__(self) -> str:
        element = (
            f"{self.output}[{', '.join(map(str, self.element))}]" if self.element else self.output
        )
        wanted = "no finite number" if math.isnan(self.wanted) else repr(self.wanted)
        numbers = ", ".join(f"{name}={text}" for name, text in self.inputs)
        return (
            f"{self.kernel}: {element} by {self.way} is {_units(self.worst)} units off (limit "
            f"{self.limit:g}): got {self.got!r}, wanted {wanted}, at point {self.point} "
            f"({self.label}): {numbers}"
        )


def worst_rows(rows: Iterable[Row]) -> tuple[Row, ...]:
    """Worst row of each output of each kernel, in the order of the first ones."""
    worst: dict[tuple[str, str], Row] = {}
    for row in rows:
        largest = worst.setdefault((row.kernel, row.output), row)
        if row.worst > largest.worst:
            worst[row.kernel, row.output] = row
    return tuple(worst.values())


@dataclass(frozen=True, slots=True, repr=False)
class Report:
    """Whether a package computes what was derived.

    Parameters
    ----------
    package : str
        Its name.
    folder : str
        Its folder.
    rows : tuple of Row
        One for each kernel, output and way of calling.
    problems : tuple of str
        Everything that is wrong, each as one message; empty if nothing is.
    notes : tuple of str
        What was not checked, and why.
    """

    package: str
    folder: str
    rows: tuple[Row, ...]
    problems: tuple[str, ...]
    notes: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong."""
        return not self.problems

    def __repr__(self) -> str:
        worst = self.worst
        count = len(self.problems)
        result = f"{count} problem{'s' * (count > 1)}" if count else "computes what was derived"
        units = f", worst {_units(worst.worst)} units of {LIMIT:g}" if worst else ""
        return f"<Report of {self.package}: {result}{units}; print() shows each output>"

    @property
    def worst(self) -> Row | None:
        """The row with the largest error of its limit, None if nothing was computed.

        Outputs with a known error count where they exceed its limit.
        """
        rows = (row for row in self.rows if row.limit == LIMIT or not row.ok)
        return max(rows, key=lambda row: row.worst / row.limit, default=None)

    def check(self) -> None:
        """Raise a `VerifyError` that names all problems, if there are any."""
        if self.problems:
            raise VerifyError(f"{self.package}: " + "\n".join(self.problems))

    def to_dict(self) -> dict[str, Any]:
        """Report as JSON can hold it; what is not finite becomes text."""
        return {
            "package": self.package,
            "folder": self.folder,
            "ok": self.ok,
            "limit": LIMIT,
            "rows": [
                {k: _plain(v) for k, v in (*asdict(row).items(), ("ok", row.ok))}
                for row in self.rows
            ],
            "problems": list(self.problems),
            "notes": list(self.notes),
        }

    def __str__(self) -> str:
        """Table of all outputs, the worst point, and what is wrong."""
        head = ("kernel", "output", "way", "worst [units]", "at point")
        cells = [
            (r.kernel, r.output, r.way, _units(r.worst), f"{r.point} ({r.label})")
            for r in self.rows
        ]
        widths = [max(len(line[k]) for line in (head, *cells)) for k in range(len(head))]
        lines = [
            "  ".join(text.ljust(width) for text, width in zip(line, widths, strict=True)).rstrip()
            for line in (head, *cells)
        ]
        return "\n".join([f"{self.package}  {self.folder}", *lines, *self._summary()])

    def _summary(self) -> list[str]:
        worst = self.worst
        lines = list(self.notes)
        if self.ok and worst is not None:
            lines.append(
                f"ok: worst {_units(worst.worst)} units of at most {LIMIT:g}, {worst.kernel} "
                f"{worst.output} by {worst.way} at point {worst.point} ({worst.label})"
            )
        return lines + [f"WRONG: {problem}" for problem in self.problems]


def _units(worst: float) -> str:
    return f"{worst:.3f}" if worst < 1e6 else f"{worst:.3g}"


def _plain(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return (
        dict(value) if isinstance(value, tuple) and value and isinstance(value[0], tuple) else value
    )
