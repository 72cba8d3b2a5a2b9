"""Result of a run: columns by name with their units, parts of the scene, files."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Mapping
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol, TypedDict, TypeVar

import numpy as np

from ..messages import (
    listed,
    missing,
    near,
    refusal,
    require_folder,
    shown,
    unknown,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from typing import Unpack

    import numpy.typing as npt
    from matplotlib.figure import Figure

    from ..momenta import Momentum
    from ..run_ledger import Violation
    from .arithmetic import Array
    from .assembled_start import Moved
    from .events import EventOccurrences
    from .trust import Trust

    class Ledger:
        """Cost of a run, and how far it can be trusted: ``print(run.ledger)`` tells it.

        Bodies have a ``kousoku.runtime.run_ledger.RunLedger``, linkages of nodes the ``Iterations``
        of an analysis, where their fields are told. Which of them a run has no type checker knows:
        it sees the fields of both.
        """

        method: str
        # of bodies
        tolerance: float
        fixed_step: float | None
        parameters: Mapping[str, float]
        steps: int
        rejected: int
        derivatives: int
        factorisations: int
        corrections: int
        drift: float
        avoided: int
        growth: float
        growth_time: float
        passed: int
        passed_time: float | None
        unresolved: int
        unresolved_time: float | None
        branch_points: int
        branch_point_time: float | None
        meetings: int
        meeting_time: float | None
        fallbacks: int
        fallback_time: float | None
        refinements: int
        energy: float | None
        energy_error: float | None
        works: Mapping[str, float]
        momenta: tuple[Momentum, ...]
        violations: Mapping[str, Violation]
        missed: Mapping[str, tuple[float, float]]
        released: tuple[str, ...]
        moved: Mapping[str, Moved]
        events: Mapping[str, int]
        seconds: Mapping[str, float]
        trust: Trust
        worst: Callable[[str], tuple[float, float]]
        worst_joint: Callable[[str], str]
        as_data: Callable[[], dict[str, object]]
        # of linkages
        target: str
        rows: int
        least: int
        most: int
        total: int
        residual: float
        condition: float
        unit: str


Value = TypeVar("Value")
#: Columns that change by a smaller part of their size do so by rounding.
ROUNDING_OF_COLUMNS = 1e-9
#: Files that results go to; the last one needs pandas and pyarrow.
SUFFIXES = (".csv", ".npz", ".parquet")


class Named(Mapping[str, Value]):
    """Values by name, which nobody can replace; it pickles.

    Parameters
    ----------
    values : mapping
        The values.
    missing : str
        Begins the message on a name that it lacks: what has none.
    advice : str
        Instead, where there are no values at all: why.
    """

    def __init__(self, values: Mapping[str, Value], missing: str = "", advice: str = "") -> None:
        self._values, self._missing, self._advice = dict(values), missing, advice

    def __getitem__(self, name: str) -> Value:
        if isinstance(name, str) and name in self._values:
            return self._values[name]
        if self._advice and not self._values:
            raise missing(self._advice)
        known, prefix = [*self], f"{self._missing}, " if self._missing else ""
        raise missing(
            f"{prefix}none of {shown(name)}: there are {listed(known) or 'none'}{near(name, known)}"
        )

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return f"{{{', '.join(self._values)}}}"


class Column(NamedTuple):
    """Place of a column: table, owner in it, component, and its unit."""

    table: str
    owner: str
    component: int | None
    unit: str


class Coordinates(np.ndarray):
    """Coordinates q of a row, which know of their run what the numbers do not tell.

    What is computed from them, copies and pickles know it too; ``numpy.array`` and lists of them
    are the numbers alone.

    Parameters
    ----------
    values : array
        The numbers.
    parameters : mapping of str to float
        Those of the run.
    counted : array
        q as the solver has it: its angles count turns.
    """

    parameters: Mapping[str, float] | None
    counted: Array | None

    def __new__(
        cls, values: Array, parameters: Mapping[str, float] | None, counted: Array | None
    ) -> Coordinates:
        """Coordinates with the parameters and counted angles of their run."""
        coordinates = np.asarray(values).view(cls)
        coordinates.parameters, coordinates.counted = parameters, counted
        return coordinates

    def __array_finalize__(self, other: Any) -> None:
        """Hand these on to what is computed from them."""
        self.parameters = getattr(other, "parameters", None)
        self.counted = getattr(other, "counted", None)

    def __reduce__(self) -> tuple[Any, ...]:
        known = None if self.parameters is None else dict(self.parameters)
        return Coordinates, (np.array(self), known, self.counted)


class AnimationOptions(TypedDict, total=False):
    """Options of an animation, as ``kousoku.view.animate`` takes them."""

    paths_of: Sequence[str | tuple[str, Sequence[float]]] | str | None
    forces: Sequence[str] | bool
    fps: float
    speed: float | None
    start: float | None
    end: float | None
    parameters: Mapping[str, float | str] | None


class AnimationPage(Protocol):
    """An animation, ``kousoku.view.Animation``: a page that shows a motion."""

    @property
    def html(self) -> str:
        """The page."""

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the page to a file ``*.html``, or a picture that moves by itself to ``*.svg``."""

    def still(self, time: float | None = None) -> str:
        """Picture of one moment as SVG; of the start unless a time [s] is given."""


