"""Reference values of a scene's kernels: on the way of the mechanism, beside it, and at NaN."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from kousoku.codegen.dual import DUAL, Dual, variable
from kousoku.codegen.error_unit import columns
from kousoku.codegen.interpret import HIGH, HIGH_CONTEXT
from kousoku.codegen.linkage_exact import Exact
from kousoku.codegen.linkage_layout import SUFFIXES
from kousoku.model.jsontext import to_text

if TYPE_CHECKING:
    from collections.abc import Sequence
    from fractions import Fraction

    from kousoku.codegen.kernel import Kernel, Package
    from kousoku.codegen.linkage_layout import Layout
    from kousoku.codegen.linkage_solution import Place

    #: For each input of the kernels its doubles.
    Numbers = dict[str, tuple[float, ...]]

FORMAT = 1
#: Every so many steps of the way a reference is taken.
EVERY = 2
#: Stands where a kernel does not look.
_NONE = Dual(HIGH_CONTEXT.nan, {})
#: How far points lie from the way, relative to each number: rounding, and anywhere.
BESIDE = ((2.0**-33, "near"), (0.25, "away from"))


@dataclass(frozen=True, slots=True)
class Point:
    """Where kernels are evaluated.

    Parameters
    ----------
    label : str
        Why the point is there.
    numbers : dict of str to tuple of float
        ``alpha``, ``x`` and their derivatives.
    has_nan : bool
        Whether the first unknown of each kernel is NaN instead.
    """

    label: str
    numbers: Numbers
    has_nan: bool = False


def references(package: Package, layout: Layout, found: Sequence[Place]) -> str:
    """Return the text of the reference values, in the format of the kinds.

    Values come from :class:`kousoku.codegen.linkage_exact.Exact` in 50 digits. Constants of the
    scene count as inputs in the unit of error: they were inputs before they were bound.
    """
    points = _points(layout, found[::EVERY])
    kernels = [
        {"name": kernel.name, "points": [_row(kernel, layout, point) for point in points]}
        for kernel in package.kernels
    ]
    return to_text({"format": FORMAT, "package": package.name, "kernels": kernels})


def _points(layout: Layout, found: Sequence[Place]) -> list[Point]:
    """Return the points of all kernels, the last one with a number that is NaN."""
    points = [
        Point(
            f"{place.part} of the way",
            {name: tuple(map(float, values)) for name, values in place.motion.items()},
        )
        for place in found
    ]
    if not found:
        points.append(Point("the positions of the scene", _given(layout)))
    for index, point in enumerate(list(points)):
        size, where = BESIDE[index % len(BESIDE)]
        points.append(Point(f"{where} {point.label}", _scattered(point.numbers, size, index)))
    # Away from symmetric positions, where a derivative may happen to vanish.
    numbers = _scattered(points[0].numbers, BESIDE[-1][0], len(points))
    points.append(Point("x[0] is nan", numbers, has_nan=True))
    return points


def _given(layout: Layout) -> Numbers:
    coordinates = layout.system.coordinates
    numbers = {
        "alpha": tuple(float(coordinates[c].start) for c in layout.system.inputs),
        "x": tuple(float(coordinates[c].start) for c in layout.unknowns),
    }
    for name in ("alpha", "x"):
        for suffix in SUFFIXES[1:]:
            numbers[name + suffix] = tuple(1.0 for _ in numbers[name])
    return numbers


def _scattered(numbers: Numbers, size: float, seed: int) -> Numbers:
    """Return numbers that are off by parts of ``size``; zeros move by it too."""
    golden = 0.6180339887498949
    count = seed
    moved: dict[str, tuple[float, ...]] = {}
    for name, values in numbers.items():
        row = []
        for value in values:
            count += 1
            step = 2 * math.fmod(count * golden, 1.0) - 1
            row.append(value * (1 + size * step) if value else size * step)
        moved[name] = tuple(row)
    return moved


def _row(kernel: Kernel, layout: Layout, point: Point) -> dict[str, object]:
    """Return one point of a kernel with its references."""
    motion, _, block = kernel.name.partition("_")
    number = int(block) - 1 if block else None
    places = layout.everywhere if number is None else layout.places_in(number)
    numbers = {quantity.name: [0.0] * quantity.size for quantity in kernel.inputs}
    duals: dict[str, list[Dual]] = {n: [_NONE] * len(x) for n, x in point.numbers.items()}
    bad: set[object] = set()
    sizes: dict[object, Any] = {}
    for coordinate, (name, index) in places.items():
        whole, where = layout.everywhere[coordinate]
        for suffix in SUFFIXES:
            if name + suffix not in numbers:
                continue
            x = point.numbers[whole + suffix][where]
            if point.has_nan and (name + suffix, index) == ("x", 0):
                # Where a number is NaN, any number shows which outputs depend on it.
                bad.add((name + suffix, index))
                numbers[name + suffix][index] = math.nan
            else:
                numbers[name + suffix][index] = x
            value = HIGH_CONTEXT.mpf(x)
            sizes[name + suffix, index] = abs(value)
            duals[whole + suffix][where] = variable(value, (name + suffix, index))

    def constant(name: object, value: Fraction) -> Dual:
        sizes[name] = abs(HIGH.number(value))
        return variable(HIGH.number(value), name)

    values = _values(motion, number, Exact(layout, DUAL, duals, constant))
    outputs = {
        quantity.name: columns([values[quantity.name][e] for e in kernel.nonzero(k)], sizes, bad)
        for k, quantity in enumerate(kernel.outputs)
    }
    inputs = {n: [x if math.isfinite(x) else str(x) for x in xs] for n, xs in numbers.items()}
    return {"label": point.label, "inputs": inputs, "outputs": outputs}


def _values(motion: str, number: int | None, exact: Exact) -> dict[str, list[Dual]]:
    """Return what a kernel must give."""
    if number is not None:
        return exact.block(number, ("position", "velocity", "acceleration").index(motion))
    return exact.nodes() if motion == "nodes" else exact.angles()
