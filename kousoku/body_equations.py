"""The equations of a scene of bodies as it is written, in numbers, at any state.

Rows come from the kernels of the kinds and M from the one of a rigid body, as a solver has them:
they are evaluated for centres of mass and principal axes, and led to the body frames of the scene.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from copy import copy
from dataclasses import replace
from functools import cached_property
from itertools import accumulate
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from kousoku.codegen.dynamics.assembled import assemble_scene
from kousoku.codegen.dynamics.assembly.residuals import unit_of
from kousoku.codegen.dynamics.composition.equations import NUMBERS, system_equations
from kousoku.codegen.dynamics.emission.context_numbers import row_of
from kousoku.codegen.dynamics.operations.characteristic_length import characteristic_length
from kousoku.codegen.dynamics.operations.mechanics import frozen
from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter
from kousoku.codegen.dynamics.redundancy.freedom import mobility_of
from kousoku.codegen.dynamics.simplification.outline import outline_of
from kousoku.labels import columns_of, is_turn, rows_of
from kousoku.model.errors import SolveError
from kousoku.model.expressions.formulas import TIME
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.values import value_of
from kousoku.model.lowering.parametric import fixed_system
from kousoku.model.lowering.system import system_of
from kousoku.model.numbers.varying import Varying
from kousoku.model.operations.interpret import ARRAY
from kousoku.model.operations.interpret import evaluate as evaluated
from kousoku.runtime.integrate.body_tables import BodyPlaces, solver_state, written_sizes
from kousoku.runtime.integrate.euler_parameters import rotated
from kousoku.runtime.integrate.run_arguments import (
    misfit_of_bodies,
    numbers_of,
    require_numbers,
    values_of,
)
from kousoku.runtime.messages import listed, unknown

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import numpy.typing as npt

    from kousoku.codegen.dynamics.redundancy.freedom import Mobility
    from kousoku.model.mechanics.multibody import Instance, MovingBody, System
    from kousoku.model.numbers.real import Array
    from kousoku.model.records.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver

#: Scenes whose equations are kept.
KEPT = 8
#: Turns that are tried to close gears, and how near to whole ones they must be.
MOST_TURNS, WHOLE = 100, 1e-6


def equations_of(scene: Scene) -> SceneEquations:
    """Equations of a scene; those of the last scenes are kept."""
    equations = _KEPT.get(id(scene))
    if equations is None or equations.scene is not scene:
        equations = SceneEquations(scene)
    _KEPT[id(scene)] = equations
    _KEPT.move_to_end(id(scene))
    while len(_KEPT) > KEPT:
        _KEPT.popitem(last=False)
    return equations


#: Equations by the identity of their scenes, which they keep alive.
_KEPT: OrderedDict[int, SceneEquations] = OrderedDict()


class CheckedState(NamedTuple):
    """A state that was checked.

    Parameters
    ----------
    time : float [s]
        Its time.
    q, v : array
        As the scene is written; Euler parameters of norm one.
    near : dict of str to float [rad]
        Angles within half a turn of which the turns of a state are counted.
    known : frozenset of str
        Names of angles whose turns drivers prescribe, or the caller.
    parameters : dict of str to float
        All parameters of the scene.
    """

    time: float
    q: Array
    v: Array
    near: dict[str, float]
    known: frozenset[str]
    parameters: dict[str, float]


class EquationsAtState(NamedTuple):
    """The equations at a state, in the unit of the scene.

    Parameters
    ----------
    C, nu, gamma : (m,) array
        Residuals, and the right sides of C_q v = ν and C_q v̇ = γ.
    C_q : (m, n) array
        Jacobian.
    M : (n, n) array
        Mass matrix about the origins of the body frames.
    f : (n,) array
        Applied forces less velocity forces.
    """

    C: Array
    nu: Array
    gamma: Array
    C_q: Array
    M: Array
    f: Array


class SceneEquations:
    """The equations of a scene of bodies; terms that do not depend on a state are prepared once.

    Parameters
    ----------
    scene : Scene
        A checked scene of bodies.

    Raises
    ------
    SceneError, AssemblyError
        It is none, or its bodies do not fit together.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.system = assemble_scene(scene, ()).system
        self._recorded = system_equations(self.system)
        self._program = self._recorded.program
        self._workspace = ProgramInterpreter(self._program)
        self.name, self.unit = self.system.name, self.system.unit
        #: As of a solver.
        self.parameters = self.system.parameters
        #: A length of the scene, in its unit.
        self.length = characteristic_length(self.system) / self.unit
        self.bodies = _body_places(self.system)
        self.sizes = written_sizes(self.bodies)
        #: Where bodies begin in q and in v as the scene is written.
        self.starts = tuple(
            tuple(accumulate((size if body.p else 3 for body in self.bodies), initial=0))
            for size in (7, 6)
        )
        self.columns = columns_of(self.system.bodies)
        self.rows = tuple(rows_of(self.system, self._program.rows))
        constraints = [self.system.constraints[row.instance] for row in self._program.rows]
        self.units = tuple(
            scene.unit if unit_of(constraint) == "m" else "rad" for constraint in constraints
        )
        #: Joint or driver of each row, and the unit of its residual in SI, as of a solver.
        self.checked = [row_of(row, self.system) for row in self._program.rows]
        self._row_scale = np.array(
            [
                (1 / self.unit if unit_of(constraint) == "m" else 1.0) / constraint.scale
                for constraint in constraints
            ]
        )
        self._column_scale = np.array([1.0 if is_turn(x) else self.unit for x in self.columns])
        self._nonzeros = tuple(
            np.array(indices, int) for indices in zip(*self._recorded.places, strict=True)
        )
        #: Names of angles that count turns, by whether a solver has a table of coordinates.
        self._turning: dict[bool, list[str]] = {}
        #: Masses and moments that M lacks, empty if none: a rod may be thin about one axis.
        self.lacks = _lack(self.system.bodies)

    @property
    def has_masses(self) -> bool:
        """Whether the scene gives all masses, and so has M and f."""
        return not self.lacks

    @cached_property
    def _freedom(self) -> Mobility:
        return mobility_of(fixed_system(self.system), outline_of(self.system, None))

    @property
    def unknown(self) -> tuple[str, ...]:
        """Joints in so large a loop that nothing is known of whether their rows are redundant."""
        return self._freedom.unknown

    @cached_property
    def redundant(self) -> npt.NDArray[np.bool_]:
        """Mask of rows that depend on the others wherever the scene moves, (m,)."""
        dropped = {(row.instance, row.row) for row in self._freedom.dropped}
        return np.array([(row.instance, row.row) in dropped for row in self._program.rows], bool)

    def state(
        self,
        t: float,
        q: npt.ArrayLike,
        v: npt.ArrayLike,
        parameters: Mapping[str, float | str] | None,
        angles: Mapping[str, float] | None,
    ) -> CheckedState:
        """State that is possible, with the values near which its angles are counted.

        Raises
        ------
        SolveError
            It is not.
        """
        values = values_of(self.name, dict(self.parameters), parameters)
        require_numbers(self.name, time=t)
        checked_q, checked_v = (
            self._checked_array(*arguments)
            for arguments in zip("qv", (q, v), self.sizes, strict=True)
        )
        for body, first in zip(self.bodies, self.starts[0], strict=False):
            p = checked_q[first + 3 : first + 7] if body.p else np.ones(1)
            norm = float(np.sqrt(p @ p))
            if not norm > 0.0:
                raise SolveError(
                    f"{self.name}: q has no Euler parameters of {body.name}: all four are 0"
                )
            p /= norm
        near, counted = self._near(float(t), values, angles or {})
        return CheckedState(float(t), checked_q, checked_v, near, counted, values)

    def _checked_array(self, name: str, numbers: npt.ArrayLike, size: int) -> Array:
        """Array of q or v, with as many numbers as the bodies of the scene have."""
        array = numbers_of(self.name, name, numbers).copy()
        if wrong := misfit_of_bodies(name, array, size):
            raise SolveError(f"{self.name}: {wrong}")
        return array

    def _near(
        self, time: float, values: Mapping[str, float], angles: Mapping[str, float]
    ) -> tuple[dict[str, float], frozenset[str]]:
        """Angles to count turns near: the caller's, those of drivers, else those of the start."""
        turning = {x.name: x.near for x in self.system.coordinates if x.counts_turns}
        prescribed = {}
        for constraint in self.system.constraints:
            names = [self.system.coordinates[term.coordinate].name for term in constraint.terms]
            if constraint.is_driver and names[0] in turning:
                arguments = {**values, TIME: time}
                law = value_of(parse_expression(constraint.law, tuple(arguments)), arguments)
                if math.isfinite(law):
                    prescribed[names[0]] = constraint.law_unit * law / constraint.terms[0].factor
        for name, value in angles.items():
            if name not in turning and name not in self.scene.coordinates:
                raise SolveError(f"{self.name}: {unknown('angle', name, sorted(turning))}")
            number: dict[str, Any] = {f"angle {name}": value}
            require_numbers(self.name, **number)
            if name in turning:
                prescribed[name] = float(value)
        return turning | prescribed, frozenset(prescribed)

    def numbers(self, state: CheckedState) -> tuple[EquationsAtState, CheckedState]:
        """Equations at a state, and the state with the turns of its angles."""
        work, masses = self._with_parameters(state)
        bodies = [
            replace(body, origin_b=tuple(numbers[4:7].tolist()), axes_b=tuple(numbers[7:].tolist()))
            for body, numbers in zip(self.bodies, masses, strict=True)
        ]
        zeros = np.zeros(len(work["q"])), np.zeros(len(work["v"]))
        q, v = solver_state(bodies, state.q, state.v, self.unit, zeros)
        work["t"], work["v"] = [state.time], v.tolist()
        self._run(work, q, state)
        turned = self._with_turns(state, work["C"])
        if turned.near != state.near:
            self._run(work, q, turned)
        return self._written(work, bodies, masses, turned, (q, v)), turned

    def _with_parameters(self, state: CheckedState) -> tuple[ProgramInterpreter, Array]:
        """Workspace with the parameters of a state, and the numbers of the bodies."""
        work, program = copy(self._workspace), self._program
        work.values = list(self._workspace.values)
        work["parameters"] = [*state.parameters.values()]
        if program.design:
            try:
                work.run("setup")
            except (ArithmeticError, ValueError):
                work["design"] = [math.nan] * len(work["design"])
            slots, numbers = dict(program.design.places), work["design"]
            wrong = [
                f"{name} is {numbers[slots[key]]:.6g}; wanted a positive number"
                for name, key in program.design.positive
                if not numbers[slots[key]] > 0.0
            ]
            if not np.isfinite(numbers).all():
                wrong.append("a formula of the scene has no finite value")
            if wrong:
                values = ", ".join(f"{name} = {x:.6g}" for name, x in state.parameters.items())
                raise SolveError(f"{self.name}: with {values}: {'; '.join(dict.fromkeys(wrong))}")
        work.run("masses")
        return work, np.array(work["masses"]).reshape(-1, NUMBERS)

    def _run(self, work: ProgramInterpreter, q: Array, state: CheckedState) -> None:
        """Evaluate all kernels at a state."""
        auxiliary = [state.near.get(coordinate.name, 0.0) for coordinate in self._program.auxiliary]
        work["q"] = [*q[: self.sizes[0]].tolist(), *auxiliary]
        try:
            work.run("geometry")
        except (ArithmeticError, ValueError) as problem:
            raise SolveError(
                f"{self.name}: its equations have no finite values at this state ({problem}): a"
                " formula has none, or two points coincide whose distance counts"
            ) from None

    def _with_turns(self, state: CheckedState, c: Sequence[float]) -> CheckedState:
        """State whose angles have the turns that close gears, screws and couplings.

        Positions tell angles up to whole turns. Where no turns close a row, none are added.
        """
        rows = [
            (float(value) / math.tau, self._factors(instance, state.parameters))
            for row, value in zip(self._program.rows, c, strict=True)
            if (instance := self.system.constraints[row.instance]).terms
        ]
        rows = [(value, factors) for value, factors in rows if factors]
        turns = _solved_turns(rows, dict.fromkeys(state.known, 0)) or dict.fromkeys(state.known, 0)
        for name in dict.fromkeys(name for _, factors in rows for name in factors):
            tries = (sign * n for n in range(MOST_TURNS) for sign in ((1, -1) if n else (1,)))
            if name not in turns:
                trials = (_solved_turns(rows, turns | {name: n}) for n in tries)
                turns = next(filter(None, trials), turns | {name: 0})
        near = {name: x + math.tau * turns.get(name, 0) for name, x in state.near.items()}
        return state._replace(near=near)

    def _factors(self, constraint: Instance, parameters: Mapping[str, float]) -> dict[str, float]:
        """Factors of the angles that a row combines."""
        factors: dict[str, float] = {}
        for term in constraint.terms:
            coordinate, factor = self.system.coordinates[term.coordinate], term.factor
            if isinstance(factor, Varying):
                factor = value_of(factor.traced.expression, parameters)
            if coordinate.counts_turns:
                factors[coordinate.name] = factors.get(coordinate.name, 0.0) + factor
        return factors

    def _written(
        self,
        work: ProgramInterpreter,
        bodies: Sequence[BodyPlaces],
        masses: Array,
        state: CheckedState,
        solved: tuple[Array, Array],
    ) -> EquationsAtState:
        """Evaluated equations, for the body frames and in the unit of the scene."""
        m, n = len(self.rows), len(self.columns)
        jacobian, drift = np.zeros((m, n)), np.zeros(n)
        if m:
            jacobian[self._nonzeros] = work["jacobian"]
        written, mass = np.zeros((m, n)), np.zeros((n, n))
        force, loads = np.zeros(n), np.array(work["forces"])
        for k, body in enumerate(bodies):
            block = slice(*self.starts[1][k : k + 2])
            to_system, drift[block] = _velocity_map(body, *solved)
            written[:, block] = jacobian[:, block] @ to_system
            p, omega = state.q[self.starts[0][k] + 3 :][:4], state.v[block][3:]
            mass[block, block], force[block] = _newton_euler(
                body, masses[k], p, omega, to_system.T @ loads[block]
            )
        rows, columns = self._row_scale, self._column_scale
        return EquationsAtState(
            C=rows * np.array(work["C"]),
            nu=0.0 - rows * np.array(work["minus_nu"]),
            gamma=0.0 - rows * (np.array(work["minus_gamma"]) + jacobian @ drift),
            C_q=rows[:, np.newaxis] * written * columns,
            M=columns[:, np.newaxis] * mass * columns / self.unit**2,
            f=columns * force / self.unit**2,
        )

    def turning(self, solver: DynamicsSolver) -> tuple[int, list[str]]:
        """First index in q of a solver of the angles that count turns, and their names."""
        is_shown = bool(solver.layout.coordinates)
        if is_shown not in self._turning:
            system = system_of(self.scene, ("coordinates",) if is_shown else ())
            needed = system.coordinates[: len(system.coordinates) - system.only_held]
            self._turning[is_shown] = [
                coordinate.name for coordinate in needed if coordinate.counts_turns
            ]
        names = self._turning[is_shown]
        first = len(solver.q) - len(solver.layout.works) - len(names)
        indices = [k for body in solver.bodies for k in (*body.r, *body.p) if isinstance(k, int)]
        if first != max(indices, default=-1) + 1:
            raise SolveError(f"{self.name}: the solver was not made from this scene")
        return first, names


