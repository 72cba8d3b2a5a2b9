"""Plots of a motion of bodies over time: bodies, coordinates, energies.

Needs matplotlib (the extra ``plot``). The same numbers give the same bytes of SVG.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
from matplotlib.figure import Figure

from kousoku.plots import STYLE, save

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from kousoku.runtime.motion import Motion

    Array = NDArray[np.float64]
    Curves = Mapping[str, Array]

#: Bodies that are drawn when none is named.
MOST_BODIES = 12
AXES = ("x", "y", "z")


def draw_curves(time: Array, panels: Sequence[tuple[str, Curves]], *, title: str) -> Figure:
    """Draw curves over time, one panel above the other.

    Parameters
    ----------
    time : (n,) [s]
        The times.
    panels : sequence of (str, mapping of str to (n,))
        Label with unit, and the curves of a panel by name; the legend leaves out a name alone.
    title : str
        Printed above.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.5, 1.2 + 1.6 * len(panels)), layout="constrained")
        rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        for panel, (label, curves) in zip(rows, panels, strict=True):
            for name, values in curves.items():
                panel.plot(time, values, label=name)
            panel.set_ylabel(label)
            if len(curves) > 1:
                panel.legend(frameon=False, fontsize="small", ncols=min(len(curves), 3))
        rows[-1].set_xlabel("time [s]")
        figure.suptitle(title)
    return figure


def figures_of(motion: Motion, unit: str, bodies: Iterable[str]) -> dict[str, Figure]:
    """Return the figures of a motion by name.

    Parameters
    ----------
    motion : Motion
        What is drawn: each body in a figure, all coordinates in one, all energies in one.
    unit : str
        Length unit of the scene.
    bodies : iterable of str
        The bodies to draw.
    """
    found = {body: _body(motion, unit, body) for body in bodies}
    if motion.coordinate:
        values, rates = dict(motion.coordinate), dict(motion.coordinate_rate)
        panels = [(f"rad, {unit}", values), (f"rad/s, {unit}/s", rates)]
        if motion.coordinate_acceleration:
            panels.append((f"rad/s², {unit}/s²", dict(motion.coordinate_acceleration)))
        found["coordinates"] = draw_curves(
            motion.time, panels, title=f"{motion.name}: coordinates, their rates"
        )
    if motion.energy:
        energies = draw_curves(
            motion.time,
            [(f"kg {unit}²/s²", dict(motion.energy))]
            + ([(f"work [kg {unit}²/s²]", dict(motion.work))] if motion.work else []),
            title=f"{motion.name}: energies",
        )
        found["energies"] = energies
    return found


def _body(motion: Motion, unit: str, body: str) -> Figure:
    tables = (
        ("position", unit, motion.position),
        ("velocity", f"{unit}/s", motion.velocity),
        ("acceleration", f"{unit}/s²", motion.acceleration),
        ("ω′", "rad/s", motion.angular_velocity),
    )
    panels = [
        (f"{what} [{per}]", {axis: table[body][:, k] for k, axis in enumerate(AXES)})
        for what, per, table in tables
        if body in table
    ]
    return draw_curves(motion.time, panels, title=f"{motion.name}: {body}")


def draw_bodies(motion: Motion, unit: str, folder: Path, body: str | None = None) -> list[Path]:
    """Draw a motion into a folder, and return the files.

    Parameters
    ----------
    motion : Motion
        What is drawn.
    unit : str
        Length unit of the scene.
    folder : Path
        Where; it is made if there is none.
    body : str, optional
        The only body to draw; else the first :data:`MOST_BODIES`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    bodies = [*motion.position][:MOST_BODIES] if body is None else [body]
    files = []
    for what, figure in figures_of(motion, unit, bodies).items():
        files.append(folder / f"{motion.name}_{what}.svg")
        save(figure, files[-1])
    return files
