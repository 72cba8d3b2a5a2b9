"""Check the bodies, joints, events and gravity of a spatial scene one by one."""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING

from kousoku.model.elements.checks import check_only_point, require_two
from kousoku.model.elements.event import events_of
from kousoku.model.elements.joints import COUPLINGS, JOINTS, NAMES
from kousoku.model.errors import Problem, SceneError
from kousoku.model.expressions.design_numbers import FORMULAS
from kousoku.model.expressions.formulas import (
    fixed_names,
    formula_problems,
    state_names,
    values_at_start,
)
from kousoku.model.records.design import LARGEST
from kousoku.model.records.dotted_keys import join, require_known, unknown
from kousoku.model.records.orientation import check_orientation
from kousoku.model.records.planar import Method
from kousoku.model.records.spatial import GROUND
from kousoku.model.text import with_a
from kousoku.model.validation.coordinates import check_coordinates
from kousoku.model.validation.couplings import check_coupling
from kousoku.model.validation.forces import check_force
from kousoku.model.validation.mass import check_mass

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.elements.joint import JointKind
    from kousoku.model.records.own_kind import OwnKind
    from kousoku.model.records.problems import Problems
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Body, Joint

PARALLEL = 1e-9
"""Sine of the smallest angle between two directions that are not parallel."""

OF_ONES_OWN = "kind of your own comes with kinds=[...], see docs/own_kind.md"
"""Hint of a message about an unknown type of joints, behind the nearest type."""

TURNING = ("orientation", "angular_velocity")
"""Values of ``hold`` that a point does not have."""

ROTATION_KEYS = ("orientation", "angular_velocity", "angular_velocity_b")
"""Keys of a body that a point does not have."""


def check_spatial(scene: Scene, problems: Problems) -> None:
    """Check bodies, joints and forces; whether the mechanism can move is left to its solver.

    Parameters
    ----------
    scene : Scene
        What could be built of it.
    problems : Problems
        What is broken in it, and where to note what else is wrong.
    """
    for table in ("nodes", "links", "rigid", "sliders"):
        if getattr(scene, table):
            problem = (
                "belongs to a planar linkage; wanted either nodes and links, or bodies and joints"
            )
            problems.add(problem, table, breaks=table)
    if scene.method != Method():
        problem = (
            "belongs to a planar linkage; of bodies a run says it, as kousoku simulate --method"
        )
        problems.add(problem, "method")
    if not scene.bodies and not problems.touches("bodies"):
        problems.add("is missing; joints need bodies to connect", "bodies", breaks="bodies")
    if GROUND in scene.bodies:
        key = f"bodies.{GROUND}"
        problem = f"{GROUND!r} is the fixed body that every scene has; choose another name"
        problems.add(problem, key, breaks=key)
    for name, body in scene.bodies.items():
        key = join("bodies", name)
        _check_body(body, key, problems)
    couplings = {}
    for name, joint in scene.joints.items():
        key = join("joints", name)
        if NAMES.get(joint.type) in COUPLINGS:
            couplings[key] = joint
            continue
        _check_joint(scene, joint, key, problems)
    check_coordinates(scene, problems)
    for key, joint in couplings.items():
        uses = [join("joints", other) for other in joint.joints or ()]
        uses += [join("coordinates", name) for name in joint.coordinates or ()]
        problems.check(key, [key, *uses], check_coupling, scene, joint, key)
    names = state_names(scene)
    for name, force in scene.forces.items():
        check_force(scene, force, join("forces", name), names, problems)
    if not problems.touches("parameters", "coordinates"):
        for event in events_of(scene):
            problems.check(f"{event.key}.when", (), event.check)
    problems.check("gravity", ["gravity"], _check_gravity, scene)


def _check_body(body: Body, key: str, problems: Problems) -> None:
    """Check motion, orientation and mass of a body, each whatever is wrong with the others."""
    problems.check(key, (), _check_turning, body, key)
    if body.orientation is not None:
        problems.check(key, (), check_orientation, body.orientation, f"{key}.orientation")
    problems.check(key, [join(key, FORMULAS)], check_mass, body, key)


def _check_turning(body: Body, key: str) -> None:
    if body.point:
        for name in ROTATION_KEYS:
            if getattr(body, name) is not None:
                raise SceneError("a point does not turn; leave it out", key=f"{key}.{name}")
        for index, held in enumerate(body.hold):
            if held in TURNING:
                raise SceneError("a point does not turn; leave it out", key=f"{key}.hold[{index}]")
    elif body.angular_velocity is not None and body.angular_velocity_b is not None:
        raise SceneError(
            "is given in frame O too, as angular_velocity; wanted one of them",
            key=f"{key}.angular_velocity_b",
        )


