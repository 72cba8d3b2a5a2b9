"""Coordinates of a system in its program: values, derivatives, and turns that are counted.

A coordinate has the frozen kernels of its kind: the residual of ``constraint`` is its value u, C_q
its Jacobian J, and ü = J v̇ − γ with γ of ``rates``. An angle is known to them up to whole turns;
what it is counted to, Θ = φ + wrap(θ − φ), follows from an entry φ of q that is less than half a
turn away; see :mod:`kousoku.codegen.dynamics.auxiliary`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.auxiliary import TURNS, Copy
from kousoku.codegen.dynamics.matrix import Matrix
from kousoku.codegen.dynamics.operations import COLUMNS, frozen, share
from kousoku.codegen.dynamics.program import AFTER_GEOMETRY
from kousoku.codegen.dynamics.recorder import Block, column

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.codegen.dynamics.auxiliary import Auxiliaries
    from kousoku.codegen.dynamics.bodies import BodyBlocks
    from kousoku.codegen.dynamics.recorder import Recorder
    from kousoku.codegen.dynamics.traces import Trace
    from kousoku.model.mechanism import Coordinate, System

NOTHING = column(())
#: The place of φ among the blocks.
TURNED = 6


@dataclass(frozen=True, slots=True)
class Value:
    """Value of a coordinate. Blocks: r, p and A of body i, those of body j, φ, the constants.

    A may be without entries: then it is computed from p.

    Parameters
    ----------
    kind : str
        The package.
    constants : tuple of str
        Names of the inputs that are fixed.
    counts_turns : bool
        Whether the value is counted from φ; else φ has no entry.
    """

    kind: str
    constants: tuple[str, ...]
    counts_turns: bool

    @property
    def title(self) -> str:
        """Name the kind."""
        return f"value of {self.kind}"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return u (1,)."""
        found = _inline(trace, "constraint", self, blocks)
        (value,) = found["C"]
        if self.counts_turns:
            (turned,), graph = blocks[TURNED].flat, trace.graph
            beyond = graph.sub(value, turned)
            value = graph.add(turned, graph.atan2(graph.sin(beyond), graph.cos(beyond)))
        return (Matrix(trace.graph, ((value,),), 1),)


@dataclass(frozen=True, slots=True)
class Slopes:
    """Jacobian of a coordinate. Blocks: as of :class:`Value`, φ without entries.

    Parameters
    ----------
    kind, constants
        As of :class:`Value`.
    columns_i, columns_j : tuple of int
        Columns of each body that are coordinates: none of the ground.
    """

    kind: str
    constants: tuple[str, ...]
    columns_i: tuple[int, ...]
    columns_j: tuple[int, ...]

    @property
    def title(self) -> str:
        """Name the kind."""
        return f"Jacobian of {self.kind}"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return J of i and of j, each one row."""
        found = _inline(trace, "constraint", self, blocks)
        row = Matrix(trace.graph, (tuple(found["C_q"]),), 2 * COLUMNS)
        right = [COLUMNS + k for k in self.columns_j]
        return row.columns(self.columns_i), row.columns(right)


@dataclass(frozen=True, slots=True)
class Curvature:
    """γ of a coordinate. Blocks: as of :class:`Slopes`, then v and ω′ of i and of j.

    Parameters
    ----------
    kind, constants
        As of :class:`Value`.
    """

    kind: str
    constants: tuple[str, ...]

    @property
    def title(self) -> str:
        """Name the kind."""
        return f"gamma of {self.kind}"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return γ (1,)."""
        names = ("v_i", "omega_i_b", "v_j", "omega_j_b")
        motion = dict(zip(names, blocks[-len(names) :], strict=True))
        found = _inline(trace, "rates", self, blocks[: -len(names)], motion)
        return (Matrix(trace.graph, ((found["gamma"][0],),), 1),)


