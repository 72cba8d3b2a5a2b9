"""The same system with its axes in another order, so that any coordinate plane can be the xy-plane.

Axes are exchanged in turn, x for y for z for x, in frame O and in all body frames. That is a
rotation, and nothing else changes: no sign and no product. A system whose bodies stay in the
xz-plane is composed as one that stays in the xy-plane, and its coordinates are named back.
"""

from __future__ import annotations

from dataclasses import replace
from enum import Enum
from typing import TYPE_CHECKING, TypeVar

from kousoku.model.mechanics.constraints import base_and_axis, components_of, is_known

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from kousoku.codegen.dynamics.recording.program import Program, RowIndex
    from kousoku.model.mechanics.multibody import Instance, MovingBody, System

    T = TypeVar("T")
    Triple = tuple[T, T, T]
    Constants = tuple[tuple[str, tuple[float, ...]], ...]

AXIS_LETTERS = "xyz"
#: The axis normal to the xy-plane.
NORMAL = 2


class Plane(Enum):
    """A coordinate plane of frame O; its value is the cyclic shift of axes that makes it xy."""

    XY = 0
    YZ = 1
    ZX = 2

    @property
    def normal(self) -> int:
        """Axis normal to it."""
        return (NORMAL + self.value) % 3


def shift_of(plane: Plane | None) -> int:
    """Cyclic shift of axes that makes a plane the xy-plane; 0 in space."""
    return 0 if plane is None else plane.value


def can_permute(system: System) -> bool:
    """Whether all kinds of a system are known to mean the same after a turn."""
    kinds = [instance.kind for instance in system.constraints]
    kinds += [coordinate.kind for coordinate in system.coordinates]
    return all(map(is_known, kinds))


def permuted(system: System, shift: int) -> System:
    """System whose component k is component k + shift of the given one, modulo 3.

    It is turned by a rotation of frame O and all principal frames alike, P (3, 3): r → P r [m], A →
    P A Pᵀ, I′ → P I′Pᵀ, so that every equation C = 0 stays what it is.
    """
    if not shift:
        return system
    return replace(
        system,
        bodies=tuple(_permuted_body(body, shift) for body in system.bodies),
        constraints=tuple(_permuted_instance(instance, shift) for instance in system.constraints),
        gravity=_triple(system.gravity, shift),
        gravity_law=_triple(system.gravity_law, shift),
        coordinates=tuple(
            replace(coordinate, constants=_permuted_constants(coordinate.constants, shift))
            for coordinate in system.coordinates
        ),
        forces=tuple(
            replace(force, constants=_permuted_constants(force.constants, shift))
            for force in system.forces
        ),
    )


def permuted_columns(columns: Sequence[int], shift: int) -> tuple[int, ...]:
    """Columns (c,) of a body, of δr (frame O) and δθ′ (body frame), in the permuted system."""
    return tuple(sorted(k // 3 * 3 + (k - shift) % 3 for k in columns))


def permuted_rows(rows: Iterable[RowIndex], system: System, shift: int) -> tuple[RowIndex, ...]:
    """Rows of a system as rows of the permuted system."""
    kinds = [c.kind for c in system.constraints]
    return tuple(
        replace(row, row=permuted_row(kinds[row.instance], row.row, shift)) for row in rows
    )


def permuted_row(kind: str, row: int, shift: int) -> int:
    """Row of the permuted kind that is a row of a kind; those of one's own are not permuted."""
    if not (kept := components_of(kind)):
        return row
    return components_of(_permuted_kind(kind, shift)).index((kept[row] - shift) % 3)


def permuted_back(program: Program, system: System, shift: int) -> Program:
    """Program of a permuted system with coordinates and rows named as in the scene.

    Parameters
    ----------
    program : Program
        The program of the permuted system.
    system : System
        The permuted system.
    shift : int
        The cyclic shift of its axes.
    """
    back = -shift
    bodies = tuple(
        replace(
            body,
            r=_triple(body.r, back),
            p=(body.p[0], *_triple(body.p[1:], back)),
            v=_triple(body.v, back),
            omega_b=_triple(body.omega_b, back),
        )
        for body in program.bodies
    )
    return replace(
        program,
        bodies=bodies,
        rows=permuted_rows(program.rows, system, back),
        left_out=permuted_rows(program.left_out, system, back),
        satisfied=permuted_rows(program.satisfied, system, back),
    )


def _triple(values: Sequence[T], shift: int) -> Triple[T]:
    x, y, z = (values[(k + shift) % 3] for k in range(3))
    return x, y, z


def _permuted_body(body: MovingBody, shift: int) -> MovingBody:
    e0, *e = body.p
    return replace(
        body,
        inertia=_triple(body.inertia, shift),
        r=_triple(body.r, shift),
        p=(e0, *_triple(e, shift)),
        v=_triple(body.v, shift),
        omega_b=_triple(body.omega_b, shift),
        origin_b=_triple(body.origin_b, shift),
        axes_b=(body.axes_b[0], *_triple(body.axes_b[1:], shift)),
    )


def _permuted_instance(instance: Instance, shift: int) -> Instance:
    constants = _permuted_constants(instance.constants, shift)
    return replace(instance, kind=_permuted_kind(instance.kind, shift), constants=constants)


def _permuted_constants(constants: Constants, shift: int) -> Constants:
    return tuple(
        (name, _triple(values, shift) if len(values) == 3 else values) for name, values in constants
    )


def _permuted_kind(kind: str, shift: int) -> str:
    base, axis = base_and_axis(kind)
    return f"{base}_{AXIS_LETTERS[(AXIS_LETTERS.index(axis) - shift) % 3]}" if axis else kind
