"""Pictures of couplings: two bodies on a frame that is not drawn, and the coupled coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.view.joint_shapes import (
    BoxShape,
    CylinderShape,
    JointFreedom,
    JointPicture,
    Owner,
    Solid,
    X,
    Y,
    Z,
)

if TYPE_CHECKING:
    from kousoku.model.records.orientation import Vector


def _rope(low: Vector, high: Vector) -> Solid:
    return CylinderShape("-", low, high, 0.025)


def _pulley(owner: Owner, x: float, z: float) -> Solid:
    return CylinderShape(owner, (x, 0.12, z), (x, -0.12, z), 0.45)


#: Body i is that of the first joint, body j that of the second one; both may move.
COUPLING_PICTURES: dict[str, JointPicture] = {
    "gear": JointPicture(
        (
            CylinderShape("j", (0.9, 0.15, 0.0), (0.9, -0.15, 0.0), 1.0),
            CylinderShape("i", (-0.7, 0.15, 0.0), (-0.7, -0.15, 0.0), 0.6),
        ),
        (
            JointFreedom("turn", Y, (-0.7, -0.15, 0.0), 0.38),
            JointFreedom("turn", Y, (0.9, -0.15, 0.0), 0.65),
        ),
        (((-0.7, 0.0, 0.0), Y), ((0.9, 0.0, 0.0), Y)),
        (),
    ),
    "rack_and_pinion": JointPicture(
        (
            BoxShape("j", (-1.7, -0.15, -0.6), (1.7, 0.15, -0.3)),
            CylinderShape("i", (0.0, 0.15, 0.4), (0.0, -0.15, 0.4), 0.7),
        ),
        (
            JointFreedom("turn", Y, (0.0, -0.15, 0.4), 0.42),
            JointFreedom("shift", X, (0.0, -0.15, -0.85), 0.9),
        ),
        (((0.0, 0.0, 0.4), Y),),
        (),
    ),
    "linear": JointPicture(
        (
            BoxShape("-", (-0.8, -0.2, 1.35), (1.5, 0.2, 1.45)),
            _rope((1.05, 0.0, -0.2), (1.05, 0.0, 1.35)),
            CylinderShape("-", (-0.3, 0.0, 0.8), (-0.3, 0.0, 1.35), 0.06),
            _rope((-0.75, 0.0, -0.5), (-0.75, 0.0, 0.8)),
            BoxShape("i", (-1.05, -0.25, -1.1), (-0.45, 0.25, -0.5)),
            _rope((0.15, 0.0, -0.2), (0.15, 0.0, 0.8)),
            _pulley("-", -0.3, 0.8),
            BoxShape("j", (0.25, -0.3, -1.4), (0.95, 0.3, -0.8)),
            CylinderShape("j", (0.6, 0.0, -0.8), (0.6, 0.0, -0.2), 0.06),
            _pulley("j", 0.6, -0.2),
        ),
        (
            JointFreedom("shift", Z, (-1.4, 0.0, -0.7), 0.5),
            JointFreedom("shift", Z, (1.4, 0.0, -0.9), 0.25),
        ),
        (),
        (),
    ),
}
