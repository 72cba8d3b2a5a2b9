"""kousoku: small, fast, verified solvers of mechanisms with closed loops.

>>> import kousoku as ks
>>> loop = ks.load("scenes/loop_free.toml")
>>> run = loop.simulate(2, parameters={"mass": 2})
>>> run["crank_angle"], run.joint("a").force, run.ledger
>>> run.animate("loop.html")

``derive`` shows how a constraint is derived, ``kinds`` holds the verified kernels, ``catalog``
lists what scenes may have, ``verify`` recomputes 50-digit references on this machine, ``ledger``
has every equation of the lectures with its verdict.
"""

from importlib import import_module
from pathlib import Path as _Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kousoku import ledger
    from kousoku.cataloging import catalog
    from kousoku.checking import explain, verify
    from kousoku.committed import kinds
    from kousoku.deriving import body, derive, kernels, number
    from kousoku.loading import load
    from kousoku.mechanism import Mechanism
    from kousoku.model.errors import (
        AssemblyError,
        CompilerError,
        KousokuError,
        MotionError,
        SceneError,
        SolveError,
    )
    from kousoku.model.reading.builder import SceneBuilder
    from kousoku.model.records.scene import Scene
    from kousoku.runtime.integrate.result import Result
    from kousoku.runtime.run import Interrupted, Run
    from kousoku.runtime.saved import SavedRun
    from kousoku.saved import open_run

# A checkout without links (core.symlinks=false) has text files in their place, and the folders of
# the sub-packages beside this one.
if _Path(__file__).with_name("model").is_file():
    __path__.append(str(_Path(__file__).parents[1]))

from kousoku.model.version import __version__

#: The public names, and the modules that have them: each is imported when it is asked for.
_MODULES = {
    "load": "loading",
    "body": "deriving",
    "catalog": "cataloging",
    "derive": "deriving",
    "kernels": "deriving",
    "kinds": "committed",
    "number": "deriving",
    "explain": "checking",
    "ledger": "ledger",
    "verify": "checking",
    "Mechanism": "mechanism",
    "open_run": "saved",
    "Result": "runtime.integrate.result",
    "Scene": "model.records.scene",
    "SceneBuilder": "model.reading.builder",
    "Run": "runtime.run",
    "SavedRun": "runtime.saved",
    "Interrupted": "runtime.run",
    "AssemblyError": "model.errors",
    "CompilerError": "model.errors",
    "KousokuError": "model.errors",
    "MotionError": "model.errors",
    "SceneError": "model.errors",
    "SolveError": "model.errors",
}

__all__ = [
    "AssemblyError",
    "CompilerError",
    "Interrupted",
    "KousokuError",
    "Mechanism",
    "MotionError",
    "Result",
    "Run",
    "SavedRun",
    "Scene",
    "SceneBuilder",
    "SceneError",
    "SolveError",
    "__version__",
    "body",
    "catalog",
    "derive",
    "explain",
    "kernels",
    "kinds",
    "ledger",
    "load",
    "number",
    "open_run",
    "verify",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is asked for: NumPy alone is needed until then."""
    if name not in _MODULES:
        raise AttributeError(f"module 'kousoku' has no attribute {name!r}")
    module = import_module(f"kousoku.{_MODULES[name]}")
    value = module if name == _MODULES[name] else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    # Completions offer the door alone, and not the sub-packages that a use of it imports.
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})
