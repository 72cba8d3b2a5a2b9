"""Work-precision plots as SVG: error across, time up, both logarithmic, one line a tool.

They are written here and not by matplotlib: a plot is 10 kB of text that says what it shows, it is
the same bytes on every machine, and the benchmarks need no other package for it. A line is told
from others by its label, its dashes and its markers, without colour.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

WIDTH, HEIGHT = 860, 520
LEFT, RIGHT, TOP, BOTTOM = 70, 250, 40, 60
DASHES = ("", "7 3", "2 3", "10 3 2 3")
#: Paths about a point, as large as 4 pixels each way.
MARKERS = (
    "m-4,0a4,4 0 1,0 8,0a4,4 0 1,0 -8,0",  # circle
    "m-4,-4h8v8h-8z",  # square
    "m0,-5l5,9h-10z",  # triangle
    "m0,-5l5,5l-5,5l-5,-5z",  # diamond
    "m-4,-4l8,8m0,-8l-8,8",  # cross
    "m0,-5v10m-5,-5h10",  # plus
    "m0,5l5,-9h-10z",  # triangle that points down
)
COLOURS = ("#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#7a5c00", "#56b4e9")
#: Errors that are shown: smaller ones as the least, larger ones, and those that are NaN, not.
LEAST, LARGEST = 1e-16, 1e3
#: The least distance of two labels.
LABEL = 14


@dataclass(frozen=True, slots=True)
class ToolLine:
    """One tool at its settings.

    Parameters
    ----------
    label : str
        What stands at its end.
    points : sequence of (float, float)
        Error and time [s], in the order of the settings.
    is_bold : bool
        Whether it is ours.
    """

    label: str
    points: Sequence[tuple[float, float]]
    is_bold: bool = False


@dataclass(frozen=True, slots=True)
class LogAxis:
    """A logarithmic axis.

    Parameters
    ----------
    low, high : int
        Powers of ten at its ends.
    start, end : float
        Where these are, in pixels.
    """

    low: int
    high: int
    start: float
    end: float

    @classmethod
    def of(
        cls, values: Sequence[float], start: float, end: float, *, falls: bool = False
    ) -> LogAxis:
        """Axis that shows all values, from the largest to the smallest if it falls."""
        low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
        high = max(high, low + 1)
        return cls(high, low, start, end) if falls else cls(low, high, start, end)

    def at(self, value: float) -> float:
        """Place of a value."""
        share = (math.log10(value) - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)

    def decades(self) -> range:
        """Powers of ten."""
        low, high = sorted((self.low, self.high))
        return range(low, high + 1)


def work_precision(title: str, error: str, lines: Sequence[ToolLine]) -> str:
    """Plot."""
    found = [
        replace(line, points=[(max(x, LEAST), y) for x, y in line.points if x < LARGEST and y > 0])
        for line in lines
    ]
    return growth(title, error, found, falls=True)


def growth(title: str, across: str, lines: Sequence[ToolLine], *, falls: bool = False) -> str:
    """Plot of times over numbers that grow to the right, or fall as errors do."""
    shown = [(line, line.points) for line in lines if line.points]
    everything = [point for _, points in shown for point in points]
    if not everything:
        return ""
    x = LogAxis.of([point[0] for point in everything], LEFT, WIDTH - RIGHT, falls=falls)
    y = LogAxis.of([point[1] for point in everything], HEIGHT - BOTTOM, TOP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        f'font-family="sans-serif" font-size="12">',
        f"<title>{escape(title)}</title>",
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
        f'<text x="{LEFT}" y="22" font-size="15">{escape(title)}</text>',
        *_grid(x, y, across),
    ]
    places = _labels([(y.at(points[-1][1]), k) for k, (_, points) in enumerate(shown)])
    for k, (line, points) in enumerate(shown):
        parts += _drawn(k, line, [(x.at(a), y.at(b)) for a, b in points], places[k])
    return "\n".join([*parts, "</svg>\n"])


def _grid(x: LogAxis, y: LogAxis, error: str) -> list[str]:
    """Lines and numbers of both axes."""
    parts = []
    right, bottom = WIDTH - RIGHT, HEIGHT - BOTTOM
    for power in x.decades():
        at = x.at(10.0**power)
        parts.append(f'<path d="M{at:.1f},{TOP}V{bottom}" stroke="#ddd"/>')
        if power % 2 == 0 or len(x.decades()) < 9:
            parts.append(_power(at, bottom + 18, power, "middle"))
    for power in y.decades():
        at = y.at(10.0**power)
        parts.append(f'<path d="M{LEFT},{at:.1f}H{right}" stroke="#ddd"/>')
        parts.append(_power(LEFT - 8, at + 4, power, "end"))
    middle = (LEFT + right) / 2
    parts.append(
        f'<text x="{middle}" y="{HEIGHT - 16}" text-anchor="middle">{escape(error)}</text>'
    )
    parts.append(
        f'<text transform="translate(18,{(TOP + bottom) / 2}) rotate(-90)" text-anchor="middle">'
        "time [s]</text>"
    )
    return parts


def _power(x: float, y: float, power: int, anchor: str) -> str:
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">10'
        f'<tspan dy="-5" font-size="9">{power}</tspan></text>'
    )


def _labels(wanted: list[tuple[float, int]]) -> dict[int, float]:
    """Heights of labels, moved apart where they would cover each other."""
    places: dict[int, float] = {}
    last = -math.inf
    for height, k in sorted(wanted):
        last = places[k] = max(height, last + LABEL)
    over = max(0.0, last - (HEIGHT - BOTTOM))
    return {k: place - over for k, place in places.items()}


def _drawn(k: int, line: ToolLine, points: list[tuple[float, float]], label: float) -> list[str]:
    """Line with its markers and its label."""
    colour, dashes = COLOURS[k % len(COLOURS)], DASHES[k % len(DASHES)]
    width = 2.4 if line.is_bold else 1.2
    path = "L".join(f"{a:.1f},{b:.1f}" for a, b in points)
    marks = "".join(f"M{a:.1f},{b:.1f}{MARKERS[k % len(MARKERS)]}" for a, b in points)
    right = WIDTH - RIGHT + 8
    (a, b), weight = points[-1], ' font-weight="bold"' if line.is_bold else ""
    return [
        f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="{width}" '
        f'stroke-dasharray="{dashes}"/>',
        f'<path d="{marks}" fill="white" stroke="{colour}" stroke-width="1.2"/>',
        f'<path d="M{a + 5:.1f},{b:.1f}L{right},{label:.1f}" stroke="#bbb" stroke-width="0.6"/>',
        f'<text x="{right + 3}" y="{label + 4:.1f}" fill="{colour}"{weight}>{escape(line.label)}'
        "</text>",
    ]
