"""The records that a derivation is made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import sympy

    from kousoku.model.quantity import Quantity


@dataclass(frozen=True, slots=True)
class Step:
    """One line of a derivation.

    Parameters
    ----------
    left : sympy.Basic
        What the line is about, e.g. δC.
    right : sympy.Basic
        What it equals now.
    rule : str
        Why: the rule that led here, in words.
    source : str
        The equation that states the rule, e.g. ``7.16``; empty where it is plain algebra.
    """

    left: sympy.Basic
    right: sympy.Basic
    rule: str
    source: str


@dataclass(frozen=True, slots=True)
class Output:
    """A derived quantity, on both levels.

    Parameters
    ----------
    quantity : Quantity
        Name, shape, unit, meaning.
    expression : sympy.Basic
        Matrix level: what is frozen and emitted. Built only from the node types that
        ``symbolic.matrices`` lists.
    components : sympy.ImmutableDenseMatrix
        Component level: scalar expressions, one column, row-major, found without the matrix
        level; references are computed from these. The components of an input are the symbols
        that ``symbolic.matrices.elements`` gives (``r_i[0]`` …; a scalar keeps its bare name).
    through : tuple of sympy.Basic
        Further forms on the matrix level, on the way to which ``expression`` is proved equal to
        the components: each next one equals the one before it.
    """

    quantity: Quantity
    expression: sympy.Basic
    components: sympy.ImmutableDenseMatrix
    through: tuple[sympy.Basic, ...] = ()


@dataclass(frozen=True, slots=True)
class Function:
    """Outputs that are evaluated together: the source of one kernel.

    Parameters
    ----------
    name, title, formula, source : str
        As in :class:`kousoku.codegen.kernel.Kernel`.
    inputs : tuple of Quantity
        In the order of the arguments.
    outputs : tuple of Output
        In the order of the arguments.
    """

    name: str
    title: str
    formula: str
    source: str
    inputs: tuple[Quantity, ...]
    outputs: tuple[Output, ...]


@dataclass(frozen=True, slots=True)
class Derivation:
    """All that is derived of one kind.

    Parameters
    ----------
    name : str
        The package that is emitted, e.g. ``p2_z``.
    kind : str
        The kind, e.g. ``p2``.
    title : str
        What it is, in one line, with its names in other books.
    source : str
        The document and section.
    steps : tuple of Step
        The derivation on the matrix level, in the order of reading.
    functions : tuple of Function
        What is emitted.
    """

    name: str
    kind: str
    title: str
    source: str
    steps: tuple[Step, ...]
    functions: tuple[Function, ...]
