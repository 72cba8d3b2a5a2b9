"""Yamada and Tatsumi 1981, section 4: the systems, the slider's place, and when a crank can turn.

The systems (29) and (33) are read against (15), assembled link by link. A displacement that is
known has its value behind it in parentheses. The zeros on the right stand for what must vanish:
the deformations of all links, three for each.

The slider is where the rod closes: (x − l1 cos α)² + (l1 sin α)² = l2², on the side x > 0. Its
velocity and acceleration follow by differentiating that condition, not the formula for x.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import sympy
from sympy import S, Symbol
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.ledger import find
from kousoku.ledger.documents import link_mechanisms, link_method
from kousoku.ledger.documents.link_element import column
from kousoku.ledger.documents.link_iteration import DIVISIONS, MP, RESIDUAL, run
from kousoku.ledger.documents.link_mechanisms import LEVER_CRANK, PISTON_CRANK, ExampleMechanism
from kousoku.ledger.formula import Array, FormulaNode, Numeral, Product, SymbolName
from kousoku.ledger.parser import parse
from kousoku.ledger.proof import equality, value_of
from kousoku.ledger.registry import Names
from kousoku.ledger.vocabulary import Vocabulary
from kousoku.model.errors import FormulaError, LedgerError
from kousoku.model.files.quantity import Quantity
from kousoku.symbolic.sympy_types import as_scalar, as_value

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.symbolic.sympy_types import Scalar, Value

NAMES = Names(link_mechanisms.NAMES)

#: Place, velocity and acceleration of the slider.
FORMULAS = ("30", "31", "32")
L1, L2, L3, L4, ALPHA, X = sympy.symbols("l_1 l_2 l_3 l_4 α x")
LENGTHS = tuple(Quantity(f"l_{k}", (), "m", f"length of link {k}") for k in (1, 2, 3, 4))
ANGLE = Quantity("α", (), "rad", "the crank's angle")
#: By how much the right sides of (34) are larger.
SPARE = tuple(Quantity(f"d_{k}", (), "m", f"spare length of inequality {k}") for k in (1, 2, 3))

ZERO = Numeral("0")


@dataclass(frozen=True, slots=True)
class ExampleVocabulary(Vocabulary):
    """The words of the system of a mechanism, displacements and angles of any size.

    Parameters
    ----------
    mechanism : ExampleMechanism
        Which links there are, where they meet, and what is known.
    """

    mechanism: ExampleMechanism = PISTON_CRANK

    def value(self, node: FormulaNode) -> Value:
        """Left side of the system, all products carried out, or the meaning of its zeros."""
        match node:
            case Product() if all(isinstance(factor, Array) for factor in node.factors):
                rows, cells = parts(node)
                u = [self._displacement(cell) for cell in cells]
                if len(rows[0]) != len(u):
                    raise FormulaError(f"{len(rows[0])} columns for {len(u)} displacements")
                return as_value(self.matrix(rows) * column(u))
            case Array() if all(row == (ZERO,) for row in node.rows):
                matrix = assembled(self)
                if len(node.rows) != matrix.rows:
                    raise FormulaError(f"{len(node.rows)} zeros for {matrix.rows} equations")
                return as_value(matrix * column([Symbol(name) for name in self.mechanism.names]))
        return Vocabulary.value(self, node)

    def matrix(self, rows: Sequence[Sequence[FormulaNode]]) -> ImmutableDenseMatrix:
        """Cells as a matrix."""
        return ImmutableDenseMatrix([[self.value(cell) for cell in row] for row in rows])

    def _displacement(self, cell: FormulaNode) -> Scalar:
        name, value = displacement(cell)
        if name not in self.mechanism.names:
            raise FormulaError(f"the mechanism has no displacement {name}")
        known = self.mechanism.known.get(name, "")
        if value != known:
            raise FormulaError(f"{name} is {known or 'not known'}, not {value or 'unknown'}")
        return as_scalar(Symbol(name))


def displacement(cell: FormulaNode) -> tuple[str, str]:
    """Name of a displacement and its value, empty where it is not known."""
    match cell:
        case SymbolName():
            return str(cell), ""
        case Product((SymbolName() as name, Numeral() as number)):
            return str(name), number.text
        case Product((SymbolName() as name, SymbolName() as value)):
            return str(name), str(value)
    raise FormulaError("a displacement is a symbol, with a value in parentheses where it is known")


def parts(node: FormulaNode) -> tuple[list[tuple[FormulaNode, ...]], list[FormulaNode]]:
    """Rows of the matrix, its parts joined side by side, and the displacements."""
    if not isinstance(node, Product):
        raise FormulaError("a system is a matrix times its displacements")
    *blocks, vector = (factor.rows for factor in node.factors if isinstance(factor, Array))
    if len({len(block) for block in blocks}) != 1:
        raise FormulaError("the parts of the matrix have different heights")
    rows = [sum(row, ()) for row in zip(*blocks, strict=True)]
    return rows, [cell for (cell,) in vector]


def assembled(words: ExampleVocabulary) -> ImmutableDenseMatrix:
    """Matrix (15) of each link in its three rows, in the columns of the nodes at which it ends."""

    def element(link: int) -> list[list[Scalar]]:
        of_link = {
            "β_i^0": words.meanings[f"β_{link}^0"],
            "l_i^0": words.meanings[f"l_{link}^0"],
        }
        cells: list[list[Scalar]] = value_of(find("15").printed, Vocabulary((), of_link)).tolist()
        return cells

    return ImmutableDenseMatrix(words.mechanism.assembled(element))


def _words(mechanism: ExampleMechanism) -> ExampleVocabulary:
    links = range(1, len(mechanism.links) + 1)
    names = [f"{letter}_{link}^0" for link in links for letter in "βl"]
    quantities = tuple(Quantity(name, (), "", "") for name in (*mechanism.names, *names))
    return ExampleVocabulary(
        quantities, {name: Symbol(name) for name in names}, mechanism=mechanism
    )


@NAMES.words
@cache
def piston() -> ExampleVocabulary:
    """Words of (29)."""
    return _words(PISTON_CRANK)


@NAMES.words
@cache
def lever() -> ExampleVocabulary:
    """Words of (33)."""
    return _words(LEVER_CRANK)


# -- what is wrong with a system -----------------------------------------------------------------


def faults_of(latex: str, words: ExampleVocabulary) -> list[str]:
    """Faults that make a printed system another one than that of the mechanism."""
    (statement,) = parse(latex)
    left, right = statement.sides
    rows, cells = parts(left)
    zeros = len(right.rows) if isinstance(right, Array) else 0
    wanted, names = assembled(words), words.mechanism.names
    found = _wrong_names([displacement(cell) for cell in cells], words.mechanism)
    if len(rows[0]) != len(names):
        found.append(f"{len(rows[0])} columns for {len(names)} displacements")
    for number, row in enumerate(rows[: wanted.rows]):
        values: list[Scalar] = [words.value(cell) for cell in row]
        values += [S.Zero] * (len(names) - len(row))
        found += _wrong_cells(number + 1, values, list(wanted.row(number)), names)
    if len(rows) > wanted.rows:
        found.append(f"rows {wanted.rows + 1} to {len(rows)} are of no link of this mechanism")
    if zeros != len(rows):
        found.append(f"{zeros} zeros for {len(rows)} rows")
    return found


def _wrong_names(cells: Sequence[tuple[str, str]], mechanism: ExampleMechanism) -> list[str]:
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


@NAMES.proof("as printed, beside the assembly of (15)")
def has_faults(mechanism: str, formula: str, faults: Sequence[str]) -> str:
    """Prove that the printed system of a mechanism has exactly these faults."""
    found = faults_of(formula, {"piston": piston, "lever": lever}[mechanism]())
    if found != list(faults):
        raise LedgerError(f"its faults are {'; '.join(found) or 'none'}")
    return "; ".join(found)


@NAMES.proof("rows {first} and on, beside those of the other system")
def rows_are_those_of(other: str, first: int, formula: str) -> str:
    """Prove that the rows from one on are those of another printed system's first part."""
    rows, _ = parts(parse(formula)[0].sides[0])
    source, _ = parts(parse(find(other).printed)[0].sides[0])
    width = 8
    same = [
        row[:width] == twin[:width] and set(row[width:]) == {ZERO}
        for row, twin in zip(rows[first - 1 :], source[first - 1 :], strict=True)
    ]
    if not all(same):
        raise LedgerError("they are other rows")
    return f"the same as in the first {width} columns there, and zeros"


