"""`load`: a generated folder becomes callables."""

from __future__ import annotations

import types
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from kousoku.model.errors import LoadError, NotInResultError
from kousoku.runtime.arguments import Signature
from kousoku.runtime.choice import choose
from kousoku.runtime.kernel import Kernel
from kousoku.runtime.notice import say_once
from kousoku.runtime.sources import Sources
from kousoku.runtime.targets import CTarget, NumpyTarget, lane_width, open_library

if TYPE_CHECKING:
    import ctypes
    from collections.abc import Callable, Mapping

    from kousoku.model.files.manifest import Manifest
    from kousoku.runtime.build import Built
    from kousoku.runtime.choice import ChosenTarget, Target
    from kousoku.runtime.toolchain import Toolchain

NUMPY_SOURCE, C_SOURCE, BATCH_SOURCE = "kernels.py", "kernels.c", "kernels_batch.c"
#: Header that batches of all packages include.
LANES = Path(__file__).with_name("lanes.h")


@dataclass(frozen=True, slots=True)
class Library:
    """The kernels of a generated package.

    ``library.constraint`` and ``library["constraint"]`` are the same `Kernel`.

    Parameters
    ----------
    folder : Path
        Folder of the package.
    manifest : Manifest
        Its manifest.
    target : {"c", "numpy"}
        Target that computes.
    kernels : mapping of str to Kernel
        In the order of the manifest.
    path : Path or None
        The shared library, None for NumPy.
    damage : str
        Damage of the library that lay in the cache before; ``""`` if there was none.
    files : mapping of str to bytes
        Name and content of the files: pickled, the library takes them along.
    """

    folder: Path
    manifest: Manifest
    target: Literal["c", "numpy"]  # as help() shows it
    kernels: Mapping[str, Kernel]
    path: Path | None = None
    damage: str = ""
    files: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    _handle: ctypes.CDLL | None = None

    def __getitem__(self, name: str) -> Kernel:
        """Kernel by its name."""
        try:
            return self.kernels[name]
        except KeyError:
            names = ", ".join(self.kernels)
            raise NotInResultError(
                f"{self.manifest.package} has no kernel {name!r}; it has {names}"
            ) from None

    def __getattr__(self, name: str) -> Kernel:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self[name]
        except KeyError as error:
            raise AttributeError(error.args[0]) from None

    def __dir__(self) -> list[str]:
        return [*object.__dir__(self), *self.kernels]

    def __reduce__(self) -> tuple[Any, ...]:
        # Function pointers do not travel; the other side loads the sources itself.
        return load_same, (Sources(self.folder, self.manifest, self.files), self.target)

    def function(self, name: str) -> Any:
        """Function that the shared library exports, any of them, as a ctypes function pointer.

        A solver package exports more than kernels; the caller sets ``restype`` and ``argtypes``
        from its header. Each call gives a new object, so that no two callers share those settings.

        Raises
        ------
        LoadError
            The target is NumPy, or the library exports no such function.
        """
        if self._handle is None:
            raise LoadError(f"{self.folder}: the target is NumPy, there is no C function {name!r}")
        try:
            return self._handle[name]
        except AttributeError:
            raise LoadError(f"{self.path} exports no function {name!r}") from None


def load(folder: str | Path, *, target: Target = "auto") -> Library:
    """Load a generated package.

    Parameters
    ----------
    folder : path
        A folder that the generator wrote, under ``generated/`` or anywhere else.
    target : {"auto", "c", "numpy"}
        ``"auto"`` takes C where a compiler can be had, and else NumPy after saying why
        in one line on the logger ``kousoku``.

    Raises
    ------
    LoadError
        The folder is not a generated package, a file of it was edited, or the shared library is
        not the package's.
    TargetError
        The folder was generated without this target.
    CompilerError
        The compiler refuses the source; with ``target="c"`` also if there is none.
    CacheError
        With ``target="c"``: neither the cache nor a temporary folder can be written.
    """
    sources = Sources.read(folder)
    return choose(
        target,
        sources,
        (C_SOURCE, lambda: _load_c(sources)),
        (NUMPY_SOURCE, lambda reason: _load_numpy(sources, reason)),
    )


def load_same(sources: Sources, target: ChosenTarget) -> Library:
    """Load a package with the target that another process had; NumPy where there is no compiler."""
    return load(sources.place(), target=target if target == "numpy" else "auto")


def _load_numpy(sources: Sources, reason: Exception | None) -> Library:
    if reason is not None:
        say_once(f"kousoku uses the NumPy kernels: {reason}")
    manifest, files = sources.manifest, sources.files
    module = sources.module(NUMPY_SOURCE)
    kernels = {}
    for k in manifest.kernels:
        signature = Signature(f"{manifest.package}.{k.name}", k.inputs, k.outputs)
        target = NumpyTarget(getattr(module, k.name), k)
        kernels[k.name] = Kernel(k, signature, target, target.call)
    return Library(sources.folder, manifest, "numpy", types.MappingProxyType(kernels), files=files)


def c_sources(files: Mapping[str, bytes]) -> tuple[tuple[str, bytes], ...]:
    """Sources of C among the files of a package, and the header that its batches include."""
    sources = tuple(item for item in files.items() if item[0].endswith((".c", ".h")))
    if BATCH_SOURCE in files and LANES.name not in files:
        sources += ((LANES.name, LANES.read_bytes()),)
    return sources


def compiled(sources: Sources, toolchain: Toolchain) -> tuple[ctypes.CDLL, Built]:
    """Build the sources of a package, or find them built, and open the library."""
    from kousoku.runtime.build import Source, build

    built = build(Source(sources.manifest.package, c_sources(sources.files)), toolchain)
    if built.damage:
        say_once(f"{built.damage}; it was built again")
    return open_library(built.path, sources.manifest), built


def _load_c(sources: Sources) -> Library:
    from kousoku.runtime.plan import plan_type
    from kousoku.runtime.toolchain import find_toolchain

    manifest, toolchain = sources.manifest, find_toolchain()
    handle, built = compiled(sources, toolchain)
    width = lane_width(handle, manifest.package)
    plan = plan_type(toolchain)
    kernels = {}
    for k in manifest.kernels:
        signature = Signature(f"{manifest.package}.{k.name}", k.inputs, k.outputs)
        target = CTarget(handle, f"kousoku_{manifest.package}_{k.name}", k, width)
        kernels[k.name] = Kernel(k, signature, target, _fast_call(plan, target, signature))
    return Library(
        sources.folder,
        manifest,
        "c",
        types.MappingProxyType(kernels),
        built.path,
        built.damage,
        sources.files,
        handle,
    )


def _fast_call(
    plan: Callable[..., Any] | None, target: CTarget, signature: Signature
) -> Callable[..., Any] | None:
    if plan is None:
        return None
    shapes = (tuple(q.shape for q in side) for side in (signature.inputs, signature.outputs))
    try:
        fast: Callable[..., Any] = plan(*target.addresses, *shapes)
    except ValueError:  # more arrays than a plan holds
        return None
    return fast
