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

#: Where an element has its rotations, by the row that belongs to each.
ROTATION = {1: 2, 2: 5}
#: Where it has x and y of its nodes.
PLACES = [0, 1, 3, 4]


class LinkageRow(NamedTuple):
    """Equation of a linkage at a state.

    Parameters
    ----------
    label, unit : str
        What it is, and the unit of its residual.
    C, nu, gamma : float
        Residual, and what C_q v and C_q v̇ are.
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
        self._place = {node: 2 * k for k, node in enumerate(scene.nodes)}

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
        for what, given in (("q", q), ("v", v)):
            array = numbers_of(name, what, given)
            if wrong := misfit(what, array, size, "x and y of each node"):
                raise SolveError(f"{name}: {wrong}")
            state.append(array)
        known = {key: _law(given, float(t)) for key, given in self.scene.inputs.items()}
        try:
            return [
                *self._fixed(state[0]),
                *self._sliding(state[0], known),
                *self._of_links(state[0], state[1], known),
            ]
        except ZeroDivisionError:
            raise SolveError(f"{name}: the two nodes of a link coincide at this state") from None

    def _fixed(self, q: Array) -> Iterator[LinkageRow]:
        for name, node in self.scene.nodes.items():
            for k, axis in enumerate("xy") if node.fixed else ():
                place = self._place[name] + k
                jacobian = np.eye(len(q))[place]
                yield LinkageRow(
                    f"{name}: fixed {axis}", self.scene.unit, q[place] - node.at[k], 0, 0, jacobian
                )

    def _sliding(self, q: Array, known: Mapping[str, Sequence[float]]) -> Iterator[LinkageRow]:
        """Equations of sliders: they stay on their lines, and are where inputs put them."""
        for name, slider in self.scene.sliders.items():
            along = self._direction(slider)
            across = np.array([-along[1], along[0]])
            yield self._on(f"{name}: across", slider, across, q, (0.0, 0.0, 0.0))
            for key, given in self.scene.inputs.items():
                if given.slider == name:
                    yield self._on(f"{key}: {name}", slider, along, q, known[key])

    @staticmethod
    def _direction(slider: Slider) -> Array:
        x, y = map(Fraction, slider.direction)
        return np.array([float(part) for part in unit_vector(x, y)])

    def _on(
        self, label: str, slider: Slider, along: Array, q: Array, law: Sequence[float]
    ) -> LinkageRow:
        """Equation of a node that is so far along a direction, from the origin of its line."""
        first, jacobian = self._place[slider.node], np.zeros(len(q))
        jacobian[first : first + 2] = along
        far = along @ (q[first : first + 2] - np.array(slider.through, float))
        return LinkageRow(label, self.scene.unit, float(far) - law[0], law[1], law[2], jacobian)

    def _of_links(
        self, q: Array, v: Array, known: Mapping[str, Sequence[float]]
    ) -> Iterator[LinkageRow]:
        """Equations of links: they keep their lengths, and prescribed angles."""
        angles: dict[int, list[LinkageRow]] = {}
        for element in self.assembly.elements:
            for row in element.rows:
                found = self._row(element, row, q, v)
                if row:
                    angles.setdefault(element.ends[ROTATION[row]].coordinate, []).append(found)
                else:
                    yield found
        for coordinate, (first, *others) in angles.items():
            record = self.assembly.coordinates[coordinate]
            if record.role is Role.INPUT:
                law = known[record.name]
                for own in (first, *others):
                    yield own._replace(
                        label=f"{record.name}: {own.label}",
                        C=math.remainder(own.C + law[0], math.tau),
                        nu=own.nu - law[1],
                        gamma=own.gamma - law[2],
                    )
                continue
            for own in others:
                yield own._replace(
                    label=f"{first.label} and {own.label}: rigid",
                    C=math.remainder(own.C - first.C, math.tau),
                    nu=own.nu - first.nu,
                    gamma=own.gamma - first.gamma,
                    C_q=own.C_q - first.C_q,
                )

    def _row(self, element: LinkElement, row: int, q: Array, v: Array) -> LinkageRow:
        """ε1, or ε2 or ε3 by the rotation that it has, with that rotation at zero."""
        places = [self._place[node] + k for node in element.nodes for k in (0, 1)]
        x, x_dot = [0.0] * 6, [0.0] * 6
        for end, place in zip(PLACES, places, strict=True):
            x[end], x_dot[end] = float(q[place]), float(v[place])
        for end in ROTATION.values():
            x[end] = float(element.ends[end].offset)
        inputs = {"x": x, "length": [float(element.length)], "offset": [0.0, 0.0]}
        shape = evaluate(link_kernels()["deformation"], inputs, FLOAT)
        rate = evaluate(link_kernels()["rate"], inputs | {"x_dot": x_dot}, FLOAT)
        derivatives = shape["D"][6 * row : 6 * row + 6]
        factor = 1 / derivatives[ROTATION[row]] if row else 1.0
        jacobian = np.zeros(len(q))
        for end, place in zip(PLACES, places, strict=True):
            jacobian[place] += factor * derivatives[end]
        return LinkageRow(
            f"{element.name} at {element.nodes[row - 1]}" if row else f"{element.name}: length",
            "rad" if row else self.scene.unit,
            factor * shape["epsilon"][row],
            0.0,
            -factor * rate["D_dot_x_dot"][row],
            jacobian,
        )


def _law(given: Input, t: float) -> tuple[float, float, float]:
    """Value that an input prescribes, and its first and second derivatives."""
    start, rate, second = map(float, (given.start, given.rate, given.acceleration))
    return start + rate * t + second / 2 * t * t, rate + second * t, second
