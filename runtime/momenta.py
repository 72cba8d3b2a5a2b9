"""Momentum in the ledger of a run: how far it changed where it should not have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

#: Bodies, and parts, that a text names.
SHOWN = 3


@dataclass(frozen=True, slots=True)
class KeptPlaces:
    """What a part of a scene keeps: bodies that joints and forces connect, and nothing to ground.

    Parameters
    ----------
    bodies : tuple of str
        Their names.
    linear, angular : tuple of (3,)
        Directions in frame O along which its linear momentum does not change, and its angular
        momentum about its centre of mass.
    """

    bodies: tuple[str, ...]
    linear: tuple[tuple[float, ...], ...]
    angular: tuple[tuple[float, ...], ...]

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> KeptPlaces:
        """Return what ``motion.json`` says of a part."""
        linear, angular = (tuple(map(tuple, data[name])) for name in ("linear", "angular"))
        return cls(tuple(data["bodies"]), linear, angular)


@dataclass(frozen=True, slots=True)
class Momentum:
    """How far the momentum of a part changed, the largest of all rows that were written.

    Parameters
    ----------
    bodies : tuple of str
        The part.
    linear : float or None [kg m/s]
        Largest change along a direction along which there should be none; None where none is such.
    angular : float or None [kg m²/s]
        The same of the angular momentum about its centre of mass.
    """

    bodies: tuple[str, ...]
    linear: float | None
    angular: float | None

    def as_data(self) -> dict[str, object]:
        """Return it ready for JSON."""
        return {"bodies": list(self.bodies), "linear": self.linear, "angular": self.angular}

    def __str__(self) -> str:
        named = ", ".join(self.bodies[:SHOWN]) + ", …" * (len(self.bodies) > SHOWN)
        texts = [
            f"{size:.1e} {unit}"
            for size, unit in ((self.linear, "kg m/s"), (self.angular, "kg m²/s"))
            if size is not None
        ]
        return f"momentum of {named}: largest change {', '.join(texts)}"


def momenta_of(kept: Sequence[KeptPlaces], changes: Sequence[float]) -> tuple[Momentum, ...]:
    """Return the changes by part.

    Parameters
    ----------
    kept : sequence of KeptPlaces
        The parts.
    changes : sequence of float
        Part by part, first linear, then angular.
    """
    found = []
    at = 0
    for one in kept:
        turn = at + len(one.linear)
        end = turn + len(one.angular)
        linear, angular = (
            max(part, default=None) for part in (changes[at:turn], changes[turn:end])
        )
        found.append(Momentum(one.bodies, linear, angular))
        at = end
    return tuple(found)
