"""Mechanisms of random scenes: closed loops, wheels, points, and what is joined rigidly."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.model.elements.joint import ANGLE
from kousoku.model.elements.joints import COUPLINGS, JOINTS, NAMES, free_coordinates_of
from tests.random_geometry import DIRECTIONS, TURNS, Pose, rotation

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from tests.random_draft import Draft
    from tests.random_geometry import Vector

JOINT_NAMES = [name for name, joint in NAMES.items() if joint in JOINTS]
COUPLING_NAMES = [name for name, joint in NAMES.items() if joint in COUPLINGS]
"""All names and aliases."""

LOOPS = (
    ("revolute", "spherical", "universal", "revolute"),
    ("prismatic", "spherical", "universal", "revolute"),
    ("screw", "universal", "spherical", "prismatic"),
    ("revolute", "spherical", "spherical", "hinge"),
    ("cylindrical", "constant_velocity", "spherical", "revolute"),
    ("universal", "planar", "ball", "revolute"),
    ("prismatic", "spherical", "point_on_plane", "universal"),
    ("spherical", "rod", "fixed", "revolute"),
    ("cylindrical", "parallel_axes", "cylindrical", "revolute"),
)
"""Joints of closed loops of three bodies; the first three leave one freedom."""

Driven = tuple[str, ...]
"""Joints whose drivers leave nothing free."""


def _frame(draft: Draft) -> Pose:
    """Frame of a mechanism in a plane: in the plane of x and y, or turned."""
    w, x, y, z = draft.pick("plane", TURNS)
    return Pose(draft.place(), rotation(w, (x, y, z)))


def _polygon(draft: Draft, corners: Sequence[Vector], last: str = "revolute") -> list[str]:
    """Add bodies along a polygon that begins and ends on the ground, and return its joints."""
    frame = _frame(draft)
    points = [frame.place((draft.metre * x, draft.metre * y, 0.0)) for x, y, _ in corners]
    normal, along = frame.place((0, 0, 1)), frame.place((1, 0, 0))
    normal = _minus(normal, frame.r)
    bodies = ["ground", *(draft.body(point) for point in points[:-1]), "ground"]
    joints = [
        draft.join("revolute", bodies[k], bodies[k + 1], point, normal)
        for k, point in enumerate(points[:-1])
    ]
    axis = normal if last == "revolute" else _minus(along, frame.r)
    return [*joints, draft.join(last, bodies[-2], bodies[-1], points[-1], axis)]


def _minus(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _four_bar(draft: Draft) -> Driven:
    return (_polygon(draft, ((0, 0, 0), (0.25, 1, 0), (2, 1.5, 0), (2.25, 0, 0)))[0],)


def _parallelogram(draft: Draft) -> Driven:
    """Add a coupler on three parallel cranks: rows of the third depend on the others."""
    at = draft.place()
    x, y = 0.25 * draft.metre, draft.metre
    coupler = draft.body((at[0] + x, at[1] + y, at[2]))
    joints = []
    for k in range(3):
        foot = (at[0] + k * draft.metre, at[1], at[2])
        crank = draft.body(foot, form="none")
        end = (foot[0] + x, foot[1] + y, foot[2])
        joints.append(draft.join("revolute", "ground", crank, foot))
        draft.join("revolute", crank, coupler, end)
    return (joints[0],)


def _slider_crank(draft: Draft) -> Driven:
    """Add a crank, its rod and a piston; its prismatic joint is the last."""
    return (_polygon(draft, ((0, 0, 0), (0.25, 0.75, 0), (2, 0, 0), (2, 0, 0)), "prismatic")[0],)


def _loop(draft: Draft) -> Driven:
    """Add a closed loop in space."""
    loops = LOOPS[:3] if draft.kind == "driven" else LOOPS
    kinds = draft.pick("loop", loops, every=len(DETERMINED))
    r = ((0.0, 0.0, 0.0), (0.25, 0.5, 1.0), (1.5, 1.0, 1.25), (2.0, -0.5, 0.25))
    points = [(x * draft.metre, y * draft.metre, z * draft.metre) for x, y, z in r]
    bodies = ["ground", *(draft.body(point) for point in points[:-1]), "ground"]
    axes: tuple[Vector, ...] = ((0, 0, 1), (1, 2, 3), (0, 1, -2), (0, 1, 3))
    joints = [
        draft.join(kind, bodies[k], bodies[k + 1], points[k], axes[k])
        for k, kind in enumerate(kinds)
    ]
    return (joints[0],)


def _bricard(draft: Draft) -> Driven:
    """Add Bricard's linkage along edges of a cube: one row of six revolutes depends on others."""
    corners = ((1, 0, 0), (1, 1, 0), (1, 1, 1), (0, 1, 1), (0, 0, 1), (0, 0, 0))
    axes: tuple[Vector, ...] = ((0, 0, 1), (1, 0, 0), (0, 1, 0))
    points = [(x * draft.metre, y * draft.metre, z * draft.metre) for x, y, z in corners]
    bodies = ["ground", *(draft.body(point) for point in points[:-1]), "ground"]
    joints = [
        draft.join("revolute", bodies[k], bodies[k + 1], point, axes[k % 3])
        for k, point in enumerate(points)
    ]
    return (joints[0],)


