"""The unit of error of a solver is what roundings can do: found backward, and never exceeded."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.checking.rounding import UNIT_ROUNDOFF, run_and_keep, units
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.recording.matrix import Matrix
from kousoku.codegen.dynamics.recording.program import Program
from kousoku.codegen.dynamics.recording.recorder import Recorder
from kousoku.model.numbers.digits import HIGH
from kousoku.model.operations.arithmetic import FLOAT
from tests.analysed import all_rows

if TYPE_CHECKING:
    from types import SimpleNamespace

    from kousoku.codegen.dynamics.recording.traces import Trace

SEGMENTS = ("geometry", "acceleration", "position", "move", "velocity", "energy", "check")


@dataclass(frozen=True, slots=True)
class Difference:
    """Difference a b − c and root √c. Blocks: a, b, c."""

    title: str = "difference"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Difference and root, as a column."""
        graph = trace.graph
        a, b, c = (block.flat[0] for block in blocks)
        rows = ((graph.sub(graph.mul(a, b), c),), (graph.sqrt(c),))
        return (Matrix(graph, rows, 1),)


def difference() -> Program:
    """Program that computes a b − c and √c, in two tasks."""
    recorder = Recorder()
    given = recorder.region("q", 3)
    result = recorder.region("dq", 2)
    recorder.begin("geometry")
    blocks = [given.part(k, 1) for k in range(3)]
    recorder.call(Difference(), *blocks, into=(result,))
    segments, regions, size = recorder.finish()
    return Program(
        name="difference",
        kernels=tuple(recorder.kernels),
        segments=tuple(segments),
        regions=tuple(regions),
        constants=(),
        size=size,
        bodies=(),
        rows=(),
        is_planar=False,
    )


def test_unit_counts_every_number_once() -> None:
    work = ProgramInterpreter(difference(), HIGH)
    work["q"] = [HIGH.number(Fraction(x)) for x in (3, 5, 16)]
    steps = run_and_keep(work, ["geometry"])
    base = work.program.region("dq").base
    found = units(work, steps, [base, base + 1])

    # a, b, a b of 15 each, c of 16, and the difference of −1
    assert found[0] == pytest.approx((15 + 15 + 15 + 16 + 1) * UNIT_ROUNDOFF)
    # √c = 4, and c ∂√c/∂c = 2
    assert found[1] == pytest.approx(6 * UNIT_ROUNDOFF)
    assert [float(x) for x in work["dq"]] == [-1.0, 4.0]


@pytest.mark.parametrize("name", ["chain", "mixed", "four_bars"])
def test_doubles_stay_within_one_unit(
    mechanisms: SimpleNamespace, rng: np.random.Generator, name: str
) -> None:
    make = getattr(mechanisms, name)
    system = make() if name == "mixed" else make(2)
    program = compose(all_rows(system, may_be_planar=False), ["reactions", "checks", "energies"])
    exact, doubles = ProgramInterpreter(program, HIGH), ProgramInterpreter(program, FLOAT)
    for region in ("q", "v"):
        values = np.array(doubles[region]) + 0.1 * rng.normal(size=len(doubles[region]))
        doubles[region] = list(map(float, values))
        exact[region] = [HIGH.number(Fraction(float(x))) for x in values]
    steps = run_and_keep(exact, SEGMENTS)
    doubles.run(*SEGMENTS)
    regions = [program.region(x) for x in ("v_dot", "lam", "q_moved", "dv", "energies", "C_ddot")]
    slots = [one.base + k for one in regions for k in range(one.size)]
    errors = [abs(float(doubles.values[slot] - exact.values[slot])) for slot in slots]
    sizes = units(exact, steps, slots)

    assert all(size or not error for error, size in zip(errors, sizes, strict=True))
    worst = max(error / size for error, size in zip(errors, sizes, strict=True) if size)
    assert 0.01 < worst < 1.0


def test_unit_of_multipliers_grows_where_rows_become_dependent(
    mechanisms: SimpleNamespace,
) -> None:
    program = compose(all_rows(mechanisms.four_bars(1)), ["reactions"])

    def largest(angle: float) -> Any:
        state = mechanisms.four_bars_state(1, angle, 1.0)
        work = ProgramInterpreter(program, HIGH)
        for name in ("r", "p", "v", "omega_b"):
            for body, values in zip(program.bodies, state[name], strict=True):
                for place, value in zip(getattr(body, name), values, strict=True):
                    if place.slot >= 0:
                        work.values[place.slot] = HIGH.number(Fraction(float(value)))
        steps = run_and_keep(work, ("geometry", "acceleration"))
        lam = program.region("lam")
        return max(units(work, steps, range(lam.base, lam.base + lam.size)))

    assert largest(1e-3) > 1e4 * largest(1.0)
