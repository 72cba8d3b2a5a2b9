"""The matrices of a scene as it is written: M v̇ + C_qᵀλ = f, C_q v̇ = γ, C_q v = ν.

Every body has its columns, δr of the origin of its frame in frame O and δθ′ in its own frame, and
every joint and driver its rows, those too that depend on others: nothing is merged, proven plane,
put onto a joint or left out. Lengths are in the unit of the scene, so that a force is in
kg unit/s² and a torque in kg unit²/s²; angles are in rad.
"""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kousoku.body_equations import equations_of
from kousoku.labels import is_turn
from kousoku.linkage_equations import LinkageEquations
from kousoku.model.errors import SolveError
from kousoku.runtime.design import nearly_redundant
from kousoku.runtime.integrate.body_tables import body_tables, solver_state, written_state
from kousoku.runtime.messages import listed, scene_key, shortly
from kousoku.runtime.run_ledger import violations_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    import numpy.typing as npt

    from kousoku.body_equations import CheckedState, EquationsAtState, SceneEquations
    from kousoku.model.numbers.real import Array
    from kousoku.model.records.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.run_ledger import Violation

#: Singular values below this part of the largest are zero where λ is solved for. At states of runs
#: of committed scenes zeros are 5e-16, of ``bricard`` with eight digits 9e-12; others 0.03 or more.
ZERO = 1e-9
#: Squared component of a row in the left null space of C_q above which its multiplier is not
#: unique: rounding leaves 2e-15 there, rows that depend on others have 0.03 or more.
NULL_PART = 1e-10
#: Largest residual of the forces with λ, and distance of a state from the solver's, as parts of the
#: largest force, of length and of speed: states of runs leave 5e-15, with eight digits 1e-11.
LARGEST_STATE_RESIDUAL = 1e-7
#: Speed at rest, in lengths of the scene a second: the least that gaps of velocities are compared
#: with. Without it rounding, 3e-16 in ``heavy_top``, would be compared with itself; rows come apart
#: only from the closure tolerance times this on, 1e-10.
REST_SPEED = 1e-6
#: Largest residual of rows in accelerations, as a part of the largest. Rounding leaves 1e-14, but
#: 3e-4 between masses of 1 and 1e-12 kg: these digits are lost, which runs win back.
MOST_LOST = 1e-9
#: Residual of forces in balance, as a part of the largest force: where a scene stands,
#: accelerations are rounding, whose digits are all lost.
BALANCED = 1e-9
#: Most rows or columns of a table in a notebook.
MOST_SHOWN = 30


