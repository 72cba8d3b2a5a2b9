"""How the systems (29) and (33) are read: against (15), assembled link by link.

A displacement that is known has its value behind it in parentheses. The zeros on the right stand
for what must vanish: the deformations of all links, three for each.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from sympy import Symbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.ledger.entry import Check
from kousoku.ledger.formula import Array, Name, Node, Number, Product
from kousoku.ledger.link_checks import MATRIX
from kousoku.ledger.link_mechanisms import LEVER_CRANK, PISTON_CRANK, Mechanism
from kousoku.ledger.link_words import column
from kousoku.ledger.parser import parse
from kousoku.ledger.proof import value_of
from kousoku.ledger.vocabulary import Vocabulary
from kousoku.model.errors import FormulaError, LedgerError
from kousoku.model.quantity import Quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from kousoku.ledger.vocabulary import Value

Scalar = Any
ZERO = Number("0")


@dataclass(frozen=True, slots=True)
class Assembled(Vocabulary):
    """The words of the system of a mechanism, displacements and angles of any size.

    Parameters
    ----------
    mechanism : Mechanism
        Which links there are, where they meet, and what is known.
    """

    mechanism: Mechanism = PISTON_CRANK

    def value(self, node: Node) -> Value:
        """Return a system's left side, all products carried out, or what its zeros stand for."""
        match node:
            case Product() if all(isinstance(factor, Array) for factor in node.factors):
                rows, cells = parts(node)
                u = [self._displacement(cell) for cell in cells]
                if len(rows[0]) != len(u):
                    raise FormulaError(f"{len(rows[0])} columns for {len(u)} displacements")
                return self.matrix(rows) * column(u)
            case Array() if all(row == (ZERO,) for row in node.rows):
                matrix = assembled(self)
                if len(node.rows) != matrix.rows:
                    raise FormulaError(f"{len(node.rows)} zeros for {matrix.rows} equations")
                return matrix * column([Symbol(name) for name in self.mechanism.names])
        return Vocabulary.value(self, node)

    def matrix(self, rows: Sequence[Sequence[Node]]) -> ImmutableDenseMatrix:
        """Return cells as a matrix."""
        return ImmutableDenseMatrix([[self.value(cell) for cell in row] for row in rows])

    def _displacement(self, cell: Node) -> Scalar:
        name, value = displacement(cell)
        if name not in self.mechanism.names:
            raise FormulaError(f"the mechanism has no displacement {name}")
        known = self.mechanism.known.get(name, "")
        if value != known:
            raise FormulaError(f"{name} is {known or 'not known'}, not {value or 'unknown'}")
        return Symbol(name)


def displacement(cell: Node) -> tuple[str, str]:
    """Return the name of a displacement and its value, empty where it is not known."""
    match cell:
        case Name():
            return str(cell), ""
        case Product((Name() as name, Number() as number)):
            return str(name), number.text
        case Product((Name() as name, Name() as value)):
            return str(name), str(value)
    raise FormulaError("a displacement is a symbol, with a value in parentheses where it is known")


def parts(node: Node) -> tuple[list[tuple[Node, ...]], list[Node]]:
    """Return the rows of the matrix, its parts joined side by side, and the displacements."""
    if not isinstance(node, Product):
        raise FormulaError("a system is a matrix times its displacements")
    *blocks, vector = (factor.rows for factor in node.factors if isinstance(factor, Array))
    if len({len(block) for block in blocks}) != 1:
        raise FormulaError("the parts of the matrix have different heights")
    rows = [sum(row, ()) for row in zip(*blocks, strict=True)]
    return rows, [cell for (cell,) in vector]


def assembled(words: Assembled) -> ImmutableDenseMatrix:
    """Return (15) of each link in its three rows, in the columns of the nodes at which it ends."""

    def element(link: int) -> list[list[Scalar]]:
        of_link = {
            "β_i^0": words.meanings[f"β_{link}^0"],
            "l_i^0": words.meanings[f"l_{link}^0"],
        }
        cells: list[list[Scalar]] = value_of(MATRIX, Vocabulary((), of_link)).tolist()
        return cells

    return ImmutableDenseMatrix(words.mechanism.assembled(element))


