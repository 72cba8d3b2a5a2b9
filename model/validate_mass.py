"""Check the mass properties of a body: what no body can have is refused."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kousoku.model.decode import LARGEST
from kousoku.model.errors import SceneError
from kousoku.model.orientation import check_orientation
from kousoku.model.spatial import SOLIDS

if TYPE_CHECKING:
    from kousoku.model.spatial import Body

POSSIBLE = 1 + 1e-9
"""Factor by which a moment may exceed the sum of the others, for moments with few digits."""


def check_mass(body: Body, key: str) -> None:
    """Refuse masses and sizes that are not positive, and moments that no body has.

    Raises
    ------
    SceneError
        With the dotted key of what is wrong.
    """
    direct = [of for of in ("mass", "center", "inertia") if getattr(body, of) is not None]
    if body.point:
        for name in ("center", "inertia", *SOLIDS):
            if getattr(body, name) not in (None, ()):
                raise SceneError("a point has a mass only; leave it out", key=f"{key}.{name}")
    if direct and body.mass is None:
        raise SceneError(f"is missing, but {direct[0]} is given", key=f"{key}.mass")
    if body.mass is not None:
        _check_positive(body.mass, "mass", "kg", f"{key}.mass")
    for name in SOLIDS:
        for index, solid in enumerate(getattr(body, name)):
            _check_solid(solid, f"{key}.{name}[{index}]")
    if body.inertia is not None:
        _check_inertia(body, f"{key}.inertia")


def _check_solid(solid: object, key: str) -> None:
    _check_positive(getattr(solid, "mass", None), "mass", "kg", f"{key}.mass")
    for name in ("size", "radius", "ends", "orientation"):
        value = getattr(solid, name, None)
        if value is None:
            continue
        if name == "radius":
            _check_positive(value, name, "", f"{key}.{name}")
        elif name == "size":
            for index, edge in enumerate(value):
                _check_positive(edge, "edge", "", f"{key}.{name}[{index}]")
        elif name == "orientation":
            check_orientation(value, f"{key}.{name}")
        elif value[0] == value[1]:
            raise SceneError("are the same point; wanted two", key=f"{key}.{name}")


def _check_positive(value: float | None, what: str, unit: str, key: str) -> None:
    if value is None or not 1 / LARGEST <= value <= LARGEST:
        shown = f"{value!r} {unit}".rstrip()
        raise SceneError(f"a {what} of {shown}; wanted a positive {what}", key=key)


def _check_inertia(body: Body, key: str) -> None:
    """Refuse moments that no body has: the sum of two is never less than the third."""
    moments = _principal_moments(body)
    largest = moments[2]
    if moments[0] < -(POSSIBLE - 1) * largest or largest > (moments[0] + moments[1]) * POSSIBLE:
        about = (
            "" if body.inertia is None or body.inertia.about is None else ", taken to the centre"
        )
        shown = ", ".join(f"{moment:.6g}" for moment in moments)
        raise SceneError(
            f"no body has these moments{about}: about its principal axes they are {shown}; wanted "
            "each positive, and the sum of two at least the third",
            key=key,
        )


def _principal_moments(body: Body) -> list[float]:
    """Return the principal moments about the centre of mass, from the smallest to the largest."""
    given = body.inertia
    assert given is not None
    rows = (given.xx, given.xy, given.zx), (given.xy, given.yy, given.yz)
    tensor = np.array([*rows, (given.zx, given.yz, given.zz)], dtype=float)
    if given.about is not None:
        d = np.subtract(body.center or (0.0, 0.0, 0.0), given.about)
        tensor -= float(body.mass or 0.0) * (d @ d * np.eye(3) - np.outer(d, d))
    return [float(moment) for moment in np.linalg.eigvalsh(tensor)]
