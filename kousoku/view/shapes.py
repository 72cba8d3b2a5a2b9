"""Shapes of a mechanism: solids, sticks and joint signs in the frames of its bodies."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations
from math import ceil, log2
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from kousoku.runtime.integrate.euler_parameters import rotated
from kousoku.view.joint_shapes import JOINT_PICTURES, Ball, BoxShape, CylinderShape
from kousoku.view.meshes import box_name, coarse, cylinder_name, mesh_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from kousoku.model.mechanics.frames import BodyFrame
    from kousoku.model.numbers.real import Array
    from kousoku.model.records.scene import Scene
    from kousoku.model.records.spatial import Body, Joint
    from kousoku.view.joint_shapes import Solid

GROUND, METAL = 0, 1
"""Colours of the ground and of joints; those of bodies follow."""
LIGHT = (
    *("#b4bac4", "#6b7280"),
    *("#4f86b8", "#e0a04d", "#5aa673", "#cf6a5a", "#8f78ba", "#48a3a6", "#b3865b", "#c877a5"),
)
DARK = (
    *("#5b6370", "#9aa3b2"),
    *("#6ea3d6", "#e8b366", "#74c08d", "#e58677", "#ab96d6", "#66c0c3", "#cfa57c", "#e096c2"),
)
"""All colours, on white and on black."""

THIN, SLENDER = 0.009, 0.07
"""Radius of lines without thickness: parts of the mechanism's size and of the length of a body."""
PIECES = 8.0
"""Pieces of a solid that is as long as the mechanism."""
WIDE = 2.5
"""How much longer than the mechanism a body may be that is drawn after its moments of inertia."""
GENERIC = "spherical"
"""Joint whose sign stands for joints of one's own."""


@dataclass(frozen=True, slots=True)
class MeshPart:
    """A mesh in the frame of a body.

    Parameters
    ----------
    mesh : str
        Its name, see :func:`kousoku.view.meshes.mesh_of`.
    matrix : (3, 4) [unit of the scene]
        What takes the vertices of the mesh, with a 1 below, to the frame of the body.
    color : int
        Place in :data:`LIGHT`.
    """

    mesh: str
    matrix: Array
    color: int


@dataclass(slots=True)
class BodyShape:
    """Shape of a body, as it is drawn.

    Parameters
    ----------
    name : str
        Its name.
    color : int
        Place in :data:`LIGHT`.
    parts : list of MeshPart
        Its solids, and signs of joints.
    at : (3,) [unit of the scene]
        Where its name stands, in its frame.
    """

    name: str
    color: int
    parts: list[MeshPart] = field(default_factory=list)
    at: Array = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True, slots=True)
