"""Lecture 8.2: primes put back, ties to the code's C and C_q, and how many rows are independent.

Identities bound a rank from above; minors that are products of components of a′ bound it from
below. Ranks at single states are those of rational matrices.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import sympy
from sympy import Rational, S
from sympy.matrices.expressions import BlockMatrix, MatAdd, ZeroMatrix
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.ledger.documents import lecture_8_2_words
from kousoku.ledger.documents.lecture_8_2_words import offset, primed, together, words
from kousoku.ledger.parser import parse
from kousoku.ledger.priming import ways_that_agree
from kousoku.ledger.proof import equality, value_of
from kousoku.ledger.registry import Names
from kousoku.model.errors import LedgerError
from kousoku.model.mechanics.parallel_rows import ROWS, variant
from kousoku.symbolic import derive
from kousoku.symbolic.bodies import COLUMNS, COMPONENTS, SYMBOLS, A, unit_flows
from kousoku.symbolic.components import cross, dot, plus, rotate, rotate_back, subtract
from kousoku.symbolic.matrices import add, mul, neg, skew, transpose
from kousoku.symbolic.pairs import D
from kousoku.symbolic.sympy_types import as_value
from kousoku.symbolic.variation import coefficient

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.ledger.proof import Side
    from kousoku.symbolic.derivation import DerivedOutput
    from kousoku.symbolic.sympy_types import Scalar, SymbolicMatrix, Value

NAMES = Names(lecture_8_2_words.NAMES)


@NAMES.proof("side {side} with primes put back in every possible way")
def primes(count: int, side: int, formula: str, part: int = 1) -> str:
    """Prove how many of all ways to put primes make a side equal to the first.

    Parameters
    ----------
    count : int
        How many should be left: 0 where primes explain nothing, 1 where they explain all.
    side : int
        Which side, 1 being the first one.
    formula : str
        The formula; the primes that it has are taken away first.
    part : int
        Which of its statements.
    """
    statement = parse(formula.replace("'", ""))[part - 1]
    equal, tried = ways_that_agree(statement, side - 1, words(), primed)
    if equal != count:
        raise LedgerError(f"{equal} of {tried} ways to put primes agree, not {count}")
    return f"{count or 'none'} of {tried} agrees"


# -- the code ------------------------------------------------------------------------------------


@NAMES.proof("the code's d is this")
def offset_in_code(formula: str | Side) -> str:
    """Prove that the vector between the points in the code is that of a formula."""
    return equality(words(), D, value_of(formula, words()))


@cache
def outputs(package: str) -> dict[str, DerivedOutput]:
    """Outputs that the code derives of a constraint: ``C`` and ``C_q``, on both levels."""
    return {o.quantity.name: o for o in derive(package).functions[0].outputs}


def derived(package: str, output: str) -> Value:
    """``C`` or ``C_q`` as the code derives it, on the matrix level."""
    return as_value(outputs(package)[output].expression)


def selection(axis: str) -> Value:
    """Selection S, which keeps the two rows that hold the component of an axis."""
    return as_value(ImmutableDenseMatrix([[int(k == row) for k in range(3)] for row in ROWS[axis]]))


@NAMES.proof("the code's {package} has C = this")
def in_code(package: str, formula: str) -> str:
    """Prove that the code's C is that of a chain that ends in zero.

    Of p1 and p2 the code turns c into the frame of i and keeps two rows: C = S A_iᵀ c.
    """
    _, _, axis = package.partition("_")
    wanted = _turned(axis, _last(formula)) if axis else _last(formula)
    return equality(offset(), derived(package, "C"), wanted)


@NAMES.proof("the code's {package} has C = S A_iᵀ c, c being this")
def rows_in_code(package: str, formula: str) -> str:
    """Prove of two rows that the code's C is that of a chain that ends in zero."""
    return in_code(package, formula)


@NAMES.proof("the code's {package} has C_q δq = this")
def varied_in_code(package: str, formula: str) -> str:
    """Prove that the code's C_q is that of a chain that ends in zero.

    Of p1 and p2 the rows are turned: δ(A_iᵀ c) = A_iᵀ δc − δθ̃′ A_iᵀ c, whose last term vanishes
    where c = 0.
    """
    return equality(offset(), derived(package, "C_q"), _jacobian_of(package, formula))


@NAMES.proof("the code's {package} has C_q δq = S (A_iᵀ δc − δθ̃′ A_iᵀ c), δc being this")
def varied_rows_in_code(package: str, formula: str) -> str:
    """Prove of two rows that the code's C_q is that of a chain that ends in zero."""
    return varied_in_code(package, formula)


