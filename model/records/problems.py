"""Problems of a scene, collected so that all of them are reported at once.

An element that failed a check is *broken*: checks that depend on it are left out, so that one
mistake is one problem.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ParamSpec, TypeVar

from kousoku.model.errors import MOST_FOUND, Problem, SceneError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from kousoku.model.records.own_kind import OwnKind

P = ParamSpec("P")
R = TypeVar("R")


class Problems:
    """Problems that were found so far.

    Attributes
    ----------
    found : list of Problem
        In the order in which they were found.
    has_formulas : bool
        Whether a formula stands in place of a number of the design: they are read later.
    kinds : mapping of str to OwnKind
        Kinds of one's own that joints may be of.
    """

    def __init__(self, kinds: Mapping[str, OwnKind] | None = None) -> None:
        self.kinds = kinds or {}
        self.found: list[Problem] = []
        self.has_formulas = False
        self._broken: dict[str, None] = {}
        self._touched: dict[str, None] = {}

    @property
    def is_full(self) -> bool:
        """Whether there are so many problems that no more are looked for."""
        return len(self.found) >= MOST_FOUND

    def add(self, problem: str, key: str, *, breaks: str = "", place: str = "") -> None:
        """Note a problem, and the element or table `breaks` that it makes unusable."""
        self.found.append(Problem(problem, key, place=place))
        if breaks:
            self.break_(breaks)

    def break_(self, key: str) -> None:
        """Note that an element (``links.l1``) or a table (``links``) cannot be used."""
        self._broken[key] = None
        self._touched[key.partition(".")[0]] = None

    def is_broken(self, *keys: str) -> bool:
        """Whether one of these elements, or its table, cannot be used."""
        return any(key in self._broken or key.partition(".")[0] in self._broken for key in keys)

    def touches(self, *tables: str) -> bool:
        """Whether an element of one of these tables, or the whole table, cannot be used."""
        return any(table in self._touched for table in tables)

    def check(
        self, key: str, uses: Iterable[str], function: Callable[P, R], /, *a: P.args, **k: P.kwargs
    ) -> R | None:
        """Check an element, unless something that it uses is broken or there are too many problems.

        Parameters
        ----------
        key : str
            The element or table, which is broken when the check fails or is left out.
        uses : iterable of str
            The elements and tables that the check depends on.
        function : callable
            The check; it raises :class:`SceneError`.
        *a, **k
            Its arguments.
        """
        if self.is_full or self.is_broken(*uses):
            self.break_(key)
            return None
        try:
            return function(*a, **k)
        except SceneError as error:
            self.found.extend(error.problems_beside(self.broken))
            self.break_(key)
            return None

    def broken(self, table: str) -> list[str]:
        """Names of the elements of a table that cannot be used."""
        paths = (key.split(".") for key in self._broken)
        return list(dict.fromkeys(path[1] for path in paths if path[0] == table and path[1:]))

    def settle(self, file: str = "") -> None:
        """Raise the problems, if there are any.

        Raises
        ------
        SceneError
            All problems.
        """
        if self.found:
            raise SceneError.of(self.found, file=file)
