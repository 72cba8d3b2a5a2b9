"""Reference values of a scene's solver at a few states, in 50 digits, from two sources.

The tasks of the program are run as they were composed; straight-line code, C and Python have no
part in it. Faults of the composition itself show against :mod:`.independent`, in which it has no
part.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.codegen.dynamics.checking.independent import (
    ComparedSolver,
    MeasureSource,
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
#: Least unit, relative to the largest of its region: roundings of roundings count there.
SECOND_ORDER = 2.0**-40
#: Fractions of the changes of all parameters that are tried, until moments of inertia are possible.
PARAMETER_STEPS = (1.0, 2.0**-4, 2.0**-8, 2.0**-16)
#: Nodes that are numbers and not operations.
LEAVES = frozenset({Op.CONST, Op.INPUT})
#: Operations whose derivatives jump.
KINKS = frozenset({Op.ABS, Op.MAX})


@dataclass(frozen=True, slots=True)
class ReferenceState:
    """State at which a program is run.

    Parameters
    ----------
    label : str
        Kind of state.
    time : float [s]
        Time.
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
        System that it was composed of.
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
    points: list[dict[str, object]] = []
    independent: list[dict[str, object]] = []
    functions: list[dict[str, object]] = []
    if count <= MOST_OPERATIONS:
        states = _states(program, system)
        points = [point for state in states if (point := _point(program, system, state))]
        independent = independent_points(_compared_solver(program, system, written))
        functions = root_function_points(program, system)
    return to_text(
        {
            "format": REFERENCE_FORMATS["dynamics"],
            "package": system.name,
            "is_exact": _uses_only(program, EXACT_OPS | LEAVES),
            "is_smooth": _uses_only(program, frozenset(Op) - KINKS),
            "operations": count,
            "most_operations": MOST_OPERATIONS,
            "points": points,
            "independent": independent,
            "functions": functions,
        }
    )


def _uses_only(program: Program, allowed: frozenset[Op]) -> bool:
    """Whether a program has no operations beside the allowed ones."""
    return all(node.op in allowed for kernel in program.kernels for node in kernel.nodes)


def _compared_solver(program: Program, system: System, written: System) -> ComparedSolver:
    """Solver as the independent check sees it: scene, coordinates, momenta, none of its results."""
    data = motion_data(program, system)
    numbers = ProgramInterpreter(program)["design"] if program.design else []
    names = [
        [body.name for body in system.carried if body.carrier in part.bodies]
        if system.carried
        else [system.bodies[k].name for k in part.bodies]
        for part in program.conserved
    ]
    return ComparedSolver(
        system=fixed_system(written),
        layout=Layout.from_data(data).at(np.array(numbers, dtype=float)),
        q=np.array(data["q"], dtype=float),
        v=np.array(data["v"], dtype=float),
        turned_angles={
            counter.place.slot - program.region("q").base: counter.name
            for counter in program.auxiliary
            if counter.kind == TURNS
        },
        momenta=[
            (bodies, part.linear, part.angular, part.about)
            for bodies, part in zip(names, program.conserved, strict=True)
        ],
        has_masses=program.has_masses,
        measures=_measures(program, system, written),
    )


def _measures(program: Program, system: System, written: System) -> list[MeasureSource]:
    """Coordinates and lengths of springs that formulas read, by their places in the scene."""
    if not any(region.name == "measures" for region in program.regions):
        return []
    indices = {coordinate.name: k for k, coordinate in enumerate(written.coordinates)}
    names = [force.name for force in written.forces]
    sources = []
    for measure in root_functions_of(system).measures:
        name = system.forces[measure.force].name if measure.force >= 0 else ""
        index = indices.get(measure.name, -1) if not name else -1
        has_length = index >= 0 and is_length(written.coordinates[index].kind)
        force = names.index(name) if names.count(name) == 1 else -1
        has_length = has_length or (force >= 0 and written.forces[force].coordinate < 0)
        unit = float(written.unit) if has_length else 1.0
        sources.append(MeasureSource(index, force, measure.is_length, unit))
    return sources


def _states(program: Program, system: System) -> list[ReferenceState]:
    """States: the start, one near it that moves, and one that no assembly would leave."""
    work = ProgramInterpreter(program)
    stream = Sha256Random(f"states of {system.name}")
    q, v = [float(x) for x in work["q"]], [float(x) for x in work["v"]]
    lengths = {slot for pair in shift_slots(program) for slot in pair}
    length = characteristic_length(system)
    sizes = {
        region.name: [length if region.base + k in lengths else 1.0 for k in range(region.size)]
        for region in program.regions
        if region.name in {"q", "v"}
    }

    def moved(values: Sequence[float], name: str, size: float) -> list[float]:
        return [
            x + size * scale * stream.sign() * stream.magnitude()
            for x, scale in zip(values, sizes[name], strict=True)
        ]

    parameters = [value for _, value in system.parameters]
    near = moved(q, "q", 2.0**-10), moved(v, "v", 1.0)
    states = [
        ReferenceState("start", 0.0, q, v, parameters),
        ReferenceState("near the start, moving", 0.75, *near, parameters),
        ReferenceState(
            "not assembled, fast", 1.5, moved(q, "q", 2.0**-4), moved(v, "v", 4.0), parameters
        ),
    ]
    if other := _other_parameters(program, parameters):
        states.append(ReferenceState("near the start, other parameters", 0.75, *near, other))
    return states


def _other_parameters(program: Program, values: Sequence[float]) -> list[float]:
    """Other values of parameters that a scene may have; none where all are fixed."""
    if not program.design:
        return []
    indices = dict(program.design.places)
    for step in PARAMETER_STEPS:
        other = [
            value + step * (other_value(value, index) - value) for index, value in enumerate(values)
        ]
        work = ProgramInterpreter(program)
        work["parameters"] = other
        work.run("setup")
        if all(work["design"][indices[key]] > 0 for _, key in program.design.positive):
            return other
    return []


def _point(program: Program, system: System, state: ReferenceState) -> dict[str, object] | None:
    """Results at a state, None where they are not finite or not determined."""
    work = ProgramInterpreter(program, HIGH)
    inputs = {"t": [state.time], "q": state.q, "v": state.v}
    if system.parameters:
        inputs["parameters"] = state.parameters
    for name, values in inputs.items():
        work[name] = [HIGH.number(Fraction(x)) for x in values]
    # Loops outside the program compute reactions that are shared out.
    unwritten = {"reactions"} if program.shares_out else set()
    hidden = {*GIVEN, *unwritten}
    regions = [region for region in program.regions if region.size and region.name not in hidden]
    slots = [region.base + k for region in regions for k in range(region.size)]
    try:
        before = ["setup"] if program.design else []
        steps = run_and_keep(work, [*before, *(segment.name for segment in program.segments)])
        sizes = iter(units(work, steps, slots))
        outputs = {
            region.name: _columns(work[region.name], list(islice(sizes, region.size)))
            for region in regions
        }
    except (ArithmeticError, ValueError, TypeError):  # a pole, or a root that is not real
        return None
    lists = (values for columns in outputs.values() for values in columns.values())
    if not all(math.isfinite(x) for values in lists for x in values):
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
    """High, low and unit of the numbers of a region; a number of unit zero is exactly zero."""
    least = SECOND_ORDER * max(sizes)
    rounded = [float(f"{max(size, least):.2e}") for size in sizes]
    high = [float(value) for value in values]
    low = [float(value - x) for value, x in zip(values, high, strict=True)]
    return {"high": high, "low": [float(f"{x:.4e}") for x in low], "unit": rounded}