def _last(latex: str) -> Value:
    """Last side of a chain before its zero."""
    return value_of(latex, words(), -2)


def _turned(axis: str, x: Scalar | SymbolicMatrix) -> Value:
    """Product S A_iᵀ x, term by term."""
    terms = x.args if isinstance(x, MatAdd) else (x,)
    return as_value(add(*(mul(selection(axis), transpose(A["i"]), term) for term in terms)))


def _jacobian_of(package: str, latex: str) -> Value:
    """Coefficients of δr^i, δθ′^i, δr^j, δθ′^j side by side."""
    kind, _, axis = package.partition("_")
    blocks = []
    for column in COLUMNS:
        block = coefficient(_last(latex), column.delta)
        if axis:
            block = _turned(axis, block)
        if axis and column.name == "θ_i":  # −δθ̃′ A_iᵀ c
            turned_c = mul(transpose(A["i"]), words().meanings[f"C^({kind})"])
            block = add(block, mul(selection(axis), skew(turned_c)))
        blocks.append(block)
    return as_value(BlockMatrix([blocks]))


# -- states --------------------------------------------------------------------------------------

_AXES = {"i": (Rational(1, 2), S(3), S(-2)), "j": (S(1), Rational(-5, 3), S(4))}


def _state(**changes: Sequence[Scalar]) -> dict[Scalar, Scalar]:
    """Rational values of all inputs, with Euler parameters of norm one."""
    values: dict[str, Sequence[Scalar]] = {
        "p_i": [Rational(n, 9) for n in (2, 4, 5, 6)],
        "p_j": [Rational(n, 11) for n in (1, 2, -4, 10)],
        "r_i": (S(1), S(0), Rational(2, 3)),
        "r_j": (S(4), S(-3), S(2)),
        "a_i_b": _AXES["i"],
        "a_j_b": _AXES["j"],
        "s_i_b": (S(1), S(2), Rational(3, 7)),
        "s_j_b": (S(-2), S(1), S(5)),
        **changes,
    }
    return {
        s: value
        for name, numbers in values.items()
        for s, value in zip(COMPONENTS[name], numbers, strict=True)
    }


def _of(state: Mapping[Scalar, Scalar], name: str) -> list[Scalar]:
    return [state[s] for s in COMPONENTS[name]]


def satisfied(kind: str, factor: int = 3) -> dict[Scalar, Scalar]:
    """State where p1 or p2 holds: the second vector is ``factor`` times a of body i."""
    state = _state()
    along = [factor * x for x in rotate(_of(state, "p_i"), _of(state, "a_i_b"))]
    if kind == "p1":
        return _state(a_j_b=rotate_back(_of(state, "p_j"), along))
    arms = [rotate(_of(state, f"p_{b}"), _of(state, f"s_{b}_b")) for b in "ij"]
    at_i = plus(_of(state, "r_i"), arms[0])
    return _state(r_j=subtract(plus(at_i, along), arms[1]))


@cache
def _equations(kind: str, frame: str) -> tuple[Scalar, ...]:
    """Equations of p1 or p2, all three, rows in frame O or in the frame of i."""
    x = COMPONENTS
    a, points = [], []
    for b in "ij":
        a.append(rotate(x[f"p_{b}"], x[f"a_{b}_b"]))
        points.append(plus(x[f"r_{b}"], rotate(x[f"p_{b}"], x[f"s_{b}_b"])))
    other = a[1] if kind == "p1" else subtract(points[1], points[0])
    if frame == "O":
        return tuple(cross(a[0], other))
    return tuple(cross(x["a_i_b"], rotate_back(x["p_i"], other)))


@cache
def _jacobian(kind: str, frame: str) -> Any:
    flows = unit_flows()
    return sympy.Matrix([[flow(c) for flow in flows] for c in _equations(kind, frame)])


def rank(
    kind: str, frame: str, state: Mapping[Scalar, Scalar], rows: Sequence[int] = (0, 1, 2)
) -> int:
    """Rank of rows of C_q at a rational state."""
    return int(_jacobian(kind, frame).extract(list(rows), list(range(12))).xreplace(state).rank())


def _require(what: str, got: object, wanted: object) -> None:
    if got != wanted:
        raise LedgerError(f"{what} is {got}, not {wanted}")


# -- counts --------------------------------------------------------------------------------------


@NAMES.proof("the number of rows of the code's {kind}")
def counted(kind: str, count: int) -> str:
    """Prove that the code's constraint has as many rows, all independent."""
    packages = [kind] if kind.startswith("n") else [f"{kind}_{axis}" for axis in ROWS]
    for package in packages:
        _require(f"the number of rows of {package}", derived(package, "C").shape, (count, 1))
        _require(f"its rank where {kind} holds", _code_rank(package, kind), count)
    return f"{count}, and so is the rank of C_q where it holds"


