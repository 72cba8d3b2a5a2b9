"""What the solver templates may see: strings, whole numbers, and tuples of them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from textwrap import fill
from typing import TYPE_CHECKING

from kousoku.model.directions import HALF_TURN
from kousoku.model.graph import literal

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from kousoku.codegen.linkage_blocks import Block
    from kousoku.codegen.linkage_layout import Layout
    from kousoku.model.assemble import Term
    from kousoku.model.planar import Input


_STAR = " *     "


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
class KnownView:
    """A coordinate that a block depends on: its name, its place among inputs and unknowns."""

    name: str
    place: int


@dataclass(frozen=True, slots=True)
class CurveView:
    """A link that bends an equation of a block.

    Parameters
    ----------
    row : int
        The equation, counted from 0.
    is_arm : int
        Whether the equation is of the direction of the link, too.
    length : str
        Its length.
    x, y, angle : tuple of (int, str)
        Places and factors of what is added up to x and y from its first to its second node, and to
        its angle; what does not move is left out.
    """

    row: int
    is_arm: int
    length: str
    x: tuple[tuple[int, str], ...]
    y: tuple[tuple[int, str], ...]
    angle: tuple[tuple[int, str], ...]

    @property
    def initialiser(self) -> tuple[str, ...]:
        """Its fields in C, in one line or two; those that are not named are zero."""
        head = [f".row = {self.row}", *[".is_arm = 1"] * self.is_arm, f".length = {self.length}"]
        sums = {
            name: ", ".join(f"{{{place}, {factor}}}" for place, factor in terms)
            for name, terms in (("x", self.x), ("y", self.y), ("angle", self.angle))
        }
        fields = [
            f".{name} = {text if name == 'angle' else f'{{{text}}}'}"
            for name, text in sums.items()
            if text
        ]
        line = ", ".join([*head, *fields])
        return (line,) if len(line) <= 92 else (f"{', '.join(head)},", ", ".join(fields))


@dataclass(frozen=True, slots=True)
class BlockView:
    """A block.

    Parameters
    ----------
    number : int
        Counted from 1.
    first, first_known, first_curve, jacobian : int
        Where its unknowns, its known coordinates, its curves and its Jacobian start.
    unknowns, links : tuple of str
        Names of its unknowns, and of the links that hold them.
    known : tuple of KnownView
        Its known coordinates, whose places are those among the inputs and, after them, all
        unknowns.
    curves : tuple of CurveView
        What bends its equations.
    """

    number: int
    first: int
    first_known: int
    first_curve: int
    jacobian: int
    unknowns: tuple[str, ...]
    links: tuple[str, ...]
    known: tuple[KnownView, ...]
    curves: tuple[CurveView, ...]

    @property
    def size(self) -> int:
        """Count of its unknowns."""
        return len(self.unknowns)

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
    largest_known, largest_block : int
        Most known coordinates, and most unknowns, of any block.
    matrix_size : int
        Count of the elements of the Jacobians of all blocks.
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
    largest_known: int
    largest_block: int
    matrix_size: int
    largest_length: str
    limit: str
    divisions: int
    max_iterations: int
    method: int
    outputs: tuple[str, ...]

    def commented(self, text: str) -> list[str]:
        """Return a comment of C, in lines that fit."""
        return fill(f"/* {text} */", 92, subsequent_indent=" * ").splitlines()

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
    def link_rows(self) -> tuple[str, ...]:
        """The links as records of Python."""
        return tuple(
            f'Link("{link.name}", "{link.first}", "{link.second}", length={link.length})'
            for link in self.links
        )

    @property
    def input_rows(self) -> tuple[str, ...]:
        """The inputs as records of Python."""
        return tuple(
            f'Input("{given.name}", "{given.unit}", scale={given.scale})' for given in self.inputs
        )

    @property
    def unknown_rows(self) -> tuple[str, ...]:
        """The unknowns as records of Python."""
        return tuple(
            f'Unknown("{unknown.name}", start={unknown.start}, scale={unknown.scale}, '
            f"is_angle={bool(unknown.is_angle)})"
            for unknown in self.unknowns
        )

    @property
    def has_known(self) -> bool:
        """Whether any block depends on something."""
        return any(block.known for block in self.blocks)

    @property
    def has_angles(self) -> bool:
        """Whether the angles of links are wanted."""
        return "angles" in self.outputs


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
        blocks=tuple(_block(layout, number) for number in range(len(sizes))),
        largest_known=max(1, *map(len, layout.known)),
        largest_block=max(sizes),
        matrix_size=sum(size * size for size in sizes),
        largest_length=literal(Fraction(scene.largest_length)),
        limit=literal(Fraction(scene.residual_limit)),
        divisions=scene.divisions,
        max_iterations=scene.method.iterations,
        method=("newton", "paper").index(scene.method.scheme),
        outputs=scene.outputs,
    )


def _quoted(names: Sequence[str]) -> tuple[str, ...]:
    return tuple(f'"{name}"' for name in names)


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


def _block(layout: Layout, number: int) -> BlockView:
    block, system = layout.blocks[number], layout.system
    sizes = [len(before.unknowns) for before in layout.blocks[:number]]
    known = [
        KnownView(system.coordinates[coordinate].name, layout.place_of(coordinate))
        for coordinate in layout.known[number]
    ]
    return BlockView(
        number=number + 1,
        first=sum(sizes),
        first_known=sum(map(len, layout.known[:number])),
        first_curve=sum(len(_curves(layout, before)) for before in layout.blocks[:number]),
        jacobian=sum(size * size for size in sizes),
        unknowns=tuple(system.coordinates[unknown].name for unknown in block.unknowns),
        links=tuple(dict.fromkeys(system.elements[element].name for element, _ in block.rows)),
        known=tuple(known),
        curves=_curves(layout, block),
    )


def _curves(layout: Layout, block: Block) -> tuple[CurveView, ...]:
    """Return what bends the equations of a block.

    ε1 alone is |d| = l. With ε2 or ε3 it is one of two rows of d = l (cos β, sin β), turned by a
    constant angle, and where all three are there, ε3 − ε2 is linear: it adds the other angle.
    """
    rows, curves = set(block.rows), []
    for row, (number, which) in enumerate(block.rows):
        element = layout.system.elements[number]
        angles = [element.ends[place] for k, place in ((1, 2), (2, 5)) if (number, k) in rows]
        x1, y1, _, x2, y2, _ = element.ends

        def curve(
            ends: tuple[Sequence[tuple[int, Term]], ...],
            angle: Sequence[Term],
            row: int = row,
            length: Fraction = element.length,
        ) -> CurveView:
            terms = (*ends, [(1, term) for term in angle])
            x, y, turned = (_terms(layout, each) for each in terms)
            return CurveView(row, int(bool(angle)), literal(length), x, y, turned)

        curves.append(curve(([(-1, x1), (1, x2)], [(-1, y1), (1, y2)]), angles[:1]))
        if which == 2 and len(angles) == 2:
            curves.append(curve(([], []), angles[1:]))
    return tuple(curves)


def _terms(layout: Layout, terms: Iterable[tuple[int, Term]]) -> tuple[tuple[int, str], ...]:
    """Return places and factors of the terms that move."""
    return tuple(
        (layout.place_of(term.coordinate), literal(sign * term.factor))
        for sign, term in terms
        if layout.is_moving(term)
    )
