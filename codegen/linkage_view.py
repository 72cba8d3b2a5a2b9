"""What the templates of a linkage may see: strings, whole numbers, and tuples of them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from textwrap import fill
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.emission.numpy_view import (
    python_kernels,
    python_segment,
    regions_of,
)
from kousoku.codegen.dynamics.emission.slots import slots_of
from kousoku.codegen.dynamics.emission.view import enumerators, segment_text
from kousoku.codegen.graph import literal
from kousoku.codegen.linkage_layout import REGIONS
from kousoku.codegen.view_lines import ascii_of, plain
from kousoku.model.motion import span_of, turns_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from kousoku.codegen.dynamics.emission.numpy_view import PythonKernel, PythonSegment
    from kousoku.codegen.dynamics.emission.view import SegmentText
    from kousoku.codegen.dynamics.recording.program import Program
    from kousoku.codegen.linkage_blocks import Block
    from kousoku.codegen.linkage_layout import Layout
    from kousoku.model.assemble import Term


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
    first, first_curve, jacobian : int
        Where its unknowns, its curves and its Jacobian start.
    unknowns, links : tuple of str
        Names of its unknowns, and of the links that hold them.
    curves : tuple of CurveView
        What bends its equations.
    """

    number: int
    first: int
    first_curve: int
    jacobian: int
    unknowns: tuple[str, ...]
    links: tuple[str, ...]
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
class LinkageView:
    """What the solver of a scene is made of.

    Parameters
    ----------
    name, title, unit : str
        The scene, what it is, and its unit of length.
    nodes : tuple of str
        In the order of the scene.
    links, inputs, unknowns, blocks : tuple
        In the order of the scene, and in the order of solving.
    largest_block : int
        Most unknowns of any block.
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
    work_size : int
        Count of slots of the workspace.
    regions : tuple of (str, int, int)
        Its parts: name, first slot and size.
    places : str
        Their first slots as enumerators of C, in lines.
    segments : tuple of SegmentText
        Those of the blocks, then those of the outputs, in C.
    python_kernels, python_segments : tuple
        The same in Python.
    """

    name: str
    title: str
    unit: str
    nodes: tuple[str, ...]
    links: tuple[LinkView, ...]
    inputs: tuple[InputView, ...]
    unknowns: tuple[UnknownView, ...]
    blocks: tuple[BlockView, ...]
    largest_block: int
    matrix_size: int
    largest_length: str
    limit: str
    divisions: int
    max_iterations: int
    method: int
    outputs: tuple[str, ...]
    work_size: int
    regions: tuple[tuple[str, int, int], ...]
    places: str
    segments: tuple[SegmentText, ...]
    python_kernels: tuple[PythonKernel, ...]
    python_segments: tuple[PythonSegment, ...]

    @property
    def title_ascii(self) -> str:
        """The title in a comment of C."""
        return ascii_of(plain(self.title))

    @property
    def meanings(self) -> tuple[tuple[str, str], ...]:
        """What the regions hold."""
        return tuple((name, REGIONS[name]) for name, _, _ in self.regions)

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
    def has_angles(self) -> bool:
        """Whether the angles of links are wanted."""
        return "angles" in self.outputs


def linkage_view(program: Program, layout: Layout) -> LinkageView:
    """Return what the templates of a scene's solver see."""
    scene = layout.system.scene
    sizes = [len(block.unknowns) for block in layout.blocks]
    coordinates, slots = layout.system.coordinates, slots_of(program)
    regions = regions_of(program)
    return LinkageView(
        name=scene.name,
        title=scene.title or f"the linkage {scene.name}",
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
        largest_block=max(sizes),
        matrix_size=sum(size * size for size in sizes),
        largest_length=literal(Fraction(scene.largest_length)),
        limit=literal(Fraction(scene.residual_limit)),
        divisions=scene.divisions,
        max_iterations=scene.method.iterations,
        method=("newton", "paper").index(scene.method.scheme),
        outputs=scene.outputs,
        work_size=program.size,
        regions=regions,
        places=enumerators({f"W_{name.upper()}": base for name, base, _ in regions}),
        segments=tuple(segment_text(program, one, slots) for one in program.segments),
        python_kernels=tuple(python_kernels(program)),
        python_segments=tuple(python_segment(program, one) for one in program.segments),
    )


def _quoted(names: Sequence[str]) -> tuple[str, ...]:
    return tuple(f'"{name}"' for name in names)


def _input(layout: Layout, name: str, number: int) -> InputView:
    coordinate, given = layout.system.coordinates[number], layout.system.scene.inputs[name]
    turns = turns_of(given) or 0.0
    return InputView(
        name=name,
        unit=coordinate.unit,
        origin=literal(Fraction(given.start)),
        span=literal(span_of(given)),
        turns=int(turns) if turns.is_integer() else 0,
        rate=literal(Fraction(given.rate)),
        rate_dot=literal(Fraction(given.acceleration)),
        scale=literal(coordinate.scale),
    )


def _block(layout: Layout, number: int) -> BlockView:
    block, system = layout.blocks[number], layout.system
    sizes = [len(before.unknowns) for before in layout.blocks[:number]]
    return BlockView(
        number=number + 1,
        first=sum(sizes),
        first_curve=sum(len(_curves(layout, before)) for before in layout.blocks[:number]),
        jacobian=sum(size * size for size in sizes),
        unknowns=tuple(system.coordinates[unknown].name for unknown in block.unknowns),
        links=tuple(dict.fromkeys(system.elements[element].name for element, _ in block.rows)),
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
