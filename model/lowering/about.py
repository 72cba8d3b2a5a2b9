"""Notes on a scene of bodies that its solver tells beside numbers, and where forces jump."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from itertools import chain
from math import dist, hypot
from typing import TYPE_CHECKING

from kousoku.model.elements.event import events_of
from kousoku.model.errors import ExpressionError
from kousoku.model.expressions.design_numbers import with_numbers
from kousoku.model.expressions.folds import with_signs
from kousoku.model.expressions.formulas import LAW_NAMES, RATE, state_names, texts_of
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.lowering.quaternions import quaternion
from kousoku.model.numbers import precise
from kousoku.model.operations.expression import Expression, names_of, ordered
from kousoku.model.operations.graph import Op
from kousoku.model.records.dotted_keys import join
from kousoku.model.records.spatial import GROUND

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from kousoku.model.records.scene import Scene
    from kousoku.model.records.solids import Box
    from kousoku.model.records.spatial import Body, Joint

    Point = tuple[float, float, float]

AWAY = 0.5
"""A point is away from a body when it is further from it than this part of its size."""


@dataclass(frozen=True, slots=True)
class About:
    """Facts about a scene that a user may not expect.

    Parameters
    ----------
    notes : tuple of str
        One line each.
    duration : float [s], optional
        How long it moves unless a run says so.
    jumps : tuple of str
        Keys of forces that jump where a ``sign``, or a quotient that is one, changes in a formula.
    moved : sequence of sequence
        Changes by assembly: body, metres and radians, and those per second.
    """

    notes: tuple[str, ...] = ()
    duration: float | None = None
    jumps: tuple[str, ...] = ()
    moved: Sequence[Sequence[object]] = ()

    @classmethod
    def of(cls, scene: Scene, notes: Sequence[str] = ()) -> About:
        """Facts about a checked scene of bodies, with further notes."""
        jumps = tuple(
            key
            for key, parts in _parts_of_forces(scene)
            if any(part.op is Op.SIGN for part in parts)
        )
        of_events = chain.from_iterable(event.notes() for event in events_of(scene))
        notes = (*scene_notes(scene), *of_events, *notes)
        return cls(notes, scene.duration, jumps)


def scene_notes(scene: Scene) -> Iterator[str]:
    """Notes on points of joints that lie far from their bodies, in a checked scene of bodies.

    A joint is checked between bodies that are made of solids, and at the ground where its body has
    a rod: a ball that hangs on the ground by a rod without mass is no mistake.
    """
    scene = with_numbers(scene)
    for name, joint in scene.joints.items():
        both = [_reach(scene, joint, k) for k in range(2)] if joint.bodies else []
        reaches = [reach for reach in both if reach is not None]
        grounded = GROUND in (joint.bodies or ())
        wanted = 1 if grounded and any(scene.bodies[body].rods for body, *_ in reaches) else 2
        if len(reaches) == wanted and all(far > AWAY * size for _, far, size in reaches):
            body, far, _ = min(reaches, key=lambda reach: reach[1])
            others = f" and {reaches[0][0] if body != reaches[0][0] else reaches[-1][0]}"
            subject = f"{body}{others} are" if len(reaches) > 1 else f"{body} is"
            key = join("joints", name)
            yield f"{key} lies {far:.3g} {scene.unit} from all that {subject} made of"


def _parts_of_forces(scene: Scene) -> Iterator[tuple[str, list[Expression]]]:
    """Key of each force, and all parts of its formulas, quotients such as x/|x| as signs."""
    names = {*state_names(scene), *LAW_NAMES}
    for name, force in scene.forces.items():
        formulas = []
        for text in texts_of(force):
            with suppress(ExpressionError):  # a text that is no formula, such as the type
                formulas.append(with_signs(parse_expression(text, names))[0])
        yield join("forces", name), [part for formula in formulas for part in ordered(formula)]


def notes_of_dry_friction(scene: Scene) -> Iterator[str]:
    """Note on each force that jumps where a rate passes zero, and so may stick there."""
    rates = {LAW_NAMES[1], *(f"{name}{RATE}" for name in scene.coordinates)}
    for key, parts in _parts_of_forces(scene):
        if any(rates.intersection(names_of(jump)) for part in parts for jump in _jumps(part)):
            yield (
                f"{key} jumps where a rate passes 0, as dry friction does: where"
                " it holds the rate at 0, steps become tiny and the run stops; take"
                " x/sqrt(x^2 + 1e-6) for sign(x)"
            )


def _jumps(part: Expression) -> Iterator[Expression]:
    """Argument x of a jump: of sign(x), or of a quotient by |x|."""
    match part:
        case Expression(Op.SIGN, (x,)) | Expression(Op.DIV, (_, Expression(Op.ABS, (x,)))):
            yield x


def _reach(scene: Scene, joint: Joint, k: int) -> tuple[str, float, float] | None:
    """Body of a joint, how far the joint's point is from its solids, and their size."""
    name = joint.ends[k]
    if name == GROUND or (joint.points is None and joint.at is None):
        return None
    body = scene.bodies[name]
    solids = [*_distances(body, _point_of(body, joint, k))]
    points = [*_extreme_points(body)]
    size = max((dist(a, b) for a in points for b in points), default=0.0)
    return (name, min(solids), size) if solids and size else None