class JointMark:
    """Mark of the place of a joint.

    Parameters
    ----------
    name : str
        Its name.
    i, j : int
        Places of its bodies in :attr:`Shapes.bodies`.
    s_i, s_j : (3,) [unit of the scene]
        Its points in their frames.
    """

    name: str
    i: int
    j: int
    s_i: Array
    s_j: Array


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis of a joint.

    Parameters
    ----------
    body : int
        Place of the body that it is fixed in.
    s, half : (3,) [unit of the scene]
        Its middle, and half of it, in the frame of the body.
    slides : bool
        Whether bodies move along it, too.
    """

    body: int
    s: Array
    half: Array
    slides: bool


@dataclass(frozen=True, slots=True)
class Strut:
    """A line between points of two bodies: a rod without mass, a spring, a guide.

    Parameters
    ----------
    kind : {"rod", "spring", "guide"}
        What it is.
    i, j : int
        Places of its bodies.
    a, b : (3,) [unit of the scene]
        Its ends in their frames.
    width : float [unit of the scene]
        Its thickness.
    """

    kind: Literal["rod", "spring", "guide"]
    i: int
    j: int
    a: Array
    b: Array
    width: float


@dataclass(frozen=True, slots=True)
class Shapes:
    """The shapes of a mechanism.

    Parameters
    ----------
    bodies : tuple of BodyShape
        The ground, then all bodies in the order of the scene; of a linkage its links and sliders.
    joints : tuple of JointMark
        Joints with a point; of a linkage its nodes.
    axes : tuple of Axis
        Axes of joints.
    struts : tuple of Strut
        Lines between bodies.
    up : (3,)
        Upward in frame O.
    size : float [unit of the scene]
        Diagonal of the mechanism where it starts.
    """

    bodies: tuple[BodyShape, ...]
    joints: tuple[JointMark, ...]
    axes: tuple[Axis, ...]
    struts: tuple[Strut, ...]
    up: Array
    size: float


def rotation(p: Array) -> Array:
    """Matrix A(p) of Euler parameters of any length, (…, 3, 3) of (…, 4)."""
    unit = np.moveaxis(p / np.linalg.norm(p, axis=-1, keepdims=True), -1, 0)
    axes = np.eye(3).reshape(3, *(1,) * (p.ndim - 1), 3)
    return np.moveaxis(rotated(unit[..., np.newaxis], axes), 0, -2)


def across_of(axis: Array) -> Array:
    """Unit vector that is perpendicular to a unit vector."""
    across = np.eye(3)[int(np.argmin(np.abs(axis)))]
    across = across - (across @ axis) * axis
    unit: Array = across / np.linalg.norm(across)
    return unit


def spatial_shapes(scene: Scene, poses: tuple[Array, Array]) -> Shapes:
    """Shapes of a scene of bodies, whose formulas are numbers already.

    Parameters
    ----------
    scene : Scene
        What is drawn, see :func:`with_values`.
    poses : ((bodies, 3), (bodies, 4))
        Positions and Euler parameters of the bodies where the motion starts. Only the size of what
        has none depends on them.
    """
    return _SpatialShapes(scene, poses).shapes()


def with_values(scene: Scene, parameters: Mapping[str, float | str] | None) -> Scene:
    """Scene with the numbers that follow from parameters; all others are its own.

    Raises
    ------
    SolveError
        A parameter is not of the scene, or is no finite number.
    """
    from msgspec import structs

    from kousoku.model.expressions.design_numbers import changed_scene
    from kousoku.model.expressions.parser import parse_expression
    from kousoku.model.expressions.values import value_of
    from kousoku.runtime.integrate.run_arguments import values_of

    values = values_of(scene.name, scene.parameters, parameters)

    def number(formula: Any, _: str) -> float:
        return value_of(parse_expression(formula.text, values), values)

    gravity = tuple(
        value_of(parse_expression(g, values), values) if isinstance(g, str) else g
        for g in scene.gravity
    )
    return structs.replace(changed_scene(scene, number), gravity=gravity)


def written_poses(scene: Scene) -> tuple[Array, Array]:
    """Positions and Euler parameters of the bodies of a scene as they are written."""
    from kousoku.model.lowering.quaternions import quaternion

    position = np.array([body.position for body in scene.bodies.values()], dtype=np.float64)
    turns = [_numbers(quaternion(body.orientation)) for body in scene.bodies.values()]
    return position.reshape(-1, 3), np.array(turns).reshape(-1, 4)


def _numbers(values: Iterable[Any]) -> Array:
    return np.array([float(value) for value in values])


def _moved(columns: Array, middle: Array) -> Array:
    return np.column_stack([columns, middle])


class _SpatialShapes:
    """The shapes of a scene of bodies while they are collected."""

    def __init__(self, scene: Scene, poses: tuple[Array, Array]) -> None:
        from kousoku.model.lowering.quaternions import quaternion
        from kousoku.model.mechanics.frames import GROUND_FRAME, BodyFrame
        from kousoku.model.numbers.precise import IDENTITY, ZERO, triple
        from kousoku.model.records.spatial import GROUND as NAME

        self._scene = scene
        self._places = {NAME: 0} | {name: k + 1 for k, name in enumerate(scene.bodies)}
        self._bodies = [BodyShape(NAME, GROUND)]
        self._bodies += [BodyShape(n, 2 + k % (len(LIGHT) - 2)) for k, n in enumerate(scene.bodies)]
        self._frames: dict[str, BodyFrame] = {NAME: GROUND_FRAME}
        for k, (name, body) in enumerate(scene.bodies.items()):
            origin, turn = triple(body.position), quaternion(body.orientation)
            self._frames[name] = BodyFrame(k, origin, turn, ZERO, IDENTITY, body.point)
        self._position, self._turn = poses
        self._marks: list[JointMark] = []
        self._axes: list[Axis] = []
        self._struts: list[Strut] = []
        gravity = _numbers(scene.gravity)
        strength = float(np.linalg.norm(gravity))
        self._up = -gravity / strength if strength > 0.0 else self._level()

    def shapes(self) -> Shapes:
        marks = {name: self._mark(name, joint) for name, joint in self._scene.joints.items()}
        self._marks = [mark for mark in marks.values() if mark is not None]
        self._size = self._measured()
        self._thin = THIN * self._size
        lengths = [length for k in range(1, len(self._bodies)) for length in self._lengths(k)]
        if lengths:
            self._thin = min(self._thin, SLENDER * float(np.median(lengths)))
        self._add_springs()
        for name, body in self._scene.bodies.items():
            self._add_body(name, body)
        for name, joint in self._scene.joints.items():
            if (mark := marks[name]) is not None:
                self._add_joint(joint, mark)
        return Shapes(
            tuple(self._bodies),
            tuple(self._marks),
            tuple(self._axes),
            tuple(self._struts),
            self._up,
            self._size,
        )

    def _level(self) -> Array:
        """Axis that is upward without gravity: z, or y where bodies turn about z only."""
        from kousoku.model.elements.joints import JOINTS, NAMES
        from kousoku.model.mechanics.frames import joint_axes

        turning = []
        for joint in self._scene.joints.values():
            kind = JOINTS.get(NAMES.get(joint.type, ""))
            if kind is not None and kind.axes and not JOINT_PICTURES[NAMES[joint.type]].slides:
                ends = self._frames[joint.ends[0]], self._frames[joint.ends[1]]
                axis = joint_axes(ends, joint)[0]
                turning.append(abs(float(ends[0].to_ground(axis)[2])) > 1 - 1e-9)
        is_upright = bool(turning) and all(turning)
        return np.array([0.0, 1.0, 0.0] if is_upright else [0.0, 0.0, 1.0])

    def _mark(self, name: str, joint: Joint) -> JointMark | None:
        """Place of a joint's sign, unless the joint has no point."""
        from kousoku.model.mechanics.frames import joint_points

        if joint.bodies is None:
            return None
        points = self._own_points(joint)
        if not points and joint.points is None and joint.at is None:
            return None
        ends = self._frames[joint.bodies[0]], self._frames[joint.bodies[1]]
        s_i, s_j = map(_numbers, points or joint_points(joint, ends))
        i, j = (self._places[body] for body in joint.bodies)
        return JointMark(name, i, j, s_i, s_j)

    def _own_points(self, joint: Joint) -> tuple[Any, ...]:
        """First point of each body that a joint of one's own has, if both have one."""
        kind = self._scene.kinds.get(joint.type)
        names = [] if kind is None else [kind.point_of(end) for end in "ij"]
        return tuple(map(joint.vector, names)) if all(names) else ()

    def _placed(self, body: int, points: Array) -> Array:
        if body == 0:
            return points
        placed: Array = points @ rotation(self._turn[body - 1]).T + self._position[body - 1]
        return placed

    def _measured(self) -> float:
        """Diagonal of the mechanism where the motion starts."""
        points = [self._placed(m.i, m.s_i[None]) for m in self._marks]
        points += [self._placed(m.j, m.s_j[None]) for m in self._marks]
        for name, body in self._scene.bodies.items():
            index = self._places[name]
            points.append(self._placed(index, np.zeros((1, 3))))
            for part in _solids(body, 1.0, 0.0, 0):
                points.append(self._placed(index, _corners(part)))
            if body.center is not None:
                points.append(self._placed(index, _numbers(body.center)[None]))
        cloud = np.concatenate(points)
        size = float(np.linalg.norm(np.ptp(cloud, axis=0)))
        if size > 0.0:
            return size
        solids = [_inertia_solid(body, 0, np.inf)[1] for body in self._scene.bodies.values()]
        sizes = [
            float(np.linalg.norm(np.ptp(_corners(p), axis=0))) for p in solids if p is not None
        ]
        return max(sizes, default=1.0)

    def _anchors(self, index: int) -> list[Array]:
        """Points of a body where joints and springs hold it, each once."""
        ends = [end for m in self._marks for end in ((m.i, m.s_i), (m.j, m.s_j))]
        ends += [end for s in self._struts for end in ((s.i, s.a), (s.j, s.b))]
        anchors: list[Array] = []
        for body, point in ends:
            apart = (float(np.linalg.norm(point - other)) for other in anchors)
            if body == index and all(d > 1e-6 * self._size for d in apart):
                anchors.append(point)
        return anchors

    def _lengths(self, index: int) -> Iterator[float]:
        """Distances between the anchors of a body."""
        for a, b in combinations(self._anchors(index), 2):
            yield float(np.linalg.norm(a - b))

    def _add_body(self, name: str, body: Body) -> None:
        index = self._places[name]
        shape = self._bodies[index]
        center, solid = _inertia_solid(body, shape.color, self._size)
        anchors = self._anchors(index)
        parts = list(_solids(body, self._size, self._thin, shape.color))
        points = [_numbers(point.at) for point in body.mass_points]
        joined = anchors + [p for p in points if not any(_is_at(p, a) for a in anchors)]
        radius = self._thin
        if not parts and len(joined) < 2:
            # Only one joint, or none: what its mass looks like says more than a stick.
            parts = [solid if solid is not None else ball(center, 2.6 * radius, shape.color)]
        if parts:
            ends = [(point, _nearest(parts, point)) for point in joined]
            sticks = [(a, b) for a, b in ends if not any(_is_inside(part, a) for part in parts)]
        else:
            sticks = _joined(joined)
        parts += [cylinder(a, b, radius, shape.color, self._size) for a, b in sticks]
        parts += [ball(point, 2.2 * radius, shape.color) for point in points]
        shape.parts = parts
        shape.at = np.mean([part.matrix[:, 3] for part in parts], axis=0)

    def _add_joint(self, joint: Joint, mark: JointMark) -> None:
        from kousoku.model.elements.joints import JOINTS, NAMES
        from kousoku.model.mechanics.frames import joint_vectors

        kind = NAMES.get(joint.type, GENERIC)
        ends = self._frames[joint.ends[0]], self._frames[joint.ends[1]]
        vectors = [
            {key: _numbers(vector) for key, vector in frame.items()}
            for frame in joint_vectors(ends, joint)
        ]
        unit = self._unit_of(mark)
        picture = JOINT_PICTURES[kind]
        lines = [direction for _, direction in picture.axes] or [(0.0, 0.0, 1.0)]
        bases = [
            _joint_basis(vectors[0], lines[0], mark.s_i, unit),
            _joint_basis(vectors[1], lines[-1], mark.s_j, unit),
        ]
        for solid in picture.sign:
            side = 1 if solid.owner == "j" else 0
            body = (mark.i, mark.j)[side]
            self._bodies[body].parts.append(_sign_part(solid, bases[side]))
        if picture.is_rod:
            self._struts.append(Strut("rod", mark.i, mark.j, mark.s_i, mark.s_j, 2 * self._thin))
        half = 0.3 * self._size if picture.slides else 3.4 * unit
        ends_of = ((mark.i, mark.s_i), (mark.j, mark.s_j))[: JOINTS[kind].axes]
        for (body, s), frame in zip(ends_of, vectors, strict=False):
            self._axes.append(Axis(body, s, half * frame["axis"], picture.slides))
        if 0 in (mark.i, mark.j) and picture.has_pedestal:
            at, axis = (mark.s_i, vectors[0]) if mark.i == 0 else (mark.s_j, vectors[1])
            turns = JOINTS[kind].axes > 0
            self._bodies[0].parts.append(
                pedestal(at, axis["axis"] if turns else None, self._up, unit)
            )

    def _unit_of(self, mark: JointMark) -> float:
        """Length of 1 of a joint's sign, by the thickness of the bodies that meet there."""
        radius = self._thin
        for body, point in ((mark.i, mark.s_i), (mark.j, mark.s_j)):
            for part in self._bodies[body].parts:
                if not part.mesh.startswith("cylinder") or not _is_inside(part, point):
                    continue
                half = float(np.linalg.norm(part.matrix[:, 2]))
                thick = float(np.linalg.norm(part.matrix[:, 0]))
                if half > 1.5 * thick:
                    radius = max(radius, thick)
        return 3.75 * min(radius, 4.0 * self._thin)

    def _add_springs(self) -> None:
        from kousoku.model.elements.forces import FORCES

        for force in self._scene.forces.values():
            line = FORCES[force.type].line(force)
            if line is None:
                continue
            bodies, points = line
            i, j = (self._places[body] for body in bodies)
            a, b = map(_numbers, points)
            self._struts.append(Strut("spring", i, j, a, b, 1.2 * self._thin))
            for body, point in ((i, a), (j, b)):
                if body == 0:
                    unit = 3.75 * self._thin
                    self._bodies[0].parts.append(pedestal(point, None, self._up, unit))


