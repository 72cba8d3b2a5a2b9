"""Which number of a row belongs to which body, joint and coordinate, as ``motion.json`` says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True, slots=True)
class ReactionPlaces:
    """Where the force and torque of a joint stand among the reactions of a row.

    Parameters
    ----------
    joint : str
        As in the scene.
    body : int
        The body that they act on, at its centre of mass.
    j : int
        Body j of the joint, -1 for the ground; if it is the ground they act on body i.
    point_b : (3,) [m]
        The joint's point in the principal frame of body j, or in frame O.
    columns : (6,) tuple of int
        Places of force (frame O) and torque (principal frame), -1 where there is no coordinate.
    """

    joint: str
    body: int
    j: int
    point_b: tuple[int | float, ...]
    columns: tuple[int, ...]

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> ReactionPlaces:
        """Return what ``motion.json`` says of a joint."""
        return cls(
            data["joint"], data["body"], data["j"], tuple(data["point_b"]), tuple(data["columns"])
        )


@dataclass(frozen=True, slots=True)
class CoordinatePlaces:
    """Where a coordinate stands among the coordinates of a row.

    Parameters
    ----------
    name : str
        As in the scene.
    is_length : bool
        Whether it is a length; else it has no unit of length.
    columns : tuple of int
        Places of value, rate and, where accelerations are wanted, second derivative.
    """

    name: str
    is_length: bool
    columns: tuple[int, ...]

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> CoordinatePlaces:
        """Return what ``motion.json`` says of a coordinate."""
        return cls(data["name"], data["is_length"], tuple(data["columns"]))
