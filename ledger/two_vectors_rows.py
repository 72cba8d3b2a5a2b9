"""How many rows of p1 and p2 are independent, and which: ranks, exact.

Identities bound a rank from above; minors that are products of components of a′ bound it from
below. Ranks at single states are those of rational matrices.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import sympy
from sympy import Rational, S
from sympy.matrices.expressions import ZeroMatrix

from kousoku.ledger.checks import equal
from kousoku.ledger.entry import Check
from kousoku.ledger.two_vectors import offset
from kousoku.ledger.two_vectors_code import derived, outputs, packages, selection
from kousoku.model.errors import LedgerError
from kousoku.model.rows import ROWS, variant
from kousoku.symbolic.bodies import COMPONENTS, SYMBOLS, A, unit_flows
from kousoku.symbolic.components import cross, dot, plus, rotate, rotate_back, subtract
from kousoku.symbolic.matrices import elements, mul, neg, skew, transpose

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kousoku.ledger.vocabulary import Value, Vocabulary

Scalar = Any

_AXES = {"i": (Rational(1, 2), S(3), S(-2)), "j": (S(1), Rational(-5, 3), S(4))}


def _state(**changes: Sequence[Scalar]) -> dict[Scalar, Scalar]:
    """Return rational values of all inputs, with Euler parameters of norm one."""
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
    """Return a state where p1 or p2 holds: the second vector is ``factor`` times a of body i."""
    state = _state()
    along = [factor * x for x in rotate(_of(state, "p_i"), _of(state, "a_i_b"))]
    if kind == "p1":
        return _state(a_j_b=rotate_back(_of(state, "p_j"), along))
    arms = [rotate(_of(state, f"p_{b}"), _of(state, f"s_{b}_b")) for b in "ij"]
    at_i = plus(_of(state, "r_i"), arms[0])
    return _state(r_j=subtract(plus(at_i, along), arms[1]))


@cache
def _equations(kind: str, frame: str) -> tuple[Scalar, ...]:
    """Return all three equations of p1 or p2, rows in frame O or in the frame of i."""
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
    """Return the rank of rows of C_q at a rational state."""
    return int(_jacobian(kind, frame).extract(list(rows), list(range(12))).xreplace(state).rank())


def _require(what: str, got: object, wanted: object) -> None:
    if got != wanted:
        raise LedgerError(f"{what} is {got}, not {wanted}")


# -- counts --------------------------------------------------------------------------------------


def counted(kind: str, count: int) -> Check:
    """Return the check that the code's constraint has as many rows, all independent."""

    def run() -> str:
        for package, _ in packages(kind):
            _require(f"the number of rows of {package}", derived(package, "C").shape, (count, 1))
            _require(f"its rank where {kind} holds", _code_rank(package, kind), count)
        return f"{count}, and so is the rank of C_q where it holds"

    return Check(f"the number of rows of the code's {kind}", run)


def _code_rank(package: str, kind: str) -> int:
    """Return the rank of the code's C_q, from its component level, where the constraint holds."""
    output = outputs(package)["C_q"]
    jacobian = output.components.reshape(output.quantity.shape[0], 12)
    return int(jacobian.xreplace(_holding(kind)).rank())


def _holding(kind: str) -> dict[Scalar, Scalar]:
    """Return a state where a constraint holds; n1 and n2 are turned about a."""
    if kind.startswith("p"):
        return satisfied(kind)
    state = _state()
    a = rotate(_of(state, "p_i"), _of(state, "a_i_b"))
    across = cross(a, [S(1), S(2), S(3)])
    if kind == "n1":
        return _state(a_j_b=rotate_back(_of(state, "p_j"), across))
    arms = [rotate(_of(state, f"p_{b}"), _of(state, f"s_{b}_b")) for b in "ij"]
    return _state(r_j=subtract(plus(plus(_of(state, "r_i"), arms[0]), across), arms[1]))


