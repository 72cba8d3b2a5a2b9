"""Rows that combine coordinates: C = Σ factor · u + offset − unit · law(t).

The derivatives of a law are formulas, too: ν = unit · law′, γ = Σ factor · γ_u + unit · law″.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.matrix import Matrix
from kousoku.codegen.dynamics.recording.recorder import column, zeros
from kousoku.codegen.expressions import to_graph
from kousoku.model.expressions.exponentials import rate_of
from kousoku.model.expressions.formulas import TIME
from kousoku.model.expressions.parser import parse_expression

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.composition.record_coordinates import CoordinateRecorder
    from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix
    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.codegen.dynamics.simplification.body_blocks import BodyBlocks
    from kousoku.model.mechanics.multibody import Instance


@dataclass(frozen=True, slots=True)
class WeightedRows:
    """Sum of weighted rows, total + Σ c row. Blocks: the total, then factor and row in turn.

    Rows are values (1, 1) of coordinates, or Jacobians (1, c): columns δr in frame O, δθ′ in the
    principal frame.
    """

    title: str = "linear combination"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Sum, in the unit [m or rad] of the combination."""
        total, *pairs = blocks
        for factor, row in zip(pairs[::2], pairs[1::2], strict=True):
            total = factor @ row + total
        return (total,)


@dataclass(frozen=True, slots=True)
class Law:
    """A formula f(t) of the time, or a derivative of it. Blocks: unit, t, the parameters.

    Parameters
    ----------
    law : str
        The formula.
    parameters : tuple of str
        Names of its arguments beside the time.
    order : int
        Which derivative by the time [s].
    """

    law: str
    parameters: tuple[str, ...]
    order: int

    @property
    def title(self) -> str:
        """Say which derivative."""
        return f"driver, derivative {self.order}"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Unit · law (1,), dᵏf/dtᵏ [m or rad per sᵏ]."""
        unit, time, parameters = (block.flat for block in blocks)
        names = (TIME, *self.parameters)
        expression = rate_of(parse_expression(self.law, names), self.order)
        leaves = dict(zip(names, (*time, *parameters), strict=True))
        node = trace.graph.mul(unit[0], to_graph(expression, trace.graph, leaves))
        return (Matrix.of(trace.graph, [node]),)


@dataclass(frozen=True, slots=True)
class Combinations:
    """Recorder of the rows of combinations, C = Σ c u + c₀ − f(t) [m or rad] of coordinates u.

    Parameters
    ----------
    recorder : Recorder
        The program.
    coordinates : CoordinateRecorder
        Recorder of the coordinates that are combined.
    time, parameters : SlotMatrix (1, 1), (n, 1)
        Arguments of the laws.
    names : tuple of str
        The parameters' names.
    """

    recorder: Recorder
    coordinates: CoordinateRecorder
    time: SlotMatrix
    parameters: SlotMatrix
    names: tuple[str, ...]

    def residual(self, instance: Instance) -> SlotMatrix:
        """Residual C (1,) of a combination, recorded."""
        total = self.recorder.constant((instance.offset,))
        if instance.is_driver:
            law = self.law(instance, 0)
            (total,) = self.recorder.call(WeightedRows(), total, column((-1,)), law)
        values = [self.coordinates.value(term.coordinate) for term in instance.terms]
        return self._weighted(instance, total, values)

    def jacobian(self, instance: Instance, index: int, body: BodyBlocks) -> SlotMatrix:
        """Jacobian Σ c J (1, c) by the columns δr, frame O, and δθ′ of a body, recorded."""
        rows = [self.coordinates.jacobian(term.coordinate).get(index) for term in instance.terms]
        return self._weighted(instance, zeros(1, len(body.columns)), rows)

    def rate(self, instance: Instance, output: str) -> SlotMatrix:
        """Right-hand side ``nu`` = ḟ or ``gamma`` = Σ c γ + f̈ (1,) [per s or s²], recorded."""
        if output == "nu":
            return self.law(instance, 1)
        gammas = [self.coordinates.gamma(term.coordinate) for term in instance.terms]
        return self._weighted(instance, self.law(instance, 2), gammas)

    def law(self, instance: Instance, order: int) -> SlotMatrix:
        """Derivative dᵏf/dtᵏ (1,) of a law, recorded in the unit of the row; zero without a law."""
        if not instance.is_driver:
            return column((0,))
        unit = self.recorder.constant((instance.law_unit,))
        operation = Law(instance.law, self.names, order)
        return self.recorder.call(operation, unit, self.time, self.parameters)[0]

    def _weighted(
        self, instance: Instance, total: SlotMatrix, rows: Sequence[SlotMatrix | None]
    ) -> SlotMatrix:
        pairs = [
            block
            for term, row in zip(instance.terms, rows, strict=True)
            if row is not None
            for block in (self.recorder.constant((term.factor,)), row)
        ]
        return self.recorder.call(WeightedRows(), total, *pairs)[0]
