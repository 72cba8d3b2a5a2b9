"""What is done with a solved motion: checks before, comparison and plots after."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np

from kousoku.closed_form import closed_form
from kousoku.model.errors import SolveError
from kousoku.runtime.tables import SUFFIXES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from kousoku.model.scene import Scene
    from kousoku.runtime.linkage import Trajectory


def check_destinations(
    out: Path | None, plot: Path | None, suffixes: Sequence[str] = SUFFIXES
) -> None:
    """Refuse places where nothing can be written, before anything is solved.

    Parameters
    ----------
    out, plot : Path, optional
        File and folder.
    suffixes : sequence of str
        How the name of the file may end.

    Raises
    ------
    SolveError
        A suffix is unknown, a folder is missing, or matplotlib is.
    """
    if out is not None:
        if out.suffix not in suffixes:
            wanted = " or ".join(suffixes)
            raise SolveError(f"--out {out}: the name must end in {wanted}")
        if out.is_dir():
            raise SolveError(f"--out {out}: is a folder, wanted a file")
        if not out.absolute().parent.is_dir():
            raise SolveError(f"--out {out}: no such folder; make it first")
    if plot is not None:
        if plot.exists() and not plot.is_dir():
            raise SolveError(f"--plot {plot}: is a file, wanted a folder")
        if find_spec("matplotlib") is None:
            raise SolveError("--plot needs matplotlib: pip install kousoku[plot]")


def node_to_show(scene: Scene, wanted: str | None) -> str:
    """Return the node to print and draw: the one that was asked for, or the last that moves.

    Raises
    ------
    SolveError
        The scene has no such node.
    """
    if wanted is None:
        return [name for name, node in scene.nodes.items() if not node.fixed][-1]
    if wanted not in scene.nodes:
        raise SolveError(f"--node {wanted}: the scene has {', '.join(scene.nodes)}")
    return wanted


def errors_of(scene: Scene, motion: Trajectory) -> dict[str, float] | None:
    """Return the largest distances from the closed form, None where there is none."""
    exact = closed_form(scene, motion.divisions, len(motion))
    if exact is None:
        return None
    pairs: dict[str, tuple[Mapping[str, np.ndarray], Mapping[str, np.ndarray]]] = {
        "position": (motion.positions, exact.positions),
        "velocity": (motion.velocities, exact.velocities),
        "acceleration": (motion.accelerations, exact.accelerations),
    }
    return {
        name: max(float(np.hypot(*(got[node] - wanted[node]).T).max()) for node in wanted)
        for name, (got, wanted) in pairs.items()
        if got
    }


def draw(motion: Trajectory, node: str, folder: Path) -> list[Path]:
    """Draw what figures 5, 7 and 8 of the paper show, and return the files."""
    from kousoku.plots import draw_motion, draw_vectors, save

    folder.mkdir(parents=True, exist_ok=True)
    symbol, alpha = next(iter(motion.inputs.items()))
    name, unit, path = motion.name, motion.unit, motion.positions[node]
    curves = [(f"position [{unit}]", path)]
    figures = {}
    place = len(motion) // 8
    links = [
        np.array([motion.positions[first][place], motion.positions[second][place]])
        for _, first, second, _ in motion.links
    ]
    for what, per, vectors in (
        ("velocity", "s", motion.velocities),
        ("acceleration", "s²", motion.accelerations),
    ):
        if vectors:
            curves.append((f"{what} [{unit}/{per}]", vectors[node]))
            title = f"{name}: {what} of {node}"
            figures[what] = draw_vectors(
                alpha, path, vectors[node], links=links, title=title, unit=unit, symbol=symbol
            )
    figures["motion"] = draw_motion(alpha, curves, title=f"{name}: {node}", symbol=symbol)
    files = []
    for what, figure in figures.items():
        files.append(folder / f"{name}_{node}_{what}.svg")
        save(figure, files[-1])
    return files
