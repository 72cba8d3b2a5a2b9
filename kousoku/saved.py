"""Saved runs: a file of columns, and of the mechanism and settings, to be opened again."""

from __future__ import annotations

import zipfile
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from kousoku.model.errors import SolveError, printable
from kousoku.runtime.integrate.events import EventLog
from kousoku.runtime.integrate.motion import Layout, Motion
from kousoku.runtime.kinematics.trajectory import NODE, TABLES, Trajectory, named_tables
from kousoku.runtime.messages import shown
from kousoku.runtime.saved import digest_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from kousoku.model.numbers.real import Array
    from kousoku.model.records.scene import Scene
    from kousoku.runtime.integrate.result import Result

#: Begins the names of arrays that are no columns: no part of a scene has a name with it.
OWN = "kousoku/"
#: Version of the format; the second has a digest of the content.
RESULT_FORMAT = 2
#: Characters of a reason that a message shows.
LONGEST_REASON = 160
#: Fields of a linkage that are kept beside its tables.
OF_LINKAGES = ("name", "unit", "method", "divisions", "target", "is_in_time", "links")


class FileFormat(msgspec.Struct, kw_only=True):
    """Format of a file, its first field.

    Parameters
    ----------
    format : int
        Its number.
    """

    format: int = RESULT_FORMAT


class KeptMotion(FileFormat, tag="bodies", kw_only=True):
    """Run of bodies in a file; its rows stand beside it.

    Parameters
    ----------
    scene : str
        As TOML.
    layout : Layout
        Columns of a row.
    method, target : str
        Its method, and the target that computed.
    is_complete : bool
        Whether all times are there.
    parameters : dict of str to float
        Those of the run.
    ledger, figures : str, dict
        Text of the ledger, and its numbers by name.
    counts : tuple of int
        Count of each event.
    trust, trust_figures : str, dict
        Text of the verdict, and its numbers by name.
    """

    scene: str
    layout: Layout
    method: str
    target: str
    is_complete: bool
    parameters: dict[str, float]
    ledger: str
    figures: dict[str, Any]
    counts: tuple[int, ...]
    trust: str
    trust_figures: dict[str, Any]


class KeptTrajectory(FileFormat, tag="nodes", kw_only=True):
    """Run of a linkage in a file; its tables stand beside it.

    Parameters
    ----------
    scene : str
        As TOML.
    name, unit, method, divisions, target, is_in_time, links, input_units
        As in :class:`Trajectory`.
    parts : dict of str to list of str
        Names of the columns of each table.
    """

    scene: str
    name: str
    unit: str
    method: str
    divisions: int
    target: str
    is_in_time: bool
    links: tuple[tuple[str, str, str, float], ...]
    input_units: dict[str, str]
    parts: dict[str, list[str]]


class MovedScene:
    """Scene of a run that was opened, to draw it.

    Parameters
    ----------
    text : str
        The scene as TOML.
    parts : sequence of str
        Bodies or nodes that the run has.
    """

    def __init__(self, text: str, parts: Sequence[str]) -> None:
        self.text, self._parts = text, list(parts)

    @cached_property
    def scene(self) -> Scene:
        """The scene.

        Raises
        ------
        SolveError
            It is not the one that moved.
        """
        from kousoku.model.reading.read import scene_from_toml

        scene = scene_from_toml(self.text, file="the scene in the run")
        if self._parts != [*(scene.bodies if scene.is_spatial else scene.nodes)]:
            raise SolveError(f"{scene.name}: the scene that was kept is not the one that moved")
        return scene


class KeptFigures:
    """Ledger or verdict of a run that was opened: its text, and its numbers by name.

    Parameters
    ----------
    text : str
        Its text.
    figures : mapping
        Its numbers by name, those that are not finite None.
    """

    #: Its name in messages.
    NAME = "verdict"

    def __init__(self, text: str, figures: Mapping[str, Any]) -> None:
        self._text, self._figures = text, dict(figures)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in self._figures:
            raise AttributeError(f"the {self.NAME} that was kept has no {name!r}")
        return self._figures[name]

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self._text.partition(chr(10))[0]}; print() shows all>"

    def as_data(self) -> dict[str, Any]:
        """Numbers of the run, ready for JSON."""
        return dict(self._figures)


class KeptLedger(KeptFigures):
    """Ledger of a run that was opened, with its verdict.

    Parameters
    ----------
    text, figures
        As in :class:`KeptFigures`.
    trust : KeptFigures
        The verdict.
    """

    NAME = "ledger"

    def __init__(self, text: str, figures: Mapping[str, Any], trust: KeptFigures) -> None:
        super().__init__(text, figures)
        self.trust = trust


