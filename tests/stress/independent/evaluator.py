"""An evaluator of scenes of bodies that shares nothing with kousoku but what its documents say.

It reads the tree of a scene file, and returns at a state all that the equations of motion have:
dense, about the origins of the body frames, each joint by vectors of its own choice, derivatives by
truncated polynomials, and accelerations by singular values, in doubles or in mpmath's digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from tests.stress.independent.forces import Forces, Load, Place
from tests.stress.independent.formulas import Reader
from tests.stress.independent.joints import ANGLE, LEAVES, SECOND, Joints
from tests.stress.independent.numbers import (
    Jet,
    array,
    back,
    cross,
    dot,
    hamilton,
    minus,
    rotation,
    times,
    turned,
    value_of,
)
from tests.stress.independent.solids import GROUND, Pose, mass_of
from tests.stress.independent.solving import solve

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from tests.stress.independent.numbers import Number, Vector
    from tests.stress.independent.solving import Solution

    Tree = dict[str, Any]
    Array = Any
    State = Mapping[str, tuple[Vector, Vector, Vector, Vector]]
    Turns = Mapping[tuple[str, str], Number]

RANK_TOLERANCE = 1e-7
"""Singular values of scaled rows that are smaller belong to rows that depend on others."""


@dataclass(frozen=True)
class Evaluation:
    """The equations of a scene at a state.

    Parameters
    ----------
    columns : dict of str to slice
        Where δr and δθ′ of each body stand.
    owners : list of str
        Joint, coupling or driver of each row.
    C, C_q, nu, gamma : array
        Rows in the unit of the scene or in rad: Ċ = C_q v − ν, C̈ = C_q v̇ − γ.
    M, f : array
        About the origins of the body frames; ``None`` where a body has no mass.
    v : (n,) array
        Velocities.
    kinetic, potential : number
        Energies, in kg (unit/s)².
    powers : dict of str to number
        Of forces without a potential.
    coordinates : dict of str to Jet
        The named ones, with their turns.
    angles : dict of (str, str) to Jet
        Those of all joints with their turns, by joint and sort.
    events : dict of str to Jet
        Formulas of events, with their derivatives along time, all coordinates, and their rates.
    """

    columns: dict[str, slice]
    owners: list[str]
    C: Array
    C_q: Array
    nu: Array
    gamma: Array
    M: Array | None
    f: Array
    v: Array
    kinetic: Number
    potential: Number
    powers: dict[str, Number]
    coordinates: dict[str, Jet]
    angles: dict[tuple[str, str], Jet]
    events: dict[str, Jet]

    @cached_property
    def solution(self) -> Solution:
        """Accelerations and multipliers."""
        assert self.M is not None
        return solve(self.M, self.C_q, self.gamma, self.f, RANK_TOLERANCE)

    def turns(self, later: float = 0.0) -> dict[tuple[str, str], Number]:
        """Values that angles are near a little later."""
        return {key: u.value + u.first[-2] * later for key, u in self.angles.items()}

    def pushes(self, owner: str) -> tuple[Array, Array]:
        """Forces −C_qᵀ λ of a joint or driver, and what of them the motion leaves open, (n, k)."""
        rows = [k for k, name in enumerate(self.owners) if name == owner]
        slopes = self.C_q[rows]
        return -slopes.T @ self.solution.lam[rows], slopes.T @ self.solution.free[rows]


class Evaluator:
    """A scene of bodies.

    Parameters
    ----------
    tree : dict
        The scene, as tomllib reads it.
    parameters : dict of str to number, optional
        Those that are not as in the scene.
    real : callable
        ``float`` or ``mpmath.mp.mpf``.
    """

    def __init__(
        self,
        tree: Tree,
        parameters: Mapping[str, float] | None = None,
        real: Callable[[Any], Number] = float,
    ) -> None:
        self.tree = tree
        self.read = Reader(real, {**tree.get("parameters", {}), **(parameters or {})})
        self.joints = Joints(tree, self.read)
        self.forces = Forces(self.joints)
        self.bodies: Tree = tree.get("bodies", {})
        self.masses = {name: mass_of(self.read, body) for name, body in self.bodies.items()}
        self.gravity = self.read.vector(tree.get("gravity", [0.0, 0.0, 0.0]))
        self.columns: dict[str, slice] = {}
        for name, body in self.bodies.items():
            first = max((own.stop for own in self.columns.values()), default=0)
            self.columns[name] = slice(first, first + (3 if body.get("point") else 6))
        self.size = max((own.stop for own in self.columns.values()), default=0)

    def state_of(self, q: Vector, v: Vector) -> State:
        """Positions and velocities by body, from lists in the order of the scene.

        Parameters
        ----------
        q : sequence
            Of each body r and Euler parameters; of a point r alone.
        v : sequence
            Of each body ṙ and ω′; of a point ṙ alone.
        """
        found, at = {}, 0
        for name, own in self.columns.items():
            is_point = own.stop - own.start == 3
            place, rates = self.read.vector(q[at : at + 7]), self.read.vector(v[own])
            at += 3 if is_point else 7
            one = [self.read.real(1), *[self.read.real(0)] * 3]
            p = one if is_point else place[3:]
            found[name] = (place[:3], p, rates[:3], [0, 0, 0] if is_point else rates[3:])
        return found

    def _poses(self, state: State) -> dict[str, Pose]:
        """Poses with derivatives: along all columns, along the motion, along time."""
        poses = {"ground": GROUND}
        for name, own in self.columns.items():
            r, p, v, omega = state[name]
            p = times(1 / _length(p), p)
            first = np.full((7, self.size + 2), self.read.real(0))
            second = first.copy()
            half = times(self.read.real(1) / 2, p)
            for k in range(3):
                first[k, own.start + k] = self.read.real(1)
                first[k, -2] = v[k]
                if own.stop - own.start > 3:
                    first[3:, own.start + 3 + k] = hamilton(
                        half, [0, *(int(k == m) for m in range(3))]
                    )
            first[3:, -2] = hamilton(half, [0, *omega])
            # p exp(½ δθ′), so that p₂ = −⅛ |δθ′|² p
            for column in range(self.size + 1):
                change = first[3:, column]
                second[3:, column] = times(-sum(x * x for x in change) / 2, p)
            jets = [Jet(x, a, b) for x, a, b in zip([*r, *p], first, second, strict=True)]
            poses[name] = Pose(jets[:3], rotation(jets[3:]))
        return poses

    def evaluate(self, t: Number, state: State, turns: Turns | None = None) -> Evaluation:
        """Evaluation of all at a state.

        Parameters
        ----------
        t : number [s]
            Time.
        state : mapping
            Of each body r in frame O, Euler parameters, ṙ in frame O, and ω′ in its frame.
        turns : mapping, optional
            What angles are near, by joint and sort: those of a state shortly before.
        """
        near, time = turns or {}, self.read.real(t)
        poses = self._poses(state)
        running = np.full(self.size + 2, self.read.real(0))
        running[-2:] = self.read.real(1)
        clock = Jet(time, running, 0 * running)
        coordinates: dict[str, Any] = {
            name: self.joints.counted(one, poses, near) for name, one in self.joints.named.items()
        }
        names = {"t": time}
        names |= {name: u.value for name, u in coordinates.items()}
        names |= {f"{name}_dot": u.first[-2] for name, u in coordinates.items()}
        rows = [*self.joints.rows(clock, poses, near)]
        jets = [self._jet(row) for _, row in rows]
        place = Place(time, poses, near, self.columns, names)
        load = Load(np.full(self.size, self.read.real(0)))
        M = self._inertia(load, poses, state) if all(self.masses.values()) else None
        if M is not None:
            self.forces.act(load, place)
        v = array([x for name in self.columns for x in self._rates(state, name)])
        return Evaluation(
            self.columns,
            [owner for owner, _ in rows],
            array([jet.value for jet in jets]),
            array([jet.first[: self.size] for jet in jets]).reshape(-1, self.size),
            array([-jet.first[-1] for jet in jets]),
            array([-2 * jet.second[-2] for jet in jets]),
            M,
            load.f,
            v,
            0 if M is None else v @ M @ v / 2,
            load.potential,
            load.powers,
            coordinates,
            {
                key: self.joints.counted({"joint": key[0], "of": key[1]}, poses, near)
                for key in self._angles
            },
            self._events(names),
        )

    def _events(self, names: Mapping[str, Number]) -> dict[str, Jet]:
        """Formulas of events, given what they may name."""
        given = self.tree.get("events", {})
        along = [
            [self.read.real(int(k == m)) for m in range(len(names))] for k in range(len(names))
        ]
        none = array([self.read.real(0)] * len(names))
        jets = {
            name: Jet(x, array(row), none)
            for (name, x), row in zip(names.items(), along, strict=True)
        }
        return {name: self.read.number(one["when"], jets) for name, one in given.items()}

    @cached_property
    def _angles(self) -> list[tuple[str, str]]:
        """All angles of joints."""
        return [
            (name, sort)
            for name in self.joints.ends
            for sort in LEAVES.get(self.joints.type_of(name), ())
            if sort in (ANGLE, SECOND)
        ]

    def _jet(self, row: Number) -> Jet:
        if isinstance(row, Jet):
            return row
        zeros = np.full(self.size + 2, self.read.real(0))
        return Jet(row, zeros, zeros)

    def _rates(self, state: State, name: str) -> Iterator[Number]:
        own = self.columns[name]
        yield from [*state[name][2], *state[name][3]][: own.stop - own.start]

    def _inertia(self, load: Load, poses: Mapping[str, Pose], state: State) -> Array:
        """Mass matrix M about the origins of the body frames; adds weight and velocity forces."""
        M = np.full((self.size, self.size), self.read.real(0))
        for name, own in self.columns.items():
            mass = self.masses[name]
            assert mass is not None
            r, A = (
                (value_of(x) for x in poses[name].r),
                [[value_of(x) for x in row] for row in poses[name].A],
            )
            omega, first = state[name][3], mass.first
            at = own.start
            for k in range(3):
                M[at + k, at + k] = mass.mass
            weight = times(mass.mass, self.gravity)
            load.potential -= dot(weight, [*r]) + dot(self.gravity, turned(A, first))
            if own.stop - own.start == 3:
                load.f[own] += array(weight)
                continue
            for k in range(3):
                axis = [int(k == m) for m in range(3)]
                # A turn about axis k moves the centre of mass by A (axis × c).
                arm = turned(A, cross(axis, first))
                M[at : at + 3, at + 3 + k] = arm
                M[at + 3 + k, at : at + 3] = arm
                M[at + 3 : at + 6, at + 3 + k] = [row[k] for row in mass.tensor]
            swing = turned(A, cross(omega, cross(omega, first)))
            spin = cross(omega, turned(mass.tensor, omega))
            moment = minus(cross(first, back(A, self.gravity)), spin)
            load.f[own] += array([*minus(weight, swing), *moment])
        return M


def _length(p: Vector) -> Number:
    return sum(x * x for x in p) ** 0.5
