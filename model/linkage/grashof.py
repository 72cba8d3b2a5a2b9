"""Closure before solving: Grashof's conditions where they can be known from the scene alone.

A node that is hinged by two links to nodes whose motion is known, or by one link to such a node
while it slides on a line, exists only while a distance stays within a range. For a four-bar this
is equation (34) of Yamada and Tatsumi (1981); the other cases are its analogues.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from math import acos, asin, atan2, copysign, floor, hypot, tau
from typing import TYPE_CHECKING

import numpy as np

from kousoku.model.errors import SceneError
from kousoku.model.linkage.circuits import check_circuits
from kousoku.model.linkage.input_drivers import travel_of
from kousoku.model.linkage.input_motion import input_values, period
from kousoku.model.linkage.prescribed import known_nodes

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.linkage.prescribed import Crank, Known
    from kousoku.model.records.scene import Scene

BLOCK = 65536
"""Divisions that are checked at once."""

ROUNDING_OF_DIVISIONS = 1e-9
"""Distance to a whole division, in divisions, within which a turning point counts as it."""


@dataclass(frozen=True, slots=True)
class Dyad:
    """A node held by two links, or a link and a slider: it exists where least ≤ distance ≤ most.

    Of two links that is |l_a − l_b| ≤ d ≤ l_a + l_b, from which (34) of Yamada and Tatsumi
    (1981) follows for a full turn of a four-bar; of a link and a slider it is 0 ≤ d ≤ l.

    Parameters
    ----------
    node : str
        The node.
    keys : tuple of str
        Keys of the links and the slider that hold it.
    distance : (n,) ndarray [unit of the scene]
        Between the known nodes, or from the known node to the line of the slider.
    least, most : float [unit of the scene]
        Range in which the dyad closes; a rod may lie on the line of its slider, so that its least
        distance is negative and never met.
    ends : tuple of str
        The known nodes.
    """

    node: str
    keys: tuple[str, ...]
    distance: np.ndarray
    least: float
    most: float
    ends: tuple[str, ...]


def check_closure(scene: Scene) -> tuple[str, ...]:
    """Check that dyads between known nodes close at every division and at the extremes of a crank.

    Returns
    -------
    tuple of str
        Where a dyad is just stretched or folded, so that its motion is not determined there.

    Raises
    ------
    SceneError
        A dyad certainly cannot close; the message holds the inequality in numbers, and the angles
        at which the crank stops.
    """
    check_circuits(scene)
    notes: dict[str, None] = {}
    turning_points = _turning_points(scene)
    # without turning points nothing is left: dyads between fixed nodes are checked in the blocks
    for ks in chain(_blocks(period(scene) + 1), [turning_points] * (len(turning_points) > 0)):
        known = known_nodes(scene, ks)
        for dyad in _dyads(scene, known):
            tolerance = max(scene.residual_limit, 64 * 2.0**-52 * _scale(dyad))
            outside = np.maximum(dyad.distance - dyad.most, dyad.least - dyad.distance)
            opened = np.flatnonzero(outside > tolerance)
            if opened.size:
                _refuse(scene, known, dyad, int(opened[0]), float(ks[opened[0]]))
            for index in np.flatnonzero(abs(outside) <= tolerance)[:1]:
                notes[_note(scene, dyad, float(ks[index]))] = None
    return tuple(notes)


def _blocks(n_rows: int) -> Iterator[np.ndarray]:
    """Blocks of divisions that are checked together, all divisions in turn."""
    for first in range(0, n_rows, BLOCK):
        yield np.arange(first, min(first + BLOCK, n_rows))


def _turning_points(scene: Scene) -> np.ndarray:
    """Crank positions with extreme distances of dyads at one crank, in fractional divisions.

    A crank that is stopped between two divisions is stopped all the same.
    """
    known, ks = known_nodes(scene, np.zeros(1)), []
    for dyad in _dyads(scene, known):
        cranks = [crank for crank in (known[end].crank for end in dyad.ends) if crank]
        fixed = [scene.nodes[end].at for end in dyad.ends if scene.nodes[end].fixed]
        if len(cranks) != 1 or len(dyad.ends) != 1 + len(fixed):
            continue
        if fixed:
            x, y = (b - a for a, b in zip(scene.nodes[cranks[0].center].at, *fixed, strict=True))
        else:
            dx, dy = scene.sliders[dyad.keys[1].partition(".")[2]].direction
            x, y = -dy, dx
        motion, angle = scene.inputs[cranks[0].input], atan2(y, x) - cranks[0].offset
        travel = travel_of(motion)
        for side in (angle, angle + tau / 2):
            turn = (side - motion.start) % copysign(tau, travel)
            if 0 < abs(turn) < abs(travel):
                ks.append(turn / travel * scene.divisions)
    return np.array([k for k in ks if abs(k - round(k)) > ROUNDING_OF_DIVISIONS])


def _scale(dyad: Dyad) -> float:
    return dyad.most + float(dyad.distance.max(initial=0.0))


def _dyads(scene: Scene, known: dict[str, Known]) -> Iterator[Dyad]:
    holders: dict[str, list[tuple[str, str]]] = {}
    for name, link in scene.links.items():
        for node in link.nodes:
            if node not in known and link.other(node) in known:
                holders.setdefault(node, []).append((name, link.other(node)))
    lines = {slider.node: (name, slider) for name, slider in scene.sliders.items()}
    for node, links in holders.items():
        (first, a), *rest = links
        for second, b in rest:
            l_a, l_b = scene.length(first), scene.length(second)
            distance = np.hypot(*(known[b].at - known[a].at))
            keys = (f"links.{first}", f"links.{second}")
            yield Dyad(node, keys, distance, abs(l_a - l_b), l_a + l_b, (a, b))
        if node in lines:
            name, slider = lines[node]
            (dx, dy), (x, y) = slider.direction, known[a].at
            offset = (x - slider.through[0]) * dy - (y - slider.through[1]) * dx
            distance = np.abs(offset) / hypot(dx, dy)
            keys = (f"links.{first}", f"sliders.{name}")
            rod = scene.length(first)
            yield Dyad(node, keys, distance, -rod, rod, (a,))


def _refuse(scene: Scene, known: dict[str, Known], dyad: Dyad, index: int, k: float) -> None:
    fixed = [end for end in dyad.ends if scene.nodes[end].fixed]
    distance, unit = float(dyad.distance[index]), scene.unit
    elements = " and ".join(dyad.keys)
    if len(fixed) == len(dyad.ends):
        raise SceneError(
            f"cannot be assembled: {elements} meet only where {_distance_text(dyad)} is "
            f"{_range_text(dyad)} {unit}, but it is {distance:.12g} {unit}",
            key=f"nodes.{dyad.node}",
        )
    cranks = [crank for crank in (known[end].crank for end in dyad.ends) if crank]
    reason = ""
    if len(cranks) == 1 and len(dyad.ends) == 1:
        reason = _slider_crank(scene, dyad, cranks[0])
    elif len(cranks) == 1 and fixed:
        reason = _four_bar(scene, dyad, cranks[0], fixed[0], distance)
    inputs = [crank.input for crank in cranks] or list(scene.inputs)
    key = f"inputs.{inputs[0]}" if cranks or len(inputs) == 1 else "inputs"
    raise SceneError(
        f"{reason}{elements} cannot close {_division_text(scene, k)}: {_distance_text(dyad)} is "
        f"{distance:.12g} {unit}, wanted {_range_text(dyad)} {unit}",
        key=key,
    )


def _four_bar(scene: Scene, dyad: Dyad, crank: Crank, end: str, distance: float) -> str:
    """Grashof's inequality (34) that does not hold, and where the crank stops."""
    origin, length = scene.nodes[crank.center].at, scene.length(crank.link)
    x, y = (b - a for a, b in zip(origin, scene.nodes[end].at, strict=True))
    frame = hypot(x, y)
    if frame == 0:
        return ""
    names = [key.partition(".")[2] for key in dyad.keys]
    lengths = [(name, scene.length(name)) for name in names]
    sides = [(crank.link, length), (_frame_name(scene, crank.center, end), frame)]
    if distance > dyad.most:
        left, right = sides, lengths
    else:
        lengths.sort(key=lambda side: side[1])
        sides.sort(key=lambda side: side[1])
        left, right = [sides[0], lengths[1]], [lengths[0], sides[1]]
    limit = dyad.most if distance > dyad.most else dyad.least
    cosine = (length**2 + frame**2 - limit**2) / (2 * length * frame)
    stops = [atan2(y, x) + sign * acos(cosine) for sign in (1, -1)] if abs(cosine) <= 1 else []
    return _crank_problem(crank, "Grashof's condition (34) ", left, right, stops)


