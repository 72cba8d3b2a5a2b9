"""Places of bodies and joints in a row of numbers, as ``motion.json`` tells them."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.composition.auxiliary import WORK
from kousoku.codegen.dynamics.composition.least_norm import ORIGIN
from kousoku.codegen.dynamics.emission.context_numbers import (
    is_driven,
    row_of,
    start_places,
)
from kousoku.codegen.dynamics.operations.characteristic_length import characteristic_length
from kousoku.codegen.dynamics.operations.joint_ends import loaded_bodies, points_of
from kousoku.codegen.dynamics.recording.program import (
    ON_DEMAND_REGIONS,
    BodyCoordinates,
    CoordinatePlace,
)
from kousoku.codegen.dynamics.simplification.forces_plane import is_flat
from kousoku.model.lowering.about import About
from kousoku.model.lowering.root_functions import root_functions_of
from kousoku.model.lowering.system import UNIT_NAMES
from kousoku.model.mechanics.constraints import is_length
from kousoku.model.numbers.varying import is_varying
from kousoku.runtime.integrate.state import fields_as_data

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.model.mechanics.multibody import Carried, Instance, MovingBody, System
    from kousoku.runtime.integrate.state import Field

#: Regions that hold what is given, or what no evaluation finds.
GIVEN = ("t", "parameters", "constants", "q", "v", *ON_DEMAND_REGIONS)
ZERO_PLACE = CoordinatePlace(-1, 0.0)
#: Where the ground is, for bodies that it carries.
STILL = BodyCoordinates(
    "",
    (ZERO_PLACE,) * 3,
    (CoordinatePlace(-1, 1.0), ZERO_PLACE, ZERO_PLACE, ZERO_PLACE),
    (ZERO_PLACE,) * 3,
    (ZERO_PLACE,) * 3,
)


def motion_data(
    program: Program,
    system: System,
    parts: Sequence[str] = (),
    state: Sequence[Field] = (),
    about: About | None = None,
) -> dict[str, object]:
    """Content of ``motion.json``.

    Parameters
    ----------
    program : Program
        The scene's program.
    system : System
        What it was composed of.
    parts : sequence of str
        Regions that a row has beyond time, q and v.
    state : sequence of Field
        The layout of the state.
    about : About, optional
        What the scene has beside numbers.
    """
    about, functions = about or About(), root_functions_of(system)
    q, v = program.region("q").base, program.region("v").base
    varying: dict[str, object] = {"design": _design(program)} if program.design else {}
    if system.given:
        varying["given"] = [
            asdict(replace(one, mass_properties=tuple(_shown(program, one.mass_properties))))
            for one in system.given
        ]
    if any(one.is_driver for one in system.constraints):
        varying["driven"] = sorted(system.coordinates[place].name for place in _driven(system))
    return {
        "format": 1,
        "name": system.name,
        "unit": system.unit,
        "unit_name": UNIT_NAMES[system.unit],
        **_start(program),
        "bodies": _bodies(program, system, q, v),
        "parameters": [[name, value] for name, value in system.parameters],
        "is_driven": is_driven(program, system),
        "has_masses": program.has_masses,
        "length": characteristic_length(system),
        "closure_tolerance": system.closure_tolerance,
        "rows": [row_of(row, system) for row in program.rows],
        "left_out": [row_of(row, system) for row in program.left_out],
        "satisfied": [row_of(row, system) for row in program.satisfied],
        "checked": _checked(program, system),
        "places": {
            region.name: [region.base, region.size]
            for region in program.regions
            if region.name not in GIVEN
        },
        "state": fields_as_data(state),
        "parts": [[part, program.region(part).size] for part in parts],
        "reactions": _reactions(program, system) if "reactions" in parts else [],
        "not_unique": list(program.not_unique) if "reactions" in parts else [],
        "undetermined": list(program.undetermined) if "reactions" in parts else [],
        "is_flat": is_flat(system, _normal(program)),
        "coordinates": _coordinates(system, parts) if "coordinates" in parts else [],
        "kept": [
            {
                "bodies": _names(system, one.bodies),
                "linear": [list(vector) for vector in one.linear],
                "angular": [list(vector) for vector in one.angular],
                "is_central": one.about is None,
            }
            for one in program.conserved
        ],
        **varying,
        "notes": list(about.notes),
        "moved": list(about.moved),
        "duration": about.duration,
        "jumps": list(about.jumps),
        "events": [[one.name, one.action] for one in system.events],
        "whens": [one.when for one in system.events],
        "led": list(functions.law_drivers),
        "drawn": list(functions.gap_drivers),
        "poles": list(functions.pole_forces),
        "works": [[one.name, one.place.slot - q] for one in program.auxiliary if one.kind == WORK],
    }


def _design(program: Program) -> dict[str, object]:
    """Places of numbers that depend on parameters: in the workspace, and among them."""
    region, places = program.region("design"), dict(program.design.places)
    return {
        "place": [region.base, region.size],
        "start": [list(pair) for pair in start_places(program)],
        "positive": [[name, places[key]] for name, key in program.design.positive],
    }


def _shown(program: Program, values: Iterable[float]) -> list[int | float]:
    """Number, or its index in the design where it depends on parameters."""
    return [program.design.place(x) if is_varying(x) else x for x in values]


def _start(program: Program) -> dict[str, list[float]]:
    """Start q and v."""
    bases = {"q": program.region("q").base, "v": program.region("v").base}
    start: dict[str, list[float]] = {name: [0.0] * program.region(name).size for name in ("q", "v")}
    for body in program.bodies:
        for name, places in (("q", body.r + body.p), ("v", body.v + body.omega_b)):
            for place in places:
                if place.slot >= 0:
                    start[name][place.slot - bases[name]] = place.value
    for one in program.auxiliary:
        start["q"][one.place.slot - bases["q"]] = one.place.value
    return start


def _normal(program: Program) -> int | None:
    """Axis across the plane of a program, None in space."""
    if not (program.is_planar and program.bodies):
        return None
    return next(k for k, place in enumerate(program.bodies[0].r) if place.slot < 0)


def _checked(program: Program, system: System) -> list[str]:
    """Joints and drivers of all rows, in the order of the scene."""
    rows = sorted(
        (*program.rows, *program.left_out, *program.satisfied), key=lambda row: row.instance
    )
    return list(dict.fromkeys(row_of(row, system)[0] for row in rows))


def _reactions(program: Program, system: System) -> list[dict[str, object]]:
    """Reactions by joint: on which body it acts, where, and which components are computed."""
    every = (*program.rows, *program.left_out, *program.satisfied)
    rows = sorted(every, key=lambda row: row.instance)
    joints: dict[str, list[Instance]] = {}
    for row in rows:
        joints.setdefault(row.joint, []).append(system.constraints[row.instance])
    points = points_of(system)
    bases = [[place.slot for place in (*one.v, *one.omega_b)] for one in program.bodies]
    found: list[dict[str, object]] = []
    first = 0
    for joint, instances in joints.items():
        bodies = tuple(dict.fromkeys(body for one in instances for body in one.bodies))
        ends = loaded_bodies(bodies)
        for body in ends:
            own = system.bodies[body]
            live = sorted(slot for slot in bases[body] if slot >= 0)
            is_shared = len(bodies) > 2
            found.append(
                {
                    "joint": f"{joint}.{own.name}" if is_shared else joint,
                    "body": body,
                    "j": body if is_shared else bodies[1],
                    "point_b": _shown(
                        program, own.origin_b if is_shared else points.get(joint, ORIGIN)
                    ),
                    "columns": [first + live.index(k) if k >= 0 else -1 for k in bases[body]],
                }
            )
            first += len(live)
    return found


def _coordinates(system: System, parts: Sequence[str]) -> list[dict[str, object]]:
    """Places of value, rate and acceleration of the coordinates that are shown."""
    count = 3 if "v_dot" in parts else 2
    return [
        {
            "name": system.coordinates[place].name,
            "is_length": is_length(system.coordinates[place].kind),
            "columns": list(range(count * k, count * (k + 1))),
        }
        for k, place in enumerate(system.shown)
    ]


def _driven(system: System) -> set[int]:
    """Coordinates that drivers determine, alone or by combinations with others that they do."""
    found: set[int] = set()
    before = -1
    while before < len(found):
        before = len(found)
        for one in system.constraints:
            left = {term.coordinate for term in one.terms} - found
            is_led = one.is_driver or len(left) < len(one.terms)
            found |= left if len(left) == 1 and is_led else set()
    return found


def _names(system: System, bodies: Sequence[int]) -> list[str]:
    """Names of bodies, of all that they carry where they carry some."""
    if not system.carried:
        return [system.bodies[index].name for index in bodies]
    return [one.name for one in system.carried if one.carrier in bodies]


def _bodies(program: Program, system: System, q: int, v: int) -> list[dict[str, object]]:
    """Places of all bodies of the scene, those too that others carry."""
    if not system.carried:
        pairs = zip(system.bodies, program.bodies, strict=True)
        return [_body(program, body, places, q, v) for body, places in pairs]
    carriers = (*program.bodies, STILL)
    return [_body(program, one, carriers[one.carrier], q, v) for one in system.carried]


def _body(
    program: Program, body: MovingBody | Carried, places: BodyCoordinates, q: int, v: int
) -> dict[str, object]:
    turns = not body.is_point
    return {
        "name": body.name,
        "r": _numbers(places.r, q),
        "p": _numbers(places.p, q) if turns else [],
        "v": _numbers(places.v, v),
        "omega_b": _numbers(places.omega_b, v) if turns else [],
        "origin_b": _shown(program, body.origin_b),
        "axes_b": _shown(program, body.axes_b),
    }


def _numbers(places: Iterable[CoordinatePlace], base: int) -> Sequence[int | float]:
    """Index for a coordinate, a number for a constant."""
    return [place.slot - base if place.slot >= 0 else float(place.value) for place in places]
