"""Momentum in the ledger of a run: its change where it is conserved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from kousoku.runtime.messages import MOST_PARTS_SHOWN

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


@dataclass(frozen=True, slots=True)
class ConservedPlaces:
    """Directions along which a part of a scene conserves its momenta.

    A part are bodies that joints and forces connect, the ground left out.

    Parameters
    ----------
    bodies : tuple of str
        Their names.
    linear, angular : tuple of (3,)
        Directions in frame O along which its linear momentum does not change, and its angular
        momentum.
    is_central : bool
        Whether the angular momentum is about its centre of mass, not about a point of the ground.
    """

    bodies: tuple[str, ...]
    linear: tuple[tuple[float, ...], ...]
    angular: tuple[tuple[float, ...], ...]
    is_central: bool = True

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> ConservedPlaces:
        """Momenta of a part from ``motion.json``."""
        linear, angular = (tuple(map(tuple, data[name])) for name in ("linear", "angular"))
        return cls(tuple(data["bodies"]), linear, angular, data["is_central"])


@dataclass(frozen=True, slots=True)
class Momentum:
    """Change of the momentum of a part, the largest of all rows that were written.

    |p·n − (p·n)₀| with p = Σ m v, and of L = Σ (r − o) × m v + A I′ω′ (3,), frame O, along
    directions n.

    Parameters
    ----------
    bodies : tuple of str
        The part.
    linear : float or None [kg m/s]
        Largest change along a direction along which there should be none; None where none is such.
    angular : float or None [kg m²/s]
        The same of the angular momentum.
    is_central : bool
        Whether that is about its centre of mass, not about a point of the ground.
    """

    bodies: tuple[str, ...]
    linear: float | None
    angular: float | None
    is_central: bool = True

    def as_data(self) -> dict[str, object]:
        """Change as data, ready for JSON."""
        about = "centre of mass" if self.is_central else "a point of the ground"
        numbers = {"linear": self.linear, "angular": self.angular}
        return {"bodies": list(self.bodies), **numbers, "about": about}

    def __str__(self) -> str:
        is_cut = len(self.bodies) > MOST_PARTS_SHOWN
        named = ", ".join(self.bodies[:MOST_PARTS_SHOWN]) + ", …" * is_cut
        about = "" if self.is_central else " about a point of the ground"
        texts = [
            f"{size:.1e} {unit}"
            for size, unit in ((self.linear, "kg m/s"), (self.angular, f"kg m²/s{about}"))
            if size is not None
        ]
        return f"momentum of {named}: largest change {', '.join(texts)}"


def momenta_of(
    conserved: Sequence[ConservedPlaces], changes: Sequence[float]
) -> tuple[Momentum, ...]:
    """Changes |p·n − (p·n)₀| of momenta, by part.

    Parameters
    ----------
    conserved : sequence of ConservedPlaces
        The parts.
    changes : (n,) sequence of float [kg m/s, kg m²/s]
        Part by part, of each direction of its linear momentum, then of each of its angular one.
    """
    momenta = []
    start = 0
    for part in conserved:
        middle = start + len(part.linear)
        end = middle + len(part.angular)
        linear, angular = (
            max(block, default=None) for block in (changes[start:middle], changes[middle:end])
        )
        momenta.append(Momentum(part.bodies, linear, angular, part.is_central))
        start = end
    return tuple(momenta)
