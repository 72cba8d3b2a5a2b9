"""The start of a run with other parameters than the scene's: what the file with these would have.

Bodies are where they fit nearest to where the scene has them, weighed with masses and moments of
inertia; their velocities are those of the scene there, changed by the least. Assembly found both
for the parameters of the scene, and they fit there only. The way from there to the parameters of
the run chooses the branch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .body_tables import BACK, composed, crossed, indices, put, rotated, taken

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    import numpy.typing as npt

    from .body_tables import BodyPlaces
    from .initial import Evaluate
    from .motion import Layout

    Array = npt.NDArray[np.float64]

#: Least moment of inertia that weighs a displacement, as a part of the largest of the body.
THIN = 1e-3
#: The longest step towards the nearest place, lengths relative to the scene's; steps at most, of
#: which so many need not be smaller than the one before, as where Euler parameters get norm one.
LONGEST, MOST, FIRST = 0.3, 100, 3
#: A step that counts as rounding, and one that is small enough where rounding goes on.
ROUNDING, SMALL = 1e-15, 1e-12
#: Below this angle [rad] a series has all digits.
SERIES = 1e-3


@dataclass(frozen=True, slots=True)
class GivenStart:
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
    weight : (11,)
        Its mass [kg], principal moments [kg m²], and of its own principal frame ``origin_b`` [m]
        and ``axes_b``, as of :class:`.body_tables.BodyPlaces`: another body may carry it. An index
        of the design stands in place of a number that depends on parameters.
    """

    position: tuple[float, ...]
    orientation: tuple[float, ...]
    velocity: tuple[float, ...]
    spin: tuple[float, ...]
    is_in_o: bool
    weight: tuple[int | float, ...]

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> GivenStart:
        """Return what ``motion.json`` says of a body."""
        return cls(**{key: tuple(x) if isinstance(x, list) else x for key, x in data.items()})


class Member:
    """A body, in the principal frame of what carries it: itself, or one that others are fixed to.

    Parameters
    ----------
    body : BodyPlaces
        Where it stands in q and v.
    given : GivenStart
        As the scene gives it.
    unit : float [m]
        The unit of the scene.
    """

    def __init__(self, body: BodyPlaces, given: GivenStart, unit: float) -> None:
        weight = np.array(given.weight)
        self.mass, self.inertia, arm, own = weight[0], weight[1:4], weight[4:7], weight[7:] * BACK
        self.heavy = np.maximum(self.inertia, THIN * self.inertia.max())
        self.frame, self.origin = np.array(body.axes_b), np.array(body.origin_b)
        self.axes = composed(self.frame, own)
        self.center = self.origin - rotated(self.axes, arm)
        self.p = composed(np.array(given.orientation), own)
        self.r = unit * np.array(given.position) - rotated(self.p, arm) if given.position else None
        self.velocity, self.spin = unit * np.array(given.velocity), np.array(given.spin)
        self.is_in_o = given.is_in_o

    def moments(self) -> Array:
        """Return the diagonal of its moments of inertia about the origin."""
        turned: Array = rotated(self.axes, np.eye(3)) ** 2 @ self.inertia
        return turned + self.mass * (self.center @ self.center - self.center**2)

    def momenta(self, turn: Array) -> tuple[Array, Array]:
        """Return momentum and angular momentum that the scene gives, where the frame is turned."""
        omega = rotated(turn * BACK if self.is_in_o else self.frame, self.spin)
        velocity = rotated(turn * BACK, self.velocity) + crossed(omega, self.center - self.origin)
        impulse = self.mass * velocity
        own = rotated(self.axes, self.inertia * rotated(self.axes * BACK, omega))
        return impulse, crossed(self.center, impulse) + own

    def pull(self, r: Array, turn: Array) -> tuple[Array, Array]:
        """Return force and torque of ½ dᵀ W d, with the displacement d from where it is given."""
        force = rotated(turn * BACK, self.mass * (r + rotated(turn, self.center) - self.r))
        since = composed(self.p * BACK, composed(turn, self.axes))
        sine = np.sqrt(since[1:] @ since[1:])
        angle = 2.0 * np.arctan2(sine, abs(since[0]))
        w = since[1:] * (np.copysign(angle, since[0]) / sine if sine else 0.0)
        effort, half = self.heavy * w, angle / 2.0
        # with T of a rotation vector w, δθ′ = T dw, that is T⁻ᵀ I′ w
        part = (1.0 - half / np.tan(half)) / angle**2 if angle > SERIES else 1.0 / 12.0
        across = crossed(w, effort)
        torque = effort - across / 2.0 + part * crossed(w, across)
        return force, crossed(self.center, force) + rotated(self.axes, torque)


