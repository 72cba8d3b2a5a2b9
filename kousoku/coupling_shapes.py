"""Pictures of couplings: two bodies on a frame that is not drawn, and what is coupled."""

from __future__ import annotations

from kousoku.joint_shapes import Box, Cylinder, Freedom, Shape, X, Y

#: Body i is that of the first joint, body j that of the second one; both may move.
COUPLED: dict[str, Shape] = {
    "gear": Shape(
        (
            Cylinder("j", (0.9, 0.15, 0.0), (0.9, -0.15, 0.0), 1.0),
            Cylinder("i", (-0.7, 0.15, 0.0), (-0.7, -0.15, 0.0), 0.6),
        ),
        (
            Freedom("turn", Y, (-0.7, -0.15, 0.0), 0.38),
            Freedom("turn", Y, (0.9, -0.15, 0.0), 0.65),
        ),
        (((-0.7, 0.0, 0.0), Y), ((0.9, 0.0, 0.0), Y)),
        (),
    ),
    "rack_and_pinion": Shape(
        (
            Box("j", (-1.7, -0.15, -0.6), (1.7, 0.15, -0.3)),
            Cylinder("i", (0.0, 0.15, 0.4), (0.0, -0.15, 0.4), 0.7),
        ),
        (
            Freedom("turn", Y, (0.0, -0.15, 0.4), 0.42),
            Freedom("shift", X, (0.0, -0.15, -0.85), 0.9),
        ),
        (((0.0, 0.0, 0.4), Y),),
        (),
    ),
}
