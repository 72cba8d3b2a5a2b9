"""Run a kernel at its reference points in every way that it can be called."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from kousoku.runtime.lanes import from_lanes, to_lanes

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.model.files.manifest import KernelManifest
    from kousoku.runtime.arguments import Floats
    from kousoku.runtime.choice import ChosenTarget
    from kousoku.runtime.kernel import Kernel
    from kousoku.runtime.reference import Reference

Way = Literal["C", "C batch", "C lanes", "NumPy", "NumPy batch"]


@dataclass(frozen=True, slots=True)
class EvaluatedOutput:
    """Output of a kernel at every point.

    Parameters
    ----------
    way : str
        How the kernel was called.
    output : int
        Which output.
    is_alone : bool
        Whether only this output was asked for, which runs other code.
    values : (n, size)
        Elements flat; a batch may be longer than the list of points, which then starts over.
    """

    way: Way
    output: int
    is_alone: bool
    values: Floats


def ways(target: ChosenTarget) -> tuple[Way, ...]:
    """Ways to call a kernel of a target."""
    return ("C", "C batch", "C lanes") if target == "c" else ("NumPy", "NumPy batch")


def evaluate(kernel: Kernel, reference: Reference, way: Way) -> Iterator[EvaluatedOutput]:
    """Every output at every point, all of them together and each alone."""
    names = tuple(q.name for q in kernel.manifest.outputs)
    # The points are chosen to be hard: NumPy's warnings are expected.
    with np.errstate(all="ignore"):
        for k, values in enumerate(_run(kernel, reference, way, names)):
            yield EvaluatedOutput(way, k, False, values)
        for k, name in enumerate(names if len(names) > 1 else ()):
            (values,) = _run(kernel, reference, way, (name,))
            yield EvaluatedOutput(way, k, True, values)


def _run(
    kernel: Kernel, reference: Reference, way: Way, names: tuple[str, ...]
) -> tuple[Floats, ...]:
    n = len(reference.labels)
    if way in {"C", "NumPy"}:
        results = [
            kernel(*(array[point] for array in reference.inputs), outputs=names)
            for point in range(n)
        ]
        return tuple(np.array(column).reshape((n, -1)) for column in zip(*results, strict=True))
    width = kernel.lane_width
    # Full blocks and a partial one, whatever the count of points is.
    rows = np.arange(n + width + (n % width == 0)) % n
    batch = tuple(array[rows] for array in reference.inputs)
    if way == "C lanes":
        blocks = kernel.lanes(*(to_lanes(array, width) for array in batch), outputs=names)
        outputs = tuple(from_lanes(block, len(rows)) for block in blocks)
    else:
        outputs = kernel(*batch, outputs=names)
    return tuple(array.reshape((len(rows), -1)) for array in outputs)


def different_bits(
    kernel: KernelManifest, reference: Reference, evaluations: Sequence[EvaluatedOutput]
) -> Iterator[str]:
    """Message for each output whose bits depend on the way of calling.

    Which NaN it is does not count: IEEE 754 leaves that to the processor.
    """
    n = len(reference.labels)
    for k, output in enumerate(kernel.outputs):
        for is_alone in (False, True):
            same = [e for e in evaluations if e.output == k and e.is_alone == is_alone]
            for other in same[1:]:
                a, b = same[0].values, other.values[:n]
                differs = (a.view(np.int64) != b.view(np.int64)) & ~(np.isnan(a) & np.isnan(b))
                if differs.any():
                    point, element = (int(i) for i in np.argwhere(differs)[0])
                    yield (
                        f"{kernel.name}: {output.name} element {element} has other bits by "
                        f"{other.way} ({b[point, element].hex()}) than by {same[0].way} "
                        f"({a[point, element].hex()}) at point {point} "
                        f"({reference.labels[point]}); contraction or other compiler flags do that"
                    )
