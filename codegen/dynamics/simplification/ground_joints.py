"""Bodies on one joint with the ground: v = R u + β with the free velocities u of the joint.

A revolute, spherical, prismatic or cylindrical joint with the ground leaves one to three velocities
u of the six of its body. R is known in closed form, and the mass Rᵀ M R that moves with u is
constant, so that the rows of the joint need no multipliers. A velocity that a driver of the joint
prescribes is part of β(t), not of u. All that is recorded by
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

    from kousoku.codegen.dynamics.recording.program import RowIndex
    from kousoku.model.mechanics.multibody import RelativeCoordinate, System
    from kousoku.model.numbers.precise import High, Quadruple, Triple

    Numbers = tuple[float, ...]

SLIDE, SHIFT, SPIN, TILT = RelativeMotion
#: Freedoms of a joint, its rotation and whether it slides, by the motions that its kinds hold.
FREEDOMS = {
    frozenset({SLIDE, SHIFT, TILT}): (AXIS, False),
    frozenset({SLIDE, SHIFT}): (POINT, False),
    frozenset({SHIFT, TILT, SPIN}): (NOTHING, True),
    frozenset({SHIFT, TILT}): (AXIS, True),
}
#: One of so many rows must be eliminated at least, or a second program costs more than it saves.
WORTH = 8
#: Sine of the angle below which vectors count as parallel: axes are rounded to doubles.
AXIS_TOLERANCE = 1e-12
PLANE_NORMAL: Triple = (CONTEXT.mpf(0), CONTEXT.mpf(0), CONTEXT.mpf(1))


@dataclass(frozen=True, slots=True)
class Prescribed:
    """A driver of the coordinate that a joint leaves free.

    Parameters
    ----------
    instance : int
        Index of its constraint in the system.
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
        Index of the body.
    instances : tuple of int
        Indices of the constraints of the joint and its drivers, whose rows hold identically.
    rotates_about : str
        What it can rotate about: nothing, an axis, a point.
    slides : bool
        Whether it can be displaced along an axis.
    joint, joint_b : (3,) [m]
        A point of the joint in frame O, and in the body.
    p : (4,)
        Euler parameters at the start.
    base : (3,) [m]
        Centre of mass at the start without displacement, frame O.
    axis, axis_b : (3,) [-]
        The axis in frame O, and in the body.
    across, across_b : (3,) and (3,)
        Two vectors perpendicular to each of them.
    beside : (4,) and (4,)
        Euler parameters orthogonal to ``p`` and to all turns of it about the axis.
    prescribed_rotation, prescribed_slide : Prescribed, optional
        Drivers of the turn and of the displacement.
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
        """Count of angular velocities that the joint leaves, driven ones included."""
        return {NOTHING: 0, AXIS: 1, POINT: 3}[self.rotates_about]

    @property
    def free(self) -> tuple[int, ...]:
        """Indices of the freedoms, rotations first, that are not driven."""
        free = () if self.prescribed_rotation else tuple(range(self.rotations))
        return (*free, self.rotations) if self.slides and not self.prescribed_slide else free

    @property
    def prescribed(self) -> tuple[tuple[int, Prescribed], ...]:
        """Indices of the driven freedoms, with their drivers."""
        drivers = ((0, self.prescribed_rotation), (self.rotations, self.prescribed_slide))
        return tuple((k, driver) for k, driver in drivers if driver)

    @property
    def is_placed(self) -> bool:
        """Whether rotation and drivers determine the centre of mass: no displacement is free."""
        return not self.slides or self.prescribed_slide is not None


