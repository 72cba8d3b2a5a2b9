"""Where bodies are and how they move, as tables by name, for the frames of the scene.

All bodies are taken at once: arrays are components first, then bodies, then rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import numpy.typing as npt

    Array = npt.NDArray[np.float64]


#: Numbers of one component that are computed together: more leave the fast part of the memory.
TOGETHER = 8192
#: The tables that are in the unit of the scene.
LENGTHS = ("position", "velocity", "acceleration")


@dataclass(frozen=True, slots=True)
class BodyPlaces:
    """Where a body stands in q and v; a number that never changes stands in place of an index.

    Parameters
    ----------
    name : str
        As in the scene.
    r, p, v, omega_b : tuple of int or float
        For each component its index in q or v, or its value: r and v in frame O [m, m/s], p the
        Euler parameters of the principal frame, omega_b in the principal frame [rad/s]. A point
        has no p and no omega_b.
    origin_b : (3,) [m]
        Origin of the user's body frame, in the principal frame.
    axes_b : (4,)
        Euler parameters that take components in the user's frame to the principal frame. An
        index of the design stands in place of a number that depends on parameters.
    """

    name: str
    r: tuple[int | float, ...]
    p: tuple[int | float, ...]
    v: tuple[int | float, ...]
    omega_b: tuple[int | float, ...]
    origin_b: tuple[int | float, ...]
    axes_b: tuple[int | float, ...]

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> BodyPlaces:
        """Return what ``motion.json`` says of a body."""
        places = {name: tuple(data[name]) for name in ("r", "p", "v", "omega_b")}
        return cls(
            data["name"],
            **places,
            origin_b=tuple(data["origin_b"]),
            axes_b=tuple(data["axes_b"]),
        )


def body_tables(
    bodies: Sequence[BodyPlaces], q: Array, v: Array, v_dot: Array | None, unit: float
) -> dict[str, dict[str, Array]]:
    """Return position, velocity and what else there is of each body, in the order of the scene.

    Parameters
    ----------
    bodies : sequence of BodyPlaces
        Where they stand in q and v.
    q, v : (n, ·) array
        Coordinates and velocities, row by row.
    v_dot : (n, ·) array, optional
        Time derivatives of the velocities.
    unit : float [m]
        The unit of the scene.

    Returns
    -------
    dict of str to dict of str to (n, 3) array
        For each table the bodies that have it; Euler parameters are (n, 4).
    """
    found: dict[str, dict[str, Array]] = {}
    rates = None if v_dot is None else v_dot.T
    size = max(1, TOGETHER // max(1, len(q)))
    for start in range(0, len(bodies), size):
        part = bodies[start : start + size]
        tables: dict[str, dict[str, Array]] = {}
        for of, turns in ((_of_rigid, True), (_of_points, False)):
            own = [body for body in part if bool(body.p) == turns]
            for name, values in of(own, q.T, v.T, rates).items() if own else ():
                scaled = values / unit if name in LENGTHS else values
                pairs = {body.name: scaled[:, k].T for k, body in enumerate(own)}
                tables[name] = tables.get(name, {}) | pairs
        for name, table in tables.items():
            ordered = {body.name: table[body.name] for body in part if body.name in table}
            found.setdefault(name, {}).update(ordered)
    return found


def _of_points(
    bodies: Sequence[BodyPlaces], q: Array, v: Array, v_dot: Array | None
) -> dict[str, Array]:
    """Return the tables of points, in SI units."""
    found = {
        "position": _taken([body.r for body in bodies], q),
        "velocity": _taken([body.v for body in bodies], v),
    }
    if v_dot is not None:
        found["acceleration"] = _rates([body.v for body in bodies], v_dot)
    return found


def _of_rigid(
    bodies: Sequence[BodyPlaces], q: Array, v: Array, v_dot: Array | None
) -> dict[str, Array]:
    """Return the tables of bodies that turn, in SI units."""
    found = _of_points(bodies, q, v, v_dot)
    p = _taken([body.p for body in bodies], q)
    omega = _taken([body.omega_b for body in bodies], v)
    arm, axes = (
        np.array(values).T[:, :, np.newaxis]
        for values in ([body.origin_b for body in bodies], [body.axes_b for body in bodies])
    )
    back = axes * np.array([1.0, -1.0, -1.0, -1.0])[:, np.newaxis, np.newaxis]
    turn = crossed(omega, arm)
    found["position"] += rotated(p, arm)
    found["velocity"] += rotated(p, turn)
    found["orientation"] = composed(p, axes)
    found["angular_velocity"] = rotated(back, omega)
    if v_dot is not None:
        alpha = _rates([body.omega_b for body in bodies], v_dot)
        found["acceleration"] += rotated(p, crossed(alpha, arm) + crossed(omega, turn))
        found["angular_acceleration"] = rotated(back, alpha)
    return found


def _taken(places: Sequence[Sequence[int | float]], columns: Array) -> Array:
    """Return what stands at places, (components, bodies, rows); numbers stand for themselves."""
    flat = [place for components in zip(*places, strict=True) for place in components]
    found = np.empty((len(flat), columns.shape[1]))
    moving = [k for k, place in enumerate(flat) if isinstance(place, int)]
    found[moving] = columns[[int(flat[k]) for k in moving]]
    for k, place in enumerate(flat):
        if not isinstance(place, int):
            found[k] = place
    return found.reshape(-1, len(places), columns.shape[1])


def _rates(places: Sequence[Sequence[int | float]], columns: Array) -> Array:
    """Return time derivatives; what does not change has none."""
    return _taken([[k if isinstance(k, int) else 0.0 for k in own] for own in places], columns)


def crossed(a: Array, b: Array) -> Array:
    """Return a × b, components first."""
    return np.stack(
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    )


def rotated(p: Array, v: Array) -> Array:
    """Return A(p) v for Euler parameters of norm one, components first."""
    t = 2.0 * crossed(p[1:], v)
    turned: Array = v + p[0] * t + crossed(p[1:], t)
    return turned


def composed(p: Array, q: Array) -> Array:
    """Return p∘q of Euler parameters, components first, of these the scalar."""
    scalar = p[0] * q[0] - (p[1] * q[1] + p[2] * q[2] + p[3] * q[3])
    vector = p[0] * q[1:] + q[0] * p[1:] + crossed(p[1:], q[1:])
    return np.concatenate([scalar[np.newaxis], vector])
