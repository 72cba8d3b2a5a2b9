"""The reference values of a package: points, and what the kernels must give there."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.errors import VerifyError
from kousoku.model.files.manifest import MANIFEST_FILE, REFERENCE_FILE, REFERENCE_FORMATS
from kousoku.runtime.report import LIMIT, Row

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from kousoku.model.files.manifest import KernelManifest, Manifest
    from kousoku.model.files.quantity import Quantity
    from kousoku.runtime.arguments import Floats


@dataclass(frozen=True, slots=True)
class Expected:
    """Reference values of one output at every point, elements flat.

    Parameters
    ----------
    high, low : (n_points, size)
        The value is high + low; NaN where the output must not be finite.
    unit : (n_points, size)
        The unit of error; 0 for elements that are identically zero.
    """

    high: Floats
    low: Floats
    unit: Floats

    @classmethod
    def of_columns(cls, columns: Mapping[str, Any]) -> Expected:
        """Stored values of an output at one point; null is NaN."""
        return cls(*(np.array([columns[key]], dtype=np.float64) for key in ("high", "low", "unit")))

    def row(self, values: Floats, **fields: Any) -> Row:
        """Worst error of an output at one point.

        Parameters
        ----------
        values : (size,)
            What was computed, in the unit of the output.
        **fields
            The other fields of the row: kernel, output, way, point, label, inputs.
        """
        (errors,) = self.errors(values[None, :])
        element = int(np.argmax(errors))
        return Row(
            worst=float(errors[element]),
            element=(element,),
            got=float(values[element]),
            wanted=float(self.high[0, element]),
            **fields,
        )

    def errors(self, values: Floats) -> Floats:
        """Errors |v − high − low| / unit (n, size) [-], element by element.

        They are infinite where only one of the two is finite, or a zero has an error.

        Parameters
        ----------
        values : (n, size)
            What a kernel gave at the points, which start over where there are more rows.
        """
        rows = np.arange(len(values)) % len(self.high)
        high, low, unit = self.high[rows], self.low[rows], self.unit[rows]
        with np.errstate(all="ignore"):
            distance = np.abs((values - high) - low)
            units = np.where(distance == 0, 0.0, distance / unit)
        # NaN is infinitely far from any number.
        units = np.where(np.isnan(units), np.inf, units)
        return np.where(np.isnan(high), np.where(np.isfinite(values), np.inf, 0.0), units)


@dataclass(frozen=True, slots=True)
class Reference:
    """The points of one kernel.

    Parameters
    ----------
    labels : tuple of str
        Why each point is there.
    inputs : tuple of (n_points, *shape) arrays
        In kernel order.
    outputs : tuple of Expected
        In kernel order.
    limits : tuple of mapping of str to float
        For each point the outputs that are known to be off by more than the limit, and how far.
    """

    labels: tuple[str, ...]
    inputs: tuple[Floats, ...]
    outputs: tuple[Expected, ...]
    limits: tuple[Mapping[str, float], ...]

    def limits_of(self, output: str) -> Floats:
        """Limits (n_points,) [-] of an output in units, point by point."""
        return np.array([limits.get(output, LIMIT) for limits in self.limits])

    def inputs_at(self, point: int, kernel: KernelManifest) -> tuple[tuple[str, str], ...]:
        """Names of the inputs and their numbers at a point, with all their digits."""
        return tuple(
            (q.name, str(array[point].tolist()))
            for q, array in zip(kernel.inputs, self.inputs, strict=True)
        )


def read_references(
    folder: Path, manifest: Manifest, files: Mapping[str, bytes]
) -> dict[str, Reference]:
    """Reference values of every kernel of a package.

    Parameters
    ----------
    folder : Path
        Folder of the package.
    manifest : Manifest
        Its manifest.
    files : mapping of str to bytes
        Contents of its files, as :func:`kousoku.runtime.sources.read_files` gives it.

    Raises
    ------
    VerifyError
        There are none, or they are not those of this package.
    """
    path = folder / REFERENCE_FILE
    if REFERENCE_FILE not in files:
        raise VerifyError(f"{folder / MANIFEST_FILE} lists no {REFERENCE_FILE}: nothing to verify")
    try:
        data = json.loads(files[REFERENCE_FILE])
        if data["format"] != REFERENCE_FORMATS["kind"]:
            raise VerifyError(
                f"{path}: its format is {data['format']}, wanted {REFERENCE_FORMATS['kind']}"
            )
        points = {kernel["name"]: kernel["points"] for kernel in data["kernels"]}
        if not all(points[k.name] for k in manifest.kernels):
            raise VerifyError(f"{path}: a kernel has no points: nothing to verify")
        return {k.name: reference_of(k, points[k.name]) for k in manifest.kernels}
    except (ValueError, KeyError, TypeError, IndexError) as error:
        raise VerifyError(f"{path} does not fit the manifest beside it: {error!r}") from None


def reference_of(kernel: KernelManifest, points: list[dict[str, Any]]) -> Reference:
    """Points of a kernel as the reference file has them, as arrays."""

    def stack(q: Quantity) -> Floats:
        rows = [[float(x) for x in point["inputs"][q.name]] for point in points]
        return np.array(rows, dtype=np.float64).reshape((len(points), *q.shape))

    outputs = []
    for q, nonzero in zip(kernel.outputs, kernel.nonzero, strict=True):
        columns = {}
        for name in ("high", "low", "unit"):
            column = np.zeros((len(points), q.size))
            rows = [point["outputs"][q.name][name] for point in points]
            # None becomes NaN: the output must not be finite.
            column[:, list(nonzero)] = np.array(rows, dtype=np.float64).reshape(
                (len(points), len(nonzero))
            )
            columns[name] = column
        outputs.append(Expected(**columns))
    labels = tuple(str(point["label"]) for point in points)
    limits = tuple(dict(point.get("limits", {})) for point in points)
    if sorted(item for errors in limits for item in errors.items()) != sorted(kernel.known):
        raise ValueError(f"{kernel.name}: known errors {limits}, not {kernel.known}")
    return Reference(labels, tuple(stack(q) for q in kernel.inputs), tuple(outputs), limits)