def _solved_turns(
    rows: Sequence[tuple[float, Mapping[str, float]]], known: Mapping[str, int]
) -> dict[str, int] | None:
    """Turns of all angles that follow from those of some, None where a row stays open.

    Parameters
    ----------
    rows : sequence of (float, dict)
        Residual of each row, in turns, and the factors of its angles.
    known : mapping of str to int
        Turns of the other angles.
    """
    turns = dict(known)
    remaining = list(rows)
    while True:
        postponed = []
        for value, factors in remaining:
            residual = value + sum(x * turns[name] for name, x in factors.items() if name in turns)
            missing = [name for name in factors if name not in turns and factors[name]]
            if len(missing) == 1:
                turn = -residual / factors[missing[0]]
                if abs(turn) > 1 / WHOLE or abs(turn - round(turn)) > WHOLE:
                    return None
                turns[missing[0]] = round(turn)
            elif missing:
                postponed.append((value, factors))
            elif abs(residual) > WHOLE:
                return None
        if len(postponed) == len(remaining) or not postponed:
            return turns
        remaining = postponed


def _lack(bodies: Sequence[MovingBody]) -> str:
    """Say which bodies have no mass, or no moments of inertia though they can turn."""
    massless = [body.name for body in bodies if not body.mass > 0.0]
    without_inertia = [
        x.name for x in bodies if x.mass > 0.0 and not x.is_point and not any(x.inertia)
    ]
    pairs = (("mass", massless), ("moments of inertia", without_inertia))
    return " and ".join(f"no {quantity} of {listed(names)}" for quantity, names in pairs if names)


