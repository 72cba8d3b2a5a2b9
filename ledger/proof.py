"""The proofs: statements of an entry are read, carried into an exact ring, and compared.

Nothing is rounded and nothing rests on sampled points: an equality holds identically in all
quantities, an inequality is shown by one rational point.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

from sympy.matrices.expressions import ZeroMatrix

from kousoku.ledger.formula import Numeral, SymbolName
from kousoku.ledger.parser import parse
from kousoku.ledger.registry import Names
from kousoku.ledger.tokens import differ_in_notation_only
from kousoku.ledger.vocabulary import shape
from kousoku.model.errors import FormulaError, LedgerError
from kousoku.symbolic import derive
from kousoku.symbolic.prove import rational_point
from kousoku.symbolic.sympy_types import as_value

if TYPE_CHECKING:
    from kousoku.ledger.entry import Check, Entry
    from kousoku.ledger.formula import Statement
    from kousoku.ledger.registry import Words
    from kousoku.ledger.vocabulary import Vocabulary
    from kousoku.symbolic.sympy_types import Scalar, SymbolicMatrix, Value


@dataclass(frozen=True, slots=True)
class Line:
    """One statement that was tested, and the finding."""

    statement: str
    result: str


@dataclass(frozen=True, slots=True)
class Proof:
    """Steps that ran for an entry, in order."""

    lines: tuple[Line, ...]

    def __str__(self) -> str:
        return "\n".join(f"{line.statement}: {line.result}" for line in self.lines)


def prove(entry: Entry) -> Proof:
    """Run all that proves an entry.

    The true form is read and its sides compared; a printed form that is not true must fail, or
    must not be readable, and may differ from the true one in notation alone only where the
    verdict says so.

    Raises
    ------
    LedgerError
        Something is not as the entry claims; the message names the entry and the statement.
    """
    try:
        return Proof((*_printed(entry), *_true_form(entry)))
    except LedgerError as problem:
        raise LedgerError(f"{entry.equation} ({entry.document.title}): {problem}") from None


def _printed(entry: Entry) -> tuple[Line, ...]:
    """Refute the printed form where it is not true."""
    if entry.verdict == "holds":
        if entry.corrected or entry.refutation:
            raise LedgerError("holds as printed, yet the entry corrects or refutes it")
        return ()
    if not entry.corrected:
        raise LedgerError(f"the verdict is {entry.verdict}, yet no corrected form is given")
    lines = tuple(_run(check) for check in entry.refutation)
    if entry.vocabulary is not None and not lines:
        lines = (Line("as printed", refuted(entry.printed, entry.vocabulary())),)
    if not lines:
        raise LedgerError("nothing shows that the printed form fails")
    if entry.is_sentence:
        return lines
    is_notation = differ_in_notation_only(entry.printed, entry.corrected)
    if is_notation != (entry.verdict == "notation"):
        extent = "only in notation" if is_notation else "in more than notation"
        raise LedgerError(f"the verdict is {entry.verdict}, yet the two forms differ {extent}")
    return lines


def _true_form(entry: Entry) -> tuple[Line, ...]:
    lines: tuple[Line, ...] = ()
    if entry.vocabulary is not None:
        text = "corrected" if entry.corrected else "as printed"
        lines = tuple(
            Line(text, finding) for finding in proved(entry.true_form, entry.vocabulary())
        )
    lines += tuple(_run(check) for check in entry.checks)
    if not lines:
        raise LedgerError("nothing proves it")
    return lines


def _run(check: Check) -> Line:
    try:
        return Line(check.statement, check.run())
    except LedgerError as problem:
        raise LedgerError(f"{check.statement}: {problem}") from None


def proved(latex: str, vocabulary: Vocabulary) -> list[str]:
    """Prove every equality of a formula.

    Returns
    -------
    list of str
        What was seen, a line for each equality.

    Raises
    ------
    LedgerError
        Two sides differ, or the formula cannot be read.
    """
    lines = []
    for statement in parse(latex):
        sides = _values(statement, vocabulary)
        compared = _compared(statement, sides)
        for k, (left, right) in enumerate(pairwise(compared), 1):
            label = f"sides {k} and {k + 1} of {len(sides)}"
            compare = order if statement.relations[k - 1] == "\\leq" else equality
            lines.append(f"{label}: {compare(vocabulary, left, right)}")
    if not lines:
        raise LedgerError("the formula has no two sides to compare")
    return lines


def refuted(latex: str, vocabulary: Vocabulary) -> str:
    """Show that a formula cannot be read or formed, or that two of its sides differ.

    Raises
    ------
    LedgerError
        The formula holds.
    """
    try:
        for statement in parse(latex):
            sides = _compared(statement, _values(statement, vocabulary))
            for k, (left, right) in enumerate(pairwise(sides), 1):
                witness = difference(vocabulary, left, right)
                if witness:
                    return f"sides {k} and {k + 1} differ: {witness}"
    except FormulaError as problem:
        return f"cannot be formed: {problem}"
    raise LedgerError("the printed form holds")


def _values(statement: Statement, vocabulary: Vocabulary) -> list[Value]:
    """Values of the sides; of a replacement ``x ← …`` the new one."""
    sides = list(statement.sides)
    if "\\leftarrow" in statement.relations:
        sides[0] = SymbolName(f"new {sides[0]}")
    return [vocabulary.value(side) for side in sides]


def _compared(statement: Statement, sides: list[Value]) -> list[Value]:
    """Leave out a zero at the end of a chain: it states a constraint, not an identity.

    A zero that is all that follows is compared, and is as large as what it equals.
    """
    if statement.sides[-1] != Numeral("0"):
        return sides
    if len(sides) > 2:
        return sides[:-1]
    return [sides[0], ZeroMatrix(*shape(sides[0]))] if shape(sides[0]) else sides


def equality(
    vocabulary: Vocabulary, left: Scalar | SymbolicMatrix, right: Scalar | SymbolicMatrix
) -> str:
    """Prove that two values are equal for all values of the quantities.

    Raises
    ------
    FormulaError
        Their shapes differ.
    LedgerError
        They differ.
    """
    _same_shape(left, right)
    witness = difference(vocabulary, left, right)
    if witness:
        raise LedgerError(witness)
    ring = vocabulary.ring()
    pairs = list(zip(ring.cells(left), ring.cells(right), strict=True))
    for k, (a, b) in enumerate(pairs, 1):
        if not ring.is_equal(a, b):
            raise LedgerError(f"element {k} of {len(pairs)} differs")
    count = "equal" if len(pairs) == 1 else f"all {len(pairs)} elements equal"
    return f"{count}, identically"


def order(
    vocabulary: Vocabulary, left: Scalar | SymbolicMatrix, right: Scalar | SymbolicMatrix
) -> str:
    """Prove that a number is never greater than another, where all quantities are positive.

    Raises
    ------
    LedgerError
        Their difference is no polynomial whose coefficients are all positive.
    """
    difference = vocabulary.ring().scalar(as_value(right) - as_value(left))
    if not difference.denominator.is_one or any(c < 0 for c in difference.numerator.coeffs()):
        raise LedgerError("the left side may be greater")
    return "never greater, for positive quantities"


def difference(
    vocabulary: Vocabulary, left: Scalar | SymbolicMatrix, right: Scalar | SymbolicMatrix
) -> str:
    """Place where two values differ at a rational point; empty where they agree there."""
    _same_shape(left, right)
    ring = vocabulary.ring(at=rational_point(vocabulary.quantities))
    pairs = list(zip(ring.cells(left), ring.cells(right), strict=True))
    for k, (a, b) in enumerate(pairs, 1):
        if not ring.is_equal(a, b):
            label = "" if len(pairs) == 1 else f"element {k} of {len(pairs)} is "
            return f"at a rational point {label}{_shown(a)} against {_shown(b)}"
    return ""


def _same_shape(left: Scalar | SymbolicMatrix, right: Scalar | SymbolicMatrix) -> None:
    first, second = ((1, 1) if not shape(side) else shape(side) for side in (left, right))
    if first != second:
        raise FormulaError(f"one side has shape {shape(left)}, the other {shape(right)}")


def _shown(fraction: Any) -> str:
    """Number as text; one that holds roots has no short form."""
    if not fraction.numerator.is_ground or not fraction.denominator.is_ground:
        return "a number with roots"
    return str(fraction.numerator.coeff(1) / fraction.denominator.coeff(1))


def derived(package: str, function: str, output: str) -> Value:
    """Output of the code's derivation."""
    functions = {f.name: f for f in derive(package).functions}
    expressions = {o.quantity.name: o.expression for o in functions[function].outputs}
    return as_value(expressions[output])


