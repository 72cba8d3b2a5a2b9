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
        The program.
    body : callable
        Returns the blocks of a body by its index.
    auxiliary : Auxiliaries
        Indices of the turns in q.
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
        self._recorded: dict[tuple[str, str, int], tuple[SlotMatrix, ...]] = {}

    def value(self, index: int) -> SlotMatrix:
        """Value u (1,) [m or rad], turns counted, recorded."""
        return self._once("value", index, self._value)[0]

    def jacobian(self, index: int) -> dict[int, SlotMatrix]:
        """Jacobian J by body, one row (1, c) each, recorded; the ground's is empty."""
        u = self.all[index]
        return dict(zip((u.i, u.j), self._once("jacobian", index, self._jacobian), strict=True))

    def gamma(self, index: int) -> SlotMatrix:
        """Right-hand side γ (1,) [m/s² or rad/s²] of ü = J v̇ − γ, recorded."""
        return self._once("gamma", index, self._gamma)[0]

    def rate(
        self,
        index: int,
        by_body: Sequence[SlotMatrix],
        less: SlotMatrix | None = None,
        into: SlotMatrix | None = None,
    ) -> SlotMatrix:
        """Rate J x − less (1,), for x in the order of v, body by body, recorded."""
        pairs = [
            block
            for body, jacobian in self.jacobian(index).items()
            if body >= 0
            for block in (jacobian, by_body[body])
        ]
        (rate,) = self._recorder.call(CoordinateRate(), *pairs, less or column((0,)), into=(into,))
        return rate

    def count_turns(self, q_moved: SlotMatrix, laws: Mapping[int, SlotMatrix]) -> None:
        """Record φ (1,) [rad], the counted angles, of a position that was moved.

        ``laws`` has the angles that drivers prescribe; these are counted from there.
        """
        for index, u in enumerate(self.all):
            if u.counts_turns:
                ends = (self._ends_at(self._body(k), q_moved) for k in (u.i, u.j))
                turns = laws.get(index) or self._auxiliary.of(self._q, TURNS, u.name)
                self._recorder.call(
                    CoordinateValue(u.kind, _names(u), counts_turns=True),
                    *(block for end in ends for block in end),
                    turns,
                    *self._constants(u),
                    into=(self._auxiliary.of(q_moved, TURNS, u.name),),
                )

    def angle_rates(self, q_dot: SlotMatrix, by_body: Sequence[SlotMatrix]) -> None:
        """Record φ̇ = J v (1,) [rad/s] of all angles, for velocities v body by body."""
        for index, u in enumerate(self.all):
            if u.counts_turns:
                target = self._auxiliary.of(q_dot, TURNS, u.name)
                self.rate(index, by_body, into=target)

    def show(
        self, region: SlotMatrix, v: Sequence[SlotMatrix], v_dot: Sequence[SlotMatrix] | None
    ) -> None:
        """Record u, u̇ and, with v̇ body by body, ü of those shown, (1,) each."""
        count = 2 if v_dot is None else 3
        for k, index in enumerate(self.shown):
            value, rate, *second = (region.part(count * k + n, 1) for n in range(count))
            self._recorder.call(Copy(), self.value(index), into=(value,))
            self.rate(index, v, into=rate)
            if v_dot is not None:
                self.rate(index, v_dot, self.gamma(index), into=second[0])

    def _ends_at(
        self, body: BodyBlocks, region: SlotMatrix
    ) -> tuple[SlotMatrix, SlotMatrix, SlotMatrix]:
        """Position r, p of a body in another region that is ordered as q; A is not known."""
        moved = dict(zip(self._q.entries, region.entries, strict=True))
        r, p = (column([moved.get(x, x) for x in block.entries]) for block in (body.r, body.p))
        return r, p, ABSENT_BLOCK

    def _once(
        self, name: str, index: int, record: Callable[[RelativeCoordinate], tuple[SlotMatrix, ...]]
    ) -> tuple[SlotMatrix, ...]:
        """Blocks by name: recorded by this segment, read of the geometry, or recorded now."""
        segment = self._recorder.segments[-1][0]
        shared = self._recorded.get(("geometry", name, index))
        if shared is not None and segment in AFTER_GEOMETRY:
            return shared
        key = (segment, name, index)
        if key not in self._recorded:
            self._recorded[key] = record(self.all[index])
        return self._recorded[key]

    def _value(self, u: RelativeCoordinate) -> tuple[SlotMatrix, ...]:
        counts = u.counts_turns
        turns = self._auxiliary.of(self._q, TURNS, u.name) if counts else ABSENT_BLOCK
        operation = CoordinateValue(u.kind, _names(u), counts)
        return self._recorder.call(operation, *self._ends(u), turns, *self._constants(u))

    def _jacobian(self, u: RelativeCoordinate) -> tuple[SlotMatrix, ...]:
        columns = (self._body(k).columns for k in (u.i, u.j))
        operation = CoordinateJacobian(u.kind, _names(u), *columns)
        return self._recorder.call(operation, *self._ends(u), ABSENT_BLOCK, *self._constants(u))

    def _gamma(self, u: RelativeCoordinate) -> tuple[SlotMatrix, ...]:
        i, j = self._body(u.i), self._body(u.j)
        return self._recorder.call(
            CoordinateGamma(u.kind, _names(u)),
            *self._ends(u),
            ABSENT_BLOCK,
            *self._constants(u),
            *(i.v_r, i.omega_b, j.v_r, j.omega_b),
        )

    def _ends(self, u: RelativeCoordinate) -> list[SlotMatrix]:
        """Position r, p and A of both bodies; A only where the geometry has computed it."""
        segment = self._recorder.segments[-1][0]
        has_orientation = segment == "geometry" or segment in AFTER_GEOMETRY
        return [
            block
            for body in (self._body(u.i), self._body(u.j))
            for block in (body.r, body.p, body.orientation if has_orientation else ABSENT_BLOCK)
        ]

    def _constants(self, u: RelativeCoordinate) -> list[SlotMatrix]:
        return [self._recorder.constant(values) for _, values in u.constants]


def _names(u: RelativeCoordinate) -> tuple[str, ...]:
    return tuple(name for name, _ in u.constants)
