"""Initial values of coordinates and rates: from those of the scene to those that are given.

Coordinates are led from the start of the scene by small steps, on the branch on which it is
assembled. All is asked of ``evaluate``, which compiled solvers and those in NumPy have: rates
of coordinates are linear in v, so that unit velocities tell their Jacobian J, and ``dv`` projects
onto the constraints: what it makes of M⁻¹Jᵀ is the least motion that moves the coordinates.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .body_tables import indices, taken
from .euler_parameters import BACK, composed
from .start_evaluation import rates_of_rows

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from .arithmetic import Array
    from .body_tables import BodyPlaces
    from .start_evaluation import Evaluate


#: The largest of the first corrections after a step, lengths relative to the scene's.
LARGEST_CORRECTION = 0.02
#: The longest step, likewise.
LONGEST_CONTINUATION_STEP = 0.3
#: The largest change of direction from step to step, relative; other branches lead elsewhere.
LARGEST_TURN = 0.5
#: The shortest step, as a part of the way.
SHORTEST_PART = 1e-7
#: What steps that fail and that succeed are changed by: halves would meet the middle of a way,
#: where a parallelogram may lie flat.
SHRINK = 0.6
GROW = 1.7
#: A correction on the way that is small enough, and one at its end.
CORRECTION_ON_THE_WAY = 1e-6
ROUNDING_OF_COORDINATES = 1e-15
#: Corrections that may be larger than the one before, and corrections at most.
FIRST_CORRECTIONS = 3
MOST_CORRECTIONS = 30
#: A coordinate depends on others where so little of its motion is its own, squared.
DEPENDENT = 1e-10
#: One that is not given stays as in the scene where so much of its motion is its own, squared.
APART = 1e-4
#: Error that values may have which others determine.
AGREES = 1e-9
#: So many freedoms of bodies that no coordinate names are held.
MOST_HELD = 100


class InitialError(ValueError):
    """A run cannot start where it is told to."""


class Start(NamedTuple):
    """A scene where it starts.

    Parameters
    ----------
    evaluate : callable
        What :func:`.start_evaluation.evaluated` returns, with the parameters of the run.
    q, v : (nq,), (nv,) array
        Where the scene starts, on the constraints, in SI units.
    bodies : sequence of BodyPlaces
        In the order of the scene.
    coordinates : mapping of str to (int, int, float)
        Where value and rate of each coordinate stand among the coordinates, and its unit [SI].
    rows : sequence of (str, str)
        Joint or driver of each constraint, and its unit, in the order of ``C_dot``.
    works : sequence of int
        Places in q that are no positions.
    length : float [m]
        A length of the scene.
    unit : float [m]
        Its unit of length.
    """

    evaluate: Evaluate
    q: Array
    v: Array
    bodies: Sequence[BodyPlaces]
    coordinates: Mapping[str, tuple[int, int, float]]
    rows: Sequence[tuple[str, str]]
    works: Sequence[int]
    length: float
    unit: float


class Jacobian(NamedTuple):
    """Jacobian of the coordinates at some position.

    Parameters
    ----------
    J : (n, nv) array
        Rates of all coordinates per velocity.
    motions : (n, nv) array
        Least motion for each coordinate, on the constraints.
    free : (n, nv) array
        The same before they are brought onto the constraints.
    """

    J: Array
    motions: Array
    free: Array


class Leader:
    """Leader of coordinates of a scene to given values.

    Parameters
    ----------
    start : Start
        Where it starts.
    """

    def __init__(self, start: Start) -> None:
        self.start, self.evaluate = start, start.evaluate
        self.names = [*start.coordinates]
        table = np.array([*start.coordinates.values()]).reshape(-1, 3).T
        self.values, self.rates = table[:2].astype(int)
        self.units = table[2]
        self.rest = np.zeros(len(start.v))
        self.sizes = np.ones(len(start.v))
        self.sizes_q = np.ones(len(start.q))
        groups: dict[tuple[int, ...], None] = {}
        for body in start.bodies:
            for places, sizes in ((body.r, self.sizes_q), (body.v, self.sizes)):
                sizes[indices(places)] = start.length
            groups.setdefault(tuple(indices((*body.v, *body.omega_b))))
        self.moves = np.ones(len(start.q))
        self.moves[[*start.works]] = 0.0
        self.held = np.zeros((0, len(start.q)))
        self.probe = probe = self.sizes * np.cos(np.arange(len(start.v)))  # no special direction
        responses = (self._rates(probe * np.isin(np.arange(len(probe)), group)) for group in groups)
        moved = [group for group, rates in zip(groups, responses, strict=True) if rates.any()]
        self.support = sorted({k for group in moved for k in group})

    def _rates(self, v: Array) -> Array:
        rates: Array = self.evaluate(self.start.q, v)["coordinates"][self.rates]
        return rates

    def value(self, q: Array) -> Array:
        """Values (n + held,) [m, rad] of the coordinates at q (nq,), then of what is held."""
        values = self.evaluate(q, self.rest)["coordinates"][self.values]
        return np.concatenate([values, self.held @ q])

    def jacobian(self, q: Array) -> Jacobian:
        """Jacobian of the coordinates at q (nq,), with the motions that change them.

        Column k of J (n, nv) has the rates of the coordinates, then of what is held, where velocity
        k is 1 [m/s or rad/s]; motions are M⁻¹Jᵀ, and these on the constraints.
        """
        still = self.evaluate(q, self.rest)
        jacobian = np.zeros((len(self.names) + len(self.held), len(self.rest)))
        weights = np.ones(len(self.rest))
        for k in self.support:
            unit = self.rest.copy()
            unit[k] = 1.0
            response = self.evaluate(q, unit)
            held = self.held @ (response["q_dot"] * self.moves)
            jacobian[:, k] = np.concatenate([response["coordinates"][self.rates], held])
            mass = 2.0 * response["energies"][0]
            weights[k] = 1.0 / mass if mass > 0.0 else 1.0
        free = jacobian * weights
        motions = [motion + (self.evaluate(q, motion)["dv"] - still["dv"]) for motion in free]
        return Jacobian(jacobian, np.array(motions).reshape(free.shape), free)

    def independent(
        self, at: Jacobian, prescribed: Sequence[int], first: Sequence[int] = ()
    ) -> list[int]:
        """Coordinates that are independent of those before them; prescribed ones come first."""
        chosen: list[int] = []
        mobility = at.J @ at.motions.T
        free_mobility = np.einsum("kv,kv->k", at.J, at.free)
        for k in dict.fromkeys((*prescribed, *first, *range(len(self.names)))):
            remainder = mobility[k, k]
            if chosen:
                block = mobility[chosen][:, chosen]
                remainder -= mobility[k, chosen] @ np.linalg.solve(block, mobility[chosen, k])
            if remainder > (DEPENDENT if k in prescribed else APART) * free_mobility[k]:
                chosen.append(k)
        return chosen

    def size(self, u: Array) -> float:
        """Largest element of a displacement (nv,) [m, rad], lengths relative to the scene's [-]."""
        return float(np.max(np.abs(u) / self.sizes, initial=0.0))

    def displaced(self, q: Array, u: Array) -> Array:
        """Position q + q̇(u) · 1 s (nq,), displaced by a velocity u (nv,) in unit time.

        Works stay what they are.
        """
        return q + self.moves * self.evaluate(q, u)["q_dot"]

    def corrected(
        self, q: Array, motions: Array, chosen: Sequence[int], goal: Array, tolerance: float
    ) -> tuple[Array, float]:
        """Position near q that meets constraints and the goal, and what it still misses.

        That is infinite where the first correction is not small.

        Parameters
        ----------
        q : (nq,) array
            Where it begins, in SI units.
        motions : (c, nv) array
            As of :meth:`motions`.
        chosen : sequence of int
            Which c coordinates.
        goal : (c,) array [m, rad]
            Their values.
        tolerance : float [-]
            What may be missed, lengths relative to that of the scene.

        Returns
        -------
        (nq,) array, float [-]
            The position, and the last correction, lengths relative to that of the scene.
        """
        last = np.inf
        for attempt in range(MOST_CORRECTIONS):
            moved = self.evaluate(q, self.rest)["q_moved"]
            displacement = (goal - self.value(moved)[chosen]) @ motions
            change = float(np.max(np.abs(moved - q) / self.sizes_q, initial=0.0))
            correction = max(change, self.size(displacement))
            if not correction <= (LARGEST_CORRECTION if attempt < FIRST_CORRECTIONS else last):
                break
            q, last = self.displaced(moved, displacement), correction
            if correction <= tolerance:
                break
        return q, last

    def led(self, q: Array, chosen: Sequence[int], wanted: Array) -> tuple[Array, float]:
        """Position (nq,) on the way to values of coordinates, and which part [-] of it was made.

        q (nq,) is where it begins, ``wanted`` (c,) [m, rad] the values of the c coordinates chosen.
        """
        if not chosen:
            return q, 1.0
        begin = self.value(q)[chosen]
        change = wanted - begin
        made, step = 0.0, 1.0
        motions = self.motions(self.jacobian(q), chosen)
        while made < 1.0:
            direction = change @ motions
            size = self.size(direction)
            step = min(step, LONGEST_CONTINUATION_STEP / size if size > 0.0 else 1.0)
            following = min(made + step, 1.0)
            goal = wanted if following == 1.0 else begin + following * change
            trial = self.displaced(q, (following - made) * direction)
            trial, correction = self.corrected(trial, motions, chosen, goal, CORRECTION_ON_THE_WAY)
            if correction <= CORRECTION_ON_THE_WAY:
                trial_motions = self.motions(self.jacobian(trial), chosen)
                if self.size(change @ trial_motions - direction) <= LARGEST_TURN * size:
                    q, motions, made, step = trial, trial_motions, following, GROW * step
                    continue
            step *= SHRINK
            if not step >= SHORTEST_PART:
                return q, made
        return q, 1.0

    def motions(self, at: Jacobian, chosen: Sequence[int]) -> Array:
        """Least motions W (c, nv) that move one of the c coordinates each: J Wᵀ = 1.

        In SI units, per unit of the coordinate: m or rad.
        """
        block = at.J[chosen] @ at.motions[chosen].T
        try:
            return np.asarray(np.linalg.solve(block.T, at.motions[chosen]), np.float64)
        except np.linalg.LinAlgError:
            return np.full((len(chosen), len(self.rest)), np.inf)

    def polished(self, q: Array, chosen: Sequence[int], wanted: Array) -> Array:
        """Position (nq,) that meets constraints and values (c,) [m, rad] to rounding."""
        before = np.inf
        for _ in range(MOST_CORRECTIONS):
            q, correction = self.corrected(
                q, self.motions(self.jacobian(q), chosen), chosen, wanted, ROUNDING_OF_COORDINATES
            )
            if correction <= ROUNDING_OF_COORDINATES or not correction < 0.5 * before:
                break
            before = correction
        return q

    def hold(self, at: Jacobian, chosen: Sequence[int]) -> None:
        """Hold bodies where coordinates leave them free: first they do not turn, then not move.

        Both are linear in q: where a body is, and 2(p₀*∘p), with p₀ at the start.
        """
        pairs = [*zip(at.J[chosen], self.motions(at, chosen), strict=True)]
        bodies = self.start.bodies
        columns = {k: (body, n) for body in bodies for n, k in enumerate(body.omega_b)}
        columns |= {k: (body, n) for body in bodies for n, k in enumerate(body.v)}
        for k, (body, n) in columns.items():
            if (
                self.size(self._free_part(self.probe, pairs)) <= CORRECTION_ON_THE_WAY
                or len(self.held) == MOST_HELD
            ):
                break
            if not isinstance(k, int):
                continue
            unit = self.rest.copy()
            unit[k] = 1.0
            motion = self._free_part(unit, pairs)
            if motion[k] > APART:
                pairs.append((unit, motion / motion[k]))
                row = np.zeros(len(self.start.q))
                if k in body.v:
                    row[indices(body.r[n : n + 1])] = 1.0
                else:
                    back = (taken(body.p, self.start.q) * BACK)[:, np.newaxis]
                    turned = composed(back, np.eye(4))[1 + n]
                    row[indices(body.p)] = 2.0 * turned[[isinstance(m, int) for m in body.p]]
                self.held = np.vstack([self.held, row])
                self.support = sorted({*self.support, *indices((*body.v, *body.omega_b))})

    def _free_part(self, u: Array, pairs: Sequence[tuple[Array, Array]]) -> Array:
        """Part of a displacement at the start that opens no joint, and changes nothing else."""
        still = self.evaluate(self.start.q, self.rest)["dv"]
        for _ in range(2):
            u = u + (self.evaluate(self.start.q, u)["dv"] - still)
            for slopes, motion in pairs:
                u = u - (slopes @ u) * motion
        return u

    def velocities(self, q: Array, at: Jacobian, chosen: Sequence[int], wanted: Array) -> Array:
        """Velocities v (nv,) of the scene at q (nq,) with wanted rates, projected once.

        v + (wanted − J v) W with W of :meth:`motions` and the rates (c,) [m/s, rad/s].
        """
        v, motions = self.start.v, self.motions(at, chosen)
        for _ in range(2):  # the second time takes away what is rounded in the first
            v = v + self.evaluate(q, v)["dv"]
            v = v + (wanted - at.J[chosen] @ v) @ motions
        return v

    def drivers(self, q: Array, slopes: Array) -> str:
        """Drivers that a coordinate follows from, all where they leave nothing free.

        ``slopes`` (nv,) is its row of J at q (nq,): by least squares it is Σ share · row of C_q.
        """
        rows = rates_of_rows(self.evaluate, q, self.sizes)
        wanted = slopes * self.sizes
        shares, _, rank, _ = np.linalg.lstsq(rows, wanted, rcond=DEPENDENT)
        size = CORRECTION_ON_THE_WAY * float(np.linalg.norm(wanted))
        if not np.linalg.norm(rows @ shares - wanted) <= size:
            return ""  # it is free
        weights = np.abs(shares) * np.linalg.norm(rows, axis=0)
        names = [name for name, _ in self.start.rows]
        contributing = [name for name, weight in zip(names, weights, strict=True) if weight > size]
        drivers = [name for name in contributing if name.startswith("drivers.")]
        if not drivers and rank == len(rows):  # a dead centre of what drivers determine
            drivers = [name for name in names if name.startswith("drivers.")]
        return ", ".join(dict.fromkeys(drivers))


