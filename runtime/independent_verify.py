"""Compare what a solver of a scene of bodies computes with each body's own equations.

The numbers are those of ``independent`` in ``reference.json.gz``: accelerations of all bodies of
the scene, forces and moments of joints and drivers, energies, powers, momenta and coordinates, at
states that are on all joints. They were found without what the solver was composed of.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.runtime.integrate.body_tables import body_tables
from kousoku.runtime.report import Row
from kousoku.runtime.solver_verify import NAMES

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.integrate.arithmetic import Array
    from kousoku.runtime.integrate.motion import Layout

    Numbers = list[tuple[str, float]]

#: What is said of such a row.
KERNEL = "newton_euler"
#: How far beside its joints a state is that is corrected, in metres and radians, and which part of
#: its residuals that may leave: the square of them, where Newton's method leads onto the joints.
OFF, MOST_LEFT_OPEN = 2.0**-20, 0.1


def independent_rows(solver: DynamicsSolver, points: Sequence[Mapping[str, Any]]) -> Iterator[Row]:
    """Worst error of each sort of numbers over all states, of M v̇ + C_qᵀλ = f and C_q v̇ = γ.

    SI units: r̈ (3,) of bodies in frame O and ω̇′ (3,) in their frames, coordinates, energies [J],
    powers [W], momenta, and force [N] and moment [N m] of joints about the origin of frame O.

    Parameters
    ----------
    solver : DynamicsSolver
        A scene.
    points : sequence
        Its states, and what it must compute there.
    """
    worst: dict[str, Row] = {}
    for number, point in enumerate(points):
        for row in _rows_at(solver, number, point):
            known = worst.get(row.output)
            if known is None or not row.worst <= known.worst:
                worst[row.output] = row
    yield from worst.values()


def _rows_at(solver: DynamicsSolver, number: int, point: Mapping[str, Any]) -> Iterator[Row]:
    q, v = (np.array(point[name], dtype=np.float64) for name in ("q", "v"))
    found = solver.evaluate(point["time"], q, v)
    layout = solver.at({}).layout
    computed = dict(_computed(layout, found, q, v))
    part = _left_open(solver, point["time"], q, v) / MOST_LEFT_OPEN
    computed["move"] = [("", part * 4.0 * point["values"]["move"]["unit"])]
    for name, wanted in point["values"].items():
        known: dict[str, list[float | None]] = {}
        for owner, high in zip(wanted["names"], wanted["high"], strict=True):
            known.setdefault(owner, []).append(high)
        compared = [
            (owner, got, high)
            for owner, numbers in _by_owner(computed.get(name, [])).items()
            for got, high in zip(numbers, known.get(owner, [np.nan] * len(numbers)), strict=True)
            if high is not None and not (np.isnan(got) and name in {"force", "moment"})
        ]
        if not compared:
            continue
        errors = [abs(got - high) for _, got, high in compared]
        element = int(np.argmax(np.where(np.isnan(errors), np.inf, errors)))
        owner, got, high = compared[element]
        size, unit = errors[element], wanted["unit"]
        units = size / unit if unit else np.inf if size else 0.0
        yield Row(
            kernel=KERNEL,
            output=name,
            way=NAMES[solver.target.name],
            worst=float(np.inf if np.isnan(units) else units),
            element=(element,),
            point=number,
            label=point["label"] + (f", {owner}" if owner else ""),
            inputs=(("time", repr(point["time"])),),
            got=float(got),
            wanted=float(high),
        )


def _left_open(solver: DynamicsSolver, time: float, q: Array, v: Array) -> float:
    """Residuals that a correction leaves beside a state, as a part of those before, but rounding.

    Before it bodies are moved that are put onto their joints.
    """
    beside = q + OFF * np.cos(np.arange(1.0, len(q) + 1.0)) * np.maximum(1.0, np.abs(q))
    for body in solver.at({}).layout.bodies:  # turns leave Euler parameters of norm one
        own = [k for k in body.p if isinstance(k, int)]
        beside[own] -= q[own] * (q[own] @ (beside - q)[own])
    left = []
    for _ in range(3):
        found = solver.evaluate(time, beside, v)
        left.append(_largest([found["C"]]))
        beside = found["q_moved"]
    rounding = OFF**2 * max(1.0, float(np.abs(q).max(initial=0.0)))
    return left[2] / max(left[1], rounding)


def _by_owner(numbers: Numbers) -> dict[str, list[float]]:
    found: dict[str, list[float]] = {}
    for owner, x in numbers:
        found.setdefault(owner, []).append(float(x))
    return found


def _computed(
    layout: Layout, found: Mapping[str, Array], q: Array, v: Array
) -> Iterator[tuple[str, Numbers]]:
    """Results of a solver, by the names of the reference, in SI units."""
    tables = body_tables(layout.bodies, q[np.newaxis], v[np.newaxis], found["v_dot"][np.newaxis], 1)
    for name in ("acceleration", "angular_acceleration"):
        table = tables.get(name, {})
        yield name, [(body, x) for body, rows in table.items() for x in rows[0]]
    for k, name in enumerate(("coordinate", "coordinate_rate", "coordinate_acceleration")):
        own = [(one, places[k]) for one, _, places in layout.coordinates if k < len(places)]
        yield name, [(one, found["coordinates"][place]) for one, place in own]
    if "energies" in found:
        yield "energy", [*zip(("kinetic", "potential"), found["energies"], strict=True)]
    yield "momenta", [("", x) for x in found.get("momenta", ())]
    yield "power", [(name, found["q_dot"][place]) for name, place in layout.works]
    for name, part in (("C", ("C", "C_left_out")), ("C_dot", ("C_dot",)), ("C_ddot", ("C_ddot",))):
        yield name, [("", _largest([found[one] for one in part if one in found]))]
    if "measures" in found:
        yield "measure", [("", x) for x in found["measures"]]
    yield "dq", [("", _largest([found["dq"]]))]
    yield "dv", [("", _largest([found["dv"]]))]
    yield "q_moved", [("", _largest([found["q_moved"] - q]))]
    if "reactions" in found:
        forces = [*_wrenches(layout, q, found["reactions"])]
        yield "force", [(name, x) for name, force, _ in forces for x in force]
        yield "moment", [(name, x) for name, _, moment in forces for x in moment]


def _largest(arrays: Sequence[Array]) -> float:
    numbers = np.concatenate([np.zeros(1), *arrays])
    return float(np.abs(numbers).max())


def _wrenches(layout: Layout, q: Array, reactions: Array) -> Iterator[tuple[str, Array, Array]]:
    """Name, force, and moment about the origin of frame O, of each joint and driver."""
    for joint in layout.reactions:
        force, torque = layout.of_joint(joint, q[np.newaxis], reactions[np.newaxis])
        point = layout.point_of(joint, q[np.newaxis])
        yield joint.joint, force[0], torque[0] + np.cross(point.T[0], force[0])
