"""The tree of a formula, as the documents' LaTeX spells it; its symbols have no meaning yet."""

from __future__ import annotations

from dataclasses import dataclass

#: Relations between the sides of a statement.
RELATIONS = ("=", "\\equiv", "\\leq", "\\leftarrow")


@dataclass(frozen=True, slots=True)
class Numeral:
    """A number, in decimal digits."""

    text: str


@dataclass(frozen=True, slots=True)
class SymbolName:
    """A symbol: its letter with primes, subscript and superscript, e.g. ``a'^i``.

    Marks in front are part of the letter: ``δA``, ``vec d``, ``d/dt A``.
    """

    letter: str
    primes: str = ""
    sub: str = ""
    sup: str = ""

    def __str__(self) -> str:
        sub = f"_{self.sub}" if self.sub else ""
        return self.letter + self.primes + sub + (f"^{self.sup}" if self.sup else "")


@dataclass(frozen=True, slots=True)
class Sum:
    """Terms with their signs, +1 or −1."""

    terms: tuple[tuple[int, FormulaNode], ...]


@dataclass(frozen=True, slots=True)
class Product:
    """Factors in their order."""

    factors: tuple[FormulaNode, ...]


@dataclass(frozen=True, slots=True)
class Cross:
    """The cross product of two vectors."""

    left: FormulaNode
    right: FormulaNode


@dataclass(frozen=True, slots=True)
class Division:
    """One thing over another."""

    over: FormulaNode
    under: FormulaNode


@dataclass(frozen=True, slots=True)
class Power:
    """An integer power; −1 is the inverse."""

    base: FormulaNode
    exponent: int


@dataclass(frozen=True, slots=True)
class Transposed:
    """The transpose."""

    inner: FormulaNode


@dataclass(frozen=True, slots=True)
class Tilde:
    """The skew matrix of a vector: a tilde, or ``cross(…)``."""

    inner: FormulaNode


@dataclass(frozen=True, slots=True)
class FunctionCall:
    """``cos``, ``sin`` or ``sqrt`` of something."""

    function: str
    argument: FormulaNode


@dataclass(frozen=True, slots=True)
class Derivative:
    """The derivative by a number: ``(d/dα)``, ``(d/dt)``."""

    by: str
    inner: FormulaNode


@dataclass(frozen=True, slots=True)
class Array:
    """Rows of cells in brackets: a matrix, or one of blocks."""

    rows: tuple[tuple[FormulaNode, ...], ...]


FormulaNode = (
    Numeral
    | SymbolName
    | Sum
    | Product
    | Cross
    | Division
    | Power
    | Transposed
    | Tilde
    | FunctionCall
    | Derivative
    | Array
)


@dataclass(frozen=True, slots=True)
class Statement:
    """Sides with the relations between them, e.g. two equalities in a row.

    Parameters
    ----------
    sides : tuple of FormulaNode
        At least one.
    relations : tuple of str
        One fewer than sides; from ``RELATIONS``.
    """

    sides: tuple[FormulaNode, ...]
    relations: tuple[str, ...]