def lead(start: Start, initial: Mapping[str, float]) -> tuple[Array, Array]:
    """Start of a scene, q and v, when some coordinates and rates are given.

    Coordinates that are not given stay as they are in the scene where they do not depend on those
    that are; rates likewise, at last. What else is free moves as little as it can.

    Parameters
    ----------
    start : Start
        The scene.
    initial : mapping of str to float
        Values by the names of coordinates, ``theta``, and rates, ``theta_dot``, in the unit of the
        scene; angles count turns.

    Returns
    -------
    q, v : (nq,), (nv,) array
        On the constraints, in SI units.

    Raises
    ------
    InitialError
        They cannot be reached, or contradict drivers or each other.
    """
    leader, q = Leader(start), start.q
    known = [*leader.names, *(f"{name}_dot" for name in leader.names)]
    if strange := [name for name in initial if name not in known]:
        raise InitialError(f"initial values of {strange}; wanted of {known}")
    at = leader.jacobian(q)
    values = {leader.names.index(name): x for name, x in initial.items() if name in leader.names}
    rates = {
        leader.names.index(name.removesuffix("_dot")): x
        for name, x in initial.items()
        if name not in leader.names
    }
    if values:
        named = leader.independent(at, [*values])
        leader.hold(at, named)
        count = len(leader.names)
        wanted = leader.value(q)
        wanted[[*values]] = [*values.values()] * leader.units[[*values]]
        # what is not given is held only where all of it can be
        tries = (
            [*named, *range(count, len(wanted))],
            named,
            [k for k in named if k in values],
        )
        for chosen in tries:
            q, made = leader.led(start.q, chosen, wanted[chosen])
            if made == 1.0:
                break
        else:
            raise InitialError(_too_far(leader, q, {k: values[k] for k in chosen}, made))
        q = leader.polished(q, chosen, wanted[chosen])
        q[[*start.works]] = start.q[[*start.works]]
        leader.held = leader.held[:0]
        at = leader.jacobian(q)
        _require(leader, q, at, values, leader.value(q), "")
    wanted = start.evaluate(start.q, start.v)["coordinates"][leader.rates]
    wanted[[*rates]] = [*rates.values()] * leader.units[[*rates]]
    chosen = leader.independent(at, [*rates], [*values])
    v = leader.velocities(q, at, chosen, wanted[chosen])
    _require(leader, q, at, rates, start.evaluate(q, v)["coordinates"][leader.rates], "_dot")
    return q, v