@dataclass(frozen=True, eq=False)
class Matrices:
    """The matrices of a scene at a state; they unpack as ``M, C_q, nu, gamma, f``.

    Parameters
    ----------
    name : str
        The scene.
    time : float [s]
        Time of the state.
    C : (m,) array
        Residuals of all rows, in the order of :attr:`rows`.
    C_q : (m, n) array
        Jacobian, in the order of :attr:`columns`.
    nu, gamma : (m,) array
        Right sides of C_q v = ν and C_q v̇ = γ.
    rows : tuple of str
        Joint or driver of each row, kind, and component: those of ``point`` are in frame O, those
        of ``p1`` and ``p2`` in the principal frame of body i.
    columns : tuple of str
        Body and component of each column: ``x``, ``y``, ``z`` of the origin of the body frame, in
        frame O, ``theta_x`` … in the body frame.
    units : tuple of str
        Unit of the residual of each row.
    redundant : (m,) array of bool
        Rows that depend on the others wherever the scene moves. Of rows that depend on each other
        these can be left out; which of them is a choice.
    unknown : tuple of str
        Joints in a loop of so many rows that it is not known which of these are redundant.
    without : str
        Why there are no M and f; empty where there are.
    mass, force : array
        M and f, see there.
    """

    name: str
    time: float
    C: Array
    C_q: Array
    nu: Array
    gamma: Array
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    units: tuple[str, ...]
    redundant: npt.NDArray[np.bool_]
    unknown: tuple[str, ...]
    without: str
    mass: Array
    force: Array

    @property
    def M(self) -> Array:
        """Mass matrix about the origins of the body frames, (n, n).

        Raises
        ------
        SolveError
            The scene has no masses, or not all.
        """
        return self._dynamic(self.mass)

    @property
    def f(self) -> Array:
        """Applied forces less velocity forces: M v̇ + C_qᵀλ = f, (n,).

        Raises
        ------
        SolveError
            The scene has no masses, or not all.
        """
        return self._dynamic(self.force)

    def _dynamic(self, array: Array) -> Array:
        if self.without:
            raise SolveError(
                f"{self.name}: no M and no f: {self.without}; take C, C_q, nu and gamma by name"
            )
        return array

    def __iter__(self) -> Iterator[Array]:
        return iter((self.M, self.C_q, self.nu, self.gamma, self.f))

    def __repr__(self) -> str:
        m, n = self.C_q.shape
        redundant = [
            row for row, is_redundant in zip(self.rows, self.redundant, strict=True) if is_redundant
        ]
        masses = f"no M, no f: {self.without}" if self.without else f"M ({n}, {n}), f ({n},)"
        lines = [
            f"{self.name} at {self.time:.6g} s: C_q ({m}, {n}), C, nu, gamma ({m},), {masses}",
            f"  columns: {listed(self.columns)}",
            f"  rows: {listed(self.rows)}",
        ]
        if redundant:
            lines.append(f"  redundant: {listed(redundant)}")
        if self.unknown:
            lines.append(f"  not known whether redundant: rows of {listed(self.unknown)}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        m, n = self.C_q.shape
        if max(m, n) > MOST_SHOWN:
            return f"<pre>{escape(repr(self))}</pre>"

        def line(cells: Sequence[object], tag: str = "td") -> str:
            heading, *entries = (escape(str(cell)) for cell in cells)
            return f"<tr><th>{heading}</th>{''.join(f'<{tag}>{x}</{tag}>' for x in entries)}</tr>"

        table = [line(["C_q", *self.columns, "C", "ν", "γ"], "th")]
        numbers = np.column_stack([self.C_q, self.C, self.nu, self.gamma])
        for row, is_redundant, values in zip(self.rows, self.redundant, numbers, strict=True):
            cells = ["" if x == 0 else f"{x:.4g}" for x in values.tolist()]
            table.append(line([f"{row} (redundant)" if is_redundant else row, *cells]))
        return f"<p>{escape(self.name)} at {self.time:.6g} s</p><table>{''.join(table)}</table>"


class Evaluation(NamedTuple):
    """Accelerations and multipliers of a scene as it is written.

    Parameters
    ----------
    v_dot : (n,) array
        In the order of ``columns``: r̈ of the origins of the body frames, in frame O, and dω′/dt.
    lam : (m,) array
        Multipliers of all rows, in the order of ``rows``; the shortest that there are where they
        are not unique, torques divided by a length of the scene.
    is_unique : (m,) array of bool
        Whether the multiplier of a row follows from the motion.
    rows, columns : tuple of str
        As of :class:`Matrices`.
    violations : mapping of str to Violation
        Residuals of each joint and driver at the state, and with these accelerations.
    notes : tuple of str
        Which of them are open, or come apart, by more than the scene's closure tolerance: what is
        computed there keeps gaps from accelerating, and is no motion of the scene. And that digits
        of accelerations are lost, as between very unequal masses.
    """

    v_dot: Array
    lam: Array
    is_unique: npt.NDArray[np.bool_]
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    violations: Mapping[str, Violation]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        """Sizes, rows that are not unique, and notes."""
        ambiguous = [
            row for row, is_unique in zip(self.rows, self.is_unique, strict=True) if not is_unique
        ]
        text = f"v_dot ({len(self.v_dot)},), lam ({len(self.lam)},)"
        text = f"{text}; not unique: {listed(ambiguous)}" if ambiguous else text
        return "\n".join([text, *self.notes])


def matrices(
    scene: Scene,
    t: float,
    q: npt.ArrayLike,
    v: npt.ArrayLike,
    parameters: Mapping[str, float | str] | None = None,
    *,
    angles: Mapping[str, float] | None = None,
) -> Matrices:
    """Matrices of a scene as it is written, at any state.

    Parameters
    ----------
    scene : Scene
        A checked scene.
    t : float [s]
        When.
    q : array
        For each body of the scene r (3) of the origin of its frame, in frame O and the unit of the
        scene, then its Euler parameters (4), scalar first and of any norm, unless it is a point; of
        a linkage x and y of each node.
    v : array
        For each body ṙ (3) in frame O, then ω′ (3) [rad/s] in its own frame, unless it is a point;
        of a linkage the velocity of each node.
    parameters : mapping of str to float or str, optional
        Those that are not as in the scene.
    angles : mapping of str to float [rad], optional
        Positions tell an angle up to whole turns only. Those of coordinates that stand here are
        counted to within half a turn of these values; those that drivers prescribe to within half
        a turn of that; all others to within half a turn of what they are at the start.

    Raises
    ------
    SolveError
        A number, parameter or angle is not possible.
    SceneError, AssemblyError
        The bodies of the scene do not fit together.
    """
    if not scene.is_spatial:
        return _linkage_matrices(scene, t, q, v, parameters or angles)
    equations = equations_of(scene)
    numbers, state = equations.numbers(equations.state(t, q, v, parameters, angles))
    return _scene_matrices(equations, numbers, state)


def evaluate(
    scene: Scene,
    solver: DynamicsSolver,
    t: float,
    q: npt.ArrayLike,
    v: npt.ArrayLike,
    parameters: Mapping[str, float | str] | None = None,
    *,
    angles: Mapping[str, float] | None = None,
) -> Evaluation:
    """Accelerations that a solver computes, and the multipliers of all rows.

    Nothing is put onto the constraints: C_q v̇ = γ holds at any state, also where joints are open,
    which the result tells.

    Parameters
    ----------
    scene : Scene
        The scene of the solver.
    solver : DynamicsSolver
        Solver of the accelerations; the state must be one that it can have.
    t, q, v, parameters, angles
        As of :func:`matrices`.

    Raises
    ------
    SolveError
        A number, parameter or angle is not possible; or the state contradicts what the solver was
        built on, such as a plane that it moves in; or the equations do not hold there.
    """
    equations = equations_of(scene)
    numbers, state = equations.numbers(equations.state(t, q, v, parameters, angles))
    terms = _scene_matrices(equations, numbers, state)
    v_dot = _accelerations(equations, solver, state)
    lam, is_unique = _multipliers(terms, terms.M @ v_dot, equations.length)
    scales = np.array([equations.unit if unit == "m" else 1.0 for _, unit in equations.checked])
    residuals = (terms.C, terms.C_q @ state.v - terms.nu, terms.C_q @ v_dot - terms.gamma)
    violations = violations_of(scales * np.abs(residuals), equations.checked)
    speeds = scales * (np.abs(terms.C_q) @ np.abs(state.v) + np.abs(terms.nu))
    notes = (*_gaps(equations, violations, speeds), *_redundancy(solver, state))
    notes = notes or (*_lost_digits(terms, v_dot, residuals[2], equations.length),)
    return Evaluation(v_dot, lam, is_unique, terms.rows, terms.columns, violations, notes)


def _gaps(
    equations: SceneEquations, violations: Mapping[str, Violation], speeds: Array
) -> Iterator[str]:
    """Notes on joints that are open at a state, and on joints that come apart.

    Velocities are compared with the largest of ``speeds``, the sizes of the terms of each row
    [m/s, rad/s].
    """
    length = equations.length * equations.unit
    arms = [1.0 if unit == "m" else length for _, unit in equations.checked]
    speed = max((speeds * arms).max(initial=0.0), REST_SPEED * length) / length
    texts = ("joints are open", ""), ("joints come apart", "/s")
    for k, ((defect, per), size) in enumerate(zip(texts, (1.0, speed), strict=True)):
        relative = {
            name: max(violation.metres[k] / length, violation.radians[k])
            for name, violation in violations.items()
        }
        limit = equations.system.closure_tolerance * size
        excessive = sorted(
            (joint for joint in relative if relative[joint] > limit),
            key=lambda joint: -relative[joint],
        )
        gaps = [
            f"{scene_key(name)} by "
            + " and ".join(
                f"{shortly(gap, 3)} {unit}{per}"
                for gap, unit in ((violation.metres[k], "m"), (violation.radians[k], "rad"))
                if gap > limit * (length if unit == "m" else 1.0)
            )
            for name in excessive
            if (violation := violations[name])
        ]
        if gaps:
            yield f"{equations.name}: at this state {defect}: {listed(gaps)}"


def _lost_digits(terms: Matrices, v_dot: Array, residual: Array, length: float) -> Iterator[str]:
    """Note on lost digits of accelerations, by the residual of rows that are not redundant."""
    arms, columns = _arms(terms, length)
    force, mass, size, demand = (
        np.abs(values).max(initial=0.0)
        for values in (
            terms.f / columns,
            np.diagonal(terms.M) / columns**2,
            columns * v_dot,
            arms * terms.gamma,
        )
    )
    size = max(size, demand)
    lost = np.abs(arms * residual)[~terms.redundant].max(initial=0.0)
    if lost > MOST_LOST * size and lost * mass > BALANCED * force:
        yield (
            f"{terms.name}: at this state digits of accelerations are lost: constraints ask for"
            f" others, by {lost / size:.1e} of the largest; a run wins these digits back"
        )


def _redundancy(solver: DynamicsSolver, state: CheckedState) -> Iterator[str]:
    """Note on rows of the solver that are nearly redundant with other parameters."""
    if state.parameters == dict((solver.base or solver).parameters):
        return
    if why := nearly_redundant(solver, np.array([*state.parameters.values()])):
        yield f"{solver.name}: {why}"


def _linkage_matrices(
    scene: Scene, t: float, q: npt.ArrayLike, v: npt.ArrayLike, extras: object
) -> Matrices:
    """Matrices of a linkage, which has no masses."""
    if extras:
        raise SolveError(f"{scene.name}: a linkage of nodes has no parameters, and counts no turns")
    equations = LinkageEquations(scene)
    rows = equations.at(t, q, v)
    n = len(equations.columns)
    return Matrices(
        scene.name,
        float(t),
        C=np.array([row.C for row in rows]),
        C_q=np.array([row.C_q for row in rows]).reshape(-1, n),
        nu=np.array([row.nu for row in rows]),
        gamma=np.array([row.gamma for row in rows]),
        rows=tuple(row.label for row in rows),
        columns=equations.columns,
        units=tuple(row.unit for row in rows),
        redundant=np.zeros(len(rows), bool),
        unknown=(),
        without="a linkage of nodes has no masses",
        mass=np.zeros((n, n)),
        force=np.zeros(n),
    )


def _scene_matrices(
    equations: SceneEquations, numbers: EquationsAtState, state: CheckedState
) -> Matrices:
    """Matrices with the names of rows and columns."""
    return Matrices(
        equations.name,
        state.time,
        *(numbers.C, numbers.C_q, numbers.nu, numbers.gamma),
        rows=equations.rows,
        columns=equations.columns,
        units=equations.units,
        redundant=equations.redundant,
        unknown=equations.unknown,
        without=equations.lacks,
        mass=numbers.M,
        force=numbers.f,
    )


def _accelerations(equations: SceneEquations, solver: DynamicsSolver, state: CheckedState) -> Array:
    """Accelerations v̇ by a solver, in the columns of the scene as it is written."""
    adapted = solver.at(state.parameters)
    q, v = solver_state(adapted.bodies, state.q, state.v, adapted.unit, (adapted.q, adapted.v))
    first, names = equations.turning(solver)
    for k, name in enumerate(names, first):
        q[k] = state.near.get(name, q[k])
    _require_reachable(equations, state, written_state(adapted.bodies, q, v, adapted.unit))
    outputs = adapted.evaluate(state.time, q, v, state.parameters)
    tables = body_tables(
        adapted.bodies, q[np.newaxis], v[np.newaxis], outputs["v_dot"][np.newaxis], adapted.unit
    )
    linear, angular = tables["acceleration"], tables.get("angular_acceleration", {})
    blocks = [
        table[body.name][0]
        for body in adapted.bodies
        for table in (linear, angular)
        if body.name in table
    ]
    return np.concatenate([np.zeros(0), *blocks])


def _arms(terms: Matrices, length: float) -> tuple[Array, Array]:
    """Lever arms of rows and of columns: a length of the scene for angles, 1 for lengths."""
    rows = np.array([length if unit == "rad" else 1.0 for unit in terms.units])
    columns = np.array([length if is_turn(name) else 1.0 for name in terms.columns])
    return rows, columns


def _multipliers(
    terms: Matrices, inertia: Array, length: float
) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Shortest λ with C_qᵀλ = f − M v̇, and which of its elements are unique."""
    rows, arms = _arms(terms, length)
    columns = 1 / arms
    scaled = rows[:, np.newaxis] * terms.C_q * columns
    load = columns * (terms.f - inertia)
    u, sigma, vt = np.linalg.svd(scaled, full_matrices=False)
    rank = int((sigma > ZERO * sigma.max(initial=0.0)).sum())
    lam = u[:, :rank] @ ((vt[:rank] @ load) / sigma[:rank])
    size = max(np.abs(columns * x).max(initial=0.0) for x in (terms.f, inertia))
    residual = np.abs(scaled.T @ lam - load).max(initial=0.0)
    if residual > LARGEST_STATE_RESIDUAL * size:
        raise SolveError(
            f"{terms.name}: at this state the accelerations of the solver leave {residual:.3g} of"
            f" forces up to {size:.3g}, which no multipliers of its rows balance: joints are open,"
            " or their velocities do not fit; give a state of a run"
        )
    null_part = 1.0 - (u[:, :rank] ** 2).sum(axis=1)  # in the left null space
    return rows * lam, null_part < NULL_PART


def _require_reachable(
    equations: SceneEquations, state: CheckedState, reachable: tuple[Array, Array]
) -> None:
    """Refuse a state that the solver cannot take, as one out of its plane."""
    length = equations.length + float(np.abs(state.q).max(initial=0.0))
    speed = length + float(np.abs(state.v).max(initial=0.0))
    for wanted, nearest, size, starts in (
        (state.q, reachable[0], length, equations.starts[0]),
        (state.v, reachable[1], speed, equations.starts[1]),
    ):
        for body, first, end in zip(equations.bodies, starts, starts[1:], strict=False):
            asked, solved = wanted[first:end], nearest[first:end]
            gap = np.abs(asked - solved)
            if wanted is state.q:  # p and −p are one orientation
                gap[3:] = np.minimum(gap[3:], np.abs(asked + solved)[3:])
            if gap.max() > LARGEST_STATE_RESIDUAL * size:
                raise SolveError(
                    f"{equations.name}: body {body.name!r} is {gap.max():.3g} from where the solver"
                    " can have it: it moves in a plane, or with a body that it is joined to"
                    " rigidly; give a state of a run"
                )
