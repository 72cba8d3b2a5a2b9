"""The Schur complement S = C_q M⁻¹ C_qᵀ by blocks: assembled, factorised, and solved with."""

from __future__ import annotations

from itertools import accumulate
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.operations.elimination import (
    Backward,
    Couple,
    Eliminate,
    Forward,
    Gather,
    Panel,
    Update,
)
from kousoku.codegen.dynamics.operations.elimination_order import Pivot, minimum_degree
from kousoku.codegen.dynamics.recording.recorder import zeros
from kousoku.model.mechanics.multibody import GROUND_INDEX

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from contextlib import AbstractContextManager

    from kousoku.codegen.dynamics.composition.joints import JointBlocks
    from kousoku.codegen.dynamics.recording.recorder import Recorder, SlotMatrix

    #: A matrix and the vector that it multiplies.
    Product = tuple[SlotMatrix, SlotMatrix]

#: A pivot with more neighbours is eliminated by several tasks.
FUSED = 2
#: How many products one task subtracts: with longer sums in several tasks few kernels serve all.
CHUNK = 4


class Schur:
    """The factors L D Lᵀ of S = C_q M⁻¹ C_qᵀ (m, m), one pivot for each joint.

    Or those of another symmetric matrix.

    Parameters
    ----------
    recorder : Recorder
        The program.
    pivots : SlotMatrix, optional
        The region of D⁻¹.
    at_once : bool
        Whether the order leaves a processor several pivots to work on at once. One after the other
        the last of them shows a loss of rank earlier.
    """

    def __init__(
        self, recorder: Recorder, pivots: SlotMatrix | None = None, *, at_once: bool = True
    ) -> None:
        self.recorder = recorder
        self.pivots = pivots
        self.at_once = at_once
        self.order: tuple[Pivot, ...] = ()
        self._names: list[str] = []
        self._factors: dict[int, tuple[SlotMatrix, SlotMatrix]] = {}
        self._panels: dict[int, dict[int, SlotMatrix]] = {}

    def factorise(self, joints: Sequence[JointBlocks]) -> None:
        """Record assembly and factorisation."""
        self._names = [joint.name for joint in joints]
        self.eliminate(self._assemble(joints), [joint.count for joint in joints])

    def eliminate(
        self, blocks: Mapping[tuple[int, int], SlotMatrix], counts: Sequence[int]
    ) -> None:
        """Record the factorisation of a symmetric matrix, positive definite.

        Parameters
        ----------
        blocks : mapping of (int, int) to SlotMatrix
            Diagonal blocks, and blocks below them that are not zero, the later row first.
        counts : sequence of int
            Rows of each block row.
        """
        pairs = [pair for pair in blocks if pair[0] != pair[1]]
        self.order = minimum_degree(len(counts), pairs, at_once=self.at_once)
        position = {pivot.joint: k for k, pivot in enumerate(self.order)}
        remaining = {}
        for (a, b), block in blocks.items():
            is_transposed = position[a] < position[b]
            remaining[(b, a) if is_transposed else (a, b)] = block.T if is_transposed else block
        first = [0, *accumulate(counts)]
        for pivot in self.order:
            for m, a in enumerate(pivot.neighbours):
                for b in pivot.neighbours[:m]:
                    remaining.setdefault((a, b), zeros(counts[a], counts[b]))
            eliminate = self._fused if len(pivot.neighbours) <= FUSED else self._split
            joint = pivot.joint
            target = self.pivots.part(first[joint], counts[joint]) if self.pivots else None
            with self._of_joint(joint):
                eliminate(pivot, remaining, target)

    def _of_joint(self, joint: int) -> AbstractContextManager[None]:
        """Name the joint that tasks belong to, where pivots are joints."""
        return self.recorder.of(self._names[joint] if self._names else "")

    def _assemble(self, joints: Sequence[JointBlocks]) -> dict[tuple[int, int], SlotMatrix]:
        """Blocks of pairs of joints, the later joint first."""
        blocks = {(k, k): joint.diagonal for k, joint in enumerate(joints)}
        by_body: dict[int, list[int]] = {}
        for k, joint in enumerate(joints):
            for body in joint.bodies:
                if body == GROUND_INDEX or not joint.scaled[body].width:
                    continue
                for other in by_body.setdefault(body, []):
                    block = blocks.get((k, other), zeros(joint.count, joints[other].count))
                    scaled, jacobian = joint.scaled[body], joints[other].jacobian[body]
                    with self.recorder.of(joint.name):
                        (blocks[k, other],) = self.recorder.call(Couple(), block, scaled, jacobian)
                by_body[body].append(k)
        return blocks

    def _fused(
        self, pivot: Pivot, blocks: dict[tuple[int, int], SlotMatrix], target: SlotMatrix | None
    ) -> None:
        neighbours = pivot.neighbours
        pairs = [(a, b) for m, a in enumerate(neighbours) for b in neighbours[: m + 1]]
        lower, inverse, *updated = self.recorder.call(
            Eliminate(len(neighbours)),
            blocks[pivot.joint, pivot.joint],
            *(blocks[a, pivot.joint] for a in neighbours),
            *(blocks[pair] for pair in pairs),
            into=(None, target),
        )
        self._factors[pivot.joint] = (lower, inverse)
        self._panels[pivot.joint] = dict(zip(neighbours, updated, strict=False))
        blocks.update(zip(pairs, updated[len(neighbours) :], strict=True))

    def _split(
        self, pivot: Pivot, blocks: dict[tuple[int, int], SlotMatrix], target: SlotMatrix | None
    ) -> None:
        call, neighbours = self.recorder.call, pivot.neighbours
        lower, inverse = call(Eliminate(0), blocks[pivot.joint, pivot.joint], into=(None, target))
        panels = {a: call(Panel(), lower, inverse, blocks[a, pivot.joint]) for a in neighbours}
        for m, a in enumerate(neighbours):
            for b in neighbours[: m + 1]:
                operation = Update(is_diagonal=a == b)
                (blocks[a, b],) = call(operation, blocks[a, b], panels[a][0], panels[b][1])
        self._factors[pivot.joint] = (lower, inverse)
        self._panels[pivot.joint] = {a: x for a, (_, x) in panels.items()}

    def solve(
        self, right: Sequence[SlotMatrix], into: Sequence[SlotMatrix] | None = None
    ) -> list[SlotMatrix]:
        """Solution λ of S λ = right (n,), joint by joint, recorded; ``into`` has its slots."""
        products: list[list[Product]] = [[] for _ in right]
        scaled: dict[int, SlotMatrix] = {}
        for pivot in self.order:
            k = pivot.joint
            with self._of_joint(k):
                total, rest = self._subtract_chunks(right[k], products[k])
                z, scaled[k] = self.recorder.call(
                    Forward(), *self._factors[k], total, *(x for pair in rest for x in pair)
                )
            for a, panel in self._panels[k].items():
                products[a].append((panel, z))
        solution: dict[int, SlotMatrix] = {}
        for pivot in reversed(self.order):
            k = pivot.joint
            products[k] = [(panel.T, solution[a]) for a, panel in self._panels[k].items()]
            with self._of_joint(k):
                total, rest = self._subtract_chunks(scaled[k], products[k])
                (solution[k],) = self.recorder.call(
                    Backward(),
                    self._factors[k][0],
                    total,
                    *(x for pair in rest for x in pair),
                    into=(into[k] if into else None,),
                )
        return [solution[k] for k in range(len(right))]

    def gather(
        self, total: SlotMatrix, products: Sequence[Product], into: SlotMatrix | None = None
    ) -> SlotMatrix:
        """Difference total − Σ products (n,), recorded; ``into`` has its slots."""
        total, rest = self._subtract_chunks(total, products)
        call = self.recorder.call
        return call(Gather(), total, *(x for pair in rest for x in pair), into=(into,))[0]

    def _subtract_chunks(
        self, total: SlotMatrix, products: Sequence[Product]
    ) -> tuple[SlotMatrix, Sequence[Product]]:
        """Subtract products until few enough are left for one task."""
        while len(products) > CHUNK:
            chunk, products = products[:CHUNK], products[CHUNK:]
            (total,) = self.recorder.call(Gather(), total, *(x for pair in chunk for x in pair))
        return total, products
