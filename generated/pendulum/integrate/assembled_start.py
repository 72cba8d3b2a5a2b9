"""Start of a run with other parameters, assembled anew: as of the scene file with these.

Bodies are where they fit nearest to where the scene has them, weighed with masses and moments of
inertia; their velocities are those of the scene there, changed by the least. Assembly found both
for the parameters of the scene, and they fit there only. The way from there to the parameters of
the run chooses the branch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .body_tables import body_tables, indices
from .euler_parameters import BACK, composed, crossed, rotated

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from .arithmetic import Array
    from .motion import Layout
    from .start_evaluation import Evaluate

#: Least moment of inertia that weighs a displacement, as a part of the largest of the body.
THIN = 1e-3
#: The longest step towards the nearest place, lengths relative to the scene's.
LONGEST_PROJECTION_STEP = 0.3
#: Steps at most, and those that need not be smaller than the one before: Euler parameters get norm
#: one in the first.
MOST_PROJECTION_STEPS = 100
FIRST_PROJECTION_STEPS = 3
#: A step that counts as rounding, and one that is small enough where rounding goes on.
ROUNDING_OF_PROJECTION_STEPS = 1e-15
SMALL_PROJECTION_STEP = 1e-12
#: Below this angle [rad] the first term of a series has all digits.
SERIES = 1e-4
#: The note where no step leads nearer.
NOT_NEAREST = (
    "with these parameters bodies begin where they follow to from the start of the scene: the"
    " nearest place, where the file with them has bodies, was not found"
)
#: Notes leave out changes below this part of a scene's length or speed: "near" means that.
TOLD = 1e-2
#: Changes below this part of them are rounding of the digits that people give.
KNOWN = 1e-6
#: Bodies that notes name.
MOST_BODIES_NAMED = 4
#: How a note on a body that starts elsewhere begins.
CHANGED = "assembly changed"
#: A point does not turn.
NO_TURN = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class WrittenBody:
    """A body at the start, as the scene gives it.

    Parameters
    ----------
    position : (3,) [unit of the scene], or (0,)
        Of the origin of its frame, frame O; empty where assembly holds positions.
    orientation : (4,)
        Euler parameters of its frame.
    velocity : (3,) [unit of the scene per s]
        Of that origin, frame O.
    spin : (3,) [rad/s]
        Angular velocity.
    is_in_o : bool
        Whether its components are in frame O, not in the frame of the body.
    mass_properties : (11,)
        Its mass [kg], principal moments [kg m²], and of its own principal frame ``origin_b`` [m]
        and ``axes_b``, as of :class:`.body_tables.BodyPlaces`: another body may carry it. An index
        of the design stands in place of a number that depends on parameters.
    """

    position: tuple[float, ...]
    orientation: tuple[float, ...]
    velocity: tuple[float, ...]
    spin: tuple[float, ...]
    is_in_o: bool
    mass_properties: tuple[int | float, ...]

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> WrittenBody:
        """Start that the scene gives a body, from ``motion.json``."""
        names = ("position", "orientation", "velocity", "spin", "mass_properties")
        return cls(is_in_o=data["is_in_o"], **{name: tuple(data[name]) for name in names})


class Places:
    """Places of components of bodies in q or v; a number that never changes stands for itself.

    Parameters
    ----------
    rows : sequence of sequence
        For each body the places of its components.
    """

    def __init__(self, rows: Sequence[Sequence[int | float]]) -> None:
        flat = [[(k, 0.0) if isinstance(k, int) else (-1, k) for k in row] for row in rows]
        table = np.array(flat, dtype=np.float64).reshape(len(rows), -1, 2).T
        self.at, self.numbers = table[0].astype(int), table[1]
        self.moves = self.at >= 0

    def of(self, source: Array) -> Array:
        """Components (components, bodies) of bodies in q or v (n,), in their units."""
        components: Array = np.where(self.moves, source[self.at], self.numbers)
        return components

    def put(self, target: Array, values: Array) -> None:
        """Write the components (components, bodies) that have a place to q or v (n,)."""
        target[self.at[self.moves]] = values[self.moves]


class WrittenBodies:
    """The bodies of a scene as it gives them, each in the principal frame of what carries it.

    A body carries itself, or another one that it is fixed to. Components stand before bodies.

    Parameters
    ----------
    layout : Layout
        What stands where, with the parameters of the run.
    """

    def __init__(self, layout: Layout) -> None:
        pairs = zip(layout.bodies, layout.given, strict=True)
        moving = [(body, start) for body, start in pairs if indices((*body.v, *body.omega_b))]
        keys = [(*body.r, *body.p, *body.v, *body.omega_b) for body, _ in moving]
        carriers = {key: body for key, (body, _) in reversed([*zip(keys, moving, strict=True)])}
        order = {key: k for k, key in enumerate(carriers)}
        self.carrier, self.count = np.array([order[key] for key in keys], dtype=int), len(order)
        bodies = [*carriers.values()]
        self.r, self.v = Places([body.r for body in bodies]), Places([body.v for body in bodies])
        self.p = Places([body.p or NO_TURN for body in bodies])
        self.omega_b = Places([body.omega_b or (0.0,) * 3 for body in bodies])
        table = np.array([start.mass_properties for _, start in moving]).T
        self.mass, self.inertia, arm, principal = table[0], table[1:4], table[4:7], _back(table[7:])
        self.heavy = np.maximum(self.inertia, THIN * self.inertia.max(axis=0))
        self.frame = np.array([body.axes_b for body, _ in moving]).T
        self.origin = np.array([body.origin_b for body, _ in moving]).T
        self.axes = composed(self.frame, principal)
        self.center = self.origin - rotated(self.axes, arm)
        self.written_p = composed(np.array([start.orientation for _, start in moving]).T, principal)
        self.has_places = all(start.position for _, start in moving)
        if self.has_places:
            position = layout.unit * np.array([start.position for _, start in moving]).T
            self.written_r = position - rotated(self.written_p, arm)
        self.velocity = layout.unit * np.array([start.velocity for _, start in moving]).T
        self.spin = np.array([start.spin for _, start in moving]).T
        self.is_in_o = np.array([start.is_in_o for _, start in moving])
        self.masses = self._summed(self.mass[np.newaxis])[0]
        self.moments = self._summed(self._moments_about_origins())

    def _summed(self, values: Array) -> Array:
        """Sums of values (n, bodies) over the bodies of each carrier, (n, carriers)."""
        sums = np.zeros((len(values), self.count))
        np.add.at(sums.T, self.carrier, values.T)
        return sums

    def _moments_about_origins(self) -> Array:
        """Moments of inertia about the axes of the principal frame of the carrier, (3, bodies)."""
        moments: Array = self.mass * ((self.center**2).sum(axis=0) - self.center**2)
        for axis, moment in zip(np.eye(3)[:, :, np.newaxis], self.inertia, strict=True):
            moments += moment * rotated(self.axes, np.broadcast_to(axis, moments.shape)) ** 2
        return moments

    def _put(self, u: Array, turn: Array, linear: Array, angular: Array) -> None:
        """Write M⁻¹ times a force and torque, or momentum, in the frames of carriers."""
        force, torque = self._summed(linear), self._summed(crossed(self.center, linear) + angular)
        self.v.put(u, rotated(turn, force) / self.masses)
        rotation = np.zeros_like(torque)
        self.omega_b.put(u, np.divide(torque, self.moments, out=rotation, where=self.moments > 0.0))

    def move(self, q: Array, v: Array) -> None:
        """Write velocities v (nv,) [m/s, rad/s] of the scene at q (nq,).

        Bodies of one carrier have the sum of their momenta.
        """
        turn = self.p.of(q)
        back = _back(turn)[:, self.carrier]
        omega = np.where(self.is_in_o, rotated(back, self.spin), rotated(self.frame, self.spin))
        velocity = rotated(back, self.velocity) + crossed(omega, self.center - self.origin)
        spin = rotated(self.axes, self.inertia * rotated(_back(self.axes), omega))
        self._put(v, turn, self.mass * velocity, spin)

    def pull(self, q: Array, u: Array) -> None:
        """Write u = M⁻¹ f (nv,) [m, rad], f the gradient of ½ dᵀ W d at q (nq,).

        d is the displacement since the scene, W has masses and moments of inertia. u is in the
        order of v, lengths in frame O and turns in principal frames.
        """
        r, turn = self.r.of(q), self.p.of(q)
        p = turn[:, self.carrier]
        displacement = r[:, self.carrier] + rotated(p, self.center) - self.written_r
        relative = composed(_back(self.written_p), composed(p, self.axes))
        sine = np.sqrt((relative[1:] ** 2).sum(axis=0))
        angle = 2.0 * np.arctan2(sine, np.abs(relative[0]))
        half = np.maximum(angle, SERIES) / 2.0
        # with T of a rotation vector w, δθ′ = T dw, the torque is T⁻ᵀ I′ w
        w = relative[1:] * np.copysign(angle / np.where(sine > 0.0, sine, 1.0), relative[0])
        factor = np.where(angle > SERIES, (1.0 - half / np.tan(half)) / half**2 / 4.0, 1.0 / 12.0)
        effort = self.heavy * w
        across = crossed(w, effort)
        torque = effort - across / 2.0 + factor * crossed(w, across)
        force = self.mass * rotated(_back(p), displacement)
        self._put(u, turn, force, rotated(self.axes, torque))


class Moved(NamedTuple):
    """Change of a body by assembly, from what the scene gives to what joints and drivers allow.

    Parameters
    ----------
    moved, turned : float [m], float [rad]
        Its frame.
    velocity, angular_velocity : float [m/s], float [rad/s]
        Where the scene gives one: joints and drivers say what the others have.
    """

    moved: float
    turned: float
    velocity: float
    angular_velocity: float

    def __str__(self) -> str:
        return (
            f"{self.moved:.3g} m, {self.turned:.3g} rad, {self.velocity:.3g} m/s,"
            f" {self.angular_velocity:.3g} rad/s"
        )


class Change(NamedTuple):
    """A body that assembly changed.

    Parameters
    ----------
    body : str
        Its name.
    sizes : Moved
        By how much.
    parts : (4,) tuple of float
        The same, relative to the scene's length, one radian, and the body's speed.
    """

    body: str
    sizes: Moved
    parts: tuple[float, ...]

    def note(self, metres: float, unit: str) -> str:
        """Line on the change, in a unit of so many metres; empty of what is near."""
        texts = (
            f"moved by {self.sizes.moved / metres:.3g} {unit}",
            f"turned by {math.degrees(self.sizes.turned):.3g} deg",
            f"velocity by {self.sizes.velocity / metres:.3g} {unit}/s",
            f"angular velocity by {self.sizes.angular_velocity:.3g} rad/s",
        )
        parts = [text for text, part in zip(texts, self.parts, strict=True) if part > TOLD]
        return f"{CHANGED} bodies.{self.body}: {', '.join(parts)}" if parts else ""


def notes_of(changes: Sequence[Change], metres: float, unit: str) -> tuple[str, ...]:
    """Notes on bodies that are not near where the scene has them, in its unit of length."""
    notes = [note for change in changes if (note := change.note(metres, unit))]
    if len(notes) > MOST_BODIES_NAMED:
        notes[MOST_BODIES_NAMED:] = [
            f"{CHANGED} {len(notes) - MOST_BODIES_NAMED} more bodies, by less"
        ]
    return tuple(notes)


def known(changes: Iterable[Change]) -> list[Change]:
    """Changes that are larger than digits that a scene leaves out, the largest first."""
    changed = (change for change in changes if max(change.parts) > KNOWN)
    return sorted(changed, key=lambda change: -max(change.parts))


def changes_of(layout: Layout, q: Array, v: Array) -> list[Change]:
    """Changes of the start that the scene gives, the largest first.

    They are those to q (nq,) and v (nv,) of the solver, in SI units.
    """
    tables = body_tables(layout.bodies, q[np.newaxis], v[np.newaxis], None, layout.unit)
    changes = []
    for body, written in zip(layout.bodies, layout.given, strict=True):
        position, velocity = (tables[x][body.name][0] for x in ("position", "velocity"))
        shift = _norm(position - written.position) if written.position else 0.0
        angle = spun = spin = 0.0
        if body.p:
            p = tables["orientation"][body.name].T
            turn = composed(_back(np.array([written.orientation]).T), p)
            angle = 2.0 * math.atan2(_norm(turn[1:]), abs(turn[0].item()))
            omega, spin = tables["angular_velocity"][body.name].T, _norm(written.spin)
            omega = rotated(p, omega) if written.is_in_o else omega
            spun = _norm(omega[:, 0] - written.spin) if spin else 0.0
        speed, length = _norm(written.velocity), layout.length / layout.unit
        change = _norm(velocity - written.velocity) if speed else 0.0
        fastest = speed + spin * length
        rates = (change / fastest, spun * length / fastest) if fastest else (0.0, 0.0)
        sizes = Moved(shift * layout.unit, angle, change * layout.unit, spun)
        changes.append(Change(body.name, sizes, (shift / length, angle, *rates)))
    return known(changes)


def _norm(a: Any) -> float:
    return float(np.linalg.norm(a))


def assembled_start(
    layout: Layout, evaluate: Evaluate, y: Array, *, is_told: bool = True
) -> tuple[Array, Array, Layout, list[Change]]:
    """Start, q and v, with the parameters of a run, and what these change.

    The layout has notes on that, in place of those on the start with the parameters of the scene.
    Velocities are projected onto the constraints once: to do it again takes away what is rounded.

    Parameters
    ----------
    layout : Layout
        What stands where, with the parameters of the run.
    evaluate : callable
        What :func:`.start_evaluation.evaluated` returns, with these parameters.
    y : (nq + nv,) array
        Where bodies fit, on the branch of the scene: q, then some v, in SI units.
    is_told : bool
        Whether changes are noted: not where the caller places the bodies.

    Returns
    -------
    q, v : (nq,), (nv,) array
        On the constraints, in SI units.
    layout, changes : Layout, list of Change
        With the notes, and what they tell.
    """
    bodies, count = WrittenBodies(layout), layout.sizes["q"]
    q, v = y[:count].copy(), y[count:].copy()
    if bodies.has_places:
        nearest_q = nearest(layout, bodies, evaluate, q)
        if nearest_q is None:
            layout = replace(layout, notes=(*layout.notes, NOT_NEAREST))
        else:
            q = nearest_q
    bodies.move(q, v)
    v += evaluate(q, v)["dv"]
    changes = changes_of(layout, q, v) if is_told else []
    notes = [note for note in layout.notes if not note.startswith(CHANGED)]
    change_notes = notes_of(changes, layout.unit, layout.unit_name)
    return q, v, replace(layout, notes=(*change_notes, *notes)), changes


def nearest(layout: Layout, bodies: WrittenBodies, evaluate: Evaluate, q: Array) -> Array | None:
    """Place (nq,) nearest to where the scene has its bodies, that can be reached from q (nq,).

    There the gradient f of ½ dᵀ W d is normal to the constraints: the tangent part of −M⁻¹ f is a
    step towards it, as long as Barzilai and Borwein take it. None where it leads nowhere. SI units.
    """
    rest, moves = np.zeros(layout.sizes["v"]), np.ones(len(q))
    moves[[index for _, index in layout.works]] = 0.0
    sizes, sizes_q, weights = np.ones(len(rest)), np.ones(len(q)), np.ones(len(rest))
    lengths = np.full((3, bodies.count), layout.length)
    for target, places, values in (
        (sizes, bodies.v, lengths),
        (sizes_q, bodies.r, lengths),
        (weights, bodies.v, np.tile(bodies.masses, (3, 1))),
        (weights, bodies.omega_b, bodies.moments),
    ):
        places.put(target, values)
    last, before, step = np.inf, rest, rest
    for _ in range(MOST_PROJECTION_STEPS):
        u = rest.copy()
        bodies.pull(q, u)
        u += evaluate(q, u)["dv"] - evaluate(q, rest)["dv"]
        size = float(np.max(np.abs(u) / sizes, initial=0.0))
        if size <= ROUNDING_OF_PROJECTION_STEPS or (
            size <= SMALL_PROJECTION_STEP and size > 0.5 * last
        ):
            return q
        bend = step @ (weights * (u - before))
        part = float(step @ (weights * step) / bend) if bend > 0.0 else 1.0
        before, step = u, -min(part, LONGEST_PROJECTION_STEP / size) * u
        closed = _closed(evaluate, q + moves * evaluate(q, step)["q_dot"], rest, sizes_q)
        if closed is None:
            break
        q, last = closed, size
    return None


def _closed(evaluate: Evaluate, q: Array, rest: Array, sizes: Array) -> Array | None:
    """Position near q that meets the constraints; None where it is not near."""
    last = np.inf
    for attempt in range(MOST_PROJECTION_STEPS):
        moved = evaluate(q, rest)["q_moved"]
        change = float(np.max(np.abs(moved - q) / sizes, initial=0.0))
        if change <= ROUNDING_OF_PROJECTION_STEPS or (
            change <= SMALL_PROJECTION_STEP and change > 0.5 * last
        ):
            return moved
        if not (change < last or attempt < FIRST_PROJECTION_STEPS):
            break
        q, last = moved, change
    return None


def _back(p: Array) -> Array:
    """Euler parameters of the opposite rotations."""
    turned: Array = p * BACK[:, np.newaxis]
    return turned