def _slider_crank(scene: Scene, dyad: Dyad, crank: Crank) -> str:
    """Condition of a crank with an offset slider, and where the crank stops."""
    slider = scene.sliders[dyad.keys[1].partition(".")[2]]
    rod = dyad.keys[0].partition(".")[2]
    (dx, dy), (x, y) = slider.direction, scene.nodes[crank.center].at
    length = scene.length(crank.link)
    offset = ((x - slider.through[0]) * dy - (y - slider.through[1]) * dx) / hypot(dx, dy)
    sines = [(offset + sign * dyad.most) / length for sign in (1, -1)]
    line_angle = atan2(dy, dx)
    arcs = [asin(sine) for sine in sines if abs(sine) <= 1]
    stops = [line_angle + angle for arc in arcs for angle in (arc, tau / 2 - arc)]
    left = [(crank.link, length), ("offset", abs(offset))]
    return _crank_problem(crank, "", left, [(rod, dyad.most)], stops)


NamedLength = tuple[str, float]


def _crank_problem(
    crank: Crank, title: str, left: list[NamedLength], right: list[NamedLength], stops: list[float]
) -> str:
    """Message of the inequality left ≤ right that fails, with the angles where the crank stops."""
    names = " <= ".join(" + ".join(name for name, _ in side) for side in (left, right))
    numbers = " > ".join(" + ".join(f"{value:.12g}" for _, value in side) for side in (left, right))
    angles = " and ".join(
        f"{angle:.6g}" for angle in sorted((s - crank.offset) % tau for s in stops)
    )
    where = f", stops it at {crank.input} = {angles} rad" if stops else ", closes at no angle"
    return (
        f"the crank {crank.link!r} cannot make the motion: {title}{names} does not hold "
        f"({numbers}){where}; "
    )


