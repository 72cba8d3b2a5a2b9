"""The motion of a scene of bodies, as arrays by name."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from kousoku.runtime.integrate import body_tables
from kousoku.runtime.tables import save_columns

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    import numpy.typing as npt

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.integrate.body_tables import BodyPlaces
    from kousoku.runtime.places import ReactionPlaces
    from kousoku.runtime.run_ledger import RunLedger

    Array = npt.NDArray[np.float64]


#: The tables of coordinates.
COORDINATE_TABLES = ("coordinate", "coordinate_rate", "coordinate_acceleration")
#: The tables of a motion.
TABLES = (
    *("position", "orientation", "velocity", "angular_velocity"),
    *("acceleration", "angular_acceleration", "force", "torque", "energy", "work"),
    *COORDINATE_TABLES,
)
#: Joints that a line names.
SHOWN = 6


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
    acceleration, angular_acceleration : mapping of str to (n, 3) array
        Their time derivatives; empty unless wanted.
    force, torque : mapping of str to (n, 3) array
        What each joint does to its body j, at its point of body j [kg unit/s², kg unit²/s²]; body i
        gets the opposite. A body that hangs on its joint j is pulled upward: the force is against
        gravity. Empty unless wanted. In a scene that moves in a plane, and does not lie in it, what
        leads out of the plane is not computed, and NaN.
    not_unique : tuple of str
        Joints whose force and torque the motion does not determine, because constraints depend on
        each other. What they have is the least that moves all bodies so: Σ |force|² + |torque|²/ℓ²
        over the joints of a set of such constraints is as small as it can be.
    reaction_length : float
        ℓ, a length of the scene, in its unit.
    energy : mapping of str to (n,) array
        ``kinetic``, ``potential`` and their sum ``total`` [kg unit²/s²]; empty unless wanted.
    work : mapping of str to (n,) array
        What each force without potential and each driver has done since the start, and the damper
        of each spring [kg unit²/s²]; empty unless energies are wanted. The total energy changes by
        their sum.
    coordinate, coordinate_rate : mapping of str to (n,) array
        Value and rate of each coordinate of the scene: lengths, or angles [rad] with the turns that
        they have made; empty unless wanted.
    coordinate_acceleration : mapping of str to (n,) array
        Their second derivatives; empty unless accelerations are wanted, too.
    ledger : RunLedger
        What the run cost.
    target : {"c", "numpy"}
        What computed.
    is_complete : bool
        Whether all times are there.
    """

    name: str
    time: Array
    position: Mapping[str, Array]
    orientation: Mapping[str, Array]
    velocity: Mapping[str, Array]
    angular_velocity: Mapping[str, Array]
    acceleration: Mapping[str, Array]
    angular_acceleration: Mapping[str, Array]
    force: Mapping[str, Array]
    torque: Mapping[str, Array]
    not_unique: tuple[str, ...]
    reaction_length: float
    energy: Mapping[str, Array]
    work: Mapping[str, Array]
    coordinate: Mapping[str, Array]
    coordinate_rate: Mapping[str, Array]
    coordinate_acceleration: Mapping[str, Array]
    ledger: RunLedger
    target: str
    is_complete: bool = True

    def __len__(self) -> int:
        return len(self.time)

    def columns(self) -> dict[str, Array]:
        """Return the columns of a file by name.

        ``time``, then for each body ``crank.x crank.y crank.z``, ``crank.e0`` … ``crank.e3``,
        ``crank.vx`` …, ``crank.omega_x`` …, and where they are wanted ``crank.ax`` …,
        ``crank.alpha_x`` …; for each joint ``hinge.fx`` …, ``hinge.mx`` …; ``energy.kinetic`` …;
        ``work.damper`` …; for each coordinate ``theta``, ``theta_dot`` and ``theta_ddot``.
        """
        table = {"time": self.time}
        bodies = (
            (self.position, ("x", "y", "z")),
            (self.orientation, ("e0", "e1", "e2", "e3")),
            (self.velocity, ("vx", "vy", "vz")),
            (self.angular_velocity, ("omega_x", "omega_y", "omega_z")),
            (self.acceleration, ("ax", "ay", "az")),
            (self.angular_acceleration, ("alpha_x", "alpha_y", "alpha_z")),
        )
        joints = ((self.force, ("fx", "fy", "fz")), (self.torque, ("mx", "my", "mz")))
        for owners, letters in ((self.position, bodies), (self.force, joints)):
            for owner in owners:
                for values, names in letters:
                    if owner in values:
                        table |= {f"{owner}.{n}": values[owner][:, k] for k, n in enumerate(names)}
        table |= {f"energy.{name}": values for name, values in self.energy.items()}
        table |= {f"work.{name}": values for name, values in self.work.items()}
        for name in self.coordinate:
            table |= {name: self.coordinate[name], f"{name}_dot": self.coordinate_rate[name]}
            if name in self.coordinate_acceleration:
                table[f"{name}_ddot"] = self.coordinate_acceleration[name]
        return table

    def summary(self) -> dict[str, object]:
        """Return what a program may want to know, ready for JSON."""
        return {
            "scene": self.name,
            "target": self.target,
            "rows": len(self),
            "bodies": list(self.position),
            "is_complete": self.is_complete,
            "not_unique": list(self.not_unique),
            "reaction_length": self.reaction_length,
            "ledger": self.ledger.as_data(),
        }

    def note(self) -> str:
        """Return the line on forces that are not unique, empty where all are."""
        if not self.not_unique:
            return ""
        names = ", ".join(f"joints.{name}" for name in self.not_unique[:SHOWN])
        more = len(self.not_unique) - SHOWN
        names += f" and {more} more" if more > 0 else ""
        return (
            f"not unique: force and torque of {names}; those with the least Σ|F|² + |M|²/ℓ² are"
            f" given, ℓ = {self.reaction_length:.6g} in the unit of the scene"
        )

    def save(self, path: str | Path) -> None:
        """Write the columns to a ``.csv`` or ``.npz`` file, as :func:`save_columns` does."""
        save_columns(self.columns(), path)


