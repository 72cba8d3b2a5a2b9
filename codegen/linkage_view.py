"""What the solver templates may see: strings, whole numbers, and tuples of them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate
from textwrap import fill
from typing import TYPE_CHECKING

from kousoku.codegen.graph import literal
from kousoku.model.directions import HALF_TURN

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from kousoku.codegen.linkage_layout import Layout
    from kousoku.model.planar import Input


_TAB, _STAR = "    ", " *     "

#: What a solution ends with, in the order of the statuses.
MESSAGES = (
    "good",
    "the linkage cannot be assembled from the positions of the scene",
    "the positions of the scene lie on a dead centre, where the side is not clear",
    "the linkage assembles only on the other side of a dead centre than the scene shows",
    "a dead centre, or a change point, on the way",
    "the residual limit is smaller than rounding allows",
    "a number is not finite",
    "an option is not finite, not positive, or start is beyond first",
)


@dataclass(frozen=True, slots=True)
class InputView:
    """A prescribed coordinate; numbers are literals of C and of Python.

    Parameters
    ----------
    name, unit : str
        The input.
    origin, span : str
        Value at division 0, and what is added until the last division.
    turns : int
        Whole turns until the last division; 0 where the motion does not repeat.
    rate, rate_dot : str
        First and second time derivative.
    scale : str
        Length that a change by 1 moves.
    """

    name: str
    unit: str
    origin: str
    span: str
    turns: int
    rate: str
    rate_dot: str
    scale: str


@dataclass(frozen=True, slots=True)
class UnknownView:
    """An unknown coordinate: where it starts, the length that a change by 1 moves."""

    name: str
    start: str
    scale: str
    is_angle: int


@dataclass(frozen=True, slots=True)
class LinkView:
    """A link: its nodes and its design length."""

    name: str
    first: str
    second: str
    length: str


@dataclass(frozen=True, slots=True)
class BlockView:
    """A block.

    Parameters
    ----------
    number : int
        Counted from 1.
    first : int
        Where its unknowns start.
    unknowns, links : tuple of str
        Names of its unknowns, and of the links that hold them.
    known : tuple of int
        Where its known coordinates stand among the inputs and, after them, all unknowns.
    """

    number: int
    first: int
    unknowns: tuple[str, ...]
    links: tuple[str, ...]
    known: tuple[int, ...]

    @property
    def quoted_links(self) -> tuple[str, ...]:
        """The links as strings of Python."""
        return _quoted(self.links)


@dataclass(frozen=True, slots=True)
class SolverView:
    """What the solver of a scene is made of.

    Parameters
    ----------
    unit : str
        Length unit of the scene.
    nodes : tuple of str
        In the order of the scene.
    links, inputs, unknowns, blocks : tuple
        In the order of the scene, and in the order of solving.
    first_of, known_of, matrix_of : tuple of int
        Where the unknowns, the known coordinates and the matrix of each block start, and where
        the last ones end.
    largest_known, largest_block : int
        Most known coordinates, and most unknowns, of any block.
    largest_length, limit : str
        Largest length of the scene, and limit of the residual.
    divisions, max_iterations : int
        As in the scene.
    method : int
        0 full Newton, 1 the iteration of the paper.
    outputs : tuple of str
        What is wanted beside positions.
    """

    unit: str
    nodes: tuple[str, ...]
    links: tuple[LinkView, ...]
    inputs: tuple[InputView, ...]
    unknowns: tuple[UnknownView, ...]
    blocks: tuple[BlockView, ...]
    first_of: tuple[int, ...]
    known_of: tuple[int, ...]
    largest_known: int
    matrix_of: tuple[int, ...]
    largest_block: int
    largest_length: str
    limit: str
    divisions: int
    max_iterations: int
    method: int
    outputs: tuple[str, ...]

    def wrapped(self, items: Iterable[object]) -> str:
        """Return the elements of an array of C, in lines that fit."""
        return fill(", ".join(map(str, items)), 92, initial_indent=_TAB, subsequent_indent=_TAB)

    def listed(self, names: Iterable[str]) -> str:
        """Return names inside a comment of C, in lines that fit."""
        return fill(", ".join(names), 92, initial_indent=_STAR, subsequent_indent=_STAR)

    @property
    def quoted_outputs(self) -> tuple[str, ...]:
        """The outputs as strings of Python."""
        return _quoted(self.outputs)

    @property
    def quoted_nodes(self) -> tuple[str, ...]:
        """The nodes as strings of Python."""
        return _quoted(self.nodes)

    @property
    def quoted_messages(self) -> tuple[str, ...]:
        """The messages as strings of Python and of C."""
        return _quoted(MESSAGES)

    @property
    def link_rows(self) -> tuple[str, ...]:
        """Name, nodes and length of each link as a tuple of Python."""
        return tuple(
            f'("{link.name}", "{link.first}", "{link.second}", {link.length})'
            for link in self.links
        )

    @property
    def input_rows(self) -> tuple[str, ...]:
        """Name, unit and scale of each input as a tuple of Python."""
        return tuple(f'("{given.name}", "{given.unit}", {given.scale})' for given in self.inputs)

    @property
    def unknown_rows(self) -> tuple[str, ...]:
        """Name, start and scale of each unknown, and whether an angle, as a tuple of Python."""
        return tuple(
            f'("{unknown.name}", {unknown.start}, {unknown.scale}, {bool(unknown.is_angle)})'
            for unknown in self.unknowns
        )

    @property
    def known_from(self) -> tuple[int, ...]:
        """The known coordinates of all blocks; one number at least, for C has no empty arrays."""
        return tuple(k for block in self.blocks for k in block.known) or (0,)

    @property
    def has_angles(self) -> bool:
        """Whether the angles of links are wanted."""
        return "angles" in self.outputs

    @property
    def matrix_size(self) -> int:
        """Count of the elements of the matrices of all blocks."""
        return self.matrix_of[-1]


def solver_view(layout: Layout) -> SolverView:
    """Return what the templates of a scene's solver see."""
    scene = layout.system.scene
    sizes = [len(block.unknowns) for block in layout.blocks]
    coordinates = layout.system.coordinates
    return SolverView(
        unit=scene.unit,
        nodes=tuple(scene.nodes),
        links=tuple(
            LinkView(name, *link.nodes, literal(Fraction(scene.length(name))))
            for name, link in scene.links.items()
        ),
        inputs=tuple(
            _input(layout, name, number)
            for name, number in zip(scene.inputs, layout.system.inputs, strict=True)
        ),
        unknowns=tuple(
            UnknownView(c.name, literal(c.start), literal(c.scale), int(c.unit == "rad"))
            for c in (coordinates[number] for number in layout.unknowns)
        ),
        blocks=tuple(
            _block(layout, number, first) for number, first in enumerate(_starts(sizes)[:-1])
        ),
        first_of=_starts(sizes),
        known_of=_starts([len(known) for known in layout.known]),
        largest_known=max(1, *map(len, layout.known)),
        matrix_of=_starts([size * size for size in sizes]),
        largest_block=max(sizes),
        largest_length=literal(Fraction(scene.largest_length)),
        limit=literal(Fraction(scene.residual_limit)),
        divisions=scene.divisions,
        max_iterations=scene.method.iterations,
        method=("newton", "paper").index(scene.method.scheme),
        outputs=scene.outputs,
    )