def ranks(kind: str) -> Check:
    """Return the check of the rank of all three rows, where the constraint holds and elsewhere."""

    def run() -> str:
        there, elsewhere = satisfied(kind), _state()
        for frame in ("O", "i"):
            values = [c.xreplace(there) for c in _equations(kind, frame)]
            _require("C", [sympy.nsimplify(value) for value in values], [0, 0, 0])
            _require(f"the rank, rows in frame {frame}", rank(kind, frame, there), 2)
        _require("the rank off C = 0, rows in frame i", rank(kind, "i", elsewhere), 2)
        _require("the rank off C = 0, rows in frame O", rank(kind, "O", elsewhere), 3)
        return "2 in frame O and in frame i where C = 0; off it 2 in frame i, 3 in frame O"

    return Check(f"the rank of the Jacobian of all three equations of {kind}", run)


def vanishing(kind: str, name: str) -> Check:
    """Return the check that without a vector the three equations say nothing at all."""

    def run() -> str:
        state = _state(**{name: (S(0), S(0), S(0))})
        values = [c.xreplace(state) for c in _equations(kind, "O")]
        _require("C", values, [0, 0, 0])
        _require("the rank", rank(kind, "O", state), 0)
        return "C = 0 whatever the rest, and the rank of C_q is 0"

    return Check(f"with {name.replace('_b', '').replace('_', '^')} = 0", run)


# -- which two rows ------------------------------------------------------------------------------


def _skew(v: Sequence[Scalar]) -> Any:
    columns = [cross(v, [S(int(k == n)) for k in range(3)]) for n in range(3)]
    return sympy.Matrix(columns).T


def _minors(rows: Any) -> list[Scalar]:
    """Return the 2×2 minors of two rows, that without column x first."""
    return [
        sympy.expand(rows.extract([0, 1], [k for k in range(3) if k != n]).det()) for n in range(3)
    ]


def minors(axis: str, power: int) -> Check:
    """Return the check that the kept rows of ã′ or ã′² have rank 2 where a′ of the axis is not 0.

    Their 2×2 minors are ± the component of the axis times each component, and times a′·a′ for ã′².
    """

    def run() -> str:
        a = COMPONENTS["a_i_b"]
        kept = (_skew(a) ** power).extract(list(ROWS[axis]), [0, 1, 2])
        own = a["xyz".index(axis)] * (dot(a, a) if power == 2 else 1)
        for found, component in zip(_minors(kept), a, strict=True):
            if sympy.expand(found**2 - (own * component) ** 2) != 0:
                raise LedgerError(f"a minor is {found}")
        return f"± a′_{axis} (a′_x, a′_y, a′_z)" + " a′·a′" * (power == 2)

    return Check(f"the 2×2 minors of the rows of ã′{'²' * (power == 2)} that hold a′_{axis}", run)


def only_where_largest() -> tuple[Check, ...]:
    """Return the checks of the rule: the axis, its absolute value, and one frame for both."""
    return (
        Check("the code takes the largest absolute value", _code_rule),
        Check("rows in frame O, chosen by components in frame i", _two_frames),
        Check("the largest component of a in frame O while body i turns", _changing),
    )


def without_bars() -> str:
    """Choose by the largest number instead of the largest absolute value: the rank falls."""
    axis = (S(-3), S(0), S(0))
    largest = "xyz"[axis.index(max(axis))]
    kept = _skew(axis).extract(list(ROWS[largest]), [0, 1, 2])
    _require("the rank of the two rows", kept.rank(), 1)
    return f"a′ = (−3, 0, 0) has its largest number in {largest}; those two rows have rank 1"


def _code_rule() -> str:
    for axis, wanted in (((-3, 1, 2), "x"), ((1, -4, 2), "y"), ((0, 1, -2), "z")):
        for kind in ("p1", "p2"):
            _require(f"the rows for {axis}", variant(kind, axis), f"{kind}_{wanted}")
    return "(−3, 1, 2) gives x, (1, −4, 2) gives y, (0, 1, −2) gives z"


