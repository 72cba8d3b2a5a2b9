"""Positions and velocities of bodies, as tables by name, for the frames of the scene.

All bodies are taken at once: arrays are components first, then bodies, then rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .euler_parameters import BACK, composed, crossed, rotated

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from .arithmetic import Array

#: Numbers of one component that are computed together: more leave the fast part of the memory.
TOGETHER = 8192
#: The tables that are in the unit of the scene.
LENGTHS = ("position", "velocity", "acceleration")


@dataclass(frozen=True, slots=True)
class BodyPlaces:
    """Places of a body in q and v; a number that never changes stands in place of an index.

    Parameters
    ----------
    name : str
        As in the scene.
    r, p, v, omega_b : tuple of int or float
        For each component its index in q or v, or its value: r and v in frame O [m, m/s], p the
        Euler parameters of the principal frame, omega_b in the principal frame [rad/s], ṗ = ½ p ∘
        (0, ω′). A point has no p and no omega_b.
    origin_b : (3,) [m]
        Origin of the user's body frame, in the principal frame.
    axes_b : (4,)
        Euler parameters that take components in the user's frame to the principal frame. An index
        of the design stands in place of a number that depends on parameters.
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
        """Places of a body, from ``motion.json``."""
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
    """Tables of position, velocity and what else there is of each body, in the order of the scene.

    Of the origin s′ of its frame r + A s′, ṙ + A ω̃′s′ and r̈ + A (ω̇̃′s′ + ω̃′ω̃′s′), in frame O;
    ω′ and ω̇′ [rad/s, rad/s²] in its frame.

    Parameters
    ----------
    bodies : sequence of BodyPlaces
        Where they stand in q and v.
    q, v : (n, nq), (n, nv) array
        Coordinates and velocities of the solver, row by row, in SI units.
    v_dot : (n, nv) array, optional
        Time derivatives of the velocities.
    unit : float [m]
        The unit of the scene.

    Returns
    -------
    dict of str to dict of str to (n, 3) array
        For each table the bodies that have it, lengths in the unit of the scene; Euler parameters
        are (n, 4) [-].
    """
    all_tables: dict[str, dict[str, Array]] = {}
    rates = None if v_dot is None else v_dot.T
    size = max(1, TOGETHER // max(1, len(q)))
    for start in range(0, len(bodies), size):
        chunk = bodies[start : start + size]
        tables: dict[str, dict[str, Array]] = {}
        for tables_of, turns in ((_rigid_tables, True), (_point_tables, False)):
            members = [body for body in chunk if bool(body.p) == turns]
            for name, values in tables_of(members, q.T, v.T, rates).items() if members else ():
                scaled = values / unit if name in LENGTHS else values
                columns = {body.name: scaled[:, k].T for k, body in enumerate(members)}
                tables[name] = tables.get(name, {}) | columns
        for name, table in tables.items():
            ordered = {body.name: table[body.name] for body in chunk if body.name in table}
            all_tables.setdefault(name, {}).update(ordered)
    return all_tables


def written_state(
    bodies: Sequence[BodyPlaces], q: Array, v: Array, unit: float
) -> tuple[Array, Array]:
    """State as the scene is written, r + A s′ and p ∘ p′, from that of its solver.

    Parameters
    ----------
    bodies : sequence of BodyPlaces
        Where they stand in q and v, in the order of the scene.
    q, v : (nq,), (nv,) array
        Coordinates and velocities of the solver, in SI units.
    unit : float [m]
        The unit of the scene.

    Returns
    -------
    q : (n,) array
        For each body r (3) of the origin of its frame, in frame O and the unit of the scene, then
        its Euler parameters p (4) [-], scalar first, unless it is a point.
    v : (m,) array
        For each body ṙ (3) in frame O, in the unit of the scene per second, then ω′ (3) [rad/s] in
        its own frame, unless it is a point; n and m as :func:`written_sizes` tells.
    """
    tables = body_tables(bodies, q[np.newaxis], v[np.newaxis], None, unit)
    positions, rates = (
        [tables[key][body.name][0] for body in bodies for key in keys if body.name in tables[key]]
        for keys in (
            [name for name in ("position", "orientation") if name in tables],
            [name for name in ("velocity", "angular_velocity") if name in tables],
        )
    )
    empty = np.zeros(0)
    return np.concatenate([empty, *positions]), np.concatenate([empty, *rates])


def written_sizes(bodies: Sequence[BodyPlaces]) -> tuple[int, int]:
    """Sizes of q and v of a state as the scene is written."""
    rigid = sum(bool(body.p) for body in bodies)
    return 3 * len(bodies) + 4 * rigid, 3 * len(bodies) + 3 * rigid


def solver_state(
    bodies: Sequence[BodyPlaces],
    q_written: Array,
    v_written: Array,
    unit: float,
    start: tuple[Array, Array],
) -> tuple[Array, Array]:
    """Coordinates and velocities of a solver from a state as the scene is written, r − A s′.

    What the solver does not have, such as a displacement out of the plane that it moves in, or the
    place of a body beside that of another one that carries it, is ignored:
    :func:`written_state` of what is returned tells whether it was as the solver has it.

    Parameters
    ----------
    bodies : sequence of BodyPlaces
        Where they stand in q and v, in the order of the scene.
    q_written, v_written : (n,), (m,) array
        The state, as :func:`written_state` returns it, n and m as
        :func:`written_sizes` tells; Euler parameters of any norm but 0.
    unit : float [m]
        The unit of the scene.
    start : (array, array)
        q and v of the solver at some state: entries that belong to no body, as angles that count
        turns, are taken from there, and so is the sign of Euler parameters.

    Returns
    -------
    q, v : (nq,), (nv,) array
        Copies of those of ``start`` with what bodies have, in SI units.
    """
    q, v = (array.copy() for array in start)
    at_q = at_v = 0
    for body in bodies:
        r, rate = (x[k : k + 3] * unit for x, k in ((q_written, at_q), (v_written, at_v)))
        at_q, at_v = at_q + 3, at_v + 3
        if body.p:
            p, omega = q_written[at_q : at_q + 4], v_written[at_v : at_v + 3]
            at_q, at_v = at_q + 4, at_v + 3
            axes, arm = np.array(body.axes_b), np.array(body.origin_b)
            p, omega = composed(p / np.sqrt(p @ p), axes * BACK), rotated(axes, omega)
            p = -p if taken(body.p, start[0]) @ p < 0 else p
            _put(q, body.p, p)
            _put(v, body.omega_b, omega)
            r, rate = r - rotated(p, arm), rate - rotated(p, crossed(omega, arm))
        _put(q, body.r, r)
        _put(v, body.v, rate)
    return q, v


def taken(places: Sequence[float], q: Array) -> Array:
    """Elements (n,) of q (nq,) at n places, in their units; numbers stand for themselves."""
    return np.array([q[k] if isinstance(k, int) else k for k in places])


def indices(places: Sequence[float]) -> list[int]:
    """Indices among places; numbers are left out."""
    return [place for place in places if isinstance(place, int)]


def _put(target: Array, places: Sequence[int | float], values: Array) -> None:
    """Write components where they have an index."""
    for index, value in zip(places, values, strict=True):
        if isinstance(index, int):
            target[index] = value


def _point_tables(
    bodies: Sequence[BodyPlaces], q: Array, v: Array, v_dot: Array | None
) -> dict[str, Array]:
    """Tables of points, in SI units."""
    tables = {
        "position": _taken([body.r for body in bodies], q),
        "velocity": _taken([body.v for body in bodies], v),
    }
    if v_dot is not None:
        tables["acceleration"] = _rates([body.v for body in bodies], v_dot)
    return tables


def _rigid_tables(
    bodies: Sequence[BodyPlaces], q: Array, v: Array, v_dot: Array | None
) -> dict[str, Array]:
    """Tables of bodies that turn, in SI units."""
    tables = _point_tables(bodies, q, v, v_dot)
    p = _taken([body.p for body in bodies], q)
    omega = _taken([body.omega_b for body in bodies], v)
    arm, axes = (
        np.array(values).T[:, :, np.newaxis]
        for values in ([body.origin_b for body in bodies], [body.axes_b for body in bodies])
    )
    back = axes * BACK[:, np.newaxis, np.newaxis]
    turn = crossed(omega, arm)
    tables["position"] += rotated(p, arm)
    tables["velocity"] += rotated(p, turn)
    tables["orientation"] = composed(p, axes)
    tables["angular_velocity"] = rotated(back, omega)
    if v_dot is not None:
        alpha = _rates([body.omega_b for body in bodies], v_dot)
        tables["acceleration"] += rotated(p, crossed(alpha, arm) + crossed(omega, turn))
        tables["angular_acceleration"] = rotated(back, alpha)
    return tables


def _taken(places: Sequence[Sequence[int | float]], columns: Array) -> Array:
    """Elements of columns at places, (components, bodies, rows); numbers stand for themselves."""
    flat = [index for components in zip(*places, strict=True) for index in components]
    elements = np.empty((len(flat), columns.shape[1]))
    moving = [k for k, index in enumerate(flat) if isinstance(index, int)]
    elements[moving] = columns[[int(flat[k]) for k in moving]]
    for k, index in enumerate(flat):
        if not isinstance(index, int):
            elements[k] = index
    return elements.reshape(-1, len(places), columns.shape[1])


def _rates(places: Sequence[Sequence[int | float]], columns: Array) -> Array:
    """Time derivatives at places; those of constants are zero."""
    return _taken([[k if isinstance(k, int) else 0.0 for k in row] for row in places], columns)
