"""Scenes that grow: chains and N-four-bars of any length, to test and to measure with."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.reading.builder import SceneBuilder

if TYPE_CHECKING:
    from kousoku.model.records.scene import Scene


def chain(count: int) -> Scene:
    """Chain of bars that hangs on the ground and stretches along x, at rest.

    Each bar is a uniform box of 1 m x 0.1 m x 0.1 m and 1 kg. Its frame has its origin at the joint
    with the bar before; the joints are revolute, about y, z, y, … Gravity is 9.81 m/s² along −z.

    Parameters
    ----------
    count : int
        Bars, one at least.
    """
    builder = SceneBuilder(f"chain_{count}", unit="m").gravity(0, 0, -9.81)
    previous = "ground"
    for k in range(count):
        name = f"bar_{k}"
        builder.body(
            name,
            position=(k, 0, 0),
            boxes=[{"mass": 1, "size": (1, 0.1, 0.1), "at": (0.5, 0, 0)}],
        )
        builder.joint(
            f"joint_{k}",
            type="revolute",
            bodies=(previous, name),
            at=(k, 0, 0),
            axis=(0, 0, 1) if k % 2 else (0, 1, 0),
        )
        previous = name
    return builder.build()


def n_four_bar(
    count: int, *, turned: tuple[float, float] = (0.0, 1.0), rate: float = -1.0
) -> Scene:
    """N-four-bar of the IFToMM library of benchmark problems (A02).

    It has N + 1 cranks of 1 m on ground points 1 m apart along x, and N couplers of 1 m between
    their ends: uniform rods of 1 kg. The plane is x, y; gravity is 9.81 m/s² along −y.

    Parameters
    ----------
    count : int
        N, one at least.
    turned : (2,) [m]
        The end of a crank, seen from its ground point: a vector of norm one.
    rate : float [rad/s]
        Angular velocity of the cranks about z; −1 is clockwise.
    """
    x, y = turned
    builder = SceneBuilder(f"n_four_bar_{count}", unit="m").gravity(0, -9.81, 0)
    for k in range(count + 1):
        crank = f"crank_{k}"
        builder.body(
            crank,
            position=(k, 0, 0),
            angular_velocity=(0, 0, rate),
            rods=[{"mass": 1, "ends": ((0, 0, 0), (x, y, 0))}],
        )
        builder.joint(
            f"ground_{k}", type="revolute", bodies=("ground", crank), at=(k, 0, 0), axis=(0, 0, 1)
        )
    for k in range(count):
        coupler, end = f"coupler_{k}", (k + x, y, 0)
        builder.body(
            coupler,
            position=end,
            velocity=(-rate * y, rate * x, 0),
            rods=[{"mass": 1, "ends": ((0, 0, 0), (1, 0, 0))}],
        )
        for side, at in enumerate((end, (k + x + 1, y, 0))):
            builder.joint(
                f"{'after' if side else 'before'}_{k}",
                type="revolute",
                bodies=(f"crank_{k + side}", coupler),
                at=at,
                axis=(0, 0, 1),
            )
    return builder.build()
