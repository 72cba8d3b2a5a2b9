"""Whether all bodies of a system stay in planes parallel to the xy-plane, with the proof.

The kinds are evaluated with e1 = e2 = 0 and z constant. A row without a structural derivative by
x, y and θ_z is constant on such motions. If all of these vanish at the start, they vanish for good
and are dropped. The remaining rows determine the planar motion. It is the motion of the system if
for each joint

- no remaining row has a derivative by z, θ_x or θ_y: its reactions stay in the plane; or
- both its bodies are held to the ground in z, θ_x and θ_y by rows that were dropped, whose
  reactions balance all forces out of the plane.

Derivatives of a shipped kind are taken at the start, those of a kind of one's own must vanish
structurally; and rows of one's own hold nothing in the plane.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.codegen.dynamics.assembly.driver_laws import fixed_law
from kousoku.codegen.dynamics.operations.body_coordinates import start
from kousoku.codegen.dynamics.operations.heights import kernel_at_start
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.codegen.dynamics.simplification.axis_permutation import (
    NORMAL,
    Plane,
    can_permute,
    permuted,
)
from kousoku.codegen.dynamics.simplification.forces_plane import (
    leaves_plane,
    leaves_with_parameters,
)
from kousoku.codegen.dynamics.simplification.outline import live_elements
from kousoku.model.lowering.parametric import fixed_system
from kousoku.model.mechanics.constraints import is_axis
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.records.own_kind import is_own

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.mechanics.multibody import Instance, MovingBody, System

#: Largest residual of a dropped row, in metres or radians: rounding, 2e-16 of positions some
#: kilometres from the origin. Those of the committed scenes are zero, or not constant.
RESIDUAL = 1e-12
#: Columns of one body that lead out of the plane.
OUT = (2, 3, 4)
#: Smallest singular value of rows that hold a body in the plane. Those of a joint about z have 1/d
#: where it lies d metres, and more than 1, from the origin of the body frame: it may be a thousand
#: kilometres away. Rows that do not hold have 1e-16 by rounding, those of the committed scenes 0.69
#: or more.
LEAST_HOLDING_SINGULAR_VALUE = 1e-6
ALONG_Z = {(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)}


def is_planar(system: System, *, must_be_held: bool = False) -> bool:
    """Whether all bodies move in planes parallel to the xy-plane.

    Parameters
    ----------
    system : System
        The scene, as it starts.
    must_be_held : bool
        Whether joints must hold all bodies in the plane, not the start alone.
    """
    if not all(_starts_in_plane(body) for body in system.bodies):
        return False
    if leaves_with_parameters(system):
        return False
    fixed = fixed_system(system)
    needs_hold = (
        must_be_held
        or system.has_gravity(NORMAL)
        or any(leaves_plane(fixed, force, NORMAL) for force in fixed.forces)
    )
    if needs_hold and not _may_hold(system):
        return False
    joints: dict[tuple[str, tuple[int, ...]], _Joint] = {}
    rows_and_elements = live_elements(system, is_planar=True)
    pairs = zip(system.constraints, fixed.constraints, strict=True)
    for (instance, known), (live, elements) in zip(pairs, rows_and_elements, strict=True):
        residual, jacobian = _at_start(fixed, known)
        dropped = [row for row in range(len(residual)) if row not in live]
        if any(not abs(residual[row]) <= RESIDUAL for row in dropped):
            return False
        joint = joints.setdefault((instance.joint, instance.bodies), _Joint())
        if is_own(instance.kind):  # what is zero by chance at the start does not count
            jacobian = np.array(elements)
        joint.live.append(jacobian[list(live)])
        joint.dropped.append(jacobian[dropped])
        if dropped or not instance.is_combination:
            joint.turns_about_z &= all(axis in ALONG_Z for axis in _axes(system, instance))
    held = _held(system, joints)
    return (all(held) or not needs_hold) and all(
        joint.stays_in_plane or all(held[k] for k in ends if k != GROUND_INDEX)
        for (_, ends), joint in joints.items()
    )


def plane_of(system: System) -> Plane | None:
    """Coordinate plane in which all bodies of a system stay, None of no plane.

    A scene in the xy-plane is meant to be planar. In another plane only joints make it so: a chain
    that hangs at rest stays in a plane, too, but not when it is started otherwise.
    """
    if is_planar(system):
        return Plane.XY
    for plane in (Plane.YZ, Plane.ZX) if can_permute(system) else ():
        if is_planar(permuted(system, plane.value), must_be_held=True):
            return plane
    return None


@dataclass(slots=True)
class _Joint:
    """Derivatives of a joint at the start: (rows, six for each body) of each instance.

    Parameters
    ----------
    live, dropped : list of array
        Derivatives of the remaining rows, and of the dropped ones.
    turns_about_z : bool
        Whether all its axes are along z. Then for any planar motion the dropped rows are those of
        the start, each block turned about z, and their rank does not change.
    """

    live: list[Any] = field(default_factory=list)
    dropped: list[Any] = field(default_factory=list)
    turns_about_z: bool = True

    @property
    def stays_in_plane(self) -> bool:
        """Whether no reaction of a remaining row leads out of the plane."""
        return not any(
            np.any(self._out(rows, side))
            for rows in self.live
            for side in range(rows.shape[1] // COLUMNS)
        )

    def holds(self, side: int) -> bool:
        """Whether the body on one side cannot leave the plane while the other stays."""
        rows = np.vstack([self._out(rows, side) for rows in self.dropped])
        if not self.turns_about_z or len(rows) < len(OUT):
            return False
        return bool(np.linalg.svd(rows, compute_uv=False)[-1] > LEAST_HOLDING_SINGULAR_VALUE)

    @staticmethod
    def _out(rows: Any, side: int) -> Any:
        return rows[:, [side * COLUMNS + k for k in OUT]]


def _may_hold(system: System) -> bool:
    """Whether the joints that turn about z alone connect all bodies to the ground.

    Other joints hold no body in the plane. This costs little, and most scenes in space end here.
    """
    neighbours: dict[int, list[int]] = {}
    joints: dict[tuple[str, tuple[int, ...]], bool] = {}
    for c in system.constraints:
        turns_about_z = c.is_combination or all(a in ALONG_Z for a in _axes(system, c))
        key = (c.joint, c.bodies)
        joints[key] = joints.get(key, True) and turns_about_z
    for (_, ends), turns_about_z in joints.items():
        for k in ends if turns_about_z else ():
            neighbours.setdefault(k, []).extend(ends)
    reached = {GROUND_INDEX: None}
    waiting = [GROUND_INDEX]
    while waiting:
        for k in neighbours.get(waiting.pop(), ()):
            if k not in reached:
                reached[k] = None
                waiting.append(k)
    return len(reached) > len(system.bodies)


def _starts_in_plane(body: MovingBody) -> bool:
    (*_, e1, e2, _), (_, _, v_z, *omega) = start(body)
    return e1 == e2 == v_z == omega[0] == omega[1] == 0


def _at_start(system: System, instance: Instance) -> tuple[Sequence[float], Any]:
    """Residuals and Jacobian (rows, six for each body) of an instance at the start.

    A residual that changes with time, or with a parameter, is infinite.
    """
    if not instance.is_combination:
        residual, jacobian = kernel_at_start(system, instance)
        return residual, np.reshape(jacobian, (-1, 2 * COLUMNS))
    total = instance.offset - fixed_law(instance, [name for name, _ in system.parameters])
    rows = np.zeros((1, len(instance.bodies), COLUMNS))
    for term in instance.terms:
        coordinate = system.coordinates[term.coordinate]
        (value,), jacobian = kernel_at_start(system, coordinate)
        turns = round((coordinate.near - value) / math.tau) if coordinate.counts_turns else 0
        total += term.factor * (value + math.tau * turns)
        blocks = np.reshape(jacobian, (2, COLUMNS))
        for body, block in zip((coordinate.i, coordinate.j), blocks, strict=True):
            rows[0, instance.bodies.index(body)] += term.factor * block
    return [total], rows.reshape(1, -1)


def _axes(system: System, instance: Instance) -> list[tuple[float, ...]]:
    """Axes of an instance, or of the coordinates that it combines.

    A kind of one's own may do anything with axes: its axis is empty, which is along none.
    """
    if is_own(instance.kind):
        return [()]
    constants = list(instance.constants)
    for term in instance.terms:
        constants += system.coordinates[term.coordinate].constants
    return [value for name, value in constants if is_axis(name)]


def _held(system: System, joints: dict[tuple[str, tuple[int, ...]], _Joint]) -> list[bool]:
    """Mask of bodies that joints, one after another from the ground, hold in the plane."""
    held = [False] * len(system.bodies)
    dependents: list[list[int]] = [[] for _ in system.bodies]
    waiting: list[int] = []
    for (_, (i, j, *_)), joint in joints.items():
        for side, (body, other) in enumerate(((i, j), (j, i))):
            if body != GROUND_INDEX and joint.holds(side):
                if other == GROUND_INDEX:
                    waiting.append(body)
                else:
                    dependents[other].append(body)
    while waiting:
        body = waiting.pop()
        if not held[body]:
            held[body] = True
            waiting.extend(dependents[body])
    return held
