"""Motion of a scene at a few states, by :mod:`.newton_euler`, to compare its solver with.

States are those that the solver can have: its start, and some beside it that move, brought onto all
joints and drivers of the scene. There M v̇ + C_qᵀλ = f, C_q v̇ = γ is solved for the separate
bodies, with residuals in 50 digits. Forces of joints that are not unique are left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.codegen.dynamics.checking.newton_euler import (
    BodyState,
    ConstraintRow,
    NewtonEulerEquations,
    quaternion_product,
    rotated,
    rotated_back,
)
from kousoku.codegen.sha256_random import Sha256Random
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.numbers.digits import HIGH
from kousoku.model.operations.arithmetic import FLOAT

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from kousoku.codegen.dynamics.checking.newton_euler import AppliedForces
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.real import Array, Real
    from kousoku.model.operations.arithmetic import FormulaArithmetic
    from kousoku.runtime.integrate.body_tables import BodyPlaces
    from kousoku.runtime.integrate.motion import Layout

#: Distances of states from the start, relative to the length of the scene or a radian, and their
#: times [s], in the order in which they are tried.
TRIALS = ((2.0**-5, 0.3), (2.0**-6, 0.04), (2.0**-8, 2.0**-8), (2.0**-12, 2.0**-12), (0.0, 0.0))
#: Count of moving states that are wanted beside the start.
MOVING_STATES = 1
#: Singular values that count as zero, and the least other one of a state, relative to the largest.
STATE_RANK_TOLERANCE, LEAST_SINGULAR_VALUE = 1e-10, 1e-4
#: Newton steps onto the constraints at most, and the residual that may remain.
MOST_CLOSING_STEPS, CLOSING_TOLERANCE = 20, 1e-13
#: Steps of iterative refinement: the residuals have 50 digits, the factors are doubles.
REFINEMENTS = 4
#: Change of a unique result along a null direction at most, relative to the terms of its sum.
UNIQUE_CHANGE = 1e-7
#: Angles further than this [rad] from the one that their turns count to may have another turn.
MOST_ANGLE_DIFFERENCE = 2.5
#: Unit of error at a condition of one, relative to the largest number of a quantity.
UNIT = 2.0**-42
#: Relative step of a state in differences of forces that tell how steep they are, and the least
#: speed that it is relative to, in sizes per second.
STEEPNESS_STEP, LEAST_SPEED = 2.0**-30, 1e-3
#: Numbers below this part of their unit of error are rounding of 50 digits, which changes with the
#: factors in doubles: they count as zero.
NEGLIGIBLE_ERROR = 2.0**-40


class _UnsuitableError(Exception):
    """Nothing can be compared at a state."""


@dataclass(frozen=True, slots=True)
class MeasureSource:
    """Coordinate of a state, or elongation of a spring, that a formula reads.

    Parameters
    ----------
    coordinate, force : int
        Index of the one that is read; the other is -1.
    is_length : bool
        Whether it is the distance of the spring's ends.
    unit : float
        Unit of a coordinate in the formula [m or rad].
    """

    coordinate: int
    force: int
    is_length: bool
    unit: float


@dataclass(frozen=True, slots=True)
class ComparedSolver:
    """Solver that is compared: its scene and its coordinates, none of its results.

    Parameters
    ----------
    system : System
        The scene after assembly, before anything is simplified, its numbers fixed.
    layout : Layout
        Indices of the bodies in q and v of the solver.
    q, v : array (n,) [m, -], (m,) [m/s, rad/s]
        Its start.
    turned_angles : dict of int to str
        Entries of q that are angles with their turns, and the names of their coordinates.
    momenta : sequence of (names, linear, angular, about)
        Momenta that it computes: bodies, directions (3,) of frame O, and the point (3,) [m] of the
        ground, None for the centre of mass.
    has_masses : bool
        Whether masses are those of the scene.
    measures : sequence of MeasureSource
        Coordinates and elongations that its formulas read.
    """

    system: System
    layout: Layout
    q: Array
    v: Array
    turned_angles: Mapping[int, str]
    momenta: Sequence[tuple[Sequence[str], Any, Any, Any]]
    has_masses: bool
    measures: Sequence[MeasureSource]


def independent_points(solver: ComparedSolver) -> list[dict[str, object]]:
    """States of a scene, and the results of a solver there: M v̇ + C_qᵀλ = f, C_q v̇ = γ.

    The bodies are separate: m v̇ = F [N] in frame O, I′ω̇′ = N′ − ω̃′I′ω′ [N m] in the principal
    frame, three mass points, (newton-euler-force) and (newton-euler-moment).

    Parameters
    ----------
    solver : ComparedSolver
        The scene, and the solver's coordinates.

    Returns
    -------
    list of dict
        For each state ``label``, ``time`` [s], ``q`` (n,), ``v`` (m,) of the solver, and
        ``values``: for each quantity, by name, the ``names`` of its numbers, ``high`` in SI units,
        and one ``unit`` of error for all. Numbers that the motion does not determine are None.
        Empty where all states near the start are too close to ones with dependent rows.
    """
    finder = _StateFinder(solver)
    points = []
    for state in finder.states():
        try:
            points.append(_point(solver, finder, state))
        except (_UnsuitableError, ArithmeticError, ValueError, TypeError):
            continue
        if len(points) > MOVING_STATES:
            break
    return points


class _StateFinder:
    """States of a solver that are on all joints and drivers of the scene."""

    def __init__(self, solver: ComparedSolver) -> None:
        self.solver = solver
        self.bodies = solver.layout.bodies
        self.equations = NewtonEulerEquations(solver.system, FLOAT)
        self.length = solver.layout.length
        shifts = {k for body in self.bodies for k in body.v if isinstance(k, int)}
        self.is_shift = np.array([k in shifts for k in range(len(solver.v))], dtype=bool)
        self.sizes = np.where(self.is_shift, self.length, 1.0)

    def states(self) -> Iterator[tuple[str, float, Array, Array]]:
        """States: the start, then some that move."""
        solver = self.solver
        yield "start", 0.0, solver.q, solver.v
        stream = Sha256Random(f"independent states of {solver.system.name}")
        for size, time in TRIALS:
            for _ in range(2 * MOVING_STATES):
                numbers = [stream.sign() * stream.magnitude() for _ in range(2 * len(solver.v))]
                shift, speed = np.array(numbers).reshape(2, -1) * self.sizes
                try:
                    q, v = self._closed(time, self.moved(solver.q, size * shift), solver.v + speed)
                except (_UnsuitableError, ArithmeticError, ValueError, TypeError):
                    continue
                yield "beside the start, moving", time, self._counted(q, v), v

    def _counted(self, q: Array, v: Array) -> Array:
        """Coordinates q with the turns of its angles counted anew."""
        counted, poses, equations = q.copy(), self.poses(q, v, FLOAT), self.equations
        rates, zeros = equations.rates(poses), np.zeros(equations.count).tolist()
        courses = equations.courses(range(len(poses)), poses, rates, zeros)
        indices = {
            coordinate.name: k for k, coordinate in enumerate(self.solver.system.coordinates)
        }
        for entry, name in self.solver.turned_angles.items():
            counted[entry] = equations.coordinate(indices[name], courses).x
        return counted

    def moved(self, q: Array, change: Array) -> Array:
        """Coordinates q after small shifts and turns, in the columns of v."""
        moved_q = q.copy()
        done: set[int] = set()
        for body in self.bodies:
            for entry, column in zip(body.r, body.v, strict=True):
                if isinstance(entry, int) and isinstance(column, int) and entry not in done:
                    moved_q[entry] += change[column]
                    done.add(entry)
            entries = [entry for entry in body.p if isinstance(entry, int)]
            if entries and entries[0] not in done:
                p = _components(body.p, q)
                half = [change[k] / 2 if isinstance(k, int) else 0.0 for k in body.omega_b]
                turn = np.array(quaternion_product(p, (1.0, *half)))
                turn /= np.sqrt(turn @ turn)
                for entry, x in zip(body.p, turn, strict=True):
                    if isinstance(entry, int):
                        moved_q[entry] = x
                done |= set(entries)
        return moved_q

    def steepness(self, time: float, q: Array, v: Array) -> Array:
        """Changes of forces (n,) [N, N m] per relative change of a state.

        A spring that is relaxed there has forces of rounding alone, of positions times its
        stiffness. Changes are zero where forces have no value beside the state.
        """
        reach = reach_of(self.poses(q, v, FLOAT), self.length)
        sizes = np.where(self.is_shift, reach, 1.0)
        weights = np.cos(np.arange(1.0, len(v) + 1.0))
        speeds = np.maximum(np.abs(v), LEAST_SPEED * self.sizes)
        try:  # at the state itself roots may have no slope
            here, there = (
                self._forces(
                    time,
                    self.moved(q, step * weights * sizes),
                    v + step * weights[::-1] * speeds,
                )
                for step in (STEEPNESS_STEP, 2.0 * STEEPNESS_STEP)
            )
        except (ArithmeticError, ValueError, TypeError):
            return np.zeros(self.equations.count)
        change = np.abs(there - here) / STEEPNESS_STEP
        return np.where(np.isfinite(change), change, 0.0)

    def _forces(self, time: float, q: Array, v: Array) -> Array:
        """Forces on all bodies (n,) [N, N m]."""
        return np.array(
            [float(x) for x in self.equations.loads(self.poses(q, v, FLOAT), time).force]
        )

    def poses(self, q: Array, v: Array, digits: FormulaArithmetic[Any]) -> list[BodyState]:
        """Poses of the bodies of the scene, from coordinates of the solver."""
        pairs = zip(self.bodies, self.solver.system.bodies, strict=True)
        return [_pose(carrier, body, q, v, digits) for carrier, body in pairs]

    def velocity_jacobian(self, q: Array) -> Array:
        """Jacobian (n, nv) of the velocities of all bodies by those of the solver."""
        jacobian = np.zeros((self.equations.count, len(self.solver.v)))
        columns = [
            dict.fromkeys(k for k in (*carrier.v, *carrier.omega_b) if isinstance(k, int))
            for carrier in self.bodies
        ]
        pairs = zip(self.bodies, self.solver.system.bodies, strict=True)
        for k, (carrier, body) in enumerate(pairs):
            for column in columns[k]:
                unit = np.zeros(len(self.solver.v))
                unit[column] = 1.0
                pose = _pose(carrier, body, q, unit, FLOAT)
                twist = [*pose.v, *(() if body.is_point else pose.omega_b)]
                jacobian[self.equations.columns_of(k), column] = twist
        return jacobian

    def _closed(self, time: float, q: Array, v: Array) -> tuple[Array, Array]:
        """State near another one, q and v, that satisfies all joints and drivers."""
        for _ in range(MOST_CLOSING_STEPS):
            rows = self.equations.constraint_rows(self.poses(q, v, FLOAT), time)
            if not rows:
                return q, v
            residual = np.array([row.value for row in rows])
            jacobian = dense(rows, self.equations.count) @ self.velocity_jacobian(q)
            if not np.isfinite(jacobian).all():
                raise _UnsuitableError
            inverse = np.linalg.pinv(jacobian * self.sizes, rcond=STATE_RANK_TOLERANCE)
            if np.abs(residual).max() <= CLOSING_TOLERANCE * max(self.length, 1.0):
                rate_residual = jacobian @ v - np.array([row.nu for row in rows])
                return q, v - self.sizes * (inverse @ rate_residual)
            q = self.moved(q, -self.sizes * (inverse @ residual))
        raise _UnsuitableError


def _components(entries: Sequence[int | float], values: Array) -> list[float]:
    return [float(values[k]) if isinstance(k, int) else float(k) for k in entries]


def _pose(
    carrier: BodyPlaces, body: Any, q: Array, v: Array, digits: FormulaArithmetic[Any]
) -> BodyState:
    """Pose and velocity of a body of the scene, from those of its carrier in a solver."""

    def numbers(values: Sequence[float]) -> list[Real]:
        return [digits.number(x) for x in values]

    r, velocity = numbers(_components(carrier.r, q)), numbers(_components(carrier.v, v))
    if body.is_point:
        return BodyState(r, numbers((1, 0, 0, 0)), velocity, numbers((0, 0, 0)))
    p, omega = numbers(_components(carrier.p, q)), numbers(_components(carrier.omega_b, v))
    norm = digits.sqrt(sum(x * x for x in p))
    p = [x / norm for x in p]
    carrier_axes, body_axes = numbers(carrier.axes_b), numbers(body.axes_b)
    inverse = (body_axes[0], -body_axes[1], -body_axes[2], -body_axes[3])
    change = quaternion_product(carrier_axes, inverse)
    arm, center = numbers(carrier.origin_b), rotated(change, numbers(body.origin_b))
    arm = [a - b for a, b in zip(arm, center, strict=True)]
    relative = (
        omega[1] * arm[2] - omega[2] * arm[1],
        omega[2] * arm[0] - omega[0] * arm[2],
        omega[0] * arm[1] - omega[1] * arm[0],
    )
    return BodyState(
        [a + b for a, b in zip(r, rotated(p, arm), strict=True)],
        quaternion_product(p, change),
        [a + b for a, b in zip(velocity, rotated(p, relative), strict=True)],
        rotated_back(change, omega),
    )


def reach_of(poses: Sequence[BodyState], length: float) -> float:
    """Size of positions [m] that rounding is relative to: the farthest one plus a scene length."""
    return length + max((abs(float(x)) for pose in poses for x in pose.r), default=0.0)


def dense(rows: Sequence[ConstraintRow], count: int) -> Array:
    """C_q (m, n) in doubles, of C_q v = ν: columns δr [m], frame O, δθ′ [rad], principal frame."""
    matrix = np.zeros((len(rows), count))
    for k, row in enumerate(rows):
        for column, x in row.jacobian.items():
            matrix[k, column] = float(x)
    return matrix


class _Solution:
    """Accelerations v̇ and multipliers λ at a state, and the null vectors of their equations."""

    def __init__(
        self,
        equations: NewtonEulerEquations,
        rows: Sequence[ConstraintRow],
        loads: AppliedForces,
        *,
        has_masses: bool,
    ) -> None:
        self.rows, count = rows, equations.count
        inertia = equations.inertia() if has_masses else [equations.digits.number(1)] * count
        force = loads.force if has_masses else [equations.digits.number(0)] * count
        masses = np.array([float(x) for x in inertia])
        positive_masses = np.where(masses > 0, masses, masses.max(initial=0.0) or 1.0)
        column_scale = 1 / np.sqrt(positive_masses)
        jacobian = dense(rows, count)
        norms = np.sqrt(((jacobian * column_scale) ** 2).sum(axis=1)) if rows else np.zeros(0)
        # A row of a cross product may be rounding, where an axis lies along a coordinate.
        norms = np.where(norms > STATE_RANK_TOLERANCE * norms.max(initial=0.0), norms, 0.0)
        jacobian[norms == 0] = 0.0
        row_scale = 1 / np.where(norms > 0, norms, 1.0)
        scaled = row_scale[:, np.newaxis] * jacobian * column_scale
        self.condition = _condition(scaled)
        m = len(rows)
        matrix = np.zeros((count + m, count + m))
        matrix[:count, :count] = np.diag(masses * column_scale**2)
        matrix[:count, count:], matrix[count:, :count] = scaled.T, scaled
        if not np.isfinite(matrix).all():
            raise _UnsuitableError
        eigenvalues, eigenvectors = np.linalg.eigh(matrix)
        keep = np.abs(eigenvalues) > STATE_RANK_TOLERANCE * np.abs(eigenvalues).max(initial=0.0)
        scale = np.concatenate([column_scale, row_scale])
        inverse = (eigenvectors[:, keep] / eigenvalues[keep]) @ eigenvectors[:, keep].T
        self.null_vectors = eigenvectors[:, ~keep].T * scale
        right_side = [*force, *(row.gamma for row in rows)]
        unknowns = [equations.digits.number(0)] * (count + m)
        for _ in range(REFINEMENTS):
            residual = [*right_side]
            for k in range(count):
                residual[k] -= inertia[k] * unknowns[k]
            for k, row in enumerate(rows):
                for column, x in row.jacobian.items():
                    residual[column] -= x * unknowns[count + k]
                    residual[count + k] -= x * unknowns[column]
            correction = scale * (inverse @ (scale * np.array([float(x) for x in residual])))
            unknowns = [
                a + equations.digits.number(float(b))
                for a, b in zip(unknowns, correction, strict=True)
            ]
        self.v_dot, self.lam = unknowns[:count], unknowns[count:]
        self.inertia_force = max(
            (abs(float(a * b)) for a, b in zip(inertia, self.v_dot, strict=True)), default=0.0
        )


def _condition(scaled: Array) -> float:
    """Ratio of the largest singular value to the smallest one that is not zero."""
    if not scaled.size:
        return 1.0
    values = np.linalg.svd(scaled, compute_uv=False)
    nonzero = values[values > STATE_RANK_TOLERANCE * values[0]]
    if nonzero[-1] < LEAST_SINGULAR_VALUE * values[0]:
        raise _UnsuitableError
    return float(values[0] / nonzero[-1])


def _point(
    solver: ComparedSolver, finder: _StateFinder, state: tuple[str, float, Array, Array]
) -> dict[str, object]:
    """State with the results that a solver must have there."""
    label, time, q, v = state
    equations = NewtonEulerEquations(solver.system, HIGH)
    poses = finder.poses(q, v, HIGH)
    exact_time = HIGH.number(time)
    rows = equations.constraint_rows(poses, exact_time)
    loads = equations.loads(poses, exact_time)
    solution = _Solution(equations, rows, loads, has_masses=solver.has_masses)
    loads.steepness = finder.steepness(time, q, v).tolist()
    values = _Values(solver, equations, poses, loads, solution).comparisons()
    return {
        "label": label,
        "time": time,
        "q": [float(x) for x in q],
        "v": [float(x) for x in v],
        "values": values,
    }


class _Values:
    """Results that a solver must have at a state, by name, with their units of error."""

    def __init__(
        self,
        solver: ComparedSolver,
        equations: NewtonEulerEquations,
        poses: Sequence[BodyState],
        loads: AppliedForces,
        solution: _Solution,
    ) -> None:
        self.solver, self.equations, self.poses = solver, equations, poses
        self.loads, self.solution = loads, solution
        all_bodies = range(len(poses))
        self.rates = equations.rates(poses)
        self.courses = equations.courses(all_bodies, poses, self.rates, solution.v_dot)
        self.length = solver.layout.length
        self.reach = reach_of(poses, self.length)
        self.angular_speed = max((abs(float(x)) for pose in poses for x in pose.omega_b), default=0)
        drift = max((abs(float(x)) for pose in poses for x in pose.v), default=0)
        self.speed = drift + self.length * self.angular_speed + 1e-3 * self.length
        self.acceleration = self._largest_acceleration()
        self.error = UNIT * solution.condition**2

    def _largest_acceleration(self) -> float:
        length, bounds = self.length, [self.speed**2 / self.length]
        for k, body in enumerate(self.equations.bodies):
            for n, column in enumerate(self.equations.columns_of(k)):
                size = abs(float(self.solution.v_dot[column])) * (length if n > 2 else 1.0)
                mass = body.mass if n < 3 else body.inertia[n - 3]
                force = max(abs(float(self.loads.force[column])), self.loads.steepness[column])
                bounds += [size, force / mass * (length if n > 2 else 1.0) if mass > 0 else 0.0]
        return max(bounds)

    def comparisons(self) -> dict[str, dict[str, object]]:
        """Results of all outputs, by name."""
        comparisons = dict([*self._accelerations(), *self._coordinates(), *self._measures()])
        sizes = {"q_moved": self.reach, "move": self.reach, "dv": self.speed, "dq": self.reach}
        sizes |= {"C": self.reach, "C_dot": self.speed, "C_ddot": self.acceleration}
        comparisons |= {
            name: self._result([""], [0.0], max(size, size / self.length))
            for name, size in sizes.items()
        }
        if self.solver.has_masses:
            comparisons |= dict([*self._energies(), *self._forces()])
        return comparisons

    def _result(
        self, names: Sequence[str], numbers: Sequence[Real | None], size: float
    ) -> dict[str, object]:
        unit = self.error * size

        def written(x: Real) -> float:
            return float(x) if abs(x) > NEGLIGIBLE_ERROR * unit else 0.0

        high = [None if x is None else written(x) for x in numbers]
        return {"names": list(names), "high": high, "unit": float(f"{unit:.3e}")}

    def _accelerations(self) -> Iterator[tuple[str, dict[str, object]]]:
        """Accelerations r̈ of origins and ω̇′; undetermined ones are None."""
        accelerations = [*self.equations.origins(self.courses, self.solution.v_dot)]
        undetermined = self._undetermined(accelerations)
        names = [body.name for body in self.equations.bodies]
        for n, (quantity, size) in enumerate(
            (
                ("acceleration", self.acceleration),
                ("angular_acceleration", self.acceleration / self.length),
            )
        ):
            labels = [name for name, row in zip(names, accelerations, strict=True) for _ in row[n]]
            numbers = [x for row in accelerations for x in row[n]]
            flags = [x for row in undetermined for x in row[n]]
            kept = [None if flag else x for x, flag in zip(numbers, flags, strict=True)]
            yield quantity, self._result(labels, kept, size)

    def _undetermined(self, accelerations: Sequence[Any]) -> list[list[list[bool]]]:
        """Marks of the accelerations that change along null directions of the equations."""
        undetermined = [[[False] * len(part) for part in row] for row in accelerations]
        count = self.equations.count
        for direction in self.solution.null_vectors:
            shift = np.abs(direction[:count]).max(initial=0.0)
            if shift <= UNIQUE_CHANGE * np.abs(direction).max():
                continue
            v_dot = [
                a + HIGH.number(float(b))
                for a, b in zip(self.solution.v_dot, direction, strict=False)
            ]
            courses = self.equations.courses(range(len(self.poses)), self.poses, self.rates, v_dot)
            shifted = self.equations.origins(courses, v_dot)
            for flags, new, old in zip(undetermined, shifted, accelerations, strict=True):
                for flag, a, b in zip(flags, new, old, strict=True):
                    for k, (x, y) in enumerate(zip(a, b, strict=True)):
                        flag[k] |= abs(float(x - y)) > UNIQUE_CHANGE * shift
        return undetermined

    def _coordinates(self) -> Iterator[tuple[str, dict[str, object]]]:
        """Value, rate and second derivative of coordinates that are shown."""
        system = self.solver.system
        shown = [
            (system.coordinates[k].name, self.equations.coordinate(k, self.courses))
            for k in system.shown
        ]
        for index, (_, value) in zip(system.shown, shown, strict=True):
            angle = system.coordinates[index]
            if angle.counts_turns and abs(float(value.x) - angle.near) > MOST_ANGLE_DIFFERENCE:
                raise _UnsuitableError
        length = min(1.0, self.length)
        names = [name for name, _ in shown]
        for quantity, derivative, size in (
            ("coordinate", "x", max(self.reach, 1.0)),
            ("coordinate_rate", "d", self.speed / length),
            ("coordinate_acceleration", "dd", self.acceleration / length),
        ):
            numbers = [getattr(value, derivative) for _, value in shown]
            yield quantity, self._result(names, numbers, size)

    def _measures(self) -> Iterator[tuple[str, dict[str, object]]]:
        """Values and rates of the measures that formulas read, in their units."""
        numbers: list[Real | None] = []
        system = self.solver.system
        for measure in self.solver.measures:
            index, unit = measure.coordinate, measure.unit
            if measure.force >= 0:
                force = system.forces[measure.force]
                value = self.equations.elongation(
                    force, self.courses, self.loads.time, is_length=measure.is_length
                )
                index = force.coordinate
            elif index >= 0:
                value = self.equations.coordinate(index, self.courses).times(1 / HIGH.number(unit))
            else:
                numbers += [None, None]
                continue
            angle = system.coordinates[index] if index >= 0 else None
            difference = abs(float(value.x) - angle.near) if angle and angle.counts_turns else 0.0
            numbers += [value.x if difference <= MOST_ANGLE_DIFFERENCE else None, value.d]
        smallest_unit = min((measure.unit for measure in self.solver.measures), default=1.0)
        size = max(self.reach, 1.0, self.speed / min(1.0, self.length)) / min(1.0, smallest_unit)
        yield "measure", self._result([""] * len(numbers), numbers, size)

    def _energies(self) -> Iterator[tuple[str, dict[str, object]]]:
        loads, size = self.loads, sum(abs(float(x)) for x in self.loads.sizes)
        for k in range(len(self.poses)):
            for n, column in enumerate(self.equations.columns_of(k)):
                size += self.loads.steepness[column] * (self.reach if n < 3 else 1.0)
        energies = [loads.kinetic, loads.potential]
        yield "energy", self._result(["kinetic", "potential"], energies, size)
        names, numbers = [], []
        indices = {body.name: k for k, body in enumerate(self.equations.bodies)}
        for bodies, linear, angular, about in self.solver.momenta:
            members = [indices[name] for name in bodies]
            linear_momentum, angular_momentum = self.equations.momentum(members, self.poses, about)
            for directions, momentum in ((linear, linear_momentum), (angular, angular_momentum)):
                for direction in directions:
                    names.append("")
                    numbers.append(
                        sum(HIGH.number(a) * b for a, b in zip(direction, momentum, strict=True))
                    )
        mass = sum(body.mass for body in self.equations.bodies)
        size = mass * self.speed * max(1.0, self.reach + self.length)
        yield "momenta", self._result(names, numbers, size)

    def _forces(self) -> Iterator[tuple[str, dict[str, object]]]:
        """Forces and moments about the origin of frame O, and powers."""
        wrenches = self._wrenches()
        forces = [abs(float(x)) for x in self.loads.force]
        heaviest = max((body.mass for body in self.equations.bodies), default=0.0)
        strength = max(self.solution.inertia_force, heaviest * self.acceleration, *forces)
        lam = [float(x) for x in self.solution.lam]
        for wrench in wrenches.values():
            for component in wrench[:3]:
                strength = max(strength, sum(abs(float(x) * lam[k]) for k, x in component))
        null_vectors = self.solution.null_vectors[:, self.equations.count :]
        for n, (quantity, size) in enumerate(
            (("force", strength), ("moment", strength * (self.reach + self.length)))
        ):
            names, numbers = [], []
            for name, wrench in wrenches.items():
                for component in wrench[3 * n : 3 * n + 3]:
                    names.append(name)
                    numbers.append(self._unique_sum(component, null_vectors))
            yield quantity, self._result(names, numbers, size)
        powers = dict(self.loads.powers)
        drivers: dict[str, list[tuple[int, Real]]] = {}
        for k, row in enumerate(self.solution.rows):
            if row.instance.is_driver:
                drivers.setdefault(row.instance.joint, []).append((k, -row.nu))
        driver_powers = {
            name: self._unique_sum(terms, null_vectors) for name, terms in drivers.items()
        }
        names = [*powers, *driver_powers]
        yield (
            "power",
            self._result(
                names,
                [*powers.values(), *driver_powers.values()],
                strength * self.speed * max(1.0, 1 / self.length),
            ),
        )

    def _unique_sum(self, terms: Sequence[tuple[int, Real]], null_vectors: Array) -> Real | None:
        """Sum Σ a λ, None where it is not unique."""
        factors = np.zeros(null_vectors.shape[1])
        for k, x in terms:
            factors[k] += float(x)
        largest = np.abs(factors).max(initial=0.0)
        for direction in null_vectors:
            limit = UNIQUE_CHANGE * largest * np.abs(direction).max(initial=0.0)
            if abs(factors @ direction) > limit:
                return None
        total: Real = sum((x * self.solution.lam[k] for k, x in terms), HIGH.number(0))
        return total

    def _wrenches(self) -> dict[str, list[list[tuple[int, Real]]]]:
        """Wrenches of joints as factors of multipliers: force, and moment about the origin of O.

        In frame O, −C_qᵀλ on body j; where that is the ground, the opposite of that on i. Each body
        of a joint of three or more has its own.
        """
        wrenches: dict[str, list[list[tuple[int, Real]]]] = {}
        connected: dict[str, dict[int, None]] = {}
        for row in self.solution.rows:
            connected.setdefault(row.instance.joint, {}).update(dict.fromkeys(row.instance.bodies))
        for k, row in enumerate(self.solution.rows):
            instance = row.instance
            bodies = [*connected[instance.joint]]
            ends = [body for body in bodies if body != GROUND_INDEX]
            if len(bodies) < 3:
                ends = [instance.i if instance.j == GROUND_INDEX else instance.j]
            for body in ends:
                name = self.equations.bodies[body].name
                key = f"{instance.joint}.{name}" if len(bodies) > 2 else instance.joint
                sign = 1 if len(bodies) < 3 and instance.j == GROUND_INDEX else -1
                wrench = wrenches.setdefault(key, [[] for _ in range(6)])
                for component, x in zip(wrench, self._wrench(row, body), strict=True):
                    component.append((k, sign * x))
        return wrenches

    def _wrench(self, row: ConstraintRow, body: int) -> list[Real]:
        """Row of C_q of a body as a force in frame O and a moment about the origin of O."""
        pose, columns = self.poses[body], self.equations.columns_of(body)
        jacobian = [row.jacobian.get(k, 0) for k in columns]
        force, torque_b = jacobian[:3], jacobian[3:] or [0, 0, 0]
        moment = rotated(pose.p, torque_b)
        x, y, z = pose.r
        arm = (
            y * force[2] - z * force[1],
            z * force[0] - x * force[2],
            x * force[1] - y * force[0],
        )
        return [*force, *(a + b for a, b in zip(moment, arm, strict=True))]
