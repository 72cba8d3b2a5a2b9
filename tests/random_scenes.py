"""Random scenes of bodies: all that a scene file may hold, in mechanisms that fit together.

``random_scene(random.Random(7), 7)`` is one of :data:`COUNT` scenes that have everything together;
``random_scene(draw)`` is any scene, and ``draw`` may be Hypothesis'.
"""

from __future__ import annotations

import random
import tomllib
from itertools import combinations
from typing import TYPE_CHECKING, Any

from kousoku.model.elements.joint import ANGLE
from kousoku.model.elements.joints import free_coordinates_of
from tests.random_draft import Draft
from tests.random_geometry import DIRECTIONS
from tests.random_mechanisms import DETERMINED, JOINT_NAMES, MECHANISMS
from tests.random_more import add_more
from tests.rare_scenes import RARE

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from tests.random_draft import Tree
    from tests.random_geometry import Vector
    from tests.random_mechanisms import Driven

COUNT = 50
"""Scenes that have together all that is drawn."""

GRAVITIES: tuple[Vector, ...] = ((0, 0, 0), (0, 0, -9.81), (0, -9.81, 0), (3, 4, -8))

OUTPUTS = ("accelerations", "coordinates", "reactions", "energies")
WANTED = [chosen for size in range(5) for chosen in combinations(OUTPUTS, size)]
"""All combinations of outputs."""


def _load(draft: Draft, kind: str, key: str) -> Tree:
    """Force or torque; two of three components are formulas."""
    size = draft.metre if kind == "force" else draft.metre**2
    components: list[float | str] = [draft.load(size), draft.load(size), size]
    entry = {"type": kind, "body": draft.rigid(), key: components}
    return entry | ({"point": draft.designs(draft.vector(draft.metre))} if kind == "force" else {})


def _spring(draft: Draft, **more: Any) -> Tree:
    """Spring from a place above to a body."""
    body = draft.draw.choice([name for name in draft.poses if name != "ground"] or [draft.rigid()])
    end = [0, 0, 0] if body in draft.points else draft.designs(draft.vector(draft.metre / 4))
    above = draft.poses[body].place((0, 0, 0))
    start = [above[0], above[1] + 0.5 * draft.metre, above[2] + 1.5 * draft.metre]
    return {"type": "spring_damper", "bodies": ["ground", body], "points": [start, end], **more}


def _rotational(draft: Draft, **more: Any) -> Tree:
    joint, of = draft.free(("angle", "second_angle"))
    two = "second_angle" in free_coordinates_of(draft.type_of(joint))
    own = {"joint": joint} | ({"of": of} if two else {})
    return {"type": "rotational_spring_damper", **own, **more}


def _friction(draft: Draft, *, is_of: bool) -> Tree:
    joint, of = draft.free(("angle", "displacement"))
    # of an angle it is another number
    is_of = is_of or len(free_coordinates_of(draft.type_of(joint))) > 1
    damping = draft.formula(0.25 * draft.metre**2 if "angle" in of else 0.25)
    return {"type": "friction", "joint": joint, "damping": damping} | ({"of": of} if is_of else {})


def _bushing(draft: Draft, **more: Any) -> Tree:
    body = draft.rigid()
    six = [20.0] * 3 + [2 * draft.metre**2] * 3
    here: Tree = {"at": draft.designs(draft.poses[body].r)}
    if "axes" in more:
        here = {"points": [list(draft.poses[body].r), draft.designs((0, 0, 0))]}
    return {"type": "bushing", "bodies": ["ground", body], "damping": six, **here, **more}


def _along(draft: Draft) -> Tree:
    coordinate = draft.coordinate()
    joint = draft.table("coordinates")[coordinate]
    return {
        "type": "along",
        "coordinate": coordinate,
        "force": draft.load(draft.metre if "disp" in joint.get("of", "") else draft.metre**2),
    }


