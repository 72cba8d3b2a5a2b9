"""The joints of a system: instances between the same two bodies, with the rows that matter."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from functools import cache
from itertools import groupby
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.mechanics import COLUMNS, Part, frozen, inputs_of
from kousoku.codegen.dynamics.recording.recorder import Block, column, pattern_of
from kousoku.codegen.dynamics.recording.traces import Trace
from kousoku.model.errors import SceneError
from kousoku.model.mechanism import COMBINATION, GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.codegen.dynamics.composition.bodies import BodyBlocks
    from kousoku.codegen.dynamics.recording.recorder import Pattern, Recorder
    from kousoku.model.mechanism import Coordinate, Instance, System

#: How many joints a moving body may have.
MOST_JOINTS = 64


@dataclass(slots=True)
class JointBlocks:
    """A joint in the workspace; the Jacobians are put in when the geometry is recorded.

    Parameters
    ----------
    name : str
        As in the scene.
    bodies : tuple of int
        Those that it connects: i, j, and the others of combinations.
    instances : tuple of int
        Places in the system.
    parts : tuple of Part
        The rows of each instance.
    constants : tuple of tuple of Block
        What each part needs; nothing of a combination.
    first, count : int
        Its rows.
    jacobian, scaled : dict of int to Block
        C_q and C_q M⁻¹ by body; C_q R and C_q R (Rᵀ M R)⁻¹ of a body that is reduced.
    whole : dict of int to Block
        C_q by body.
    own : Block
        C_q M⁻¹ C_qᵀ.
    """

    name: str
    bodies: tuple[int, ...]
    instances: tuple[int, ...]
    parts: tuple[Part, ...]
    constants: tuple[tuple[Block, ...], ...]
    first: int
    count: int
    jacobian: dict[int, Block] = field(default_factory=dict)
    scaled: dict[int, Block] = field(default_factory=dict)
    whole: dict[int, Block] = field(default_factory=dict)
    own: Block = field(default_factory=lambda: column(()))

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


def require_few_joints(system: System) -> None:
    """Refuse bodies with so many joints that coupling every two of them is hopeless.

    Raises
    ------
    SceneError
        A body has more than :data:`MOST_JOINTS`.
    """
    joints = dict.fromkeys((x.joint, body) for x in system.constraints for body in x.bodies)
    counts = Counter(body for _, body in joints if body != GROUND_INDEX)
    for body, count in counts.items():
        if count > MOST_JOINTS:
            raise SceneError(
                f"has {count} joints; at most {MOST_JOINTS} are possible on one body that moves,"
                " because the cost grows with their cube: divide it into bodies with fixed joints",
                key=f"bodies.{system.bodies[body].name}",
            )


def joints_of(
    system: System,
    recorder: Recorder,
    rows: Mapping[int, Sequence[int]],
    body: Callable[[int], BodyBlocks],
) -> list[JointBlocks]:
    """Return the joints that have rows left; rows that are structurally zero are not kept."""
    found = []
    first = 0
    numbered = list(enumerate(system.constraints))
    for (name, i, j), group in groupby(numbered, lambda x: (x[1].joint, x[1].i, x[1].j)):
        kept, bodies = [], [i, j]
        for place, instance in group:
            live = live_rows(system, instance, recorder, body)
            chosen = tuple(row for row in live if row in rows.get(place, live))
            if chosen:
                names = tuple(name for name, _ in inputs_of(instance))
                blocks = tuple(recorder.constant(values) for _, values in inputs_of(instance))
                kept.append((place, Part(instance.kind, chosen, names), blocks))
                bodies += instance.others
        count = sum(len(part.rows) for _, part, _ in kept)
        if count:
            found.append(
                JointBlocks(
                    name=name,
                    bodies=tuple(dict.fromkeys(bodies)),
                    instances=tuple(place for place, _, _ in kept),
                    parts=tuple(part for _, part, _ in kept),
                    constants=tuple(blocks for _, _, blocks in kept),
                    first=first,
                    count=count,
                )
            )
        first += count
    return found


def live_rows(
    system: System, instance: Instance, recorder: Recorder, body: Callable[[int], BodyBlocks]
) -> tuple[int, ...]:
    """Return the rows of an instance whose Jacobian is not structurally zero."""
    if instance.kind != COMBINATION:
        return _live(instance, recorder, body)
    terms = (system.coordinates[term.coordinate] for term in instance.terms)
    return (0,) if any(_live(term, recorder, body) for term in terms) else ()


def _live(
    one: Instance | Coordinate, recorder: Recorder, body: Callable[[int], BodyBlocks]
) -> tuple[int, ...]:
    i, j = body(one.i), body(one.j)
    columns = (*i.columns, *(COLUMNS + k for k in j.columns))
    rows = enumerate(slopes_of(one, recorder, body))
    return tuple(row for row, there in rows if any(there[k] for k in columns))


def slopes_of(
    one: Instance | Coordinate, recorder: Recorder, body: Callable[[int], BodyBlocks]
) -> tuple[tuple[bool, ...], ...]:
    """Return which elements of the Jacobian (rows, 12) are not structurally zero."""
    i, j = body(one.i), body(one.j)
    constants = [recorder.constant(values) for _, values in inputs_of(one)]
    pattern, _, _, lengths = pattern_of((i.r, i.p, j.r, j.p, *constants))
    names = tuple(name for name, _ in inputs_of(one))
    return _slopes(one.kind, names, pattern, tuple(lengths))


@cache
def _slopes(
    kind: str, names: tuple[str, ...], pattern: Pattern, lengths: tuple[int, ...]
) -> tuple[tuple[bool, ...], ...]:
    trace = Trace(lengths)
    nodes = [trace.matrix(*block).flat for block in pattern]
    inputs = dict(zip(("r_i", "p_i", "r_j", "p_j", *names), nodes, strict=True))
    jacobian = trace.inline(frozen(kind, "constraint"), inputs)["C_q"]
    width = 2 * COLUMNS
    there = [trace.graph.value(node) != 0 for node in jacobian]
    return tuple(tuple(there[row : row + width]) for row in range(0, len(there), width))
