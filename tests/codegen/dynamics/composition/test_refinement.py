"""One step of iterative refinement against 50 digits, near a position where the rank drops.

A four-bar of equal cranks stretches out into a line when its cranks lie along the ground. A driver
turns one of them there, so that multipliers of all rows, and its power, are looked at, too.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics.assembly.assemble import assemble
from kousoku.codegen.dynamics.composition.compose import compose
from kousoku.codegen.dynamics.recording.inline import inline
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.model.lowering.system import system_of
from kousoku.model.numbers.digits import HIGH
from kousoku.model.reading.families import chain, n_four_bar
from kousoku.model.reading.read import scene_from_toml
from kousoku.model.reading.write import to_toml
from tests.analysed import all_rows

if TYPE_CHECKING:
    from kousoku.codegen.dynamics.recording.program import Program

WANTED = ("checks", "reactions", "energies")
DRIVER = '[drivers]\nmotor = { joint = "ground_0", value = "-7*t" }\n'
#: Of the cranks from the line [rad]: the smallest pivot is 1e-8 of the largest.
ANGLE = 2e-4
#: What rounding makes of accelerations, multipliers and power before that step, and after it.
LOST, LEFT = 5e-11, 5e-12


@pytest.fixture(scope="module")
def program() -> Program:
    bars = n_four_bar(1, turned=(math.cos(ANGLE), math.sin(ANGLE)), rate=-7.0)
    text = to_toml(bars)
    return compose(all_rows(assemble(system_of(scene_from_toml(f"{text}\n{DRIVER}")))), WANTED)


def numbers(values: Any) -> np.ndarray:
    return np.array([float(x) for x in values])


def errors(work: ProgramInterpreter, exact: ProgramInterpreter) -> np.ndarray:
    """Errors of v_dot, lam and the power of the driver, relative to their largest."""
    found = []
    for region, first in (("v_dot", 0), ("lam", 0), ("q_dot", -1)):
        wanted = numbers(exact[region][first:])
        found.append(np.abs(numbers(work[region][first:]) - wanted).max() / np.abs(wanted).max())
    return np.array(found)


def left(work: ProgramInterpreter) -> float:
    """Residual of C_q v_dot = gamma, relative to v_dot."""
    work.run("check")
    rows = work["C_ddot"][: len(work["C"])]
    return float(np.abs(numbers(rows)).max() / np.abs(numbers(work["v_dot"])).max())


def refine(work: ProgramInterpreter) -> None:
    """Do what solvers do with what the segment finds."""
    work.run("refinement")
    for region, more in (("v_dot", "dv"), ("lam", "more_lam")):
        work[region] = [a + b for a, b in zip(work[region], work[more], strict=True)]
    (more_power,) = work["more_power"]
    *rates, power = work["q_dot"]
    work["q_dot"] = [*rates, power + more_power]


@pytest.mark.parametrize("form", ["tasks", "straight"])
def test_accelerations_multipliers_and_power_are_brought_to_those_of_fifty_digits(
    program: Program, form: str
) -> None:
    work = ProgramInterpreter(program if form == "tasks" else inline(program, limit=100_000))
    exact = ProgramInterpreter(program, HIGH)
    for one in (work, exact):
        one.run("geometry", "acceleration")
    pivots = numbers(work["pivots"])
    assert pivots.min() < 1e-7 * pivots.max()
    before, rest = errors(work, exact), left(work)
    refine(work)
    assert before.min() > LOST
    assert errors(work, exact).max() < LEFT
    assert rest > 1e-14
    assert left(work) < 1e-16


def test_chains_of_bodies_are_not_refined() -> None:
    program = compose(all_rows(assemble(system_of(chain(3)))), WANTED)
    assert program.on_demand == ()
