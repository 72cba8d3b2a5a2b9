"""Check the mass properties of a body: impossible masses, sizes and moments are refused."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kousoku.model.errors import SceneError
from kousoku.model.records.design import LARGEST
from kousoku.model.records.orientation import check_orientation
from kousoku.model.records.problems import Problems
from kousoku.model.records.spatial import SOLIDS
from kousoku.model.text import with_a

if TYPE_CHECKING:
    from kousoku.model.records.spatial import Body

POSSIBLE = 1 + 1e-9
"""Factor by which a moment may exceed the sum of the others, for moments with few digits."""


def check_mass(body: Body, key: str) -> None:
    """Refuse masses and sizes that are not positive, and moments that no body has.

    Raises
    ------
    SceneError
        All that is wrong, each with its dotted key.
    """
    problems = Problems()
    problems.check(key, (), _check_keys, body, key)
    mass = f"{key}.mass"
    if body.mass is not None:
        problems.check(mass, (), _check_positive, body.mass, "mass", "kg", mass)
    for name in SOLIDS:
        for index, solid in enumerate(getattr(body, name)):
            _check_solid(solid, f"{key}.{name}[{index}]", problems)
    if body.inertia is not None:
        uses = [key] if body.inertia.about is None else [key, mass]
        problems.check(f"{key}.inertia", uses, _check_inertia, body, f"{key}.inertia")
    problems.settle()


def _check_keys(body: Body, key: str) -> None:
    """Refuse centre, inertia and solids of a point, and centre and inertia without a mass."""
    given_keys = [name for name in ("mass", "center", "inertia") if getattr(body, name) is not None]
    if body.point:
        for name in ("center", "inertia", *SOLIDS):
            if getattr(body, name) not in (None, ()):
                raise SceneError("a point has a mass only; leave it out", key=f"{key}.{name}")
    if given_keys and body.mass is None:
        raise SceneError(f"is missing, but {given_keys[0]} is given", key=f"{key}.mass")


def _check_solid(solid: object, key: str, problems: Problems) -> None:
    """Check the keys of a solid, each whatever is wrong with the others."""
    mass = getattr(solid, "mass", None)
    problems.check(f"{key}.mass", (), _check_positive, mass, "mass", "kg", f"{key}.mass")
    for name in ("size", "radius", "ends", "orientation"):
        value, value_key = getattr(solid, name, None), f"{key}.{name}"
        if value is None:
            continue
        if name == "radius":
            problems.check(value_key, (), _check_positive, value, name, "", value_key)
        elif name == "size":
            for index, edge in enumerate(value):
                edge_key = f"{value_key}[{index}]"
                problems.check(edge_key, (), _check_positive, edge, "edge", "", edge_key)
        elif name == "orientation":
            problems.check(value_key, (), check_orientation, value, value_key)
        elif value[0] == value[1]:
            problems.add("are the same point; wanted two", value_key)


def _check_positive(value: float | None, noun: str, unit: str, key: str) -> None:
    if value is None or not 1 / LARGEST <= value <= LARGEST:
        shown = f"{value!r} {unit}".rstrip()
        raise SceneError(f"{with_a(noun)} of {shown}; wanted a positive {noun}", key=key)


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
    if 0.0 < largest < 1 / LARGEST:
        raise SceneError(
            f"its largest moment is {largest:.6g}; wanted at least {1 / LARGEST:g}, or leave"
            " the inertia out",
            key=key,
        )


def _principal_moments(body: Body) -> list[float]:
    """Principal moments about the centre of mass, from the smallest to the largest."""
    inertia = body.inertia
    assert inertia is not None
    rows = (inertia.xx, inertia.xy, inertia.zx), (inertia.xy, inertia.yy, inertia.yz)
    tensor = np.array([*rows, (inertia.zx, inertia.yz, inertia.zz)], dtype=float)
    if inertia.about is not None:
        d = np.subtract(body.center or (0.0, 0.0, 0.0), inertia.about)
        tensor -= float(body.mass or 0.0) * (d @ d * np.eye(3) - np.outer(d, d))
    return [float(moment) for moment in np.linalg.eigvalsh(tensor)]