def _is_at(a: Array, b: Array) -> bool:
    return bool(np.allclose(a, b, rtol=0.0, atol=1e-9 * (1.0 + float(np.abs(a).max()))))


def _joined(points: Sequence[Array]) -> list[tuple[Array, Array]]:
    """Sticks between points: from the first to the second, or around all of them."""
    if len(points) < 2:
        return []
    if len(points) == 2:
        return [(points[0], points[1])]
    cloud = np.array(points)
    middle = cloud.mean(axis=0)
    _, _, axes = np.linalg.svd(cloud - middle)
    projected = (cloud - middle) @ axes[:2].T
    order = np.argsort(np.arctan2(projected[:, 1], projected[:, 0]), kind="stable")
    ring = [cloud[k] for k in order]
    return list(zip(ring, ring[1:] + ring[:1], strict=True))


def _nearest(parts: Sequence[MeshPart], point: Array) -> Array:
    """Middle of the part that is nearest to a point."""
    middles = [part.matrix[:, 3] for part in parts]
    return min(middles, key=lambda middle: float(np.linalg.norm(middle - point)))


def _is_inside(part: MeshPart, point: Array) -> bool:
    """Whether a point is in the box around a part, or nearly so."""
    local, *_ = np.linalg.lstsq(part.matrix[:, :3], point - part.matrix[:, 3], rcond=None)
    return bool(np.abs(local).max() < 1.15)