# -- the slider ----------------------------------------------------------------------------------


def _closure(x: Scalar) -> Scalar:
    """Residual of the rod's length squared."""
    c, s = sympy.cos(ALPHA), sympy.sin(ALPHA)
    return as_scalar((x - L1 * c) ** 2 + (L1 * s) ** 2 - L2**2)


def slider() -> tuple[Scalar, Scalar, Scalar]:
    """Place, velocity and acceleration of the slider for dα/dt = 1, d²α/dt² = 0."""
    missed = sympy.Poly(sympy.expand(_closure(X)), X)
    square, linear, constant = missed.all_coeffs()
    half = -linear / (2 * square)
    place = half + sympy.sqrt(half**2 - constant / square)  # the larger root
    closure = _closure(X)
    slope = -closure.diff(ALPHA) / closure.diff(X)
    curve = slope.diff(ALPHA) + slope.diff(X) * slope
    at = {X: place}
    return place, slope.xreplace(at), curve.xreplace(at)


@NAMES.words
@cache
def words() -> Vocabulary:
    """Words of (30) to (32)."""
    names = ("x座標", "x座標方向の速度", "x座標方向の加速度")
    meanings = dict(zip(names, slider(), strict=True))
    meanings |= {"l_1": L1, "l_2": L2, "α": ALPHA}
    return Vocabulary((*LENGTHS[:2], ANGLE), meanings)


