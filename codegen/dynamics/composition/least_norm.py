"""Multipliers of rows that depend on others: those with the least forces and torques at the joints.

With C_d = X C_K, K being the rows that are kept, all multipliers

    λ_K = λ − Xᵀ μ,  λ_d = μ,  Xᵀ = S⁻¹ C_K M⁻¹ C_dᵀ,  S = C_K M⁻¹ C_Kᵀ,

move all bodies in the same way, λ being those that the accelerations were computed with. At its
point each joint then has w − B μ, its force and its torque divided by ℓ. The sum of squares is
least where (Σ BᵀB) μ = Σ Bᵀw.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from itertools import chain, pairwise
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.composition.schur import Schur
from kousoku.codegen.dynamics.disjoint_sets import DisjointSets
from kousoku.codegen.dynamics.operations.elimination import Couple, Gather
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS
from kousoku.codegen.dynamics.recording.matrix import Matrix
from kousoku.codegen.dynamics.recording.recorder import SlotMatrix, column, zeros
from kousoku.model.errors import SceneError
from kousoku.model.mechanics.multibody import GROUND_INDEX
from kousoku.runtime.messages import MOST_NAMES_SHOWN

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from kousoku.codegen.dynamics.composition.joints import JointBlocks
    from kousoku.codegen.dynamics.composition.reactions import Reaction
    from kousoku.codegen.dynamics.recording.recorder import Recorder
    from kousoku.codegen.dynamics.recording.traces import Trace
    from kousoku.codegen.dynamics.simplification.body_blocks import BodyBlocks
    from kousoku.model.records.orientation import Vector

ORIGIN = (0.0, 0.0, 0.0)
#: Rows of a set that are shared out at most: the cost grows with their cube.
MOST_SHARED_ROWS = 60
#: Weight of the multipliers of idle rows beside forces: their squares select among multipliers that
#: give the same forces, and change the least forces by 10⁻¹² of them.
IDLE_WEIGHT = Fraction(1, 2**20)
#: Components of force and torque that a joint in the xy-plane has.
IN_PLANE = (0, 1, 5)


@dataclass(frozen=True, slots=True)
class Shared:
    """Joints among which forces are shared out.

    Parameters
    ----------
    groups : sequence of sequence of str, optional
        The joints of each set of rows that depend on each other; unless given, all joints are one.
    idle : mapping of int to sequence of int
        Rows that no motion changes, or that others of their joint imply, by the indices of their
        constraints: they carry nothing.
    """

    groups: Sequence[Sequence[str]] | None = None
    idle: Mapping[int, Sequence[int]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Scale:
    """Weights of forces and torques against each other: Σ |F|² + |N|²/ℓ² is least, frame O.

    Parameters
    ----------
    points : mapping of str to (3,) tuple [m]
        The point of each joint that has one, as
        :func:`~kousoku.codegen.dynamics.operations.joint_ends.points_of` returns them.
    length : float [m]
        ℓ.
    shared : Shared
        Joints among which they are shared out.
    """

    points: Mapping[str, Vector]
    length: float
    shared: Shared = Shared()


def merged(groups: Iterable[Sequence[str]]) -> list[frozenset[str]]:
    """Groups of joints such that no joint is in two of them, in the order of the first."""
    groups = list(groups)
    names = list(dict.fromkeys(chain.from_iterable(groups)))
    index = {name: k for k, name in enumerate(names)}
    sets = DisjointSets(index.values())
    for group in groups:
        for a, b in pairwise(group):
            sets.join(index[a], index[b])
    return [frozenset(names[k] for k in members) for members in sets.sets()]


@dataclass(frozen=True, slots=True)
class MultiplierWrench:
    """Force and torque / ℓ of a joint at its point for each of its multipliers, in frame O.

    F = C_rᵀ and N = A C_θ′ᵀ + (r − r_P) × F [N, N m] for λ = 1. Blocks: C_q (n, c) of the body that
    they act on, its A, and the arm from the joint's point to its centre of mass: r (3,) [m] or
    zero, A and s′ of body j with r − A s′; 1/ℓ.

    Parameters
    ----------
    columns : tuple of int
        The body's coordinates.
    """

    columns: tuple[int, ...]
    title: str = "force and torque"

    def __call__(self, trace: Trace, *blocks: Matrix) -> tuple[Matrix, ...]:
        """Force and torque / ℓ row by row, (n, 6); (n, 3) in the plane."""
        jacobian, orientation, r, orientation_j, s, weight = blocks
        graph = trace.graph
        arm = r - orientation_j @ s
        rows = []
        for row in jacobian.rows:
            full = [graph.const(0)] * 6
            for index, entry in zip(self.columns, row, strict=True):
                full[index] = entry
            force, moment = (Matrix.of(graph, part) for part in (full[:3], full[3:]))
            torque = orientation @ moment + arm.cross(force)
            rows.append((*force.flat, *(torque @ weight).flat))
        wrenches = Matrix(graph, tuple(rows), 6)
        return (wrenches.columns(IN_PLANE) if self.is_in_plane else wrenches,)

    @property
    def is_in_plane(self) -> bool:
        """Whether the body stays in the xy-plane."""
        return 2 not in self.columns


class LeastNorm:
    """The multipliers of joints whose rows depend on each other.

    λ_K − Xᵀ μ of the rows that are kept, μ of the others, with (Σ BᵀB) μ = Σ Bᵀw: least Σ |F|² +
    |N|²/ℓ² of forces [N] and torques [N m] (3,) in frame O, at the points of the joints.

    Parameters
    ----------
    recorder : Recorder
        The program.
    schur : Schur
        The factors of the rows that are kept.
    body : callable
        The blocks of a body by its index.
    joints : sequence of JointBlocks
        The rows that are kept, with their Jacobians.
    scale : Scale
        Weights of the squares whose sum is least.
    """

    def __init__(
        self,
        recorder: Recorder,
        schur: Schur,
        body: Callable[[int], BodyBlocks],
        joints: Sequence[JointBlocks],
        scale: Scale,
    ) -> None:
        self.recorder = recorder
        self.schur = schur
        self.body = body
        self.joints = joints
        self.scale = scale

    def share_out(self, reactions: Sequence[Reaction]) -> None:
        """Record the multipliers λ (n,) of the joints of one set."""
        left_out = [joint.left_out for joint in reactions if joint.left_out]
        count = sum(rows.count for rows in left_out)
        if count > MOST_SHARED_ROWS:
            names = ", ".join(f"joints.{joint.name}" for joint in reactions[:MOST_NAMES_SHOWN])
            raise SceneError(
                f"asks for reactions, which are not unique at {names} and others: {count} rows"
                f" depend on each other, and what they carry is shared out for {MOST_SHARED_ROWS}"
                " at most; leave reactions out, or free what is held twice (kousoku"
                " explain lists it)",
                key="outputs",
            )
        dependences = [self._dependence(rows) for rows in left_out]
        terms = [self._shares(joint, left_out, dependences) for joint in reactions]
        terms += self._idle_shares(left_out)
        sum_of = self._sum_of_products
        square = {
            (a, b): sum_of([(shares[a], shares[b]) for shares, _ in terms])
            for a in range(len(left_out))
            for b in range(a + 1)
        }
        right = [sum_of([(shares[a], w) for shares, w in terms]) for a in range(len(left_out))]
        factors = Schur(self.recorder)
        factors.eliminate(square, [rows.count for rows in left_out])
        least = factors.solve(right)
        for joint in reactions:
            if joint.kept:
                ((_, x),) = joint.multipliers
                for xt, mu in zip(dependences, least, strict=True):
                    (x,) = self.recorder.call(Gather(), x, xt[joint.kept.first], mu)
                joint.multipliers = [(joint.kept, x)]
            if joint.left_out:
                index = next(k for k, rows in enumerate(left_out) if rows is joint.left_out)
                joint.multipliers.append((joint.left_out, least[index]))

    def _idle_shares(
        self, left_out: Sequence[JointBlocks]
    ) -> Iterator[tuple[list[SlotMatrix], SlotMatrix]]:
        """Weighted B of the multipliers of idle rows, and w = 0: zero is their least."""
        for k, rows in enumerate(left_out):
            instance_rows = [
                (instance, row)
                for instance, part in zip(rows.instances, rows.parts, strict=True)
                for row in part.rows
            ]
            for index, (instance, row) in enumerate(instance_rows):
                if row in self.scale.shared.idle.get(instance, ()):
                    unit = [IDLE_WEIGHT if n == index else 0 for n in range(rows.count)]
                    shares = [zeros(1, other.count) for other in left_out]
                    shares[k] = self.recorder.constant(unit).T
                    yield shares, zeros(1, 1)

    def _sum_of_products(self, factors: Sequence[tuple[SlotMatrix, SlotMatrix]]) -> SlotMatrix:
        """Sum of products Σ aᵀ b."""
        total = zeros(factors[0][0].width, factors[0][1].width)
        for a, b in factors:
            (total,) = self.recorder.call(Couple(), total, a.T, b.T)
        return total

    def _dependence(self, left_out: JointBlocks) -> dict[int, SlotMatrix]:
        """Matrix Xᵀ of the rows of a joint, in blocks by the first rows of joints that are kept."""
        rights = []
        for joint in self.joints:
            right = zeros(joint.count, left_out.count)
            for body, jacobian in left_out.jacobian.items():
                if body != GROUND_INDEX and body in joint.scaled:
                    (right,) = self.recorder.call(Couple(), right, joint.scaled[body], jacobian)
            rights.append(right)
        columns = [
            self.schur.solve(
                [column(right.T.part(c * right.height, right.height).entries) for right in rights]
            )
            for c in range(left_out.count)
        ]
        return {
            joint.first: SlotMatrix(
                tuple(x for solved in columns for x in solved[k].entries),
                left_out.count,
                joint.count,
            ).T
            for k, joint in enumerate(self.joints)
        }

    def _shares(
        self,
        joint: Reaction,
        left_out: Sequence[JointBlocks],
        dependences: Sequence[Mapping[int, SlotMatrix]],
    ) -> tuple[list[SlotMatrix], SlotMatrix]:
        """B of one joint, in blocks by the joints whose rows are left out, and its w."""
        call = self.recorder.call
        units = {id(rows): self._unit_wrenches(joint, rows) for rows in joint.blocks}
        height = self.height(joint)
        shares = []
        for rows, xt in zip(left_out, dependences, strict=True):
            share = zeros(height, rows.count)
            if rows is joint.left_out:
                share = negative(units[id(rows)].T)
            if joint.kept:
                (share,) = call(Couple(), share, units[id(joint.kept)].T, xt[joint.kept.first].T)
            shares.append(share)
        return shares, self._total_wrench(joint, units)

    def idle_rows(self, joint: Reaction) -> list[tuple[JointBlocks, int, int]]:
        """First and count of the rows of constraints of a joint that have idle ones."""
        idle = []
        for rows in joint.blocks:
            first = 0
            for instance, part in zip(rows.instances, rows.parts, strict=True):
                if instance in self.scale.shared.idle:
                    idle.append((rows, first, len(part.rows)))
                first += len(part.rows)
        return idle

    def multipliers(self, x: SlotMatrix, into: SlotMatrix) -> None:
        """Write the weighted multipliers of rows some of which are idle."""
        weight = self.recorder.constant([IDLE_WEIGHT])
        self.recorder.call(Couple(), zeros(x.height, 1), x, weight, into=(into,))

    def wrench(self, joint: Reaction, into: SlotMatrix) -> None:
        """Write force and torque / ℓ (6,) of a joint at its point, of its multipliers."""
        units = {id(rows): self._unit_wrenches(joint, rows) for rows in joint.blocks}
        self._total_wrench(joint, units, into)

    def height(self, joint: Reaction) -> int:
        """Number of components of force and torque: 6, in the plane 3."""
        wrench = MultiplierWrench(self.body(joint.end).columns)
        return len(IN_PLANE) if wrench.is_in_plane else COLUMNS

    def _total_wrench(
        self, joint: Reaction, units: Mapping[int, SlotMatrix], into: SlotMatrix | None = None
    ) -> SlotMatrix:
        """Force and torque / ℓ of the multipliers, from those of unit multipliers."""
        total = zeros(self.height(joint), 1)
        for k, (rows, x) in enumerate(joint.multipliers, 1):
            target = into if k == len(joint.multipliers) else None
            (total,) = self.recorder.call(Couple(), total, units[id(rows)].T, x.T, into=(target,))
        return total

    def _unit_wrenches(self, joint: Reaction, rows: JointBlocks) -> SlotMatrix:
        """Force and torque / ℓ of unit multipliers of some rows of a joint."""
        end, j = self.body(joint.end), self.body(joint.j)
        start = end.r if joint.j == GROUND_INDEX else zeros(3, 1)
        point = self.recorder.constant(self.scale.points.get(joint.name, ORIGIN))
        weight = self.recorder.constant([1 / Fraction(self.scale.length)])
        blocks = (rows.jacobian[joint.end], end.orientation, start, j.orientation, point, weight)
        (wrenches,) = self.recorder.call(MultiplierWrench(end.columns), *blocks)
        return wrenches


def negative(block: SlotMatrix) -> SlotMatrix:
    """Negative block."""
    return SlotMatrix(tuple(-x for x in block.entries), block.height, block.width)
