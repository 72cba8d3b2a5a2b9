"""Equations that a person gives: written once in CasADi, for SciPy, heyoka, CVODES and IDAS.

They share nothing with kousoku. CasADi differentiates constraints and energies; what it writes in C
is compiled with the flags that kousoku's solvers get.
"""

from __future__ import annotations

import subprocess
import tempfile
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from kousoku.runtime.toolchain import find_toolchain
from tests.benchmarks.kit import required

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.model.numbers.real import Array

#: A source that is longer [bytes] is compiled with -O1: gcc needs minutes for more.
LONG_SOURCE = 4_000_000


@dataclass(frozen=True, slots=True, eq=False)  # told apart by identity, so that code is kept
class StateEquations:
    """ẋ = f(x), or with multipliers ẋ = (q̇, v̇) from the system of index 1.

    Parameters
    ----------
    x : SX (n,)
        The state.
    start : (n,) array
        Its value at time 0.
    observed : SX (k,)
        Positions of the points that are judged, of x.
    rate : SX (n,), optional
        f where it is explicit.
    q_dot, matrix, right : SX, optional
        q̇, and the symmetric system whose solution begins with v̇, where it is not.
    energy, reactions : SX, optional
        Of x; the multipliers themselves where the system has them.
    """

    x: Any
    start: Array
    observed: Any
    rate: Any = None
    q_dot: Any = None
    matrix: Any = None
    right: Any = None
    energy: Any = None
    reactions: Any = None

    @property
    def explicit(self) -> Any:
        """F as one expression; a system is factorised as L D Lᵀ in the order of its rows."""
        if self.rate is not None:
            return self.rate
        ca = required("casadi")
        return ca.vertcat(self.q_dot, self.solved()[: self.x.numel() - self.q_dot.numel()])

    def solved(self) -> Any:
        """v̇ and the multipliers."""
        ca = required("casadi")
        d, lt, order = ca.ldl(self.matrix, False)
        return ca.ldl_solve(self.right, d, lt, order)

    def judge(self) -> Callable[[Array], tuple[Array, Array, Array]]:
        """Function that gives positions, energy and reactions of rows of states."""
        ca = required("casadi")
        empty = ca.SX(0, 1)
        told = [
            self.observed,
            *(empty if one is None else one for one in (self.energy, self.reactions)),
        ]
        function = ca.Function("judge", [self.x], [ca.densify(one) for one in told])

        def of(states: Array) -> tuple[Array, Array, Array]:
            columns = np.ascontiguousarray(states.T)
            positions, energy, reactions = (
                np.array(one).T for one in function.map(len(states))(columns)
            )
            return positions, energy, reactions

        return of


def index_1(
    q: Any,
    v: Any,
    start: Array,
    *,
    mass: Any,
    forces: Any,
    constraints: Any,
    observed: Any,
    q_dot: Any = None,
    energy: Any = None,
    held: Sequence[slice] = (),
) -> StateEquations:
    """M v̇ + Gᵀλ = forces and G v̇ = γ of constraints g(q) = 0; q̇ is v unless given.

    ``held`` are the rows of each joint whose reaction is judged, by how large its force is.
    """
    ca = required("casadi")
    q_dot = v if q_dot is None else q_dot
    jacobian = ca.jacobian(constraints, q)
    if q_dot is not v:
        jacobian = ca.mtimes(jacobian, ca.jacobian(q_dot, v))
    gamma = -ca.jtimes(ca.jtimes(constraints, q, q_dot), q, q_dot)
    rows = constraints.numel()
    matrix = ca.vertcat(ca.horzcat(mass, jacobian.T), ca.horzcat(jacobian, ca.SX(rows, rows)))
    made = StateEquations(
        ca.vertcat(q, v),
        np.asarray(start, dtype=np.float64),
        observed,
        q_dot=q_dot,
        matrix=matrix,
        right=ca.vertcat(forces, gamma),
        energy=energy,
    )
    if not held:
        return made
    multipliers = made.solved()[v.numel() :]
    norms = [ca.norm_2(multipliers[rows]) for rows in held]
    return replace(made, reactions=ca.vertcat(*norms))


def lagrange(
    q: Any,
    v: Any,
    start: Array,
    *,
    kinetic: Any,
    potential: Any,
    observed: Any,
    constraints: Any = None,
    forces: Any = 0,
) -> StateEquations:
    """Lagrange's equations of T(q, v) and V(q), of index 1 where there are constraints."""
    ca = required("casadi")
    momentum = ca.gradient(kinetic, v)
    mass = ca.jacobian(momentum, v)
    right = ca.gradient(kinetic - potential, q) - ca.jtimes(momentum, q, v) + forces
    energy = kinetic + potential
    if constraints is not None:
        return index_1(
            q,
            v,
            start,
            mass=mass,
            forces=right,
            constraints=constraints,
            observed=observed,
            energy=energy,
        )
    return StateEquations(
        ca.vertcat(q, v),
        np.asarray(start, dtype=np.float64),
        observed,
        q_dot=v,
        matrix=mass,
        right=right,
        energy=energy,
    )


def one_freedom(
    angle: Any,
    rate: Any,
    start: Array,
    *,
    mass: Any,
    potential: Any,
    observed: Any,
    torque: Any = 0,
) -> StateEquations:
    """M(θ) θ̈ = τ − V′ − M′ θ̇²/2: reduced by hand to one coordinate."""
    ca = required("casadi")
    slope = ca.jtimes(mass, angle, 1)
    change = (torque - ca.jtimes(potential, angle, 1) - slope * rate * rate / 2) / mass
    return StateEquations(
        ca.vertcat(angle, rate),
        np.asarray(start, dtype=np.float64),
        observed,
        rate=ca.vertcat(rate, change),
        energy=mass * rate * rate / 2 + potential,
    )


def compiled(function: Any) -> Any:
    """CasADi function that calls its own C."""
    ca = required("casadi")
    folder = Path(tempfile.mkdtemp(prefix="bench_"))
    name = f"{function.name()}.c"
    generator = ca.CodeGenerator(name)
    generator.add(function)
    generator.generate(f"{folder}/")
    source, library = folder / name, folder / f"{function.name()}.so"
    command = list(find_toolchain().compile_command([str(source)], str(library)))
    if source.stat().st_size > LONG_SOURCE:
        command = ["-O1" if word == "-O3" else word for word in command]
    subprocess.run(command, check=True)
    return ca.external(function.name(), str(library))


@lru_cache(maxsize=8)
def caller(
    equations: StateEquations, what: Literal["rate", "jacobian"] = "rate"
) -> Callable[[float, Array], Array]:
    """f(t, x) or its Jacobian over arrays, compiled, through CasADi's buffers."""
    ca = required("casadi")
    wanted = equations.explicit
    count = len(equations.start)
    result = np.zeros(count)
    if what == "jacobian":
        wanted = ca.jacobian(wanted, equations.x)
        result = np.zeros((count, count), order="F")
    function = compiled(ca.Function(what, [equations.x], [ca.densify(wanted)], {"cse": True}))
    buffer, call = function.buffer()
    state = np.zeros(count)
    buffer.set_arg(0, state.data)
    buffer.set_res(0, result.ravel(order="K").data)
    kept = (function, buffer)

    def of(_t: float, x: Array, _kept: Any = kept) -> Array:
        state[:] = x
        call()
        return result.copy()

    return of
