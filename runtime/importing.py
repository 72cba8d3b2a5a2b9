"""Import modules of a generated folder from bytes whose digests were compared.

Python's own way reads the files again, and its cache of compiled modules goes by date and size.
"""

from __future__ import annotations

import hashlib
import sys
from importlib import import_module
from importlib.abc import InspectLoader, MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import TYPE_CHECKING

from kousoku.model.errors import LoadError

if TYPE_CHECKING:
    import types
    from collections.abc import Mapping, Sequence


class _Verified(MetaPathFinder, InspectLoader):
    """The sources of all folders that were imported, by the names of their modules."""

    def __init__(self) -> None:
        self.sources: dict[str, tuple[str, bytes]] = {}

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: types.ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find a module among the sources, and leave all others to Python."""
        if fullname not in self.sources:
            return None
        origin, _ = self.sources[fullname]
        spec = ModuleSpec(fullname, self, origin=origin, is_package=self.is_package(fullname))
        spec.has_location = True
        return spec

    def get_source(self, fullname: str) -> str:
        """Give the text of a module, also to a traceback."""
        return self.sources[fullname][1].decode()

    def is_package(self, fullname: str) -> bool:
        """Tell whether a module holds others."""
        return Path(self.sources[fullname][0]).name == "__init__.py"

    def exec_module(self, module: types.ModuleType) -> None:
        """Run a module."""
        origin, source = self.sources[module.__name__]
        exec(compile(source, origin, "exec", dont_inherit=True), module.__dict__)


_VERIFIED = _Verified()


def import_source(folder: Path, files: Mapping[str, bytes], name: str) -> types.ModuleType:
    """Import a module of a folder, and those of the folder that it imports.

    Parameters
    ----------
    folder : Path
        Where the files lie: they are not read again, tracebacks name them.
    files : mapping of str to bytes
        Path in the folder and content. The folder becomes a package of a name of its own, whose
        ``__init__.py`` is not run.
    name : str
        Path of the module in the folder, such as ``solver.py``.

    Returns
    -------
    module
        The same one for the same bytes, wherever they lie: tracebacks name the first folder.

    Raises
    ------
    LoadError
        The folder lacks a module, or its manifest does not list it.
    """
    sources = {path: data for path, data in files.items() if path.endswith(".py")}
    total = hashlib.sha256()
    for path, data in sources.items():
        total.update(b"%d %s%d " % (len(path), path.encode(), len(data)))
        total.update(data)
    top = f"kousoku_{folder.name.replace('.', '_')}_{total.hexdigest()[:16]}"
    modules = {top: (str(folder / "__init__.py"), b"")}
    for path, data in sources.items():
        parts = path.removesuffix(".py").split("/")
        if parts != ["__init__"]:
            dotted = ".".join((top, *parts)).removesuffix(".__init__")
            modules[dotted] = (str(folder / path), data)
    _VERIFIED.sources.update(modules)
    if _VERIFIED not in sys.meta_path:
        sys.meta_path.insert(0, _VERIFIED)
    try:
        return import_module(".".join((top, *name.removesuffix(".py").split("/"))))
    except ModuleNotFoundError as error:
        package, _, missed = (error.name or "").partition(".")
        if package != top:
            raise
        raise not_listed(folder, f"{missed.replace('.', '/')}.py") from None


def not_listed(folder: Path, name: str) -> LoadError:
    """Error of a folder whose manifest does not list a file that is wanted."""
    return LoadError(f"{folder}: {name} is wanted, and its manifest does not list it")