def _frame_name(scene: Scene, first: str, second: str) -> str:
    for name, link in scene.links.items():
        if set(link.nodes) == {first, second}:
            return name
    return f"{first}{second}"


def _distance_text(dyad: Dyad) -> str:
    if len(dyad.ends) == 1:
        return f"the distance from {dyad.ends[0]} to the line"
    return f"the distance from {dyad.ends[0]} to {dyad.ends[1]}"


def _range_text(dyad: Dyad) -> str:
    return (
        f"{dyad.least:.12g} to {dyad.most:.12g}" if dyad.least >= 0 else f"at most {dyad.most:.12g}"
    )


def _division_text(scene: Scene, k: float) -> str:
    """Division `k`, which may be fractional, in words, with the values of the inputs there."""
    is_whole, low = float(k).is_integer(), floor(k)
    where = f"at division {low}" if is_whole else f"between divisions {low} and {low + 1}"
    return f"{where} ({_inputs_text(scene, k)})"


def _inputs_text(scene: Scene, k: float) -> str:
    values = (
        f"{name} = {float(input_values(motion, scene.divisions, np.array([k]))[0]):.6g}"
        for name, motion in scene.inputs.items()
    )
    return ", ".join(values)


def _note(scene: Scene, dyad: Dyad, k: float) -> str:
    moves = not all(scene.nodes[end].fixed for end in dyad.ends)
    where = f"{_division_text(scene, k)} " if moves else ""
    return (
        f"{where}{' and '.join(dyad.keys)} at {dyad.node} are stretched or folded: the motion is "
        "not determined there"
    )
