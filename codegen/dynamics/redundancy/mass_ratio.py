"""Light bodies that hang between heavy ones, so that C_q M⁻¹ C_qᵀ cancels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from kousoku.model.mechanics.multibody import GROUND_INDEX

if TYPE_CHECKING:
    from kousoku.model.mechanics.multibody import System

LIGHT = 1e-4
"""A body of less than this part of the masses of two neighbours, or moments, costs four digits."""


def has_extreme_mass_ratio(system: System) -> bool:
    """Whether a body is much lighter than two bodies, or a body and the ground, it joins.

    The inverse of its mass then outweighs theirs in the rows of both joints, and the elimination of
    one row from the other leaves the small difference of large numbers.
    """
    pairs = {tuple(sorted(set(instance.bodies))) for instance in system.constraints}
    neighbours: dict[int, list[int]] = {}
    for a, b in (pair for pair in pairs if len(pair) == 2):
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    sizes = [(float(body.mass), float(max(body.inertia))) for body in system.bodies]
    for body, adjacent in neighbours.items():
        if body == GROUND_INDEX or len(adjacent) < 2:
            continue
        for size, *of_adjacent in zip(*(_sizes(sizes, k) for k in (body, *adjacent)), strict=True):
            if 0.0 < size < LIGHT * sorted(of_adjacent)[-2]:
                return True
    return False


def _sizes(sizes: list[tuple[float, float]], body: int) -> tuple[float, float]:
    """Mass and largest moment of a body; of the ground they are infinite."""
    return (math.inf, math.inf) if body == GROUND_INDEX else sizes[body]