def _check_joint(scene: Scene, joint: Joint, key: str, problems: Problems) -> None:
    """Check bodies, axes, numbers and points of a joint, each whatever is wrong with the others."""
    own_kind = scene.kinds.get(joint.type)
    kind = None if own_kind else problems.check(key, (), _kind_of, scene, joint, key)
    ends = [join("bodies", body) for body in joint.bodies or () if body != GROUND]
    problems.check(key, (), _check_two_bodies, joint, key)
    for index, body in enumerate(joint.bodies or ()):  # each whatever is wrong with the other body
        body_key = f"{key}.bodies[{index}]"
        uses = [join("bodies", body)] if body != GROUND else []
        problems.check(key, uses, require_known, "body", body, scene.bodies, body_key, GROUND)
    if own_kind is not None:
        problems.check(key, (), _check_inputs, joint, own_kind, key)
        problems.check(key, [key, *ends], _check_own_points, scene, joint, own_kind, key)
    if kind is None:
        return
    problems.check(key, (), _check_axes, joint, kind, key)
    problems.check(key, (), _check_numbers, joint, kind, key)
    problems.check(key, (), kind.check_numbers, joint, key)
    problems.check(key, (), _check_length, joint, kind, key)
    problems.check(key, (), _check_point, joint, kind, key)
    problems.check(key, [key, *ends], _check_point_bodies, scene, joint, kind, key)


def _check_two_bodies(joint: Joint, key: str) -> None:
    if joint.bodies is None:
        raise SceneError("is missing; wanted a list of 2 names", key=f"{key}.bodies")
    require_two(joint.bodies, key)


def _check_point_bodies(scene: Scene, joint: Joint, kind: JointKind, key: str) -> None:
    """Check that a point body is met where it is, by a joint that keeps no orientation of it."""
    for index, (name, point) in enumerate(zip(joint.ends, joint.points or (), strict=False)):
        if name != GROUND:
            check_only_point(scene, name, point, f"{key}.points[{index}]")
    for index, name in enumerate(joint.ends):
        if name != GROUND and scene.bodies[name].point and kind.needs_orientation(index):
            raise _keeps_orientation(joint, index, key)


def _keeps_orientation(joint: Joint, index: int, key: str) -> SceneError:
    """Error of a joint that keeps an orientation of a point."""
    return SceneError(
        f"{joint.ends[index]} is a point, which has no orientation that {with_a(joint.type)} joint "
        "could keep; wanted a body that is no point",
        key=f"{key}.bodies[{index}]",
    )


def _kind_of(scene: Scene, joint: Joint, key: str) -> JointKind:
    if joint.type not in NAMES:
        known = (*NAMES, *scene.kinds)
        problem = unknown(f"joint {joint.type[:40]!r}", joint.type, known)
        hint = f" A {OF_ONES_OWN}" if problem.endswith("?") else f"; a {OF_ONES_OWN}"
        raise SceneError(f"{problem}{hint}", key=f"{key}.type")
    return JOINTS[NAMES[joint.type]]


def _check_inputs(joint: Joint, kind: OwnKind, key: str) -> None:
    """Check that a joint of one's own kind has the inputs of the kind, and no other keys."""
    values = joint.inputs or {}
    for name in joint.__struct_fields__:
        if name not in ("type", "bodies", joint.FLAT) and getattr(joint, name) is not None:
            wanted = ", ".join(("bodies", *kind.inputs))
            raise SceneError(
                f"{with_a(joint.type)} joint has none; it has {wanted}", key=f"{key}.{name}"
            )
    for name, own_input in kind.inputs.items():
        if name not in values:
            sort = "a list of 3 numbers" if own_input.vector else "a number"
            raise SceneError(
                f"is missing; {with_a(joint.type)} joint wants {sort}: {own_input.meaning}",
                key=f"{key}.{name}",
            )
    directions = [name for name, own_input in kind.inputs.items() if own_input.is_direction]
    _check_lengths({f"{key}.{name}": joint.vector(name) for name in directions})


def _check_own_points(scene: Scene, joint: Joint, kind: OwnKind, key: str) -> None:
    """Check that a point body is met where it is, by a kind that keeps no orientation of it."""
    for index, (end, name, turns) in enumerate(zip("ij", joint.ends, kind.turns, strict=True)):
        if name == GROUND or not scene.bodies[name].point:
            continue
        if turns:
            raise _keeps_orientation(joint, index, key)
        for input_name, own_input in kind.inputs.items():
            if own_input.body == end:
                check_only_point(scene, name, joint.vector(input_name), f"{key}.{input_name}")


