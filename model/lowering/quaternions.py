"""Orientations of a scene as Euler parameters in 50 digits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.numbers import precise
from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.precise import IDENTITY, Quadruple, compose

if TYPE_CHECKING:
    from kousoku.model.records.orientation import Orientation


def quaternion(orientation: Orientation | None) -> Quadruple:
    """Euler parameters of an orientation that was checked, of any length but zero.

    Parameters
    ----------
    orientation : Orientation, optional
        None is that of the other frame.

    Returns
    -------
    (4,) [-]
        Scalar first, in 50 digits: components in the frame to those in the other frame.
    """
    if orientation is None:
        return IDENTITY
    if orientation.quaternion is not None:
        w, x, y, z = map(CONTEXT.mpf, orientation.quaternion)
        return (w, x, y, z) if orientation.order == "wxyz" else (z, w, x, y)
    if orientation.matrix is not None:
        first, second, third = map(precise.triple, orientation.matrix)
        return precise.quaternion_of((first, second, third))
    if orientation.angles is not None:
        return _from_angles(orientation)
    if orientation.rotation_vector is not None:
        axis = precise.triple(orientation.rotation_vector)
        return _about(axis, precise.length(axis))
    assert orientation.axis is not None and orientation.angle is not None
    return _about(precise.triple(orientation.axis), precise.number(orientation.angle))


def _from_angles(orientation: Orientation) -> Quadruple:
    assert orientation.angles is not None
    assert orientation.sequence is not None
    p = IDENTITY
    for letter, angle in zip(orientation.sequence, orientation.angles, strict=True):
        turn = _about(
            precise.triple(float(letter == name) for name in "xyz"), precise.number(angle)
        )
        p = compose(p, turn) if orientation.about == "body" else compose(turn, p)
    return p


def _about(axis: precise.Triple, angle: precise.High) -> Quadruple:
    """Rotation about an axis of any length; none where the axis is zero."""
    size = precise.length(axis)
    if size == 0:
        return IDENTITY
    half = angle / 2
    return (CONTEXT.cos(half), *precise.scale(CONTEXT.sin(half) / size, axis))
