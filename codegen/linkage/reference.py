"""Reference values of a linkage: along its motion, beside it, and at NaN."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from kousoku.codegen.error_unit import columns
from kousoku.codegen.linkage.exact import Exact
from kousoku.codegen.linkage.layout import SUFFIXES
from kousoku.codegen.linkage.solution import solution
from kousoku.model.files.jsontext import to_text
from kousoku.model.files.manifest import REFERENCE_FORMATS
from kousoku.model.numbers.digits import CONTEXT, HIGH
from kousoku.model.numbers.dual import DUAL, Dual, variable
from kousoku.runtime.kinematics.rows import OF_NODES

if TYPE_CHECKING:
    from collections.abc import Sequence
    from fractions import Fraction

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.codegen.linkage.layout import WorkspaceLayout
    from kousoku.codegen.linkage.solution import LinkagePosition

    #: For each input of the kernels its doubles.
    Numbers = dict[str, tuple[float, ...]]

#: Stride of the positions that are references.
STRIDE = 2
#: Distances of points from the motion, relative to each number: of rounding, and larger.
BESIDE = ((2.0**-33, "near"), (0.25, "away from"))


@dataclass(frozen=True, slots=True)
class ReferencePoint:
    """Point at which segments are evaluated.

    Parameters
    ----------
    label : str
        Kind of the point.
    numbers : dict of str to tuple of float
        ``alpha``, ``x`` and their derivatives.
    block : int, optional
        The block whose segments alone are evaluated.
    nan : (str, int), optional
        The number that is NaN instead: the first unknown of the block.
    """

    label: str
    numbers: Numbers
    block: int | None = None
    nan: tuple[str, int] | None = None


def reference_values(
    program: Program, layout: WorkspaceLayout, positions: Sequence[LinkagePosition]
) -> str:
    """Text of the reference values.

    Values come from :class:`kousoku.codegen.linkage.exact.Exact` in 50 digits. Constants of the
    scene count as inputs in the unit of error: they were inputs before they were bound.
    """
    return to_text(
        {
            "format": REFERENCE_FORMATS["linkage"],
            "points": [
                _row(program, layout, point) for point in _points(layout, positions[::STRIDE])
            ],
            "exact": [kernel.name for kernel in program.kernels if kernel.is_exact],
            "solution": solution(layout, positions),
        }
    )


def _points(layout: WorkspaceLayout, positions: Sequence[LinkagePosition]) -> list[ReferencePoint]:
    """Points; each of the last ones has a number that is NaN."""
    points = [
        ReferencePoint(
            f"{position.part} of the way",
            {name: tuple(map(float, values)) for name, values in position.motion.items()},
        )
        for position in positions
    ]
    if not positions:
        points.append(ReferencePoint("the positions of the scene", _start_numbers(layout)))
    for index, point in enumerate(list(points)):
        size, where = BESIDE[index % len(BESIDE)]
        points.append(
            ReferencePoint(f"{where} {point.label}", _scattered(point.numbers, size, index))
        )
    # Away from symmetric positions, where a derivative may happen to vanish.
    numbers = _scattered(points[0].numbers, BESIDE[-1][0], len(points))
    first = 0
    for number, block in enumerate(layout.blocks):
        points.append(ReferencePoint(f"x[{first}] is nan", numbers, number, ("x", first)))
        first += len(block.unknowns)
    return points


def _start_numbers(layout: WorkspaceLayout) -> Numbers:
    coordinates = layout.assembly.coordinates
    numbers = {
        "alpha": tuple(float(coordinates[c].start) for c in layout.assembly.inputs),
        "x": tuple(float(coordinates[c].start) for c in layout.unknowns),
    }
    for name in ("alpha", "x"):
        for suffix in SUFFIXES[1:]:
            numbers[name + suffix] = tuple(1.0 for _ in numbers[name])
    return numbers


def _scattered(numbers: Numbers, size: float, seed: int) -> Numbers:
    """Numbers with relative changes of up to ``size``, absolute ones of zeros."""
    golden = 0.6180339887498949
    count = seed
    scattered: dict[str, tuple[float, ...]] = {}
    for name, values in numbers.items():
        row = []
        for value in values:
            count += 1
            step = 2 * math.fmod(count * golden, 1.0) - 1
            row.append(value * (1 + size * step) if value else size * step)
        scattered[name] = tuple(row)
    return scattered


def _row(program: Program, layout: WorkspaceLayout, point: ReferencePoint) -> dict[str, object]:
    """Point with the references of its segments."""
    high = {n: [CONTEXT.mpf(x) for x in xs] for n, xs in point.numbers.items()}
    duals = {n: [variable(x, (n, k)) for k, x in enumerate(xs)] for n, xs in high.items()}
    sizes: dict[object, Any] = {(n, k): abs(x) for n, xs in high.items() for k, x in enumerate(xs)}
    inputs: dict[str, list[object]] = {n: list(xs) for n, xs in point.numbers.items()}
    nonfinite = []
    if point.nan is not None:
        # In place of NaN, any number shows which outputs depend on it.
        name, index = point.nan
        inputs[name][index] = "nan"
        nonfinite.append(point.nan)

    def constant(name: object, value: Fraction) -> Dual:
        sizes[name] = abs(HIGH.number(value))
        return variable(HIGH.number(value), name)

    exact = Exact(layout, DUAL, duals, constant)
    outputs = {}
    for kernel in program.kernels:
        order, _, number = kernel.name.partition("_")
        if point.block is not None and number != str(point.block + 1):
            continue
        if number:
            values = exact.block(int(number) - 1, OF_NODES.index(order))
        else:
            values = exact.nodes() if order == "nodes" else exact.angles()
        outputs[kernel.name] = {name: columns(x, sizes, nonfinite) for name, x in values.items()}
    return {"label": point.label, "inputs": inputs, "outputs": outputs}