def velocity_transformations_of(
    system: System, rows: Mapping[int, Sequence[int]], *, is_planar: bool
) -> dict[int, VelocityTransformation]:
    """Transformations v = R u + β of bodies that coordinates of their joint with the ground move.

    v (6,) [m/s, rad/s] of a body has ṙ in frame O, ω′ in the principal frame.

    Parameters
    ----------
    system : System
        The scene, as it starts: there all joints hold.
    rows : mapping of int to sequence of int
        Rows that are not structurally zero, by the indices of their constraints.
    is_planar : bool
        Whether bodies move in planes parallel to the xy-plane.

    Returns
    -------
    mapping of int to VelocityTransformation
        By the body, in the order of the system.
    """
    grounded: dict[int, list[int]] = {}
    for index, instance in enumerate(system.constraints):
        if GROUND_INDEX in instance.bodies and len(instance.bodies) == 2:
            grounded.setdefault(max(instance.i, instance.j), []).append(index)
    transformations = {}
    for body in sorted(grounded):
        if _is_fixed(system, body, grounded[body]):
            transformation = _reduction(system, body, grounded[body], is_planar=is_planar)
            if transformation and _velocity_count(transformation, rows) == (3 if is_planar else 6):
                transformations[body] = transformation
    return transformations


def is_worth(system: System, rows: Sequence[RowIndex]) -> bool:
    """Whether drivers act on bodies at the ground, or joints there have many of the rows.

    Parameters
    ----------
    system : System
        The scene.
    rows : sequence of RowIndex
        All rows that are solved.
    """
    grounded = [len(c.bodies) == 2 and GROUND_INDEX in c.bodies for c in system.constraints]
    if any(c.is_driver for c, at in zip(system.constraints, grounded, strict=True) if at):
        return True
    count = sum(grounded[row.instance] for row in rows)
    return 0 < len(rows) <= WORTH * count


def _is_fixed(system: System, body: int, indices: Sequence[int]) -> bool:
    """Whether a body can turn, and no number of it or its joint depends on parameters."""
    moving, instances = system.bodies[body], [system.constraints[k] for k in indices]
    coordinates = [system.coordinates[term.coordinate] for x in instances for term in x.terms]
    numbers = (moving.mass, moving.inertia, moving.r, moving.p)
    constants = (*(x.constants for x in instances), *(x.constants for x in coordinates))
    nears = tuple(c.near for c in coordinates)
    return not moving.is_point and not is_varying((*numbers, *constants, *nears))


def _velocity_count(joint: VelocityTransformation, rows: Mapping[int, Sequence[int]]) -> int:
    """Count of free velocities and of rows of the joint and its drivers."""
    return len(joint.free) + sum(len(rows.get(k, ())) for k in joint.instances)


def _reduction(
    system: System, body: int, indices: Sequence[int], *, is_planar: bool
) -> VelocityTransformation | None:
    joints = [k for k in indices if not system.constraints[k].is_combination]
    groups = [list(group) for _, group in groupby(joints, lambda k: system.constraints[k].joint)]
    if len(groups) != 1 or any(
        instance.is_combination and instance.joint == system.constraints[joints[0]].joint
        for instance in system.constraints
    ):
        return None
    held = [held_by(system.constraints[k].kind) for k in joints]
    by_motion = {motion: k for k, motions in zip(joints, held, strict=True) for motion in motions}
    freedoms = FREEDOMS.get(frozenset(by_motion))
    if freedoms is None or not all(held) or len(by_motion) < sum(map(len, held)):
        return None
    undriven = _undriven(system, body, by_motion, *freedoms, is_planar=is_planar)
    drivers = [k for k in indices if system.constraints[k].is_driver]
    return _with_drivers(system, undriven, drivers)