# -- proofs that entries name -------------------------------------------------------------------

#: Proofs that the entries of every document may name.
GENERAL = Names()


class Side(NamedTuple):
    """One side of a formula, the first being 1."""

    formula: str
    number: int


@GENERAL.proof()
def equal(words: Words, left: str | Side, right: str | Side) -> str:
    """Prove that two formulas have the same value; a zero on the right is as large as the left."""
    vocabulary = words()
    return equality(vocabulary, *_values_of(vocabulary, left, right))


@GENERAL.proof()
def different(words: Words, left: str | Side, right: str | Side) -> str:
    """Prove that two formulas have different values somewhere, or cannot be compared."""
    vocabulary = words()
    try:
        witness = difference(vocabulary, *_values_of(vocabulary, left, right))
    except FormulaError as problem:
        return f"cannot be formed: {problem}"
    if not witness:
        raise LedgerError("no difference is seen")
    return witness


@GENERAL.proof()
def unreadable(words: Words, formula: str) -> str:
    """Prove that a formula cannot be formed: its shapes do not fit."""
    finding = refuted(formula, words())
    if not finding.startswith("cannot be formed"):
        raise LedgerError(f"it can be formed: {finding}")
    return finding


def _values_of(vocabulary: Vocabulary, left: str | Side, right: str | Side) -> tuple[Value, Value]:
    value, other = value_of(left, vocabulary), value_of(right, vocabulary)
    return value, ZeroMatrix(*shape(value)) if other == 0 and shape(value) else other


def value_of(formula: str | Side, vocabulary: Vocabulary, side: int = -1) -> Value:
    """Value of one side of a formula, its last one unless told."""
    text = formula.formula if isinstance(formula, Side) else formula
    number = formula.number - 1 if isinstance(formula, Side) else side
    (statement,) = parse(text)
    return vocabulary.value(statement.sides[number])