def _code_rank(package: str, kind: str) -> int:
    """Rank of the code's C_q, from its component level, where the constraint holds."""
    output = outputs(package)["C_q"]
    jacobian = output.components.reshape(output.quantity.shape[0], 12)
    return int(jacobian.xreplace(_holding(kind)).rank())


def _holding(kind: str) -> dict[Scalar, Scalar]:
    """State where a constraint holds; n1 and n2 are turned about a."""
    if kind.startswith("p"):
        return satisfied(kind)
    state = _state()
    a = rotate(_of(state, "p_i"), _of(state, "a_i_b"))
    across = cross(a, [S(1), S(2), S(3)])
    if kind == "n1":
        return _state(a_j_b=rotate_back(_of(state, "p_j"), across))
    arms = [rotate(_of(state, f"p_{b}"), _of(state, f"s_{b}_b")) for b in "ij"]
    return _state(r_j=subtract(plus(plus(_of(state, "r_i"), arms[0]), across), arms[1]))


@NAMES.proof("the rank of the Jacobian of all three equations of {kind}")
def ranks(kind: str) -> str:
    """Prove the rank of all three rows, where the constraint holds and elsewhere."""
    there, elsewhere = satisfied(kind), _state()
    for frame in ("O", "i"):
        values = [c.xreplace(there) for c in _equations(kind, frame)]
        _require("C", [sympy.nsimplify(value) for value in values], [0, 0, 0])
        _require(f"the rank, rows in frame {frame}", rank(kind, frame, there), 2)
    _require("the rank off C = 0, rows in frame i", rank(kind, "i", elsewhere), 2)
    _require("the rank off C = 0, rows in frame O", rank(kind, "O", elsewhere), 3)
    return "2 in frame O and in frame i where C = 0; off it 2 in frame i, 3 in frame O"


@NAMES.proof("with {vector} = 0")
def vanishing(kind: str, vector: str) -> str:
    """Prove that without a vector, such as a^i, the three equations say nothing at all."""
    letter, _, of_body = vector.partition("^")
    state = _state(**{f"{letter}_{of_body}_b": (S(0), S(0), S(0))})
    values = [c.xreplace(state) for c in _equations(kind, "O")]
    _require("C", values, [0, 0, 0])
    _require("the rank", rank(kind, "O", state), 0)
    return "C = 0 whatever the rest, and the rank of C_q is 0"


# -- which two rows ------------------------------------------------------------------------------


def _skew(v: Sequence[Scalar]) -> Any:
    columns = [cross(v, [S(int(k == n)) for k in range(3)]) for n in range(3)]
    return sympy.Matrix(columns).T


def _minors(rows: Any) -> list[Scalar]:
    """Minors 2×2 of two rows, that without column x first."""
    return [
        sympy.expand(rows.extract([0, 1], [k for k in range(3) if k != n]).det()) for n in range(3)
    ]


@NAMES.proof("the 2×2 minors of the rows of ã′ that hold a′_{axis}")
def minors(axis: str) -> str:
    """Prove that the kept rows of ã′ have rank 2 where a′ of the axis is not 0.

    Their 2×2 minors are ± the component of the axis times each component.
    """
    minors_are(_skew(COMPONENTS["a_i_b"]), axis, S.One)
    return f"± a′_{axis} (a′_x, a′_y, a′_z)"


@NAMES.proof("the 2×2 minors of the rows of ã′² that hold a′_{axis}")
def minors_of_square(axis: str) -> str:
    """Prove the same of ã′², where the minors are a′·a′ times as large."""
    a = COMPONENTS["a_i_b"]
    minors_are(_skew(a) ** 2, axis, dot(a, a))
    return f"± a′_{axis} (a′_x, a′_y, a′_z) a′·a′"


def minors_are(matrix: Any, axis: str, factor: Scalar) -> None:
    """Prove that the minors of the rows of an axis are ± a′ of the axis times a′, and a factor.

    Raises
    ------
    LedgerError
        A minor is another one.
    """
    a = COMPONENTS["a_i_b"]
    own = a["xyz".index(axis)] * factor
    kept = matrix.extract(list(ROWS[axis]), [0, 1, 2])
    for found, component in zip(_minors(kept), a, strict=True):
        if sympy.expand(found**2 - (own * component) ** 2) != 0:
            raise LedgerError(f"a minor is {found}")


