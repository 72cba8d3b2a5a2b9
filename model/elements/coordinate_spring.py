"""The spring against a coordinate: the element of rotational springs, friction and bushings."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from kousoku.model.elements.along import is_length
from kousoku.model.elements.force import scalars
from kousoku.model.mechanics.multibody import ForceElement

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.elements.force import Lowering
    from kousoku.model.numbers.precise import High
    from kousoku.model.records.spatial import Value


@dataclass(frozen=True, slots=True)
class CoordinateSpring(ForceElement):
    """A spring and damper against a coordinate u: τ = −k (u − u⁰) − c u̇ (1,) [N or N m], by Jᵀτ.

    Of ``constants`` ``stiffness`` k [N/m or N m/rad] and ``damping`` c [N s/m or N m s/rad] by the
    coordinate and its rate, then ``free`` u⁰ [m or rad]; with a law of its own ``moment``, its
    unit, and ``free``. J (1, 12) has the columns δr in frame O, δθ′ in the body frame.
    """

    kind: str = field(init=False, default="coordinate_spring")

    @property
    def has_potential(self) -> bool:
        """Whether it is linear."""
        return not self.law


def linear_spring(
    name: str,
    index: int,
    law: tuple[Value | None, Value | None],
    lowering: Lowering,
    free: Value | High = 0.0,
) -> CoordinateSpring:
    """Linear spring against a coordinate: τ = −k (u − u⁰) − c u̇ (1,) [N or N m].

    Parameters
    ----------
    name : str
        Of the force in the scene.
    index : int
        Of the coordinate in the list of the scene.
    law : (float or str, float or str)
        Stiffness k and damping c in the unit of the scene; None is zero.
    lowering : Lowering
        Scene, frames and coordinates.
    free : float or str [m or rad]
        u⁰, where it has no force.
    """
    from kousoku.model.numbers import precise

    one = precise.number(1)
    stiffness, damping = law
    scale = one if is_length(lowering, index) else lowering.unit**2
    numbers = {"stiffness": (stiffness or 0.0, scale), "damping": (damping or 0.0, scale)}
    return spring_against(name, index, numbers | {"free": (free, one)}, lowering)


def spring_against(
    name: str,
    index: int,
    numbers: Mapping[str, tuple[Any, High]],
    lowering: Lowering,
    law: str = "",
) -> CoordinateSpring:
    """Spring against a coordinate, τ = τ(u, u̇) (1,) [N or N m]: of numbers with units, or a law."""
    u = lowering.coordinates.record(index)
    constants, formulas = scalars(numbers)
    return CoordinateSpring(name, u.i, u.j, constants, law, formulas, index)
