"""Numbers of a scene that depend on parameters: their values with those of a run.

``motion.json`` has an index in place of each; the solver computes them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.model.errors import SolveError
from kousoku.runtime.dynamics_targets import Memory
from kousoku.runtime.integrate.nearly_dependent import nearly_dependent
from kousoku.runtime.integrate.settings import Status
from kousoku.runtime.messages import MOST_PARTS_SHOWN, listed, scene_key

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.integrate.arithmetic import Array


#: Singular values, and shares of rows, below this part are zero.
INDEPENDENT = 1e-9


@dataclass(frozen=True, slots=True)
class DesignPlaces:
    """Places of the numbers of a scene that depend on parameters.

    Parameters
    ----------
    place : (int, int)
        First index in the workspace, and count.
    start : tuple of (int, int)
        Indices in (q, v), and among the numbers, of what parameters change at the start.
    positive : tuple of (str, int)
        Keys of the scene whose numbers must be positive, and their indices.
    """

    place: tuple[int, int]
    start: tuple[tuple[int, int], ...]
    positive: tuple[tuple[str, int], ...]

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> DesignPlaces:
        """Places from ``motion.json``."""
        base, size = data["place"]
        return cls(
            (base, size),
            tuple((column, index) for column, index in data["start"]),
            tuple((name, index) for name, index in data["positive"]),
        )

    def problems(self, numbers: Array) -> Iterator[str]:
        """Problems with the numbers (n,) of the design, in SI units."""
        for name, index in self.positive:
            if not numbers[index] > 0.0:
                yield f"{name} is {numbers[index]:.6g}; wanted a positive number"
        if not np.isfinite(numbers).all():
            yield "a formula of the scene has no finite value; wanted parameters for which it has"


def with_parameters(solver: DynamicsSolver, values: Array) -> DynamicsSolver:
    """Solver with the start, bodies and joints that follow from some parameters.

    Parameters
    ----------
    solver : DynamicsSolver
        A scene as it was loaded, or with other parameters.
    values : (n,) array
        All parameters, in the order of the scene and in their units.

    Raises
    ------
    SolveError
        A number of the scene is not possible with them; the message has its key.
    """
    if solver.base is not None:
        current = np.array([value for _, value in solver.parameters])
        if np.array_equal(values, current):
            return solver
        solver = solver.base
    design = solver.design
    if design is None:
        return solver
    work = np.zeros(solver.target.work_size)
    solver.target.evaluate(0.0, solver.q, solver.v, values, work)
    base, size = design.place
    numbers = work[base : base + size]
    if problems := list(design.problems(numbers)):
        listed = "; ".join(dict.fromkeys(problems))
        raise SolveError(f"{solver.name}: with {parameters_text(solver, values)}: {listed}")
    state = np.concatenate([solver.q, solver.v])
    for column, index in design.start:
        state[column] = numbers[index]
    count = len(solver.q)
    return replace(
        solver,
        q=state[:count],
        v=state[count:],
        layout=solver.layout.at(numbers),
    )


def not_closed(solver: DynamicsSolver, work: Array, times: float) -> str:
    """Joints that are open, at rows that are left out or where these took over.

    Parameters
    ----------
    solver : DynamicsSolver
        A scene.
    work : (work_size,) array
        Workspace in which its solver evaluated the rows [m, rad].
    times : float [-]
        Largest residual of a closed joint, in closure tolerances.
    """
    rows, limit = solver.checked, times * solver.layout.closure_tolerance
    base, _ = solver.places.get("C", solver.places["C_left_out"])
    sizes = np.abs(work[base : base + len(rows)])
    worst: dict[str, str] = {}
    for k in np.argsort(-sizes).tolist():
        joint, unit = rows[k]
        if not sizes[k] <= limit * (solver.length if unit == "m" else 1.0):
            worst.setdefault(joint, f"{scene_key(joint)} by {sizes[k]:.3g} {unit}")
    return ", ".join(list(worst.values())[:MOST_PARTS_SHOWN])


def loops_that_open(solver: DynamicsSolver, values: Array) -> str:
    """Rows of loops that depend on others with the parameters of the scene only.

    Each is told by the row that is left out, by how much it misses for each length or radian that
    bodies move as the rows allow that are kept, and by the joints whose rows implied it: |N c| of
    its row c (nv,) of C_q, with N by rows an orthonormal basis of what the rows kept allow.

    Parameters
    ----------
    solver : DynamicsSolver
        A scene.
    values : (n,) array
        All parameters, in the order of the scene and in their units.
    """
    scene = solver if solver.base is None else solver.base
    rows, count = solver.checked, len(solver.rows)
    units = np.array([solver.length if unit == "m" else 1.0 for _, unit in rows])
    nominal = np.array([value for _, value in scene.parameters])
    before = _rates_of_rows(scene, nominal) / units[:, np.newaxis]
    after = _rates_of_rows(with_parameters(scene, values), values) / units[:, np.newaxis]
    if not (np.isfinite(before).all() and np.isfinite(after).all()):
        return ""
    _, sizes, moves = np.linalg.svd(after[:count])
    free = moves[np.count_nonzero(sizes > INDEPENDENT * sizes.max(initial=0.0)) :]
    open_joints: dict[str, str] = {}
    for k in range(count, len(rows)):
        joint, unit = rows[k]
        missed = units[k] * float(np.linalg.norm(free @ after[k]))
        if missed <= solver.layout.closure_tolerance * units[k]:
            continue
        shares = np.linalg.lstsq(before[:count].T, before[k], rcond=INDEPENDENT)[0]
        implying = [rows[n][0] for n in np.flatnonzero(np.abs(shares) > INDEPENDENT).tolist()]
        loop = listed(list(dict.fromkeys(map(scene_key, [joint, *implying]))))
        open_joints.setdefault(
            joint, f"{scene_key(joint)} by {missed:.3g} {unit} in the loop of {loop}"
        )
    return ", ".join(list(open_joints.values())[:MOST_PARTS_SHOWN])


def _rates_of_rows(solver: DynamicsSolver, values: Array) -> Array:
    """Jacobian C_q of all rows at the start, by velocities relative to the length of the scene."""
    from kousoku.runtime.integrate.body_tables import indices
    from kousoku.runtime.integrate.start_evaluation import evaluated, rates_of_rows

    target, sizes = solver.target, np.ones(len(solver.v))
    for body in solver.layout.bodies:
        sizes[indices(body.v)] = solver.length
    evaluate = evaluated(target.evaluate, values, target.work_size, solver.places)
    return rates_of_rows(evaluate, solver.q, sizes).T


def nearly_redundant(solver: DynamicsSolver, values: Array) -> str:
    """Reason why no run starts with parameters with which rows nearly depend on each other.

    Parameters
    ----------
    solver : DynamicsSolver
        A scene.
    values : (n,) array
        All parameters, in the order of the scene and in their units.

    Returns
    -------
    str
        Empty where rows are independent.
    """
    adapted, target = with_parameters(solver, values), solver.target
    memory = Memory(np.zeros(target.state_size), np.zeros(target.work_size))
    if target.starter(0.0, adapted.q, adapted.v, values, memory)() != Status.DEPENDENT:
        return ""
    name, tolerance = f"with {parameters_text(solver, values)}", solver.layout.closure_tolerance
    return nearly_dependent(name, solver.checked, solver.places, memory.work, tolerance)


def parameters_text(solver: DynamicsSolver, values: Array) -> str:
    """Parameters and their values (n,) in one line, each in its unit."""
    pairs = zip(solver.parameters, values, strict=True)
    return ", ".join(f"{name} = {value:.6g}" for (name, _), value in pairs)
