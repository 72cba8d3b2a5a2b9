"""Equations of a scene from its definitions, for comparison with the results of a solver.

Each body of the scene is for itself: m v̇ = F and I′ ω̇′ = N′ − ω̃′ I′ ω′, with forces, joints,
drivers and coordinates as the scene gives them, each by its geometric definition. Nothing is
merged, put into a plane, put onto a joint or left out, and no kernel, operation or composition has
a part in it: what these do wrong shows. A residual C along a motion,
:mod:`~kousoku.codegen.dynamics.operations.jets`, tells Ċ and C̈, and by Ċ = C_q v − ν and
C̈ = C_q v̇ − γ all that is needed of it. Of a kind of one's own C is what its kernel computes, there
is no other definition; its Jacobian, ν and γ have no part in it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import accumulate
from typing import TYPE_CHECKING, Any

from kousoku.codegen.dynamics.elements.constraints import facets_of_kind
from kousoku.codegen.dynamics.elements.force_facets import facets_of
from kousoku.codegen.dynamics.operations.jets import (
    Jet,
    arithmetic_of,
    cross,
    formula,
)
from kousoku.codegen.kernel_json import load_frozen
from kousoku.codegen.passes.rebuild import with_outputs
from kousoku.model.expressions.formulas import RATE, TIME
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.mechanics.constraints import is_length
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.model.numbers.digits import HIGH
from kousoku.model.operations.interpret import evaluate
from kousoku.model.records.own_kind import PREFIX, is_own

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from kousoku.codegen.dynamics.operations.jets import JetVector
    from kousoku.model.mechanics.multibody import ForceElement, Instance, MovingBody, System
    from kousoku.model.numbers.real import Real
    from kousoku.model.operations.arithmetic import FormulaArithmetic
    from kousoku.model.operations.expression import Expression


@dataclass(frozen=True, slots=True)
class BodyState:
    """Position and velocity of a body: ṗ = ½ p ∘ (0, ω′), lecture 7.1, (5.16).

    Parameters
    ----------
    r, v : (3,) [m], [m/s]
        Centre of mass and its velocity, frame O.
    p, omega_b : (4,) [-], (3,) [rad/s]
        Euler parameters of the principal frame, of norm one, and the angular velocity there.
    """

    r: Sequence[Real]
    p: Sequence[Real]
    v: Sequence[Real]
    omega_b: Sequence[Real]


def quaternion_product(p: Sequence[Any], q: Sequence[Any]) -> tuple[Any, ...]:
    """Product p ∘ q (4,) of Euler parameters [-], of jets or numbers: the rotation q, then p.

    It is (p₀ q₀ − p·q, p₀ q + q₀ p + p × q); q takes a frame to the one that p takes to frame O.
    """
    x, y, z = cross(p[1:], q[1:])
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + q[0] * p[1] + x,
        p[0] * q[2] + q[0] * p[2] + y,
        p[0] * q[3] + q[0] * p[3] + z,
    )


def rotated(p: Sequence[Any], a: Sequence[Any]) -> tuple[Any, Any, Any]:
    """Vector A(p) a (3,) for p of norm one, of jets or numbers: a + 2 e₀ (e × a) + 2 e × (e × a).

    a (3,), of any unit, is in the principal frame, A a in frame O; lecture 7.1, (4.3).
    """
    t = cross(p[1:], a)
    u = cross(p[1:], t)
    x, y, z = (a[k] + (p[0] * t[k] + u[k]) + (p[0] * t[k] + u[k]) for k in range(3))
    return x, y, z


def rotated_back(p: Sequence[Any], a: Sequence[Any]) -> tuple[Any, Any, Any]:
    """Vector A(p)ᵀ a (3,), of any unit, principal frame, of a in frame O; lecture 7.1, (4.3)."""
    return rotated((p[0], -p[1], -p[2], -p[3]), a)


class Course:
    """Motion of a body: r(t) and p(t) to second order, ṗ = ½ p ∘ (0, ω′), lecture 7.1, (5.16).

    Parameters
    ----------
    r, p : (3,) [m], (4,) [-] of Jet
        Centre of mass in frame O, and Euler parameters of the principal frame.
    """

    def __init__(self, r: Sequence[Jet], p: Sequence[Jet]) -> None:
        self.r, self.p = r, p

    @classmethod
    def of(cls, pose: BodyState, rates: Sequence[Real], second: Sequence[Real]) -> Course:
        """Course of a body with v, ω′ and v̇, ω̇′; p̈ = ½ (ṗ ∘ (0, ω′) + p ∘ (0, ω̇′)).

        Parameters
        ----------
        pose : BodyState
            Where it is; its velocities are not looked at.
        rates, second : (6,) [m/s, rad/s], [m/s², rad/s²]
            v and v̇ in frame O, ω′ and ω̇′ in the principal frame.
        """
        r = [Jet(x, rates[k], second[k]) for k, x in enumerate(pose.r)]
        omega, alpha = (0, *rates[3:]), (0, *second[3:])
        first = [x / 2 for x in quaternion_product(pose.p, omega)]
        halves = zip(
            quaternion_product(first, omega), quaternion_product(pose.p, alpha), strict=True
        )
        return cls(
            r, [Jet(x, d, (a + b) / 2) for x, d, (a, b) in zip(pose.p, first, halves, strict=True)]
        )

    def with_rates(self, rates: Sequence[Real]) -> Course:
        """Course from the same place with other constant v [m/s] and ω′ [rad/s], (6,)."""
        here = BodyState([x.x for x in self.r], [x.x for x in self.p], (), ())
        return Course.of(here, rates, [0] * 6)

    def vector(self, a: Sequence[Real]) -> JetVector:
        """Vector A a′ (3,) in frame O, of a′ (3,) in the principal frame, in its unit."""
        return rotated(self.p, [Jet(x) for x in a])

    def point(self, s: Sequence[Real]) -> JetVector:
        """Place r + A s′ (3,) [m] in frame O, of a point s′ (3,) [m] in the principal frame."""
        x, y, z = (a + b for a, b in zip(self.r, self.vector(s), strict=True))
        return x, y, z


@dataclass(slots=True)
class Found:
    """Forces at a state: f of M v̇ + C_qᵀλ = f.

    Parameters
    ----------
    force : list (n,) [N, N m]
        F in frame O and N′ about the centre of mass, in the principal frame, for each body.
    potential, kinetic : number [J]
        Energies.
    powers : dict of str to number [W]
        Of forces, by name, as far as their work is no potential energy.
    sizes : list of number [J]
        The parts that the energies are added up from.
    steepness : sequence (n,) of float [N, N m]
        Changes of the force where the state moves, by the part of its reach.
    time : number [s]
        When that is.
    """

    force: list[Real]
    potential: Real = 0
    kinetic: Real = 0
    powers: dict[str, Real] = field(default_factory=dict)
    sizes: list[Real] = field(default_factory=list)
    steepness: Sequence[float] = ()
    time: Real = 0


@dataclass(slots=True)
class ConstraintRow:
    """One row of the constraints: Ċ = C_q v − ν, C̈ = C_q v̇ − γ.

    Parameters
    ----------
    instance : Instance
        The joint or driver.
    value, nu, gamma : number [m or rad, per s, per s²]
        C, and what C_q v and C_q v̇ are.
    jacobian : dict of int to number
        C_q by column: δr [m] in frame O, δθ′ [rad] in the principal frame.
    """

    instance: Instance
    value: Real
    nu: Real
    gamma: Real
    jacobian: dict[int, Real]


class BodyEquations:
    """The equations of all bodies of an unsimplified system: M v̇ + C_qᵀλ = f, C_q v̇ = γ.

    Columns (n,) are δr [m] in frame O and δθ′ [rad] in the principal frame of each body, rows f [N]
    and [N m] in the same frames: m v̇ = F, I′ω̇′ = N′ − ω̃′I′ω′, three mass points,
    (newton-euler-force) and (newton-euler-moment).

    Parameters
    ----------
    system : System
        The scene, all of whose numbers are fixed.
    digits : FormulaArithmetic
        What is computed with.
    """

    def __init__(self, system: System, digits: FormulaArithmetic[Any] = HIGH) -> None:
        self.system, self.digits = system, digits
        self.bodies = system.bodies
        #: The first column of each body, and their count.
        self.starts = [*accumulate((3 if body.is_point else 6 for body in self.bodies), initial=0)]
        self.count = self.starts[-1]
        self._ground = Course([self._jet(0)] * 3, [self._jet(x) for x in (1, 0, 0, 0)])
        self._read: dict[tuple[str, tuple[str, ...]], Expression] = {}

    def _jet(self, x: float) -> Jet:
        return Jet(self.digits.number(x))

    def _numbers(self, values: Sequence[float]) -> list[Real]:
        return [self.digits.number(x) for x in values]

    def own(self, body: int) -> range:
        """Columns of a body: δr [m] in frame O, δθ′ [rad] in the principal frame, if it turns."""
        return range(self.starts[body], self.starts[body + 1])

    def inertia(self) -> list[Real]:
        """Diagonal of M (n,) [kg, kg m²]: m and the principal moments."""
        parts = ([b.mass] * 3 + ([] if b.is_point else list(b.inertia)) for b in self.bodies)
        return self._numbers([x for part in parts for x in part])

    def rates(self, poses: Sequence[BodyState]) -> list[Real]:
        """Velocities v (n,) [m/s, rad/s] of all bodies, (ṙ, ω′) of each."""
        pairs = zip(self.bodies, poses, strict=True)
        return [x for body, one in pairs for x in (*one.v, *(() if body.is_point else one.omega_b))]

    def course(
        self, body: int, pose: BodyState, rates: Sequence[Real], second: Sequence[Real]
    ) -> Course:
        """Course of a body, given v (n,) and v̇ (n,) of all."""
        own = self.own(body)
        parts = [[values[k] for k in own] + [0] * (6 - len(own)) for values in (rates, second)]
        return Course.of(pose, *parts)

    def courses(
        self,
        bodies: Sequence[int],
        poses: Sequence[BodyState],
        rates: Sequence[Real],
        second: Sequence[Real],
    ) -> dict[int, Course]:
        """Courses of some bodies, of the ground too, given v (n,) and v̇ (n,) of all."""
        moving = [k for k in bodies if k != GROUND_INDEX]
        found = {k: self.course(k, poses[k], rates, second) for k in moving}
        return {GROUND_INDEX: self._ground, **found}

    # What is measured.

    def coordinate(self, place: int, at: Mapping[int, Course]) -> Jet:
        """Value u [m, rad or -]: an angle with its turns, a displacement, a distance, a cosine."""
        one = self.system.coordinates[place]
        own = {name: self._numbers(values) for name, values in one.constants}
        i, j = at[one.i], at[one.j]
        (value,) = facets_of_kind(one.kind).residuals(i, j, own, self.digits)
        if not one.counts_turns:
            return value
        turn = 8 * self.digits.atan(self.digits.number(1))
        count = round(float((self.digits.number(one.near) - value.x) / turn))
        return value + Jet(turn * count)

    def _residuals(self, one: Instance, at: Mapping[int, Course], time: Real) -> Sequence[Jet]:
        """Residuals, zero where a joint or driver holds."""
        own = {name: self._numbers(values) for name, values in one.constants}
        if one.is_combination:
            total = self._jet(one.offset)
            for term in one.terms:
                factor = self.digits.number(term.factor)
                total += self.coordinate(term.coordinate, at).times(factor)
            if one.law:
                law = self.value(one.law, {TIME: Jet(time, self.digits.number(1))})
                total -= law.times(self.digits.number(one.law_unit))
            return (total,)
        if is_own(one.kind):
            return self._own(one, at)
        kind = facets_of_kind(one.kind)
        return kind.residuals(at[one.i], at[one.j], own, self.digits)

    def _own(self, one: Instance, at: Mapping[int, Course]) -> Sequence[Jet]:
        """C of a kind of one's own: its definition is that of its kernels.

        It is taken in the frames that it is stated in. What follows of it, C_q, ν and γ, is found
        here anew.
        """
        own = {name: [Jet(x) for x in self._numbers(values)] for name, values in one.constants}
        inputs = {name.removeprefix(PREFIX): values for name, values in own.items() if is_own(name)}
        for body, place in zip("ij", (one.i, one.j), strict=True):
            course, origin = at[place], dict(one.constants)[f"origin_{body}"]
            inputs[f"r_{body}"] = [*course.point(self._numbers(origin))]
            inputs[f"p_{body}"] = [*quaternion_product(course.p, own[f"frame_{body}"])]
        kernel = next(k for k in load_frozen(one.kind).kernels if k.name == "constraint")
        return evaluate(with_outputs(kernel, ["C"]), inputs, arithmetic_of(self.digits))["C"]

    def value(self, text: str, names: Mapping[str, Jet]) -> Jet:
        """Value of a formula of these names and the parameters."""
        known = {name: self._jet(x) for name, x in self.system.parameters} | dict(names)
        key = text, tuple(known)
        if key not in self._read:
            self._read[key] = parse_expression(text, known, longest=len(text))
        return formula(self._read[key], known, self.digits)

    # The constraints.

    def lines(self, poses: Sequence[BodyState], time: Real) -> list[ConstraintRow]:
        """Rows C, ν, γ, C_q of all joints and drivers, those too that depend on others."""
        rates, rest = self.rates(poses), [self.digits.number(0)] * self.count
        found: list[ConstraintRow] = []
        for one in self.system.constraints:
            bodies = [body for body in one.bodies if body != GROUND_INDEX]
            at = self.courses(bodies, poses, rates, rest)
            along = self._residuals(one, at, time)
            at_rest = self.courses(bodies, poses, rest, rest)
            still = self._residuals(one, at_rest, time)
            own = [
                ConstraintRow(one, c.x, -s.d, -c.dd, {}) for c, s in zip(along, still, strict=True)
            ]
            for column, ahead_at in self.each_column(at_rest):
                ahead = self._residuals(one, ahead_at, time)
                for line, a, s in zip(own, ahead, still, strict=True):
                    line.jacobian[column] = a.d - s.d
            found += own
        return found

    def each_column(self, at: Mapping[int, Course]) -> Iterator[tuple[int, dict[int, Course]]]:
        """Columns of bodies one by one, with the courses where that velocity alone is one."""
        zeros = [self.digits.number(0)] * 6
        at_rest = {body: course.with_rates(zeros) for body, course in at.items()}
        for body, course in at_rest.items():
            for k, column in enumerate(self.own(body) if body != GROUND_INDEX else ()):
                rates = [self.digits.number(k == n) for n in range(6)]
                yield column, {**at_rest, body: course.with_rates(rates)}

    # The forces.

    def loads(self, poses: Sequence[BodyState], time: Real) -> Found:
        """Forces f (n,), applied less velocity forces ω̃′I′ω′, and the energies [J]."""
        rates, rest = self.rates(poses), [self.digits.number(0)] * self.count
        found = Found([*rest], time=time)
        at = self.courses(range(len(poses)), poses, rates, rest)
        fall = self._fall()
        for k, (body, pose) in enumerate(zip(self.bodies, poses, strict=True)):
            self._weigh(body, pose, fall, self.own(k), found)
        for force in self.system.forces:
            self._act(force, at, time, found)
        return found

    def _fall(self) -> list[Real]:
        """Acceleration of free fall."""
        unit = self.digits.number(self.system.unit)
        pairs = zip(self.system.gravity, self.system.gravity_law, strict=True)
        return [
            self.value(text, {}).x * unit if text else self.digits.number(x) for x, text in pairs
        ]

    def _weigh(
        self, body: MovingBody, pose: BodyState, fall: Sequence[Real], own: range, found: Found
    ) -> None:
        """Add weight, −ω̃′ I′ ω′ and the energies of a body: ½ m v·v + ½ ω′·I′ω′ and −m g·r."""
        mass = self.digits.number(body.mass)
        kinetic = mass * sum(x * x for x in pose.v) / 2
        potential = -mass * sum(g * x for g, x in zip(fall, pose.r, strict=True))
        for k in range(3):
            found.force[own[k]] += mass * fall[k]
        if not body.is_point:
            spin = [
                self.digits.number(a) * b for a, b in zip(body.inertia, pose.omega_b, strict=True)
            ]
            kinetic += sum(a * b for a, b in zip(spin, pose.omega_b, strict=True)) / 2
            for k, x in enumerate(cross(pose.omega_b, spin)):
                found.force[own[3 + k]] -= x
        found.kinetic += kinetic
        found.potential += potential
        found.sizes += [kinetic, potential]

    def _act(
        self,
        force: ForceElement,
        at: Mapping[int, Course],
        time: Real,
        found: Found,
    ) -> None:
        """Add a force, its power, and its potential energy."""
        names = self._names(at, time)
        given = self._given(force, names)
        power, energy = facets_of(force).by_definition(self, at, names, given, found)
        if force.works:
            found.powers[force.name] = found.powers.get(force.name, 0) + power
        if force.has_potential:
            found.potential += energy
            found.sizes.append(energy)

    def _given(self, force: ForceElement, names: Mapping[str, Jet]) -> dict[str, list[Real]]:
        """Constants of a force, times their formulas."""
        texts = dict(force.formulas)
        return {
            name: [
                self.digits.number(x) * (self.value(texts[name], names).x if name in texts else 1)
                for x in values
            ]
            for name, values in force.constants
        }

    def elongation(
        self, force: ForceElement, at: Mapping[int, Course], time: Real, *, is_length: bool
    ) -> Jet:
        """Elongation that the law of a spring is of, or the distance of its ends; in its unit."""
        given = self._given(force, self._names(at, time))
        value, free = facets_of(force).length_by_definition(self, at, given)
        if not is_length:
            value -= Jet(free)
        (unit,) = given.get("unit", self._numbers((1,)))
        return value.times(1 / unit)

    def _names(self, at: Mapping[int, Course], time: Real) -> dict[str, Jet]:
        """Values of the names that formulas may use, in the unit of the scene."""
        names = {TIME: Jet(time, self.digits.number(1))}
        for place, one in enumerate(self.system.coordinates):
            value = self.coordinate(place, at)
            if is_length(one.kind):
                value = value.times(1 / self.digits.number(self.system.unit))
            names |= {one.name: value, f"{one.name}{RATE}": Jet(value.d)}
        return names

    def apply_force(
        self, body: int, at: Course, arm: Sequence[Real], force: Sequence[Real], found: Found
    ) -> None:
        """Add a force F (3,) [N] in frame O that acts on a point s′ (3,) [m]: F, and s′ × AᵀF."""
        if body == GROUND_INDEX:
            return
        own = self.own(body)
        torque = cross(arm, rotated_back([x.x for x in at.p], force))
        for k, x in zip(own, (*force, *torque), strict=False):
            found.force[k] += x

    def apply_torque(self, body: int, at: Course, torque: Sequence[Real], found: Found) -> Real:
        """Add a torque N (3,) [N m] in frame O that acts on a body, AᵀN; return its power N·ω."""
        p = [x.x for x in at.p]
        own = self.own(body)[3:] if body != GROUND_INDEX else range(0)
        turning = rotated_back(p, torque)
        first = quaternion_product((p[0], -p[1], -p[2], -p[3]), [x.d for x in at.p])
        for k, x in zip(own, turning, strict=False):
            found.force[k] += x
        energy: Real = 2 * sum(a * b for a, b in zip(turning, first[1:], strict=True))
        return energy

    # What bodies do.

    def origins(
        self, at: Mapping[int, Course], second: Sequence[Real]
    ) -> Iterator[tuple[list[Real], tuple[Real, ...]]]:
        """Accelerations r̈ (3,) [m/s²], frame O, of the origins of bodies' own frames, and dω′/dt.

        That is in the own frame, (3,) [rad/s²]; the origin is at r + A s′ with s′ in the principal
        frame.
        """
        for k, body in enumerate(self.bodies):
            place = at[k].point(self._numbers(body.origin_b))
            alpha = [second[column] for column in self.own(k)[3:]]
            turning = rotated_back(self._numbers(body.axes_b), alpha) if alpha else ()
            yield [x.dd for x in place], turning

    def momentum(
        self, bodies: Sequence[int], poses: Sequence[BodyState], about: Sequence[float] | None
    ) -> tuple[list[Real], list[Real]]:
        """Momentum Σ m v, and Σ (r − o) × m v + A I′ω′ about a point o, or the centre of mass.

        (3,) [kg m/s] and (3,) [kg m²/s], frame O.
        """
        masses = {k: self.digits.number(self.bodies[k].mass) for k in bodies}
        mass = sum(masses.values())
        linear = [sum(masses[k] * poses[k].v[n] for k in bodies) for n in range(3)]
        center = [sum(masses[k] * poses[k].r[n] for k in bodies) / mass for n in range(3)]
        drift = [x / mass for x in linear]
        if about is not None:
            center, drift = self._numbers(about), self._numbers((0, 0, 0))
        total = self._numbers((0, 0, 0))
        for k in bodies:
            one, body = poses[k], self.bodies[k]
            arm = [a - b for a, b in zip(one.r, center, strict=True)]
            part = cross(arm, [masses[k] * (a - b) for a, b in zip(one.v, drift, strict=True)])
            spin: Sequence[Real] = (0, 0, 0)
            if not body.is_point:
                moments = self._numbers(body.inertia)
                spin = rotated(one.p, [a * b for a, b in zip(moments, one.omega_b, strict=True)])
            total = [a + b + c for a, b, c in zip(total, part, spin, strict=True)]
        return linear, total
