"""Smaller trees of scenes that a finding is still in."""

from __future__ import annotations

import copy
import re
import time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    Tree = dict[str, Any]

#: Seconds that a finding is made smaller for; a fault that was planted is made so for less.
MOST_SECONDS, PLANTED_SECONDS = 30.0, 1.0


def _is_table(value: Any) -> bool:
    return isinstance(value, dict)


def smallest(tree: Tree, is_found: Callable[[Tree], bool], among: int = 1) -> Tree:
    """Smaller tree of which the same is true, found by leaving out parts in turn.

    After ``MOST_SECONDS``, or its part of them, no more is tried.

    Parameters
    ----------
    tree : dict
        A scene.
    is_found : callable
        Whether what was found is found in a smaller one; what it raises means no.
    among : int
        How many findings share the time.
    """
    last, found = time.monotonic() + MOST_SECONDS / among, True
    while found:
        found = False
        for smaller in _smaller(tree):
            if time.monotonic() > last:
                return tree
            try:
                found = is_found(smaller)
            except Exception:
                found = False
            if found:
                tree = smaller
                break
    return tree


def _smaller(tree: Tree) -> Iterator[Tree]:
    """Trees with one part less: first elements with all that names them, then keys."""
    for table in ("events", "forces", "inputs", "drivers", "bodies", "joints", "coordinates"):
        for name in tree.get(table, {}):
            yield without(tree, {name})
    for key in ("gravity", "divisions", "parameters", "closure_tolerance"):
        if key in tree:
            yield {one: value for one, value in tree.items() if one != key}
    parameters = tree.get("parameters", {})
    for gone in (unnamed(tree), *({name} for name in parameters)):
        kept = {name: one for name, one in parameters.items() if name not in gone}
        if gone and kept:
            yield tree | {"parameters": kept}
    for output in tree.get("outputs", ()):
        yield tree | {"outputs": [one for one in tree["outputs"] if one != output]}
    for table, key in ((t, k) for t, v in tree.items() if _is_table(v) for k in v):
        element = tree[table][key]
        for part in element if _is_table(element) else ():
            smaller = copy.deepcopy(tree)
            del smaller[table][key][part]
            yield smaller


def unnamed(tree: Tree) -> set[str]:
    """Parameters that nothing refers to."""
    others = {table: elements for table, elements in tree.items() if table != "parameters"}
    return {name for name in tree.get("parameters", ()) if not _refers(others, {name})}


def without(tree: Tree, names: set[str]) -> Tree:
    """Tree without some elements, and without all that refers to them."""
    left = {}
    for table, elements in tree.items():
        if not _is_table(elements) or table == "parameters":
            left[table] = elements
            continue
        kept = {
            name: one
            for name, one in elements.items()
            if name not in names and not _refers(one, names)
        }
        if kept:
            left[table] = kept
        if gone := elements.keys() - kept.keys() - names:
            return without(tree, names | gone)
    return left


def _refers(one: Any, names: set[str]) -> bool:
    if isinstance(one, dict):
        return any(_refers(value, names) for value in one.values())
    if isinstance(one, list | tuple):
        return any(_refers(value, names) for value in one)
    words = re.findall(r"\w+", one) if isinstance(one, str) else []
    return any(word.removesuffix("_dot") in names for word in words)
