"""The equations of a scene from its definitions, for comparison with what a solver computes.

Each body of the scene is for itself: m v̇ = F and I′ ω̇′ = N′ − ω̃′ I′ ω′, with forces, joints,
drivers and coordinates as the scene gives them, each by its geometric definition. Nothing is
merged, put into a plane, put onto a joint or left out, and no kernel, operation or composition has
a part in it: what these do wrong shows. A residual C along a motion, :mod:`.jets`, tells Ċ and C̈,
and by Ċ = C_q v − ν and C̈ = C_q v̇ − γ all that is needed of it. Of a kind of one's own C is what
its kernel computes, there is no other definition; its Jacobian, ν and γ have no part in it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import accumulate
from typing import TYPE_CHECKING, Any

from kousoku.codegen.dynamics.checking.jets import (
    Jet,
    arithmetic_of,
    atan2,
    cross,
    dot,
    formula,
    sqrt,
)
from kousoku.codegen.dynamics.elements.forces import facets_of
from kousoku.codegen.passes.rebuild import with_outputs
from kousoku.codegen.store import load_frozen
from kousoku.model.digits import HIGH
from kousoku.model.expression import parse_expression
from kousoku.model.formulas import RATE, TIME
from kousoku.model.interpret import evaluate
from kousoku.model.mechanism import COMBINATION, GROUND_INDEX
from kousoku.model.own_kind import PREFIX, is_own

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from kousoku.codegen.dynamics.checking.jets import High, Vector
    from kousoku.model.arithmetic import FormulaArithmetic
    from kousoku.model.mechanism import ForceElement, Instance, MovingBody, System
    from kousoku.model.terms import Expression

#: Kinds of coordinates that are lengths.
LENGTHS = ("n2", "length")


@dataclass(frozen=True, slots=True)
class Pose:
    """Where a body is, and how it moves.

    Parameters
    ----------
    r, v : (3,)
        Centre of mass and its velocity, frame O.
    p, omega_b : (4,), (3,)
        Euler parameters of the principal frame, of norm one, and the angular velocity there.
    """

    r: Sequence[High]
    p: Sequence[High]
    v: Sequence[High]
    omega_b: Sequence[High]


def composed(p: Sequence[Any], q: Sequence[Any]) -> tuple[Any, ...]:
    """Return p ∘ q, of jets or numbers."""
    x, y, z = cross(p[1:], q[1:])
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + q[0] * p[1] + x,
        p[0] * q[2] + q[0] * p[2] + y,
        p[0] * q[3] + q[0] * p[3] + z,
    )


def turned(p: Sequence[Any], a: Sequence[Any]) -> tuple[Any, Any, Any]:
    """Return A(p) a for p of norm one, of jets or numbers: a + 2 e₀ (e × a) + 2 e × (e × a)."""
    t = cross(p[1:], a)
    u = cross(p[1:], t)
    x, y, z = (a[k] + (p[0] * t[k] + u[k]) + (p[0] * t[k] + u[k]) for k in range(3))
    return x, y, z


def turned_back(p: Sequence[Any], a: Sequence[Any]) -> tuple[Any, Any, Any]:
    """Return A(p)ᵀ a."""
    return turned((p[0], -p[1], -p[2], -p[3]), a)


class Course:
    """A body on its way: r(t) and p(t) to second order.

    Parameters
    ----------
    r, p : (3,), (4,) of Jet
        Centre of mass, and Euler parameters of the principal frame.
    """

    def __init__(self, r: Sequence[Jet], p: Sequence[Jet]) -> None:
        self.r, self.p = r, p

    @classmethod
    def of(cls, pose: Pose, rates: Sequence[High], second: Sequence[High]) -> Course:
        """Return the way of a body with v, ω′ and v̇, ω̇′; ṗ = ½ p ∘ (0, ω′)."""
        r = [Jet(x, rates[k], second[k]) for k, x in enumerate(pose.r)]
        omega, alpha = (0, *rates[3:]), (0, *second[3:])
        first = [x / 2 for x in composed(pose.p, omega)]
        halves = zip(composed(first, omega), composed(pose.p, alpha), strict=True)
        return cls(
            r, [Jet(x, d, (a + b) / 2) for x, d, (a, b) in zip(pose.p, first, halves, strict=True)]
        )

    def with_rates(self, rates: Sequence[High]) -> Course:
        """Return the way from the same place with other rates, which do not change."""
        here = Pose([x.x for x in self.r], [x.x for x in self.p], (), ())
        return Course.of(here, rates, [0] * 6)

    def vector(self, a: Sequence[High]) -> Vector:
        """Return a body-fixed vector in frame O."""
        return turned(self.p, [Jet(x) for x in a])

    def point(self, s: Sequence[High]) -> Vector:
        """Return the place of a body-fixed point in frame O."""
        x, y, z = (a + b for a, b in zip(self.r, self.vector(s), strict=True))
        return x, y, z


@dataclass(slots=True)
class Found:
    """What acts at a state.

    Parameters
    ----------
    force : list
        F in frame O and N′ about the centre of mass for each body, (n,).
    potential, kinetic : number [J]
        Energies.
    powers : dict of str to number [W]
        Of forces, by name, as far as their work is no potential energy.
    sizes : list of number [J]
        The parts that the energies are added up from.
    """

    force: list[High]
    potential: High = 0
    kinetic: High = 0
    powers: dict[str, High] = field(default_factory=dict)
    sizes: list[High] = field(default_factory=list)


@dataclass(slots=True)
class Line:
    """One row of the constraints.

    Parameters
    ----------
    instance : Instance
        The joint or driver.
    value, nu, gamma : number
        C, and what C_q v and C_q v̇ are.
    slopes : dict of int to number
        C_q by column.
    """

    instance: Instance
    value: High
    nu: High
    gamma: High
    slopes: dict[int, High]


class BodyEquations:
    """The equations of all bodies of a system that was not simplified.

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

    def _numbers(self, values: Sequence[float]) -> list[High]:
        return [self.digits.number(x) for x in values]

    def own(self, body: int) -> range:
        """Return the columns of a body."""
        return range(self.starts[body], self.starts[body + 1])

    def inertia(self) -> list[High]:
        """Return the diagonal of M."""
        parts = ([b.mass] * 3 + ([] if b.is_point else list(b.inertia)) for b in self.bodies)
        return self._numbers([x for part in parts for x in part])

    def rates(self, poses: Sequence[Pose]) -> list[High]:
        """Return v of all bodies."""
        pairs = zip(self.bodies, poses, strict=True)
        return [x for body, one in pairs for x in (*one.v, *(() if body.is_point else one.omega_b))]

    def course(
        self, body: int, pose: Pose, rates: Sequence[High], second: Sequence[High]
    ) -> Course:
        """Return the way of a body, given the rates of all."""
        own = self.own(body)
        parts = [[values[k] for k in own] + [0] * (6 - len(own)) for values in (rates, second)]
        return Course.of(pose, *parts)

    def courses(
        self,
        bodies: Sequence[int],
        poses: Sequence[Pose],
        rates: Sequence[High],
        second: Sequence[High],
    ) -> dict[int, Course]:
        """Return the ways of some bodies, of the ground too."""
        moving = [k for k in bodies if k != GROUND_INDEX]
        found = {k: self.course(k, poses[k], rates, second) for k in moving}
        return {GROUND_INDEX: self._ground, **found}

    # What is measured.

    def coordinate(self, place: int, at: Mapping[int, Course]) -> Jet:
        """Return a coordinate: an angle with its turns, a displacement, a distance, a cosine."""
        one = self.system.coordinates[place]
        own = {name: self._numbers(values) for name, values in one.constants}
        i, j = at[one.i], at[one.j]
        if one.kind == "n1":
            return dot(i.vector(own["a_i_b"]), j.vector(own["a_j_b"]))
        if one.kind == "angle":
            a_j = j.vector(own["a_j_b"])
            sine, cosine = (dot(i.vector(own[name]), a_j) for name in ("b_i_b", "a_i_b"))
            angle = atan2(sine, cosine, self.digits)
            turn = 8 * self.digits.atan(self.digits.number(1))
            count = round(float((self.digits.number(one.near) - angle.x) / turn))
            return angle + Jet(turn * count)
        across = _difference(j.point(own["s_j_b"]), i.point(own["s_i_b"]))
        if one.kind == "n2":
            return dot(i.vector(own["a_i_b"]), across)
        return sqrt(dot(across, across), self.digits)

    def _residuals(self, one: Instance, at: Mapping[int, Course], time: High) -> Sequence[Jet]:
        """Return what is zero where a joint or driver holds."""
        own = {name: self._numbers(values) for name, values in one.constants}
        if one.kind == COMBINATION:
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
        i, j = at[one.i], at[one.j]
        kind = one.kind.partition("_")[0]
        if kind == "n1":
            return (dot(i.vector(own["a_i_b"]), j.vector(own["a_j_b"])),)
        if kind == "p1":
            return cross(i.vector(own["a_i_b"]), j.vector(own["a_j_b"]))
        across = _difference(j.point(own["s_j_b"]), i.point(own["s_i_b"]))
        if kind == "point":
            return across
        if kind == "p2":
            return cross(i.vector(own["a_i_b"]), across)
        if kind == "n2":
            return (dot(i.vector(own["a_i_b"]), across),)
        if kind == "distance":
            (length,) = own["length"]
            return (sqrt(dot(across, across), self.digits) - Jet(length),)
        raise ValueError(f"{one.joint}: no definition of the kind {one.kind}")

    def _own(self, one: Instance, at: Mapping[int, Course]) -> Sequence[Jet]:
        """Return C of a kind of one's own: its definition is that of its kernels.

        It is taken in the frames that it is stated in. What follows of it, C_q, ν and γ, is found
        here anew.
        """
        own = {name: [Jet(x) for x in self._numbers(values)] for name, values in one.constants}
        inputs = {name.removeprefix(PREFIX): values for name, values in own.items() if is_own(name)}
        for body, place in zip("ij", (one.i, one.j), strict=True):
            course, origin = at[place], dict(one.constants)[f"origin_{body}"]
            inputs[f"r_{body}"] = [*course.point(self._numbers(origin))]
            inputs[f"p_{body}"] = [*composed(course.p, own[f"frame_{body}"])]
        kernel = next(k for k in load_frozen(one.kind).kernels if k.name == "constraint")
        return evaluate(with_outputs(kernel, ["C"]), inputs, arithmetic_of(self.digits))["C"]

    def value(self, text: str, names: Mapping[str, Jet]) -> Jet:
        """Return the value of a formula of these names and the parameters."""
        known = {name: self._jet(x) for name, x in self.system.parameters} | dict(names)
        key = text, tuple(known)
        if key not in self._read:
            self._read[key] = parse_expression(text, known, longest=len(text))
        return formula(self._read[key], known, self.digits)

    # The constraints.

    def lines(self, poses: Sequence[Pose], time: High) -> list[Line]:
        """Return all rows of joints and drivers, those too that depend on others."""
        rates, rest = self.rates(poses), [self.digits.number(0)] * self.count
        found: list[Line] = []
        for one in self.system.constraints:
            bodies = [body for body in one.bodies if body != GROUND_INDEX]
            at = self.courses(bodies, poses, rates, rest)
            along = self._residuals(one, at, time)
            at_rest = self.courses(bodies, poses, rest, rest)
            still = self._residuals(one, at_rest, time)
            own = [Line(one, c.x, -s.d, -c.dd, {}) for c, s in zip(along, still, strict=True)]
            for column, ahead_at in self.each_column(at_rest):
                ahead = self._residuals(one, ahead_at, time)
                for line, a, s in zip(own, ahead, still, strict=True):
                    line.slopes[column] = a.d - s.d
            found += own
        return found

    def each_column(self, at: Mapping[int, Course]) -> Iterator[tuple[int, dict[int, Course]]]:
        """Yield each column of bodies, and their ways where that velocity alone is one."""
        zeros = [self.digits.number(0)] * 6
        at_rest = {body: course.with_rates(zeros) for body, course in at.items()}
        for body, course in at_rest.items():
            for k, column in enumerate(self.own(body) if body != GROUND_INDEX else ()):
                rates = [self.digits.number(k == n) for n in range(6)]
                yield column, {**at_rest, body: course.with_rates(rates)}

    # The forces.

    def loads(self, poses: Sequence[Pose], time: High) -> Found:
        """Return applied less velocity forces, and the energies."""
        rates, rest = self.rates(poses), [self.digits.number(0)] * self.count
        found = Found([*rest])
        at = self.courses(range(len(poses)), poses, rates, rest)
        fall = self._fall()
        for k, (body, pose) in enumerate(zip(self.bodies, poses, strict=True)):
            self._weigh(body, pose, fall, self.own(k), found)
        for force in self.system.forces:
            self._act(force, at, time, found)
        return found

    def _fall(self) -> list[High]:
        """Return the acceleration of free fall."""
        unit = self.digits.number(self.system.unit)
        pairs = zip(self.system.gravity, self.system.gravity_law, strict=True)
        return [
            self.value(text, {}).x * unit if text else self.digits.number(x) for x, text in pairs
        ]

    def _weigh(
        self, body: MovingBody, pose: Pose, fall: Sequence[High], own: range, found: Found
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
        time: High,
        found: Found,
    ) -> None:
        """Add a force, its power, and its potential energy."""
        names = self._names(at, time)
        texts = dict(force.formulas)
        given = {
            name: [
                self.digits.number(x) * (self.value(texts[name], names).x if name in texts else 1)
                for x in values
            ]
            for name, values in force.constants
        }
        power, energy = facets_of(force).by_definition(self, at, names, given, found)
        if force.works:
            found.powers[force.name] = found.powers.get(force.name, 0) + power
        if force.has_potential:
            found.potential += energy
            found.sizes.append(energy)

    def _names(self, at: Mapping[int, Course], time: High) -> dict[str, Jet]:
        """Return what formulas may name, in the unit of the scene."""
        names = {TIME: Jet(time, self.digits.number(1))}
        for place, one in enumerate(self.system.coordinates):
            value = self.coordinate(place, at)
            if one.kind in LENGTHS:
                value = value.times(1 / self.digits.number(self.system.unit))
            names |= {one.name: value, f"{one.name}{RATE}": Jet(value.d)}
        return names

    def push(
        self, body: int, at: Course, arm: Sequence[High], force: Sequence[High], found: Found
    ) -> None:
        """Add a force in frame O that acts on a point of a body: F, and s′ × Aᵀ F."""
        if body == GROUND_INDEX:
            return
        own = self.own(body)
        torque = cross(arm, turned_back([x.x for x in at.p], force))
        for k, x in zip(own, (*force, *torque), strict=False):
            found.force[k] += x

    def turn(self, body: int, at: Course, torque: Sequence[High], found: Found) -> High:
        """Add a torque in frame O that acts on a body; return its power."""
        p = [x.x for x in at.p]
        own = self.own(body)[3:] if body != GROUND_INDEX else range(0)
        turning = turned_back(p, torque)
        first = composed((p[0], -p[1], -p[2], -p[3]), [x.d for x in at.p])
        for k, x in zip(own, turning, strict=False):
            found.force[k] += x
        return 2 * sum(a * b for a, b in zip(turning, first[1:], strict=True))

    # What bodies do.

    def origins(
        self, at: Mapping[int, Course], second: Sequence[High]
    ) -> Iterator[tuple[list[High], tuple[High, ...]]]:
        """Yield r̈ of the origin of each body's own frame, frame O, and dω′/dt in that frame."""
        for k, body in enumerate(self.bodies):
            place = at[k].point(self._numbers(body.origin_b))
            alpha = [second[column] for column in self.own(k)[3:]]
            turning = turned_back(self._numbers(body.axes_b), alpha) if alpha else ()
            yield [x.dd for x in place], turning

    def momentum(
        self, bodies: Sequence[int], poses: Sequence[Pose], about: Sequence[float] | None
    ) -> tuple[list[High], list[High]]:
        """Return Σ m v, and Σ (r − o) × m v + A I′ω′ about a point o, or the centre of mass."""
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
            spin: Sequence[High] = (0, 0, 0)
            if not body.is_point:
                moments = self._numbers(body.inertia)
                spin = turned(one.p, [a * b for a, b in zip(moments, one.omega_b, strict=True)])
            total = [a + b + c for a, b, c in zip(total, part, spin, strict=True)]
        return linear, total


def _difference(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]
