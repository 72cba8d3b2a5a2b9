"""The numbers that the solver of a program has in any language: sizes, places, weights."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.composition.auxiliary import TURNS, WORK
from kousoku.codegen.dynamics.composition.bodies import inverse_masses, thickened
from kousoku.codegen.dynamics.redundancy.left_out import take_over
from kousoku.model import precise
from kousoku.model.varying import is_varying

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanism import System

#: An error that is compared with this counts as none.
IGNORED = 1e300


def sizes(program: Program, parts: Sequence[str]) -> list[tuple[str, int]]:
    """Return what a solver is laid out by: where its regions are, and how large what it has is.

    Parameters
    ----------
    program : Program
        Task lists, or what inlining made of them.
    parts : sequence of str
        Regions that a row has beyond time, q and v.
    """
    found = [(f"W_{region.name.upper()}", region.base) for region in program.regions]
    counts = {"NQ": "q", "NV": "v", "NC": "C", "CONSTANTS": "constants"}
    found += [(name, program.region(region).size) for name, region in counts.items()]
    beside = len(program.left_out) + len(program.reduced)
    found.append(("NCHECK", len(program.rows) + beside))
    found += [("FITS", int(bool(program.reduced))), ("ADDED", _added(program))]
    found += [(f"N_{part.upper()}", program.region(part).size) for part in parts]
    found += [("N_FREE", one.size) for one in program.regions if one.name == "free"]
    works = sum(one.kind == WORK for one in program.auxiliary) if program.is_weighed else 0
    found.append(("WORKS", works))
    sized = {"more_power": "N_POWER", "wrenches": "N_WRENCHES"}
    found += [(sized[one.name], one.size) for one in program.regions if one.name in sized]
    counted = [one.place.slot for one in program.auxiliary if one.kind == TURNS]
    first = min(counted, default=0) - program.region("q").base if counted else 0
    found += [("COUNTED", first), ("COUNTED_END", first + len(counted))]
    found.append(("MOMENTA", sum(one.count for one in program.kept)))
    found += _parameter_sizes(program)
    if program.design:
        found.append(("N_DESIGN", program.region("design").size))
    found.append(("W_SIZE", program.size))
    return found


def _parameter_sizes(program: Program) -> list[tuple[str, int]]:
    """Return how many parameters there are, and where they are if there is no region of them."""
    for region in program.regions:
        if region.name == "parameters":
            return [("N_PARAMETERS", region.size)]
    return [("W_PARAMETERS", 0), ("N_PARAMETERS", 0)]


def has_drivers(system: System) -> bool:
    """Return whether constraints depend on time."""
    return any(instance.is_driver for instance in system.constraints)


def has_fallback(program: Program) -> bool:
    """Return whether rows that are left out take over where those that are kept lose rank."""
    return take_over(len(program.rows), len(program.left_out))


def driver_places(program: Program, system: System) -> list[tuple[int, int]]:
    """Return for each row of a driver which row it is, and where its work is in q."""
    base = program.region("q").base
    works = {one.name: one.place.slot - base for one in program.auxiliary if one.kind == WORK}
    owners = (system.constraints[row.instance] for row in program.rows)
    return [(k, works[one.joint]) for k, one in enumerate(owners) if one.is_driver]


def weights(program: Program, system: System) -> list[float]:
    """Return the diagonal of M⁻¹ in the order of v, zero where there is no mass.

    A scene that moves in a plane and is computed in space has the thickness that makes it move.
    """
    if not program.is_planar:
        system = thickened(system)
    found = [0.0] * program.region("v").size
    base = program.region("v").base
    for body, places in zip(system.bodies, program.bodies, strict=True):
        inverse = inverse_masses(body, range(6))
        for place, weight in zip((*places.v, *places.omega_b), inverse, strict=True):
            if place.slot >= 0:
                found[place.slot - base] = precise.double(weight)
    return found


def weight_places(program: Program, system: System) -> list[int]:
    """Return where the weights are in the design, −1 where they are fixed; nothing if all are."""
    given = weights(program, system)
    if not any(map(is_varying, given)):
        return []
    return [program.design.place(x) if is_varying(x) else -1 for x in given]


def start_places(program: Program) -> list[tuple[int, int]]:
    """Return where in (q, v) a start depends on parameters, and its place in the design."""
    q, v, places = program.region("q"), program.region("v"), dict(program.design.places)
    return [
        (slot - q.base if q.base <= slot < q.base + q.size else q.size + slot - v.base, places[key])
        for slot, key in program.design.start
    ]


def positive_places(program: Program) -> list[int]:
    """Return where in the design numbers are that must be positive."""
    places = dict(program.design.places)
    return list(dict.fromkeys(places[key] for _, key in program.design.positive))


def is_driven(program: Program, system: System) -> bool:
    """Return whether drivers and joints leave no freedom, so that the motion is kinematics."""
    count = len(program.rows) + len(program.reduced)
    return has_drivers(system) and count == program.region("v").size


def slots(program: Program, name: str) -> range:
    """Return the slots of a region."""
    region = program.region(name)
    return range(region.base, region.base + region.size)


def floors(program: Program, length: float) -> list[float]:
    """Return for each component of the state what its error is compared with when it is zero."""
    lengths = {slot for pair in shift_slots(program) for slot in pair}
    own = (*slots(program, "q"), *slots(program, "v"))
    ignored = {one.place.slot for one in program.auxiliary}
    return [IGNORED if k in ignored else length if k in lengths else 1.0 for k in own]


def shift_slots(program: Program) -> list[tuple[int, int]]:
    """Return the slots of each length that changes, in q and in v; first what is added to."""
    places = sorted(range(len(program.bodies)), key=program.placed.__contains__)
    bodies = (program.bodies[k] for k in places)
    pairs = ((r.slot, v.slot) for body in bodies for r, v in zip(body.r, body.v, strict=True))
    return [(r, v) for r, v in pairs if v >= 0]


def _added(program: Program) -> int:
    """Return to how many lengths corrections are added; the others follow from all else."""
    placed = (program.bodies[k] for k in program.placed)
    return len(shift_slots(program)) - sum(x.slot >= 0 for body in placed for x in body.v)


def turn_slots(program: Program) -> list[tuple[int, int, int]]:
    """Return the first slot of Euler parameters, that of the turn, and how many parameters vary."""
    found = []
    for body in program.bodies:
        p = [place.slot for place in body.p if place.slot >= 0]
        omega = [place.slot for place in body.omega_b if place.slot >= 0]
        if p:
            found.append((p[0], omega[0], len(p)))
    return found