def arrays_of(result: Result) -> dict[str, Any]:
    """Arrays that a file of columns holds beside them, so that it can be opened."""
    about: FileFormat
    arrays: dict[str, Any] = {}
    if isinstance(result, Motion):
        arrays |= {"rows": result.rows, "events": result.told.rows}
        about = KeptMotion(
            scene=result.mechanism.text,
            layout=result.layout,
            method=result.method,
            target=result.target,
            is_complete=result.is_complete,
            parameters=dict(result.parameters),
            ledger=str(result.ledger),
            figures=result.ledger.as_data(),
            counts=result.told.counts,
            trust=str(result.ledger.trust),
            trust_figures=result.ledger.trust.as_data(),
        )
    else:
        assert isinstance(result, Trajectory)
        counted = ("iterations", "residual", "condition")
        arrays |= {name: getattr(result, name) for name in counted}
        if result.times is not None:
            arrays["times"] = result.times
        parts = {table: [*getattr(result, table)] for table in TABLES if getattr(result, table)}
        for table in parts:
            arrays[table] = np.stack([*getattr(result, table).values()], axis=1)
        about = KeptTrajectory(
            scene=result.mechanism.text,
            input_units=dict(result.input_units),
            parts=parts,
            **{name: getattr(result, name) for name in OF_LINKAGES},
        )
    arrays["about"] = np.array(msgspec.json.encode(about).decode())
    arrays["digest"] = np.array(digest_of(arrays))
    return {f"{OWN}{name}": values for name, values in arrays.items()}


def open_run(path: str | Path) -> Result:
    """Open a run that ``run.save("run.npz")`` kept: to read, to plot and to animate it.

    Parameters
    ----------
    path : path
        A ``.npz`` file.

    Returns
    -------
    Result
        As it was; its ledger has text and numbers.

    Raises
    ------
    SolveError
        There is no such file, or no run was saved in it.
    """
    name = printable(str(path)) if isinstance(path, str | Path) else shown(path)
    try:
        arrays = _arrays_in(Path(path))
        text = str(arrays["about"])
        number = msgspec.json.decode(text, type=FileFormat).format
        if number != RESULT_FORMAT:
            raise ValueError(
                f"its format is {number}, this kousoku reads {RESULT_FORMAT}; make the run again"
                " and save it, or read its columns with numpy.load"
            )
        if str(arrays.pop("digest")) != digest_of(arrays):
            raise ValueError("its content is not what was saved, as its digest tells")
        about = msgspec.json.decode(text, type=KeptMotion | KeptTrajectory)
        if isinstance(about, KeptMotion):
            return _motion(about, arrays)
        return _trajectory(about, arrays)
    except OSError as error:
        raise SolveError(f"{name}: cannot be read: {error.strerror or error}") from None
    except Exception as error:  # a damaged file makes its readers raise whatever there is
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:LONGEST_REASON]
        raise SolveError(
            f'{name}: holds no run ({reason}); wanted a file that run.save("….npz") wrote'
        ) from None


def _arrays_in(path: Path) -> dict[str, Any]:
    """Arrays of a file that are no columns; those that were cut off are missed."""
    arrays = {}
    with zipfile.ZipFile(path) as archive:
        for entry in archive.namelist():
            name = entry.removesuffix(".npy")
            if name.startswith(OWN):
                if archive.getinfo(entry).compress_type != zipfile.ZIP_STORED:
                    raise ValueError("it is compressed, and may be larger than any memory")
                with archive.open(entry) as file:
                    values = np.lib.format.read_array(file, allow_pickle=False)
                values.flags.writeable = False  # results share it
                arrays[name.removeprefix(OWN)] = values
    if "about" not in arrays:
        raise ValueError("nothing says what its columns belong to")
    return arrays


