"""Turn a spatial scene into a system: principal frames, SI units, instances of kinds.

What a number of the scene becomes is computed in 50 digits and rounded once.
"""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, Any

import msgspec

from kousoku.model.elements.event import events_of
from kousoku.model.elements.joints import COUPLINGS, JOINTS, NAMES
from kousoku.model.errors import SceneError
from kousoku.model.expressions.formulas import used_parameters
from kousoku.model.lowering.coordinates import CoordinateList
from kousoku.model.lowering.held import held_coordinates, held_of
from kousoku.model.lowering.mass import mass_properties
from kousoku.model.lowering.parametric import positive_numbers, varying_scene
from kousoku.model.lowering.quaternions import quaternion
from kousoku.model.lowering.system_drivers import driver_instances, start_values
from kousoku.model.lowering.system_forces import force_elements, gravity_law, gravity_of
from kousoku.model.lowering.zero_directions import check_zero_directions
from kousoku.model.mechanics.constraints import COMBINATION, CONSTRAINTS, is_point
from kousoku.model.mechanics.frames import (
    GROUND_FRAME,
    BodyFrame,
    joint_points,
    joint_vectors,
    not_negative,
    to_quaternion,
    to_vector,
)
from kousoku.model.mechanics.multibody import Instance, MovingBody, System
from kousoku.model.mechanics.parallel_rows import variant
from kousoku.model.numbers import precise
from kousoku.model.numbers.precise import ZERO, High, Triple
from kousoku.model.numbers.traced import Traced
from kousoku.model.numbers.varying import Varying, fixed, is_varying
from kousoku.model.records.own_kind import FRAMES, ORIGINS, input_name
from kousoku.model.records.spatial import GROUND
from kousoku.model.records.units import METRES
from kousoku.model.validation.mass import POSSIBLE
from kousoku.model.validation.unused import OUTPUTS, output_problem

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from kousoku.model.elements.joint import JointPart
    from kousoku.model.errors import Problem
    from kousoku.model.lowering.mass import MassProperties
    from kousoku.model.records.own_kind import OwnInput, OwnKind
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Body, Joint

UNIT_NAMES = {float(precise.number(length)): name for name, length in METRES.items()}
"""Names of units by their lengths in metres."""


def system_of(scene: Scene, outputs: Sequence[str] | None = None) -> System:
    """System of a spatial scene, at the positions and velocities that the scene gives.

    Coordinates that nothing needs, and parameters that stand in no formula, are left out of it.

    Parameters
    ----------
    scene : Scene
        A checked scene.
    outputs : sequence of str, optional
        Outputs that are wanted; those of the scene unless given.

    Raises
    ------
    SceneError
        The scene is planar, or gives no distance to a rod, or there is no such output.
    """
    if not scene.is_spatial:
        raise SceneError("is missing; wanted a scene of bodies and joints", key="bodies")
    scene = varying_scene(msgspec.structs.replace(scene, parameters=used_parameters(scene)))
    unit = precise.number(METRES[scene.unit])
    frames = {GROUND: GROUND_FRAME}
    bodies = tuple(_bodies(scene, frames, unit))
    held_by_body = [held_of(name, body, frames[name], unit) for name, body in scene.bodies.items()]
    check_zero_directions(scene, frames)
    coordinates = CoordinateList(scene, frames, unit)
    start_values(scene, coordinates)
    constraints = (
        *_constraints(scene, frames, coordinates),
        *driver_instances(scene, coordinates),
    )
    forces = force_elements(scene, frames, coordinates, unit)
    events = tuple(event.element(coordinates) for event in events_of(scene))
    wanted = _outputs(scene, outputs)
    shown = scene.coordinates if "coordinates" in wanted else ()
    indices = tuple(coordinates.index_of(name) for name in shown)
    needed = len(coordinates.records)
    held = (
        *chain.from_iterable(positions for positions, _ in held_by_body),
        *held_coordinates(scene, coordinates),
    )
    return System(
        name=scene.name,
        unit=float(unit),
        bodies=bodies,
        constraints=constraints,
        gravity=gravity_of(scene, unit),
        gravity_law=gravity_law(scene),
        held=held,
        held_rates=tuple(chain.from_iterable(rates for _, rates in held_by_body)),
        forces=forces,
        coordinates=coordinates.records,
        shown=indices,
        parameters=tuple(scene.parameters.items()),
        only_held=len(coordinates.records) - needed,
        positive=(*positive_numbers(scene), *_moments(scene, bodies)),
        closure_tolerance=scene.closure_tolerance,
        events=events,
    )


