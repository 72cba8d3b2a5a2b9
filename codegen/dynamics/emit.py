"""Emit a scene of bodies: the solver in C, and what tells which number belongs to which body."""

from __future__ import annotations

import hashlib
from dataclasses import astuple
from typing import TYPE_CHECKING

from kousoku import __version__
from kousoku.codegen.dynamics.view import dynamics_view
from kousoku.codegen.emit import environment, manifest, template
from kousoku.codegen.jsontext import to_text
from kousoku.codegen.kernel import Package

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from kousoku.codegen.dynamics.program import Coordinates, Place, Program
    from kousoku.model.mechanism import MovingBody, System

MOTION_FILE = "motion.json"
TEMPLATES = {
    "solver.c": "dynamics/solver.c.jinja",
    "solver.h": "dynamics/solver.h.jinja",
}
#: What the text is made of, for the digest.
PARTS = (*TEMPLATES.values(), "dynamics/integrator.c.jinja", "c/_macros.jinja")


def emit_dynamics(program: Program, system: System) -> dict[str, str]:
    """Return the folder of a scene's solver.

    Parameters
    ----------
    program : Program
        Task lists, or what inlining made of them.
    system : System
        What the program was composed of.

    Returns
    -------
    dict of str to str
        File name and text, the manifest last.
    """
    view = dynamics_view(program, characteristic_length(system))
    templates = environment()
    total = hashlib.sha256(f"{__version__}\n{view!r}\n{astuple(system)!r}".encode())
    for part in PARTS:
        total.update(template(part).encode())
    signature = total.hexdigest()
    files = {
        name: templates.get_template(path).render(view=view, version=__version__, digest=signature)
        for name, path in TEMPLATES.items()
    }
    files[MOTION_FILE] = to_text(motion_data(program, system))
    package = Package(
        system.name, f"the motion of {system.name}", f"kousoku generate {system.name}.toml", ()
    )
    return files | {"manifest.json": manifest(package, signature, files).to_json()}


def characteristic_length(system: System) -> float:
    """Return the largest distance of a joint from the origin of a frame [m]; 1 where none is."""
    lengths = [
        max(abs(x) for x in numbers)
        for instance in system.constraints
        for name, numbers in instance.constants
        if name.startswith("s_") or name == "length"
    ]
    return max(lengths, default=0.0) or 1.0


def motion_data(program: Program, system: System) -> dict[str, object]:
    """Return what ``motion.json`` holds."""
    bases = {"q": program.region("q").base, "v": program.region("v").base}
    start: dict[str, list[float]] = {name: [0.0] * program.region(name).size for name in ("q", "v")}
    for body in program.bodies:
        for name, places in (("q", body.r + body.p), ("v", body.v + body.omega_b)):
            for place in places:
                if place.slot >= 0:
                    start[name][place.slot - bases[name]] = place.value
    return {
        "format": 1,
        "name": system.name,
        "unit": system.unit,
        **start,
        "bodies": [
            _body(body, places, bases["q"], bases["v"])
            for body, places in zip(system.bodies, program.bodies, strict=True)
        ],
    }


def _body(body: MovingBody, places: Coordinates, q: int, v: int) -> dict[str, object]:
    turns = not body.is_point
    return {
        "name": body.name,
        "r": _numbers(places.r, q),
        "p": _numbers(places.p, q) if turns else [],
        "v": _numbers(places.v, v),
        "omega_b": _numbers(places.omega_b, v) if turns else [],
        "origin_b": list(body.origin_b),
        "axes_b": list(body.axes_b),
    }


def _numbers(places: Iterable[Place], base: int) -> Sequence[int | float]:
    """Return an index for a coordinate, a number for what never changes."""
    return [place.slot - base if place.slot >= 0 else float(place.value) for place in places]