FORCES: dict[str, Callable[[Draft], Tree]] = {
    "force": lambda draft: _load(draft, "force", "force"),
    "force_b": lambda draft: _load(draft, "force", "force_b"),
    "torque": lambda draft: _load(draft, "torque", "torque"),
    "torque_b": lambda draft: _load(draft, "torque", "torque_b"),
    "along": _along,
    "spring": lambda draft: _spring(draft, stiffness=draft.design(20.0), damping=0.5),
    "rotational": lambda draft: _rotational(draft, stiffness=draft.design(3 * draft.metre**2)),
    "friction": lambda draft: _friction(draft, is_of=False),
    "bushing": lambda draft: _bushing(
        draft, stiffness=[draft.design(30.0)] * 3 + [k * draft.metre**2 for k in (1, 2, 3)]
    ),
    "free length": lambda draft: _spring(
        draft, stiffness=15, free_length=draft.design(draft.length(0.5, 1))
    ),
    "damper": lambda draft: _spring(draft, damping=draft.formula(2.0)),
    "tension": lambda draft: _spring(draft, tension="50*x + 10*abs(x)*x + 5*v*exp(-t)"),
    "free angle": lambda draft: _rotational(
        draft, stiffness=draft.metre**2, damping=0.1 * draft.metre**2, free_angle=draft.formula(0.5)
    ),
    "moment": lambda draft: _rotational(draft, moment=f"{draft.metre**2:g}*(2*sin(x) + 0.1*v)"),
    "rotational of": lambda draft: {
        "type": "rotational_spring_damper",
        "coordinate": draft.coordinate(("angle", "second_angle")),
        "stiffness": 2 * draft.metre**2,
    },
    "friction of": lambda draft: _friction(draft, is_of=True),
    "bushing of": lambda draft: _bushing(draft, axes=[[1, 2, 0], [0, 0, 1]]),
    "tension of t": lambda draft: _spring(draft, tension=f"{draft.metre:g}*(2 + sin(4*t))"),
}
"""What acts on bodies."""


def _own_joint(draft: Draft, kind: str, of: str = "") -> Tree:
    return {"joint": draft.hang(kind)} | ({"of": of} if of else {})


def _own_coordinate(draft: Draft) -> Tree:
    angle = {"joint": draft.hang("revolute"), "near": 0.0}
    return {"coordinate": draft.add("coordinates", angle)}


def _distance(draft: Draft) -> Tree:
    at = draft.place()
    body = draft.body(at)
    start = [at[0], at[1], at[2] + 2 * draft.metre]
    points = [start, draft.designs((0, 0, 0))]
    u = draft.add("coordinates", {"bodies": ["ground", body], "points": points})
    return {"coordinate": u, "value": draft.law(2 * draft.metre, 0.5 * draft.metre)}


def _height(draft: Draft) -> Tree:
    at = draft.place()
    u = draft.add("coordinates", {"body": draft.body(at), "along": [0, 0, 1]})
    return {"coordinate": u, "value": draft.law(at[2], draft.metre)}


def _path(draft: Draft, *, is_point: bool) -> Tree:
    at = draft.place()
    body = draft.body(at, is_point=is_point)
    s = (0.0, 0.0, 0.0) if is_point else draft.vector(draft.metre / 4)
    place = draft.poses[body].place(s)
    path = [draft.law(place[0], draft.metre), draft.law(place[1], draft.metre), place[2]]
    return {"body": body, "path": path} | ({} if is_point else {"point": list(s)})


DRIVERS: dict[str, Callable[[Draft], Tree]] = {
    "angle": lambda draft: _own_joint(draft, "revolute") | {"value": draft.law(0)},
    "coordinate": lambda draft: _own_coordinate(draft) | {"value": draft.law(0)},
    "displacement": lambda draft: (
        _own_joint(draft, "prismatic") | {"value": draft.law(0, draft.metre)}
    ),
    "distance": _distance,
    "path": lambda draft: _path(draft, is_point=False),
    "angle of": lambda draft: _own_joint(draft, "cylindrical", "angle") | {"value": draft.law(0)},
    "place": _height,
    "second angle": lambda draft: (
        _own_joint(draft, "hooke", "second_angle") | {"value": draft.law(0)}
    ),
    "path of a point": lambda draft: _path(draft, is_point=True),
}
"""What is driven; each brings a body of its own."""


