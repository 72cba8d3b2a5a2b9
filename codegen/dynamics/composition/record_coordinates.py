"""Record the coordinates of a system: each in the segment that first asks for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.composition.auxiliary import TURNS, Copy
from kousoku.codegen.dynamics.operations.coordinates import (
    CoordinateGamma,
    CoordinateJacobian,
    CoordinateRate,
    CoordinateValue,
)
from kousoku.codegen.dynamics.recording.program import AFTER_GEOMETRY
from kousoku.codegen.dynamics.recording.recorder import SlotMatrix, column

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from kousoku.codegen.dynamics.composition.auxiliary import Auxiliaries
    from kousoku.codegen.dynamics.recording.recorder import Recorder
    from kousoku.codegen.dynamics.simplification.body_blocks import BodyBlocks
    from kousoku.model.mechanics.multibody import RelativeCoordinate, System

ABSENT_BLOCK = column(())


class CoordinateRecorder:
    """Coordinates u [m or rad] of a program: u̇ = J v, ü = J v̇ − γ.

    J (1, c) has the columns δr in frame O, δθ′ in the principal frame of each body. What
    ``geometry`` has recorded is read by the segments after it.

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
    q : SlotMatrix
        Positions.
    """

    def __init__(
        self,
        system: System,
        recorder: Recorder,
        body: Callable[[int], BodyBlocks],
        auxiliary: Auxiliaries,
        q: SlotMatrix,
    ) -> None:
        self.all, self.shown = system.coordinates, system.shown
        self._recorder = recorder
        self._body = body
        self._auxiliary = auxiliary
        self._q = q
        self._known: dict[tuple[str, str, int], tuple[SlotMatrix, ...]] = {}

    def value(self, place: int) -> SlotMatrix:
        """Value u (1,) [m or rad], turns counted, recorded."""
        return self._once("value", place, self._value)[0]

    def jacobian(self, place: int) -> dict[int, SlotMatrix]:
        """Jacobian J by body, one row (1, c) each, recorded; the ground's is empty."""
        one = self.all[place]
        return dict(zip((one.i, one.j), self._once("jacobian", place, self._jacobian), strict=True))

    def gamma(self, place: int) -> SlotMatrix:
        """Right-hand side γ (1,) [m/s² or rad/s²] of ü = J v̇ − γ, recorded."""
        return self._once("gamma", place, self._gamma)[0]

    def rate(
        self,
        place: int,
        by_body: Sequence[SlotMatrix],
        less: SlotMatrix | None = None,
        into: SlotMatrix | None = None,
    ) -> SlotMatrix:
        """Rate J x − less (1,), for x in the order of v, body by body, recorded."""
        pairs = [
            block
            for body, jacobian in self.jacobian(place).items()
            if body >= 0
            for block in (jacobian, by_body[body])
        ]
        (rate,) = self._recorder.call(CoordinateRate(), *pairs, less or column((0,)), into=(into,))
        return rate

    def count_turns(self, q_moved: SlotMatrix, laws: Mapping[int, SlotMatrix]) -> None:
        """Record φ (1,) [rad] of a position that was moved: what the angle is counted to there.

        ``laws`` has what drivers make of angles that they set; those are counted from that.
        """
        for place, one in enumerate(self.all):
            if one.counts_turns:
                ends = (self._ends_at(self._body(k), q_moved) for k in (one.i, one.j))
                turns = laws.get(place) or self._auxiliary.of(self._q, TURNS, one.name)
                self._recorder.call(
                    CoordinateValue(one.kind, _names(one), counts_turns=True),
                    *(block for end in ends for block in end),
                    turns,
                    *self._constants(one),
                    into=(self._auxiliary.of(q_moved, TURNS, one.name),),
                )

    def angle_rates(self, q_dot: SlotMatrix, by_body: Sequence[SlotMatrix]) -> None:
        """Record φ̇ = J v (1,) [rad/s] of all angles, for velocities v body by body."""
        for place, one in enumerate(self.all):
            if one.counts_turns:
                target = self._auxiliary.of(q_dot, TURNS, one.name)
                self.rate(place, by_body, into=target)

    def show(
        self, region: SlotMatrix, v: Sequence[SlotMatrix], v_dot: Sequence[SlotMatrix] | None
    ) -> None:
        """Record u, u̇ and, with v̇ body by body, ü of those shown, (1,) each."""
        count = 2 if v_dot is None else 3
        for k, place in enumerate(self.shown):
            value, rate, *second = (region.part(count * k + n, 1) for n in range(count))
            self._recorder.call(Copy(), self.value(place), into=(value,))
            self.rate(place, v, into=rate)
            if v_dot is not None:
                self.rate(place, v_dot, self.gamma(place), into=second[0])

    def _ends_at(
        self, body: BodyBlocks, region: SlotMatrix
    ) -> tuple[SlotMatrix, SlotMatrix, SlotMatrix]:
        """Position r, p of a body where another region holds its position; A is not known."""
        there = dict(zip(self._q.entries, region.entries, strict=True))
        r, p = (column([there.get(x, x) for x in block.entries]) for block in (body.r, body.p))
        return r, p, ABSENT_BLOCK

    def _once(
        self, what: str, place: int, record: Callable[[RelativeCoordinate], tuple[SlotMatrix, ...]]
    ) -> tuple[SlotMatrix, ...]:
        """Blocks that the segment has recorded, or may read of the geometry, or records now."""
        segment = self._recorder.segments[-1][0]
        shared = self._known.get(("geometry", what, place))
        if shared is not None and segment in AFTER_GEOMETRY:
            return shared
        key = (segment, what, place)
        if key not in self._known:
            self._known[key] = record(self.all[place])
        return self._known[key]

    def _value(self, one: RelativeCoordinate) -> tuple[SlotMatrix, ...]:
        counts = one.counts_turns
        turns = self._auxiliary.of(self._q, TURNS, one.name) if counts else ABSENT_BLOCK
        operation = CoordinateValue(one.kind, _names(one), counts)
        return self._recorder.call(operation, *self._ends(one), turns, *self._constants(one))

    def _jacobian(self, one: RelativeCoordinate) -> tuple[SlotMatrix, ...]:
        columns = (self._body(k).columns for k in (one.i, one.j))
        operation = CoordinateJacobian(one.kind, _names(one), *columns)
        return self._recorder.call(operation, *self._ends(one), ABSENT_BLOCK, *self._constants(one))

    def _gamma(self, one: RelativeCoordinate) -> tuple[SlotMatrix, ...]:
        i, j = self._body(one.i), self._body(one.j)
        return self._recorder.call(
            CoordinateGamma(one.kind, _names(one)),
            *self._ends(one),
            ABSENT_BLOCK,
            *self._constants(one),
            *(i.v_r, i.omega_b, j.v_r, j.omega_b),
        )

    def _ends(self, one: RelativeCoordinate) -> list[SlotMatrix]:
        """Position r, p and A of both bodies; A only where the geometry has computed it."""
        segment = self._recorder.segments[-1][0]
        has_orientation = segment == "geometry" or segment in AFTER_GEOMETRY
        return [
            block
            for body in (self._body(one.i), self._body(one.j))
            for block in (body.r, body.p, body.orientation if has_orientation else ABSENT_BLOCK)
        ]

    def _constants(self, one: RelativeCoordinate) -> list[SlotMatrix]:
        return [self._recorder.constant(values) for _, values in one.constants]


def _names(one: RelativeCoordinate) -> tuple[str, ...]:
    return tuple(name for name, _ in one.constants)
