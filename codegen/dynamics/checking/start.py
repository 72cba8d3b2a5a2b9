"""Forces and events that have no value where a scene starts, as friction v/|v| at rest."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.composition.equations import system_equations
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.model.expressions.formulas import TIME
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.values import value_of
from kousoku.model.lowering.root_functions import root_functions_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanics.multibody import ForceElement, System


def forces_without_value(system: System) -> list[str]:
    """Names of forces whose formulas have no finite value at the start.

    Parameters
    ----------
    system : System
        The scene after assembly.
    """
    formulas = [force for force in system.forces if force.law or force.formulas]
    if not formulas or _have_values(system, formulas) or not _have_values(system, ()):
        return []
    names = dict.fromkeys(force.name for force in formulas)
    return [
        name
        for name in names
        if not _have_values(system, [force for force in formulas if force.name == name])
    ]


def _have_values(system: System, forces: Sequence[ForceElement]) -> bool:
    """Whether some forces have finite values at the start."""
    work = ProgramInterpreter(system_equations(replace(system, forces=tuple(forces))).program)
    try:
        work.run("masses", "geometry")
    except (ArithmeticError, ValueError):
        return False
    return all(map(isfinite, work["forces"]))


def events_without_value(program: Program, system: System) -> list[tuple[str, str]]:
    """Name and formula of the events that have no finite value at the start.

    Parameters
    ----------
    program, system : Program, System
        Program and system that a solver is emitted from.
    """
    if not system.events:
        return []
    measures = root_functions_of(system).measures
    start = measures_at_start(program, len(measures))
    if start is None:  # the check of that spring's force reports it
        return []
    values = {TIME: 0.0, **dict(system.parameters)}
    for measure, (value, rate) in zip(measures, start, strict=True):
        values |= {measure.name: value, measure.rate: rate}
    return [
        (event.name, event.when)
        for event in system.events
        if not isfinite(value_of(parse_expression(event.when, values), values))
    ]


def measures_at_start(program: Program, count: int) -> list[tuple[float, float]] | None:
    """Values and rates of all measures at the start; None where a spring has no length there.

    Parameters
    ----------
    program : Program
        Program that a solver is emitted from.
    count : int
        Count of the measures.
    """
    if not count:
        return []
    work = ProgramInterpreter(program)
    try:
        work.run("measure")
    except (ArithmeticError, ValueError):
        return None
    return [*zip(*[map(float, work["measures"])] * 2, strict=True)]