def motion_of(
    solver: DynamicsSolver, rows: Array, ledger: RunLedger, *, is_complete: bool
) -> Motion:
    """Return rows (time, q, v, then what is wanted) as arrays by name, in the users' frames.

    Parameters
    ----------
    solver : DynamicsSolver
        What made them.
    rows : array
        The rows.
    ledger : RunLedger
        What they cost.
    is_complete : bool
        Whether all times are there.
    """
    n, first = len(solver.q), 1 + len(solver.q) + len(solver.v)
    q, v = rows[:, 1 : 1 + n], rows[:, 1 + n : first]
    parts = {}
    for name, size in solver.parts:
        parts[name] = rows[:, first : first + size]
        first += size
    tables: dict[str, dict[str, Array]] = {name: {} for name in TABLES}
    tables |= body_tables.body_tables(solver.bodies, q, v, parts.get("v_dot"), solver.unit)
    if "reactions" in parts:
        for joint in solver.reactions:
            pair = _of_joint(joint, solver.bodies, q, parts["reactions"])
            if not solver.is_flat:
                _hide(pair, joint, turns=bool(solver.bodies[joint.body].p))
            tables["force"][joint.joint] = pair[0] / solver.unit
            tables["torque"][joint.joint] = pair[1] / solver.unit**2
    if "energies" in parts:
        kinetic, potential = parts["energies"].T / solver.unit**2
        tables["energy"] = {
            "kinetic": kinetic,
            "potential": potential,
            "total": kinetic + potential,
        }
        tables["work"] = {name: q[:, place] / solver.unit**2 for name, place in solver.works}
    for shown in solver.coordinates:
        unit = solver.unit if shown.is_length else 1.0
        for name, place in zip(COORDINATE_TABLES, shown.columns, strict=False):
            tables[name][shown.name] = parts["coordinates"][:, place] / unit
    frozen = {name: MappingProxyType(table) for name, table in tables.items()}
    return Motion(
        solver.name,
        rows[:, 0],
        **frozen,
        not_unique=solver.not_unique,
        reaction_length=solver.length / solver.unit,
        ledger=ledger,
        target=solver.target.name,
        is_complete=is_complete,
    )


def _of_joint(
    joint: ReactionPlaces, bodies: Sequence[BodyPlaces], q: Array, reactions: Array
) -> tuple[Array, Array]:
    """Return force and torque on body j at the joint's point, in frame O [N, N m]."""
    body, sign = bodies[joint.body], -1.0 if joint.j < 0 else 1.0
    own = [reactions[:, k] if k >= 0 else np.zeros(len(reactions)) for k in joint.columns]
    force, torque = (sign * np.stack(own[k : k + 3], axis=1) for k in (0, 3))
    center = _columns(body.r, q)
    point = np.broadcast_to(np.array(joint.point_b), center.shape)
    if joint.j >= 0:
        other = bodies[joint.j]
        point = _columns(other.r, q) + (rotated(_columns(other.p, q), point) if other.p else 0.0)
    if body.p:
        torque = rotated(_columns(body.p, q), torque)
    return force, torque + body_tables.crossed((center - point).T, force.T).T


def _hide(pair: tuple[Array, Array], joint: ReactionPlaces, *, turns: bool) -> None:
    """Mark what is not computed: of a planar body, all that leads out of the plane."""
    force, torque = pair
    force[:, [k < 0 for k in joint.columns[:3]]] = np.nan
    if turns:
        torque[:, [k < 0 for k in joint.columns[3:]]] = np.nan


def _columns(places: Sequence[int | float], rows: Array) -> Array:
    return np.stack(
        [rows[:, k] if isinstance(k, int) else np.full(len(rows), k) for k in places], axis=1
    )


def rotated(p: Array, v: Array) -> Array:
    """Return A(p) v for rows of Euler parameters of norm one, and of vectors."""
    return body_tables.rotated(p.T, v.T).T


def composed(p: Array, q: Array) -> Array:
    """Return p∘q for rows of Euler parameters, scalar first."""
    return body_tables.composed(p.T, q.T).T
