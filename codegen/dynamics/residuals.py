"""The rows of a whole system, evaluated from the frozen kernels without composing a program.

This is for what happens once, before there is a solver: assembly, and counting freedoms.
"""

from __future__ import annotations

from itertools import accumulate
from typing import TYPE_CHECKING, Any

import numpy as np

from kousoku.codegen.dynamics.operations import COLUMNS, frozen
from kousoku.codegen.interpret import ARRAY, HIGH, evaluate
from kousoku.model import precise

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.codegen.dynamics.pose import Pose
    from kousoku.model.mechanism import Instance, MovingBody
    from kousoku.model.precise import High

    Array = np.ndarray[Any, np.dtype[np.float64]]
    Places = np.ndarray[Any, np.dtype[np.int64]]


class Jacobian:
    """C_q of a system in 50 digits, by its elements that are not zero.

    Parameters
    ----------
    elements : sequence of (int, int, number)
        Row, column (six for each body) and value.
    shape : (int, int)
        Rows and columns.
    """

    def __init__(self, elements: Sequence[tuple[int, int, High]], shape: tuple[int, int]) -> None:
        self._elements = elements
        self._shape = shape

    def dense(self) -> Array:
        """Return the matrix in doubles."""
        matrix = np.zeros(self._shape)
        for row, column, value in self._elements:
            matrix[row, column] = float(value)
        return matrix

    def times(self, v: Sequence[High]) -> list[High]:
        """Return C_q v."""
        product = [precise.ZERO[0]] * self._shape[0]
        for row, column, value in self._elements:
            product[row] += value * v[column]
        return product

    def transposed_times(self, lam: Sequence[High]) -> list[High]:
        """Return C_qᵀ λ."""
        product = [precise.ZERO[0]] * self._shape[1]
        for row, column, value in self._elements:
            product[column] += value * lam[row]
        return product


