"""The manifest of a generated package: what `emit` promises and `load` and `verify` check."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, dataclass, replace
from typing import Any

from kousoku.model.errors import LoadError, printable
from kousoku.model.files.jsontext import to_text
from kousoku.model.files.quantity import Quantity
from kousoku.model.version import __version__

MANIFEST_FORMAT = 2
#: Version of the interface of package and runtime: functions and records of C, rows, data files. It
#: is raised when an older package would not run with the newer runtime, or the other way round.
ABI = 4
#: Formats of reference values: of a kind, of a scene of nodes, of a scene of bodies.
REFERENCE_FORMATS = {"kind": 1, "linkage": 1, "dynamics": 4}
#: A file of a package: in its folder, or in one folder of that, such as ``integrate/memory.h``.
PLAIN = re.compile(r"(?=.{1,200}\Z)(?:[A-Za-z_]\w*/)?[A-Za-z_][\w-]*(?:\.\w+)+", re.ASCII)
#: Files of a folder: the manifest; the reference values, compressed as
#: :mod:`kousoku.model.files.compressed` does; of a scene the data about its bodies, or nodes.
MANIFEST_FILE = "manifest.json"
REFERENCE_FILE = "reference.json.gz"
MOTION_FILE = "motion.json"
#: The analysis that goes along with a linkage of nodes, and with nothing else.
LINKAGE_LIBRARY = "kinematics"


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
    known : tuple of (str, float)
        Outputs that are further off than the limit at a point that is known, and by how many units
        at most.
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
    known: tuple[tuple[str, float], ...] = ()

    @property
    def signature(self) -> str:
        """Names and sizes of the arrays, as the compiled kernel tells them: ``r[3] -> C[1]``."""
        inputs, outputs = (
            " ".join(f"{q.name}[{q.size}]" for q in side) for side in (self.inputs, self.outputs)
        )
        return f"{inputs} -> {outputs}".lstrip()


@dataclass(frozen=True, slots=True)
class Manifest:
    """Content of ``manifest.json``.

    Parameters
    ----------
    package, title, regenerate : str
        As in the package.
    version : str
        Version of kousoku that emitted it.
    digest : str
        SHA-256 over all that the manifest says but its files; sources name it, the compiled library
        exports it.
    inputs : tuple of (str, str)
        What it was made of, ``derivation`` or ``scene``, ``templates``, ``runtime``, and the
        beginning of the SHA-256 of each: ``generate --check`` says which changed.
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
    digest: str
    inputs: tuple[tuple[str, str], ...]
    files: tuple[tuple[str, str], ...]
    kernels: tuple[KernelManifest, ...]

    def stated(self) -> str:
        """SHA-256 over the manifest without files and digest: what the digest must be.

        Files have digests of their own, and those of a target may be left out.
        """
        import hashlib  # noqa: PLC0415 (an import of the runtime alone shall not pay for it)

        text = replace(self, digest="", files=()).to_json()
        return hashlib.sha256(text.encode()).hexdigest()

    def to_json(self) -> str:
        """Text of ``manifest.json``; the same manifest gives the same bytes."""
        return to_text({"format": MANIFEST_FORMAT, "abi": ABI, **asdict(self)})

    @classmethod
    def from_json(cls, text: str) -> Manifest:
        """Read what :meth:`to_json` wrote.

        Raises
        ------
        ValueError, KeyError, TypeError
            The text is not a manifest of this format.
        LoadError
            The package has another ABI than this version of kousoku.
        """
        data: dict[str, Any] = json.loads(text)
        if data.pop("format") != MANIFEST_FORMAT:
            raise ValueError(f"manifest format is not {MANIFEST_FORMAT}")
        if (abi := data.pop("abi", 0)) != ABI:
            package, version, command, their_abi = (
                printable(f"{entry:.100}")
                for entry in (data["package"], data["version"], data["regenerate"], str(abi))
            )
            raise LoadError(
                f"{package} was generated by kousoku {version} with ABI {their_abi}, and this is"
                f" kousoku {__version__} with ABI {ABI}; generate it again: {command}"
            )
        kernels = tuple(_kernel_from_json(kernel) for kernel in data.pop("kernels"))
        inputs, files = (_text_pairs(data.pop(key)) for key in ("inputs", "files"))
        return cls(inputs=inputs, files=files, kernels=kernels, **data)


def _text_pairs(pairs: Any) -> tuple[tuple[str, str], ...]:
    texts = tuple((name, digest) for name, digest in pairs)
    if not all(isinstance(text, str) for pair in texts for text in pair):
        raise TypeError("its inputs and files are not pairs of texts")
    return texts


def _kernel_from_json(data: dict[str, Any]) -> KernelManifest:
    def quantities(key: str) -> tuple[Quantity, ...]:
        return tuple(Quantity(**{**q, "shape": tuple(q["shape"])}) for q in data.pop(key))

    return KernelManifest(
        inputs=quantities("inputs"),
        outputs=quantities("outputs"),
        nonzero=tuple(tuple(indices) for indices in data.pop("nonzero")),
        operations=tuple((op, count) for op, count in data.pop("operations")),
        known=tuple((output, units) for output, units in data.pop("known")),
        **data,
    )
