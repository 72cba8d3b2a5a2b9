"""Bodies that hang on the ground by one joint: v = R u + β with the velocities u that it leaves.

A revolute, spherical, prismatic or cylindrical joint with the ground leaves one to three velocities
u of the six of its body. R is known in closed form, and the mass Rᵀ M R that moves with u is
constant, so that the rows of the joint need no multipliers. What a driver of the joint prescribes
is part of β(t), and none of u. All that is recorded by
:mod:`kousoku.codegen.dynamics.composition.record_joint_coordinates`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import groupby
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.assembly.pose import Pose, normalised
from kousoku.codegen.dynamics.assembly.residuals import inputs_at
from kousoku.codegen.dynamics.elements.constraints import (
    RelativeMotion,
    facets_of_kind,
    held_by,
)
from kousoku.codegen.dynamics.operations.joint_projections import AXIS, NOTHING, POINT
from kousoku.codegen.dynamics.operations.mechanics import frozen
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.numbers import precise
from kousoku.model.numbers.digits import CONTEXT, HIGH
from kousoku.model.numbers.varying import is_varying
from kousoku.model.operations.interpret import evaluate

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.recording.program import ConstraintEquation
    from kousoku.model.mechanics.multibody import RelativeCoordinate, System
    from kousoku.model.numbers.precise import High, Quadruple, Triple

    Numbers = tuple[float, ...]

SLIDE, SHIFT, SPIN, TILT = RelativeMotion
#: What a joint leaves free, how it turns and whether it slides, by what its kinds do not allow.
FREEDOMS = {
    frozenset({SLIDE, SHIFT, TILT}): (AXIS, False),
    frozenset({SLIDE, SHIFT}): (POINT, False),
    frozenset({SHIFT, TILT, SPIN}): (NOTHING, True),
    frozenset({SHIFT, TILT}): (AXIS, True),
}
#: Of so many rows one must go at least, or a second program takes longer than it will ever save.
WORTH = 8
#: Sines of angles between vectors that count as parallel are smaller: axes are rounded to doubles.
AXIS_TOLERANCE = 1e-12
PLANE_NORMAL: Triple = (CONTEXT.mpf(0), CONTEXT.mpf(0), CONTEXT.mpf(1))


@dataclass(frozen=True, slots=True)
class Prescribed:
    """A driver of the coordinate that a joint leaves free.

    Parameters
    ----------
    instance : int
        Its place in the system.
    sign : int
        1 where the coordinate grows with the turn or the displacement of the body, else −1.
    start : float [rad or m]
        The coordinate where the body stands at the start: turn and displacement are zero there.
    """

    instance: int
    sign: int
    start: float


@dataclass(frozen=True, slots=True)
class VelocityTransformation:
    """A body on a joint with the ground, v = R u + β: all vectors are rounded once.

    R (6, f) has (A (s′ × a′), a′) of a turn and (a, 0) of a displacement.

    Parameters
    ----------
    body : int
        Its index.
    instances : tuple of int
        Places of the joint and of its drivers in the system: these rows hold by themselves.
    rotates_about : str
        What it can rotate about: nothing, an axis, a point.
    slides : bool
        Whether it can be displaced along an axis.
    joint, joint_b : (3,) [m]
        A point of the joint in frame O, and in the body.
    p : (4,)
        Euler parameters at the start.
    base : (3,) [m]
        Where the centre of mass is there without displacement, frame O.
    axis, axis_b : (3,) [-]
        The axis in frame O, and in the body.
    across, across_b : (3,) and (3,)
        Two vectors perpendicular to each of them.
    beside : (4,) and (4,)
        Euler parameters that no turn about the axis has a part of, beside those of ``p``.
    prescribed_rotation, prescribed_slide : Prescribed, optional
        What drives the turn and the displacement.
    """

    body: int
    instances: tuple[int, ...]
    rotates_about: str
    slides: bool
    joint: Numbers
    joint_b: Numbers
    p: Numbers
    base: Numbers
    axis: Numbers
    axis_b: Numbers
    across: tuple[Numbers, Numbers]
    across_b: tuple[Numbers, Numbers]
    beside: tuple[Numbers, Numbers]
    prescribed_rotation: Prescribed | None = None
    prescribed_slide: Prescribed | None = None

    @property
    def rotations(self) -> int:
        """Count of angular velocities that the joint leaves, those too that are driven."""
        return {NOTHING: 0, AXIS: 1, POINT: 3}[self.rotates_about]

    @property
    def free(self) -> tuple[int, ...]:
        """Freedoms of it, rotations first, that are not driven."""
        free = () if self.prescribed_rotation else tuple(range(self.rotations))
        return (*free, self.rotations) if self.slides and not self.prescribed_slide else free

    @property
    def prescribed(self) -> tuple[tuple[int, Prescribed], ...]:
        """Freedoms of it that are driven, and by which driver."""
        found = ((0, self.prescribed_rotation), (self.rotations, self.prescribed_slide))
        return tuple((k, one) for k, one in found if one)

    @property
    def is_placed(self) -> bool:
        """Whether its centre of mass follows from all else, so that nothing is added to it."""
        return not self.slides or self.prescribed_slide is not None


def velocity_transformations_of(
    system: System, rows: Mapping[int, Sequence[int]], *, is_planar: bool
) -> dict[int, VelocityTransformation]:
    """Bodies that the coordinates of their joint with the ground can describe: v = R u + β.

    v (6,) [m/s, rad/s] of a body has ṙ in frame O, ω′ in the principal frame.

    Parameters
    ----------
    system : System
        The scene, as it starts: there all joints hold.
    rows : mapping of int to sequence of int
        Rows of constraints that are not structurally zero, by the places of these.
    is_planar : bool
        Whether bodies move in planes parallel to the xy-plane.

    Returns
    -------
    mapping of int to VelocityTransformation
        By the body, in the order of the system.
    """
    grounded: dict[int, list[int]] = {}
    for place, one in enumerate(system.constraints):
        if GROUND_INDEX in one.bodies and len(one.bodies) == 2:
            grounded.setdefault(max(one.i, one.j), []).append(place)
    found = {}
    for body in sorted(grounded):
        if _is_fixed(system, body, grounded[body]):
            new = _reduction(system, body, grounded[body], is_planar=is_planar)
            if new and _leaves(new, rows) == (3 if is_planar else 6):
                found[body] = new
    return found


def is_worth(system: System, rows: Sequence[ConstraintEquation]) -> bool:
    """Whether drivers act on bodies at the ground, or joints there have many of the rows.

    Parameters
    ----------
    system : System
        The scene.
    rows : sequence of ConstraintEquation
        All that are solved.
    """
    grounded = [len(one.bodies) == 2 and GROUND_INDEX in one.bodies for one in system.constraints]
    if any(one.is_driver for one, at in zip(system.constraints, grounded, strict=True) if at):
        return True
    count = sum(grounded[row.instance] for row in rows)
    return 0 < len(rows) <= WORTH * count


def _is_fixed(system: System, body: int, places: Sequence[int]) -> bool:
    """Whether a body can turn, and no number of it or its joint depends on parameters."""
    moving, joints = system.bodies[body], [system.constraints[place] for place in places]
    led = [system.coordinates[term.coordinate] for one in joints for term in one.terms]
    numbers = (moving.mass, moving.inertia, moving.r, moving.p)
    constants = (*(one.constants for one in joints), *(one.constants for one in led))
    nears = tuple(one.near for one in led)
    return not moving.is_point and not is_varying((*numbers, *constants, *nears))


def _leaves(one: VelocityTransformation, rows: Mapping[int, Sequence[int]]) -> int:
    """Number of velocities: those left free, and rows of the joint and drivers."""
    return len(one.free) + sum(len(rows.get(place, ())) for place in one.instances)


def _reduction(
    system: System, body: int, places: Sequence[int], *, is_planar: bool
) -> VelocityTransformation | None:
    joints = [k for k in places if not system.constraints[k].is_combination]
    groups = [list(own) for _, own in groupby(joints, lambda k: system.constraints[k].joint)]
    if len(groups) != 1 or any(
        one.is_combination and one.joint == system.constraints[joints[0]].joint
        for one in system.constraints
    ):
        return None
    held = [held_by(system.constraints[k].kind) for k in joints]
    by_motion = {motion: k for k, own in zip(joints, held, strict=True) for motion in own}
    freedoms = FREEDOMS.get(frozenset(by_motion))
    if freedoms is None or not all(held) or len(by_motion) < sum(map(len, held)):
        return None
    found = _placed(system, body, by_motion, *freedoms, is_planar=is_planar)
    drivers = [k for k in places if system.constraints[k].is_driver]
    return _with_drivers(system, found, drivers)


def _placed(
    system: System,
    body: int,
    by_motion: Mapping[RelativeMotion, int],
    rotates_about: str,
    slides: bool,
    *,
    is_planar: bool,
) -> VelocityTransformation:
    """Velocity transformation of a body on a joint that nothing drives.

    The joint is given by the places of its constraints, by the motions that they do not allow.
    """
    of = {motion: dict(system.constraints[k].constants) for motion, k in by_motion.items()}
    instances = tuple(sorted(set(by_motion.values())))
    first = system.constraints[instances[0]]
    own, ground = ("j", "i") if first.i == GROUND_INDEX else ("i", "j")
    moving = system.bodies[body]
    p = normalised(moving.p)
    axis, axis_b = _axes(of.get(TILT, {}), ground, own, p)
    if is_planar:
        is_normal = not any(axis[:2])
        rotates_about = AXIS if is_normal and rotates_about != NOTHING else NOTHING
        slides = slides and not is_normal
    joint, joint_b = (precise.triple(of[SHIFT][f"s_{side}_b"]) for side in (ground, own))
    if slides:  # the displacement is counted from where the body stands
        end = precise.add(precise.triple(moving.r), precise.rotate(p, joint_b))
        shift = precise.dot(axis, precise.subtract(end, joint))
        joint = precise.add(joint, precise.scale(shift, axis))
    across_b = _across(axis_b)
    zero = CONTEXT.mpf(0)
    return VelocityTransformation(
        body=body,
        instances=instances,
        rotates_about=rotates_about,
        slides=slides,
        joint=precise.rounded(joint),
        joint_b=precise.rounded(joint_b),
        p=precise.rounded(p),
        base=precise.rounded(precise.subtract(joint, precise.rotate(p, joint_b))),
        axis=precise.rounded(axis),
        axis_b=precise.rounded(axis_b),
        across=_pair(_across(axis)),
        across_b=_pair(across_b),
        beside=_pair([precise.compose(p, (zero, *one)) for one in across_b]),
    )


def _axes(
    parallel: Mapping[str, tuple[float, ...]], ground: str, own: str, p: Quadruple
) -> tuple[Triple, Triple]:
    """Axis of a joint in frame O and in the body, both in one direction."""
    if not parallel:
        return PLANE_NORMAL, PLANE_NORMAL
    axis = precise.unit(precise.triple(parallel[f"a_{ground}_b"]))
    axis_b = precise.unit(precise.triple(parallel[f"a_{own}_b"]))
    is_turned = precise.dot(axis, precise.rotate(p, axis_b)) < 0
    return axis, precise.scale(CONTEXT.mpf(-1 if is_turned else 1), axis_b)


def _across(axis: Triple) -> list[Triple]:
    """Vectors perpendicular to an axis and to each other, two of them."""
    first = precise.across(axis)
    return [first, precise.cross(axis, first)]


def _pair(values: Sequence[Sequence[High]]) -> tuple[Numbers, Numbers]:
    first, second = map(precise.rounded, values)
    return first, second


def _with_drivers(
    system: System, found: VelocityTransformation, drivers: Sequence[int]
) -> VelocityTransformation:
    """Body with the drivers of the coordinates of its joint; other drivers stay rows."""
    for place in drivers:
        one = system.constraints[place]
        if len(one.terms) != 1 or one.terms[0].factor != 1.0 or one.offset:
            continue
        coordinate = system.coordinates[one.terms[0].coordinate]
        sign = _along(found, coordinate)
        if not sign:
            continue
        led = Prescribed(place, sign, _at_start(system, coordinate))
        instances = (*found.instances, place)
        measured = facets_of_kind(coordinate.kind).measures
        if measured == SPIN and found.rotates_about == AXIS and not found.prescribed_rotation:
            found = replace(found, prescribed_rotation=led, instances=instances)
        elif measured == SLIDE and found.slides and not found.prescribed_slide:
            found = replace(found, prescribed_slide=led, instances=instances)
    return found


def _along(found: VelocityTransformation, coordinate: RelativeCoordinate) -> int:
    """Sign 1 or −1 of a coordinate that grows or falls with that of the joint, else 0."""
    direction = facets_of_kind(coordinate.kind).direction(dict(coordinate.constants))
    if direction is None:
        return 0
    is_own = coordinate.i == found.body
    axis = precise.triple(found.axis_b if is_own else found.axis)
    cosine = precise.dot(direction, axis)
    if (
        precise.length(precise.cross(direction, axis)) > AXIS_TOLERANCE
        or abs(abs(cosine) - 1) > AXIS_TOLERANCE
    ):
        return 0
    return (-1 if is_own else 1) * (1 if cosine > 0 else -1)


def _at_start(system: System, coordinate: RelativeCoordinate) -> float:
    """Value of a coordinate at the start, its turns counted."""
    inputs = inputs_at(coordinate, Pose.of(system.bodies))
    value = evaluate(frozen(coordinate.kind, "constraint"), inputs, HIGH)["C"][0]
    if coordinate.counts_turns:
        whole = 2 * CONTEXT.pi
        value += whole * CONTEXT.nint((precise.number(coordinate.near) - value) / whole)
    return float(value)