@NAMES.proof()
def without_bars() -> str:
    """Choose by the largest number instead of the largest absolute value: the rank falls."""
    axis = (S(-3), S(0), S(0))
    largest = "xyz"[axis.index(max(axis))]
    kept = _skew(axis).extract(list(ROWS[largest]), [0, 1, 2])
    _require("the rank of the two rows", kept.rank(), 1)
    return f"a′ = (−3, 0, 0) has its largest number in {largest}; those two rows have rank 1"


@NAMES.proof()
def code_takes_largest() -> str:
    """Ask the code for the rows that it keeps, for components of either sign."""
    for axis, wanted in (((-3, 1, 2), "x"), ((1, -4, 2), "y"), ((0, 1, -2), "z")):
        for kind in ("p1", "p2"):
            _require(f"the rows for {axis}", variant(kind, axis), f"{kind}_{wanted}")
    return "(−3, 1, 2) gives x, (1, −4, 2) gives y, (0, 1, −2) gives z"


_ABOUT_DIAGONAL = [S(1) / 2] * 4  # x goes to y, y to z, z to x


@NAMES.proof()
def rows_of_another_frame() -> str:
    """Choose by components in the frame of i and keep rows in frame O: the rank falls."""
    axis = (S(1), S(0), S(0))
    state = _state(p_i=_ABOUT_DIAGONAL, a_i_b=axis)
    a = rotate(_ABOUT_DIAGONAL, axis)
    _require("a in frame O", a, [0, 1, 0])
    _require("rows of x", _skew(a).extract(list(ROWS["x"]), [0, 1, 2]).rank(), 1)
    _require("rows of y", _skew(a).extract(list(ROWS["y"]), [0, 1, 2]).rank(), 2)
    for row, frame in (("x", "i"), ("y", "O")):
        _require(f"the rank in frame {frame}", rank("p2", frame, state, ROWS[row]), 2)
    return "a′ = (1, 0, 0) turned to a = (0, 1, 0): rows of x have rank 1 in ã, rows of y rank 2"


@NAMES.proof()
def largest_in_space_changes() -> str:
    """Turn a about the diagonal: in frame O another component is the largest."""
    axis = (S(1), S(0), S(0))
    seen = []
    for p in ([S(1), S(0), S(0), S(0)], _ABOUT_DIAGONAL):
        sizes: list[Any] = [abs(x) for x in rotate(p, axis)]
        seen.append("xyz"[sizes.index(max(sizes))])
    _require("the largest component", seen, ["x", "y"])
    return "x, then y; a′ is constant, so that in the frame of i the choice is made once"


# -- blocks of the Jacobian ----------------------------------------------------------------------


@NAMES.proof()
def is_zero_at_zero_offset() -> str:
    """Prove that n2 holds where d = 0, in any attitude."""
    return equality(together(), derived("n2", "C"), ZeroMatrix(1, 1))


@NAMES.proof()
def block_at_zero_offset(column: str) -> str:
    """Prove that the block of δr^j is aᵀ where d = 0, or that of δr^i its negative."""
    row = _axis_as_row()
    place, wanted = {"r^i": (0, neg(row)), "r^j": (2, row)}[column]
    return equality(together(), _block("n2", place), wanted)


@NAMES.proof()
def size_at_zero_offset() -> str:
    """Prove that these blocks have the size of a′, which is not 0."""
    row, a = _axis_as_row(), SYMBOLS["a_i_b"]
    return equality(together(), mul(row, transpose(row)), mul(transpose(a), a))


def _axis_as_row() -> Value:
    return as_value(mul(transpose(SYMBOLS["a_i_b"]), transpose(A["i"])))


@NAMES.proof(
    "the code's {package}: the block of δθ′^i is S ã′ ṽ, v = A_iᵀ a^j; where C = 0, v = k a′"
)
def block_of_rotation(package: str) -> str:
    """Prove that a block of the code's C_q of p1 is S ã′ times a multiple of ã′ where C = 0."""
    back = mul(transpose(A["i"]), A["j"], SYMBOLS["a_j_b"])
    return _is_block(package, 1, skew(back))


@NAMES.proof("the code's {package}: the block of δr^i is −S ã′ A_iᵀ")
def block_of_translation(package: str) -> str:
    """Prove that a block of the code's C_q of p2 is S ã′ times a regular matrix."""
    return _is_block(package, 0, neg(transpose(A["i"])))


def _is_block(package: str, place: int, right: Scalar | SymbolicMatrix) -> str:
    _, _, axis = package.partition("_")
    wanted = mul(selection(axis), skew(SYMBOLS["a_i_b"]), right)
    return equality(offset(), _block(package, place), wanted)


def _block(package: str, place: int) -> Value:
    return as_value(derived(package, "C_q").blocks[0, place])
