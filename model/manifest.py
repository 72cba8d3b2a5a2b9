"""The manifest of a generated package: what `emit` promises and `load` and `verify` check."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from typing import Any

from kousoku.model.jsontext import to_text
from kousoku.model.quantity import Quantity

FORMAT = 2
#: File of the reference values, compressed as :mod:`kousoku.model.compressed` does.
REFERENCE_FILE = "reference.json.gz"


@dataclass(frozen=True, slots=True)
class KernelManifest:
    """The signature of one kernel.

    Parameters
    ----------
    name, title, formula, source : str
        As in the derivation.
    inputs, outputs : tuple of Quantity
        In the order of the arguments.
    nonzero : tuple of tuple of int
        For each output the flat indices of the elements that are not identically zero.
    is_exact : bool
        Whether every target must give the same bits (only + − × ÷ √).
    operations : tuple of (str, int)
        Count of each operation that runs when all outputs are asked for.
    """

    name: str
    title: str
    formula: str
    source: str
    inputs: tuple[Quantity, ...]
    outputs: tuple[Quantity, ...]
    nonzero: tuple[tuple[int, ...], ...]
    is_exact: bool
    operations: tuple[tuple[str, int], ...]

    @property
    def signature(self) -> str:
        """Names and sizes of the arrays, as the compiled kernel tells them: ``r[3] -> C[1]``."""
        inputs, outputs = (
            " ".join(f"{q.name}[{q.size}]" for q in side) for side in (self.inputs, self.outputs)
        )
        return f"{inputs} -> {outputs}".lstrip()


@dataclass(frozen=True, slots=True)
class Manifest:
    """What stands in ``manifest.json``.

    Parameters
    ----------
    package, title, regenerate : str
        As in the package.
    version : str
        Version of kousoku that emitted it.
    origin : str
        SHA-256 over graphs, templates and version.
    digest : str
        SHA-256 over all that the manifest says but its files; sources name it, the compiled library
        exports it.
    files : tuple of (str, str)
        File name and SHA-256 of its content, the manifest itself left out. What is kept compressed
        counts as it is before.
    kernels : tuple of KernelManifest
        In the order of the text.
    """

    package: str
    title: str
    regenerate: str
    version: str
    origin: str
    digest: str
    files: tuple[tuple[str, str], ...]
    kernels: tuple[KernelManifest, ...]

    def stated(self) -> str:
        """Return the SHA-256 over all that is said but files and digest: what the digest must be.

        Files have digests of their own, and those of a target may be left out.
        """
        import hashlib  # noqa: PLC0415 (an import of the runtime alone shall not pay for it)

        said = replace(self, digest="", files=()).to_json()
        return hashlib.sha256(said.encode()).hexdigest()

    def to_json(self) -> str:
        """Return the text of ``manifest.json``; the same manifest gives the same bytes."""
        return to_text({"format": FORMAT, **asdict(self)})

    @classmethod
    def from_json(cls, text: str) -> Manifest:
        """Read what :meth:`to_json` wrote.

        Raises
        ------
        ValueError, KeyError, TypeError
            The text is not a manifest of this format.
        """
        data: dict[str, Any] = json.loads(text)
        if data.pop("format") != FORMAT:
            raise ValueError(f"manifest format is not {FORMAT}")
        kernels = tuple(_kernel_from_json(kernel) for kernel in data.pop("kernels"))
        files = tuple((name, digest) for name, digest in data.pop("files"))
        return cls(files=files, kernels=kernels, **data)


def _kernel_from_json(data: dict[str, Any]) -> KernelManifest:
    def quantities(key: str) -> tuple[Quantity, ...]:
        return tuple(Quantity(**{**q, "shape": tuple(q["shape"])}) for q in data.pop(key))

    return KernelManifest(
        inputs=quantities("inputs"),
        outputs=quantities("outputs"),
        nonzero=tuple(tuple(indices) for indices in data.pop("nonzero")),
        operations=tuple((op, count) for op, count in data.pop("operations")),
        **data,
    )