def _undriven(
    system: System,
    body: int,
    by_motion: Mapping[RelativeMotion, int],
    rotates_about: str,
    slides: bool,
    *,
    is_planar: bool,
) -> VelocityTransformation:
    """Velocity transformation of a body on a joint that nothing drives.

    Its constraints are given by their indices, for each motion that they hold.
    """
    constants = {motion: dict(system.constraints[k].constants) for motion, k in by_motion.items()}
    instances = tuple(sorted(set(by_motion.values())))
    first = system.constraints[instances[0]]
    moving_end, ground_end = ("j", "i") if first.i == GROUND_INDEX else ("i", "j")
    moving_body = system.bodies[body]
    p = normalised(moving_body.p)
    axis, axis_b = _axes(constants.get(TILT, {}), ground_end, moving_end, p)
    if is_planar:
        is_normal = not any(axis[:2])
        rotates_about = AXIS if is_normal and rotates_about != NOTHING else NOTHING
        slides = slides and not is_normal
    joint, joint_b = (
        precise.triple(constants[SHIFT][f"s_{end}_b"]) for end in (ground_end, moving_end)
    )
    if slides:  # the displacement is counted from where the body stands
        point = precise.add(precise.triple(moving_body.r), precise.rotate(p, joint_b))
        shift = precise.dot(axis, precise.subtract(point, joint))
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
        beside=_pair([precise.compose(p, (zero, *e)) for e in across_b]),
    )


def _axes(
    constants: Mapping[str, tuple[float, ...]], ground_end: str, moving_end: str, p: Quadruple
) -> tuple[Triple, Triple]:
    """Axis of a joint in frame O and in the body, both in one direction."""
    if not constants:
        return PLANE_NORMAL, PLANE_NORMAL
    axis = precise.unit(precise.triple(constants[f"a_{ground_end}_b"]))
    axis_b = precise.unit(precise.triple(constants[f"a_{moving_end}_b"]))
    is_turned = precise.dot(axis, precise.rotate(p, axis_b)) < 0
    return axis, precise.scale(CONTEXT.mpf(-1 if is_turned else 1), axis_b)


def _across(axis: Triple) -> list[Triple]:
    """Two vectors perpendicular to an axis and to each other."""
    first = precise.across(axis)
    return [first, precise.cross(axis, first)]


def _pair(values: Sequence[Sequence[High]]) -> tuple[Numbers, Numbers]:
    first, second = map(precise.rounded, values)
    return first, second


def _with_drivers(
    system: System, joint: VelocityTransformation, drivers: Sequence[int]
) -> VelocityTransformation:
    """Transformation with drivers of the coordinates of its joint; other drivers stay rows."""
    for index in drivers:
        driver = system.constraints[index]
        if len(driver.terms) != 1 or driver.terms[0].factor != 1.0 or driver.offset:
            continue
        coordinate = system.coordinates[driver.terms[0].coordinate]
        sign = _sign_of(joint, coordinate)
        if not sign:
            continue
        prescribed = Prescribed(index, sign, _at_start(system, coordinate))
        instances = (*joint.instances, index)
        measured = facets_of_kind(coordinate.kind).measures
        if measured == SPIN and joint.rotates_about == AXIS and not joint.prescribed_rotation:
            joint = replace(joint, prescribed_rotation=prescribed, instances=instances)
        elif measured == SLIDE and joint.slides and not joint.prescribed_slide:
            joint = replace(joint, prescribed_slide=prescribed, instances=instances)
    return joint


def _sign_of(joint: VelocityTransformation, coordinate: RelativeCoordinate) -> int:
    """Sign 1 or −1 of a coordinate along or against that of the joint, else 0."""
    direction = facets_of_kind(coordinate.kind).direction(dict(coordinate.constants))
    if direction is None:
        return 0
    is_first = coordinate.i == joint.body
    axis = precise.triple(joint.axis_b if is_first else joint.axis)
    cosine = precise.dot(direction, axis)
    if (
        precise.length(precise.cross(direction, axis)) > AXIS_TOLERANCE
        or abs(abs(cosine) - 1) > AXIS_TOLERANCE
    ):
        return 0
    return (-1 if is_first else 1) * (1 if cosine > 0 else -1)


def _at_start(system: System, coordinate: RelativeCoordinate) -> float:
    """Value of a coordinate at the start, its turns counted."""
    inputs = inputs_at(coordinate, Pose.of(system.bodies))
    value = evaluate(frozen(coordinate.kind, "constraint"), inputs, HIGH)["C"][0]
    if coordinate.counts_turns:
        turn = 2 * CONTEXT.pi
        value += turn * CONTEXT.nint((precise.number(coordinate.near) - value) / turn)
    return float(value)
