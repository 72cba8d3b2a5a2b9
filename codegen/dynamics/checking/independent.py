"""Motion of a scene at a few states, by :mod:`.newton_euler`, to compare its solver with.

States are those that the solver can have: its start, and some beside it that move, brought onto all
joints and drivers of the scene. There M v̇ + C_qᵀλ = f, C_q v̇ = γ is solved for each body by
itself, with residuals in 50 digits. What forces of joints are not unique is left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.codegen.dynamics.checking.newton_euler import (
    BodyEquations,
    BodyState,
    ConstraintRow,
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

    from kousoku.codegen.dynamics.checking.newton_euler import Found
    from kousoku.model.mechanics.multibody import System
    from kousoku.model.numbers.real import Array, Real
    from kousoku.model.operations.arithmetic import FormulaArithmetic
    from kousoku.runtime.integrate.body_tables import BodyPlaces
    from kousoku.runtime.integrate.motion import Layout

#: How far states are from the start: as a part of the length of the scene or a radian, in seconds,
#: and how fast, as a part of the length or a radian in a second. Those that come first are tried
#: first.
TRIALS = ((2.0**-5, 0.3), (2.0**-6, 0.04), (2.0**-8, 2.0**-8), (2.0**-12, 2.0**-12), (0.0, 0.0))
#: States that move and are wanted beside the start.
STATES = 1
#: Singular values that are zero, and the least that a state may have, as parts of the largest.
STATE_RANK_TOLERANCE, WEAK = 1e-10, 1e-4
#: Steps onto the constraints at most, and what may be left of them.
MOST_CLOSING_STEPS, CLOSING_TOLERANCE = 20, 1e-13
#: Steps of refinement: the residuals have 50 digits, the factors are doubles.
REFINED = 4
#: What changes by less along a null direction, as a part of what it is made of, is unique.
UNIQUE = 1e-7
#: An angle that is further from what it is counted to may have another turn [rad].
MOST_ANGLE_DIFFERENCE = 2.5
#: The unit of error at a condition of one, as a part of the largest number of a sort.
UNIT = 2.0**-42
#: By how much a state is moved to see what rounding of it does to forces, as a part of sizes, and
#: the least speeds, in sizes per second.
MOVED, LEAST_SPEED = 2.0**-30, 1e-3
#: What is smaller, as a part of that unit, is rounding of 50 digits, which is another one beside
#: other factors in doubles: zero.
NEGLIGIBLE_ERROR = 2.0**-40


class _UnsuitableError(Exception):
    """Nothing can be compared at a state."""


@dataclass(frozen=True, slots=True)
class GivenMeasure:
    """What a formula reads of a state: a coordinate, or the elongation of a spring.

    Parameters
    ----------
    coordinate, force : int
        Which; the other is -1.
    is_length : bool
        Whether it is the distance of the spring's ends.
    unit : float
        In which a coordinate is counted [m or rad].
    """

    coordinate: int
    force: int
    is_length: bool
    unit: float


@dataclass(frozen=True, slots=True)
class GivenSolver:
    """Solver that is compared, as far as it is known.

    Parameters
    ----------
    system : System
        The scene after assembly, before anything is simplified, its numbers fixed.
    layout : Layout
        Where the solver has its bodies.
    q, v : array (n,) [m, -], (m,) [m/s, rad/s]
        Its start.
    turning : dict of int to str
        Entries of q that are angles with their turns, and the coordinates.
    momenta : sequence of (names, linear, angular, about)
        Which momenta it computes: bodies, directions (3,) of frame O, and the point (3,) [m] of the
        ground, None for the centre of mass.
    has_masses : bool
        Whether masses are those of the scene.
    measures : sequence of GivenMeasure
        What its formulas read.
    """

    system: System
    layout: Layout
    q: Array
    v: Array
    turning: Mapping[int, str]
    momenta: Sequence[tuple[Sequence[str], Any, Any, Any]]
    has_masses: bool
    measures: Sequence[GivenMeasure]


def independent_points(given: GivenSolver) -> list[dict[str, object]]:
    """States of a scene, and the results of a solver there: M v̇ + C_qᵀλ = f, C_q v̇ = γ.

    These are solved for each body by itself: m v̇ = F [N] in frame O, I′ω̇′ = N′ − ω̃′I′ω′ [N m] in
    the principal frame, three mass points, (newton-euler-force) and (newton-euler-moment).

    Parameters
    ----------
    given : GivenSolver
        The scene, and the solver's coordinates.

    Returns
    -------
    list of dict
        For each state ``label``, ``time`` [s], ``q`` (n,), ``v`` (m,) of the solver, and
        ``values``: by name of what is compared the ``names`` of its numbers, ``high`` in SI units,
        and one ``unit`` of error for all. Numbers that the motion does not determine are None.
        Empty where no state near the start is away from places where rows become dependent.
    """
    finder = _States(given)
    found = []
    for state in finder.states():
        try:
            found.append(_point(given, finder, state))
        except (_UnsuitableError, ArithmeticError, ValueError, TypeError):
            continue
        if len(found) > STATES:
            break
    return found


class _States:
    """States of a solver that are on all joints and drivers of the scene."""

    def __init__(self, given: GivenSolver) -> None:
        self.given = given
        self.bodies = given.layout.bodies
        self.equations = BodyEquations(given.system, FLOAT)
        self.length = given.layout.length
        shifts = {k for body in self.bodies for k in body.v if isinstance(k, int)}
        self.is_shift = np.array([k in shifts for k in range(len(given.v))], dtype=bool)
        self.sizes = np.where(self.is_shift, self.length, 1.0)

    def states(self) -> Iterator[tuple[str, float, Array, Array]]:
        """States: the start, then some that move."""
        given = self.given
        yield "start", 0.0, given.q, given.v
        stream = Sha256Random(f"independent states of {given.system.name}")
        for size, time in TRIALS:
            for _ in range(2 * STATES):
                numbers = [stream.sign() * stream.magnitude() for _ in range(2 * len(given.v))]
                shift, speed = np.array(numbers).reshape(2, -1) * self.sizes
                try:
                    q, v = self._onto(time, self.moved(given.q, size * shift), given.v + speed)
                except (_UnsuitableError, ArithmeticError, ValueError, TypeError):
                    continue
                yield "beside the start, moving", time, self._counted(q, v), v

    def _counted(self, q: Array, v: Array) -> Array:
        """Coordinates q with the angles that they have there."""
        found, poses, equations = q.copy(), self.poses(q, v, FLOAT), self.equations
        rates = equations.rates(poses)
        at = equations.courses(range(len(poses)), poses, rates, np.zeros(equations.count).tolist())
        places = {one.name: k for k, one in enumerate(self.given.system.coordinates)}
        for entry, name in self.given.turning.items():
            found[entry] = equations.coordinate(places[name], at).x
        return found

    def moved(self, q: Array, change: Array) -> Array:
        """Coordinates q after small shifts and turns, in the columns of v."""
        found = q.copy()
        done: set[int] = set()
        for body in self.bodies:
            for at, of in zip(body.r, body.v, strict=True):
                if isinstance(at, int) and isinstance(of, int) and at not in done:
                    found[at] += change[of]
                    done.add(at)
            own = [at for at in body.p if isinstance(at, int)]
            if own and own[0] not in done:
                p = _taken(body.p, q)
                half = [change[k] / 2 if isinstance(k, int) else 0.0 for k in body.omega_b]
                turn = np.array(quaternion_product(p, (1.0, *half)))
                turn /= np.sqrt(turn @ turn)
                for at, x in zip(body.p, turn, strict=True):
                    if isinstance(at, int):
                        found[at] = x
                done |= set(own)
        return found

    def steepness(self, time: float, q: Array, v: Array) -> Array:
        """Changes of forces (n,) [N, N m] where a state moves, by the part of its reach.

        A spring that is relaxed there has forces of rounding alone, of places times its stiffness.
        They are zero where forces have no value beside the state.
        """
        reach = reach_of(self.poses(q, v, FLOAT), self.length)
        sizes = np.where(self.is_shift, reach, 1.0)
        ways = np.cos(np.arange(1.0, len(v) + 1.0))
        speeds = np.maximum(np.abs(v), LEAST_SPEED * self.sizes)
        try:  # at the state itself roots may have no slope
            here, there = (
                self._forces(
                    time, self.moved(q, part * ways * sizes), v + part * ways[::-1] * speeds
                )
                for part in (MOVED, 2.0 * MOVED)
            )
        except (ArithmeticError, ValueError, TypeError):
            return np.zeros(self.equations.count)
        change = np.abs(there - here) / MOVED
        return np.where(np.isfinite(change), change, 0.0)

    def _forces(self, time: float, q: Array, v: Array) -> Array:
        """Forces on all bodies (n,) [N, N m]."""
        return np.array(
            [float(x) for x in self.equations.loads(self.poses(q, v, FLOAT), time).force]
        )

    def poses(self, q: Array, v: Array, digits: FormulaArithmetic[Any]) -> list[BodyState]:
        """Poses of the bodies of the scene, from coordinates of the solver."""
        pairs = zip(self.bodies, self.given.system.bodies, strict=True)
        return [_pose(place, body, q, v, digits) for place, body in pairs]

    def velocities(self, q: Array) -> Array:
        """Velocities of all bodies for each velocity of the solver, (n, nv)."""
        found = np.zeros((self.equations.count, len(self.given.v)))
        columns = [
            dict.fromkeys(k for k in (*one.v, *one.omega_b) if isinstance(k, int))
            for one in self.bodies
        ]
        for k, (place, body) in enumerate(zip(self.bodies, self.given.system.bodies, strict=True)):
            for column in columns[k]:
                unit = np.zeros(len(self.given.v))
                unit[column] = 1.0
                pose = _pose(place, body, q, unit, FLOAT)
                own = [*pose.v, *(() if body.is_point else pose.omega_b)]
                found[self.equations.own(k), column] = own
        return found

    def _onto(self, time: float, q: Array, v: Array) -> tuple[Array, Array]:
        """State that is on all joints and drivers."""
        for _ in range(MOST_CLOSING_STEPS):
            lines = self.equations.lines(self.poses(q, v, FLOAT), time)
            if not lines:
                return q, v
            residual = np.array([line.value for line in lines])
            jacobian = dense(lines, self.equations.count) @ self.velocities(q)
            if not np.isfinite(jacobian).all():
                raise _UnsuitableError
            inverse = np.linalg.pinv(jacobian * self.sizes, rcond=STATE_RANK_TOLERANCE)
            if np.abs(residual).max() <= CLOSING_TOLERANCE * max(self.length, 1.0):
                rates = jacobian @ v - np.array([line.nu for line in lines])
                return q, v - self.sizes * (inverse @ rates)
            q = self.moved(q, -self.sizes * (inverse @ residual))
        raise _UnsuitableError


def _taken(places: Sequence[int | float], values: Array) -> list[float]:
    return [float(values[k]) if isinstance(k, int) else float(k) for k in places]


def _pose(
    place: BodyPlaces, body: Any, q: Array, v: Array, digits: FormulaArithmetic[Any]
) -> BodyState:
    """Pose of a body of the scene, from that of its carrier in a solver."""

    def numbers(values: Sequence[float]) -> list[Real]:
        return [digits.number(x) for x in values]

    r, drift = numbers(_taken(place.r, q)), numbers(_taken(place.v, v))
    if body.is_point:
        return BodyState(r, numbers((1, 0, 0, 0)), drift, numbers((0, 0, 0)))
    p, omega = numbers(_taken(place.p, q)), numbers(_taken(place.omega_b, v))
    size = digits.sqrt(sum(x * x for x in p))
    p = [x / size for x in p]
    axes, own = numbers(place.axes_b), numbers(body.axes_b)
    back = (own[0], -own[1], -own[2], -own[3])
    change = quaternion_product(axes, back)
    arm, center = numbers(place.origin_b), rotated(change, numbers(body.origin_b))
    arm = [a - b for a, b in zip(arm, center, strict=True)]
    turn = (
        omega[1] * arm[2] - omega[2] * arm[1],
        omega[2] * arm[0] - omega[0] * arm[2],
        omega[0] * arm[1] - omega[1] * arm[0],
    )
    return BodyState(
        [a + b for a, b in zip(r, rotated(p, arm), strict=True)],
        quaternion_product(p, change),
        [a + b for a, b in zip(drift, rotated(p, turn), strict=True)],
        rotated_back(change, omega),
    )


def reach_of(poses: Sequence[BodyState], length: float) -> float:
    """Size of positions [m], of which rounding is: the farthest one, and a length of the scene."""
    return length + max((abs(float(x)) for one in poses for x in one.r), default=0.0)


def dense(lines: Sequence[ConstraintRow], count: int) -> Array:
    """C_q (m, n) in doubles, of C_q v = ν: columns δr [m], frame O, δθ′ [rad], principal frame."""
    found = np.zeros((len(lines), count))
    for k, line in enumerate(lines):
        for column, x in line.jacobian.items():
            found[k, column] = float(x)
    return found


class _Solved:
    """v̇ and λ at a state, and along which directions they are not unique."""

    def __init__(
        self,
        equations: BodyEquations,
        lines: Sequence[ConstraintRow],
        found: Found,
        *,
        has_masses: bool,
    ) -> None:
        self.lines, count = lines, equations.count
        inertia = equations.inertia() if has_masses else [equations.digits.number(1)] * count
        force = found.force if has_masses else [equations.digits.number(0)] * count
        masses = np.array([float(x) for x in inertia])
        usual = np.where(masses > 0, masses, masses.max(initial=0.0) or 1.0)
        columns = 1 / np.sqrt(usual)
        jacobian = dense(lines, count)
        sizes = np.sqrt(((jacobian * columns) ** 2).sum(axis=1)) if lines else np.zeros(0)
        # A row of a cross product may be rounding, where an axis lies along a coordinate.
        sizes = np.where(sizes > STATE_RANK_TOLERANCE * sizes.max(initial=0.0), sizes, 0.0)
        jacobian[sizes == 0] = 0.0
        rows = 1 / np.where(sizes > 0, sizes, 1.0)
        scaled = rows[:, np.newaxis] * jacobian * columns
        self.condition = _condition(scaled)
        m = len(lines)
        matrix = np.zeros((count + m, count + m))
        matrix[:count, :count] = np.diag(masses * columns**2)
        matrix[:count, count:], matrix[count:, :count] = scaled.T, scaled
        if not np.isfinite(matrix).all():
            raise _UnsuitableError
        values, vectors = np.linalg.eigh(matrix)
        keep = np.abs(values) > STATE_RANK_TOLERANCE * np.abs(values).max(initial=0.0)
        scale = np.concatenate([columns, rows])
        inverse = (vectors[:, keep] / values[keep]) @ vectors[:, keep].T
        self.free = vectors[:, ~keep].T * scale
        wanted = [*force, *(line.gamma for line in lines)]
        found_x = [equations.digits.number(0)] * (count + m)
        for _ in range(REFINED):
            rest = [*wanted]
            for k in range(count):
                rest[k] -= inertia[k] * found_x[k]
            for k, line in enumerate(lines):
                for column, x in line.jacobian.items():
                    rest[column] -= x * found_x[count + k]
                    rest[count + k] -= x * found_x[column]
            step = scale * (inverse @ (scale * np.array([float(x) for x in rest])))
            found_x = [
                a + equations.digits.number(float(b)) for a, b in zip(found_x, step, strict=True)
            ]
        self.v_dot, self.lam = found_x[:count], found_x[count:]
        self.inertia_force = max(
            (abs(float(a * b)) for a, b in zip(inertia, self.v_dot, strict=True)), default=0.0
        )


def _condition(scaled: Array) -> float:
    """Ratio of the largest singular value to the smallest one that is not zero."""
    if not scaled.size:
        return 1.0
    values = np.linalg.svd(scaled, compute_uv=False)
    live = values[values > STATE_RANK_TOLERANCE * values[0]]
    if live[-1] < WEAK * values[0]:
        raise _UnsuitableError
    return float(values[0] / live[-1])


def _point(
    given: GivenSolver, finder: _States, state: tuple[str, float, Array, Array]
) -> dict[str, object]:
    """State, and the results that a solver must have there."""
    label, time, q, v = state
    equations = BodyEquations(given.system, HIGH)
    poses = finder.poses(q, v, HIGH)
    at_time = HIGH.number(time)
    lines = equations.lines(poses, at_time)
    found = equations.loads(poses, at_time)
    solved = _Solved(equations, lines, found, has_masses=given.has_masses)
    found.steepness = finder.steepness(time, q, v).tolist()
    values = _Values(given, equations, poses, found, solved).all()
    return {
        "label": label,
        "time": time,
        "q": [float(x) for x in q],
        "v": [float(x) for x in v],
        "values": values,
    }


class _Values:
    """Results that a solver must have at a state, by name, and how far off they may be."""

    def __init__(
        self,
        given: GivenSolver,
        equations: BodyEquations,
        poses: Sequence[BodyState],
        found: Found,
        solved: _Solved,
    ) -> None:
        self.given, self.equations, self.poses = given, equations, poses
        self.found, self.solved = found, solved
        everyone = range(len(poses))
        self.rates = equations.rates(poses)
        self.at = equations.courses(everyone, poses, self.rates, solved.v_dot)
        self.length = given.layout.length
        self.reach = reach_of(poses, self.length)
        self.turning = max((abs(float(x)) for one in poses for x in one.omega_b), default=0)
        drift = max((abs(float(x)) for one in poses for x in one.v), default=0)
        self.speed = drift + self.length * self.turning + 1e-3 * self.length
        self.acceleration = self._largest_acceleration()
        self.error = UNIT * solved.condition**2

    def _largest_acceleration(self) -> float:
        length, found = self.length, [self.speed**2 / self.length]
        for k, body in enumerate(self.equations.bodies):
            for n, column in enumerate(self.equations.own(k)):
                size = abs(float(self.solved.v_dot[column])) * (length if n > 2 else 1.0)
                mass = body.mass if n < 3 else body.inertia[n - 3]
                force = max(abs(float(self.found.force[column])), self.found.steepness[column])
                found += [size, force / mass * (length if n > 2 else 1.0) if mass > 0 else 0.0]
        return max(found)

    def all(self) -> dict[str, dict[str, object]]:
        """Comparisons of all outputs."""
        made = dict([*self._accelerations(), *self._coordinates(), *self._measures()])
        sizes = {"q_moved": self.reach, "move": self.reach, "dv": self.speed, "dq": self.reach}
        sizes |= {"C": self.reach, "C_dot": self.speed, "C_ddot": self.acceleration}
        rests = {
            name: self._made([""], [0.0], max(size, size / self.length))
            for name, size in sizes.items()
        }
        made |= rests
        if self.given.has_masses:
            made |= dict([*self._energies(), *self._forces()])
        return made

    def _made(
        self, names: Sequence[str], numbers: Sequence[Real | None], size: float
    ) -> dict[str, object]:
        unit = self.error * size

        def written(x: Real) -> float:
            return float(x) if abs(x) > NEGLIGIBLE_ERROR * unit else 0.0

        high = [None if x is None else written(x) for x in numbers]
        return {"names": list(names), "high": high, "unit": float(f"{unit:.3e}")}

    def _accelerations(self) -> Iterator[tuple[str, dict[str, object]]]:
        """Accelerations r̈ of origins and ω̇′; those that are not determined are left out."""
        own = [*self.equations.origins(self.at, self.solved.v_dot)]
        loose = self._loose(own)
        names = [body.name for body in self.equations.bodies]
        for n, (what, size) in enumerate(
            (
                ("acceleration", self.acceleration),
                ("angular_acceleration", self.acceleration / self.length),
            )
        ):
            labels = [name for name, row in zip(names, own, strict=True) for _ in row[n]]
            numbers = [x for row in own for x in row[n]]
            free = [x for row in loose for x in row[n]]
            kept = [None if is_free else x for x, is_free in zip(numbers, free, strict=True)]
            yield what, self._made(labels, kept, max(size, self.acceleration if n == 0 else size))

    def _loose(self, own: Sequence[Any]) -> list[list[list[bool]]]:
        """Accelerations that change along directions which no equation determines."""
        found = [[[False] * len(part) for part in row] for row in own]
        count = self.equations.count
        for free in self.solved.free:
            if np.abs(free[:count]).max(initial=0.0) <= UNIQUE * np.abs(free).max():
                continue
            other = [
                a + HIGH.number(float(b)) for a, b in zip(self.solved.v_dot, free, strict=False)
            ]
            at = self.equations.courses(range(len(self.poses)), self.poses, self.rates, other)
            for marks, new, old in zip(found, self.equations.origins(at, other), own, strict=True):
                for mark, a, b in zip(marks, new, old, strict=True):
                    for k, (x, y) in enumerate(zip(a, b, strict=True)):
                        mark[k] |= abs(float(x - y)) > UNIQUE * np.abs(free[:count]).max()
        return found

    def _coordinates(self) -> Iterator[tuple[str, dict[str, object]]]:
        """Value, rate and second derivative of coordinates that are shown."""
        system = self.given.system
        shown = [
            (system.coordinates[k].name, self.equations.coordinate(k, self.at))
            for k in system.shown
        ]
        for place, (_, value) in zip(system.shown, shown, strict=True):
            one = system.coordinates[place]
            if one.counts_turns and abs(float(value.x) - one.near) > MOST_ANGLE_DIFFERENCE:
                raise _UnsuitableError
        length = min(1.0, self.length)
        names = [name for name, _ in shown]
        for what, part, size in (
            ("coordinate", "x", max(self.reach, 1.0)),
            ("coordinate_rate", "d", self.speed / length),
            ("coordinate_acceleration", "dd", self.acceleration / length),
        ):
            yield what, self._made(names, [getattr(value, part) for _, value in shown], size)

    def _measures(self) -> Iterator[tuple[str, dict[str, object]]]:
        """Value and rate of what formulas read, in their units."""
        numbers: list[Real | None] = []
        system = self.given.system
        for one in self.given.measures:
            place, unit = one.coordinate, one.unit
            if one.force >= 0:
                force = system.forces[one.force]
                value = self.equations.elongation(
                    force, self.at, self.found.time, is_length=one.is_length
                )
                place = force.coordinate
            elif place >= 0:
                value = self.equations.coordinate(place, self.at).times(1 / HIGH.number(unit))
            else:
                numbers += [None, None]
                continue
            of = system.coordinates[place] if place >= 0 else None
            off = abs(float(value.x) - of.near) if of and of.counts_turns else 0.0
            numbers += [value.x if off <= MOST_ANGLE_DIFFERENCE else None, value.d]
        least = min((one.unit for one in self.given.measures), default=1.0)
        size = max(self.reach, 1.0, self.speed / min(1.0, self.length)) / min(1.0, least)
        yield "measure", self._made([""] * len(numbers), numbers, size)

    def _energies(self) -> Iterator[tuple[str, dict[str, object]]]:
        found, size = self.found, sum(abs(float(x)) for x in self.found.sizes)
        for k in range(len(self.poses)):
            for n, column in enumerate(self.equations.own(k)):
                size += self.found.steepness[column] * (self.reach if n < 3 else 1.0)
        yield "energy", self._made(["kinetic", "potential"], [found.kinetic, found.potential], size)
        names, numbers = [], []
        places = {body.name: k for k, body in enumerate(self.equations.bodies)}
        for bodies, linear, angular, about in self.given.momenta:
            own = [places[name] for name in bodies]
            first, second = self.equations.momentum(own, self.poses, about)
            for vector, whole in ((linear, first), (angular, second)):
                for direction in vector:
                    names.append("")
                    numbers.append(
                        sum(HIGH.number(a) * b for a, b in zip(direction, whole, strict=True))
                    )
        mass = sum(body.mass for body in self.equations.bodies)
        size = mass * self.speed * max(1.0, self.reach + self.length)
        yield "momenta", self._made(names, numbers, size)

    def _forces(self) -> Iterator[tuple[str, dict[str, object]]]:
        """Forces and moments about the origin of frame O, and powers."""
        shares = self._shares()
        forces = [abs(float(x)) for x in self.found.force]
        heaviest = max((body.mass for body in self.equations.bodies), default=0.0)
        strength = max(self.solved.inertia_force, heaviest * self.acceleration, *forces)
        lam = [float(x) for x in self.solved.lam]
        for row in shares.values():
            for one in row[:3]:
                strength = max(strength, sum(abs(float(x) * lam[k]) for k, x in one))
        free = self.solved.free[:, self.equations.count :]
        for n, (what, size) in enumerate(
            (("force", strength), ("moment", strength * (self.reach + self.length)))
        ):
            names, numbers = [], []
            for name, row in shares.items():
                for one in row[3 * n : 3 * n + 3]:
                    names.append(name)
                    numbers.append(self._unique(one, free))
            yield what, self._made(names, numbers, size)
        powers = dict(self.found.powers)
        drivers: dict[str, list[tuple[int, Real]]] = {}
        for k, line in enumerate(self.solved.lines):
            if line.instance.is_driver:
                drivers.setdefault(line.instance.joint, []).append((k, -line.nu))
        rows = {name: self._unique(one, free) for name, one in drivers.items()}
        names = [*powers, *rows]
        yield (
            "power",
            self._made(
                names,
                [*powers.values(), *rows.values()],
                strength * self.speed * max(1.0, 1 / self.length),
            ),
        )

    def _unique(self, one: Sequence[tuple[int, Real]], free: Array) -> Real | None:
        """Sum Σ a λ, None where it is not unique."""
        factors = np.zeros(free.shape[1])
        for k, x in one:
            factors[k] += float(x)
        for direction in free:
            limit = UNIQUE * np.abs(factors).max(initial=0.0) * np.abs(direction).max(initial=0.0)
            if abs(factors @ direction) > limit:
                return None
        found: Real = sum((x * self.solved.lam[k] for k, x in one), HIGH.number(0))
        return found

    def _shares(self) -> dict[str, list[list[tuple[int, Real]]]]:
        """Shares by joint of its multipliers: force in frame O, moment about its origin.

        It is on body j, as −C_qᵀλ says; where that is the ground it is the opposite of that on i.
        Where a joint has more bodies each has its own.
        """
        found: dict[str, list[list[tuple[int, Real]]]] = {}
        joined: dict[str, dict[int, None]] = {}
        for line in self.solved.lines:
            joined.setdefault(line.instance.joint, {}).update(dict.fromkeys(line.instance.bodies))
        for k, line in enumerate(self.solved.lines):
            one = line.instance
            bodies = [*joined[one.joint]]
            ends = [body for body in bodies if body != GROUND_INDEX]
            if len(bodies) < 3:
                ends = [one.i if one.j == GROUND_INDEX else one.j]
            for body in ends:
                name = self.equations.bodies[body].name
                key = f"{one.joint}.{name}" if len(bodies) > 2 else one.joint
                sign = 1 if len(bodies) < 3 and one.j == GROUND_INDEX else -1
                row = found.setdefault(key, [[] for _ in range(6)])
                for own, x in zip(row, self._wrench(line, body), strict=True):
                    own.append((k, sign * x))
        return found

    def _wrench(self, line: ConstraintRow, body: int) -> list[Real]:
        """Row of C_q of a body as force in frame O and moment about its origin."""
        pose, own = self.poses[body], self.equations.own(body)
        jacobian = [line.jacobian.get(k, 0) for k in own]
        force, turning = jacobian[:3], jacobian[3:] or [0, 0, 0]
        moment = rotated(pose.p, turning)
        x, y, z = pose.r
        arm = (
            y * force[2] - z * force[1],
            z * force[0] - x * force[2],
            x * force[1] - y * force[0],
        )
        return [*force, *(a + b for a, b in zip(moment, arm, strict=True))]
