"""Saved runs: a file of columns that also holds what they belong to, to be opened again."""

from __future__ import annotations

import json
import zipfile
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from kousoku.model.errors import SolveError
from kousoku.runtime.integrate.motion import Layout, Motion
from kousoku.runtime.integrate.result import Named
from kousoku.runtime.kinematics.trajectory import Trajectory

if TYPE_CHECKING:
    from pathlib import Path

    import numpy.typing as npt

    from kousoku.model.scene import Scene
    from kousoku.runtime.integrate.result import Result

    Array = npt.NDArray[np.float64]

#: The arrays beside the columns: what they belong to as JSON, and the rows of a solver.
ABOUT, ROWS = "kousoku", "kousoku.rows"
FORMAT = 1
#: Of a linkage, all that is no mapping of columns.
SCALARS = ("name", "unit", "method", "divisions", "target", "is_in_time", "links", "input_units")
#: Of a linkage, tables of parts.
TABLES = ("inputs", "positions", "velocities", "accelerations")
ANGLES = ("angles", "angular_velocities", "angular_accelerations")


class Moved:
    """What moved in a run that was opened: its scene, to draw it.

    Parameters
    ----------
    text : str
        The scene as TOML.
    """

    def __init__(self, text: str) -> None:
        self.text = text

    @property
    def scene(self) -> Scene:
        """The scene."""
        from kousoku.model.read import scene_from_toml

        return scene_from_toml(self.text)


def arrays_of(result: Result) -> dict[str, Array]:
    """Return the arrays that a file of columns holds beside them, so that it can be opened."""
    about: dict[str, Any] = {
        "format": FORMAT,
        "scene": result.mechanism.text,
        "ledger": str(result.ledger),
        "parameters": dict(result.parameters),
    }
    arrays: dict[str, Any] = {}
    if isinstance(result, Motion):
        about |= {"layout": msgspec.to_builtins(result.layout), "method": result.method}
        about |= {"target": result.target, "is_complete": result.is_complete}
        arrays[ROWS] = result.rows
    elif isinstance(result, Trajectory):
        about |= {name: getattr(result, name) for name in SCALARS}
        about["input_units"] = dict(result.input_units)
        arrays |= {f"{ABOUT}.{name}": getattr(result, name) for name in ("iterations", "residual")}
        if result.times is not None:
            arrays[f"{ABOUT}.times"] = result.times
        for table in (*TABLES, *ANGLES):
            if getattr(result, table):
                own = getattr(result, table)
                about[table] = [*own]
                arrays[f"{ABOUT}.{table}"] = np.stack([*own.values()], axis=1)
    return arrays | {ABOUT: np.array(json.dumps(about))}


def open_run(path: str | Path) -> Result:
    """Open a run that ``run.save("run.npz")`` kept: to read, to plot and to animate it.

    Parameters
    ----------
    path : path
        A ``.npz`` file.

    Returns
    -------
    Result
        As it was; its ledger is text.

    Raises
    ------
    SolveError
        There is no such file, or no run was saved in it.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            found = {name: file[name] for name in file.files if name.startswith(ABOUT)}
        about = json.loads(str(found[ABOUT]))
        if about["format"] != FORMAT:
            raise ValueError(f"format {about['format']} instead of {FORMAT}")
        return _opened(about, found)
    except OSError as error:
        raise SolveError(f"{path}: cannot be read: {error.strerror or error}") from None
    except (KeyError, TypeError, ValueError, zipfile.BadZipFile, msgspec.ValidationError) as error:
        text = f"{path}: holds no run; wanted a file that run.save('….npz') wrote"
        raise SolveError(text) from error


def _opened(about: dict[str, Any], arrays: dict[str, Any]) -> Result:
    result: Result
    if "layout" in about:
        result = Motion(
            msgspec.convert(about["layout"], Layout),
            arrays[ROWS],
            target=about["target"],
            method=about["method"],
            ledger=about["ledger"],
            parameters=about["parameters"],
            is_complete=about["is_complete"],
        )
    else:
        tables = {}
        for table in (*TABLES, *ANGLES):
            names = about.get(table, [])
            own = {name: arrays[f"{ABOUT}.{table}"][:, k] for k, name in enumerate(names)}
            tables[table] = Named(own, f"{about['name']}: no {table}")
        given = {name: about[name] for name in SCALARS} | tables
        given["links"] = tuple(tuple(link) for link in about["links"])
        rest = {name: arrays[f"{ABOUT}.{name}"] for name in ("iterations", "residual")}
        result = Trajectory(**given, **rest, times=arrays.get(f"{ABOUT}.times"))
    result.mechanism = Moved(about["scene"])
    return result
