"""Numbers of a solver that are the same in all languages: sizes, indices, tables."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from kousoku.codegen.dynamics.composition.auxiliary import TURNS, WORK
from kousoku.codegen.dynamics.composition.switching import BOUNDS
from kousoku.codegen.dynamics.operations.body_coordinates import with_all_inertias
from kousoku.codegen.dynamics.redundancy.redundant_rows import take_over
from kousoku.codegen.dynamics.redundancy.varying_rank import rank_rows
from kousoku.codegen.dynamics.simplification.body_blocks import inverse_masses
from kousoku.model.lowering.root_functions import root_functions_of
from kousoku.model.mechanics.constraints import is_length
from kousoku.model.numbers import precise
from kousoku.model.numbers.varying import is_varying
from kousoku.runtime.integrate.settings import ACTIONS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.program import Program, RowIndex
    from kousoku.model.lowering.root_functions import Measure, PartScale
    from kousoku.model.mechanics.multibody import System

#: Least ratio of the masses of a run to those of the scene, where parameters change them.
LEAST_MASS_PART = 1e-30
#: Floor of coordinates whose changes are ignored.
IGNORED = 1e300


def layout_sizes(program: Program) -> dict[str, int]:
    """Counts of the layout of a solver, by their names in C."""
    present = {region.name: region.size for region in program.regions}
    counted = unwrapped_angles(program)
    crossings = sum(present.get(name, 0) for name in ("crossings", "breaks", "poles"))
    return {
        "NQ": present["q"],
        "NV": present["v"],
        "NC": present["C"],
        "NCHECK": present["C"] + present.get("C_left_out", 0),
        "ADDED": added(program),
        "WORKS": works(program),
        "UNWRAPPED_ANGLES": counted.start,
        "UNWRAPPED_ANGLES_END": counted.stop,
        "MOMENTA": present.get("momenta", 0),
        "CONSTANTS": present["constants"],
        "N_PARAMETERS": present.get("parameters", 0),
        "N_DESIGN": present.get("design", 0),
        "N_POWER": present.get("more_power", 0),
        "N_WRENCHES": present.get("wrenches", 0),
        "N_SWITCHES": present.get("switches", 0) // BOUNDS,
        "N_FEATURES": present.get("features", 0) // BOUNDS,
        "N_GAPS": present.get("gaps", 0) // BOUNDS,
        "N_LAWS": present.get("laws", 0) // BOUNDS,
        "N_MEASURES": present.get("measures", 0) // 2,
        "N_CROSSINGS": crossings // BOUNDS,
        "N_BREAKS": present.get("breaks", 0) // BOUNDS,
        "N_POLES": present.get("poles", 0) // BOUNDS,
        "N_NARROW": present.get("narrow", 0) // BOUNDS,
        "N_INFINITE": present.get("infinite", 0) // BOUNDS,
        "N_LENGTHS": present.get("lengths", 0),
        "N_DISTANCES": present.get("lengths", 0) + present.get("distances", 0),
    }


def works(program: Program) -> int:
    """Number of entries at the end of q that are works."""
    return sum(entry.kind == WORK for entry in program.auxiliary) if program.has_masses else 0


def unwrapped_angles(program: Program) -> range:
    """Entries of q that count turns."""
    counted = [counter.place.slot for counter in program.auxiliary if counter.kind == TURNS]
    first = min(counted) - program.region("q").base if counted else 0
    return range(first, first + len(counted))


#: Numbers and rows of numbers, each with the body, joint or driver that it belongs to.
Table = list[tuple[str, Any]]


def tables(
    program: Program, system: System, length: float, parts: Sequence[str]
) -> dict[str, Table]:
    """Tables of a solver, the same for all languages.

    Parameters
    ----------
    program : Program
        Task lists, or the program that inlining made of them.
    system : System
        System that it was composed of.
    length : float [m]
        A length of the scene, to which corrections are compared.
    parts : sequence of str
        Regions that a row has beyond time, q and v.
    """
    owner = owners(program)
    q, v = slots(program, "q"), slots(program, "v")
    shifts, starts = shift_slots(program), start_places(program)
    lengths = {slot for pair in shifts for slot in pair}
    switched, functions = has_row_switch(program), root_functions_of(system)
    rows = (*program.rows, *program.left_out, *program.satisfied)
    ranked = rank_rows(program, system)
    compares = bool(ranked) or is_driven(program, system)
    return {
        "parameters": list(system.parameters),
        "is_length": [(owner[slot], int(slot in lengths)) for slot in v],
        "floors": list(zip((owner[slot] for slot in q), floors(program, length), strict=True))
        if compares
        else [],
        "shifts": [(owner[a], (a - q.start, b - v.start)) for a, b in shifts],
        "orientations": [
            (owner[a], (a - q.start, b - v.start, n)) for a, b, n in orientation_slots(program)
        ],
        "inverse_masses": [
            (owner[slot], float(x))
            for slot, x in zip(v, inverse_mass_table(program, system), strict=True)
        ]
        if switched
        else [],
        "mass_places": [
            (owner[slot], k) for slot, k in zip(v, mass_places(program, system), strict=False)
        ]
        if switched
        else [],
        "drivers": driver_rows(program, system) if switched else [],
        "rank_rows": ranked,
        "starts": [(owner[(*q, *v)[index]], (index, entry)) for index, entry in starts],
        "positive": positive_places(program),
        "measure_sizes": [
            (measure.name, float(measure_size(measure, system, length)))
            for measure in functions.measures
        ],
        "narrow_scales": part_scales(functions.narrow_scales, program, system, length),
        "feature_scales": part_scales(functions.feature_scales, program, system, length),
        "events": [
            (event.name, (event.direction, ACTIONS.index(event.action), int(jumps)))
            for event, jumps in zip(system.events, functions.jumps, strict=True)
        ],
        "row_is_length": [
            (name, int(unit == "m")) for name, unit in (row_of(row, system) for row in rows)
        ],
        "parts": [(part, (program.region(part).base, program.region(part).size)) for part in parts],
    }


def part_scales(
    parts: Sequence[PartScale], program: Program, system: System, length: float
) -> Table:
    """Scales of the variations of parts of formulas, and whether each is over a square of times.

    The scale of a force moves the lightest body by the length of the scene in that time; where
    bodies have no masses it is the size of the part, and where a run may change masses a small
    fraction of that. The scale of a driver's law is the length of the scene or 1 rad, or the size
    of the part where that is less.
    """
    span, mass = length / system.unit, lightest_mass(system, length)
    changes = any(is_varying(x) for body in system.bodies for x in (body.mass, *body.inertia))
    scales: Table = []
    for part in parts:
        size = part.size if 0.0 < part.size < math.inf else 1.0
        size *= LEAST_MASS_PART if changes and program.has_masses else 1.0
        forces = {"N": mass * span, "N m": mass * span * span, "m/s^2": span}
        driven = {"m": min(span, size), "rad": min(1.0, size)}
        if any(unit in driven for unit in part.units) or changes or not program.has_masses:
            scales.append(("", (min(driven.get(unit, size) for unit in part.units), 0)))
        else:
            scales.append(("", (min(forces[unit] for unit in part.units), 1)))
    return scales


def lightest_mass(system: System, length: float) -> float:
    """Least of the masses of bodies, and of their moments of inertia over the square of a length.

    Those that are zero are left out; 1 where none has any [kg].
    """
    bodies = system.bodies
    masses = [float(body.mass) for body in bodies]
    masses += [float(moment) / (length * length) for body in bodies for moment in body.inertia]
    return min((mass for mass in masses if mass > 0.0), default=1.0)


def measure_size(measure: Measure, system: System, length: float) -> float:
    """Scale of the errors of a measure: the length of the scene in its unit, or 1 rad."""
    if measure.coordinate < 0:
        return length / system.unit
    if not is_length(system.coordinates[measure.coordinate].kind):
        return 1.0
    return length / (system.unit if measure.force < 0 else 1.0)


def row_of(row: RowIndex, system: System) -> list[str]:
    """Name of the joint of a row, or the key of its driver, and the unit of its residual."""
    instance = system.constraints[row.instance]
    name = f"drivers.{row.joint}" if instance.is_driver else row.joint
    return [name, instance.row_unit]


def owners(program: Program) -> dict[int, str]:
    """Body, or the name of the auxiliary entry, of each slot of q and v."""
    names = {entry.place.slot: entry.name for entry in program.auxiliary}
    for body in program.bodies:
        for place in (*body.r, *body.p, *body.v, *body.omega_b):
            if place.slot >= 0:
                names[place.slot] = body.body
    return names


def has_drivers(system: System) -> bool:
    """Whether constraints depend on time."""
    return any(instance.is_driver for instance in system.constraints)


def has_row_switch(program: Program) -> bool:
    """Whether rows that are left out take over where those that are kept lose rank."""
    return take_over(len(program.rows), len(program.left_out))


def driver_rows(program: Program, system: System) -> Table:
    """Rows of drivers: index of each row, and index of its work in q."""
    base = program.region("q").base
    works = {work.name: work.place.slot - base for work in program.auxiliary if work.kind == WORK}
    rows = [(k, system.constraints[row.instance]) for k, row in enumerate(program.rows)]
    return [(driver.joint, (k, works[driver.joint])) for k, driver in rows if driver.is_driver]


def inverse_mass_table(program: Program, system: System) -> list[float]:
    """Diagonal of M⁻¹ in the order of v, zero where there is no mass.

    A planar scene that is computed in space takes the moments of inertia that it lacks.
    """
    if not program.is_planar:
        system = with_all_inertias(system)
    diagonal = [0.0] * program.region("v").size
    base = program.region("v").base
    for body, places in zip(system.bodies, program.bodies, strict=True):
        inverse = inverse_masses(body, range(6))
        for place, value in zip((*places.v, *places.omega_b), inverse, strict=True):
            if place.slot >= 0:
                diagonal[place.slot - base] = precise.double(value)
    return diagonal


def mass_places(program: Program, system: System) -> list[int]:
    """Indices of inverse masses in the design, −1 of fixed ones; nothing if all are fixed."""
    diagonal = inverse_mass_table(program, system)
    if not any(map(is_varying, diagonal)):
        return []
    return [program.design.place(x) if is_varying(x) else -1 for x in diagonal]


def start_places(program: Program) -> list[tuple[int, int]]:
    """Indices in (q, v) of starts that depend on parameters, each with its index in the design."""
    q, v, design = program.region("q"), program.region("v"), dict(program.design.places)
    return [
        (slot - q.base if q.base <= slot < q.base + q.size else q.size + slot - v.base, design[key])
        for slot, key in program.design.start
    ]


def positive_places(program: Program) -> Table:
    """Indices in the design of numbers that must be positive, and their keys."""
    indices = dict(program.design.places)
    names = {indices[key]: name for name, key in reversed(program.design.positive)}
    order = dict.fromkeys(indices[key] for _, key in program.design.positive)
    return [(names[index], index) for index in order]


def is_driven(program: Program, system: System) -> bool:
    """Whether drivers and joints leave no freedom, so that the motion is kinematics."""
    count = len(program.rows) + len(program.satisfied)
    return has_drivers(system) and count == program.region("v").size


def slots(program: Program, name: str) -> range:
    """Slots of a region."""
    region = program.region(name)
    return range(region.base, region.base + region.size)


def floors(program: Program, length: float) -> list[float]:
    """Floors of the coordinates: the least scale of the change of each."""
    lengths = {slot for slot, _ in shift_slots(program)}
    ignored = {entry.place.slot for entry in program.auxiliary}
    entries = slots(program, "q")
    return [IGNORED if k in ignored else length if k in lengths else 1.0 for k in entries]


def shift_slots(program: Program) -> list[tuple[int, int]]:
    """Slots in q and in v of each variable length; first those that corrections are added to."""
    order = sorted(range(len(program.bodies)), key=program.placed.__contains__)
    bodies = (program.bodies[k] for k in order)
    pairs = ((r.slot, v.slot) for body in bodies for r, v in zip(body.r, body.v, strict=True))
    return [(r, v) for r, v in pairs if v >= 0]


def added(program: Program) -> int:
    """Number of lengths that corrections are added to; the lengths of placed bodies follow."""
    placed = (program.bodies[k] for k in program.placed)
    return len(shift_slots(program)) - sum(x.slot >= 0 for body in placed for x in body.v)


def orientation_slots(program: Program) -> list[tuple[int, int, int]]:
    """First slot of the Euler parameters, that of ω′, and count of variable parameters, by body."""
    turns = []
    for body in program.bodies:
        p = [place.slot for place in body.p if place.slot >= 0]
        omega = [place.slot for place in body.omega_b if place.slot >= 0]
        if p:
            turns.append((p[0], omega[0], len(p)))
    return turns