class Carrier:
    """A body of the solver, with the bodies of the scene that are part of it.

    Parameters
    ----------
    places : BodyPlaces
        Where it stands in q and v.
    members : sequence of Member
        Its bodies.
    """

    def __init__(self, places: BodyPlaces, members: Sequence[Member]) -> None:
        self.places, self.members = places, members
        self.mass = sum(one.mass for one in members)
        self.moments = sum((one.moments() for one in members), np.zeros(3))

    def turn(self, q: Array) -> Array:
        """Return the Euler parameters of its principal frame."""
        return taken(self.places.p, q) if self.places.p else np.array([1.0, 0.0, 0.0, 0.0])

    def share(self, q: Array, v: Array) -> None:
        """Write its velocity, which has the momenta of its bodies."""
        turn = self.turn(q)
        self._put(v, turn, [one.momenta(turn) for one in self.members])

    def pull(self, q: Array, u: Array) -> None:
        """Write M⁻¹ times the force and torque of its displacement."""
        r, turn = taken(self.places.r, q), self.turn(q)
        self._put(u, turn, [one.pull(r, turn) for one in self.members])

    def _put(self, v: Array, turn: Array, sums: Sequence[tuple[Array, Array]]) -> None:
        linear, angular = (sum(parts, np.zeros(3)) for parts in zip(*sums, strict=True))
        omega = np.divide(angular, self.moments, out=np.zeros(3), where=self.moments > 0.0)
        put(v, self.places.v, rotated(turn, linear) / self.mass)
        put(v, self.places.omega_b, omega[: len(self.places.omega_b)])


def carriers_of(layout: Layout) -> Iterator[Carrier]:
    """Yield the bodies of a solver that move."""
    groups: dict[tuple[int | float, ...], list[tuple[BodyPlaces, Member]]] = {}
    for body, given in zip(layout.bodies, layout.given, strict=True):
        if indices((*body.v, *body.omega_b)):
            own = groups.setdefault((*body.r, *body.p, *body.v, *body.omega_b), [])
            own.append((body, Member(body, given, layout.unit)))
    for pairs in groups.values():
        yield Carrier(pairs[0][0], [member for _, member in pairs])


def given_start(
    layout: Layout, evaluate: Evaluate, y: Array, *, is_moved: bool = True
) -> tuple[Array, Array]:
    """Return q and v of the start with the parameters of a run.

    Bodies that are fixed to each other are one where they weigh displacements together, and
    have the sum of their momenta. Velocities are projected onto the constraints once: to do it
    again takes away what is rounded.

    Parameters
    ----------
    layout : Layout
        What stands where, with the parameters of the run.
    evaluate : callable
        What :func:`.initial.evaluated` returns, with these parameters.
    y : array
        Where bodies fit, on the branch of the scene: q, then some v.
    is_moved : bool
        Whether they are brought to the nearest place from there.
    """
    carriers, count = [*carriers_of(layout)], layout.sizes["q"]
    q, v = y[:count].copy(), y[count:].copy()
    if is_moved and all(one.position for one in layout.given):
        q = nearest(layout, carriers, evaluate, q)
    for one in carriers:
        one.share(q, v)
    return q, v + evaluate(q, v)["dv"]


def nearest(layout: Layout, carriers: Sequence[Carrier], evaluate: Evaluate, q: Array) -> Array:
    """Return the place nearest to where the scene has its bodies, that can be reached from q.

    There the force f of ½ dᵀ W d is normal to the constraints: what is tangent of −M⁻¹ f is a step
    towards it, as long as Barzilai and Borwein take it. Where that leads nowhere bodies stay.
    """
    rest, moves = np.zeros(layout.sizes["v"]), np.ones(len(q))
    moves[[place for _, place in layout.works]] = 0.0
    sizes, sizes_q, weights = np.ones(len(rest)), np.ones(len(q)), np.ones(len(rest))
    for one in carriers:
        sizes[indices(one.places.v)] = sizes_q[indices(one.places.r)] = layout.length
        put(weights, one.places.v, np.full(3, one.mass))
        put(weights, one.places.omega_b, one.moments[: len(one.places.omega_b)])
    start, last, part, before, step = q, np.inf, 1.0, rest, rest
    for _ in range(MOST):
        u = rest.copy()
        for one in carriers:
            one.pull(q, u)
        u += evaluate(q, u)["dv"] - evaluate(q, rest)["dv"]
        size = float(np.max(np.abs(u) / sizes, initial=0.0))
        if size <= ROUNDING or (size <= SMALL and size > 0.5 * last):
            return q
        bend = step @ (weights * (u - before))
        part = step @ (weights * step) / bend if bend > 0.0 else 1.0
        before, step = u, -min(part, LONGEST / size) * u
        found = _closed(evaluate, q + moves * evaluate(q, step)["q_dot"], rest, sizes_q)
        if found is None:
            break
        q, last = found, size
    return start


def _closed(evaluate: Evaluate, q: Array, rest: Array, sizes: Array) -> Array | None:
    """Return a position near q that meets the constraints; None where it is not near."""
    last = np.inf
    for attempt in range(MOST):
        moved = evaluate(q, rest)["q_moved"]
        change = float(np.max(np.abs(moved - q) / sizes, initial=0.0))
        if change <= ROUNDING or (change <= SMALL and change > 0.5 * last):
            return moved
        if not (change < last or attempt < FIRST):
            break
        q, last = moved, change
    return None