def _corners(part: MeshPart) -> Array:
    signs = np.array([[x, y, z, 1.0] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners: Array = signs @ part.matrix.T
    return corners


def vertices_of(part: MeshPart, sides: int = 0) -> Array:
    """Vertices of a part in the frame of its body, (n, 3).

    Parameters
    ----------
    part : MeshPart
        The part.
    sides : int
        Faces around a cylinder; its own unless given.
    """
    mesh = np.array(mesh_of(coarse(part.mesh, sides)).vertices)
    vertices: Array = mesh @ part.matrix[:, :3].T + part.matrix[:, 3]
    return vertices


def _cuts(length: float, size: float) -> int:
    """Number of pieces that a solid is cut into: 1, 2, 4 or 8, so that there are few meshes."""
    return int(2 ** min(ceil(log2(max(1.0, PIECES * length / size))), 3))


def cylinder(a: Array, b: Array, radius: float, color: int, size: float) -> MeshPart:
    """Cylinder between the middles of its faces."""
    length = float(np.linalg.norm(b - a))
    axis = (b - a) / length
    first = across_of(axis)
    columns = np.column_stack([radius * first, radius * np.cross(axis, first), (b - a) / 2])
    is_disc = radius > length
    name = "disc" if is_disc else cylinder_name(_cuts(length, size))
    return MeshPart(name, _moved(columns, (a + b) / 2), color)


def ball(at: Array, radius: float, color: int) -> MeshPart:
    """Ball."""
    return MeshPart("ball", _moved(radius * np.eye(3), at), color)


def box(middle: Array, columns: Array, color: int, size: float) -> MeshPart:
    """Mesh of a box; the columns are half its edges."""
    cuts = [_cuts(2 * float(np.linalg.norm(edge)), size) for edge in columns.T]
    return MeshPart(box_name(*cuts), _moved(columns, middle), color)


def pedestal(at: Array, axis: Array | None, up: Array, unit: float) -> MeshPart:
    """Sign of the ground below a point, across an axis where there is one."""
    across = across_of(up) if axis is None else np.cross(up, axis)
    if float(np.linalg.norm(across)) < 0.3:  # the axis stands upright
        across = across_of(up)
    across = across / np.linalg.norm(across)
    along = np.cross(across, up)
    columns = 1.5 * unit * np.column_stack([across, up, 0.55 * along])
    return MeshPart("pedestal", _moved(columns, at), GROUND)


def _solids(body: Body, size: float, thin: float, color: int) -> Iterator[MeshPart]:
    """Solids of a body in its frame."""
    from kousoku.model.lowering.quaternions import quaternion

    for cuboid in body.boxes:
        turn = (
            np.eye(3)
            if cuboid.orientation is None
            else rotation(_numbers(quaternion(cuboid.orientation)))
        )
        yield box(_numbers(cuboid.at), turn * (_numbers(cuboid.size) / 2), color, size)
    for tube in body.cylinders:
        a, b = map(_numbers, tube.ends)
        yield cylinder(a, b, float(tube.radius), color, size)
    for rod in body.rods:
        a, b = map(_numbers, rod.ends)
        yield cylinder(a, b, thin, color, size)
    for sphere in body.spheres:
        yield ball(_numbers(sphere.at), float(sphere.radius), color)


def _inertia_solid(body: Body, color: int, size: float) -> tuple[Array, MeshPart | None]:
    """Centre of mass, and the uniform box or cylinder that has the body's moments.

    A body without solids whose moments are those of no box, or of one that is much larger than the
    mechanism, has none.
    """
    from kousoku.model.lowering.mass import mass_properties

    properties = mass_properties(body)
    mass, center = float(properties.mass), _numbers(properties.center)
    moments = _numbers(properties.moments)
    if mass <= 0.0 or body.inertia is None or moments.max() <= 0.0:
        return center, None
    squares = 6.0 * (moments.sum() - 2.0 * moments) / mass  # of the edges of a box
    if squares.min() < -1e-6 * squares.max() or squares.max() > (WIDE * size) ** 2:
        return center, None
    least = 0.6 * THIN * min(size, float(np.sqrt(squares.max())))
    edges = np.maximum(np.sqrt(np.maximum(squares, 0.0)), 2 * least)
    axes = rotation(_numbers(properties.axes)).T  # its columns are the principal axes
    for k in range(3):
        a, b = moments[k - 2], moments[k - 1]
        if abs(a - b) <= 1e-6 * moments.max() < moments.max() - moments.min():
            radius = max(float(np.sqrt(2.0 * moments[k] / mass)), least)
            square = 12.0 * a / mass - 3.0 * radius**2
            half = max(float(np.sqrt(max(square, 0.0))) / 2, least)
            return center, cylinder(
                center - half * axes[:, k], center + half * axes[:, k], radius, color, size
            )
    return center, box(center, axes * (edges / 2), color, size)


def _joint_basis(
    vectors: Mapping[str, Array], line: Sequence[float], at: Array, unit: float
) -> Array:
    """Transformation of the picture of a joint to the joint frame of a body, (3, 4)."""
    k = int(np.argmax(line))
    columns = np.empty((3, 3))
    for step, name in enumerate(("axis", "across", "third")):
        columns[:, (k + step) % 3] = vectors[name]
    return _moved(unit * columns, at)


def _sign_part(solid: Solid, basis: Array) -> MeshPart:
    """Solid of a joint's sign in the frame of a body."""
    match solid:
        case BoxShape(_, low, high):
            half = np.subtract(high, low) / 2
            part = MeshPart(box_name(1, 1, 1), _moved(np.diag(half), np.add(low, high) / 2), METAL)
        case CylinderShape(_, start, end, radius):
            part = cylinder(np.array(start), np.array(end), radius, METAL, 100.0)
        case Ball(_, at, radius):
            part = ball(np.array(at), radius, METAL)
    matrix = basis @ np.vstack([part.matrix, [0.0, 0.0, 0.0, 1.0]])
    name = cylinder_name(1) if part.mesh == "disc" else part.mesh
    return MeshPart(name, matrix, METAL)
