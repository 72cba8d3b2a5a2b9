"""`verify`: recompute the reference values of a package on this machine.

Every kernel runs at every point of ``reference.json.gz`` in every way it can be called, with all
its outputs and with each output alone, and its error is told in the units that stand there.
Kernels that use only + − × ÷ √ and absolute values must also give the same bits in C and in NumPy.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kousoku.model.errors import LoadError, VerifyError
from kousoku.runtime.evaluate import different_bits, evaluate, ways
from kousoku.runtime.library import Library, load
from kousoku.runtime.reference import read_references
from kousoku.runtime.report import LIMIT, Report, Row
from kousoku.runtime.solver_verify import by_each_target
from kousoku.runtime.sources import Sources, folder_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from kousoku.model.files.manifest import KernelManifest
    from kousoku.runtime.choice import Target
    from kousoku.runtime.evaluate import EvaluatedOutput
    from kousoku.runtime.reference import Reference

__all__ = ["LIMIT", "Report", "Row", "verify"]


def verify(package: Library | str | Path, *, target: Target = "auto") -> Report:
    """Check that a package computes what was derived.

    Parameters
    ----------
    package : Library or path
        A loaded package, or its folder.
    target : {"auto", "c", "numpy"}
        What to check: all that this machine can run, or one target. A loaded package brings its
        own target; ``"auto"`` checks the other one beside it.

    Returns
    -------
    Report
        ``report.ok``; it does not raise for what is wrong with the package. ``report.check()``
        does.
    """
    from kousoku.runtime.dynamics_verify import BodiesCheck
    from kousoku.runtime.linkage_verify import LinkageCheck

    folder = package.folder if isinstance(package, Library) else folder_of(package)
    try:
        sources = Sources.read(folder)
        if sources.is_scene:
            check = LinkageCheck if sources.is_linkage else BodiesCheck
            return check(sources).verify(target)
        manifest = sources.manifest
        references = read_references(folder, manifest, sources.files)
    except (LoadError, VerifyError) as error:
        return Report(folder.name, str(folder), (), (str(error),))
    problems: list[str] = []
    notes: list[str] = []

    def loaded(choice: Target) -> Library:
        if isinstance(package, Library) and package.target == choice:
            return package
        return load(folder, target=choice)

    libraries = by_each_target(loaded, target, problems, notes)
    problems += [f"{library.damage}; it was built again" for library in libraries if library.damage]
    rows: list[Row] = []
    for kernel in manifest.kernels:
        reference = references[kernel.name]
        evaluations = [
            evaluation
            for library in libraries
            for way in ways(library.target)
            for evaluation in evaluate(library[kernel.name], reference, way)
        ]
        computed = list(rows_of(kernel, reference, evaluations))
        wrong = [str(row) for row in computed if not row.ok]
        rows += computed
        problems += wrong
        # Where a value is wrong, its bits are no news.
        if kernel.is_exact and not wrong:
            problems += different_bits(kernel, reference, evaluations)
    return Report(manifest.package, str(folder), tuple(rows), tuple(problems), tuple(notes))


def rows_of(
    kernel: KernelManifest, reference: Reference, evaluations: Sequence[EvaluatedOutput]
) -> Iterator[Row]:
    """Worst error of each output in each way of calling."""
    for way in dict.fromkeys(evaluation.way for evaluation in evaluations):
        for k in range(len(kernel.outputs)):
            candidates = [e for e in evaluations if e.way == way and e.output == k]
            limits = reference.limits_of(kernel.outputs[k].name)
            for limit in dict.fromkeys(limits.tolist() if candidates else ()):
                is_here = limits == limit
                rows = (_row(kernel, reference, candidate, is_here) for candidate in candidates)
                yield replace(max(rows, key=lambda row: row.worst), limit=limit)


def _row(
    kernel: KernelManifest,
    reference: Reference,
    evaluation: EvaluatedOutput,
    is_here: NDArray[np.bool_],
) -> Row:
    """Worst error at the points of a mask."""
    expected = reference.outputs[evaluation.output]
    errors = expected.errors(evaluation.values)
    errors[~np.resize(is_here, len(errors))] = 0.0
    row, element = np.unravel_index(int(np.argmax(errors)), errors.shape)
    point = int(row) % len(reference.labels)
    output = kernel.outputs[evaluation.output]
    index = np.unravel_index(int(element), output.shape) if output.shape else ()
    return Row(
        kernel=kernel.name,
        output=output.name,
        way=evaluation.way,
        worst=float(errors[row, element]),
        element=tuple(int(k) for k in index),
        point=point,
        label=reference.labels[point],
        inputs=reference.inputs_at(point, kernel),
        got=float(evaluation.values[row, element]),
        wanted=float(expected.high[point, element]),
    )
