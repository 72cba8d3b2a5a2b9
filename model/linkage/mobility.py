"""Degrees of freedom of a planar linkage: its number of inputs, and redundant constraints."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random
from typing import TYPE_CHECKING, TypeVar

from kousoku.model.errors import SceneError
from kousoku.model.text import counted, in_words

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.model.records.scene import Scene

Key = TypeVar("Key")

#: A Mersenne prime. Each row is of degree 3 at most in the positions: random positions make n
#: independent rows dependent with a probability below 3 n/2⁶¹ (Schwartz and Zippel).
PRIME = 2**61 - 1

NodeCoordinate = tuple[str, int]
"""A coordinate: the node, and 0 for x or 1 for y."""

Residues = tuple[int, int]
"""A position modulo PRIME."""

SparseRow = dict[NodeCoordinate, int]
"""Derivatives of one constraint by coordinates, modulo PRIME; zeros left out."""


def check_mobility(scene: Scene) -> None:
    """Check that constraints are independent and that the inputs take all degrees of freedom.

    The rank of the Jacobian is taken at random positions of the free nodes, in arithmetic modulo a
    prime: exact, and never below the rank at any position that the linkage can really take. What is
    refused here is therefore singular everywhere. A linkage wants as many inputs as 2 · (free
    nodes) − (rows of links, sliders and rigid connections).

    Raises
    ------
    SceneError
        Elements repeat each other, the number of inputs is wrong, or inputs prescribe the same.
    """
    positions = _random_positions(scene)
    basis = _Basis({}, {}, {})
    n_constraints = 0
    for key, row in _constraints(scene, positions):
        repeated = basis.add(key, row)
        if repeated is not None:
            raise SceneError(
                f"repeats what {_names_text(repeated)} already {_verb(repeated)}; leave one of "
                "them out (linkages that move only thanks to special lengths are not supported)",
                key=key,
            )
        n_constraints += 1
    n_coordinates = 2 * sum(not node.fixed for node in scene.nodes.values())
    wanted = n_coordinates - n_constraints
    if wanted != len(scene.inputs):
        raise SceneError(
            f"wrong number of inputs: the linkage has {counted(wanted, 'degree')} of freedom "
            f"({n_coordinates} coordinates of free nodes − {n_constraints} constraints of links, "
            "sliders and rigid connections) and wants "
            f"{counted(wanted, 'input')}, got {len(scene.inputs)}",
            key="inputs",
        )
    for key, row in _inputs(scene, positions):
        repeated = basis.add(key, row)
        if repeated is not None:
            raise SceneError(
                f"prescribes what {_names_text(repeated)} already {_verb(repeated)}, while another "
                "part of the linkage is left free; move the input to that part",
                key=key,
            )


@dataclass(frozen=True, slots=True)
class _Basis:
    """Rows in echelon form by their pivots, each with the constraints that it combines."""

    rows: dict[NodeCoordinate, SparseRow]
    origins: dict[NodeCoordinate, dict[str, int]]
    order: dict[str, None]

    def add(self, key: str, row: SparseRow) -> tuple[str, ...] | None:
        """Add a row; where it depends on earlier ones, return their keys instead."""
        reduced, origin = dict(row), {key: 1}
        # A row holds no pivot of an earlier one, so that this walks forward and ends.
        while pivot := next((column for column in reduced if column in self.rows), None):
            factor = -reduced[pivot] % PRIME
            _accumulate(reduced, self.rows[pivot], factor)
            _accumulate(origin, self.origins[pivot], factor)
        if not reduced:
            return tuple(name for name in self.order if name in origin)
        self.order.setdefault(key)
        pivot = next(iter(reduced))
        scale = pow(reduced[pivot], -1, PRIME)
        self.rows[pivot] = {column: value * scale % PRIME for column, value in reduced.items()}
        self.origins[pivot] = {name: value * scale % PRIME for name, value in origin.items()}
        return None


def _accumulate(total: dict[Key, int], terms: dict[Key, int], factor: int) -> None:
    for key, value in terms.items():
        residue = (total.get(key, 0) + factor * value) % PRIME
        if residue:
            total[key] = residue
        else:
            total.pop(key, None)


def _random_positions(scene: Scene) -> dict[str, Residues]:
    random = Random(1981)
    return {
        name: (_residue(node.at[0]), _residue(node.at[1]))
        if node.fixed
        else (random.randrange(PRIME), random.randrange(PRIME))
        for name, node in scene.nodes.items()
    }


def _residue(value: float) -> int:
    numerator, denominator = value.as_integer_ratio()
    return numerator * pow(denominator, -1, PRIME) % PRIME


def _constraints(scene: Scene, positions: dict[str, Residues]) -> Iterator[tuple[str, SparseRow]]:
    """Rows of moving links (length), sliders (line) and rigid connections (angle)."""
    for name, link in scene.links.items():
        if not scene.is_ground(name):
            x, y = _difference(positions, link.nodes)
            yield f"links.{name}", _relative(scene, link.nodes, x, y)
    for name, slider in scene.sliders.items():
        dx, dy = (_residue(component) for component in slider.direction)
        row = {(slider.node, 0): -dy % PRIME, (slider.node, 1): dx}
        yield f"sliders.{name}", {column: value for column, value in row.items() if value}
    for name, rigid in scene.rigid.items():
        for other in rigid.links[1:]:
            row = _angle_row(scene, positions, other)
            _accumulate(row, _angle_row(scene, positions, rigid.links[0]), PRIME - 1)
            yield f"rigid.{name}", row


def _inputs(scene: Scene, positions: dict[str, Residues]) -> Iterator[tuple[str, SparseRow]]:
    for name, motion in scene.inputs.items():
        if motion.slider is not None:
            slider = scene.sliders[motion.slider]
            dx, dy = (_residue(component) for component in slider.direction)
            row = {(slider.node, 0): dx, (slider.node, 1): dy}
            yield f"inputs.{name}", {column: value for column, value in row.items() if value}
        elif motion.link is not None:
            yield f"inputs.{name}", _angle_row(scene, positions, motion.link)


def _angle_row(scene: Scene, positions: dict[str, Residues], link: str) -> SparseRow:
    """Derivative of the angle β of a link: (u × du) / (u · u)."""
    ends = scene.links[link].nodes
    x, y = _difference(positions, ends)
    if scene.is_ground(link):
        return {}
    scale = pow(x * x + y * y, -1, PRIME)
    return _relative(scene, ends, -y * scale, x * scale)


def _difference(positions: dict[str, Residues], ends: tuple[str, str]) -> Residues:
    (x1, y1), (x2, y2) = positions[ends[0]], positions[ends[1]]
    return x2 - x1, y2 - y1


def _relative(scene: Scene, ends: tuple[str, str], x: int, y: int) -> SparseRow:
    """Row of (x, y) · (dr_2 − dr_1), fixed nodes left out."""
    row: SparseRow = {}
    for node, sign in zip(ends, (-1, 1), strict=True):
        if not scene.nodes[node].fixed:
            for axis, value in enumerate((x, y)):
                if value % PRIME:
                    row[node, axis] = sign * value % PRIME
    return row


def _names_text(keys: tuple[str, ...]) -> str:
    shown = [*keys[:6], "others"] if len(keys) > 6 else list(keys)
    return in_words(shown) if shown else "the frame"


def _verb(keys: tuple[str, ...]) -> str:
    return "determine" if len(keys) > 1 else "determines"
