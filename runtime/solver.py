"""The solver of a scene, of bodies or of nodes: a folder is opened, whichever it was made from."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.runtime.sources import Sources

if TYPE_CHECKING:
    from pathlib import Path

    from kousoku.runtime.choice import Target
    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.linkage import LinkageSolver

    #: What both have: ``name``, ``target`` with its ``name`` and ``sources``, ``parameters``,
    #: ``counts``, ``in_time``, ``along_inputs``, and ``of_bodies`` for what bodies alone have.
    Solver = DynamicsSolver | LinkageSolver


def load_solver(folder: str | Path, *, target: Target = "auto") -> Solver:
    """Load the folder that was generated from a scene.

    Parameters
    ----------
    folder : path
        A folder that the generator wrote.
    target : {"auto", "c", "numpy"}
        ``"auto"`` takes C where a compiler can be had, and else NumPy after saying why
        in one line on the logger ``kousoku``.

    Raises
    ------
    LoadError, CompilerError, CacheError
        As of :func:`kousoku.runtime.dynamics.load_dynamics`.
    """
    sources = Sources.read(folder)
    if sources.is_linkage:
        from kousoku.runtime.linkage import open_linkage

        return open_linkage(sources, target)
    from kousoku.runtime.dynamics import open_dynamics

    return open_dynamics(sources, target)
