"""The rows of a whole system, evaluated from the frozen kernels without composing a program.

It serves assembly and the count of freedoms, once, before there is a solver. A row that combines
coordinates is a sum over them, each evaluated as a row of its own kind; formulas of the time are
taken at t = 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from itertools import accumulate
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.codegen.dynamics.assembly.driver_laws import law_at_start
from kousoku.codegen.dynamics.assembly.jacobian import PreciseJacobian
from kousoku.codegen.dynamics.operations.mechanics import COLUMNS, frozen
from kousoku.codegen.passes.rebuild import with_outputs
from kousoku.model.mechanics.multibody import RelativeCoordinate
from kousoku.model.numbers import precise
from kousoku.model.numbers.digits import CONTEXT, HIGH
from kousoku.model.operations.interpret import ARRAY, evaluate

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

    from kousoku.codegen.dynamics.assembly.jacobian import Indices
    from kousoku.codegen.dynamics.assembly.pose import Pose
    from kousoku.model.mechanics.multibody import Instance, MovingBody, System
    from kousoku.model.numbers.precise import High
    from kousoku.model.numbers.real import Array
    from kousoku.model.operations.kernel import Kernel

PAIR_COLUMNS = 2 * COLUMNS


@dataclass(frozen=True, slots=True)
class _Piece:
    """Rows of one kernel: a whole instance, or one term of a combination.

    Parameters
    ----------
    source : Instance or RelativeCoordinate
        Kind, bodies and constants.
    first : int
        Its first row.
    factor : float
        Factor of its residual.
    coordinate : int
        Index of the coordinate, −1 of an instance.
    """

    source: Instance | RelativeCoordinate
    first: int
    factor: float = 1.0
    coordinate: int = -1


class Residuals:
    """The rows C (m,) [m or rad] of some constraints between the bodies of a system.

    δC = C_q (δr, δθ′): C_q (m, 6 bodies) has columns δr [m] in frame O, δθ′ [rad] in the principal
    frame; each kind has its equation of lecture 8.2.

    Parameters
    ----------
    constraints : sequence of Instance
        In the order of their rows.
    bodies : sequence of MovingBody
        All bodies of the system.
    coordinates : sequence of RelativeCoordinate
        Coordinates that the terms of combinations refer to.
    parameters : sequence of (str, float)
        Names that formulas may use, and their values.
    left_out : collection of (int, int)
        Rows that are set to zero, as others imply them: indices of a constraint and of its row.
    """

    def __init__(
        self,
        constraints: Sequence[Instance],
        bodies: Sequence[MovingBody],
        coordinates: Sequence[RelativeCoordinate] = (),
        parameters: Sequence[tuple[str, float]] = (),
        *,
        left_out: Collection[tuple[int, int]] = (),
    ) -> None:
        self.constraints = tuple(constraints)
        self.coordinates = tuple(coordinates)
        self.columns = COLUMNS * len(bodies)
        self._is_point = [body.is_point for body in bodies]
        sizes = [_size(instance) for instance in constraints]
        #: The first row of each instance, and the count of rows at the end.
        self.first = [0, *accumulate(sizes)]
        self.rows = self.first[-1]
        self.left_out = tuple(left_out)
        self.is_left_out = np.zeros(self.rows, bool)
        self.is_left_out[[self.first[index] + row for index, row in left_out]] = True
        #: Mask of the rows that are lengths; the others are angles, or sines of them.
        self.in_metres = np.repeat([unit_of(instance) == "m" for instance in constraints], sizes)
        #: Coordinates that angles are counted from, to within half a turn.
        self.near = np.array([coordinate.near for coordinate in coordinates])
        self._pieces = list(self._pieces_of_rows())
        self._set_offsets(parameters)
        self._stacks = [self._stacked(pieces) for pieces in _by_kind(self._pieces)]

    @classmethod
    def of(
        cls,
        system: System,
        constraints: Sequence[Instance],
        left_out: Collection[tuple[int, int]] = (),
    ) -> Residuals:
        """Rows of constraints between the bodies of a system, some left out."""
        of_system = (system.bodies, system.coordinates, system.parameters)
        return cls(constraints, *of_system, left_out=left_out)

    def count(self, instance: Instance) -> int:
        """Number of rows of an instance."""
        return _size(instance)

    def ratios(self, length: float) -> Array:
        """Largest factor of each row that combines coordinates, in a length and radians; else 1.

        Ratios may be of any size: beside a gear of 10,000 a row of its slow shaft is negligible.
        """
        ratios = np.ones(self.rows)
        for instance, first in zip(self.constraints, self.first, strict=False):
            if instance.is_combination and len(instance.terms) > 1:
                unit = length if self.in_metres[first] else 1.0
                ratios[first] = max(
                    abs(term.factor)
                    * (length if unit_of(self.coordinates[term.coordinate]) == "m" else 1.0)
                    / unit
                    for term in instance.terms
                )
        return ratios

    def _pieces_of_rows(self) -> Iterator[_Piece]:
        for instance, first in zip(self.constraints, self.first, strict=False):
            if not instance.is_combination:
                yield _Piece(instance, first)
            for term in instance.terms:
                source = self.coordinates[term.coordinate]
                yield _Piece(source, first, term.factor, term.coordinate)

    def _set_offsets(self, parameters: Sequence[tuple[str, float]]) -> None:
        """Set the terms of rows that do not depend on positions, at t = 0, and the rates ν."""
        zero = precise.ZERO[0]
        self._offsets = [zero] * self.rows
        #: Sums of the sizes of all terms of combinations, row by row.
        self.sizes = np.zeros(self.rows)
        #: ν at t = 0 in 50 digits, row by row.
        self.nu = [zero] * self.rows
        for instance, first in zip(self.constraints, self.first, strict=False):
            if instance.is_combination:
                law = law_at_start(instance, parameters)
                self._offsets[first] = precise.number(instance.offset) - law.value
                self.sizes[first] = abs(instance.offset) + abs(float(law.value))
                self.nu[first] = zero if self.is_left_out[first] else law.rate
        self._offsets_in_doubles = np.array([float(x) for x in self._offsets])
        for piece in self._pieces:
            if piece.coordinate >= 0:
                self.sizes[piece.first] += abs(piece.factor * self.near[piece.coordinate])

    def at(self, pose: Pose) -> tuple[list[High], PreciseJacobian]:
        """C and C_q in 50 digits; angles are counted from those of the pose."""
        values = list(self._offsets)
        elements: list[tuple[int, int, High]] = []
        for piece in self._pieces:
            factor = precise.number(piece.factor)
            kernel = frozen(piece.source.kind, "constraint")
            result = evaluate(kernel, inputs_at(piece.source, pose), HIGH)
            for row, value in enumerate(result["C"], piece.first):
                values[row] += factor * self._counted(value, piece.coordinate, pose.near)
            for index, value in enumerate(result["C_q"]):
                row, column = divmod(index, PAIR_COLUMNS)
                column = self._column(piece.source, column)
                if value and column >= 0 and not self.is_left_out[piece.first + row]:
                    elements.append((piece.first + row, column, factor * value))
        for row in np.flatnonzero(self.is_left_out).tolist():
            values[row] = precise.ZERO[0]
        return values, PreciseJacobian(elements, (self.rows, self.columns))

    def counted(self, pose: Pose) -> Pose:
        """Pose with its present angles, their turns counted on from the previous ones."""
        near = list(pose.near)
        for index, coordinate in enumerate(self.coordinates):
            if coordinate.counts_turns:
                kernel = frozen(coordinate.kind, "constraint")
                (value,) = evaluate(kernel, inputs_at(coordinate, pose), HIGH)["C"]
                near[index] = self._counted(value, index, pose.near)
        return replace(pose, near=tuple(near))

    def _counted(self, value: High, coordinate: int, near: Sequence[High]) -> High:
        """Angle with the turns that bring it next to the one of its coordinate."""
        if coordinate < 0 or not self.coordinates[coordinate].counts_turns:
            return value
        turn = 2 * CONTEXT.pi
        turns: High = turn * CONTEXT.nint((near[coordinate] - value) / turn)
        return value + turns

    def _column(self, source: Instance | RelativeCoordinate, column: int) -> int:
        """Column of the system for a column of an instance, −1 where there is none."""
        body = source.i if column < COLUMNS else source.j
        component = column % COLUMNS
        has_none = body < 0 or (self._is_point[body] and component >= COLUMNS // 2)
        return -1 if has_none else COLUMNS * body + component

    def at_start(self, bodies: Sequence[MovingBody]) -> tuple[Array, Array]:
        """C and C_q v − ν at the start in doubles, all instances of a kind at once."""
        c, rows, columns, values = self.elements(*positions_of(bodies))
        speed = np.array([*((*body.v, *body.omega_b) for body in bodies), (0.0,) * COLUMNS])
        rates = -np.array([float(x) for x in self.nu])
        np.add.at(rates, rows, values * speed.ravel()[columns])
        return c, rates

    def doubles(self, r: Array, p: Array, near: Array | None = None) -> tuple[Array, Array]:
        """C and C_q, dense, in doubles; arguments as :meth:`elements` takes them."""
        c, rows, columns, values = self.elements(r, p, near)
        matrix = np.zeros((self.rows, self.columns))
        np.add.at(matrix, (rows, columns), values)
        return c, matrix

    def elements(
        self, r: Array, p: Array, near: Array | None = None
    ) -> tuple[Array, Indices, Indices, Array]:
        """Residuals C, and rows, columns and values of the elements of C_q that are not zero.

        Parameters
        ----------
        r, p : (bodies + 1, 3) [m] and (bodies + 1, 4)
            Positions of all bodies, that of the ground last.
        near : (coordinates,), optional
            Coordinates that angles are counted from; those of the start unless given.

        Returns
        -------
        C : (rows,)
            The residuals.
        rows, columns, values : (elements,)
            Duplicates, as of a combination of two coordinates of one body, are summed by callers.
        """
        results = [evaluate(stack.kernel, stack.inputs(r, p), ARRAY) for stack in self._stacks]
        c = self._summed([result["C"] for result in results], near)
        all_rows, all_columns, all_values = [], [], []
        for stack, result in zip(self._stacks, results, strict=True):
            elements = result["C_q"]
            shape = (len(elements), len(stack.first))
            values = stack.factors * np.array([np.broadcast_to(x, shape[1:]) for x in elements])
            index = np.broadcast_to(np.arange(len(elements))[:, np.newaxis], shape)
            rows, columns = stack.first + index // PAIR_COLUMNS, np.resize(stack.columns, shape)
            is_kept = (values != 0) & (columns >= 0) & ~self.is_left_out[rows]
            all_rows.append(rows[is_kept])
            all_columns.append(columns[is_kept])
            all_values.append(values[is_kept])
        if not all_values:
            return c, np.zeros(0, int), np.zeros(0, int), np.zeros(0)
        return c, np.concatenate(all_rows), np.concatenate(all_columns), np.concatenate(all_values)

    def residuals(self, r: Array, p: Array, near: Array | None = None) -> Array:
        """C alone, in doubles; arguments as :meth:`elements` takes them."""
        stacks = ((stack.residual, stack.inputs(r, p)) for stack in self._stacks)
        return self._summed([evaluate(*stack, ARRAY)["C"] for stack in stacks], near)

    def _summed(self, results: Sequence[Sequence[Array]], near: Array | None) -> Array:
        """C from the outputs of the kernels of all stacks."""
        c = self._offsets_in_doubles.copy()
        for stack, result in zip(self._stacks, results, strict=True):
            for row, value in enumerate(result):
                counted = stack.counted(value, self.near if near is None else near)
                np.add.at(c, stack.first + row, stack.factors * counted)
        c[self.is_left_out] = 0.0
        return c

    def angles(self, r: Array, p: Array, near: Array) -> Array:
        """Coordinates that count turns, counted on from the values that they had."""
        angles = near.copy()
        for stack in self._stacks:
            if stack.is_angle:
                (value,) = evaluate(stack.residual, stack.inputs(r, p), ARRAY)["C"]
                angles[stack.coordinates] = stack.counted(value, near)
        return angles

    def _stacked(self, pieces: Sequence[_Piece]) -> _Stack:
        sources = [piece.source for piece in pieces]
        constants = [dict(source.constants) for source in sources]
        return _Stack(
            kernel=frozen(sources[0].kind, "constraint"),
            residual=_residual_of(sources[0].kind),
            is_angle=isinstance(sources[0], RelativeCoordinate) and sources[0].counts_turns,
            constants={name: np.array([c[name] for c in constants]).T for name in constants[0]},
            bodies={end: np.array([getattr(source, end) for source in sources]) for end in "ij"},
            first=np.array([piece.first for piece in pieces]),
            factors=np.array([piece.factor for piece in pieces]),
            coordinates=np.array([piece.coordinate for piece in pieces]),
            columns=np.array(
                [[self._column(source, k) for source in sources] for k in range(PAIR_COLUMNS)]
            ),
        )


def positions_of(bodies: Sequence[MovingBody]) -> tuple[Array, Array]:
    """Positions r (n + 1, 3) [m], frame O, and p (n + 1, 4) [-] of n bodies, the ground last."""
    r = np.array([*(body.r for body in bodies), (0.0, 0.0, 0.0)])
    p = np.array([*(body.p for body in bodies), (1.0, 0.0, 0.0, 0.0)])
    return r, p


@dataclass(frozen=True, slots=True)
class _Stack:
    """Pieces of one kind, whose kernel is evaluated once for all of them.

    Parameters
    ----------
    kernel, residual : Kernel
        The kernel of the constraint, and its part that gives C alone.
    is_angle : bool
        Whether it gives angles of coordinates, which count turns.
    constants : dict of str to array
        Constant inputs, each element an array over the pieces.
    bodies : dict of str to array
        Index of body ``i`` and of body ``j``.
    first, factors, coordinates : (pieces,)
        As of a piece.
    columns : (12, pieces)
        Columns in the system, −1 where there is none.
    """

    kernel: Kernel
    residual: Kernel
    is_angle: bool
    constants: Mapping[str, Array]
    bodies: Mapping[str, Indices]
    first: Indices
    factors: Array
    coordinates: Indices
    columns: Indices

    def inputs(self, r: Array, p: Array) -> dict[str, Any]:
        """Inputs of the kernel."""
        inputs: dict[str, Any] = dict(self.constants)
        for end, bodies in self.bodies.items():
            inputs |= {f"r_{end}": r[bodies].T, f"p_{end}": p[bodies].T}
        return inputs

    def counted(self, value: Array, near: Array) -> Array:
        """Angles with the turns that bring them next to those of their coordinates."""
        if not self.is_angle:
            return value
        turns: Array = np.round((near[self.coordinates] - value) / math.tau)
        return value + math.tau * turns


@cache
def _residual_of(kind: str) -> Kernel:
    """Residual of a kind alone: the kernel of C, the first output of its constraint."""
    kernel = frozen(kind, "constraint")
    return with_outputs(kernel, [kernel.outputs[0].name])


def _size(instance: Instance) -> int:
    if instance.is_combination:
        return 1
    return frozen(instance.kind, "constraint").outputs[0].size


def unit_of(source: Instance | RelativeCoordinate) -> str:
    """Unit of the rows of a constraint, or of a coordinate: ``m``, or one that is no length."""
    unit = "" if isinstance(source, RelativeCoordinate) else source.unit
    return unit or frozen(source.kind, "constraint").outputs[0].unit


def remark_on_ratios(constraints: Iterable[Instance], largest: float) -> str:
    """Remark on the first coupling with a larger ratio; empty without.

    Beside it a slow coordinate counts as at rest.
    """
    for c in constraints:
        sizes = [abs(term.factor) for term in c.terms]
        if c.is_combination and sizes and max(sizes) >= largest * min(sizes):
            return (
                f"; joints.{c.joint} has a ratio of {max(sizes) / min(sizes):.3g}: what moves so"
                " slowly counts as at rest, drive what moves fast"
            )
    return ""


def _by_kind(pieces: Sequence[_Piece]) -> list[list[_Piece]]:
    """Pieces of each kind, instances apart from coordinates: angles of joints count no turns."""
    groups: dict[tuple[str, bool], list[_Piece]] = {}
    for piece in pieces:
        groups.setdefault((piece.source.kind, piece.coordinate >= 0), []).append(piece)
    return list(groups.values())


def inputs_at(source: Instance | RelativeCoordinate, pose: Pose) -> dict[str, Sequence[High]]:
    """Inputs of a kernel in 50 digits: constants, and r (3,) [m] and p (4,) of both bodies."""
    inputs: dict[str, Sequence[High]] = {
        name: [precise.number(x) for x in constant] for name, constant in source.constants
    }
    for end, body in (("i", source.i), ("j", source.j)):
        inputs[f"r_{end}"], inputs[f"p_{end}"] = pose.r[body], pose.p[body]
    return inputs