def _drive(draft: Draft, joints: Driven) -> None:
    """Drive all of these joints, by formulas or as inputs."""
    for joint in joints:
        free = free_coordinates_of(draft.type_of(joint))
        size = 1.0 if free[0] == ANGLE else 0.25 * draft.metre
        # Inputs take the same time: there is one, and drivers do the rest.
        if joint == joints[0] and len(free) == 1 and draft.pick("input", (False, True)):
            way: Tree = {"turns": 0.125} if free[0] == ANGLE else {"to": size}
            way |= draft.pick("rate", ({}, {"rate": size}, {"rate": size, "acceleration": size}))
            draft.add("inputs", {"joint": joint, **way})
            draft.tree["divisions"] = 20
        else:
            law = {"value": draft.law(0, size)}
            draft.add("drivers", draft.leaf(joint, free[0]) | law)


def _grow(draft: Draft) -> None:
    """Add bodies on any joints, each on one before or on the ground."""
    for _ in range(2 + draft.draw.randrange(2)):
        name = draft.pick("joint", JOINT_NAMES, each=2)
        i = draft.draw.choice([one for one in draft.poses if one not in draft.points])
        at = draft.place()
        offset = draft.vector(draft.metre / 2)
        j = draft.body((at[0] + offset[0], at[1] + offset[1], at[2] - draft.metre / 2 + offset[2]))
        draft.join(name, i, j, at, draft.draw.choice(DIRECTIONS))


def _build(draft: Draft, wanted: Sequence[str]) -> None:
    """Add bodies, joints, forces and drivers."""
    is_driven = draft.kind == "driven"
    has_forces = draft.kind == "tree" or draft.pick("has forces", (True, False), every=2)
    weightless = not (has_forces or "reactions" in wanted or "energies" in wanted)
    draft.may_be_massless = is_driven and weightless
    if draft.kind == "tree":
        _grow(draft)
    else:
        names = DETERMINED if is_driven else [*MECHANISMS]
        driven = MECHANISMS[draft.pick("mechanism", names)](draft)
        if is_driven:
            _drive(draft, driven)
        elif draft.pick("more", (False, True)):
            MECHANISMS["wheels"](draft)
    if has_forces:
        for _ in range(1 + draft.draw.randrange(2)):
            draft.add("forces", FORCES[draft.pick("force", [*FORCES])](draft))
    may_hold = not (is_driven or draft.is_parametric or draft.is_written_off)
    if may_hold and draft.pick("held", (False, True), every=2):
        draft.table("coordinates")[draft.coordinate()]["hold"] = True
    if draft.kind == "tree" and draft.pick("has driver", (False, True)):
        draft.add("drivers", DRIVERS[draft.pick("driver", [*DRIVERS], every=2)](draft))


def random_scene(draw: random.Random, number: int | None = None) -> Tree:
    """Random scene of bodies, as :func:`tomllib.loads` would give it.

    Parameters
    ----------
    draw : random.Random
        What chooses; the same one gives the same scene.
    number : int, optional
        Which of the :data:`COUNT` scenes it is that have everything together; any scene when left
        out.

    Returns
    -------
    dict
        The tables of the scene.
    """
    draft = Draft(draw, number)
    wanted = list(draft.pick("outputs", WANTED))
    _build(draft, wanted)
    if number is None and draft.kind != "driven":  # the numbered ones stay what they are
        add_more(draft)
    has_more = draft.tree.keys() & {"forces", "drivers", "inputs"}
    if any(gravity := draft.draw.choice(GRAVITIES if has_more else GRAVITIES[1:])):
        draft.tree["gravity"] = [draft.design(draft.metre * g) for g in gravity]
    if "coordinates" in wanted and not draft.table("coordinates"):
        draft.coordinate()
    draft.write_off()
    outputs = [*(["velocities"] if draft.draw.randrange(2) else []), *wanted]
    return {key: value for key, value in draft.tree.items() if value} | {"outputs": outputs}


def numbered_scenes() -> list[Tree]:
    """Scenes that have everything together, the same ones each time; written ones at the end."""
    drawn = [random_scene(random.Random(number), number) for number in range(COUNT)]
    return drawn + [tomllib.loads(text) for text in RARE]