@NAMES.proof()
def closes(formula: str) -> str:
    """Put (30) into the condition that the rod closes."""
    seen = equality(words(), _closure(value_of(formula, words())), S.Zero)
    other = L1 * sympy.cos(ALPHA) - sympy.sqrt(L2**2 - L1**2 * sympy.sin(ALPHA) ** 2)
    product = equality(words(), value_of(formula, words()) * other, L1**2 - L2**2)
    return f"{seen}; with l1 < l2 the two roots have different signs, their product {product}"


# -- the computed motion -------------------------------------------------------------------------


@NAMES.proof()
def steps_end_small(mechanism: str) -> dict[str, bool]:
    """Look at the residuals of a turn."""
    done = run(mechanism)
    text = f"{len(done.corrections)} steps end with at most {done.residual:.1e} cm"
    return {text: len(done.corrections) == DIVISIONS and done.residual <= float(RESIDUAL)}


def counted_in(sentence: str) -> tuple[int, int]:
    """Numbers of iterations that a sentence states: ``6回~7回``, or ``10回``."""
    numbers = [int(number) for number in re.findall(r"(\d+)回", sentence)]
    return numbers[0], numbers[-1]


@NAMES.proof()
def takes(mechanism: str, formula: str, is_true: bool) -> str:
    """Prove that a sentence states how many corrections a turn takes, or does not."""
    least, most = run(mechanism).range
    if ((least, most) == counted_in(formula)) is not is_true:
        raise LedgerError(f"it takes {least} to {most}")
    return _counted(least, most)


@NAMES.proof()
def takes_when_renewed(mechanism: str, passes: tuple[int, int]) -> str:
    """Count the passes of an iteration that renews x″ as well."""
    least, most = run(mechanism, renews=True).range
    if [least + 1, most + 1] != list(passes):
        raise LedgerError(f"it takes {least} to {most} corrections")
    return f"corrections {_counted(least, most)}, passes {_counted(*passes)}"


def _counted(least: int, most: int) -> str:
    return f"{least} to {most}" if least < most else f"{least} at every step"


@NAMES.proof()
def agrees() -> dict[str, bool]:
    """Compare the computed slider with (30) to (32) at all 61 positions."""
    lengths = {L1: S(PISTON_CRANK.lengths[0]), L2: S(PISTON_CRANK.lengths[1])}
    formulas = [value_of(find(key).printed, words()).xreplace(lengths) for key in FORMULAS]
    column = PISTON_CRANK.names.index("u_3")
    worst = [0.0, 0.0, 0.0]
    for k, state in enumerate(run("piston").states):
        angle = sympy.Float(str(2 * MP.pi * k / DIVISIONS), MP.dps)
        for order, (formula, motion) in enumerate(zip(formulas, state, strict=True)):
            exact = formula.evalf(MP.dps, subs={ALPHA: angle})
            apart = abs(float(exact - sympy.Float(str(motion[column]), MP.dps)))
            worst[order] = max(worst[order], apart)
    names = ("place", "velocity", "acceleration")
    return {
        f"{name} within {error:.0e}": error < 1e-12
        for name, error in zip(names, worst, strict=True)
    }


