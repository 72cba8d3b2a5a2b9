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
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.composition.schur import Schur
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
#: Rows of a set that are shared out at most: what it takes grows with their cube.
MOST_SHARED_ROWS = 60
#: What multipliers of rows that carry nothing count beside forces: their squares tell those apart
#: that give the same forces, and change the least ones by 10⁻¹² of them.
LITTLE = Fraction(1, 2**20)
#: Components of force and torque that a joint in the xy-plane has.
IN_PLANE = (0, 1, 5)


@dataclass(frozen=True, slots=True)
class Shared:
    """Among which joints forces are shared out.

    Parameters
    ----------
    groups : sequence of sequence of str, optional
        The joints of each set of rows that depend on each other; unless given, all joints are one.
    idle : mapping of int to sequence of int
        Rows that nothing changes, or that others of their joint imply, by the places of their
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
        Among which joints.
    """

    points: Mapping[str, Vector]
    length: float
    shared: Shared = Shared()


def merged(groups: Iterable[Sequence[str]]) -> list[frozenset[str]]:
    """Groups of joints such that no joint is in two of them, in the order of the first."""
    found: list[frozenset[str]] = []
    for group in groups:
        total = frozenset(group)
        near = [k for k, one in enumerate(found) if one & total]
        for k in near:
            total |= found[k]
        at = near[0] if near else len(found)
        found = [one for k, one in enumerate(found) if k not in near]
        found.insert(at, total)
    return found