class Part:
    """A body, joint, driver, node or link in a result: its tables are attributes."""

    def __init__(self, result: Result, name: str, tables: Mapping[str, str]) -> None:
        self._result, self._tables, self.name = result, tables, name

    if TYPE_CHECKING:  # a type checker sees which tables there are
        position: Array
        velocity: Array
        acceleration: Array
        orientation: Array
        angle: Array
        angular_velocity: Array
        angular_acceleration: Array
        force: Array
        torque: Array
    else:

        def __getattr__(self, table: str) -> Array:
            if table.startswith("_"):
                raise AttributeError(table)
            if table not in self._tables:
                raise AttributeError(f"{self.name}: {unknown('table', table, [*self._tables])}")
            try:
                return getattr(self._result, self._tables[table])[self.name]
            except KeyError as error:
                raise AttributeError(str(error)) from None

    def __dir__(self) -> list[str]:
        return ["name", *self._tables]

    def __repr__(self) -> str:
        return f"<{self.name} in the result of {self._result.name}: {', '.join(self._tables)}>"


class Result:
    """Rows of a run by name; tables are made when they are read.

    ``run["crank.x"]`` is a column, ``run.columns()`` all of them, ``run.units`` their units;
    ``run.body("crank").position`` and the like are tables. Lengths are in the unit of the scene,
    angles in radians, times in seconds, vectors in frame O where nothing else is said.
    """

    #: For each sort of parts the tables that they have, by attribute.
    PARTS: ClassVar[Mapping[str, Mapping[str, str]]] = {}
    name: str
    unit: str
    target: str
    #: What moved, where kousoku loaded it; plots and animations are drawn from its scene.
    mechanism: Any = None
    #: How it was computed.
    method: str

    if TYPE_CHECKING:  # a type checker sees what runs of bodies have alone, and linkages
        is_complete: bool

        @property
        def events(self) -> Mapping[str, EventOccurrences]:
            """Of bodies: how often each event of the scene was, when, and the states there."""

        @property
        def stopped_by(self) -> str:
            """Of bodies: the event that ended the run; empty where none did."""

        @property
        def not_unique(self) -> tuple[str, ...]:
            """Of bodies: joints whose force and torque the motion does not determine."""

        @property
        def undetermined(self) -> dict[str, tuple[str, ...]]:
            """Of bodies: columns of force and torque that are not determined, by joint."""

        @property
        def reaction_length(self) -> float:
            """Of bodies: a length of the scene, in its unit, that torques are weighed by."""

        @property
        def iterations(self) -> npt.NDArray[np.int32]:
            """Of linkages: corrections in the step that led to each row."""

    def __len__(self) -> int:
        raise NotImplementedError

    @property
    def time(self) -> Array:
        """Times (n,) [s]."""
        raise NotImplementedError

    def state(self, k: int) -> tuple[float, Array, Array]:
        """Time, q and v of a row, as the scene is written.

        Returns
        -------
        t : float [s]
            The time.
        q : array
            For each body of the scene r of the origin of its frame in frame O [unit], then its
            Euler parameters, scalar first, unless it is a point; of a linkage x and y of each node.
            Of bodies it also knows the parameters of the run and the turns of its angles.
        v : array
            For each body ṙ [unit/s], then ω′ in its frame [rad/s] unless it is a point; of a
            linkage the rates of x and y.

        Raises
        ------
        IndexError
            There is no such row.
        TypeError
            A row is no whole number.
        """
        if not hasattr(k, "__index__"):
            raise TypeError(f"{self.name}: row {shown(k)}; wanted a whole number")
        if not -len(self) <= k < len(self):
            raise IndexError(f"{self.name}: no row {shown(k)}: there are {len(self)}")
        q, v = self._state(k)
        return float(self.time[k]), q, v

    def _state(self, k: int) -> tuple[Array, Array]:
        """Coordinates q and velocities v of a row that there is, as the scene is written."""
        raise NotImplementedError

    @property
    def ledger(self) -> Ledger:
        """Ledger of the run: its cost, and how far it can be trusted."""
        raise NotImplementedError

    @property
    def parameters(self) -> Mapping[str, float]:
        """The parameters of the run."""
        return Named({})

    def summary(self) -> dict[str, Any]:
        """Summary for programs, ready for JSON."""
        raise NotImplementedError

    def main_columns(self, of: str | None = None) -> list[str]:
        """Columns that are shown where none are named: of a body or node, or all."""
        raise NotImplementedError

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes for a reader before he trusts the numbers, a line each."""
        return ()

    @cached_property
    def places(self) -> dict[str, Column]:
        """Places of the columns, in order."""
        raise NotImplementedError

    def _names(self, sort: str) -> Sequence[str]:
        """Names of all parts of a sort."""
        raise NotImplementedError

    @property
    def units(self) -> dict[str, str]:
        """The unit of each column; ``-`` where it has none."""
        return {name: place.unit for name, place in self.places.items()}

    def __getitem__(self, name: str) -> Array:
        """Column by its name."""
        if name not in self:
            raise missing(f"{self.name}: {self._no_column(name)}")
        table, owner, component, _ = self.places[name]
        values: Array = getattr(self, table)[owner] if owner else getattr(self, table)
        return values if component is None else values[:, component]

    def _no_column(self, name: object) -> str:
        columns = [*self.places]
        if owned := [column for column, place in self.places.items() if place.owner == name]:
            return f"no column {shown(name)}: those of {name} are {listed(owned)}"
        return f"no column {shown(name)}: there are {listed(columns)}{near(name, columns)}"

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name in self.places

    def __iter__(self) -> Iterator[str]:
        return iter(self.places)

    def columns(self) -> dict[str, Array]:
        """Columns (n,) by name, in the units that :attr:`units` tells."""
        return {name: self[name] for name in self.places}

    def columns_of(self, name: str) -> list[str]:
        """Column, or those of a body, joint, driver, node or link.

        Raises
        ------
        KeyError
            There is none; where kousoku is installed it is a ``NotInResultError``, too.
        """
        if name in self:
            return [name]
        columns = [column for column, place in self.places.items() if place.owner == name]
        if not columns:
            raise missing(f"{self.name}: {self._no_column(name)}")
        return columns

    def body(self, name: str) -> Part:
        """Position, velocity, orientation … of a body."""
        return self._part("body", name)

    def joint(self, name: str) -> Part:
        """Force and torque of a joint on its body j."""
        return self._part("joint", name)

    def driver(self, name: str) -> Part:
        """Force and torque of a driver on its body j."""
        return self._part("driver", name)

    def node(self, name: str) -> Part:
        """Position, velocity and acceleration of a node of a linkage."""
        return self._part("node", name)

    def link(self, name: str) -> Part:
        """Angle, angular velocity and angular acceleration of a link of a linkage."""
        return self._part("link", name)

    def _moving(self, names: Sequence[str], least: float = 0.0) -> list[str]:
        """Columns that change by more than rounding."""
        if not len(self):
            return []
        return [
            x
            for x in names
            if np.ptp(self[x]) > ROUNDING_OF_COLUMNS * max(least, np.abs(self[x]).max())
        ]

    def _part(self, sort: str, name: str) -> Part:
        if sort not in self.PARTS:
            calls = ", ".join(f".{known}(…)" for known in self.PARTS)
            raise missing(f"{self.name}: no {sort} {shown(name)}: the result has {calls}")
        if name not in (names := self._names(sort)):
            raise missing(f"{self.name}: {unknown(sort, name, names)}")
        return Part(self, name, self.PARTS[sort])

    def to_pandas(self) -> Any:
        """Columns as a ``pandas.DataFrame``; its ``attrs`` have the units."""
        frame = self._late("pandas", "table").DataFrame(self.columns())
        frame.attrs |= {"name": self.name, "units": self.units}
        return frame

    def save(self, path: str | Path) -> None:
        """Write the columns to a ``.csv``, ``.npz`` or ``.parquet`` file, whole or not at all.

        A CSV file has one line of names, then one line a row with all digits of the doubles. A run
        that is kept as ``.npz`` can be opened again, :func:`kousoku.open_run`. No folder is made.

        Raises
        ------
        kousoku.model.errors.SolveError
            The name ends otherwise or is none, its folder is missing, or the file cannot be
            written; without ``kousoku`` a ``ValueError``.
        """
        if not isinstance(path, str | os.PathLike):
            raise refusal(f"{shown(path)} is no name of a file; wanted one")
        path = Path(path)
        if "\0" in str(path):
            raise refusal(f"{shown(str(path))} is not the name of a file: it has a null character")
        if path.suffix not in SUFFIXES:
            suffixes = f"{', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}"
            raise refusal(f"{path}: results go to a file that ends in {suffixes}")
        require_folder(path)
        buffer, table = io.BytesIO(), dict[str, Any](self.columns())
        if path.suffix == ".csv":
            rows = zip(*(column.tolist() for column in table.values()), strict=True)
            lines = [",".join(table), *(",".join(map(repr, row)) for row in rows)]
            buffer.write(("\n".join(lines) + "\n").encode())
        elif path.suffix == ".npz":
            if self.mechanism is not None:
                table |= import_module("kousoku.saved").arrays_of(self)
            _write_arrays(buffer, table)
        else:
            self._late("pyarrow", "table")
            self.to_pandas().to_parquet(buffer)
        try:
            _write(path, buffer.getvalue())
        except OSError as error:
            raise refusal(f"{path}: cannot be written: {error.strerror or error}") from error

    def plot(self, *columns: str) -> Figure:
        """Draw columns over time, what was asked for unless named; a matplotlib ``Figure``."""
        figure: Figure = self._late("kousoku.result_plots", "plot").plot(self, *columns)
        return figure

    def figures(self, of: str | None = None) -> dict[str, Figure]:
        """Draw all plots of a run by name, as ``--plot FOLDER``, or those of a body or node."""
        plots = self._late("kousoku.result_plots", "plot")
        figures: dict[str, Figure] = plots.figures_of(self, of=of)
        return figures

    def animate(
        self, path: str | os.PathLike[str] | None = None, **options: Unpack[AnimationOptions]
    ) -> AnimationPage:
        """Show the motion on a page of its own; options as of ``kousoku.view.animate``.

        Raises
        ------
        kousoku.model.errors.SolveError
            There is no such option, joint or body, or the page cannot be written; or what moved is
            not known, as where a folder was copied: ``kousoku.load`` its scene there.
        """
        known = ["path", *AnimationOptions.__annotations__]
        for name in options:
            if name not in known:
                raise refusal(f"{self.name}: {unknown('option', name, known)}")
        if self.mechanism is None:
            raise refusal(
                f"{self.name}: only runs of what kousoku.load gave have solids to be drawn: load"
                " the scene file where kousoku is, pip install kousoku",
                alone=ModuleNotFoundError,
            )
        shown: AnimationOptions = {"parameters": dict(self.parameters), **options}
        view = import_module("kousoku.view")
        animation: AnimationPage = view.animate(self, self.mechanism.scene, path, **shown)
        return animation

    def _late(self, module: str, extra: str) -> Any:
        """Module that is imported when it is needed, or an error that says how to install it."""
        try:
            return import_module(module)
        except ModuleNotFoundError as error:
            package = (error.name or module).partition(".")[0]
            line = f"{self.name}: needs {package}: pip install 'kousoku[{extra}]'"
            raise ModuleNotFoundError(line, name=error.name) from None

    def _repr_html_(self) -> str:
        from html import escape

        return f"{self._still()}<pre>{escape(repr(self))}</pre>"

    def _still(self) -> str:
        """Picture of the first row, empty where nothing knows what moved."""
        if self.mechanism is None or not len(self):
            return ""
        view = import_module("kousoku.view")
        still: str = view.still(self.mechanism.scene, self._first(), self.parameters)
        return still

    def _first(self) -> Result:
        """Result with its first row, or with more where that is no less work."""
        return self

    def __repr__(self) -> str:
        lines = [*self._verdict(), f"{type(self).__name__} of {self.name}: {self._extent()}"]
        for sort in self.PARTS:
            if names := self._names(sort):
                plural = sort.replace("body", "bodie") + "s"
                lines.append(f"  {plural}: {listed(names)}")
        return "\n".join([*lines, f"  columns: {listed([*self.places])}"])

    def _verdict(self) -> list[str]:
        """Line on how far the run can be trusted, where it is known."""
        return []

    def _extent(self) -> str:
        return f"{len(self)} rows, {self.unit}, {self.target}"


def _write_arrays(buffer: io.BytesIO, arrays: Mapping[str, Any]) -> None:
    """Write what ``numpy.load`` reads by name; ``numpy.savez`` has arguments of its own."""
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, values in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, np.asarray(values), allow_pickle=False)


def _write(path: Path, data: bytes) -> None:
    """Write a file whole or not at all."""
    import tempfile

    with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.") as folder:
        part = Path(folder) / path.name
        part.write_bytes(data)
        part.replace(path)
