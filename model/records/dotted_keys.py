"""Dotted keys of a scene, and messages for unknown names with the nearest known one."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING

from kousoku.model.errors import SceneError
from kousoku.model.text import nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Sequence

    from kousoku.model.errors import Problem


def unknown(noun: str, name: str, known: tuple[str, ...]) -> str:
    """Message for a name that is not among `known`, with the nearest one."""
    near = nearest(name, known)
    if near:
        return f"unknown {noun}; did you mean {near!r}?"
    listed = ", ".join(known[:12]) + (", …" if len(known) > 12 else "")
    return f"unknown {noun}; known here: {listed or 'none'}"


class UnknownNameError(SceneError):
    """An unknown name; the message says which known one is nearest.

    Parameters
    ----------
    noun : str
        Sort of what is named, such as ``body``.
    name : str
        Its name.
    known : tuple of str
        The names that there are.
    key : str
        The dotted key where it stands.
    """

    def __init__(self, noun: str, name: str, known: tuple[str, ...], key: str) -> None:
        self.noun, self.name, self.known = noun, name, known
        super().__init__(unknown(f"{noun} {name[:40]!r}", name, known), key=key)

    def problems_beside(self, broken: Callable[[str], Sequence[str]]) -> Sequence[Problem]:
        """Problem whose known names include those of broken elements."""
        if self.key.endswith(".type"):  # no name of an element
            return self.problems
        broken_names = broken({"body": "bodies"}.get(self.noun, f"{self.noun}s"))
        known = tuple(dict.fromkeys((*self.known, *broken_names)))
        return UnknownNameError(self.noun, self.name, known, self.key).problems


def require_known(noun: str, name: str, known: Collection[str], key: str, *also: str) -> None:
    """Refuse an unknown name.

    Parameters
    ----------
    noun : str
        Sort of what is named, such as ``body``.
    name : str
        Its name.
    known : collection of str
        The names that there are.
    key : str
        The dotted key where it stands.
    *also : str
        Other names that may stand there, such as the ground.

    Raises
    ------
    SceneError
        There is none of that name; the message says which is nearest.
    """
    if name not in known and name not in also:
        raise UnknownNameError(noun, name, (*known, *also), key)


def join(key: str, name: str) -> str:
    """Dotted key of `name` in the table `key`, quoted and cut short where it must be."""
    shown = name if len(name) <= 40 else name[:40] + "…"
    if not re.fullmatch("[A-Za-z0-9_-]+…?", shown):
        shown = json.dumps(shown, ensure_ascii=not shown.isprintable())
    return f"{key}.{shown}" if key else shown


def dotted(path: Iterable[str | int]) -> str:
    """Dotted key of a path of keys and of indices in lists."""
    key = ""
    for step in path:
        key = f"{key}[{step}]" if isinstance(step, int) else join(key, step)
    return key
