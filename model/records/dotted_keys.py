"""Dotted keys of a scene, and names in it that nothing has: what the nearest one is."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING

from kousoku.model.errors import SceneError
from kousoku.model.text import nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Sequence

    from kousoku.model.errors import Problem


def unknown(what: str, name: str, known: tuple[str, ...]) -> str:
    """Message for a name that is not among `known`, with the nearest one."""
    near = nearest(name, known)
    if near:
        return f"unknown {what}; did you mean {near!r}?"
    listed = ", ".join(known[:12]) + (", …" if len(known) > 12 else "")
    return f"unknown {what}; known here: {listed or 'none'}"


class UnknownNameError(SceneError):
    """Something is named that is not there; the message says which name is nearest.

    Parameters
    ----------
    what : str
        What is named, such as ``body``.
    name : str
        Its name.
    known : tuple of str
        The names that there are.
    key : str
        The dotted key where it stands.
    """

    def __init__(self, what: str, name: str, known: tuple[str, ...], key: str) -> None:
        self.what, self.name, self.known = what, name, known
        super().__init__(unknown(f"{what} {name[:40]!r}", name, known), key=key)

    def problems_beside(self, broken: Callable[[str], Sequence[str]]) -> Sequence[Problem]:
        """Problem with the names of elements among the known ones that are wrong."""
        if self.key.endswith(".type"):  # no name of an element
            return self.problems
        also = broken({"body": "bodies"}.get(self.what, f"{self.what}s"))
        known = tuple(dict.fromkeys((*self.known, *also)))
        return UnknownNameError(self.what, self.name, known, self.key).problems


def require_known(what: str, name: str, known: Collection[str], key: str, *also: str) -> None:
    """Refuse a name of something that is not there.

    Parameters
    ----------
    what : str
        What is named, such as ``body``.
    name : str
        Its name.
    known : collection of str
        The names that there are.
    key : str
        The dotted key where it stands.
    *also : str
        What may stand there, too, such as the ground.

    Raises
    ------
    SceneError
        There is none of that name; the message says which is nearest.
    """
    if name not in known and name not in also:
        raise UnknownNameError(what, name, (*known, *also), key)


def join(key: str, name: str) -> str:
    """Dotted key of `name` in the table `key`, quoted and cut short where it must be."""
    shown = name if len(name) <= 40 else name[:40] + "…"
    if not re.fullmatch("[A-Za-z0-9_-]+…?", shown):
        shown = json.dumps(shown, ensure_ascii=not shown.isprintable())
    return f"{key}.{shown}" if key else shown


def dotted(path: Iterable[str | int]) -> str:
    """Dotted key of a path of keys and of places in lists."""
    key = ""
    for part in path:
        key = f"{key}[{part}]" if isinstance(part, int) else join(key, part)
    return key