def _outputs(scene: Scene, outputs: Sequence[str] | None) -> Sequence[str]:
    """Outputs that are wanted, unless no scene of bodies has them."""
    wanted = scene.outputs if outputs is None else outputs
    for index, output in enumerate(wanted):
        if output not in OUTPUTS:
            raise SceneError(output_problem(scene, output), key=f"outputs[{index}]")
    return wanted


def _bodies(scene: Scene, frames: dict[str, BodyFrame], unit: High) -> Iterator[MovingBody]:
    """Bodies of a scene, and add their frames to those that are known."""
    for index, (name, body) in enumerate(scene.bodies.items()):
        properties = mass_properties(body, f"bodies.{name}")
        frames[name] = BodyFrame(
            index,
            precise.triple(body.position),
            quaternion(body.orientation),
            properties.center,
            properties.axes,
            body.point,
        )
        yield _moving(name, body, frames[name], properties, unit)


def _moments(scene: Scene, bodies: Sequence[MovingBody]) -> Iterator[tuple[str, float]]:
    """Functions of the principal moments that depend on parameters and must be positive.

    These are the moments, and the sum of two less the third where the scene gives the inertia: of
    solids that is positive.
    """
    for body in bodies:
        key = f"bodies.{body.name}.inertia"
        yield from ((key, x) for x in filter(is_varying, body.inertia))
        if scene.bodies[body.name].inertia is None or not is_varying(body.inertia):
            continue
        moments = [precise.number(x) for x in body.inertia]
        for k, third in enumerate(moments):
            two = precise.number(POSSIBLE) * (moments[k - 1] + moments[k - 2])
            if isinstance(excess := two - third, Traced):
                yield f"{key}, the sum of two principal moments less the third,", Varying(excess)


def _moving(
    name: str, body: Body, frame: BodyFrame, properties: MassProperties, unit: High
) -> MovingBody:
    arm = precise.rotate(frame.p, frame.center)
    if body.angular_velocity_b is not None:
        spin = precise.triple(body.angular_velocity_b)
        omega = precise.rotate(frame.p, spin)
    else:
        omega = precise.triple(body.angular_velocity or (0.0, 0.0, 0.0))
        spin = precise.rotate_back(frame.p, omega)
    velocity = precise.add(precise.triple(body.velocity), precise.cross(omega, arm))
    moments = to_vector(precise.scale(unit * unit, properties.moments))
    return MovingBody(
        name=name,
        mass=precise.double(properties.mass),
        inertia=not_negative(moments),
        is_point=body.point,
        r=fixed(to_vector(precise.scale(unit, precise.add(frame.position, arm)))),
        p=fixed(to_quaternion(precise.compose(frame.p, precise.conjugate(frame.axes)))),
        v=fixed(to_vector(precise.scale(unit, velocity))),
        omega_b=fixed(to_vector(frame.principal(spin))),
        origin_b=frame.point(ZERO, unit),
        axes_b=to_quaternion(frame.axes),
        spins_in_o=body.angular_velocity is not None,
    )


def _constraints(
    scene: Scene, frames: Mapping[str, BodyFrame], coordinates: CoordinateList
) -> list[Instance]:
    """Constraints of all joints; all that cannot be composed is refused at once."""
    instances: list[Instance] = []
    problems: list[Problem] = []
    for name, joint in scene.joints.items():
        try:
            if joint.type in scene.kinds:
                instances.append(_own_instance(name, joint, scene.kinds[joint.type], frames, scene))
            else:
                instances += _instances(name, joint, frames, coordinates)
        except SceneError as error:
            problems += error.problems
    if problems:
        raise SceneError.of(problems)
    return instances


