"""The list of kinds: names, other books' names, packages, and the module that derives each."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING

from kousoku.model.errors import DerivationError
from kousoku.model.text import near_name, plain_name

if TYPE_CHECKING:
    from kousoku.symbolic.derivation import Derivation


@dataclass(frozen=True, slots=True)
class Kind:
    """One line of the list of kinds.

    Parameters
    ----------
    title : str
        What it is, in one line.
    module : str
        The module of ``kousoku.symbolic`` whose ``derive(package)`` derives it.
    packages : tuple of str
        Derivations of it: one for each choice of its rows. They are emitted as one package.
    aliases : tuple of str
        Other names, compared without case, blanks and hyphens.
    """

    title: str
    module: str
    packages: tuple[str, ...]
    aliases: tuple[str, ...] = ()


#: All kinds by name. How to add one, CONTRIBUTING says: Add a kind.
KINDS: dict[str, Kind] = {
    "rotation": Kind("rotation by Euler parameters", "rotation", ("rotation",)),
    "n1": Kind("two vectors perpendicular", "pairs", ("n1",), ("dot-1", "perpendicular", "perp-1")),
    "n2": Kind(
        "vector perpendicular to the line between two points",
        "pairs",
        ("n2",),
        ("dot-2", "inplane"),
    ),
    "p1": Kind(
        "two vectors parallel", "pairs", ("p1_x", "p1_y", "p1_z"), ("parallel-1", "parallel axes")
    ),
    "p2": Kind(
        "vector parallel to the line between two points",
        "pairs",
        ("p2_x", "p2_y", "p2_z"),
        ("parallel-2", "inline"),
    ),
    "point": Kind(
        "two points coincident", "joints", ("point",), ("spherical", "atpoint", "coincident points")
    ),
    "distance": Kind("two points at a given distance", "joints", ("distance",), ("distance-1",)),
    "angle": Kind("angle about a common axis", "angle", ("angle",), ("axis angle",)),
    "length": Kind("distance of two points", "length", ("length",), ("point distance",)),
    "linear_combination": Kind(
        "coordinates coupled to each other and to time",
        "combination",
        ("linear_combination",),
        ("combination", "coupler"),
    ),
    "norm": Kind("Euler parameters of norm one", "joints", ("norm",), ("euler parameter norm",)),
    "spring_damper": Kind(
        "spring and damper between two points",
        "spring",
        ("spring_damper",),
        ("tsda",),
    ),
    "link": Kind("planar link element", "link", ("link",), ("link element",)),
    "mass_points": Kind(
        "Newton-Euler equations of mass points", "mass", ("mass_points",), ("mass points",)
    ),
    "rigid_body": Kind(
        "Newton-Euler equations of a rigid body", "mass", ("rigid_body",), ("rigid body",)
    ),
}


def packages_of(name: str) -> tuple[str, ...]:
    """Packages that a name stands for.

    Parameters
    ----------
    name : str
        A package (``p2_x``), a kind (``p2``: all its variants) or a name from another book
        (``INLINE``); case, blanks and hyphens do not count.

    Raises
    ------
    DerivationError
        No kind has this name.
    """
    plain = plain_name(name)
    for kind, entry in KINDS.items():
        if plain in {plain_name(kind), *map(plain_name, entry.aliases)}:
            return entry.packages
        for package in entry.packages:
            if plain == plain_name(package):
                return (package,)
    names = [*KINDS, *(alias for entry in KINDS.values() for alias in entry.aliases)]
    known = ", ".join(KINDS)
    raise DerivationError(f"unknown kind {name!r}; known are {known}{near_name(name, names)}")


def derive(name: str) -> Derivation:
    """Derive one choice of rows; of a kind with several, by the name of the kind, the last.

    Parameters
    ----------
    name : str
        As in :func:`packages_of`.

    Returns
    -------
    Derivation
        The steps on the matrix level, and every output on both levels.

    Raises
    ------
    DerivationError
        No kind has this name.
    """
    package = packages_of(name)[-1]
    entry = next(entry for entry in KINDS.values() if package in entry.packages)
    module = import_module(f"kousoku.symbolic.{entry.module}")
    derivation: Derivation = module.derive(package)
    return derivation