def _point_of(body: Body, joint: Joint, k: int) -> Point:
    """Point of a joint in the frame of a body."""
    if joint.points is not None:
        return joint.points[k]
    assert joint.at is not None
    arm = precise.subtract(precise.triple(joint.at), precise.triple(body.position))
    return _floats(precise.rotate_back(quaternion(body.orientation), arm))


def _distances(body: Body, point: Point) -> Iterator[float]:
    """Distances of a point in the frame of a body from each solid of it."""
    for rod in body.rods:
        yield _from_segment(point, *rod.ends)
    for cylinder in body.cylinders:
        yield max(0.0, _from_segment(point, *cylinder.ends) - cylinder.radius)
    for box in body.boxes:
        seen = _in_box(box, point)
        yield hypot(*(max(0.0, abs(x) - edge / 2) for x, edge in zip(seen, box.size, strict=True)))
    for sphere in body.spheres:
        yield max(0.0, dist(point, sphere.at) - sphere.radius)
    for mass in body.mass_points:
        yield dist(point, mass.at)
    if body.mass is not None:
        yield dist(point, body.center or (0.0, 0.0, 0.0))


def _extreme_points(body: Body) -> Iterator[Point]:
    """Points that span the size of a body."""
    for ends in (*(rod.ends for rod in body.rods), *(cylinder.ends for cylinder in body.cylinders)):
        yield from ends
    for box in body.boxes:
        half = hypot(*box.size) / 2
        yield from ((box.at[0] + x, box.at[1], box.at[2]) for x in (-half, half))
    for sphere in body.spheres:
        x, y, z = sphere.at
        yield from ((x + r, y, z) for r in (-sphere.radius, sphere.radius))
    yield from (mass.at for mass in body.mass_points)
    if body.mass is not None:
        yield body.center or (0.0, 0.0, 0.0)


def _from_segment(point: Point, start: Point, end: Point) -> float:
    along = [b - a for a, b in zip(start, end, strict=True)]
    square = sum(x * x for x in along)
    arm = [x - a for x, a in zip(point, start, strict=True)]
    fraction = sum(x * y for x, y in zip(arm, along, strict=True)) / square if square else 0.0
    fraction = min(1.0, max(0.0, fraction))
    return dist(point, [a + fraction * x for a, x in zip(start, along, strict=True)])


def _in_box(box: Box, point: Point) -> Point:
    """Point in the axes of a box, from its middle."""
    arm = precise.subtract(precise.triple(point), precise.triple(box.at))
    return _floats(precise.rotate_back(quaternion(box.orientation), arm))


def _floats(values: precise.Triple) -> Point:
    x, y, z = map(float, values)
    return x, y, z
