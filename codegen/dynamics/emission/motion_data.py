"""Indices of bodies and joints in rows of results: the content of ``motion.json``."""

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

#: Regions that hold inputs, or that no evaluation fills.
GIVEN = ("t", "parameters", "constants", "q", "v", *ON_DEMAND_REGIONS)
ZERO_PLACE = CoordinatePlace(-1, 0.0)
#: Coordinates of the ground, for bodies that it carries.
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
        System that it was composed of.
    parts : sequence of str
        Regions that a row has beyond time, q and v.
    state : sequence of Field
        The layout of the state.
    about : About, optional
        Facts about the scene that a user may not expect.
    """
    about, functions = about or About(), root_functions_of(system)
    q, v = program.region("q").base, program.region("v").base
    varying: dict[str, object] = {"design": _design(program)} if program.design else {}
    if system.written_starts:
        varying["given"] = [
            asdict(replace(given, mass_properties=tuple(_shown(program, given.mass_properties))))
            for given in system.written_starts
        ]
    if any(instance.is_driver for instance in system.constraints):
        varying["driven"] = sorted(system.coordinates[index].name for index in _driven(system))
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
                "bodies": _names(system, momentum.bodies),
                "linear": [list(vector) for vector in momentum.linear],
                "angular": [list(vector) for vector in momentum.angular],
                "is_central": momentum.about is None,
            }
            for momentum in program.conserved
        ],
        **varying,
        "notes": list(about.notes),
        "moved": list(about.moved),
        "duration": about.duration,
        "jumps": list(about.jumps),
        "events": [[event.name, event.action] for event in system.events],
        "whens": [event.when for event in system.events],
        "led": list(functions.law_drivers),
        "drawn": list(functions.gap_drivers),
        "poles": list(functions.pole_forces),
        "works": [
            [work.name, work.place.slot - q] for work in program.auxiliary if work.kind == WORK
        ],
    }


def _design(program: Program) -> dict[str, object]:
    """Indices of numbers that depend on parameters: in the workspace, and among themselves."""
    region, indices = program.region("design"), dict(program.design.places)
    return {
        "place": [region.base, region.size],
        "start": [list(pair) for pair in start_places(program)],
        "positive": [[name, indices[key]] for name, key in program.design.positive],
    }


def _shown(program: Program, values: Iterable[float]) -> list[int | float]:
    """Numbers, each replaced by its index in the design where it depends on parameters."""
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
    for entry in program.auxiliary:
        start["q"][entry.place.slot - bases["q"]] = entry.place.value
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
    """Reactions of joints: the body that each acts on, its point, and its computed components."""
    every = (*program.rows, *program.left_out, *program.satisfied)
    rows = sorted(every, key=lambda row: row.instance)
    joints: dict[str, list[Instance]] = {}
    for row in rows:
        joints.setdefault(row.joint, []).append(system.constraints[row.instance])
    points = points_of(system)
    bases = [[place.slot for place in (*body.v, *body.omega_b)] for body in program.bodies]
    reactions: list[dict[str, object]] = []
    first = 0
    for joint, instances in joints.items():
        bodies = tuple(dict.fromkeys(body for instance in instances for body in instance.bodies))
        ends = loaded_bodies(bodies)
        for body in ends:
            loaded = system.bodies[body]
            live = sorted(slot for slot in bases[body] if slot >= 0)
            is_shared = len(bodies) > 2
            reactions.append(
                {
                    "joint": f"{joint}.{loaded.name}" if is_shared else joint,
                    "body": body,
                    "j": body if is_shared else bodies[1],
                    "point_b": _shown(
                        program, loaded.origin_b if is_shared else points.get(joint, ORIGIN)
                    ),
                    "columns": [first + live.index(k) if k >= 0 else -1 for k in bases[body]],
                }
            )
            first += len(live)
    return reactions


def _coordinates(system: System, parts: Sequence[str]) -> list[dict[str, object]]:
    """Columns of value, rate and acceleration of the coordinates that are shown."""
    count = 3 if "v_dot" in parts else 2
    return [
        {
            "name": system.coordinates[index].name,
            "is_length": is_length(system.coordinates[index].kind),
            "columns": list(range(count * k, count * (k + 1))),
        }
        for k, index in enumerate(system.shown)
    ]


def _driven(system: System) -> set[int]:
    """Coordinates that drivers determine, directly or by combinations with such coordinates."""
    driven: set[int] = set()
    before = -1
    while before < len(driven):
        before = len(driven)
        for instance in system.constraints:
            unknown = {term.coordinate for term in instance.terms} - driven
            is_determining = instance.is_driver or len(unknown) < len(instance.terms)
            driven |= unknown if len(unknown) == 1 and is_determining else set()
    return driven


def _names(system: System, bodies: Sequence[int]) -> list[str]:
    """Names of bodies; in a scene with carried bodies, of those that they carry."""
    if not system.carried:
        return [system.bodies[index].name for index in bodies]
    return [body.name for body in system.carried if body.carrier in bodies]


def _bodies(program: Program, system: System, q: int, v: int) -> list[dict[str, object]]:
    """Indices of all bodies of the scene, carried ones included."""
    if not system.carried:
        pairs = zip(system.bodies, program.bodies, strict=True)
        return [_body(program, body, places, q, v) for body, places in pairs]
    carriers = (*program.bodies, STILL)
    return [_body(program, body, carriers[body.carrier], q, v) for body in system.carried]


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
    """Indices of coordinates, and values of constants."""
    return [place.slot - base if place.slot >= 0 else float(place.value) for place in places]
