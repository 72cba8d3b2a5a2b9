"""What bodies of random scenes are: orientations in all forms, masses of all parts, and starts."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from tests.random_geometry import DIRECTIONS, TURNS, Pose, dot, product, rotation, turn

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.random_draft import Draft, Tree
    from tests.random_geometry import Matrix


def _axis_angle(draft: Draft) -> tuple[Tree, Matrix]:
    axis, angle = draft.draw.choice(DIRECTIONS), draft.number(-2.5, 2.5)
    return {"axis": list(axis), "angle": angle}, turn(axis, angle)


def _rotation_vector(draft: Draft) -> tuple[Tree, Matrix]:
    axis = draft.draw.choice(DIRECTIONS)
    return {"rotation_vector": list(axis)}, turn(axis, math.sqrt(dot(axis, axis)))


def _angles(draft: Draft, about: str) -> tuple[Tree, Matrix]:
    sequence = draft.draw.choice(("zyx", "xyz", "zxz", "yzy"))
    angles = [draft.number(-1.5, 1.5) for _ in range(3)]
    A = Pose().A
    for letter, angle in zip(sequence, angles, strict=True):
        one = turn(DIRECTIONS[{"x": 1, "y": 2, "z": 0}[letter]], angle)
        A = product(A, one) if about == "body" else product(one, A)
    return {"angles": angles, "sequence": sequence, "about": about}, A


def _quaternion(draft: Draft, order: str) -> tuple[Tree, Matrix]:
    w, x, y, z = draft.draw.choice(TURNS)
    p = [w, x, y, z] if order == "wxyz" else [x, y, z, w]
    return {"quaternion": p, "order": order}, rotation(w, (x, y, z))


def _matrix(draft: Draft) -> tuple[Tree, Matrix]:
    w, x, y, z = draft.draw.choice(TURNS)
    A = rotation(w, (x, y, z))
    return {"matrix": [list(row) for row in A]}, A


ORIENTATIONS: dict[str, Callable[[Draft], tuple[Tree, Matrix]]] = {
    "none": lambda _: ({}, Pose().A),
    "wxyz": lambda draft: _quaternion(draft, "wxyz"),
    "xyzw": lambda draft: _quaternion(draft, "xyzw"),
    "matrix": _matrix,
    "axis": _axis_angle,
    "rotation vector": _rotation_vector,
    "body angles": lambda draft: _angles(draft, "body"),
    "fixed angles": lambda draft: _angles(draft, "fixed"),
}
"""The forms of orientations: what is written, and A."""


def _inertia(draft: Draft, **more: float) -> Tree:
    size = draft.number(0.5, 2) * draft.metre**2
    if more:
        moments: Tree = {"xx": size, "yy": 1.25 * size, "zz": 0.75 * size}
        return moments | {key: share * size for key, share in more.items()}
    return {"xx": draft.design(size), "yy": 1.25 * size, "zz": draft.design(0.75 * size)}


def _solid(draft: Draft, **numbers: Any) -> Tree:
    return {"mass": draft.design(draft.number(0.5, 2)), **numbers}


def _ends(draft: Draft) -> list[list[float]]:
    return [list(draft.vector(draft.metre / 4)), [draft.length(0.5, 1), 0.0, draft.metre / 8]]


MASSES: dict[str, Callable[[Draft], Tree]] = {
    "mass": lambda draft: _solid(draft, inertia=_inertia(draft)),
    "center": lambda draft: _solid(
        draft, center=draft.designs(draft.vector(0.25 * draft.metre)), inertia=_inertia(draft)
    ),
    "products": lambda draft: _solid(draft, inertia=_inertia(draft, xy=0.1, yz=-0.2, zx=0.05)),
    "about": lambda draft: {
        "mass": 1.0,
        "center": [0, 0.1 * draft.metre, 0],
        "inertia": _inertia(draft) | {"about": [0.1 * draft.metre, 0, 0]},
    },
    "boxes": lambda draft: {
        "boxes": [_solid(draft, size=[draft.design(draft.length(0.25, 1)) for _ in range(3)])]
    },
    "turned box": lambda draft: {
        "boxes": [
            {"mass": 1.5, "size": [draft.metre, draft.metre / 2, draft.metre / 4]}
            | {
                "at": list(draft.vector(draft.metre / 4)),
                "orientation": _quaternion(draft, "wxyz")[0],
            }
        ]
    },
    "cylinders": lambda draft: {
        "cylinders": [_solid(draft, radius=draft.design(draft.length(0.1, 0.3)), ends=_ends(draft))]
    },
    "spheres": lambda draft: {
        "spheres": [_solid(draft, radius=draft.design(draft.length(0.25, 0.5)))]
    },
    "rods and points": lambda draft: {
        "rods": [{"mass": 1.0, "ends": _ends(draft)}],
        "mass_points": [
            {"mass": 0.5, "at": [0.0, draft.metre / 2, 0.0]},
            {"mass": 0.25, "at": list(draft.vector(draft.metre))},
        ],
    },
}
"""What bodies are made of."""

STARTS: tuple[Callable[[Draft], Tree], ...] = (
    lambda _: {},
    lambda draft: {"angular_velocity": list(draft.vector(2))},
    lambda draft: {"velocity": list(draft.vector(draft.metre))},
    lambda draft: {"angular_velocity_b": list(draft.vector(3))},
    lambda draft: {} if draft.is_parametric or draft.is_written_off else {"hold": ["x", "y", "z"]},
    lambda draft: {} if draft.is_parametric or draft.is_written_off else {"hold": ["orientation"]},
)
"""Velocities at the start, and what assembly may not change."""
