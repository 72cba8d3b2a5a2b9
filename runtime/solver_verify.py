"""Check of a generated scene: the part common to bodies and to linkages of nodes.

At each state of ``reference.json.gz`` all that the solver computes is computed again, by C and by
NumPy, and its error is told in units of what rounding can do there.
"""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

from kousoku.model.errors import LoadError, NoCompilerError, TargetError, VerifyError
from kousoku.model.files.manifest import REFERENCE_FILE
from kousoku.runtime.notice import silent
from kousoku.runtime.report import Report, Row

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from kousoku.runtime.choice import ChosenTarget, Target
    from kousoku.runtime.sources import Sources

    #: Content of ``reference.json.gz``; None where the folder was generated without.
    Data = Mapping[str, Any] | None

Loaded = TypeVar("Loaded")

NAMES: dict[str, str] = {"c": "C", "numpy": "NumPy"}


class SolverCheck(ABC, Generic[Loaded]):
    """The check of a folder that was made from a scene.

    Parameters
    ----------
    sources : Sources
        Its files, compared with the manifest.
    """

    #: Format of the reference values.
    REFERENCE_FORMAT: ClassVar[int]

    def __init__(self, sources: Sources) -> None:
        self.sources = sources

    @abstractmethod
    def load(self, target: Target) -> Loaded:
        """Solver by a target."""

    @abstractmethod
    def require(self, data: Mapping[str, Any]) -> object:
        """Read all that reference values must have; a missing one raises."""

    @abstractmethod
    def rows(self, solver: Loaded, data: Mapping[str, Any]) -> Iterable[Row]:
        """Worst error of each output."""

    @abstractmethod
    def problems(self, solvers: Sequence[Loaded], data: Data) -> Iterator[str]:
        """Other problems: of motions and tables, and differences between targets."""

    def notes(self, data: Mapping[str, Any]) -> Iterator[str]:
        """Notes on what is not compared, and why."""
        return iter(())

    def verify(self, target: Target) -> Report:
        """Whether the folder computes what was composed.

        Parameters
        ----------
        target : {"auto", "c", "numpy"}
            What to check.
        """
        folder, package = self.sources.folder, self.sources.manifest.package
        problems: list[str] = []
        notes: list[str] = []
        try:
            data = self._read()
        except VerifyError as error:
            return Report(package, str(folder), (), (str(error),))
        solvers = by_each_target(self.load, target, problems, notes)
        rows: list[Row] = []
        if data is None:
            notes.append(
                f"{folder.name} has no {REFERENCE_FILE}: it was generated without reference values;"
                " kousoku generate SCENE.toml writes them"
            )
        else:
            notes += self.notes(data)
            rows = [row for solver in solvers for row in self.rows(solver, data)]
        problems += [str(row) for row in rows if not row.ok]
        problems += self.problems(solvers, data)
        return Report(package, str(folder), tuple(rows), tuple(problems), tuple(notes))

    def _read(self) -> Data:
        if REFERENCE_FILE not in self.sources.files:
            return None
        path = self.sources.folder / REFERENCE_FILE
        try:
            data: dict[str, Any] = json.loads(self.sources.files[REFERENCE_FILE])
            if data["format"] != self.REFERENCE_FORMAT:
                raise VerifyError(
                    f"{path}: its format is {data['format']}, wanted {self.REFERENCE_FORMAT}"
                )
            self.require(data)
        except (ValueError, KeyError, TypeError) as error:
            raise VerifyError(f"{path} cannot be read: {error!r}") from None
        return data


def by_each_target(
    load: Callable[[Target], Loaded], target: Target, problems: list[str], notes: list[str]
) -> list[Loaded]:
    """Library or solver by each target; a missing one is a problem, or a note.

    No compiler is a note, unless C was asked for; none at all is a problem.
    """
    loaded = []
    targets: tuple[ChosenTarget, ...] = ("c", "numpy")
    for choice in targets:
        if target not in {"auto", choice}:
            continue
        try:
            with silent():
                loaded.append(load(choice))
        except (NoCompilerError, TargetError) as error:
            text = f"{NAMES[choice]} is not checked: {error}"
            (notes if target == "auto" else problems).append(text)
        except LoadError as error:
            problems.append(str(error))
    if not loaded and not problems:
        problems.append("nothing was checked, because nothing could be run")
    return loaded