def _beside(wanted: float, value: float) -> str:
    """Value as text; beside what is wanted, rounding of zero is zero."""
    return "0" if abs(value) < 1e-12 * abs(wanted) else f"{value:.9g}"


def _too_far(leader: Leader, q: Array, values: Mapping[int, float], made: float) -> str:
    """Say how far coordinates were led."""
    count = len(leader.names)
    reached, begun = (leader.value(point)[:count] / leader.units for point in (q, leader.start.q))
    texts = [
        f"{leader.names[k]} comes from {_beside(wanted, begun[k])} to"
        f" {_beside(wanted, reached[k])} of {wanted:.9g}"
        for k, wanted in values.items()
    ]
    return (
        f"initial values are not reached: {', '.join(texts)} ({100.0 * made:.3g} % of the way);"
        " joints or drivers lead no further, as at a dead centre, or rows become dependent there"
    )


def _require(
    leader: Leader, q: Array, at: Jacobian, values: Mapping[int, float], reached: Array, suffix: str
) -> None:
    """Refuse values that are not met: drivers determine them, or they depend on each other."""
    problems = []
    for k, wanted in values.items():
        value = reached[k] / leader.units[k]
        if not abs(value - wanted) <= AGREES * max(1.0, abs(wanted)):
            name = f"{leader.names[k]}{suffix}"
            drivers = leader.drivers(q, at.J[k])
            if drivers:
                why = f"wanted {value:.9g}: {drivers} says so at t = 0"
            elif leader.independent(at, [k])[:1] != [k]:
                why = _dead_centre(leader, at, k, value, suffix)
            else:
                why = f"wanted {value:.9g}: it follows from the rest"
            problems.append(f"{name} is {wanted!r}, {why}")
    if problems:
        raise InitialError(f"initial values do not fit: {'; '.join(problems)}")


def _dead_centre(leader: Leader, at: Jacobian, k: int, now: float, suffix: str) -> str:
    """Say that nothing leads a coordinate from where its rate is zero, and what to give instead."""
    name = leader.names[k]
    free = leader.independent(at, [])
    instead = " or ".join(leader.names[j] for j in free) or "another coordinate of the scene"
    moved = f"its rate is 0 there, however {instead} moves" if free else "its rate is 0 there"
    if suffix:
        return f"wanted {now:.9g}: this place is a dead centre of {name}, {moved}"
    return (
        f"but stays at {now:.9g}: the start is a dead centre of {name}, {moved}, and on which side"
        f" it would go on is open; give {instead} instead, which leads it there, or q0 and v0"
    )
