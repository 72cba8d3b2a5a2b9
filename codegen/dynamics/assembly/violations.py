"""Violations of joints, in metres and radians, joint by joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.elements.constraints import BodiesAtRest, facets_of_kind
from kousoku.model.numbers import precise
from kousoku.model.numbers.precise import ZERO
from kousoku.model.records.own_kind import is_own
from kousoku.runtime.messages import listed

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.assembly.pose import Pose
    from kousoku.codegen.dynamics.assembly.residuals import Residuals
    from kousoku.model.mechanics.multibody import Instance
    from kousoku.model.numbers.precise import High, Triple

CONSTRAINT_TOLERANCE = 1e-12
"""Violation, as a part of the size of the system, up to which joints fit; smaller steps along
positions that fit are no steps."""

WORTH_NAMING = 1e-6
"""A violation below this part of the worst is not named."""


def violations(rows: Residuals, pose: Pose, length: float) -> dict[str, tuple[float, float]]:
    """Violations |C| of joints that are not closed, the largest by each key, the worst first.

    Parameters
    ----------
    rows : Residuals
        Rows that should hold.
    pose : Pose
        Positions of the bodies, frame O.
    length : float [m]
        The size of the system.

    Returns
    -------
    dict of str to (float, float) [m, rad]
        By the dotted key, the largest row that is a length and the largest that is an angle.
    """
    largest: dict[str, list[float]] = {}
    values, _ = rows.at(pose)
    for instance, first in zip(rows.constraints, rows.first, strict=False):
        block = slice(first, first + rows.count(instance))
        is_by_rows = instance.is_combination or is_own(instance.kind)
        if is_by_rows or rows.is_left_out[block].any():
            size, unit = max(map(abs, values[block])), 0 if rows.in_metres[first] else 1
        else:
            size, unit = _size(instance, pose)
        sizes = largest.setdefault(key_of(instance), [0.0, 0.0])
        sizes[unit] = max(sizes[unit], float(size))
    return worst_first(largest, CONSTRAINT_TOLERANCE, length)


def key_of(instance: Instance) -> str:
    """Dotted key of the element that an instance comes from: ``joints.a``, ``drivers.motor``."""
    if "." in instance.joint:
        return instance.joint
    return f"{'drivers' if instance.is_driver else 'joints'}.{instance.joint}"


def worst_first(
    sizes: Mapping[str, Sequence[float]], at_least: float, length: float
) -> dict[str, tuple[float, float]]:
    """Joints whose larger size is above a limit and worth naming, the worst first.

    Metres are compared with radians by a length, so that the size of a mechanism does not matter.
    """
    scaled = {name: max(m / length, rad) for name, (m, rad) in sizes.items()}
    limit = max(at_least, WORTH_NAMING * max(scaled.values(), default=0.0))
    names = sorted((name for name in sizes if scaled[name] > limit), key=lambda name: -scaled[name])
    return {name: (sizes[name][0], sizes[name][1]) for name in names}


def _size(instance: Instance, pose: Pose) -> tuple[High, int]:
    """Violation of an instance, and 0 for metres or 1 for radians."""
    constants = dict(instance.constants)
    ends = tuple(zip("ij", (instance.i, instance.j), strict=True))

    def in_o(name: str, body: str, index: int) -> Triple:
        values = constants.get(f"{name}_{body}_b")
        return ZERO if values is None else precise.rotate(pose.p[index], precise.triple(values))

    axis, other = (in_o("a", body, index) for body, index in ends)
    start, end = (precise.add(pose.r[index], in_o("s", body, index)) for body, index in ends)
    d = precise.subtract(end, start)
    length = constants.get("length")
    at_rest = BodiesAtRest((axis, other), d, None if length is None else precise.number(length[0]))
    return facets_of_kind(instance.kind).gap(at_rest)


def sizes_of(open_joints: dict[str, tuple[float, float]], units: tuple[str, str]) -> str:
    """Text such as ``joints.a by 0.25 m and 0.1 rad, joints.b by 0.2 m``."""
    texts = []
    worst = max(map(max, open_joints.values()))
    for key, sizes in open_joints.items():
        shown = zip(sizes, units, strict=True)
        parts = [f"{x:.3g} {unit}" for x, unit in shown if x > WORTH_NAMING * worst]
        texts.append(f"{key} by {' and '.join(parts)}")
    return listed(texts)
