"""Reference values of a scene's kernels: on the way of the mechanism, beside it, and at NaN."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from kousoku.codegen.interpret import HIGH, HIGH_CONTEXT
from kousoku.codegen.jsontext import to_text
from kousoku.codegen.linkage_dual import DUAL, ROUNDING, Dual, variable
from kousoku.codegen.linkage_exact import SUFFIXES, Exact
from kousoku.codegen.linkage_solution import places

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from fractions import Fraction

    from kousoku.codegen.kernel import Kernel, Package
    from kousoku.codegen.linkage_layout import Layout

    #: For each input of the kernels its doubles.
    Numbers = dict[str, tuple[float, ...]]

FORMAT = 1
SMALLEST_SUBNORMAL = 5e-324
#: A derivative below this is a zero that 50 digits left over.
NEGLIGIBLE = HIGH_CONTEXT.mpf(10) ** -40
#: Every so many steps of the way a reference is taken.
EVERY = 2
#: How far points lie from the way, relative to each number: rounding, and anywhere.
BESIDE = ((2.0**-33, "near"), (0.25, "away from"))


def references(package: Package, layout: Layout) -> str:
    """Return the text of ``reference.json``, in the format of the kinds.

    Values come from :class:`kousoku.codegen.linkage_exact.Exact` in 50 digits. Constants of the
    scene count as inputs in the unit of error: they were inputs before they were bound.
    """
    points = _points(layout)
    kernels = []
    for kernel in package.kernels:
        rows = [_row(kernel, layout, label, numbers) for label, numbers in points]
        kernels.append({"name": kernel.name, "points": rows})
    return to_text({"format": FORMAT, "package": package.name, "kernels": kernels})


def _points(layout: Layout) -> list[tuple[str, Numbers]]:
    """Return the points of all kernels, the last one with a number that is NaN."""
    found = places(layout)[::EVERY]
    points: list[tuple[str, Numbers]] = []
    for place in found:
        numbers = {name: tuple(map(float, values)) for name, values in place.motion.items()}
        points.append((f"{place.part} of the way", numbers))
    if not found:
        points.append(("the positions of the scene", _given(layout)))
    for index, (label, numbers) in enumerate(list(points)):
        size, where = BESIDE[index % len(BESIDE)]
        points.append((f"{where} {label}", _scattered(numbers, size, index)))
    # Away from symmetric positions, where a derivative may happen to vanish.
    numbers = _scattered(points[0][1], BESIDE[-1][0], len(points))
    points.append(("x[0] is nan", {**numbers, "x": (math.nan, *numbers["x"][1:])}))
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


def _row(kernel: Kernel, layout: Layout, label: str, numbers: Numbers) -> dict[str, object]:
    """Return one point of a kernel with its references."""
    names = [quantity.name for quantity in kernel.inputs]
    bad = {(n, k) for n in names for k, x in enumerate(numbers[n]) if not math.isfinite(x)}
    sizes: dict[object, Any] = {}
    motion: dict[str, list[Dual]] = {}
    for name in names:
        motion[name] = []
        for k, x in enumerate(numbers[name]):
            # Where a number is NaN, any number shows which outputs depend on it.
            value = HIGH_CONTEXT.mpf(x if math.isfinite(x) else 1.25)
            sizes[name, k] = abs(value)
            motion[name].append(variable(value, (name, k)))

    def constant(name: object, value: Fraction) -> Dual:
        sizes[name] = abs(HIGH.number(value))
        return variable(HIGH.number(value), name)

    values = _values(kernel, Exact(layout, DUAL, motion, constant))
    outputs = {
        quantity.name: _columns([values[quantity.name][e] for e in kernel.nonzero(k)], sizes, bad)
        for k, quantity in enumerate(kernel.outputs)
    }
    inputs = {n: [x if math.isfinite(x) else str(x) for x in numbers[n]] for n in names}
    return {"label": label, "inputs": inputs, "outputs": outputs}


def _values(kernel: Kernel, exact: Exact) -> dict[str, list[Dual]]:
    """Return what a kernel must give, found by its name."""
    if kernel.name == "nodes":
        return exact.nodes()
    if kernel.name == "angles":
        return exact.angles()
    motion, _, number = kernel.name.partition("_")
    return exact.block(int(number) - 1, ("position", "velocity", "acceleration").index(motion))


def _columns(
    elements: Sequence[Dual], sizes: Mapping[object, Any], bad: set[tuple[str, int]]
) -> dict[str, object]:
    rows = [_element(element, sizes, bad) for element in elements]
    return {name: [row[k] for row in rows] for k, name in enumerate(("high", "low", "unit"))}


def _element(
    element: Dual, sizes: Mapping[object, Any], bad: set[tuple[str, int]]
) -> tuple[float | None, float, float]:
    """Return high, low and unit u (|f| + Σ |x ∂f/∂x|) of one number."""
    if any(abs(element.gradient.get(name, 0)) > NEGLIGIBLE for name in bad):
        return None, 0.0, SMALLEST_SUBNORMAL
    high = float(element.value)
    low = float(element.value - high)
    size = abs(element.value) + sum(abs(sizes[n] * x) for n, x in element.gradient.items())
    unit = max(float(f"{float(ROUNDING * size):.2e}"), SMALLEST_SUBNORMAL)
    return high, float(f"{low:.4e}"), unit