def _wheels(draft: Draft) -> Driven:
    """Add two wheels and a rack, and what couples them; return what is left to drive."""
    angles = [name for name in JOINT_NAMES if ANGLE in free_coordinates_of(name)]
    one = [
        name for name in angles if len(free_coordinates_of(name)) == 1 and NAMES[name] == "revolute"
    ]
    kinds = one if draft.kind == "driven" else angles
    first, second = (draft.hang(draft.draw.choice(kinds)) for _ in range(2))
    rack = draft.hang("prismatic")
    name = draft.pick("coupling", COUPLING_NAMES, every=1 if draft.kind == "driven" else 2)
    if NAMES[name] == "gear":
        ratio = draft.design(draft.draw.choice((-1.0, 2.0, -0.25)))
        draft.add("joints", {"type": name, "joints": [first, second], "ratio": ratio})
        return first, rack
    if NAMES[name] == "rack_and_pinion":
        radius = draft.design(draft.length(0.25, 1))
        draft.add("joints", {"type": name, "joints": [first, rack], "radius": radius})
        return first, second
    given = ((first, ANGLE), (second, ANGLE), (rack, "displacement"))
    types = [draft.table("joints")[joint]["type"] for joint, _ in given]
    names = [
        draft.add(
            "coordinates",
            {"joint": joint} | ({"of": of} if len(free_coordinates_of(kind)) > 1 else {}),
        )
        for (joint, of), kind in zip(given, types, strict=True)
    ]
    factors = [draft.design(factor) for factor in (1.0, -0.5, 2 / draft.metre)]
    draft.add("joints", {"type": name, "coordinates": names, "factors": factors})
    return first, second


def _points(draft: Draft) -> Driven:
    """Add points on a rod, a spherical joint, a line and a plane, and a body that holds one."""
    holder = draft.hang("spherical")
    body = draft.table("joints")[holder]["bodies"][1]
    for kind, other in (("rod", "ground"), ("rod", body), ("inline", "ground"), ("inplane", body)):
        at = draft.place()
        far = (at[0], at[1], at[2] - draft.metre * (kind == "rod"))
        draft.join(kind, other, draft.body(far, is_point=True), at, draft.draw.choice(DIRECTIONS))
    at = draft.place()
    draft.join("ball", body, draft.body(at, is_point=True), at)
    return ()


def _welded(draft: Draft) -> Driven:
    """Add a pendulum of bodies that are joined rigidly, and one that does not move."""
    first = draft.hang("revolute")
    body = draft.table("joints")[first]["bodies"][1]
    for kind, other in (("fixed", body), ("weld", "ground"), ("rigid", body)):
        at = draft.place()
        draft.join(kind, other, draft.body(at), at, draft.draw.choice(DIRECTIONS))
    return (first,)


def _apart(draft: Draft) -> Driven:
    """Add parts that nothing connects: one on the ground, and two bodies that fly."""
    first = draft.hang("revolute")
    one, other = draft.body(draft.place()), draft.body(draft.place())
    draft.join("hinge", one, other, draft.place(), draft.draw.choice(DIRECTIONS))
    return (first,)


MECHANISMS: dict[str, Callable[[Draft], Driven]] = {
    "four-bar": _four_bar,
    "wheels": _wheels,
    "slider-crank": _slider_crank,
    "loop": _loop,
    "bricard": _bricard,
    "parallelogram": _parallelogram,
    "welded": _welded,
    "points": _points,
    "apart": _apart,
}
"""Parts of a scene; each tells the joints whose drivers leave nothing free."""

DETERMINED = ("four-bar", "wheels", "slider-crank", "loop", "bricard", "parallelogram")
"""Those that may be driven completely."""
