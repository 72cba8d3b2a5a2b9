"""What acts on bodies beside gravity: accelerations, power, and potential energy.

Forces on points come from the kernel ``resultant`` of ``mass_points``, springs from the kind
``spring_damper``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.formulas import formula_node
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS, frozen, share
from kousoku.codegen.dynamics.recording.matrix import Matrix
from kousoku.model.mechanism import LAW_NAMES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.codegen.dynamics.recording.traces import Trace

SPRING = "spring_damper"
#: Names of the constants of a spring, in their order.
ENDS, LAW = ("s_i_b", "s_j_b"), ("stiffness", "damping", "free_length")
#: What the law of a spring depends on first: how far it is beyond what is free, and the rate.
ELONGATION = LAW_NAMES[:2]
#: Kinds of loads that act at a point.
POINTED = ("force", "force_b")


@dataclass(frozen=True, slots=True)
class Load:
    """M⁻¹f of a force or torque, and its power.

    Blocks: p, A, v, ω′ and the diagonal of M⁻¹ of the body, of a force its point, then vectors that
    are added up.

    Parameters
    ----------
    kind : str
        ``force``, ``force_b``, ``torque`` or ``torque_b``.
    columns : tuple of int
        The body's coordinates.
    works : bool
        Whether its power is wanted.
    """

    kind: str
    columns: tuple[int, ...]
    works: bool

    @property
    def title(self) -> str:
        """Name the kind."""
        return f"{self.kind} on a body"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return what it adds to the acceleration of each coordinate; F·v + N′·ω′ if wanted."""
        p, orientation, v, omega, weights, *constants = blocks
        share(trace, p, orientation)
        point = constants.pop(0) if self.kind in POINTED else None
        given = sum(constants[1:], constants[0])
        zeros = (trace.graph.const(0),) * 3
        if self.kind == "torque":
            forces = (*zeros, *(orientation.T @ given).flat)
        elif point is None:
            forces = (*zeros, *given.flat)
        elif self.kind == "force":
            forces = _at_point(trace, p.flat, point, given)
        else:
            still = (trace.graph.const(1), *zeros)
            torque = _at_point(trace, still, point, given)[3:]
            forces = (*(orientation @ given).flat, *torque)
        found = (_accelerations(trace, forces, self.columns, weights),)
        if not self.works:
            return found
        mul, rates = trace.graph.mul, (*v.flat, *omega.flat)
        power = trace.graph.sum(mul(a, b) for a, b in zip(forces, rates, strict=True))
        return *found, _number(trace, power)


@dataclass(frozen=True, slots=True)
class Spring:
    """M⁻¹f of a spring and damper, and the power of what is no potential energy.

    Blocks: r, p, A, v, ω′ and the diagonal of M⁻¹ of body i, those of body j, then the two ends,
    stiffness, damping and free length; of a law of its own unit and free length, then value and
    unit of each name that it may depend on beside elongation and rate.

    Parameters
    ----------
    columns_i, columns_j : tuple of int
        Columns of each body that are coordinates: none of the ground.
    law : str
        Tension as a formula, empty where linear.
    names : tuple of str
        What it may depend on beside elongation and rate.
    works : bool
        Whether its power is wanted.
    """

    columns_i: tuple[int, ...]
    columns_j: tuple[int, ...]
    law: str
    names: tuple[str, ...]
    works: bool
    title: str = "spring and damper"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return what it adds to the acceleration of each coordinate of i and j; its power."""
        r_i, p_i, a_i, v_i, omega_i, weights_i = blocks[:6]
        r_j, p_j, a_j, v_j, omega_j, weights_j = blocks[6:12]
        share(trace, p_i, a_i)
        share(trace, p_j, a_j)
        places = {"r_i": r_i, "p_i": p_i, "r_j": r_j, "p_j": p_j}
        places |= dict(zip(ENDS, blocks[12:14], strict=True))
        motion = {"v_i": v_i, "omega_i_b": omega_i, "v_j": v_j, "omega_j_b": omega_j}
        found = _inline(trace, "length", places | motion)
        if self.law:
            tension = damped = self._tension(trace, found, *blocks[14:])
        else:
            law = dict(zip(LAW, blocks[14:], strict=True))
            tension = _inline(trace, "law", found | law)["T"]
            damped = law["damping"] @ found["l_dot"]
        force = _inline(trace, "force", places | {"T": tension})["force"].flat
        added = (
            _accelerations(trace, force[:COLUMNS], self.columns_i, weights_i),
            _accelerations(trace, force[COLUMNS:], self.columns_j, weights_j),
        )
        if not self.works:
            return added
        return *added, -(damped @ found["l_dot"])

    def _tension(self, trace: Trace, found: dict[str, Matrix], *given: Matrix) -> Matrix:
        """Return the tension [N] by the formula."""
        unit, free, *rest = given
        elongation = found["l"] - free
        own = [elongation, unit, found["l_dot"], unit, *rest]
        value = formula_node(trace, self.law, (*ELONGATION, *self.names), own)
        return unit @ _number(trace, value)


@dataclass(frozen=True, slots=True)
class Stretch:
    """Length of a spring and its rate. Blocks: r, p, v and ω′ of both bodies, then the two ends."""

    title: str = "length of a spring"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return l and its derivative by time."""
        ends = (f"{name}_{body}" for body in "ij" for name in ("r", "p", "v", "omega"))
        names = (name + "_b" if "omega" in name else name for name in (*ends, *ENDS))
        found = _inline(trace, "length", dict(zip(names, blocks, strict=True)))
        return found["l"], found["l_dot"]


