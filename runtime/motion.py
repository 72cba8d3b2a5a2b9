"""The motion of a scene of bodies, as arrays by name."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.runtime.tables import save_columns

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import numpy.typing as npt

    Array = npt.NDArray[np.float64]


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
        Euler parameters that take components in the user's frame to the principal frame.
    """

    name: str
    r: tuple[int | float, ...]
    p: tuple[int | float, ...]
    v: tuple[int | float, ...]
    omega_b: tuple[int | float, ...]
    origin_b: tuple[float, ...]
    axes_b: tuple[float, ...]

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


@dataclass(frozen=True, slots=True)
class RunLedger:
    """What a run cost, and how far it can be trusted.

    Parameters
    ----------
    method : str
        The Runge-Kutta method.
    tolerance : float
        Local error of a step, relative.
    steps, rejected : int
        Steps that were made, and that were tried in vain.
    derivatives, factorisations : int
        Evaluations of the accelerations, and factorisations of C_q M⁻¹ C_qᵀ.
    drift : float
        Largest correction of a step onto the constraints, relative to a length of the scene.
    """

    method: str
    tolerance: float
    steps: int
    rejected: int
    derivatives: int
    factorisations: int
    drift: float

    def __str__(self) -> str:
        return (
            f"{self.method}, tolerance {self.tolerance:g}: {self.steps} steps, {self.rejected}"
            f" rejected, {self.derivatives} accelerations, {self.factorisations} factorisations;"
            f" a step left the constraints by {self.drift:.1e} at most before it was brought back"
        )


@dataclass(frozen=True, slots=True)
class Motion:
    """Positions and velocities of bodies at the times that were asked for.

    Lengths are in the unit of the scene, vectors in frame O where nothing else is said.

    Parameters
    ----------
    name : str
        The scene.
    time : (n,) array [s]
        The times.
    position : mapping of str to (n, 3) array
        Origin of each body's frame.
    orientation : mapping of str to (n, 4) array
        Euler parameters of each body's frame, scalar first; points have none.
    velocity : mapping of str to (n, 3) array
        Of the origin.
    angular_velocity : mapping of str to (n, 3) array [rad/s]
        Components in the body's frame.
    ledger : RunLedger
        What the run cost.
    target : {"c", "numpy"}
        What computed.
    """

    name: str
    time: Array
    position: Mapping[str, Array]
    orientation: Mapping[str, Array]
    velocity: Mapping[str, Array]
    angular_velocity: Mapping[str, Array]
    ledger: RunLedger
    target: str

    def __len__(self) -> int:
        return len(self.time)

    def columns(self) -> dict[str, Array]:
        """Return the columns of a file by name.

        ``time``, then for each body ``crank.x crank.y crank.z``, ``crank.e0`` … ``crank.e3``,
        ``crank.vx`` …, ``crank.omega_x`` ….
        """
        table = {"time": self.time}
        letters = (
            (self.position, ("x", "y", "z")),
            (self.orientation, ("e0", "e1", "e2", "e3")),
            (self.velocity, ("vx", "vy", "vz")),
            (self.angular_velocity, ("omega_x", "omega_y", "omega_z")),
        )
        for body in self.position:
            for values, names in letters:
                if body in values:
                    table |= {f"{body}.{n}": values[body][:, k] for k, n in enumerate(names)}
        return table

    def summary(self) -> dict[str, object]:
        """Return what a program may want to know, ready for JSON."""
        return {
            "scene": self.name,
            "target": self.target,
            "rows": len(self),
            "bodies": list(self.position),
            "ledger": asdict(self.ledger),
        }

    def save(self, path: str | Path) -> None:
        """Write the columns to a ``.csv`` or ``.npz`` file, as :func:`save_columns` does."""
        save_columns(self.columns(), Path(path))


def by_body(
    bodies: Sequence[BodyPlaces], q: Array, v: Array, unit: float
) -> tuple[Mapping[str, Array], Mapping[str, Array], Mapping[str, Array], Mapping[str, Array]]:
    """Return position, orientation, velocity and angular velocity in the users' frames, by name."""
    tables: tuple[dict[str, Array], ...] = ({}, {}, {}, {})
    for body in bodies:
        r, velocity = _columns(body.r, q), _columns(body.v, v)
        if body.p:
            p, omega = _columns(body.p, q), _columns(body.omega_b, v)
            arm = np.array(body.origin_b)
            r = r + rotated(p, np.broadcast_to(arm, r.shape))
            velocity = velocity + rotated(p, np.cross(omega, arm))
            axes = np.array(body.axes_b)
            tables[1][body.name] = composed(p, np.broadcast_to(axes, p.shape))
            conjugate = np.broadcast_to(axes * [1, -1, -1, -1], p.shape)
            tables[3][body.name] = rotated(conjugate, omega)
        tables[0][body.name], tables[2][body.name] = r / unit, velocity / unit
    first, second, third, fourth = map(MappingProxyType, tables)
    return first, second, third, fourth


def _columns(places: Sequence[int | float], rows: Array) -> Array:
    return np.stack(
        [rows[:, k] if isinstance(k, int) else np.full(len(rows), k) for k in places], axis=1
    )


def rotated(p: Array, v: Array) -> Array:
    """Return A(p) v for rows of Euler parameters of norm one, and of vectors."""
    e0, e = p[:, :1], p[:, 1:]
    t = 2.0 * np.cross(e, v)
    return v + e0 * t + np.cross(e, t)


def composed(p: Array, q: Array) -> Array:
    """Return p∘q for rows of Euler parameters, scalar first."""
    scalar = p[:, :1] * q[:, :1] - np.sum(p[:, 1:] * q[:, 1:], axis=1, keepdims=True)
    vector = p[:, :1] * q[:, 1:] + q[:, :1] * p[:, 1:] + np.cross(p[:, 1:], q[:, 1:])
    return np.concatenate([scalar, vector], axis=1)