def _instances(
    name: str, joint: Joint, frames: Mapping[str, BodyFrame], coordinates: CoordinateList
) -> Iterator[Instance]:
    """Instances of a joint, in the order of the table of joints."""
    if NAMES[joint.type] in COUPLINGS:
        yield COUPLINGS[NAMES[joint.type]].combination(name, joint, coordinates)
        return
    unit = coordinates.unit
    kind = JOINTS[NAMES[joint.type]]
    ends = frames[joint.ends[0]], frames[joint.ends[1]]
    points = joint_points(joint, ends) if kind.has_point else ()
    is_oriented = any(map(kind.needs_orientation, (0, 1)))
    vectors = joint_vectors(ends, joint) if is_oriented else ({}, {})
    if joint.zero is not None and kind.keeps_zero:
        _require_near(name, ends, vectors)
    for part in kind.parts:
        if part.kind == COMBINATION:
            yield kind.combination(name, joint, coordinates)
            continue
        constants = dict(_constants(part, ends, points, vectors, unit))
        package = part.kind
        if CONSTRAINTS[package].has_variants:
            package = variant(package, constants["a_i_b"])
        if CONSTRAINTS[part.kind].has_length:
            constants["length"] = (_length(name, joint, ends, points, unit),)
        yield Instance(name, package, ends[0].index, ends[1].index, tuple(constants.items()))


def _own_instance(
    name: str, joint: Joint, kind: OwnKind, frames: Mapping[str, BodyFrame], scene: Scene
) -> Instance:
    """Joint of one's own: its frames in the principal ones, and its inputs in SI units.

    Its point in a body is the first that its kind has there, or else the origin of the body frame.
    """
    unit = precise.number(METRES[scene.unit])
    ends = frames[joint.ends[0]], frames[joint.ends[1]]
    inputs = joint.inputs or {}
    names = [kind.point_of(body) for body in "ij"]
    points = [precise.triple(joint.vector(key)) if key else ZERO for key in names]
    constants: list[tuple[str, tuple[float, ...]]] = []
    for body, end, point in zip("ij", ends, points, strict=True):
        constants.append((f"s_{body}_b", end.point(point, unit)))
    for key, end in zip(ORIGINS, ends, strict=True):
        constants.append((key, end.point(ZERO, unit)))
    for key, end in zip(FRAMES, ends, strict=True):
        constants.append((key, to_quaternion(end.axes)))
    for key, own_input in kind.inputs.items():
        constants.append((input_name(key), _own_value(own_input, inputs[key], unit)))
    return Instance(
        name, kind.kernels, ends[0].index, ends[1].index, tuple(constants), unit=kind.unit
    )


def _own_value(own_input: OwnInput, value: Any, unit: High) -> tuple[float, ...]:
    """Input of a kind of one's own; directions have norm one."""
    factor = unit if own_input.unit == "m" else precise.number(1)
    if not own_input.vector:
        return (precise.double(factor * precise.number(value)),)
    vector = precise.triple(value)
    if own_input.is_direction:
        return precise.rounded(precise.unit(vector))
    return to_vector(precise.scale(factor, vector))


def _require_near(
    name: str,
    ends: tuple[BodyFrame, BodyFrame],
    vectors: tuple[dict[str, Triple], dict[str, Triple]],
) -> None:
    """Refuse directions that are to be parallel and are nearer to the opposite of that."""
    i, j = (
        [end.to_ground(axes[direction]) for direction in ("across", "third")]
        for end, axes in zip(ends, vectors, strict=True)
    )
    if not sum(precise.dot(a, b) for a, b in zip(i, j, strict=True)) > 0:
        raise SceneError(
            "are more than a quarter turn apart as the orientations are written, and would be kept "
            "antiparallel; wanted bodies that are turned nearer to it",
            key=f"joints.{name}.zero",
        )


def _constants(
    part: JointPart,
    ends: tuple[BodyFrame, BodyFrame],
    points: Sequence[Triple],
    vectors: tuple[dict[str, Triple], dict[str, Triple]],
    unit: High,
) -> Iterator[tuple[str, tuple[float, ...]]]:
    """Inputs of a kernel that are fixed, in the order of its arguments."""
    for name in CONSTRAINTS[part.kind].inputs:
        k = "ij".index(name[2])
        if is_point(name):
            yield name, ends[k].point(points[k], unit)
        else:
            yield name, precise.rounded(vectors[k][part.j if k else part.i])


def _length(
    name: str, joint: Joint, ends: tuple[BodyFrame, BodyFrame], points: Sequence[Triple], unit: High
) -> float:
    """Length of a rod, the distance of its points where the scene gives none."""
    if joint.length is not None:
        return precise.double(unit * precise.number(joint.length))
    start, end = (frame.place(point) for frame, point in zip(ends, points, strict=True))
    length = precise.length(precise.subtract(end, start))
    if not length:
        raise SceneError("is missing, and its two points coincide", key=f"joints.{name}.length")
    return precise.double(unit * length)