def _body_places(system: System) -> tuple[BodyPlaces, ...]:
    """Indices of bodies in q and v where no coordinate is left out."""
    places, at_q, at_v = [], 0, 0
    for body in system.bodies:
        turns = not body.is_point
        places.append(
            BodyPlaces(
                body.name,
                tuple(range(at_q, at_q + 3)),
                tuple(range(at_q + 3, at_q + 7)) if turns else (),
                tuple(range(at_v, at_v + 3)),
                tuple(range(at_v + 3, at_v + 6)) if turns else (),
                body.origin_b,
                body.axes_b,
            )
        )
        at_q, at_v = at_q + 3 + 4 * turns, at_v + 3 + 3 * turns
    return tuple(places)


def _velocity_map(body: BodyPlaces, q: Array, v: Array) -> tuple[Array, Array]:
    """T and Ṫ v for v_s = T v, from the velocities of the scene to those of a system.

    A system has the centre of mass and the principal axes in place of the body frame: with s′ from
    there to the origin, ṙ_s = ṙ + A_s s̃′ ω_s′ and ω_s′ = A(axes) ω′.
    """
    if not body.p:
        return np.eye(3), np.zeros(3)
    p, omega = q[list(map(int, body.p))], v[list(map(int, body.omega_b))]
    arm, turn, to_o = np.array(body.origin_b), _matrix(body.axes_b), _matrix(p)
    to_system = np.eye(6)
    to_system[:3, 3:] = to_o @ _tilde(arm) @ turn
    to_system[3:, 3:] = turn
    drift = np.zeros(6)
    drift[:3] = -to_o @ np.cross(omega, np.cross(omega, arm))
    return to_system, drift