@dataclass(frozen=True, slots=True)
class Along:
    """Rate of a coordinate. Blocks: J and x of each body in turn, what is taken away last."""

    title: str = "rate"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return Σ J x minus the last block."""
        *pairs, less = blocks
        total = -less
        for row, x in zip(pairs[::2], pairs[1::2], strict=True):
            total = row @ x + total
        return (total,)


def _inline(
    trace: Trace,
    kernel: str,
    what: Value | Slopes | Curvature,
    blocks: Sequence[Matrix],
    motion: dict[str, Matrix] | None = None,
) -> dict[str, list[int]]:
    """Rebuild a kernel of a coordinate; return its outputs."""
    r_i, p_i, a_i, r_j, p_j, a_j, _, *constants = blocks
    for p, orientation in ((p_i, a_i), (p_j, a_j)):
        if orientation.flat:
            share(trace, p, orientation)
    given = {"r_i": r_i, "p_i": p_i, "r_j": r_j, "p_j": p_j} | (motion or {})
    given |= dict(zip(what.constants, constants, strict=True))
    inputs = {name: block.flat for name, block in given.items()}
    return trace.inline(frozen(what.kind, kernel), inputs)


class CoordinateBlocks:
    """The coordinates of a system: each is recorded in the segment that first asks for it.

    What ``geometry`` has recorded is read by the segments after it.

    Parameters
    ----------
    system : System
        The scene.
    recorder : Recorder
        Where they are recorded.
    body : callable
        Returns the blocks of a body by its index.
    auxiliary : Auxiliaries
        Where the turns are.
    q : Block
        Positions.
    """

    def __init__(
        self,
        system: System,
        recorder: Recorder,
        body: Callable[[int], BodyBlocks],
        auxiliary: Auxiliaries,
        q: Block,
    ) -> None:
        self.all, self.shown = system.coordinates, system.shown
        self._recorder = recorder
        self._body = body
        self._auxiliary = auxiliary
        self._q = q
        self._known: dict[tuple[str, str, int], tuple[Block, ...]] = {}

    def value(self, place: int) -> Block:
        """Return the value, turns counted (1,)."""
        return self._once("value", place, self._value)[0]

    def slopes(self, place: int) -> dict[int, Block]:
        """Return the Jacobian by body, one row each; the ground's is empty."""
        one = self.all[place]
        return dict(zip((one.i, one.j), self._once("slopes", place, self._slopes), strict=True))

    def gamma(self, place: int) -> Block:
        """Return γ: the second derivative of the coordinate is J v̇ − γ (1,)."""
        return self._once("gamma", place, self._gamma)[0]

    def rate(
        self,
        place: int,
        by_body: Sequence[Block],
        less: Block | None = None,
        into: Block | None = None,
    ) -> Block:
        """Return J x − less for x in the order of v, body by body (1,)."""
        pairs = [
            block
            for body, slopes in self.slopes(place).items()
            if body >= 0
            for block in (slopes, by_body[body])
        ]
        (rate,) = self._recorder.call(Along(), *pairs, less or column((0,)), into=(into,))
        return rate

    def count_turns(self, q_moved: Block) -> None:
        """Record φ of a position that was moved: what the angle is counted to there."""
        for one in self.all:
            if one.counts_turns:
                ends = (self._ends_at(self._body(k), q_moved) for k in (one.i, one.j))
                turns = self._auxiliary.of(self._q, TURNS, one.name)
                self._recorder.call(
                    Value(one.kind, _names(one), counts_turns=True),
                    *(block for end in ends for block in end),
                    turns,
                    *self._constants(one),
                    into=(self._auxiliary.of(q_moved, TURNS, one.name),),
                )

    def turn(self, q_dot: Block, by_body: Sequence[Block]) -> None:
        """Record how fast the angles turn, for velocities in the order of v, body by body."""
        for place, one in enumerate(self.all):
            if one.counts_turns:
                target = self._auxiliary.of(q_dot, TURNS, one.name)
                self.rate(place, by_body, into=target)

    def show(self, region: Block, v: Sequence[Block], v_dot: Sequence[Block] | None) -> None:
        """Record value, rate and, with v̇ body by body, second derivative of those shown."""
        count = 2 if v_dot is None else 3
        for k, place in enumerate(self.shown):
            value, rate, *second = (region.part(count * k + n, 1) for n in range(count))
            self._recorder.call(Copy(), self.value(place), into=(value,))
            self.rate(place, v, into=rate)
            if v_dot is not None:
                self.rate(place, v_dot, self.gamma(place), into=second[0])

    def _ends_at(self, body: BodyBlocks, region: Block) -> tuple[Block, Block, Block]:
        """Return r and p of a body where another region holds its position; A is not known."""
        first, last = self._q.entries[0], self._q.entries[-1]
        away = region.entries[0] - first
        r, p = (
            column([x + away if first <= x <= last else x for x in block.entries])
            for block in (body.r, body.p)
        )
        return r, p, NOTHING

    def _once(
        self, what: str, place: int, record: Callable[[Coordinate], tuple[Block, ...]]
    ) -> tuple[Block, ...]:
        """Return what the segment has recorded, or may read of the geometry, or record it."""
        segment = self._recorder.segments[-1][0]
        shared = self._known.get(("geometry", what, place))
        if shared is not None and segment in AFTER_GEOMETRY:
            return shared
        key = (segment, what, place)
        if key not in self._known:
            self._known[key] = record(self.all[place])
        return self._known[key]

    def _value(self, one: Coordinate) -> tuple[Block, ...]:
        counts = one.counts_turns
        turns = self._auxiliary.of(self._q, TURNS, one.name) if counts else NOTHING
        operation = Value(one.kind, _names(one), counts)
        return self._recorder.call(operation, *self._ends(one), turns, *self._constants(one))

    def _slopes(self, one: Coordinate) -> tuple[Block, ...]:
        columns = (self._body(k).columns for k in (one.i, one.j))
        operation = Slopes(one.kind, _names(one), *columns)
        return self._recorder.call(operation, *self._ends(one), NOTHING, *self._constants(one))

    def _gamma(self, one: Coordinate) -> tuple[Block, ...]:
        i, j = self._body(one.i), self._body(one.j)
        return self._recorder.call(
            Curvature(one.kind, _names(one)),
            *self._ends(one),
            NOTHING,
            *self._constants(one),
            *(i.v_r, i.omega_b, j.v_r, j.omega_b),
        )

    def _ends(self, one: Coordinate) -> list[Block]:
        """Return r, p and A of both bodies; A only where the geometry has computed it."""
        segment = self._recorder.segments[-1][0]
        has_orientation = segment == "geometry" or segment in AFTER_GEOMETRY
        return [
            block
            for body in (self._body(one.i), self._body(one.j))
            for block in (body.r, body.p, body.orientation if has_orientation else NOTHING)
        ]

    def _constants(self, one: Coordinate) -> list[Block]:
        return [self._recorder.constant(values) for _, values in one.constants]


def _names(one: Coordinate) -> tuple[str, ...]:
    return tuple(name for name, _ in one.constants)