_ABOUT_DIAGONAL = [S(1) / 2] * 4  # x goes to y, y to z, z to x


def _two_frames() -> str:
    axis = (S(1), S(0), S(0))
    state = _state(p_i=_ABOUT_DIAGONAL, a_i_b=axis)
    a = rotate(_ABOUT_DIAGONAL, axis)
    _require("a in frame O", a, [0, 1, 0])
    _require("rows of x", _skew(a).extract(list(ROWS["x"]), [0, 1, 2]).rank(), 1)
    _require("rows of y", _skew(a).extract(list(ROWS["y"]), [0, 1, 2]).rank(), 2)
    for row, frame in (("x", "i"), ("y", "O")):
        _require(f"the rank in frame {frame}", rank("p2", frame, state, ROWS[row]), 2)
    return "a′ = (1, 0, 0) turned to a = (0, 1, 0): rows of x have rank 1 in ã, rows of y rank 2"


def _changing() -> str:
    axis = (S(1), S(0), S(0))
    seen = []
    for p in ([S(1), S(0), S(0), S(0)], _ABOUT_DIAGONAL):
        sizes = [abs(x) for x in rotate(p, axis)]
        seen.append("xyz"[sizes.index(max(sizes))])
    _require("the largest component", seen, ["x", "y"])
    return "x, then y; a′ is constant, so that in the frame of i the choice is made once"


# -- d = 0 ---------------------------------------------------------------------------------------


@cache
def together() -> Vocabulary:
    """Return the words with both points in one place: r^j = r^i + s_i − s_j, and d = 0."""
    known = offset()
    d = elements(next(q for q in known.quantities if q.name == "d"))
    zero = dict.fromkeys(d, S.Zero)
    given = {name: [x.xreplace(zero) for x in value] for name, value in known.given.items()}
    return replace(known, given={**given, "d": [S.Zero] * 3})


def at_zero_offset() -> tuple[Check, ...]:
    """Return the checks that n2 holds where d = 0, with an independent row."""
    a = SYMBOLS["a_i_b"]
    row = mul(transpose(a), transpose(A["i"]))

    return (
        equal(
            "where d = 0, C = 0 in any attitude",
            together,
            partial(derived, "n2", "C"),
            lambda: ZeroMatrix(1, 1),
        ),
        equal("there the block of δr^j is aᵀ", together, partial(_block, "n2", 2), lambda: row),
        equal("and that of δr^i is −aᵀ", together, partial(_block, "n2", 0), lambda: neg(row)),
        equal(
            "|aᵀ|² = a′·a′, so that the rank of C_q is 1",
            together,
            lambda: mul(row, transpose(row)),
            lambda: mul(transpose(a), a),
        ),
    )


def blocks_with_minors(kind: str) -> tuple[Check, ...]:
    """Return the checks that a block of the code's C_q is S ã′ or S ã′ ã′ times a regular matrix.

    Of p1 it is that of δθ′^i, where A_iᵀ a^j is a multiple of a′; of p2 that of δr^i.
    """
    a, back = SYMBOLS["a_i_b"], transpose(A["i"])
    if kind == "p1":
        text, place = "δθ′^i is S ã′ ṽ, v = A_iᵀ a^j; where C = 0, v = k a′", 1
        right = skew(mul(back, A["j"], SYMBOLS["a_j_b"]))
    else:
        text, place, right = "δr^i is −S ã′ A_iᵀ", 0, neg(back)
    return tuple(
        equal(
            f"the code's {package}: the block of {text}",
            offset,
            partial(_block, package, place),
            partial(mul, selection(axis), skew(a), right),
        )
        for package, axis in packages(kind)
    )


def _block(package: str, place: int) -> Value:
    return derived(package, "C_q").blocks[0, place]