def _words(mechanism: Mechanism) -> Assembled:
    links = range(1, len(mechanism.links) + 1)
    names = [f"{letter}_{link}^0" for link in links for letter in "βl"]
    quantities = tuple(Quantity(name, (), "", "") for name in (*mechanism.names, *names))
    return Assembled(quantities, {name: Symbol(name) for name in names}, mechanism=mechanism)


@cache
def piston() -> Assembled:
    """Return the words of (29)."""
    return _words(PISTON_CRANK)


@cache
def lever() -> Assembled:
    """Return the words of (33)."""
    return _words(LEVER_CRANK)


# -- what is wrong with a system -----------------------------------------------------------------


def faults(latex: str, words: Assembled) -> list[str]:
    """Return all that makes a printed system another one than that of the mechanism."""
    (statement,) = parse(latex)
    left, right = statement.sides
    rows, cells = parts(left)
    zeros = len(right.rows) if isinstance(right, Array) else 0
    wanted, names = assembled(words), words.mechanism.names
    found = _wrong_names([displacement(cell) for cell in cells], words.mechanism)
    if len(rows[0]) != len(names):
        found.append(f"{len(rows[0])} columns for {len(names)} displacements")
    for number, row in enumerate(rows[: wanted.rows]):
        values = [words.value(cell) for cell in row] + [0] * (len(names) - len(row))
        found += _wrong_cells(number + 1, values, list(wanted.row(number)), names)
    if len(rows) > wanted.rows:
        found.append(f"rows {wanted.rows + 1} to {len(rows)} are of no link of this mechanism")
    if zeros != len(rows):
        found.append(f"{zeros} zeros for {len(rows)} rows")
    return found


def _wrong_names(cells: Sequence[tuple[str, str]], mechanism: Mechanism) -> list[str]:
    found = []
    if [name for name, _ in cells] != mechanism.names:
        found.append("other displacements, or in another order")
    for name, value in cells:
        known = mechanism.known.get(name, "")
        if value != known:
            found.append(f"{name} is {known or 'unknown'}, printed as {value or 'unknown'}")
    return found


def _wrong_cells(
    row: int, got: Sequence[Scalar], wanted: Sequence[Scalar], names: Sequence[str]
) -> list[str]:
    pairs = list(zip(names, got, wanted, strict=True))
    idle = [f"{one} under {name}" for name, one, two in pairs if one not in (two, 0)]
    missing = [f"{two} under {name}" for name, one, two in pairs if two not in (one, 0)]
    if not idle and not missing:
        return []
    return [f"row {row} has {' and '.join(idle) or '0'}, wanted {' and '.join(missing) or '0'}"]


def are_faults(latex: str, words: Callable[[], Assembled], *expected: str) -> Check:
    """Return the check that a printed system has exactly these faults."""

    def run() -> str:
        found = faults(latex, words())
        if found != list(expected):
            raise LedgerError(f"its faults are {'; '.join(found) or 'none'}")
        return "; ".join(found)

    return Check("as printed, beside the assembly of (15)", run)


def are_rows_of(latex: str, other: str, first: int) -> Check:
    """Return the check that the rows from one on are those of another system's first part."""

    def run() -> str:
        rows, _ = parts(parse(latex)[0].sides[0])
        source, _ = parts(parse(other)[0].sides[0])
        width = 8
        same = [
            row[:width] == twin[:width] and set(row[width:]) == {ZERO}
            for row, twin in zip(rows[first - 1 :], source[first - 1 :], strict=True)
        ]
        if not all(same):
            raise LedgerError("they are other rows")
        return f"the same as in the first {width} columns there, and zeros"

    return Check(f"rows {first} and on, beside those of the other system", run)