def _newton_euler(
    body: BodyPlaces, properties: Array, p: Array, omega: Array, load: Array
) -> tuple[Array, Array]:
    """M about the origin of the body frame, and applied less velocity forces, in SI units.

    Parameters
    ----------
    body : BodyPlaces
        The frames of the body.
    properties : array
        Its mass and principal moments first.
    p, omega : array
        Euler parameters and angular velocity of its body frame, empty or unused of a point.
    load : array
        Force in frame O, and torque about that origin in the body frame.
    """
    mass = properties[0]
    if not body.p:
        return mass * np.eye(3), load
    turn = _matrix(body.axes_b)
    center = -turn.T @ np.array(body.origin_b)
    inertia = turn.T @ np.diag(properties[1:4]) @ turn - mass * _tilde(center) @ _tilde(center)
    inputs: dict[str, Any] = {"mass": [mass], "r_AG_b": center, "I_A_b": inertia.ravel()}
    inputs |= {"p": p, "omega_b": omega, "F": load[:3], "N_b": load[3:]}
    terms = evaluated(frozen("rigid_body", "newton_euler"), inputs, ARRAY)
    return np.array(terms["M"], dtype=float).reshape(6, 6), np.array(terms["h"], dtype=float)


def _tilde(a: Array) -> Array:
    """Skew matrix ã with ã b = a × b."""
    x, y, z = a
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _matrix(p: npt.ArrayLike) -> Array:
    """Matrix A(p) for Euler parameters of norm one."""
    return rotated(np.asarray(p)[:, np.newaxis], np.eye(3))
