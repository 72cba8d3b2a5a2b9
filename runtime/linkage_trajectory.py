"""The motion of a linkage as arrays, as columns, as a file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.runtime.tables import save_columns

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    import numpy.typing as npt

    Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Positions of a linkage, row by row, with what was wanted beside them.

    Lengths are in the unit of the scene, angles in radians, times in seconds, vectors in frame O.
    Mappings keep the order of the scene; what was not wanted is an empty mapping.

    Parameters
    ----------
    name, unit : str
        The scene and its unit of length.
    method : {"newton", "paper"}
        How positions were found.
    divisions : int
        Divisions of a turn.
    inputs : mapping of str to (rows,) array
        The prescribed coordinates by name; angles count on over the turns.
    positions, velocities, accelerations : mapping of str to (rows, 2) array
        Of each node.
    angles, angular_velocities, angular_accelerations : mapping of str to (rows,) array
        Of each link, from +x to the direction from its first to its second node.
    iterations : (rows,) array of int
        Corrections in the step that led to each row.
    residual : (rows,) array
        Largest residual at each row.
    links : tuple of (str, str, str, float)
        Name, nodes and design length of each link.
    target : {"c", "numpy"}
        What computed.
    time : (rows,) array [s], optional
        Of each row, where the inputs were followed in time.
    """

    name: str
    unit: str
    method: str
    divisions: int
    inputs: Mapping[str, Array]
    positions: Mapping[str, Array]
    velocities: Mapping[str, Array]
    accelerations: Mapping[str, Array]
    angles: Mapping[str, Array]
    angular_velocities: Mapping[str, Array]
    angular_accelerations: Mapping[str, Array]
    iterations: npt.NDArray[np.intc]
    residual: Array
    links: tuple[tuple[str, str, str, float], ...]
    target: str
    time: Array | None = None

    def __len__(self) -> int:
        return len(self.residual)

    @property
    def alpha(self) -> Array:
        """The input, (rows,), or with several inputs all of them, (rows, inputs)."""
        columns = tuple(self.inputs.values())
        return columns[0] if len(columns) == 1 else np.stack(columns, axis=-1)

    @property
    def residual_max(self) -> float:
        """The largest residual of all rows."""
        return float(np.max(self.residual, initial=0.0))

    def columns(self) -> dict[str, Array]:
        """Return the columns of a file by name.

        First the ``time``, where there is one. The input is called ``alpha``; several inputs are
        called by their names. Then ``O1.x O1.y O1.vx O1.vy O1.ax O1.ay`` and so on, then
        the angles of links.
        """
        is_single = len(self.inputs) == 1
        table = {} if self.time is None else {"time": self.time}
        table |= {"alpha" if is_single else name: value for name, value in self.inputs.items()}
        motions = (("", self.positions), ("v", self.velocities), ("a", self.accelerations))
        for node in self.positions:
            for letter, motion in motions:
                if node in motion:
                    table[f"{node}.{letter}x"] = motion[node][:, 0]
                    table[f"{node}.{letter}y"] = motion[node][:, 1]
        for link in self.angles:
            table[f"{link}.angle"] = self.angles[link]
            table[f"{link}.angle_dot"] = self.angular_velocities[link]
            table[f"{link}.angle_ddot"] = self.angular_accelerations[link]
        return table

    def save(self, path: str | Path) -> None:
        """Write the columns to a ``.csv`` or ``.npz`` file, as :func:`save_columns` does."""
        save_columns(self.columns(), path)

    def summary(self) -> dict[str, Any]:
        """Return what a program may want to know, ready for JSON."""
        return {
            "scene": self.name,
            "unit": self.unit,
            "target": self.target,
            "method": self.method,
            "divisions": self.divisions,
            "rows": len(self),
            "iterations": {
                "min": int(np.min(self.iterations[1:], initial=np.iinfo(np.intc).max))
                if len(self) > 1
                else 0,
                "max": int(np.max(self.iterations, initial=0)),
                "total": int(np.sum(self.iterations)),
            },
            "residual_max": self.residual_max,
        }