def _check_point(joint: Joint, kind: JointKind, key: str) -> None:
    """Check that a joint that has a point is given it once, in frame O or in both bodies."""
    if not kind.has_point:
        for name in ("points", "at"):
            if getattr(joint, name) is not None:
                raise SceneError(
                    f"{with_a(joint.type)} joint has no point; leave it out", key=f"{key}.{name}"
                )
        return
    if joint.at is not None and (joint.points is not None or "at" not in kind.point_keys):
        problem = (
            "its two points are apart; wanted points, one in each body"
            if joint.points is None
            else "has points too; wanted one of them"
        )
        raise SceneError(problem, key=f"{key}.at")
    if joint.points is None and joint.at is None:
        raise SceneError(
            f"is missing; {with_a(joint.type)} joint wants its point in each body, or once in"
            " frame O as 'at'",
            key=f"{key}.points",
        )


def _check_axes(joint: Joint, kind: JointKind, key: str) -> None:
    """Check the axes, and then the directions across them."""
    names = [name for name in ("axes", "axis", "second_axis") if getattr(joint, name) is not None]
    if not kind.axes and not (kind.has_zero and joint.zero is not None):
        for name in names:
            raise SceneError(
                f"{with_a(joint.type)} joint has no axis; leave it out", key=f"{key}.{name}"
            )
        _check_zero(joint, kind, key)
        return
    if not names:
        raise SceneError(
            f"is missing; {with_a(joint.type)} joint wants an axis in each body, or in frame O as"
            " 'axis'",
            key=f"{key}.axes",
        )
    if joint.axes is not None and len(names) > 1:
        raise SceneError("has axes too; wanted one of them", key=f"{key}.{names[1]}")
    if joint.axes is None and joint.axis is None:
        raise SceneError("is missing; wanted the axis of body i", key=f"{key}.axis")
    if kind.axes == 2 and joint.axes is None and joint.second_axis is None:
        raise SceneError("is missing; wanted the axis of body j", key=f"{key}.second_axis")
    if kind.axes == 1 and joint.second_axis is not None:
        raise SceneError(
            f"{with_a(joint.type)} joint has one axis; leave it out", key=f"{key}.second_axis"
        )
    axes = {f"{key}.axes[{index}]": axis for index, axis in enumerate(joint.axes or ())}
    axes |= {f"{key}.{name}": getattr(joint, name) for name in names if name != "axes"}
    _check_lengths(axes)
    _check_zero(joint, kind, key)


def _check_zero(joint: Joint, kind: JointKind, key: str) -> None:
    """Check the directions across the axes, from which an angle is counted."""
    if joint.zero is None:
        return
    if not kind.has_zero:
        raise SceneError(
            f"{with_a(joint.type)} joint has no angle, and keeps none; leave it out",
            key=f"{key}.zero",
        )
    _check_lengths({f"{key}.zero[{index}]": zero for index, zero in enumerate(joint.zero)})
    # Beside an axis in frame O they are checked when the frames of the bodies are known.
    for index, (zero, axis) in enumerate(zip(joint.zero, joint.axes or (), strict=False)):
        sizes = hypot(*zero) * hypot(*axis)
        (a, b, c), (x, y, z) = zero, axis
        if not hypot(b * z - c * y, c * x - a * z, a * y - b * x) > PARALLEL * sizes:
            raise SceneError(
                "is parallel to the axis; wanted a direction across it", key=f"{key}.zero[{index}]"
            )


def _check_numbers(joint: Joint, kind: JointKind, key: str) -> None:
    """Refuse numbers of other joints."""
    for name in ("pitch", "joints", "ratio", "radius", "coordinates", "factors"):
        value = getattr(joint, name)
        if value is not None and name not in kind.keys:
            raise SceneError(
                f"{with_a(joint.type)} joint has none; leave it out", key=f"{key}.{name}"
            )


def _check_lengths(axes: Mapping[str, tuple[float, float, float]]) -> None:
    """Refuse axes of zero length, all of them."""
    zero = [key for key, axis in axes.items() if not hypot(*axis) >= 1 / LARGEST]
    if zero:
        problem = "has zero length; wanted an axis"
        raise SceneError.of([Problem(problem, key) for key in zero])


def _check_length(joint: Joint, kind: JointKind, key: str) -> None:
    if joint.length is not None and "length" not in kind.own_keys:
        raise SceneError(
            f"{with_a(joint.type)} joint has no length; leave it out", key=f"{key}.length"
        )


def _check_gravity(scene: Scene) -> None:
    """Refuse components of gravity that are no formulas of parameters.

    Raises
    ------
    SceneError
        All of them.
    """
    start = values_at_start(scene)
    if problems := list(formula_problems(scene.gravity, fixed_names(scene), "gravity", start)):
        raise SceneError.of(problems)
