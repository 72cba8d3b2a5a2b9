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
        What a solver is emitted from.
    """
    if not system.events:
        return []
    measures = root_functions_of(system).measures
    found = measures_at_start(program, len(measures))
    if found is None:  # the force of that spring says so
        return []
    values = {TIME: 0.0, **dict(system.parameters)}
    for one, (value, rate) in zip(measures, found, strict=True):
        values |= {one.name: value, one.rate: rate}
    return [
        (one.name, one.when)
        for one in system.events
        if not isfinite(value_of(parse_expression(one.when, values), values))
    ]


def measures_at_start(program: Program, count: int) -> list[tuple[float, float]] | None:
    """Value and rate of all that formulas read, at the start; None beside a spring without length.

    Parameters
    ----------
    program : Program
        What a solver is emitted from.
    count : int
        How many they are.
    """
    if not count:
        return []
    work = ProgramInterpreter(program)
    try:
        work.run("measure")
    except (ArithmeticError, ValueError):
        return None
    return [*zip(*[map(float, work["measures"])] * 2, strict=True)]
