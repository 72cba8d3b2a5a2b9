"""Reference values of a scene's solver at a few states, in 50 digits, from two sources.

The tasks of the program are run as they were composed; straight-line code, C and Python have no
part in it. What the composition itself does wrong shows against :mod:`.independent`, in which it
has none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.codegen.dynamics.checking.independent import (
    GivenMeasure,
    GivenSolver,
    independent_points,
)
from kousoku.codegen.dynamics.checking.root_functions import root_function_points
from kousoku.codegen.dynamics.checking.rounding import run_and_keep, units
from kousoku.codegen.dynamics.composition.auxiliary import TURNS
from kousoku.codegen.dynamics.emission.context_numbers import shift_slots
from kousoku.codegen.dynamics.emission.motion_data import GIVEN, motion_data
from kousoku.codegen.dynamics.operations.characteristic_length import characteristic_length
from kousoku.codegen.dynamics.recording.counts import operations
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.sha256_random import Sha256Random
from kousoku.model.files.jsontext import to_text
from kousoku.model.files.manifest import REFERENCE_FORMATS
from kousoku.model.lowering.parametric import fixed_system
from kousoku.model.lowering.root_functions import root_functions_of
from kousoku.model.mechanics.constraints import is_length
from kousoku.model.numbers.digits import HIGH
from kousoku.model.numbers.traced import other_value
from kousoku.model.operations.graph import EXACT_OPS, Op
from kousoku.runtime.integrate.motion import Layout

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanics.multibody import System

#: Programs with more operations get no reference values: they would take minutes.
MOST_OPERATIONS = 100_000
#: No unit is smaller, as a part of the largest of its region: roundings of roundings count there.
SECOND_ORDER = 2.0**-40
#: Which part of the changes of all parameters is tried, until moments of inertia are possible.
PARTS_OF_CHANGES = (1.0, 2.0**-4, 2.0**-8, 2.0**-16)
#: What is a number and not an operation.
LEAVES = frozenset({Op.CONST, Op.INPUT})
#: Operations whose derivatives jump.
KINKS = frozenset({Op.ABS, Op.MAX})


@dataclass(frozen=True, slots=True)
class ReferenceState:
    """State at which a program is run.

    Parameters
    ----------
    label : str
        Why this state is there.
    time : float [s]
        When.
    q, v : list of float
        Coordinates and velocities.
    parameters : list of float
        Values of the parameters.
    """

    label: str
    time: float
    q: list[float]
    v: list[float]
    parameters: list[float]


def solver_references(program: Program, system: System, written: System) -> str:
    """Text of the reference values of a scene of bodies.

    Parameters
    ----------
    program : Program
        Tasks, as composed.
    system : System
        What it was composed of.
    written : System
        The same after assembly alone: all bodies and joints of the scene.

    Returns
    -------
    str
        For each state time, q and v, and for each region of the workspace lists ``high``, ``low``
        and ``unit``, as kernels have them; the unit is that of
        :mod:`kousoku.codegen.dynamics.checking.rounding`; then ``independent``, the states of
        :mod:`kousoku.codegen.dynamics.checking.independent`, and ``functions``, the points of
        :mod:`kousoku.codegen.dynamics.checking.root_functions`. Without states where the program
        has more than :data:`MOST_OPERATIONS` operations.
    """
    count = operations(program)
    found: list[dict[str, object]] = []
    independent: list[dict[str, object]] = []
    functions: list[dict[str, object]] = []
    if count <= MOST_OPERATIONS:
        states = _states(program, system)
        found = [point for state in states if (point := _point(program, system, state))]
        independent = independent_points(_known(program, system, written))
        functions = root_function_points(program, system)
    return to_text(
        {
            "format": REFERENCE_FORMATS["dynamics"],
            "package": system.name,
            "is_exact": _uses(program, EXACT_OPS | LEAVES),
            "is_smooth": _uses(program, frozenset(Op) - KINKS),
            "operations": count,
            "most_operations": MOST_OPERATIONS,
            "points": found,
            "independent": independent,
            "functions": functions,
        }
    )


def _uses(program: Program, allowed: frozenset[Op]) -> bool:
    """Whether a program has no other operations."""
    return all(node.op in allowed for kernel in program.kernels for node in kernel.nodes)


def _known(program: Program, system: System, written: System) -> GivenSolver:
    """Solver as the checker sees it, beside its results: where it has its bodies."""
    data = motion_data(program, system)
    numbers = ProgramInterpreter(program)["design"] if program.design else []
    names = [
        [one.name for one in system.carried if one.carrier in part.bodies]
        if system.carried
        else [system.bodies[k].name for k in part.bodies]
        for part in program.conserved
    ]
    return GivenSolver(
        system=fixed_system(written),
        layout=Layout.from_data(data).at(np.array(numbers, dtype=float)),
        q=np.array(data["q"], dtype=float),
        v=np.array(data["v"], dtype=float),
        turning={
            one.place.slot - program.region("q").base: one.name
            for one in program.auxiliary
            if one.kind == TURNS
        },
        momenta=[
            (own, part.linear, part.angular, part.about)
            for own, part in zip(names, program.conserved, strict=True)
        ],
        has_masses=program.has_masses,
        measures=_measures(program, system, written),
    )


def _measures(program: Program, system: System, written: System) -> list[GivenMeasure]:
    """Coordinates and lengths of springs that formulas read, by their places in the scene."""
    if not any(one.name == "measures" for one in program.regions):
        return []
    places = {one.name: k for k, one in enumerate(written.coordinates)}
    names = [one.name for one in written.forces]
    found = []
    for one in root_functions_of(system).measures:
        name = system.forces[one.force].name if one.force >= 0 else ""
        place = places.get(one.name, -1) if not name else -1
        has_length = place >= 0 and is_length(written.coordinates[place].kind)
        force = names.index(name) if names.count(name) == 1 else -1
        has_length = has_length or (force >= 0 and written.forces[force].coordinate < 0)
        unit = float(written.unit) if has_length else 1.0
        found.append(GivenMeasure(place, force, one.is_length, unit))
    return found


def _states(program: Program, system: System) -> list[ReferenceState]:
    """States: the start, one near it that moves, and one that no assembly would leave."""
    work = ProgramInterpreter(program)
    stream = Sha256Random(f"states of {system.name}")
    q, v = [float(x) for x in work["q"]], [float(x) for x in work["v"]]
    lengths = {slot for pair in shift_slots(program) for slot in pair}
    length = characteristic_length(system)
    sizes = {
        name: [length if base + k in lengths else 1.0 for k in range(size)]
        for name, base, size in (
            (one.name, one.base, one.size) for one in program.regions if one.name in {"q", "v"}
        )
    }

    def moved(values: Sequence[float], name: str, size: float) -> list[float]:
        return [
            x + size * scale * stream.sign() * stream.magnitude()
            for x, scale in zip(values, sizes[name], strict=True)
        ]

    given = [value for _, value in system.parameters]
    near = moved(q, "q", 2.0**-10), moved(v, "v", 1.0)
    states = [
        ReferenceState("start", 0.0, q, v, given),
        ReferenceState("near the start, moving", 0.75, *near, given),
        ReferenceState(
            "not assembled, fast", 1.5, moved(q, "q", 2.0**-4), moved(v, "v", 4.0), given
        ),
    ]
    if other := _other_parameters(program, given):
        states.append(ReferenceState("near the start, other parameters", 0.75, *near, other))
    return states


def _other_parameters(program: Program, given: Sequence[float]) -> list[float]:
    """Other values of parameters that a scene may have; none where all are fixed."""
    if not program.design:
        return []
    places = dict(program.design.places)
    for part in PARTS_OF_CHANGES:
        other = [
            value + part * (other_value(value, place) - value) for place, value in enumerate(given)
        ]
        work = ProgramInterpreter(program)
        work["parameters"] = other
        work.run("setup")
        if all(work["design"][places[key]] > 0 for _, key in program.design.positive):
            return other
    return []


def _point(program: Program, system: System, state: ReferenceState) -> dict[str, object] | None:
    """Results at a state, None where they are not finite or not determined."""
    work = ProgramInterpreter(program, HIGH)
    given = {"t": [state.time], "q": state.q, "v": state.v}
    if system.parameters:
        given["parameters"] = state.parameters
    for name, values in given.items():
        work[name] = [HIGH.number(Fraction(x)) for x in values]
    # What loops find is no task of the program.
    given_too = {"reactions"} if program.shares_out else set()
    hidden = {*GIVEN, *given_too}
    regions = [one for one in program.regions if one.size and one.name not in hidden]
    slots = [one.base + k for one in regions for k in range(one.size)]
    try:
        before = ["setup"] if program.design else []
        steps = run_and_keep(work, [*before, *(segment.name for segment in program.segments)])
        sizes = iter(units(work, steps, slots))
        outputs = {
            one.name: _columns(work[one.name], list(islice(sizes, one.size))) for one in regions
        }
    except (ArithmeticError, ValueError, TypeError):  # a pole, or a root that is not real
        return None
    if not all(math.isfinite(x) for own in outputs.values() for row in own.values() for x in row):
        return None
    return {
        "label": state.label,
        "time": state.time,
        "q": state.q,
        "v": state.v,
        **({"parameters": state.parameters} if program.design else {}),
        "outputs": outputs,
    }


def _columns(values: Sequence[Any], sizes: Sequence[float]) -> dict[str, list[float]]:
    """High, low and unit of the numbers of a region; it is exactly zero where units are."""
    least = SECOND_ORDER * max(sizes)
    rounded = [float(f"{max(size, least):.2e}") for size in sizes]
    high = [float(value) for value in values]
    low = [float(value - x) for value, x in zip(values, high, strict=True)]
    return {"high": high, "low": [float(f"{x:.4e}") for x in low], "unit": rounded}
