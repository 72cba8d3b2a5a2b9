"""The equations of a linkage of nodes as it is written: columns are the places of all nodes.

Links keep their lengths by the kernel of the link element. The rotations of the paper are left out
by their own equations: what an input says of a link, and that links are connected rigidly, are
equations of nodes. A linkage has no masses.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kousoku.codegen.linkage.assemble import Role, assemble
from kousoku.codegen.linkage.kernels import link_kernels
from kousoku.model.errors import SolveError
from kousoku.model.numbers.directions import unit_vector
from kousoku.model.operations.arithmetic import FLOAT
from kousoku.model.operations.interpret import evaluate
from kousoku.runtime.integrate.run_arguments import misfit, numbers_of, require_numbers

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    import numpy.typing as npt

    from kousoku.codegen.linkage.assemble import LinkElement
    from kousoku.model.numbers.real import Array
    from kousoku.model.records.planar import Input, Slider
    from kousoku.model.records.scene import Scene

#: Index of the rotation of an element that each of its rows determines.
ROTATION = {1: 2, 2: 5}
#: Indices of x and y of its two nodes.
TRANSLATIONS = [0, 1, 3, 4]


class LinkageRow(NamedTuple):
    """Equation of a linkage at a state.

    Parameters
    ----------
    label, unit : str
        Its name, and the unit of its residual.
    C, nu, gamma : float
        Residual, and the right sides of C_q v = ν and C_q v̇ = γ.
    C_q : (n,) array
        Its Jacobian.
    """

    label: str
    unit: str
    C: float
    nu: float
    gamma: float
    C_q: Array


class LinkageEquations:
    """The equations of a linkage.

    Parameters
    ----------
    scene : Scene
        A checked linkage of nodes.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.assembly = assemble(scene)
        self.columns = tuple(f"{node}.{axis}" for node in scene.nodes for axis in "xy")
        self._first = {node: 2 * k for k, node in enumerate(scene.nodes)}

    def at(self, t: float, q: npt.ArrayLike, v: npt.ArrayLike) -> list[LinkageRow]:
        """Equations at a state: those of fixed nodes, sliders, links, rotations.

        Raises
        ------
        SolveError
            A number is not possible.
        """
        name, size = self.scene.name, len(self.columns)
        require_numbers(name, time=t)
        state = []
        for symbol, values in (("q", q), ("v", v)):
            array = numbers_of(name, symbol, values)
            if wrong := misfit(symbol, array, size, "x and y of each node"):
                raise SolveError(f"{name}: {wrong}")
            state.append(array)
        laws = {key: _law(record, float(t)) for key, record in self.scene.inputs.items()}
        try:
            return [
                *self._fixed_rows(state[0]),
                *self._slider_rows(state[0], laws),
                *self._link_rows(state[0], state[1], laws),
            ]
        except ZeroDivisionError:
            raise SolveError(f"{name}: the two nodes of a link coincide at this state") from None

    def _fixed_rows(self, q: Array) -> Iterator[LinkageRow]:
        for name, node in self.scene.nodes.items():
            for k, axis in enumerate("xy") if node.fixed else ():
                column = self._first[name] + k
                jacobian = np.eye(len(q))[column]
                yield LinkageRow(
                    f"{name}: fixed {axis}", self.scene.unit, q[column] - node.at[k], 0, 0, jacobian
                )

    def _slider_rows(self, q: Array, laws: Mapping[str, Sequence[float]]) -> Iterator[LinkageRow]:
        """Equations of sliders: they stay on their lines, and are where inputs put them."""
        for name, slider in self.scene.sliders.items():
            along = self._direction(slider)
            across = np.array([-along[1], along[0]])
            yield self._along(f"{name}: across", slider, across, q, (0.0, 0.0, 0.0))
            for key, record in self.scene.inputs.items():
                if record.slider == name:
                    yield self._along(f"{key}: {name}", slider, along, q, laws[key])

    @staticmethod
    def _direction(slider: Slider) -> Array:
        x, y = map(Fraction, slider.direction)
        return np.array([float(component) for component in unit_vector(x, y)])

    def _along(
        self, label: str, slider: Slider, along: Array, q: Array, law: Sequence[float]
    ) -> LinkageRow:
        """Equation of a node whose distance along a direction, from its line's origin, is given."""
        first, jacobian = self._first[slider.node], np.zeros(len(q))
        jacobian[first : first + 2] = along
        distance = along @ (q[first : first + 2] - np.array(slider.through, float))
        return LinkageRow(
            label, self.scene.unit, float(distance) - law[0], law[1], law[2], jacobian
        )

    def _link_rows(
        self, q: Array, v: Array, laws: Mapping[str, Sequence[float]]
    ) -> Iterator[LinkageRow]:
        """Equations of links: they keep their lengths, and prescribed angles."""
        angles: dict[int, list[LinkageRow]] = {}
        for element in self.assembly.elements:
            for row in element.rows:
                equation = self._row(element, row, q, v)
                if row:
                    angles.setdefault(element.ends[ROTATION[row]].coordinate, []).append(equation)
                else:
                    yield equation
        for coordinate, (first, *others) in angles.items():
            record = self.assembly.coordinates[coordinate]
            if record.role is Role.INPUT:
                law = laws[record.name]
                for other in (first, *others):
                    yield other._replace(
                        label=f"{record.name}: {other.label}",
                        C=math.remainder(other.C + law[0], math.tau),
                        nu=other.nu - law[1],
                        gamma=other.gamma - law[2],
                    )
                continue
            for other in others:
                yield other._replace(
                    label=f"{first.label} and {other.label}: rigid",
                    C=math.remainder(other.C - first.C, math.tau),
                    nu=other.nu - first.nu,
                    gamma=other.gamma - first.gamma,
                    C_q=other.C_q - first.C_q,
                )

    def _row(self, element: LinkElement, row: int, q: Array, v: Array) -> LinkageRow:
        """ε1, or ε2 or ε3 per radian of its rotation, with that rotation at zero."""
        columns = [self._first[node] + k for node in element.nodes for k in (0, 1)]
        x, x_dot = [0.0] * 6, [0.0] * 6
        for slot, column in zip(TRANSLATIONS, columns, strict=True):
            x[slot], x_dot[slot] = float(q[column]), float(v[column])
        for slot in ROTATION.values():
            x[slot] = float(element.ends[slot].offset)
        inputs = {"x": x, "length": [float(element.length)], "offset": [0.0, 0.0]}
        shape = evaluate(link_kernels()["deformation"], inputs, FLOAT)
        rate = evaluate(link_kernels()["rate"], inputs | {"x_dot": x_dot}, FLOAT)
        derivatives = shape["D"][6 * row : 6 * row + 6]
        factor = 1 / derivatives[ROTATION[row]] if row else 1.0
        jacobian = np.zeros(len(q))
        for slot, column in zip(TRANSLATIONS, columns, strict=True):
            jacobian[column] += factor * derivatives[slot]
        return LinkageRow(
            f"{element.name} at {element.nodes[row - 1]}" if row else f"{element.name}: length",
            "rad" if row else self.scene.unit,
            factor * shape["epsilon"][row],
            0.0,
            -factor * rate["D_dot_x_dot"][row],
            jacobian,
        )


def _law(record: Input, t: float) -> tuple[float, float, float]:
    """Value that an input prescribes, and its first and second derivatives."""
    start, rate, second = map(float, (record.start, record.rate, record.acceleration))
    return start + rate * t + second / 2 * t * t, rate + second * t, second