@NAMES.proof()
def rates_are_slopes() -> str:
    """Put dα/dt = 1 and d²α/dt² = 0 into velocity and acceleration."""
    known = link_method.words()
    unit = {link_method.RATE: S.One, link_method.ACCELERATION: S.Zero}
    pairs = (("d/dt x", "x'"), ("d²/dt² x", "x''"))
    seen = [equality(known, known.meanings[a].xreplace(unit), known.meanings[b]) for a, b in pairs]
    return f"velocity is x′, {seen[0]}; acceleration is x″, {seen[1]}"


# -- when a crank can turn -----------------------------------------------------------------------


@NAMES.words
@cache
def turning() -> Vocabulary:
    """Words of (34): lengths by how much shorter the left sides are, none negative."""
    first, second, third = (Symbol(q.name) for q in SPARE)
    meanings = {
        "l_1": L1,
        "l_2": L1 + (second + third) / 2,
        "l_3": L1 + (first + third) / 2,
        "l_4": L1 + (first + second) / 2,
    }
    return Vocabulary((LENGTHS[0], *SPARE), meanings)


def _spare() -> list[Scalar]:
    """Right sides of (34) less the left ones, for any lengths."""
    meanings = {"l_1": L1, "l_2": L2, "l_3": L3, "l_4": L4}
    known = Vocabulary(LENGTHS, meanings)
    return [
        known.value(right) - known.value(left)
        for left, right in (statement.sides for statement in parse(find("34").printed))
    ]


@NAMES.proof()
def full_turn() -> dict[str, bool]:
    """Follow the distance of O2 from O4, between which coupler and lever must reach."""
    first, second, third = _spare()
    farthest = (L2 + L3) ** 2 - (L1 + L4) ** 2
    nearest = (L1 - L4) ** 2 - (L2 - L3) ** 2
    whole = L1 + L2 + L3 + L4
    sums = (
        (first + second, 2 * (L4 - L1)),
        (first + third, 2 * (L3 - L1)),
        (second + third, 2 * (L2 - L1)),
    )
    return {
        "farthest, at α = π: (l2 + l3)² − (l1 + l4)² is the spare length of the third inequality"
        " times the sum of all lengths": sympy.expand(farthest - third * whole) == 0,
        "nearest, at α = 0: (l4 − l1)² − (l2 − l3)² is the product of the other two, which are"
        " both positive where l1 < l4": sympy.expand(nearest - first * second) == 0,
        "the sums of any two are twice l4 − l1, l3 − l1, l2 − l1: l1 is the shortest link": all(
            sympy.expand(one - other) == 0 for one, other in sums
        ),
    }


@NAMES.proof()
def without_it() -> dict[str, bool]:
    """Look at a mechanism whose frame is shorter than its crank: it turns, and (34) fails."""
    lengths = {L1: S(60), L2: S(80), L3: S(100), L4: S(30)}
    turns = abs(80 - 100) <= abs(60 - 30) and 60 + 30 <= 80 + 100
    failing = [spare.xreplace(lengths) < 0 for spare in _spare()]
    return {
        "60, 80, 100 and a frame of 30: both cranks turn, the first two fail": turns
        and failing == [True, True, False]
    }


@NAMES.proof()
def is_strict() -> dict[str, bool]:
    """Put in the lengths of the example: the links are never all in line."""
    lengths = dict(zip((L1, L2, L3, L4), map(S, LEVER_CRANK.lengths), strict=True))
    spare = [int(s.xreplace(lengths)) for s in _spare()]
    shown = ", ".join(str(s) for s in spare)
    return {f"30, 60, 80, 100 leave {shown} cm to spare": spare == [90, 50, 10]}
