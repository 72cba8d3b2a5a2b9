"""Mass properties of a body: sums over its solids, centre of mass, principal axes.

All in 50 digits and in the units of the scene; :mod:`kousoku.model.lowering.system` rounds once.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from msgspec import structs

from kousoku.model.errors import SceneError
from kousoku.model.lowering.quaternions import quaternion
from kousoku.model.numbers import precise
from kousoku.model.numbers.digits import CONTEXT
from kousoku.model.numbers.precise import ZERO, High, Quadruple, Square, Triple
from kousoku.model.numbers.traced import NOISE, Traced, at_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from kousoku.model.records.solids import Box, Cylinder, Inertia
    from kousoku.model.records.spatial import Body

#: A part of a body: mass, centre, inertia tensor about the centre in the axes of the body frame.
SolidPart = tuple[High, Triple, Square]

SAME = CONTEXT.mpf(2) ** -53
"""Elements of a tensor below this part of its largest moment are zero: doubles do not show them."""


RIGHT = precise.sqrt(CONTEXT.mpf(0.5))
"""Cosine and sine of 45 degrees."""
TINY = CONTEXT.mpf(10) ** -300
"""Negligible number, added where a quotient would be 0/0."""
UNIT = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
PAIRS = ((0, 1), (0, 2), (1, 2))
"""Elements off the diagonal."""


@dataclass(frozen=True, slots=True)
class MassProperties:
    """Mass properties of a body in its principal frame.

    Parameters
    ----------
    mass : [kg]
        Zero where the scene gives none.
    center : (3,) [unit of the scene]
        Centre of mass in the body frame.
    moments : (3,) [kg unit²]
        Principal moments of inertia about the centre of mass.
    axes : (4,)
        Euler parameters, of any length, that take components in the body frame to components in the
        principal frame.
    """

    mass: High
    center: Triple
    moments: Triple
    axes: Quadruple


def mass_properties(body: Body, key: str = "") -> MassProperties:
    """Mass properties of a body that was checked, summed over all its parts.

    m = Σ mₖ [kg], c = Σ mₖ cₖ / m (3,) [unit of the scene] and, about c, the inertia tensor
    J = Σ (Jₖ + mₖ (|d|² I − d dᵀ)) (3, 3) [kg unit²] with d = cₖ − c, in the body frame. The
    principal axes are those that are nearest to the axes of the body: where its tensor is diagonal
    they are the axes of the body themselves.
    """
    try:
        return _properties(structs.replace(body, **ANYWHERE))
    except SceneError as error:
        raise SceneError(error.problems[0].problem, key=key) from None


#: Position and velocity of a body, which its mass properties do not depend on.
ANYWHERE: dict[str, Any] = {
    "position": (0.0, 0.0, 0.0),
    "orientation": None,
    "velocity": (0.0, 0.0, 0.0),
    "angular_velocity": None,
    "angular_velocity_b": None,
    "hold": (),
}


@lru_cache(maxsize=4096)
def _properties(body: Body) -> MassProperties:
    parts = list(_parts(body))
    mass = sum((part[0] for part in parts), CONTEXT.mpf(0))
    if mass == 0:
        center = ZERO if body.center is None else precise.triple(body.center)
        return MassProperties(mass, center, ZERO, precise.IDENTITY)
    center = ZERO
    for part_mass, at, _ in parts:
        center = precise.add(center, precise.scale(part_mass / mass, at))
    total = [[CONTEXT.mpf(0)] * 3 for _ in range(3)]
    for part_mass, at, tensor in parts:
        moved = steiner(part_mass, precise.subtract(at, center))
        for i in range(3):
            for j in range(3):
                total[i][j] += tensor[i][j] + moved[i][j]
    moments, axes = principal(total)
    return MassProperties(mass, center, moments, axes)


def steiner(mass: High, d: Triple) -> Square:
    """Inertia tensor m (|d|² I − d dᵀ) (3, 3) [kg unit²] of a mass at d (3,) about the origin.

    m [kg]; d [unit of the scene] and the tensor are in one frame.
    """
    square = precise.dot(d, d)
    return _symmetric(
        lambda i, j: mass * (int(i == j) * square - d[i] * d[j]),
    )


def principal(tensor: list[list[High]]) -> tuple[Triple, Quadruple]:
    """Principal moments of a symmetric tensor, and the rotation to its principal axes.

    Jacobi's method: each rotation by at most 45 degrees clears one element, so that zeros which
    keep an axis of the body a principal axis stay zeros.

    Parameters
    ----------
    tensor : (3, 3) [kg unit²]
        J by rows, in the body frame.

    Returns
    -------
    moments : (3,) [kg unit²]
        The diagonal of A(p) J A(p)ᵀ.
    p : (4,) [-]
        Euler parameters of any norm: components in the body frame to the principal frame.
    """
    if any(isinstance(x, Traced) for row in tensor for x in row):
        return traced_principal(tensor)
    a = [list(row) for row in tensor]
    axes = [[CONTEXT.mpf(int(i == j)) for j in range(3)] for i in range(3)]
    limit = SAME * max(abs(a[i][i]) for i in range(3))
    for i, j in ((0, 1), (0, 2), (1, 2)):
        if abs(a[i][j]) <= limit:
            a[i][j] = a[j][i] = CONTEXT.mpf(0)
    limit *= NOISE
    while max(abs(a[0][1]), abs(a[0][2]), abs(a[1][2])) > limit:
        for i, j in ((0, 1), (0, 2), (1, 2)):
            if abs(a[i][j]) > limit:
                _clear(a, axes, i, j)
    (x, y, z) = ((row[0], row[1], row[2]) for row in axes)
    return (a[0][0], a[1][1], a[2][2]), precise.quaternion_of((x, y, z))


def traced_principal(tensor: list[list[High]]) -> tuple[Triple, Quadruple]:
    """Principal moments and axes of a tensor that depends on parameters.

    The axes are those of the scene where parameters do not turn them; else one element off the
    diagonal is cleared in closed form.

    Parameters
    ----------
    tensor : (3, 3) [kg unit²]
        By rows, in the body frame.

    Returns
    -------
    moments, p : (3,) [kg unit²], (4,) [-]
        As of :func:`principal`.

    Raises
    ------
    SceneError
        Parameters turn the principal axes, and not about an axis of the body.
    """
    _, p = principal([[at_scene(x) for x in row] for row in tensor])
    rows = [precise.rotate_back(p, precise.triple(row)) for row in UNIT]
    x, y, z = ((row[0], row[1], row[2]) for row in tensor)
    images = [(precise.dot(x, b), precise.dot(y, b), precise.dot(z, b)) for b in rows]
    turned = [[precise.dot(a, image) for image in images] for a in rows]
    if not _shown_off_diagonal(turned):
        return (turned[0][0], turned[1][1], turned[2][2]), p
    a = [list(row) for row in tensor]
    axes = [[CONTEXT.mpf(int(i == j)) for j in range(3)] for i in range(3)]
    pairs = _shown_off_diagonal(a)
    if len(pairs) != 1:
        raise SceneError(
            "has principal axes that parameters turn in space; wanted parts that keep an axis of"
            " the body a principal axis, or numbers instead of the formulas",
        )
    _clear(a, axes, *pairs[0])
    (x, y, z) = ((row[0], row[1], row[2]) for row in axes)
    return (a[0][0], a[1][1], a[2][2]), precise.quaternion_of((x, y, z))


def _shown_off_diagonal(tensor: Sequence[Sequence[High]]) -> list[tuple[int, int]]:
    """Elements off the diagonal that are not zero.

    A formula that is zero but for rounding is so beside the moments, with any parameters: in sums
    of products of which all but one vanish, nothing else tells how large the numbers were.
    """
    diagonal = [tensor[i][i] for i in range(3)]
    limit = SAME * max(abs(at_scene(x)) for x in diagonal)

    def is_shown(x: High) -> bool:
        if not isinstance(x, Traced):
            return bool(abs(x) > limit)
        moments = ([abs(_value(moment, k)) for moment in diagonal] for k in range(len(x.values)))
        pairs = zip(x.values, moments, strict=True)
        return not all(abs(value) <= NOISE * max(sizes) for value, sizes in pairs)

    return [(i, j) for i, j in PAIRS if is_shown(tensor[i][j])]


def _value(x: High, k: int) -> High:
    """Number with the parameters of the scene, k = 0, or with others."""
    return x.values[k] if isinstance(x, Traced) else x


def _turn(difference: High, element: High) -> tuple[High, High]:
    """Cosine and sine of the turn that clears an element, given the difference of moments.

    It is at most 45 degrees in the scene, which it is where moments are equal with any parameters,
    and at most 90 degrees with others: the larger moment may become the smaller one, or both
    equal. Of the double angle, half of that with the larger cosine is known to all digits.

    Raises
    ------
    SceneError
        In the scene all axes are principal axes, and which ones are with others is not known.
    """
    if not any(difference.values if isinstance(difference, Traced) else (difference,)):
        return RIGHT, RIGHT
    if not (at_scene(difference) or at_scene(element)):
        raise SceneError(
            "has equal principal moments, and parameters that turn its axes once they differ;"
            " wanted other values of the parameters, or numbers instead of the formulas"
        )
    if difference < 0:
        difference, element = -difference, -element
    size = precise.sqrt(difference * difference + 4 * element * element + TINY)
    cosine, sine = difference / size, 2 * element / size
    larger = precise.sqrt((1 + abs(cosine)) / 2)
    total = larger + abs(sine) / (2 * larger)
    c, s = (total + cosine / total) / 2, (total - cosine / total) / 2
    norm = precise.sqrt(c * c + s * s)
    side = sine + TINY
    return c / norm, side / abs(side) * (s / norm)


def _clear(a: list[list[High]], axes: list[list[High]], i: int, j: int) -> None:
    """Turn rows and columns i and j of a, and rows of ``axes``, until a_ij is zero."""
    difference, element = a[j][j] - a[i][i], a[i][j]
    if isinstance(difference, Traced) or isinstance(element, Traced):
        c, s = _turn(difference, element)
    else:
        theta = difference / (2 * element)
        root = abs(theta) + CONTEXT.sqrt(theta * theta + 1)
        t = 1 / root if theta >= 0 else -1 / root
        c = 1 / precise.sqrt(t * t + 1)
        s = t * c
    for rows in (a, axes):
        first, second = rows[i], rows[j]
        rows[i] = [c * x - s * y for x, y in zip(first, second, strict=True)]
        rows[j] = [s * x + c * y for x, y in zip(first, second, strict=True)]
    for row in a:
        row[i], row[j] = c * row[i] - s * row[j], s * row[i] + c * row[j]
    a[i][j] = a[j][i] = CONTEXT.mpf(0)


def _parts(body: Body) -> Iterator[SolidPart]:
    """Parts of a body, in the order of its keys."""
    if body.mass is not None:
        mass = precise.number(body.mass)
        center = ZERO if body.center is None else precise.triple(body.center)
        yield mass, center, _about_center(mass, center, body.inertia)
    for point in body.mass_points:
        yield precise.number(point.mass), precise.triple(point.at), _diagonal(ZERO)
    for box in body.boxes:
        yield precise.number(box.mass), precise.triple(box.at), _box(box)
    for rod in body.rods:
        start, end = map(precise.triple, rod.ends)
        mass = precise.number(rod.mass)
        yield mass, _middle(start, end), steiner(mass / 12, precise.subtract(end, start))
    for cylinder in body.cylinders:
        start, end = map(precise.triple, cylinder.ends)
        yield precise.number(cylinder.mass), _middle(start, end), _cylinder(cylinder)
    for sphere in body.spheres:
        mass, radius = precise.number(sphere.mass), precise.number(sphere.radius)
        moment = 2 * mass * radius**2 / 5
        yield mass, precise.triple(sphere.at), _diagonal((moment, moment, moment))


def _about_center(mass: High, center: Triple, inertia: Inertia | None) -> Square:
    """Inertia tensor about the centre of mass, of one that is given about any point."""
    if inertia is None:
        return _diagonal(ZERO)
    (xx, yy, zz) = precise.triple((inertia.xx, inertia.yy, inertia.zz))
    (xy, yz, zx) = precise.triple((inertia.xy, inertia.yz, inertia.zx))
    tensor = ((xx, xy, zx), (xy, yy, yz), (zx, yz, zz))
    if inertia.about is None:
        return tensor
    moved = steiner(mass, precise.subtract(center, precise.triple(inertia.about)))
    return _symmetric(lambda i, j: tensor[i][j] - moved[i][j])


def _box(box: Box) -> Square:
    mass = precise.number(box.mass)
    a, b, c = (precise.number(edge) ** 2 for edge in box.size)
    moments = (mass * (b + c) / 12, mass * (c + a) / 12, mass * (a + b) / 12)
    if box.orientation is None:
        return _diagonal(moments)
    p = quaternion(box.orientation)
    axes = [precise.rotate(p, precise.triple(row)) for row in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    return _symmetric(lambda i, j: sum(moments[k] * axes[k][i] * axes[k][j] for k in range(3)))


def _cylinder(cylinder: Cylinder) -> Square:
    """Inertia I_t I + (I_a − I_t) u uᵀ, with I_a = m R²/2, I_t = m (3 R² + L²)/12 and u = l/L."""
    mass, square = precise.number(cylinder.mass), precise.number(cylinder.radius) ** 2
    start, end = map(precise.triple, cylinder.ends)
    along = precise.subtract(end, start)
    length = precise.dot(along, along)
    transverse = mass * (3 * square + length) / 12
    difference = (mass * square / 2 - transverse) / length
    return _symmetric(lambda i, j: int(i == j) * transverse + difference * along[i] * along[j])


def _middle(start: Triple, end: Triple) -> Triple:
    return precise.scale(CONTEXT.mpf(1) / 2, precise.add(start, end))


def _diagonal(moments: Triple) -> Square:
    return _symmetric(lambda i, j: moments[i] if i == j else CONTEXT.mpf(0))


def _symmetric(element: Callable[[int, int], High]) -> Square:
    (x, y, z) = ((element(i, 0), element(i, 1), element(i, 2)) for i in range(3))
    return x, y, z
