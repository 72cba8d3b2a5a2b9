"""The picture of a motion: shapes, and where bodies are at equal times that a screen can show."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, isfinite, log10
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.view.linkages import OUT, linkage_at_rest, linkage_motion
from kousoku.view.shapes import rotation, spatial_shapes, with_values, written_poses

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from kousoku.model.numbers.real import Array
    from kousoku.model.records.scene import Scene
    from kousoku.view.shapes import Axis, Shapes

MOST_NUMBERS, LEAST_FRAMES = 250_000, 200
"""Numbers of a motion that a page holds at most, unless these are fewer frames."""
TURN = 0.4
"""Angle that a body may turn from one frame to the next [rad]."""
SHOWN_TURNS = 2.0
"""Turns in a second that an eye can follow."""
SHORTEST_SHOW, LONGEST_SHOW = 3.0, 30.0
"""How long a motion is shown, in seconds, unless it takes that time in reality."""
SLACK = 1e-9
"""Part by which a moment may lie beyond the end, by rounding."""
PATHS = 6
"""Paths that are drawn when none are named."""


@dataclass(frozen=True, slots=True)
class Path:
    """A point whose path is drawn.

    Parameters
    ----------
    name : str
        Joint or body whose path it is.
    body : int
        Place of the body in the shapes.
    s : (3,) [unit of the scene]
        The point in its frame.
    """

    name: str
    body: int
    s: Array


@dataclass(frozen=True, slots=True)
class Picture:
    """A mechanism in motion, or at rest.

    Parameters
    ----------
    name, title, unit : str
        Of the scene.
    shapes : Shapes
        Of its bodies.
    time : (n,) [s]
        Equal steps.
    position : (n, bodies, 3) [unit of the scene]
        Origins of the frames, without the ground.
    turn : (n, bodies, 4)
        Euler parameters of the frames, scalar first.
    force : mapping of str to (n, 3)
        What joints do to their bodies j, in frame O [kg unit/s²].
    paths : tuple of Path
        Points whose paths are drawn.
    normal : (3,), optional
        Normal of the plane of the motion, toward who looks at it, where it is planar.
    speed : float
        Seconds of motion in a second of showing.
    is_chosen : bool
        Whether who asks named the joints whose forces are drawn.
    verdict : str
        How far the run can be trusted, empty where that is not known.
    """

    name: str
    title: str
    unit: str
    shapes: Shapes
    time: Array
    position: Array
    turn: Array
    force: Mapping[str, Array]
    paths: tuple[Path, ...]
    normal: Array | None
    speed: float
    is_chosen: bool = False
    verdict: str = ""

    def directions(self) -> Array:
        """East, north and up in frame O, (3, 3): a planar motion is seen looking north."""
        up = self.shapes.up
        if self.normal is None:
            east = np.cross(up, [1.0, 0.0, 0.0]) if abs(up[0]) > 0.9 else np.array([1.0, 0.0, 0.0])
            if abs(up[1]) > 0.9:  # y upward: x to the right, z toward who looks
                east = np.array([1.0, 0.0, 0.0])
            east = east - (east @ up) * up
            east /= np.linalg.norm(east)
            return np.array([east, np.cross(up, east), up])
        upward = up - (up @ self.normal) * self.normal
        if np.linalg.norm(upward) < 0.1:
            y = np.array([0.0, 1.0, 0.0])
            y = np.array([0.0, 0.0, 1.0]) if abs(self.normal[1]) > 0.9 else y
            upward = y - (y @ self.normal) * self.normal
        upward /= np.linalg.norm(upward)
        return np.array([np.cross(upward, self.normal), -self.normal, upward])

    def view(self) -> tuple[float, float]:
        """Azimuth and elevation of the first view [rad]."""
        return (0.0, 0.0) if self.normal is not None else (0.55, 0.42)


def picture_at_rest(scene: Scene, parameters: Mapping[str, float | str] | None = None) -> Picture:
    """Picture of a scene at the positions as they are written."""
    if scene.is_spatial:
        scene = with_values(scene, parameters)
        poses = written_poses(scene)
        shapes, (position, turn) = spatial_shapes(scene, poses), (array[None] for array in poses)
        normal = normal_of(shapes, position, turn)
    else:
        shapes, position, turn = linkage_at_rest(scene)
        normal = OUT
    return Picture(
        name=scene.name,
        title=scene.title or scene.name,
        unit=scene.unit,
        shapes=shapes,
        time=np.zeros(1),
        position=position,
        turn=turn,
        force={},
        paths=(),
        normal=normal,
        speed=1.0,
    )


def picture_of(
    result: Any,
    scene: Scene,
    *,
    paths_of: Sequence[Any] | None = None,
    forces: Sequence[str] | bool = True,
    fps: float = 30.0,
    speed: float | None = None,
    start: float | None = None,
    end: float | None = None,
    parameters: Mapping[str, float | str] | None = None,
) -> Picture:
    """Picture of a run, see :func:`kousoku.view.animate`."""
    from kousoku.model.errors import SolveError

    _require_numbers(scene.name, fps=fps, speed=speed, start=start, end=end)
    if len(result) == 0:
        raise SolveError(f"{scene.name}: the run has no row: there is nothing to show")
    if not scene.is_spatial:
        shapes, time, position, turn, rates = linkage_motion(result, scene)
        table: dict[str, Array] = {}
    else:
        given_values = parameters if parameters is not None else getattr(result, "parameters", {})
        scene = with_values(scene, given_values)
        time, rows = np.asarray(result.time, dtype=np.float64), len(result)
        position = _stacked(result.position, scene, rows, 3)
        turn = _stacked(result.orientation, scene, rows, 4)
        rates = (
            _stacked(result.velocity, scene, rows, 3),
            _stacked(result.angular_velocity, scene, rows, 3),
        )
        shapes = spatial_shapes(scene, (position[0], turn[0]))
        table = dict(result.force)
    first = time[0] if start is None else max(start, time[0])
    last = time[-1] if end is None else min(end, time[-1])
    if last < first:
        raise SolveError(f"{scene.name}: start={start!r} is not before end={end!r}")
    spin = _fastest(rates[1])
    show_speed = speed if speed is not None else _speed(last - first, spin)
    times = _times(first, last, len(shapes.bodies), fps=fps, speed=show_speed, spin=spin)
    chosen = _chosen_forces(table, forces, scene.name)
    samples = _interpolation(time, times)
    moved = _hermite(position, rates[0], time, samples)
    turned = _slerped(turn, samples)
    return Picture(
        name=scene.name,
        title=scene.title or scene.name,
        unit=scene.unit,
        shapes=shapes,
        time=times,
        position=moved,
        turn=turned,
        force={name: _linear(np.nan_to_num(values), samples) for name, values in chosen.items()},
        paths=_paths(shapes, paths_of, scene.name),
        normal=normal_of(shapes, position, turn),
        speed=show_speed,
        is_chosen=not isinstance(forces, bool),
        verdict=getattr(result, "verdict", ""),
    )


def require_showable(
    scene: Scene, *, paths_of: Sequence[Any] | None = None, speed: float | None = None
) -> None:
    """Refuse options that no picture of a scene can show, before it is moved.

    Raises
    ------
    SolveError
        There is no such joint or body, or the speed is none.
    """
    _require_numbers(scene.name, speed=speed)
    if paths_of:
        _paths(picture_at_rest(scene).shapes, paths_of, scene.name)


def require_moment(picture: Picture, time: float) -> None:
    """Refuse a moment that the picture of a run does not show."""
    from kousoku.model.errors import SolveError

    _require_numbers(picture.name, time=time)
    first, last = picture.time[[0, -1]].tolist()
    if not first - SLACK * abs(first) <= time <= last + SLACK * abs(last):
        raise SolveError(f"{picture.name}: time {time!r}; wanted one from {first:g} to {last:g} s")


def _require_numbers(scene: str, **options: float | None) -> None:
    """Refuse options that are no numbers, or not positive where they have to be."""
    from kousoku.model.errors import SolveError
    from kousoku.runtime.integrate.run_arguments import require_numbers

    for name, value in options.items():
        if value is None:
            continue
        number: dict[str, Any] = {name: value}
        require_numbers(scene, **number)
        if name in {"fps", "speed"} and not 0.0 < value < np.inf:
            raise SolveError(f"{scene}: {name} {value!r}; wanted a positive number")


def _stacked(table: Mapping[str, Array], scene: Scene, rows: int, size: int) -> Array:
    """Table of all bodies, (n, bodies, size); points do not turn."""
    none = np.zeros(size)
    none[0] = float(size == 4)
    columns = [table.get(name, np.broadcast_to(none, (rows, size))) for name in scene.bodies]
    return np.stack(columns, axis=1)


def _fastest(omega: Array) -> float:
    """Largest angular velocity of all bodies [rad/s]."""
    largest = float(np.linalg.norm(omega, axis=-1).max(initial=0.0))
    return largest if isfinite(largest) else 0.0


def _speed(duration: float, spin: float) -> float:
    """Speed at which a motion is shown: real time, unless that is too short, long or fast."""
    if duration <= 0.0:
        return 1.0
    factor = 1.0
    if duration < SHORTEST_SHOW / 3:
        factor = duration / SHORTEST_SHOW
    elif duration > LONGEST_SHOW * 2:
        factor = duration / LONGEST_SHOW
    if spin * factor > 2 * np.pi * SHOWN_TURNS:
        factor = 2 * np.pi * SHOWN_TURNS / spin
    return 1.0 if factor == 1.0 else _round(factor)


def _round(value: float) -> float:
    """Nearest of 1, 2, 5 times a power of ten."""
    power = 10.0 ** np.floor(log10(value))
    step = min((1, 2, 5, 10), key=lambda candidate: abs(log10(value / power / candidate)))
    return float(f"{step * power:.1g}")


def _times(
    first: float, last: float, bodies: int, *, fps: float, speed: float, spin: float
) -> Array:
    """Times at which the motion is kept, equally apart."""
    duration = last - first
    if duration <= 0.0:
        return np.array([first])
    frames = max(duration * fps / speed, duration * spin / TURN)
    most = max(LEAST_FRAMES, MOST_NUMBERS / (7 * bodies))
    return np.linspace(first, last, ceil(min(frames, most)) + 1)


def _interpolation(time: Array, times: Array) -> tuple[NDArray[np.intp], Array]:
    """Row at or before each time, and the fraction of the step to the next one."""
    if len(time) == 1:
        return np.zeros(len(times), dtype=np.intp), np.zeros(len(times))
    row = np.clip(np.searchsorted(time, times, side="right") - 1, 0, len(time) - 2)
    step = time[row + 1] - time[row]
    fraction = np.divide(times - time[row], step, out=np.zeros(len(times)), where=step > 0.0)
    return row, np.clip(fraction, 0.0, 1.0)


def _linear(values: Array, samples: tuple[NDArray[np.intp], Array]) -> Array:
    row, fraction = samples
    after = np.minimum(row + 1, len(values) - 1)
    weight = fraction.reshape(-1, *(1,) * (values.ndim - 1))
    interpolated: Array = (1 - weight) * values[row] + weight * values[after]
    return interpolated


def _hermite(
    values: Array, rates: Array, time: Array, samples: tuple[NDArray[np.intp], Array]
) -> Array:
    """Positions between rows, by cubic Hermite interpolation with the velocities."""
    if len(time) == 1 or not np.isfinite(rates).all():
        return _linear(values, samples)
    row, fraction = samples
    after = row + 1
    h = (time[after] - time[row])[:, None, None]
    s = fraction[:, None, None]
    interpolated: Array = (
        (1 + 2 * s) * (1 - s) ** 2 * values[row]
        + s * (1 - s) ** 2 * h * rates[row]
        + s**2 * (3 - 2 * s) * values[after]
        - s**2 * (1 - s) * h * rates[after]
    )
    return interpolated


def _slerped(turn: Array, samples: tuple[NDArray[np.intp], Array]) -> Array:
    """Euler parameters between rows, by spherical interpolation, of norm one."""
    row, fraction = samples
    before, after = turn[row], turn[np.minimum(row + 1, len(turn) - 1)]
    cosine = (before * after).sum(axis=-1, keepdims=True)
    after = np.where(cosine < 0.0, -after, after)
    angle = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
    s = fraction[:, None, None]
    sine = np.sin(angle)
    near = sine < 1e-6
    safe = np.where(near, 1.0, sine)
    a = np.where(near, 1 - s, np.sin((1 - s) * angle) / safe)
    b = np.where(near, s, np.sin(s * angle) / safe)
    interpolated: Array = a * before + b * after
    interpolated /= np.linalg.norm(interpolated, axis=-1, keepdims=True)
    return interpolated


def _chosen_forces(
    table: Mapping[str, Array], forces: Sequence[str] | bool, name: str
) -> dict[str, Array]:
    from kousoku.model.errors import SolveError
    from kousoku.runtime.messages import unknown

    if isinstance(forces, bool):
        return dict(table) if forces else {}
    for joint in forces:
        if not table:
            raise SolveError(f'{name}: no force of joints: generated without "reactions"')
        if joint not in table:
            raise SolveError(f"{name}: {unknown('joint', joint, list(table))}")
    return {joint: table[joint] for joint in forces}


def _paths(shapes: Shapes, paths_of: Sequence[Any] | None, name: str) -> tuple[Path, ...]:
    """Points whose paths are drawn.

    Raises
    ------
    SolveError
        There is no such body or joint, or a point is no three numbers.
    """
    from kousoku.model.errors import SolveError
    from kousoku.runtime.messages import unknown

    joints = {mark.name: mark for mark in shapes.joints}
    places = {body.name: k for k, body in enumerate(shapes.bodies) if k}
    if paths_of is None:
        inner = [mark for mark in joints.values() if mark.i and mark.j]
        if inner:
            return tuple(Path(mark.name, mark.j, mark.s_j) for mark in inner[:PATHS])
        moving = list(enumerate(shapes.bodies))[1 : PATHS + 1]
        return tuple(Path(body.name, k, body.at) for k, body in moving)
    paths = []
    for choice in [paths_of] if isinstance(paths_of, str) else paths_of:
        if isinstance(choice, str) and choice in joints:
            mark = joints[choice]
            paths.append(Path(choice, mark.j or mark.i, mark.s_j if mark.j else mark.s_i))
            continue
        body, point = (choice, None) if isinstance(choice, str) else tuple(choice)
        if body not in places:
            raise SolveError(f"{name}: {unknown('body or joint', body, [*places, *joints])}")
        shape = shapes.bodies[places[body]]
        s = shape.at if point is None else np.asarray(point, dtype=np.float64)
        if s.shape != (3,):
            raise SolveError(f"{name}: paths_of: {point!r} is no point of {body}; wanted (x, y, z)")
        paths.append(Path(body, places[body], s))
    return tuple(paths)


def normal_of(shapes: Shapes, position: Array, turn: Array) -> Array | None:
    """Normal of the plane in which all bodies move, if there is one.

    All points keep their places along it, and bodies turn about it only. Where nothing moves, axes
    of joints say what is possible.
    """
    candidates = [np.eye(3)[k] for k in (2, 1, 0)]
    axes = [_in_ground(axis, turn) for axis in shapes.axes]
    step = max(1, len(position) // 200)
    position, turned = position[::step], rotation(turn[::step])
    is_moving = bool(np.ptp(position, axis=0).any() or np.ptp(turned, axis=0).any())
    for normal in [*axes, *candidates]:
        height = position @ normal
        in_body = np.einsum("kbij,i->kbj", turned, normal)
        is_flat = np.ptp(height, axis=0).max(initial=0.0) <= 1e-6 * shapes.size
        is_flat &= bool(np.ptp(in_body, axis=0).max(initial=0.0) <= 1e-6)
        if is_flat and (is_moving or _allowed(shapes, axes, normal)):
            return np.asarray(np.copysign(1.0, _right(normal, shapes.up)) * normal) + 0.0
    return None


def _in_ground(axis: Axis, turn: Array) -> Array:
    """Direction of an axis where the motion starts, in frame O."""
    direction: Array = axis.half / np.linalg.norm(axis.half)
    return direction if axis.body == 0 else rotation(turn[0, axis.body - 1]) @ direction


def _allowed(shapes: Shapes, axes: Sequence[Array], normal: Array) -> bool:
    """Whether joints let bodies turn about a normal only, and slide across it."""
    pairs = zip(shapes.axes, axes, strict=True)
    return bool(axes) and all(
        abs(direction @ normal) < 1e-6 if axis.slides else abs(direction @ normal) > 1 - 1e-6
        for axis, direction in pairs
    )


def _right(normal: Array, up: Array) -> float:
    """Largest component of the direction to the right of who sees a plane."""
    upward = up - (up @ normal) * normal
    if np.linalg.norm(upward) < 0.1:
        upward = np.array([0.0, 1.0, 0.0]) if abs(normal[1]) < 0.9 else np.array([0.0, 0.0, 1.0])
    right = np.cross(upward, normal)
    return float(right[int(np.argmax(np.abs(right)))])
