"""Equations of a scene from its definitions, for comparison with the results of a solver.

Each body of the scene has its own equations, m v̇ = F and I′ ω̇′ = N′ − ω̃′ I′ ω′, with forces,
joints, drivers and coordinates as the scene gives them, each by its geometric definition. Nothing
is merged, put into a plane, put onto a joint or left out, and no kernel, operation or composition
has a part in it: their faults show. A residual C along a motion,
:mod:`~kousoku.codegen.dynamics.operations.jets`, comes with Ċ and C̈, from which C_q, ν and γ
follow by Ċ = C_q v − ν and C̈ = C_q v̇ − γ. Of a kind of one's own C is what its kernel computes,
there is no other definition; the Jacobian, ν and γ of its kernels have no part in it.
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


class BodyMotion:
    """Motion of a body: r(t) and p(t) to second order, ṗ = ½ p ∘ (0, ω′), lecture 7.1, (5.16).

    Parameters
    ----------
    r, p : (3,) [m], (4,) [-] of Jet
        Centre of mass in frame O, and Euler parameters of the principal frame.
    """

    def __init__(self, r: Sequence[Jet], p: Sequence[Jet]) -> None:
        self.r, self.p = r, p

    @classmethod
    def of(cls, pose: BodyState, rates: Sequence[Real], v_dot: Sequence[Real]) -> BodyMotion:
        """Motion of a body with v, ω′ and v̇, ω̇′; p̈ = ½ (ṗ ∘ (0, ω′) + p ∘ (0, ω̇′)).

        Parameters
        ----------
        pose : BodyState
            Its r and p; its velocities are not used.
        rates, v_dot : (6,) [m/s, rad/s], [m/s², rad/s²]
            v and v̇ in frame O, ω′ and ω̇′ in the principal frame.
        """
        r = [Jet(x, rates[k], v_dot[k]) for k, x in enumerate(pose.r)]
        omega, alpha = (0, *rates[3:]), (0, *v_dot[3:])
        p_dot = [x / 2 for x in quaternion_product(pose.p, omega)]
        terms = zip(
            quaternion_product(p_dot, omega), quaternion_product(pose.p, alpha), strict=True
        )
        return cls(
            r, [Jet(x, d, (a + b) / 2) for x, d, (a, b) in zip(pose.p, p_dot, terms, strict=True)]
        )

    def with_rates(self, rates: Sequence[Real]) -> BodyMotion:
        """Motion through the same pose at other, constant v [m/s] and ω′ [rad/s], (6,)."""
        pose = BodyState([x.x for x in self.r], [x.x for x in self.p], (), ())
        return BodyMotion.of(pose, rates, [0] * 6)

    def vector(self, a: Sequence[Real]) -> JetVector:
        """Vector A a′ (3,) in frame O, of a′ (3,) in the principal frame, in its unit."""
        return rotated(self.p, [Jet(x) for x in a])

    def point(self, s: Sequence[Real]) -> JetVector:
        """Position r + A s′ (3,) [m] in frame O, of a point s′ (3,) [m] in the principal frame."""
        x, y, z = (a + b for a, b in zip(self.r, self.vector(s), strict=True))
        return x, y, z


@dataclass(slots=True)
class AppliedForces:
    """Forces at a state: f of M v̇ + C_qᵀλ = f.

    Parameters
    ----------
    force : list (n,) [N, N m]
        F in frame O and N′ about the centre of mass, in the principal frame, for each body.
    potential, kinetic : number [J]
        Energies.
    powers : dict of str to number [W]
        Powers of forces, by name, where their work is no potential energy.
    sizes : list of number [J]
        Terms of the sums that the energies are.
    steepness : sequence (n,) of float [N, N m]
        Changes of f per relative change of the state.
    time : number [s]
        Time of the state.
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
        C, and the right sides of C_q v = ν and C_q v̇ = γ on the constraints.
    jacobian : dict of int to number
        C_q by column: δr [m] in frame O, δθ′ [rad] in the principal frame.
    """

    instance: Instance
    value: Real
    nu: Real
    gamma: Real
    jacobian: dict[int, Real]


class NewtonEulerEquations:
    """The equations of all bodies of an unsimplified system: M v̇ + C_qᵀλ = f, C_q v̇ = γ.

    Columns (n,) are δr [m] in frame O and δθ′ [rad] in the principal frame of each body, rows f [N]
    and [N m] in the same frames: m v̇ = F, I′ω̇′ = N′ − ω̃′I′ω′, three mass points,
    (newton-euler-force) and (newton-euler-moment).

    Parameters
    ----------
    system : System
        The scene, all of whose numbers are fixed.
    digits : FormulaArithmetic
        Arithmetic of all numbers: doubles or 50 digits.
    """

    def __init__(self, system: System, digits: FormulaArithmetic[Any] = HIGH) -> None:
        self.system, self.digits = system, digits
        self.bodies = system.bodies
        #: The first column of each body, then the count of all columns.
        sizes = (3 if body.is_point else 6 for body in self.bodies)
        self._first_columns = [*accumulate(sizes, initial=0)]
        self.count = self._first_columns[-1]
        self._ground = BodyMotion([self._jet(0)] * 3, [self._jet(x) for x in (1, 0, 0, 0)])
        self._formulas: dict[tuple[str, tuple[str, ...]], Expression] = {}

    def _jet(self, x: float) -> Jet:
        return Jet(self.digits.number(x))

    def _numbers(self, values: Sequence[float]) -> list[Real]:
        return [self.digits.number(x) for x in values]

    def columns_of(self, body: int) -> range:
        """Columns of a body: δr [m] in frame O, δθ′ [rad] in the principal frame, if it turns."""
        return range(self._first_columns[body], self._first_columns[body + 1])

    def inertia(self) -> list[Real]:
        """Diagonal of M (n,) [kg, kg m²]: m and the principal moments."""
        diagonals = (
            [body.mass] * 3 + ([] if body.is_point else list(body.inertia)) for body in self.bodies
        )
        return self._numbers([x for diagonal in diagonals for x in diagonal])

    def rates(self, poses: Sequence[BodyState]) -> list[Real]:
        """Velocities v (n,) [m/s, rad/s] of all bodies, (ṙ, ω′) of each."""
        pairs = zip(self.bodies, poses, strict=True)
        return [
            x for body, pose in pairs for x in (*pose.v, *(() if body.is_point else pose.omega_b))
        ]

    def course(
        self, body: int, pose: BodyState, rates: Sequence[Real], v_dot: Sequence[Real]
    ) -> BodyMotion:
        """Motion of a body, from v (n,) and v̇ (n,) of all."""
        columns = self.columns_of(body)
        local = [
            [values[k] for k in columns] + [0] * (6 - len(columns)) for values in (rates, v_dot)
        ]
        return BodyMotion.of(pose, *local)

    def courses(
        self,
        bodies: Sequence[int],
        poses: Sequence[BodyState],
        rates: Sequence[Real],
        v_dot: Sequence[Real],
    ) -> dict[int, BodyMotion]:
        """Courses of some bodies and of the ground, from v (n,) and v̇ (n,) of all."""
        moving = [k for k in bodies if k != GROUND_INDEX]
        courses = {k: self.course(k, poses[k], rates, v_dot) for k in moving}
        return {GROUND_INDEX: self._ground, **courses}

    # Coordinates.

    def coordinate(self, index: int, courses: Mapping[int, BodyMotion]) -> Jet:
        """Value u [m, rad or -]: an angle with its turns, a displacement, a distance, a cosine."""
        coordinate = self.system.coordinates[index]
        constants = {name: self._numbers(values) for name, values in coordinate.constants}
        i, j = courses[coordinate.i], courses[coordinate.j]
        (value,) = facets_of_kind(coordinate.kind).residuals(i, j, constants, self.digits)
        if not coordinate.counts_turns:
            return value
        turn = 8 * self.digits.atan(self.digits.number(1))
        count = round(float((self.digits.number(coordinate.near) - value.x) / turn))
        return value + Jet(turn * count)

    def _residuals(
        self, instance: Instance, courses: Mapping[int, BodyMotion], time: Real
    ) -> Sequence[Jet]:
        """Residuals C of a joint or driver, zero where it holds."""
        constants = {name: self._numbers(values) for name, values in instance.constants}
        if instance.is_combination:
            total = self._jet(instance.offset)
            for term in instance.terms:
                factor = self.digits.number(term.factor)
                total += self.coordinate(term.coordinate, courses).times(factor)
            if instance.law:
                law = self.value(instance.law, {TIME: Jet(time, self.digits.number(1))})
                total -= law.times(self.digits.number(instance.law_unit))
            return (total,)
        if is_own(instance.kind):
            return self._user_residuals(instance, courses)
        kind = facets_of_kind(instance.kind)
        return kind.residuals(courses[instance.i], courses[instance.j], constants, self.digits)

    def _user_residuals(
        self, instance: Instance, courses: Mapping[int, BodyMotion]
    ) -> Sequence[Jet]:
        """Residuals C of a kind of one's own, which its kernel ``constraint`` defines.

        The kernel takes the frames that the kind is stated in. C_q, ν and γ follow from C here,
        and not from the kernels.
        """
        constants = {
            name: [Jet(x) for x in self._numbers(values)] for name, values in instance.constants
        }
        inputs = {
            name.removeprefix(PREFIX): values for name, values in constants.items() if is_own(name)
        }
        for body, index in zip("ij", (instance.i, instance.j), strict=True):
            course, origin = courses[index], dict(instance.constants)[f"origin_{body}"]
            inputs[f"r_{body}"] = [*course.point(self._numbers(origin))]
            inputs[f"p_{body}"] = [*quaternion_product(course.p, constants[f"frame_{body}"])]
        kernel = next(k for k in load_frozen(instance.kind).kernels if k.name == "constraint")
        return evaluate(with_outputs(kernel, ["C"]), inputs, arithmetic_of(self.digits))["C"]

    def value(self, text: str, names: Mapping[str, Jet]) -> Jet:
        """Value of a formula in these names and the parameters."""
        known = {name: self._jet(x) for name, x in self.system.parameters} | dict(names)
        key = text, tuple(known)
        if key not in self._formulas:
            self._formulas[key] = parse_expression(text, known, longest=len(text))
        return formula(self._formulas[key], known, self.digits)

    # The constraints.

    def constraint_rows(self, poses: Sequence[BodyState], time: Real) -> list[ConstraintRow]:
        """Rows C, ν, γ, C_q of all joints and drivers, dependent rows included."""
        rates, zeros = self.rates(poses), [self.digits.number(0)] * self.count
        rows: list[ConstraintRow] = []
        for instance in self.system.constraints:
            bodies = [body for body in instance.bodies if body != GROUND_INDEX]
            courses = self.courses(bodies, poses, rates, zeros)
            moving = self._residuals(instance, courses, time)
            resting_courses = self.courses(bodies, poses, zeros, zeros)
            resting = self._residuals(instance, resting_courses, time)
            instance_rows = [
                ConstraintRow(instance, c.x, -s.d, -c.dd, {})
                for c, s in zip(moving, resting, strict=True)
            ]
            for column, unit_courses in self.each_column(resting_courses):
                unit_rates = self._residuals(instance, unit_courses, time)
                for row, a, s in zip(instance_rows, unit_rates, resting, strict=True):
                    row.jacobian[column] = a.d - s.d
            rows += instance_rows
        return rows

    def each_column(
        self, courses: Mapping[int, BodyMotion]
    ) -> Iterator[tuple[int, dict[int, BodyMotion]]]:
        """Columns of the bodies, each with the courses where its velocity is one, others zero."""
        zeros = [self.digits.number(0)] * 6
        resting = {body: course.with_rates(zeros) for body, course in courses.items()}
        for body, course in resting.items():
            for k, column in enumerate(self.columns_of(body) if body != GROUND_INDEX else ()):
                rates = [self.digits.number(k == n) for n in range(6)]
                yield column, {**resting, body: course.with_rates(rates)}

    # The forces.

    def loads(self, poses: Sequence[BodyState], time: Real) -> AppliedForces:
        """Forces f (n,), applied less velocity forces ω̃′I′ω′, and the energies [J]."""
        rates, zeros = self.rates(poses), [self.digits.number(0)] * self.count
        loads = AppliedForces([*zeros], time=time)
        courses = self.courses(range(len(poses)), poses, rates, zeros)
        gravity = self._gravity()
        for k, (body, pose) in enumerate(zip(self.bodies, poses, strict=True)):
            self._add_body(body, pose, gravity, self.columns_of(k), loads)
        for force in self.system.forces:
            self._add_force(force, courses, time, loads)
        return loads

    def _gravity(self) -> list[Real]:
        """Gravity g (3,) [m/s²], frame O."""
        unit = self.digits.number(self.system.unit)
        pairs = zip(self.system.gravity, self.system.gravity_law, strict=True)
        return [
            self.value(text, {}).x * unit if text else self.digits.number(x) for x, text in pairs
        ]

    def _add_body(
        self,
        body: MovingBody,
        pose: BodyState,
        gravity: Sequence[Real],
        columns: range,
        loads: AppliedForces,
    ) -> None:
        """Add weight, −ω̃′ I′ ω′ and the energies of a body: ½ m v·v + ½ ω′·I′ω′ and −m g·r."""
        mass = self.digits.number(body.mass)
        kinetic = mass * sum(x * x for x in pose.v) / 2
        potential = -mass * sum(g * x for g, x in zip(gravity, pose.r, strict=True))
        for k in range(3):
            loads.force[columns[k]] += mass * gravity[k]
        if not body.is_point:
            spin = [
                self.digits.number(a) * b for a, b in zip(body.inertia, pose.omega_b, strict=True)
            ]
            kinetic += sum(a * b for a, b in zip(spin, pose.omega_b, strict=True)) / 2
            for k, x in enumerate(cross(pose.omega_b, spin)):
                loads.force[columns[3 + k]] -= x
        loads.kinetic += kinetic
        loads.potential += potential
        loads.sizes += [kinetic, potential]

    def _add_force(
        self,
        force: ForceElement,
        courses: Mapping[int, BodyMotion],
        time: Real,
        loads: AppliedForces,
    ) -> None:
        """Add a force, its power, and its potential energy."""
        names = self._formula_names(courses, time)
        constants = self._constants(force, names)
        power, energy = facets_of(force).by_definition(self, courses, names, constants, loads)
        if force.is_nonconservative:
            loads.powers[force.name] = loads.powers.get(force.name, 0) + power
        if force.has_potential:
            loads.potential += energy
            loads.sizes.append(energy)

    def _constants(self, force: ForceElement, names: Mapping[str, Jet]) -> dict[str, list[Real]]:
        """Constants of a force, each times its formula where it has one."""
        texts = dict(force.formulas)
        return {
            name: [
                self.digits.number(x) * (self.value(texts[name], names).x if name in texts else 1)
                for x in values
            ]
            for name, values in force.constants
        }

    def elongation(
        self, force: ForceElement, courses: Mapping[int, BodyMotion], time: Real, *, is_length: bool
    ) -> Jet:
        """Elongation that a spring's law takes, or the distance of its ends; in its unit."""
        constants = self._constants(force, self._formula_names(courses, time))
        value, free_length = facets_of(force).length_by_definition(self, courses, constants)
        if not is_length:
            value -= Jet(free_length)
        (unit,) = constants.get("unit", self._numbers((1,)))
        return value.times(1 / unit)

    def _formula_names(self, courses: Mapping[int, BodyMotion], time: Real) -> dict[str, Jet]:
        """Values of the names that formulas may use, in the unit of the scene."""
        names = {TIME: Jet(time, self.digits.number(1))}
        for index, coordinate in enumerate(self.system.coordinates):
            value = self.coordinate(index, courses)
            if is_length(coordinate.kind):
                value = value.times(1 / self.digits.number(self.system.unit))
            names |= {coordinate.name: value, f"{coordinate.name}{RATE}": Jet(value.d)}
        return names

    def apply_force(
        self,
        body: int,
        course: BodyMotion,
        arm: Sequence[Real],
        force: Sequence[Real],
        loads: AppliedForces,
    ) -> None:
        """Add a force F (3,) [N] in frame O that acts on a point s′ (3,) [m]: F, and s′ × AᵀF."""
        if body == GROUND_INDEX:
            return
        columns = self.columns_of(body)
        torque = cross(arm, rotated_back([x.x for x in course.p], force))
        for k, x in zip(columns, (*force, *torque), strict=False):
            loads.force[k] += x

    def apply_torque(
        self, body: int, course: BodyMotion, torque: Sequence[Real], loads: AppliedForces
    ) -> Real:
        """Add a torque N (3,) [N m] in frame O that acts on a body, AᵀN; return its power N·ω."""
        p = [x.x for x in course.p]
        columns = self.columns_of(body)[3:] if body != GROUND_INDEX else range(0)
        torque_b = rotated_back(p, torque)
        half_omega = quaternion_product((p[0], -p[1], -p[2], -p[3]), [x.d for x in course.p])
        for k, x in zip(columns, torque_b, strict=False):
            loads.force[k] += x
        power: Real = 2 * sum(a * b for a, b in zip(torque_b, half_omega[1:], strict=True))
        return power

    # Accelerations and momenta.

    def origins(
        self, courses: Mapping[int, BodyMotion], v_dot: Sequence[Real]
    ) -> Iterator[tuple[list[Real], tuple[Real, ...]]]:
        """Accelerations r̈ (3,) [m/s²], frame O, of the origins of the body frames, and dω′/dt.

        dω′/dt (3,) [rad/s²] is in the body frame, () for a point; the origin is at r + A s′, with
        s′ in the principal frame.
        """
        for k, body in enumerate(self.bodies):
            origin = courses[k].point(self._numbers(body.origin_b))
            alpha = [v_dot[column] for column in self.columns_of(k)[3:]]
            angular = rotated_back(self._numbers(body.axes_b), alpha) if alpha else ()
            yield [x.dd for x in origin], angular

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
        angular = self._numbers((0, 0, 0))
        for k in bodies:
            pose, body = poses[k], self.bodies[k]
            arm = [a - b for a, b in zip(pose.r, center, strict=True)]
            orbital = cross(arm, [masses[k] * (a - b) for a, b in zip(pose.v, drift, strict=True)])
            spin: Sequence[Real] = (0, 0, 0)
            if not body.is_point:
                moments = self._numbers(body.inertia)
                spin = rotated(pose.p, [a * b for a, b in zip(moments, pose.omega_b, strict=True)])
            angular = [a + b + c for a, b, c in zip(angular, orbital, spin, strict=True)]
        return linear, angular
