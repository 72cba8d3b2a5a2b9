"""The solver of a scene, of bodies or of nodes: a folder is opened, whichever it was made from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from kousoku.runtime.sources import Sources

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from kousoku.runtime.choice import Target
    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.integrate.motion import Motion
    from kousoku.runtime.kinematics.trajectory import Trajectory


class LoadedTarget(Protocol):
    """Target that computes."""

    @property
    def name(self) -> str:
        """Its language, ``c`` or ``numpy``."""


class Solver(Protocol):
    """The solver of a scene, whether of bodies or of nodes.

    :class:`kousoku.runtime.dynamics.DynamicsSolver` is one, and
    :class:`kousoku.runtime.linkage.LinkageSolver`.
    """

    @property
    def name(self) -> str:
        """The scene."""

    @property
    def target(self) -> LoadedTarget:
        """Target that computes."""

    @property
    def sources(self) -> Sources:
        """The generated files."""

    @property
    def parameters(self) -> tuple[tuple[str, float], ...]:
        """Parameters that a run may change, and their values in the scene."""

    @property
    def counts(self) -> tuple[tuple[int, str, str], ...]:
        """Counts of the elements of a scene: number, noun, and its plural."""

    def in_time(self, **options: Any) -> Motion | Trajectory:
        """Motion in time."""

    def along_inputs(
        self, times: Callable[[int | None], Sequence[float]], options: Mapping[str, Any]
    ) -> Motion | Trajectory:
        """Motion at the divisions of the inputs.

        Parameters
        ----------
        times : callable
            Returns when the inputs are at their divisions, given how many these are.
        options : mapping
            Options of this kind of solver.
        """

    def of_bodies(self, what: str) -> DynamicsSolver:
        """Solver of bodies, for what bodies alone have; a linkage refuses, and says why."""


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
