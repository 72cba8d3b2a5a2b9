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

#: Kernel that a report names for these rows.
KERNEL = "newton_euler"
#: Disturbance of a state off its joints before it is corrected, in metres and radians, and part of
#: its residuals that the correction may leave: their square, where Newton's method converges.
DISTURBANCE, LARGEST_REMAINDER = 2.0**-20, 0.1


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
            largest = worst.get(row.output)
            if largest is None or not row.worst <= largest.worst:
                worst[row.output] = row
    yield from worst.values()


def _rows_at(solver: DynamicsSolver, number: int, point: Mapping[str, Any]) -> Iterator[Row]:
    q, v = (np.array(point[name], dtype=np.float64) for name in ("q", "v"))
    outputs = solver.evaluate(point["time"], q, v)
    layout = solver.at({}).layout
    computed = dict(_computed(layout, outputs, q, v))
    share = _remainder(solver, point["time"], q, v) / LARGEST_REMAINDER
    computed["move"] = [("", share * 4.0 * point["values"]["move"]["unit"])]
    for name, record in point["values"].items():
        references: dict[str, list[float | None]] = {}
        for owner, reference in zip(record["names"], record["high"], strict=True):
            references.setdefault(owner, []).append(reference)
        compared = [
            (owner, value, reference)
            for owner, numbers in _by_owner(computed.get(name, [])).items()
            for value, reference in zip(
                numbers, references.get(owner, [np.nan] * len(numbers)), strict=True
            )
            if reference is not None and not (np.isnan(value) and name in {"force", "moment"})
        ]
        if not compared:
            continue
        errors = [abs(value - reference) for _, value, reference in compared]
        element = int(np.argmax(np.where(np.isnan(errors), np.inf, errors)))
        owner, value, reference = compared[element]
        size, unit = errors[element], record["unit"]
        error = size / unit if unit else np.inf if size else 0.0
        yield Row(
            kernel=KERNEL,
            output=name,
            way=NAMES[solver.target.name],
            worst=float(np.inf if np.isnan(error) else error),
            element=(element,),
            point=number,
            label=point["label"] + (f", {owner}" if owner else ""),
            inputs=(("time", repr(point["time"])),),
            got=float(value),
            wanted=float(reference),
        )


def _remainder(solver: DynamicsSolver, time: float, q: Array, v: Array) -> float:
    """Residuals after a correction of a disturbed state, as a part of those before, but rounding.

    A correction before it moves the bodies that are put onto their joints.
    """
    beside = q + DISTURBANCE * np.cos(np.arange(1.0, len(q) + 1.0)) * np.maximum(1.0, np.abs(q))
    for body in solver.at({}).layout.bodies:  # turns leave Euler parameters of norm one
        indices = [k for k in body.p if isinstance(k, int)]
        beside[indices] -= q[indices] * (q[indices] @ (beside - q)[indices])
    residuals = []
    for _ in range(3):
        outputs = solver.evaluate(time, beside, v)
        residuals.append(_largest([outputs["C"]]))
        beside = outputs["q_moved"]
    rounding = DISTURBANCE**2 * max(1.0, float(np.abs(q).max(initial=0.0)))
    return residuals[2] / max(residuals[1], rounding)


def _by_owner(numbers: Numbers) -> dict[str, list[float]]:
    by_owner: dict[str, list[float]] = {}
    for owner, x in numbers:
        by_owner.setdefault(owner, []).append(float(x))
    return by_owner


def _computed(
    layout: Layout, outputs: Mapping[str, Array], q: Array, v: Array
) -> Iterator[tuple[str, Numbers]]:
    """Results of a solver, by the names of the reference, in SI units."""
    tables = body_tables(
        layout.bodies, q[np.newaxis], v[np.newaxis], outputs["v_dot"][np.newaxis], 1
    )
    for name in ("acceleration", "angular_acceleration"):
        table = tables.get(name, {})
        yield name, [(body, x) for body, rows in table.items() for x in rows[0]]
    for k, name in enumerate(("coordinate", "coordinate_rate", "coordinate_acceleration")):
        columns = [
            (coordinate, indices[k])
            for coordinate, _, indices in layout.coordinates
            if k < len(indices)
        ]
        yield name, [(coordinate, outputs["coordinates"][index]) for coordinate, index in columns]
    if "energies" in outputs:
        yield "energy", [*zip(("kinetic", "potential"), outputs["energies"], strict=True)]
    yield "momenta", [("", x) for x in outputs.get("momenta", ())]
    yield "power", [(name, outputs["q_dot"][index]) for name, index in layout.works]
    for name, parts in (("C", ("C", "C_left_out")), ("C_dot", ("C_dot",)), ("C_ddot", ("C_ddot",))):
        yield name, [("", _largest([outputs[part] for part in parts if part in outputs]))]
    if "measures" in outputs:
        yield "measure", [("", x) for x in outputs["measures"]]
    yield "dq", [("", _largest([outputs["dq"]]))]
    yield "dv", [("", _largest([outputs["dv"]]))]
    yield "q_moved", [("", _largest([outputs["q_moved"] - q]))]
    if "reactions" in outputs:
        forces = [*_wrenches(layout, q, outputs["reactions"])]
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