class Residuals:
    """The rows of some constraints between the bodies of a system.

    Parameters
    ----------
    constraints : sequence of Instance
        In the order of their rows.
    bodies : sequence of MovingBody
        All bodies of the system.
    """

    def __init__(self, constraints: Sequence[Instance], bodies: Sequence[MovingBody]) -> None:
        self.constraints = tuple(constraints)
        self.columns = COLUMNS * len(bodies)
        self._is_point = [body.is_point for body in bodies]
        outputs = [frozen(instance.kind, "constraint").outputs[0] for instance in constraints]
        sizes = [output.size for output in outputs]
        #: The first row of each instance, and the count of rows at the end.
        self.first = [0, *accumulate(sizes)]
        self.rows = self.first[-1]
        #: Which rows are lengths; the others are sines of angles.
        self.in_metres = np.repeat([output.unit == "m" for output in outputs], sizes)

    def at(self, pose: Pose) -> tuple[list[High], Jacobian]:
        """Return C and C_q in 50 digits."""
        values: list[High] = []
        elements: list[tuple[int, int, High]] = []
        for instance, first in zip(self.constraints, self.first, strict=False):
            inputs: dict[str, Sequence[High]] = {
                name: [precise.number(x) for x in constant] for name, constant in instance.constants
            }
            for letter, body in (("i", instance.i), ("j", instance.j)):
                inputs[f"r_{letter}"], inputs[f"p_{letter}"] = pose.r[body], pose.p[body]
            result = evaluate(frozen(instance.kind, "constraint"), inputs, HIGH)
            values += result["C"]
            for place, value in enumerate(result["C_q"]):
                row, column = divmod(place, 2 * COLUMNS)
                column = self._column(instance, column)
                if value and column >= 0:
                    elements.append((first + row, column, value))
        return values, Jacobian(elements, (self.rows, self.columns))

    def _column(self, instance: Instance, column: int) -> int:
        """Return the column of the system for one of an instance, −1 where there is none."""
        body = instance.i if column < COLUMNS else instance.j
        own = column % COLUMNS
        has_none = body < 0 or (self._is_point[body] and own >= COLUMNS // 2)
        return -1 if has_none else COLUMNS * body + own

    def fast(self, bodies: Sequence[MovingBody]) -> tuple[Array, Array]:
        """Return C and C_q v at the start in doubles, all instances of a kind at once."""
        c, rates = np.zeros(self.rows), np.zeros(self.rows)
        still, none = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
        state = {
            "r": np.array([*(body.r for body in bodies), still]),
            "p": np.array([*(body.p for body in bodies), none]),
        }
        speed = np.array([*((*body.v, *body.omega_b) for body in bodies), still + still])
        for kind, places in self._by_kind().items():
            of_kind = [self.constraints[place] for place in places]
            kernel = frozen(kind, "constraint")
            result = evaluate(kernel, _stacked(of_kind, state), ARRAY)
            rows = kernel.outputs[0].size
            jacobian = [np.broadcast_to(x, len(places)) for x in result["C_q"]]
            i, j = (speed[[getattr(of, letter) for of in of_kind]] for letter in "ij")
            v = np.concatenate((i, j), axis=1).T
            first = np.array([self.first[place] for place in places])
            for row in range(rows):
                c[first + row] = result["C"][row]
                width = 2 * COLUMNS
                rates[first + row] = sum(
                    jacobian[row * width + column] * v[column] for column in range(width)
                )
        return c, rates

    def doubles(self, r: Array, p: Array) -> tuple[Array, Array]:
        """Return C and C_q, dense, in doubles; arguments as :meth:`elements` takes them."""
        c, rows, columns, values = self.elements(r, p)
        matrix = np.zeros((self.rows, self.columns))
        matrix[rows, columns] = values
        return c, matrix

    def elements(self, r: Array, p: Array) -> tuple[Array, Places, Places, Array]:
        """Return C, and of the elements of C_q that are not zero rows, columns and values.

        Parameters
        ----------
        r, p : (bodies + 1, 3) [m] and (bodies + 1, 4)
            Positions of all bodies, that of the ground last.
        """
        c = np.zeros(self.rows)
        rows, columns, found = [], [], []
        state = {"r": r, "p": p}
        for kind, places in self._by_kind().items():
            of_kind = [self.constraints[place] for place in places]
            kernel = frozen(kind, "constraint")
            result = evaluate(kernel, _stacked(of_kind, state), ARRAY)
            first = np.array([self.first[place] for place in places])
            for row, value in enumerate(result["C"]):
                c[first + row] = value
            own = np.array([[self._column(one, k) for one in of_kind] for k in range(2 * COLUMNS)])
            for at, value in enumerate(result["C_q"]):
                row, k = divmod(at, 2 * COLUMNS)
                values = np.asarray(value) + np.zeros(len(places))
                there = (values != 0) & (own[k] >= 0)
                rows.append((first + row)[there])
                columns.append(own[k][there])
                found.append(values[there])
        if not found:
            return c, np.zeros(0, int), np.zeros(0, int), np.zeros(0)
        return c, np.concatenate(rows), np.concatenate(columns), np.concatenate(found)

    def _by_kind(self) -> Mapping[str, list[int]]:
        groups: dict[str, list[int]] = {}
        for place, instance in enumerate(self.constraints):
            groups.setdefault(instance.kind, []).append(place)
        return groups


def _stacked(instances: Sequence[Instance], state: Mapping[str, Array]) -> dict[str, Any]:
    """Return the inputs of a kernel, each element an array over the instances."""
    names = [name for name, _ in instances[0].constants]
    constants = [dict(instance.constants) for instance in instances]
    inputs: dict[str, Any] = {
        name: np.array([constant[name] for constant in constants]).T for name in names
    }
    for letter in "ij":
        bodies = [getattr(instance, letter) for instance in instances]
        for name, values in state.items():
            inputs[f"{name}_{letter}"] = values[bodies].T
    return inputs
