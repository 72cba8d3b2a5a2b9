"""Plots of a run over time: coordinates, bodies, forces of joints, efforts of drivers, energies.

Needs matplotlib (the extra ``plot``). The same numbers give the same bytes of SVG.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np

from kousoku.model.errors import NotInResultError, SolveError
from kousoku.runtime.integrate.motion import BODY, COORDINATE, IN_METRES, JOINT, UNITS, Motion
from kousoku.runtime.messages import shown
from kousoku.view.plots import STYLE, Drawing, draw_linkage, save

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    from matplotlib.figure import Figure

    from kousoku.model.numbers.real import Array
    from kousoku.runtime.integrate.result import Result

#: Bodies and joints that are drawn where none is named.
MOST_PARTS = 12
#: Part of the largest number of its kind below which a curve is rounding.
CURVE_NOISE = 1e-9
#: Labels of axes, by table.
LABELS = {
    "positions": "position",
    "velocities": "velocity",
    "accelerations": "acceleration",
    "angular_velocity": "ω′",
    "angular_acceleration": "ω̇′",
    "orientation": "Euler parameters",
    "coordinate": "",
    "coordinate_rate": "",
    "coordinate_acceleration": "",
}
#: Names of components in a legend, by their count.
LETTERS = {3: ("x", "y", "z"), 2: ("x", "y"), 4: ("e0", "e1", "e2", "e3")}


@dataclass(frozen=True, slots=True)
class PlotPanel:
    """Curves that share an axis.

    Parameters
    ----------
    label : str
        Their quantity and unit.
    curves : mapping of str to (n,) array
        The curves by name.
    size : float
        The largest number of their kind in the run: what is far smaller is rounding.
    """

    label: str
    curves: Mapping[str, Array]
    size: float

    @property
    def is_noise(self) -> bool:
        """Whether there is nothing to see but rounding around zero."""
        return all(_largest(values) <= CURVE_NOISE * self.size for values in self.curves.values())


def plot(result: Result, *columns: str) -> Figure:
    """Draw columns of a run over time; forces in N, torques in N m, energies in J.

    Parameters
    ----------
    result : Result
        The run.
    *columns : str
        Columns, or bodies, joints, drivers or nodes, of which all is drawn; when left out, the
        coordinates and what drivers do, or the last body that moves.

    Raises
    ------
    NotInResultError
        There is no such column.
    SolveError
        What is given is no name, such as a list of them.
    """
    for name in columns:
        if not isinstance(name, str):
            raise SolveError(f"{result.name}: no column {shown(name)}; wanted names, one by one")
    main = (x for x in result.main_columns() if result.places[x].table != "inputs")
    names = list(columns) or [*main, *_efforts(result)]
    chosen = [x for name in names for x in result.columns_of(name)]
    if {*chosen} == {"time"}:
        raise SolveError(f"{result.name}: time is what columns are drawn over; name another column")
    return _figure(result, list(_panels(result, chosen, asked={*columns})))


def draw_into(
    result: Result, path: Path, *, columns: Sequence[str] | None = None, of: str | None = None
) -> list[Path]:
    """Draw a run into a file, or several plots into a folder; return the files.

    Parameters
    ----------
    result : Result
        The run.
    path : Path
        A picture such as ``run.png`` or ``run.svg``, or a folder, which is made if there is none.
    columns : sequence of str, optional
        What to draw, in one plot.
    of : str, optional
        The only body or node to draw.
    """
    if path.suffix and not path.is_dir():
        save(plot(result, *(columns or ([of] if of else []))), path)
        return [path]
    path.mkdir(parents=True, exist_ok=True)
    files = []
    for name, figure in figures_of(result, columns=columns, of=of).items():
        files.append(path / f"{result.name}_{name}.svg")
        save(figure, files[-1])
    return files


def figures_of(
    result: Result, *, columns: Sequence[str] | None = None, of: str | None = None
) -> dict[str, Figure]:
    """Figures of a run by name.

    Parameters
    ----------
    result : Result
        The run: of a scene of bodies each body and each joint whose forces are known has a figure,
        all coordinates, all drivers and all energies one; of a linkage a node has the three of the
        1981 paper.
    columns : sequence of str, optional
        What to draw, in one figure.
    of : str, optional
        The only body or node to draw.
    """
    if columns:
        return {"columns": plot(result, *columns)}
    if not isinstance(result, Motion):
        return draw_linkage(result, of)
    groups = {"coordinates": [x for x, place in result.places.items() if place.table in COORDINATE]}
    bodies = [of] if of else [*result.position]
    drivers = result.drivers if result.force else []
    joints = [name for name in result.force if name not in drivers]
    for name in (*bodies[:MOST_PARTS], *(joints[:MOST_PARTS] if of is None else [])):
        groups[name] = result.columns_of(name)
    groups["drivers"] = [x for name in drivers for x in result.columns_of(name)]
    groups["energies"] = [
        x for x, place in result.places.items() if place.table in {"energy", "work"}
    ]
    figures = {}
    for name, members in groups.items():
        title = name if name in bodies or name in joints else ""
        if panels := list(_panels(result, members, title)):
            figures[name] = _figure(result, panels, title)
    return figures


def _efforts(result: Result) -> list[str]:
    """Columns of forces of drivers, where they are known, without those that are zero."""
    if not (isinstance(result, Motion) and result.force):
        return []
    tables = {x: result.places[x].table for name in result.drivers for x in result.columns_of(name)}
    sizes = {x: max(map(_largest, getattr(result, x).values())) for x in tables.values()}
    return [x for x, table in tables.items() if _largest(result[x]) > CURVE_NOISE * sizes[table]]


def _panels(
    result: Result, columns: Iterable[str], title: str = "", asked: Collection[str] = ()
) -> Iterator[PlotPanel]:
    """Panels of columns: components of one vector share one, and columns of one unit.

    Labels leave out the body or joint that the title tells. Columns that are asked for one by one
    are drawn as they are, at rest too.
    """
    groups: dict[tuple[str, ...], list[str]] = {}
    for name in dict.fromkeys(columns):
        place = result.places[name]
        is_vector = place.table in BODY or place.table in JOINT or place.component is not None
        if name == "time":
            continue
        key = (place.table, place.owner if is_vector else "", place.unit)
        groups.setdefault(key, []).append(name)
    for (table, owner, written), names in groups.items():
        curves, label = _curves(result, table, owner, names), LABELS.get(table, table)
        is_asked = not {*names}.isdisjoint(asked)
        center = _center(result, owner, curves) if owner and table == "position" else {}
        if center and not is_asked:
            curves, label = center, "centre of mass"
        of = f"{owner}: " if owner and owner != title else ""
        label = label.replace("_", " ")
        if not owner and len(curves) == 1 and not label:
            label = next(iter(curves))
        text, unit, size = f"{of}{label}".strip(), written, _size(result, table, written)
        if isinstance(result, Motion) and table in IN_METRES:  # mm and cm have no newtons
            factor = result.layout.unit ** (2 if "u²" in UNITS[table] else 1)
            curves = {curve: factor * values for curve, values in curves.items()}
            unit, size = IN_METRES[table], factor * size
        panel = PlotPanel(f"{text} [{unit}]".strip(), curves, size)
        if is_asked or not panel.is_noise or len(groups) == 1:
            yield panel


def _curves(result: Result, table: str, owner: str, names: Sequence[str]) -> dict[str, Array]:
    """Curves of a panel by the distinctive part of their names."""
    if not owner:
        places = (result.places[name] for name in names)
        labels = [f"{place.owner or place.table}{COORDINATE.get(table, '')}" for place in places]
        return dict(zip(labels, map(result.__getitem__, names), strict=True))
    values = getattr(result, table)[owner]
    letters = LETTERS[values.shape[1]] if values.ndim > 1 else ("",)
    numbers = [result.places[name].component or 0 for name in names]
    return {letters[k]: result[name] for k, name in zip(numbers, names, strict=True)}


def _center(result: Result, body: str, origin: Mapping[str, Array]) -> dict[str, Array]:
    """Path of the centre of mass of a body whose origin rests, empty where it moves."""
    size = _size(result, "position", result.unit)
    if not isinstance(result, Motion) or any(
        np.ptp(x) > CURVE_NOISE * size for x in origin.values()
    ):
        return {}
    centers = result.center_of_mass(body)
    if centers is None or not (np.ptp(centers, axis=0) > CURVE_NOISE * size).any():
        return {}
    return {letter: centers[:, k] for k, letter in enumerate("xyz") if letter in origin}


def _size(result: Result, table: str, unit: str) -> float:
    """Largest number of a table in the whole run."""
    values = getattr(result, table)
    places = {name: place for name, place in result.places.items() if place.table == table}
    owners = {place.owner for place in places.values() if place.unit == unit}
    sizes = [_largest(values[owner]) for owner in owners if owner in values]
    size = max(sizes, default=0.0)
    if isinstance(result, Motion):
        size = max(size, _turning(result, table))
    return size or 1.0


def _turning(result: Motion, table: str) -> float:
    """Speed of a point that is a length of the scene beside the body that turns fastest."""
    length = result.reaction_length
    omega = max(map(_largest, result.angular_velocity.values()), default=0.0)
    alpha = max(map(_largest, result.angular_acceleration.values()), default=0.0)
    speeds = {"velocity": omega * length, "acceleration": (omega**2 + alpha) * length}
    return {"position": length, **speeds}.get(table, 0.0)


def _largest(values: Array) -> float:
    finite = values[np.isfinite(values)]
    return float(np.abs(finite).max()) if finite.size else 0.0


def _figure(result: Result, panels: Sequence[PlotPanel], title: str = "") -> Figure:
    """Draw panels one above the other."""
    x, below = _over(result)
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(6.0, 1.2 + 1.7 * len(panels)), layout="constrained")
        rows = figure.subplots(max(1, len(panels)), 1, sharex=True, squeeze=False)[:, 0]
        for axes, panel in zip(rows, panels, strict=False):
            for name, values in panel.curves.items():
                axes.plot(x, values, label=name)
            axes.set_ylabel(panel.label)
            low, high = axes.get_ylim()
            least = 1e-6 * panel.size
            if high - low < least:  # rounding is not spread over the whole height
                middle = 0.5 * (low + high)
                axes.set_ylim(middle - 0.1 * panel.size, middle + 0.1 * panel.size)
            if len(panel.curves) > 1 or next(iter(panel.curves)) not in panel.label:
                columns = min(len(panel.curves), 4)
                axes.legend(frameon=False, fontsize="small", ncols=columns, loc="upper right")
                axes.margins(y=0.15)
        rows[-1].set_xlabel(below)
        figure.suptitle(f"{result.name}: {title}" if title else result.name)
    return figure


def _over(result: Result) -> tuple[Array, str]:
    """Abscissa of curves: time, or the input of a linkage."""
    try:
        return result.time, "time [s]"
    except NotInResultError:
        name = next(iter(result.places))
        return result[name], f"{name} [{result.units[name]}]"