@dataclass(frozen=True, slots=True)
class MultiplierWrench:
    """Force and torque / ℓ of a joint at its point for each of its multipliers, in frame O.

    F = C_rᵀ and N = A C_θ′ᵀ + (r − r_P) × F [N, N m] for λ = 1. Blocks: C_q (n, c) of the body that
    they act on, its A, and the way from the joint's point to its centre of mass: r (3,) [m] or
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
            for place, entry in zip(self.columns, row, strict=True):
                full[place] = entry
            force, own = (Matrix.of(graph, part) for part in (full[:3], full[3:]))
            torque = orientation @ own + arm.cross(force)
            rows.append((*force.flat, *(torque @ weight).flat))
        found = Matrix(graph, tuple(rows), 6)
        return (found.columns(IN_PLANE) if self.is_in_plane else found,)

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
        Where they are recorded.
    schur : Schur
        The factors of the rows that are kept.
    body : callable
        The blocks of a body by its index.
    joints : sequence of JointBlocks
        The rows that are kept, with their Jacobians.
    scale : Scale
        What is least.
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
        left_out = [one.left_out for one in reactions if one.left_out]
        count = sum(rows.count for rows in left_out)
        if count > MOST_SHARED_ROWS:
            names = ", ".join(f"joints.{one.name}" for one in reactions[:MOST_NAMES_SHOWN])
            raise SceneError(
                f"asks for reactions, which are not unique at {names} and others: {count} rows"
                f" depend on each other, and what they carry is shared out for {MOST_SHARED_ROWS}"
                " at most; leave reactions out, or free what is held twice (kousoku"
                " explain lists it)",
                key="outputs",
            )
        ways = [self._ways(rows) for rows in left_out]
        parts = [self._of_joint(one, left_out, ways) for one in reactions]
        parts += self._idle(left_out)
        total = self._products
        square = {
            (a, b): total([(shares[a], shares[b]) for shares, _ in parts])
            for a in range(len(left_out))
            for b in range(a + 1)
        }
        right = [total([(shares[a], w) for shares, w in parts]) for a in range(len(left_out))]
        factors = Schur(self.recorder)
        factors.eliminate(square, [rows.count for rows in left_out])
        least = factors.solve(right)
        for one in reactions:
            if one.kept:
                ((_, x),) = one.multipliers
                for way, mu in zip(ways, least, strict=True):
                    (x,) = self.recorder.call(Gather(), x, way[one.kept.first], mu)
                one.multipliers = [(one.kept, x)]
            if one.left_out:
                place = next(k for k, rows in enumerate(left_out) if rows is one.left_out)
                one.multipliers.append((one.left_out, least[place]))

    def _idle(
        self, left_out: Sequence[JointBlocks]
    ) -> Iterator[tuple[list[SlotMatrix], SlotMatrix]]:
        """B of the multipliers of rows that nothing changes, and w: zero is the least."""
        for k, rows in enumerate(left_out):
            own = [
                (instance, row)
                for instance, part in zip(rows.instances, rows.parts, strict=True)
                for row in part.rows
            ]
            for place, (instance, row) in enumerate(own):
                if row in self.scale.shared.idle.get(instance, ()):
                    unit = [LITTLE if n == place else 0 for n in range(rows.count)]
                    shares = [zeros(1, other.count) for other in left_out]
                    shares[k] = self.recorder.constant(unit).T
                    yield shares, zeros(1, 1)

    def _products(self, pairs: Sequence[tuple[SlotMatrix, SlotMatrix]]) -> SlotMatrix:
        """Sum of products Σ aᵀ b."""
        total = zeros(pairs[0][0].width, pairs[0][1].width)
        for a, b in pairs:
            (total,) = self.recorder.call(Couple(), total, a.T, b.T)
        return total

    def _ways(self, left_out: JointBlocks) -> dict[int, SlotMatrix]:
        """Matrix Xᵀ of the rows of a joint, by joints that are kept: by their first rows."""
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

    def _of_joint(
        self,
        one: Reaction,
        left_out: Sequence[JointBlocks],
        ways: Sequence[Mapping[int, SlotMatrix]],
    ) -> tuple[list[SlotMatrix], SlotMatrix]:
        """B of the rows of each joint that are left out, and w."""
        call = self.recorder.call
        units = {id(rows): self._units(one, rows) for rows in one.parts}
        height = self.height(one)
        shares = []
        for rows, way in zip(left_out, ways, strict=True):
            share = zeros(height, rows.count)
            if rows is one.left_out:
                share = negative(units[id(rows)].T)
            if one.kept:
                (share,) = call(Couple(), share, units[id(one.kept)].T, way[one.kept.first].T)
            shares.append(share)
        return shares, self._sum(one, units)

    def idle_rows(self, one: Reaction) -> list[tuple[JointBlocks, int, int]]:
        """First and count of the rows of constraints of a joint that have idle ones."""
        found = []
        for rows in one.parts:
            first = 0
            for instance, part in zip(rows.instances, rows.parts, strict=True):
                if instance in self.scale.shared.idle:
                    found.append((rows, first, len(part.rows)))
                first += len(part.rows)
        return found

    def multipliers(self, x: SlotMatrix, into: SlotMatrix) -> None:
        """Write a little of the multipliers of rows some of which are idle."""
        little = self.recorder.constant([LITTLE])
        self.recorder.call(Couple(), zeros(x.height, 1), x, little, into=(into,))

    def wrench(self, one: Reaction, into: SlotMatrix) -> None:
        """Write force and torque / ℓ (6,) of a joint at its point, as its multipliers are."""
        self._sum(one, {id(rows): self._units(one, rows) for rows in one.parts}, into)

    def height(self, one: Reaction) -> int:
        """Number of components of force and torque: 6, in the plane 3."""
        return (
            len(IN_PLANE) if MultiplierWrench(self.body(one.end).columns).is_in_plane else COLUMNS
        )

    def _sum(
        self, one: Reaction, units: Mapping[int, SlotMatrix], into: SlotMatrix | None = None
    ) -> SlotMatrix:
        """Force and torque / ℓ from those of each row with the multiplier one."""
        total = zeros(self.height(one), 1)
        for k, (rows, x) in enumerate(one.multipliers, 1):
            target = into if k == len(one.multipliers) else None
            (total,) = self.recorder.call(Couple(), total, units[id(rows)].T, x.T, into=(target,))
        return total

    def _units(self, one: Reaction, rows: JointBlocks) -> SlotMatrix:
        """Force and torque for each multiplier of some rows of a joint."""
        end, j = self.body(one.end), self.body(one.j)
        start = end.r if one.j == GROUND_INDEX else zeros(3, 1)
        point = self.recorder.constant(self.scale.points.get(one.name, ORIGIN))
        weight = self.recorder.constant([1 / Fraction(self.scale.length)])
        blocks = (rows.jacobian[one.end], end.orientation, start, j.orientation, point, weight)
        (found,) = self.recorder.call(MultiplierWrench(end.columns), *blocks)
        return found


def negative(block: SlotMatrix) -> SlotMatrix:
    """Negative block."""
    return SlotMatrix(tuple(-x for x in block.entries), block.height, block.width)
