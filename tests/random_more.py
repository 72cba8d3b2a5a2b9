"""What random scenes may have beside what the numbered ones have: each is drawn after all else."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.random_bodies import MASSES
from tests.random_geometry import DIRECTIONS, Pose, across, turn

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.random_draft import Draft, Tree
    from tests.random_geometry import Vector

WHEN = (
    *("t - 0.1", "{u}", "{u}_dot", "sin(20*t) - 0.3", "{u} - {p}*t", "min({u}, 1) + {u}_dot"),
    "max(t - 0.05, {u}_dot)*cos({u})",
)
"""Formulas of events."""

ACTIONS: tuple[Tree, ...] = ({}, {"action": "count"}, {"action": "record"}, {"action": "stop"})
WAYS: tuple[Tree, ...] = (
    {},
    {"direction": "rising"},
    {"direction": "falling"},
    {"direction": "both"},
)


def _events(draft: Draft) -> None:
    for _ in range(1 + draft.draw.randrange(3)):
        text = draft.draw.choice(WHEN)
        u = draft.coordinate(("angle", "second_angle")) if "{u}" in text else ""
        p = draft.parameter(0.5) if "{p}" in text else ""
        ways: Tree = draft.draw.choice(ACTIONS) | draft.draw.choice(WAYS)
        draft.add("events", {"when": text.format(u=u, p=p)} | ways)


def _simple(draft: Draft, r: Vector) -> str:
    """Add a body in the directions of frame O, whose inertia has them as principal axes."""
    name = draft.body(r, form="none")
    for key in ("mass", "center", "inertia", "boxes", "cylinders", "spheres", "rods"):
        draft.tree["bodies"][name].pop(key, None)
    draft.tree["bodies"][name].pop("mass_points", None)
    draft.tree["bodies"][name] |= MASSES["center" if draft.draw.randrange(2) else "mass"](draft)
    return name


def _door(draft: Draft) -> None:
    """Add a body on two hinges in line, whose rows depend on each other."""
    at, axis = draft.place(), draft.draw.choice(DIRECTIONS)
    body = draft.body((at[0] + draft.metre / 2, at[1], at[2]))
    size = sum(x * x for x in axis) ** 0.5
    far = tuple(x + draft.metre * a / size for x, a in zip(at, axis, strict=True))
    for point in (at, (far[0], far[1], far[2])):
        draft.join("revolute", "ground", body, point, axis)


def _bent(draft: Draft) -> None:
    """Add two shafts at an angle that a constant velocity joint connects."""
    at = draft.place()
    body = draft.body((at[0] + draft.metre / 2, at[1], at[2]))
    axis = draft.draw.choice(DIRECTIONS)
    second = times_turn(across(axis), draft.number(0.1, 1.2), axis)
    name = draft.join("constant_velocity", "ground", body, at, axis)
    joint = draft.table("joints")[name]
    if "axes" in joint:
        joint["axes"] = [list(axis), list(draft.poses[body].vector(second))]
    else:
        joint["second_axis"] = list(second)


def times_turn(about: Vector, angle: float, a: Vector) -> Vector:
    """Vector that is turned about another one."""
    return Pose(A=turn(about, angle)).place(a)


def _against(draft: Draft) -> None:
    """Add a joint whose axis points the other way in body j."""
    at, axis = draft.place(), draft.draw.choice(DIRECTIONS)
    body = draft.body((at[0], at[1] + draft.metre / 2, at[2]))
    kind = draft.draw.choice(("revolute", "cylindrical", "planar", "parallel_axes"))
    own = [list(axis), [-x for x in draft.poses[body].vector(axis)]]
    entry: Tree = {"type": kind, "bodies": ["ground", body], "axes": own}
    if kind != "parallel_axes":
        entry["points"] = [list(at), list(draft.poses[body].point(at))]
    draft.add("joints", entry)


def _chain(draft: Draft) -> None:
    """Add a chain of simple bodies in a plane, as a rope is."""
    at, before = draft.place(), "ground"
    axis = draft.draw.choice(DIRECTIONS[:3])
    along = across(axis)
    for k in range(2 + draft.draw.randrange(4)):
        x, y, z = (p + draft.metre * k / 2 * a for p, a in zip(at, along, strict=True))
        body = _simple(draft, (x, y, z))
        draft.join("revolute", before, body, (x, y, z), axis)
        before = body


def _between(draft: Draft) -> None:
    """Add a spring between bodies, and what acts on a point."""
    bodies = [name for name in draft.poses if name != "ground"]
    i, j = draft.draw.choice(bodies), draft.body(draft.place(), is_point=True)
    ends = [[0, 0, 0] if one in draft.points else [0.0, draft.metre, 0.0] for one in (i, j)]
    draft.add(
        "forces",
        {
            "type": "spring_damper",
            "bodies": [i, j],
            "points": ends,
            "stiffness": 20,
            "damping": 0.5,
        },
    )
    wind = [draft.load(draft.metre), 0.0, f"{draft.metre:g}*sin(5*t)"]
    draft.add("forces", {"type": "force", "body": j, "force": wind})
    others = [name for name in bodies if name not in draft.points]
    if len(others) > 1:
        pair = [others[0], others[-1]]
        six = [20.0] * 3 + [2 * draft.metre**2] * 3
        at = list(draft.poses[pair[1]].r)
        draft.add("forces", {"type": "bushing", "bodies": pair, "at": at, "stiffness": six})


def _flying(draft: Draft) -> None:
    """Add a body that nothing holds, which turns about no principal axis."""
    name = draft.body(draft.place())
    draft.tree["bodies"][name].pop("angular_velocity_b", None)
    draft.tree["bodies"][name] |= {"angular_velocity": ["30 deg", 2.0, "pi/4"]}


MORE: tuple[Callable[[Draft], None], ...] = (
    *(_events, _door, _bent, _against, _chain, _between, _flying),
)
"""What a scene may have more."""


def add_more(draft: Draft) -> None:
    """Add up to three of them; nothing for the smallest draws."""
    for _ in range(draft.draw.randrange(4)):
        draft.draw.choice(MORE)(draft)
