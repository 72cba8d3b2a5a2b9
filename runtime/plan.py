"""Build the C extension that calls kernels with little overhead, where Python and NumPy let us."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.errors import LoadError

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.toolchain import Toolchain

_MODULE = "kousoku_call"


@cache
def plan_type(toolchain: Toolchain) -> Callable[..., Any] | None:
    """Type ``Plan`` of ``_call.c``, None where it cannot be built.

    Without it the same checks run in Python, and ctypes does the calls: slower, with the same
    results and messages. It is built once for each version of Python and NumPy.
    """
    if sys.platform == "win32":  # linking against python3xx.lib is not worth the trouble
        return None
    headers = _headers()
    if headers is None:
        return None
    try:
        return _import(_build(toolchain, headers))
    except (LoadError, ImportError, OSError):
        return None


def _headers() -> tuple[str, ...] | None:
    """Folders of ``Python.h`` and ``numpy/arrayobject.h``, None if one is missing."""
    import sysconfig

    folders = (sysconfig.get_path("include"), np.get_include())
    names = ("Python.h", "numpy/arrayobject.h")
    is_complete = all((Path(f) / name).is_file() for f, name in zip(folders, names, strict=True))
    return folders if is_complete else None


def _build(toolchain: Toolchain, headers: tuple[str, ...]) -> Path:
    import sysconfig

    from kousoku.runtime.build import Source, build

    text = (Path(__file__).parent / "_call.c").read_bytes()
    built_for = f"/* {sys.version} {sysconfig.get_config_var('SOABI')} NumPy {np.__version__} */\n"
    flags = ("-std=c11", *(f"-I{folder}" for folder in headers))
    if sys.platform == "darwin":
        flags = (*flags, "-undefined", "dynamic_lookup")
    files = (("_call.c", text), ("built_for.h", built_for.encode()))
    return build(Source(_MODULE, files, flags), toolchain).path


def _import(path: Path) -> Callable[..., Any]:
    from importlib.machinery import ExtensionFileLoader
    from importlib.util import module_from_spec, spec_from_file_location

    loader = ExtensionFileLoader(_MODULE, str(path))
    spec = spec_from_file_location(_MODULE, path, loader=loader)
    if spec is None:
        raise ImportError(path)
    module = module_from_spec(spec)
    loader.exec_module(module)
    plan: Callable[..., Any] = module.Plan
    return plan