def _quoted(names: Sequence[str]) -> tuple[str, ...]:
    return tuple(f'"{name}"' for name in names)


def _starts(sizes: list[int]) -> tuple[int, ...]:
    return tuple(accumulate(sizes, initial=0))


def _input(layout: Layout, name: str, number: int) -> InputView:
    coordinate, given = layout.system.coordinates[number], layout.system.scene.inputs[name]
    turns = _turns(given)
    return InputView(
        name=name,
        unit=coordinate.unit,
        origin=literal(Fraction(given.start)),
        span=literal(_span(given, turns)),
        turns=int(turns) if turns.denominator == 1 else 0,
        rate=literal(Fraction(given.rate)),
        rate_dot=literal(Fraction(given.acceleration)),
        scale=literal(coordinate.scale),
    )


def _turns(given: Input) -> Fraction:
    """Return the turns of an input, 0 where it goes to a value instead."""
    if given.turns is None:
        return Fraction(0 if given.to is not None or given.slider is not None else 1)
    return Fraction(given.turns)


def _span(given: Input, turns: Fraction) -> Fraction:
    if given.to is not None:
        return Fraction(given.to) - Fraction(given.start)
    return 2 * HALF_TURN * turns


def _block(layout: Layout, number: int, first: int) -> BlockView:
    block, system = layout.blocks[number], layout.system
    start = {"alpha": 0, "x": len(system.inputs)}
    places = (layout.everywhere[coordinate] for coordinate in layout.known[number])
    return BlockView(
        number=number + 1,
        first=first,
        unknowns=tuple(system.coordinates[unknown].name for unknown in block.unknowns),
        links=tuple(dict.fromkeys(system.elements[element].name for element, _ in block.rows)),
        known=tuple(start[name] + index for name, index in places),
    )