def _motion(about: KeptMotion, arrays: Mapping[str, Array]) -> Motion:
    layout, sizes = about.layout, about.layout.sizes
    if [*sizes][:3] != ["t", "q", "v"] or sizes["t"] != 1 or min(sizes.values()) < 0:
        raise ValueError("its rows do not begin with t, q and v")
    rows = _checked(arrays, "rows", (None, sum(sizes.values())), 1 + sizes["q"] + sizes["v"])
    if (np.diff(rows[:, 0]) < 0.0).any():
        raise ValueError("its times do not ascend")
    _require_places(layout)
    events = _checked(arrays, "events", (None, 1 + rows.shape[1]), 1)
    count = len(layout.events)
    if len(about.counts) != count or not np.isin(events[:, 0], range(count)).all():
        raise ValueError("what it says of its events is not so")
    motion = Motion(
        layout,
        rows,
        target=about.target,
        method=about.method,
        ledger=KeptLedger(
            about.ledger,
            about.figures,
            KeptFigures(about.trust, about.trust_figures),
        ),
        parameters=about.parameters,
        is_complete=about.is_complete,
        told=EventLog(about.counts, events),
    )
    motion.mechanism = MovedScene(about.scene, [body.name for body in layout.bodies])
    return motion


def _require_places(layout: Layout) -> None:
    """Refuse a layout that leads out of its rows.

    Raises
    ------
    ValueError
        It does.
    """
    sizes = {"v_dot": layout.sizes["v"], "energies": 2, "coordinates": 0, "reactions": 0}
    sizes |= layout.sizes
    is_right = sizes["v_dot"] == sizes["v"] and sizes["energies"] == 2

    def inside(field: str, positions: Iterable[float], *lengths: int, least: int = 0) -> bool:
        indices = [*positions]
        variable = [index for index in indices if isinstance(index, int)]
        return len(indices) in lengths and all(least <= x < sizes[field] for x in variable)

    for body in layout.bodies:
        turns = 4 * bool(body.p), 3 * bool(body.p)
        is_right &= inside("q", body.r, 3) and inside("q", body.p, turns[0])
        is_right &= inside("v", body.v, 3) and inside("v", body.omega_b, turns[1])
        is_right &= (len(body.origin_b), len(body.axes_b)) == (3, 4)
    for joint in layout.reactions:
        is_right &= inside("reactions", joint.columns, 6, least=-1) and len(joint.point_b) == 3
        is_right &= 0 <= joint.body < len(layout.bodies) and -1 <= joint.j < len(layout.bodies)
    for _, _, columns in layout.coordinates if sizes["coordinates"] else ():
        is_right &= inside("coordinates", columns, 2, 3)
    is_right &= all(inside("q", [index], 1) for _, index in layout.works)
    if not (is_right and 0.0 < layout.unit < np.inf and 0.0 < layout.length < np.inf):
        raise ValueError("what it says of its rows is not so")


def _trajectory(about: KeptTrajectory, arrays: Mapping[str, Any]) -> Trajectory:
    rows = len(_checked(arrays, "residual", (None,), None))
    iterations = arrays["iterations"]
    if iterations.shape != (rows,) or iterations.dtype.kind != "i" or (iterations < 0).any():
        raise ValueError(f"iterations: wanted {rows} counts")
    times = _checked(arrays, "times", (rows,), None) if "times" in arrays else None
    columns = {}
    for table in TABLES:
        if names := about.parts.get(table):
            shape = (rows, len(names), *(2,) * (table in {name for name, *_ in NODE}))
            finite = None if table in {"inputs", "positions"} else 0
            columns[table] = names, _checked(arrays, table, shape, finite)
    trajectory = Trajectory(
        input_units=about.input_units,
        times=times,
        iterations=iterations,
        residual=arrays["residual"],
        condition=_checked(arrays, "condition", (rows,), None),
        **{name: getattr(about, name) for name in OF_LINKAGES},
        **named_tables(about.name, columns),
    )
    trajectory.mechanism = MovedScene(about.scene, about.parts["positions"])
    return trajectory


#: Largest possible position: squares of larger ones overflow.
LARGEST_POSITION = 1e150


def _checked(
    arrays: Mapping[str, Array], name: str, shape: tuple[int | None, ...], finite: int | None
) -> Array:
    """Array of doubles of a shape; the first columns, or all, have to be finite and possible.

    Raises
    ------
    ValueError
        It is another one.
    """
    array = arrays[name]
    expected = tuple(
        actual if size is None else size for size, actual in zip(shape, array.shape, strict=False)
    )
    if array.dtype != np.float64 or array.shape != expected or array.ndim != len(shape):
        raise ValueError(f"{name} is {array.dtype} {array.shape}; wanted doubles, {shape}")
    if not np.isfinite(array[..., :finite]).all():
        raise ValueError(f"{name} has numbers that are not finite")
    if not (np.abs(array[..., :finite]) <= LARGEST_POSITION).all():
        raise ValueError(
            f"{name} has numbers that are too large; wanted at most {LARGEST_POSITION:g}"
        )
    return array
