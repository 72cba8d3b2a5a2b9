"""Emission of a package of kernels as a folder of text, the same bytes on every machine."""

from __future__ import annotations

import hashlib
from dataclasses import astuple, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from jinja2 import Environment, PackageLoader, StrictUndefined

from kousoku.codegen.context import package_context
from kousoku.codegen.context_lines import c_call, python_lines
from kousoku.codegen.known_errors import known_errors
from kousoku.model.files.manifest import ABI, MANIFEST_FILE, KernelManifest, Manifest
from kousoku.model.version import __version__

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.operations.kernel import Kernel, Package

    Inputs = tuple[tuple[str, str], ...]

#: File of the generated folder, and its template.
FILES = {
    "__init__.py": "numpy/__init__.py.jinja",
    "kernels.py": "numpy/kernels.py.jinja",
    "kernels.c": "c/kernels.c.jinja",
    "kernels_batch.c": "c/kernels_batch.c.jinja",
    "expressions.h": "c/expressions.h.jinja",
    "kernels.h": "c/kernels.h.jinja",
}


#: Files of the runtime that need nothing else of it: a copy goes along, so that a folder that alone
#: is copied out works on NumPy, and its batches compile.
LIBRARIES = ("batch_numpy.py", "lanes.h")
#: Module that composes messages: a copy goes along with solvers of scenes.
MESSAGES = "messages.py"
#: Paths of copies of files of ``model``, and names of these.
OF_MODEL = {"integrate/angles.py": "angles.py"}
_TEMPLATES = PackageLoader("kousoku.codegen")
_ROOT = Path(__file__).parents[1]
_RUNTIME = _ROOT / "runtime"


@cache
def environment() -> Environment:
    """Environment in which templates are read and filled; each is parsed once a process."""
    templates = Environment(
        loader=_TEMPLATES,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    templates.globals.update(c_call=c_call, python_lines=python_lines, abi=ABI)
    return templates


def runtime_sources(*names: str) -> dict[str, str]:
    """Plain sources of the runtime that go along with generated solvers.

    Parameters
    ----------
    *names : str
        Files, such as ``batch_numpy.py``, and folders, such as ``integrate``: their C headers and
        Python modules, and files of ``model`` that they use.

    Returns
    -------
    dict of str to str
        Path in the generated folder and text, in order.
    """
    texts = {}
    for name in names:
        source = _RUNTIME / name
        for path in sorted(source.iterdir()) if source.is_dir() else [source]:
            if path.suffix in {".h", ".py"}:
                text = path.read_text(encoding="utf-8")
                texts[path.relative_to(_RUNTIME).as_posix()] = text
        for copy, original in OF_MODEL.items():
            if copy.startswith(f"{name}/"):
                texts[copy] = (_ROOT / "model" / original).read_text(encoding="utf-8")
    return texts


def runtime_source(name: str) -> tuple[str, str]:
    """Path and text of one of :func:`runtime_sources`; the text of another file is empty."""
    path = _ROOT / "model" / OF_MODEL[name] if name in OF_MODEL else _RUNTIME / name
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    return path.relative_to(_ROOT).as_posix(), text


def emit(package: Package, data: Mapping[str, str]) -> dict[str, str]:
    """Folder of a package.

    Parameters
    ----------
    package : Package
        The kernels.
    data : mapping of str to str
        File name and text of the files of the folder beside the code.

    Returns
    -------
    dict of str to str
        File name and text, the manifest last.

    Raises
    ------
    EmitError
        A name is no identifier, or an operation cannot be printed.
    """
    templates = environment()
    promised = promise(package, inputs_of(package))
    context = package_context(package, __version__, promised.digest)
    files = {
        name: templates.get_template(path).render(package=context) for name, path in FILES.items()
    }
    files |= runtime_sources(*LIBRARIES) | dict(sorted(data.items()))
    return with_manifest(files, promised)


def inputs_of(package: Package) -> Inputs:
    """SHA-256 of all inputs of a package: graphs, templates, plain source."""
    return hashed(
        derivation=repr((astuple(package), None)),
        templates=templates_in("_macros", "c/", "numpy/"),
        runtime=repr(runtime_sources(*LIBRARIES)),
    )


def hashed(**parts: str) -> Inputs:
    """Digests of the inputs of a package: the beginning of each SHA-256."""
    return tuple((name, sha256(text)[:16]) for name, text in parts.items())


def templates_in(*folders: str) -> str:
    """Names and texts of all templates of some folders, as digests count them."""
    names = [name for name in sorted(_TEMPLATES.list_templates()) if name.startswith(folders)]
    texts = [_TEMPLATES.get_source(environment(), name)[0] for name in names]
    return "".join(f"\n{name}\n{text}" for name, text in zip(names, texts, strict=True))


def promise(package: Package, inputs: Inputs) -> Manifest:
    """Manifest of a package before its files are there.

    Parameters
    ----------
    package : Package
        The kernels.
    inputs : tuple of (str, str)
        Digests of the inputs of the text: :func:`hashed`.

    Returns
    -------
    Manifest
        Without files. Its digest goes into the sources, so that they cannot say anything else.
    """
    manifest = Manifest(
        package=package.name,
        title=package.title,
        regenerate=package.regenerate,
        version=__version__,
        digest="",
        inputs=inputs,
        files=(),
        kernels=tuple(_kernel_manifest(package, kernel) for kernel in package.kernels),
    )
    return replace(manifest, digest=manifest.stated())


def with_manifest(files: Mapping[str, str], promised: Manifest) -> dict[str, str]:
    """Folder with its manifest, which lists all other files, at the end."""
    listed = tuple((name, sha256(text)) for name, text in files.items())
    return {**files, MANIFEST_FILE: replace(promised, files=listed).to_json()}


def _kernel_manifest(package: Package, kernel: Kernel) -> KernelManifest:
    return KernelManifest(
        name=kernel.name,
        title=kernel.title,
        formula=kernel.formula,
        source=kernel.source,
        inputs=kernel.inputs,
        outputs=kernel.outputs,
        nonzero=tuple(kernel.nonzero(k) for k in range(len(kernel.outputs))),
        is_exact=kernel.is_exact,
        operations=tuple(sorted((op.value, count) for op, count in kernel.operations.items())),
        known=tuple(
            known for error in known_errors(package, kernel.name) for known in error.units.items()
        ),
    )


def sha256(text: str) -> str:
    """SHA-256 of a text."""
    return hashlib.sha256(text.encode()).hexdigest()
