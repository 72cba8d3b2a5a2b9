"""A motion of a scene of bodies, row by row against the independent evaluator."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from tests.random_draft import UNITS
from tests.stress.changes import is_angle
from tests.stress.independent.evaluator import Evaluator
from tests.stress.independent.numbers import cross, minus, rotation, turned
from tests.stress.independent.solids import Pose
from tests.stress.independent.solving import solve

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from kousoku.mechanism import Mechanism
    from kousoku.runtime.integrate.motion import Motion
    from tests.stress.independent.evaluator import Evaluation
    from tests.stress.independent.solving import Solution

    Tree = dict[str, Any]
    Array = Any
    Measured = tuple[str, float, float]
    """A figure, its value, and the largest value that is right."""

SINGULAR = 1e4
"""From this condition on, rounding of positions decides more than digits of the accelerations."""

U = 2.0**-53
"""A unit of rounding. Limits are some times what fifty healthy scenes have at most, in units."""

ROUGH = 2.0**-24
"""How far forces may be that are a root of a coordinate near zero: some times the root of U. Their
works add up some of them: of a coordinate that is zero but for rounding each has another sign."""

REFINED = 1e-11
"""How far accelerations may be: some times the 2e-12 from which on a solver refines them."""

CLEAR = 1e4
"""How much larger the smallest singular value that counts is than the next one, at least."""


NEARLY_ZERO = 1e-9
"""Formulas of events that are nearer to zero in a row may be on either side of it."""

DIRECTIONS = {"both": (-1, 1), "rising": (1,), "falling": (-1,)}
"""To which signs the formula of an event changes."""


SMOOTH, WORKS = 1e-10, 5e-9
"""What integrals of powers may miss that tell works, and how far works may then be off: five
tolerances, as positions may be, for works are integrated by the same steps. Of powers that jump
the integral is known to half of what it may miss."""


def nodes(end: float, number: int = 17) -> Array:
    """Times at which powers are integrated, those of Clenshaw and Curtis."""
    times = end * (1 - np.cos(np.pi * np.arange(number) / (number - 1))) / 2
    times[-1] = end
    return times


def _integral(times: Array, values: Any) -> tuple[float, float]:
    """Integral of the polynomial through values at nodes, and what it may miss.

    That is the size of its last coefficients: they are small where values are smooth.
    """
    polynomial = np.polynomial.Chebyshev.fit(times, values, len(times) - 1)
    whole, span = polynomial.integ(), times[-1] - times[0]
    last = np.abs(polynomial.coef[len(times) // 2 + 1 :]).sum()
    return float(whole(times[-1]) - whole(times[0])), float(last * span)


def size_of(*arrays: Array) -> float:
    """Largest absolute value, 0 of nothing."""
    return max((abs(float(x)) for a in arrays for x in np.ravel(a)), default=0.0)


def _is_unclear(solution: Solution) -> bool:
    """Whether accelerations have few digits, or which rows are independent is a matter of them."""
    return solution.condition > SINGULAR or solution.gap < CLEAR


def _formulas(force: Mapping[str, Any]) -> list[str]:
    """Return the formulas of a force, those of its components, too."""
    parts = [one if isinstance(one, list) else [one] for one in force.values()]
    return [part for one in parts for part in one if isinstance(part, str)]


class Comparison:
    """A scene, and the evaluator of the same tree.

    Parameters
    ----------
    tree : dict
        The scene.
    mechanism : Mechanism
        What kousoku made of it.
    parameters : dict of str to float, optional
        Those of the run that are not as in the scene.

    Attributes
    ----------
    counts : Counter of str
        Accelerations that were compared, and what was not, as rounding of positions decides it.
    """

    def __init__(
        self, tree: Tree, mechanism: Mechanism, parameters: Mapping[str, float] | None = None
    ) -> None:
        self.tree, self.mechanism, self.counts = tree, mechanism, Counter[str]()
        self.metre = UNITS[tree["unit"]]
        self.evaluator = Evaluator(tree, parameters)
        self.start: Evaluation | None = None
        self.missed, self.rates_missed = 0.0, [0.0, 0.0]
        self.rough = ROUGH if "sqrt(" in str(tree.get("forces")) else 0.0

    def rows(self, run: Motion) -> Iterator[Measured]:
        """Distances of the rows of a motion from what the evaluator says of them."""
        length = max(1.0, run.layout.length)
        self.missed = run.ledger.trust.missed * length
        # what rows that are left out miss moves: by the rates, and theirs, that the run tells
        left_out = getattr(self.mechanism.solver, "left_out", ())
        told = [run.ledger.violations[joint] for joint in dict(left_out)]
        self.rates_missed = [
            max((max(one.metres[k], one.radians[k]) for one in told), default=0.0) for k in (1, 2)
        ]
        seen: list[tuple[float, Evaluation]] = []
        for k, found in enumerate(self.evaluations(run)):
            self.start = self.start or found
            seen.append((run.time[k], found))
            yield from self._constraints(found)
            yield from self._tables(run, k, found)
            if k in (0, len(run) - 1):
                yield from self._equations(run, k, found)
        yield from self._events(run, seen)

    def evaluations(self, run: Motion) -> Iterator[Evaluation]:
        """Evaluations of the rows of a motion, one after the other."""
        last = None
        for k in range(len(run)):
            t, q, v = run.state(k)
            found = self._at(t, q, v, last)
            last = (t, found)
            yield found

    def _at(
        self, t: float, q: Array, v: Array, last: tuple[float, Evaluation] | None
    ) -> Evaluation:
        """Evaluation of a row; angles went on by half of the time at the rate before and after."""
        state = self.evaluator.state_of(q.tolist(), v.tolist())
        if last is None:
            return self.evaluator.evaluate(t, state)
        near = last[1].turns((t - last[0]) / 2)
        found = self.evaluator.evaluate(t, state, near)
        half = {key: u.first[-2] * (t - last[0]) / 2 for key, u in found.angles.items()}
        near = {key: value + half[key] for key, value in near.items()}
        return self.evaluator.evaluate(t, state, near)

    def scales(self, found: Evaluation) -> Array:
        """Scales of the rows: what a metre or a radian of a body makes of them.

        So a coupler of angles with a displacement is measured as the angle that it is.
        """
        return self._of(found.C_q * self.units(found)).ravel()

    def _constraints(self, found: Evaluation) -> Iterator[Measured]:
        scales = self.scales(found)
        # rows that others imply but for the closure tolerance are open by what the run tells
        limit = 1000 * U + 2 * self.missed
        yield "rows of joints and drivers (m, rad)", size_of(found.C / scales), limit
        limit += 2 * self.rates_missed[0]
        rates = found.C_q @ found.v - found.nu
        yield "their rates (m/s, rad/s)", size_of(rates / scales) / (1 + self._speed(found)), limit

    def _speed(self, found: Evaluation) -> float:
        return size_of(found.v / self.units(found))

    def _tables(self, run: Motion, k: int, found: Evaluation) -> Iterator[Measured]:
        """Errors of results: coordinates, energies, forces of joints."""
        for name, u in found.coordinates.items():
            if name not in run.coordinate:
                continue
            of = self.metre if self._is_length(name) else 1.0
            off = size_of(run.coordinate[name][k] - u.value) / (of + abs(u.value))
            yield "coordinates (of 1 m or rad and more)", off, 20 * U
            rate = size_of(run.coordinate_rate[name][k] - u.first[-2]) / of
            yield "their rates (m/s, rad/s)", rate / (1 + self._speed(found)), 1000 * U
        if "energy.kinetic" in run and found.M is not None and self.start is not None:
            kinetic, potential = (run[f"energy.{one}"] for one in ("kinetic", "potential"))
            joule = self.metre**2
            size = joule + found.kinetic + abs(found.potential) + abs(self.start.potential)
            yield "kinetic energy (relative)", size_of(kinetic[k] - found.kinetic) / size, 30 * U
            off = potential[k] - found.potential
            yield "potential energy (relative)", size_of(off) / size, 60 * U

    def _events(self, run: Motion, seen: list[tuple[float, Evaluation]]) -> Iterator[Measured]:
        """Distances of formulas from zero at their events, and events that are not there."""
        for name, event in run.events.items():
            for k in range(len(event.states)):
                t, q, v = event.states.state(k)
                before = [row for row in seen if row[0] <= t][-1]
                found = self._at(t, q, v, before)
                off = abs(self._beyond(name, found))
                yield "formulas of events at their events (s, m, rad)", off, 100 * U
            signs = [self._beyond(name, found) for _, found in seen]
            signs = [1 if x > 0 else -1 for x in signs if abs(x) > NEARLY_ZERO]
            wanted = DIRECTIONS[self.tree["events"][name].get("direction", "both")]
            changes = [b for a, b in pairwise(signs) if a != b]
            missing = sum(b in wanted for b in changes) - event.count
            yield "events between rows that are missing (events)", max(0, missing), 0

    def _beyond(self, name: str, found: Evaluation) -> float:
        """Height above zero of the formula of an event, in seconds, metres or radians."""
        formula = found.events[name]
        lengths = [self.metre if self._is_length(name) else 1.0 for name in found.coordinates]
        rates = [size * (1 + self._speed(found)) for size in lengths]
        changes = np.abs(formula.first) @ [1.0, *lengths, *rates]
        return float(formula.value / changes) if changes else 0.0

    def works(self, run: Motion) -> Iterator[Measured]:
        """Distances of works from integrals of the evaluator's powers.

        Parameters
        ----------
        run : Motion
            With rows at :func:`nodes`.
        """
        powers: dict[str, list[float]] = {name: [] for name in run.ledger.works}
        for found in self.evaluations(run):
            known = dict(found.powers)
            if found.M is not None and powers.keys() - known.keys():
                solution = found.solution
                if _is_unclear(solution):
                    self.counts["motions whose works are too ill conditioned to compare"] += 1
                    return
                for owner in powers.keys() - known.keys():
                    pushes, left_open = found.pushes(owner)
                    is_known = size_of(left_open) <= 1e-6 * size_of(found.C_q)
                    known[owner] = pushes @ found.v if is_known else np.nan
            for name, own in powers.items():
                own.append(known[name])
        for name, own in powers.items():
            if np.isnan(own).any():
                continue
            work, missed = _integral(run.time, own)
            size = self.metre**2 + size_of(own) * run.time[-1]
            off = abs(run.ledger.works[name] / run.layout.unit**2 - work)
            off = max(0.0, off - 4 * self.rough * size)
            if missed <= SMOOTH * size:
                yield "works (relative)", off / size, WORKS
            else:
                yield "works of powers that jump or bend (relative)", off / missed, 0.5

    def _is_length(self, name: str) -> bool:
        one = self.tree["coordinates"][name]
        key = self.evaluator.joints.key_of(one)
        return key is None or "displacement" in key[1]

    def _equations(self, run: Motion, k: int, found: Evaluation) -> Iterator[Measured]:
        """Errors of M, f, C_q, ν, γ and what follows from them."""
        state = run.state(k)
        theirs = self.mechanism.matrices(*state)
        # Both choose rows of their own for a joint: one's are combinations of the other's.
        for owner in dict.fromkeys(found.owners):
            yield from self._rows_of(owner, found, theirs)
        units, joule, rough = self.units(found), self.metre**2, self.rough
        if found.M is not None:
            square = np.outer(units, units) / joule
            off = size_of((found.M - theirs.M) * square) / size_of(found.M * square)
            yield "mass matrix (relative)", off, 40 * U
            size = self._force(found, found.M @ found.v) + 1e-3 + self._stiffness()
            rough *= max(1.0, self._roots() / size)
            off = size_of((found.f - theirs.f) * units) / joule / size
            yield "applied forces (relative)", off, max(10000 * U, rough)
        solution = self._solution(found)
        if solution is None:
            return
        if _is_unclear(solution):
            self.counts["accelerations too ill conditioned to compare"] += 1
            return
        self.counts["accelerations compared"] += 1
        limit = 10 * U * solution.condition**2 + REFINED + rough * solution.condition
        limit += 2 * self.rates_missed[1]
        yield from self._accelerations(run, k, found, solution, limit)
        if found.M is None:
            return
        evaluated = self.mechanism.evaluate(*state)
        size = size_of(solution.v_dot / units) + self._speed(found) ** 2 + 1
        off = size_of((evaluated.v_dot - solution.v_dot) / units) / size
        yield "accelerations (relative)", off, limit
        size = self._force(found, found.M @ solution.v_dot, *(found.C_q.T * solution.lam).T) + 1e-3
        # rows in micrometres have elements of 1 and of 1e6, which cancel in the evaluator's sums
        limit += U * max(self.metre, 1 / self.metre)
        for owner in dict.fromkeys(found.owners):
            own = [row.partition(":")[0] == owner for row in theirs.rows]
            push = -theirs.C_q[own].T @ evaluated.lam[own]
            pushes, left_open = found.pushes(owner)
            if size_of(left_open) <= 1e-6 * size_of(found.C_q):
                off = size_of((push - pushes) * units) / joule / size
                yield "forces of joints and drivers (relative)", off, limit
                yield from self._wrench(run, k, owner, pushes, (size, limit))

    def _accelerations(
        self, run: Motion, k: int, found: Evaluation, solution: Solution, limit: float
    ) -> Iterator[Measured]:
        """Errors of the table of accelerations."""
        if "accelerations" not in self.tree["outputs"]:
            return
        tables = run.acceleration, run.angular_acceleration
        for name, own in found.columns.items():
            got = np.concatenate([table[name][k] for table in tables if name in table])
            units = self.units(found)[own]
            size = size_of(solution.v_dot / self.units(found)) + self._speed(found) ** 2 + 1
            off = size_of((got - solution.v_dot[own]) / units) / size
            yield "table of accelerations (relative)", off, limit

    def _wrench(
        self, run: Motion, k: int, owner: str, pushes: Array, known: tuple[float, float]
    ) -> Iterator[Measured]:
        """Errors of the tables of force and torque of a joint."""
        ends = self.evaluator.joints.ends.get(owner)
        if ends is None or "reactions" not in self.tree["outputs"]:
            return
        size, limit = known
        seen = 1 if ends.bodies[1] != "ground" else 0
        body, sign = ends.bodies[seen], 2 * seen - 1
        own = self.evaluator.columns[body]
        pose = self._pose(run, k, body)
        force = sign * pushes[own][:3]
        place = pose.place(ends.points[seen])
        if seen == 0:  # body j is the ground, and its point stays
            place = ends.points[1]
        moment = np.zeros(3)
        if own.stop - own.start > 3:
            moment = sign * np.array(turned(pose.A, pushes[own][3:]))
        moment -= np.array(cross(minus(place, pose.r), force))
        off = size_of(run.force[owner][k] - force) / self.metre / size
        yield "table of forces of joints (relative)", off, limit
        off = size_of(run.torque[owner][k] - moment) / self.metre**2 / size
        yield "table of torques of joints (relative)", off, limit

    def _pose(self, run: Motion, k: int, body: str) -> Pose:
        p = run.orientation[body][k] if body in run.orientation else [1, 0, 0, 0]
        return Pose(run.position[body][k], rotation(p))

    def _force(self, found: Evaluation, *also: Array) -> float:
        """Largest of some generalised forces in N and N m."""
        return size_of(*(f * self.units(found) for f in (found.f, *also))) / self.metre**2

    def _stiffness(self) -> float:
        """Largest force of a spring or bushing that a metre or a radian makes [N, N m].

        Those of one that is nearly relaxed are differences of positions, which both have rounded:
        relative to themselves they have as few digits as one likes.
        """
        read, sizes = self.evaluator.read.number, [0.0]
        for force in self.tree.get("forces", {}).values():
            given = force.get("stiffness", 0.0)
            six = given if isinstance(given, list) else [given]
            turns = force["type"] == "rotational_spring_damper" or is_angle(self.tree, force)
            units = [1.0] * 3 + [self.metre**2] * 3
            units = [self.metre**2] if turns else units[: len(six)]
            sizes += (abs(float(read(k))) / u for k, u in zip(six, units, strict=True))
        return max(sizes)

    def _roots(self) -> float:
        """Return the largest force that is a root of a metre or a radian [N, N m].

        Of a coordinate that is zero but for rounding that is what is rounded, whatever it pushes.
        """
        given = self.tree.get("coordinates", {})
        sizes = {name: self.metre if self._is_length(name) else 1.0 for name in given}
        names = {"t": 0.0, **sizes, **{f"{name}_dot": one for name, one in sizes.items()}}
        largest = 0.0
        for force in self.tree.get("forces", {}).values():
            turns = "torque" in force["type"] or is_angle(self.tree, force)
            unit = self.metre**2 if turns else self.metre
            for text in _formulas(force):
                if "sqrt(" in text:
                    largest = max(largest, abs(self.evaluator.read.number(text, names)) / unit)
        return largest

    def _rows_of(self, owner: str, found: Evaluation, theirs: Any) -> Iterator[Measured]:
        mine = [name == owner for name in found.owners]
        own = [row.partition(":")[0] == owner for row in theirs.rows]
        units = self.units(found)
        A, B = found.C_q[mine] * units, theirs.C_q[own] * units
        A, B = A / self._of(A), B / self._of(B)
        X = np.linalg.lstsq(A.T, B.T, rcond=None)[0].T if size_of(A) else np.zeros((len(B), len(A)))
        yield "Jacobian of joints (relative)", size_of(X @ A - B), 1000 * U
        sizes = self._of(found.C_q[mine] * units)[:, 0], self._of(theirs.C_q[own] * units)[:, 0]
        speed = self._speed(found)
        for name, power, most in (("nu", 1, 20), ("gamma", 2, 100)):
            x, y = getattr(found, name)[mine] / sizes[0], getattr(theirs, name)[own] / sizes[1]
            size = 1 + speed**power + size_of(x, y)
            yield f"{name} of joints (relative)", size_of(X @ x - y) / size, most * U

    @staticmethod
    def _of(A: Array) -> Array:
        """Largest element of each row, 1 of a row of zeros."""
        return np.array([[size_of(row) or 1.0] for row in A])

    def units(self, found: Evaluation) -> Array:
        """Amount of each column that a metre or a radian is."""
        sizes = np.ones(len(found.v))
        for own in found.columns.values():
            sizes[own.start : own.start + 3] = self.metre
        return sizes

    def _solution(self, found: Evaluation) -> Solution | None:
        if found.M is not None:
            return found.solution
        # Without masses accelerations follow where nothing is left free.
        solution = solve(np.eye(len(found.v)), found.C_q, found.gamma, 0 * found.v, 1e-7)
        rank = len(found.C) - solution.free.shape[1]
        return solution if rank == len(found.v) else None
