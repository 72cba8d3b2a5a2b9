"""The joints of a system: instances between the same two bodies, with their rows."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import groupby
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.mechanics import InstanceRows, inputs_of
from kousoku.codegen.dynamics.recording.program import RowIndex
from kousoku.codegen.dynamics.recording.recorder import SlotMatrix, column

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from kousoku.codegen.dynamics.recording.recorder import Recorder
    from kousoku.model.mechanics.multibody import Instance, RelativeCoordinate, System


@dataclass(slots=True)
class JointBlocks:
    """A joint in the workspace; the Jacobians are put in when the geometry is recorded.

    δC = C_q (δr, δθ′): δr [m] in frame O, δθ′ [rad] in the principal frame of each body.

    Parameters
    ----------
    name : str
        As in the scene.
    bodies : tuple of int
        Bodies that it connects: i, j, and the others of combinations.
    instances : tuple of int
        Indices of its constraints in the system.
    parts : tuple of InstanceRows
        The rows of each instance.
    constants : tuple of tuple of SlotMatrix
        Constants of each part; none of a combination.
    first, count : int
        First of its rows, and their count n.
    jacobian, scaled : dict of int to SlotMatrix (n, c)
        C_q and C_q M⁻¹ by body; C_q R and C_q R (Rᵀ M R)⁻¹ of a body that is reduced.
    c_q : dict of int to SlotMatrix (n, c)
        C_q by body.
    diagonal : SlotMatrix (n, n)
        C_q M⁻¹ C_qᵀ.
    """

    name: str
    bodies: tuple[int, ...]
    instances: tuple[int, ...]
    parts: tuple[InstanceRows, ...]
    constants: tuple[tuple[SlotMatrix, ...], ...]
    first: int
    count: int
    jacobian: dict[int, SlotMatrix] = field(default_factory=dict)
    scaled: dict[int, SlotMatrix] = field(default_factory=dict)
    c_q: dict[int, SlotMatrix] = field(default_factory=dict)
    diagonal: SlotMatrix = field(default_factory=lambda: column(()))

    @property
    def i(self) -> int:
        """Body i."""
        return self.bodies[0]

    @property
    def j(self) -> int:
        """Body j."""
        return self.bodies[1]

    @property
    def others(self) -> tuple[int, ...]:
        """Bodies beside i and j."""
        return self.bodies[2:]


def store_constants(system: System, recorder: Recorder, instances: Iterable[int]) -> None:
    """Store the constants of constraints, by their indices, in the next slots of the workspace.

    Of a combination those of the first coordinate: others follow where they are recorded.
    """
    for index in instances:
        instance = system.constraints[index]
        sources: list[Instance | RelativeCoordinate] = [instance]
        sources += [system.coordinates[term.coordinate] for term in instance.terms[:1]]
        for source in sources:
            for _, values in inputs_of(source):
                recorder.constant(values)


def joints_of(
    system: System, recorder: Recorder, rows: Mapping[int, Sequence[int]]
) -> list[JointBlocks]:
    """Joints that have rows.

    Parameters
    ----------
    system : System
        The scene.
    recorder : Recorder
        The program.
    rows : mapping of int to sequence of int
        Rows of each constraint that has some, by its index.
    """
    joints = []
    first = 0
    numbered = list(enumerate(system.constraints))
    for (name, i, j), group in groupby(numbered, lambda x: (x[1].joint, x[1].i, x[1].j)):
        kept, bodies = [], [i, j]
        for index, instance in group:
            selected = tuple(rows.get(index, ()))
            if selected:
                names = tuple(name for name, _ in inputs_of(instance))
                blocks = tuple(recorder.constant(values) for _, values in inputs_of(instance))
                kept.append((index, InstanceRows(instance.kind, selected, names), blocks))
                bodies += instance.others
        count = sum(len(part.rows) for _, part, _ in kept)
        if count:
            joints.append(
                JointBlocks(
                    name=name,
                    bodies=tuple(dict.fromkeys(bodies)),
                    instances=tuple(index for index, _, _ in kept),
                    parts=tuple(part for _, part, _ in kept),
                    constants=tuple(blocks for _, _, blocks in kept),
                    first=first,
                    count=count,
                )
            )
        first += count
    return joints


def rows_of(joints: Iterable[JointBlocks]) -> tuple[RowIndex, ...]:
    """Rows of joints in their order."""
    return tuple(
        RowIndex(joint.name, instance, row)
        for joint in joints
        for instance, part in zip(joint.instances, joint.parts, strict=True)
        for row in part.rows
    )
