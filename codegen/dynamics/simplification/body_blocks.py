"""The blocks of a body: slots of its coordinates and its numbers in the workspace."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.body_coordinates import shape, start
from kousoku.codegen.dynamics.recording.design import number
from kousoku.codegen.dynamics.recording.program import BodyCoordinates, CoordinatePlace
from kousoku.codegen.dynamics.recording.recorder import SlotMatrix, column, slot_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.recorder import Recorder
    from kousoku.model.mechanics.multibody import MovingBody, System
    from kousoku.model.numbers.precise import High


@dataclass(frozen=True, slots=True)
class BodyBlocks:
    """A body in the workspace: ṙ = v, ṗ = ½ p ∘ (0, ω′), in SI units.

    Parameters
    ----------
    coordinates : tuple of int
        Indices in (r, p) of its coordinates.
    columns : tuple of int
        Indices in (δr, δθ′) of its velocities.
    q, v : int
        Offsets in the regions.
    r, p, v_r, omega_b : SlotMatrix (3, 1) [m], (4, 1), (3, 1) [m/s], (3, 1) [rad/s]
        The whole vectors: components that are no coordinates are constants. r and v in frame O,
        ω′ in the principal frame.
    orientation : SlotMatrix
        A, (3, 3), from the principal frame to frame O.
    inverse_mass : SlotMatrix (1, c) [1/kg, 1/(kg m²)]
        Diagonal of M⁻¹ in the columns, one row.
    basis, inverse : SlotMatrix, optional
        R (c, f) and (Rᵀ M R)⁻¹ (f, f) of a body that is reduced; see
        :mod:`~kousoku.codegen.dynamics.simplification.ground_joints`.
    """

    coordinates: tuple[int, ...]
    columns: tuple[int, ...]
    q: int
    v: int
    r: SlotMatrix
    p: SlotMatrix
    v_r: SlotMatrix
    omega_b: SlotMatrix
    orientation: SlotMatrix
    inverse_mass: SlotMatrix
    basis: SlotMatrix | None = None
    inverse: SlotMatrix | None = None

    @property
    def effective_inverse_mass(self) -> SlotMatrix:
        """The inverse of the mass that other joints move: (Rᵀ M R)⁻¹ or M⁻¹."""
        return self.inverse or self.inverse_mass

    def spread(self, entries: Sequence[int]) -> tuple[SlotMatrix, SlotMatrix]:
        """Columns (δr, δθ′) with zeros where there is no column."""
        full = [0] * 6
        for index, entry in zip(self.columns, entries, strict=True):
            full[index] = entry
        return column(full[:3]), column(full[3:])


IDENTITY = SlotMatrix((1, 0, 0, 0, 1, 0, 0, 0, 1), 3, 3)
ZEROS = column((0, 0, 0))
#: The ground has no columns.
GROUND = BodyBlocks(
    (), (), 0, 0, ZEROS, column((1, 0, 0, 0)), ZEROS, ZEROS, IDENTITY, SlotMatrix((), 1, 0)
)


def inverse_masses(body: MovingBody, columns: Sequence[int]) -> list[High]:
    """Diagonal of M⁻¹ (c,) [1/kg, 1/(kg m²)], exactly; zero where there is no mass.

    M = diag(m, m, m, I₁, I₂, I₃) about the centre of mass: frame O, then the principal frame.
    """
    diagonal = [number(x) for x in (*(body.mass,) * 3, *body.inertia)]
    return [1 / diagonal[k] if diagonal[k] else Fraction(0) for k in columns]


def gyroscopic_ratios(body: MovingBody, columns: Sequence[int]) -> list[High]:
    """Gyroscopic ratios (I₂ − I₃)/I₁ and its like (3,) [-], exactly; zero where it cannot turn.

    I′ω̇′ = −ω̃′I′ω′ in the principal frame is ω̇₁ = (I₂ − I₃)/I₁ ω₂ ω₃ and so on: three mass
    points, (newton-euler-moment).
    """
    moments = [number(moment) for moment in body.inertia]
    return [
        (moments[(k + 1) % 3] - moments[(k + 2) % 3]) / moments[k]
        if k + 3 in columns
        else Fraction(0)
        for k in range(3)
    ]


def _mixed(
    recorder: Recorder, kept: Sequence[int], slots: Sequence[int], values: Sequence[float]
) -> list[int]:
    """Entries of a vector: slots at the indices that are coordinates, numbers elsewhere."""
    fixed = [0.0 if index in kept else value for index, value in enumerate(values)]
    entries = list(recorder.constant(fixed).entries)
    for index, entry in zip(kept, slots, strict=True):
        entries[index] = entry
    return entries


def body_blocks(
    system: System, recorder: Recorder, q: SlotMatrix, v: SlotMatrix, *, is_planar: bool
) -> list[BodyBlocks]:
    """Blocks of all bodies; A is put in when the geometry is recorded.

    q (n,) [m, -] is r in frame O and p of each body, v (m,) [m/s, rad/s] is ṙ and ω′ in the
    principal frame, M⁻¹ = diag(1/m, 1/I); components out of the plane are constant.
    """
    blocks = []
    at_q = at_v = 0
    for body in system.bodies:
        kept, columns = shape(body, is_planar=is_planar)
        position, velocity = start(body)
        position_entries = _mixed(recorder, kept, q.part(at_q, len(kept)).entries, position)
        velocity_entries = _mixed(recorder, columns, v.part(at_v, len(columns)).entries, velocity)
        blocks.append(
            BodyBlocks(
                coordinates=kept,
                columns=columns,
                q=at_q,
                v=at_v,
                r=column(position_entries[:3]),
                p=column(position_entries[3:]),
                v_r=column(velocity_entries[:3]),
                omega_b=column(velocity_entries[3:]),
                orientation=IDENTITY,
                inverse_mass=recorder.constant(inverse_masses(body, columns)).T,
            )
        )
        at_q += len(kept)
        at_v += len(columns)
    return blocks


def coordinates(body: MovingBody, blocks: BodyBlocks) -> BodyCoordinates:
    """Slots of the coordinates of a body, for callers that run the program."""
    position, velocity = start(body)

    def slots(
        block: SlotMatrix, first: int, kept: Sequence[int], values: Sequence[float]
    ) -> CoordinatePlaces:
        return tuple(
            CoordinatePlace(slot_of(entry) if first + k in kept else -1, values[first + k])
            for k, entry in enumerate(block.entries)
        )

    return BodyCoordinates(
        body.name,
        slots(blocks.r, 0, blocks.coordinates, position),
        slots(blocks.p, 3, blocks.coordinates, position),
        slots(blocks.v_r, 0, blocks.columns, velocity),
        slots(blocks.omega_b, 3, blocks.columns, velocity),
    )


CoordinatePlaces = tuple[CoordinatePlace, ...]