@dataclass(frozen=True, slots=True)
class Stored:
    """Potential energy of a force that has one. Blocks: r and p of both bodies, the constants.

    Parameters
    ----------
    kind : str
        ``force`` or ``spring_damper``.
    """

    kind: str

    @property
    def title(self) -> str:
        """Name the kind."""
        return f"energy of {self.kind}"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Return (0, V): V = ½ k (l − l⁰)² of a spring, −F·(r + A s′) of a force."""
        graph = trace.graph
        zero = graph.const(0)
        if self.kind == SPRING:
            places = dict(zip(("r_i", "p_i", "r_j", "p_j", *ENDS), blocks[:6], strict=True))
            still = Matrix(graph, ((zero,),) * 3, 1)
            motion = dict.fromkeys(("v_i", "omega_i_b", "v_j", "omega_j_b"), still)
            found = _inline(trace, "length", places | motion)
            law = dict(zip(LAW, blocks[6:], strict=True))
            (energy,) = _inline(trace, "law", found | law)["V"].flat
        else:
            _, _, r, p, point, force = blocks
            inputs = {"r": r.flat, "p": p.flat, "s_b": point.flat}
            place = trace.inline(frozen("rotation", "point"), inputs)["r_P"]
            work = graph.sum(graph.mul(a, b) for a, b in zip(force.flat, place, strict=True))
            energy = graph.neg(work)
        return (Matrix(graph, ((zero,), (energy,)), 1),)


def _inline(trace: Trace, kernel: str, inputs: dict[str, Matrix]) -> dict[str, Matrix]:
    """Rebuild a kernel of the spring; return its outputs as columns."""
    nodes = {name: block.flat for name, block in inputs.items()}
    found = trace.inline(frozen(SPRING, kernel), nodes)
    return {
        name: Matrix(trace.graph, tuple((node,) for node in flat), 1)
        for name, flat in found.items()
    }


def _number(trace: Trace, node: int) -> Matrix:
    return Matrix(trace.graph, ((node,),), 1)


def _at_point(trace: Trace, p: Sequence[int], point: Matrix, force: Matrix) -> tuple[int, ...]:
    """Return the force in frame O and its torque in the body frame."""
    rest = (trace.graph.const(0),) * 6
    inputs = {"p": p, "s_b": (*point.flat, *rest), "f": (*force.flat, *rest)}
    found = trace.inline(frozen("mass_points", "resultant"), inputs)
    return (*found["F"], *found["N_b"])


def _accelerations(
    trace: Trace, forces: Sequence[int], columns: Sequence[int], weights: Matrix
) -> Matrix:
    mul = trace.graph.mul
    pairs = zip(columns, weights.flat, strict=True)
    return Matrix(trace.graph, tuple((mul(forces[k], weight),) for k, weight in pairs), 1)
