"""The length of the line between two points: the coordinate that a rod keeps and a driver moves.

Where the points coincide, d = 0, the length is zero and the line has no direction: |d| has a kink
and no derivative. The Jacobian is then zero, and so is the reaction: a force along the length does
nothing at that moment, and a driver of it is refused there. The rate of points that pass through
each other jumps from −|ḋ| to |ḋ|, so that γ is minus infinity; it is zero where ḋ is. The
derivative of the reaction is not finite. Squares underflow where |d| is below 10⁻¹⁵⁴ m: no digit of
a shorter length is right.

No form subtracts the part along the line from a whole vector, or n nᵀ from the identity: parts
across the line are computed by themselves.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import sympy
from sympy.matrices.expressions import Identity, MatrixSymbol

from kousoku.symbolic.bodies import COLUMNS, DELTA, RATE
from kousoku.symbolic.components import dot
from kousoku.symbolic.constraint import derive_constraint
from kousoku.symbolic.derivation import Step
from kousoku.symbolic.forms import (
    ClosedForm,
    Constraint,
    Plain,
    blocks_of,
    curvature,
    less_products,
    name_blocks,
    name_lines,
)
from kousoku.symbolic.joints import (
    GAMMA_RULE,
    half_square_curvature,
    own_point_drops,
    point_offset,
    turning_curvature,
)
from kousoku.symbolic.matrices import (
    Divisor,
    Dot,
    NamedMatrix,
    NamedScalar,
    add,
    mul,
    neg,
    skew,
    transpose,
)
from kousoku.symbolic.spring import ALONG, FROM_OWN_ORIGIN, INVERSE, OF_BODY, RELATIVE, D, L

if TYPE_CHECKING:
    from kousoku.symbolic.derivation import Derivation
    from kousoku.symbolic.sympy_types import SymbolicMatrix

    Blocks = tuple[SymbolicMatrix, ...]

#: Rate of d, and its second without accelerations.
RATES = (NamedMatrix("d_dot", RATE(D)), NamedMatrix("d_ddot", curvature(D)))
#: d·w, in which no point meets its own rate.
BY_POINTS = add(
    mul(transpose(RELATIVE["r"]), RELATIVE["w"]),
    mul(transpose(RELATIVE["omega"]), skew(OF_BODY["i"]["s"]), OF_BODY["j"]["s"]),
)
#: One divided by l, infinite where l is zero.
CURVED = NamedScalar("c", 1 / Divisor(L))
#: Values where the points coincide and stay so.
AT_POLE = {"C": 0.0, "C_q": 0.0, "nu": 0.0, "gamma": 0.0, "reaction": 0.0, "reaction_q": math.nan}
OWN_POINT_DROPS = own_point_drops(D, FROM_OWN_ORIGIN)


def derive(_: str) -> Derivation:
    """Derivation of ``length``: l = |d| (1,) [m], d (8.8) in frame O from the point on i to j's."""
    return derive_constraint(_length())


def _gamma(by_points: SymbolicMatrix) -> SymbolicMatrix:
    """γ = −(v_p·(v_p + 2 w_p) + y − (n·w)²)/l, v_p and w_p the parts of v and w across d.

    Parameters
    ----------
    by_points : SymbolicMatrix
        d·w.
    """
    v, w = RELATIVE["v"], RELATIVE["w"]
    k = NamedMatrix("k", by_points)
    # Divided by the square, which is computed before its root.
    by_origins = NamedMatrix("h_v", mul(transpose(D), v))
    along_v, along_w = (mul(1 / Divisor(Dot(D, D)), x) for x in (by_origins, k))
    across_v = NamedMatrix("v_p", add(v, neg(mul(D, NamedMatrix("e", along_v)))))
    across_w = NamedMatrix("w_p", add(w, neg(mul(D, NamedMatrix("f", along_w)))))
    across = mul(transpose(across_v), add(across_v, mul(2, across_w)))
    further = add(NamedMatrix("y", turning_curvature()), neg(mul(k, NamedMatrix("f", along_w))))
    return mul(-1 / Divisor(L), add(across, further))


def _plain_gamma(rate: SymbolicMatrix, curved: SymbolicMatrix) -> SymbolicMatrix:
    """γ = ((h/l)² − z)/l, h = d·ḋ and z the rate of d·ḋ without accelerations."""
    along = mul(CURVED, NamedMatrix("h", rate))
    return mul(CURVED, add(mul(along, along), neg(NamedMatrix("z", curved))))


def _lines() -> tuple[Step, ...]:
    v, w = RELATIVE["v"], RELATIVE["w"]
    rate = mul(transpose(D), RATES[0])
    curved = add(mul(transpose(RATES[0]), RATES[0]), mul(transpose(D), RATES[1]))
    h, k, z, gamma = (MatrixSymbol(name, 1, 1) for name in ("h", "k", "z", "gamma"))
    return (
        Step(h, rate, "abbreviation: l dl/dt", ""),
        Step(h, mul(transpose(D), add(v, w)), "dd/dt = v + w", ""),
        Step(z, curved, "abbreviation: the rate of h without accelerations", ""),
        Step(z, half_square_curvature(), GAMMA_RULE, "7.15"),
        Step(gamma, _plain_gamma(rate, curved), "d²l/dt² = (dh/dt − (dl/dt)²)/l", ""),
        Step(k, BY_POINTS, "abbreviation: d·w", ""),
        Step(k, mul(transpose(D), w), "s·w = 0 in each body, and (x × y)·z = x·(y × z)", ""),
    )


def _closed() -> ClosedForm:
    """Rows l_q = d·d_q / l and l_qq = (n~ d_q)ᵀ n~ d_q / l + n·d_qq, by 1 − n nᵀ = n~ᵀ n~."""
    half_square = blocks_of(mul(transpose(D), DELTA(D)), OWN_POINT_DROPS)
    names = name_blocks("D", half_square)
    row = name_blocks("C", [mul(INVERSE, block) for block in names])
    second = [blocks_of(DELTA(transpose(part)), OWN_POINT_DROPS) for part in half_square]
    lines = [[mul(CURVED, block) for block in line] for line in name_lines("D", second)]
    of_own_angles = less_products(lines, (row, [mul(CURVED, block) for block in row]))
    columns = blocks_of(DELTA(D))
    plain = [
        mul(CURVED, block)
        for block in name_blocks("B", [mul(transpose(D), column) for column in columns])
    ]
    rules = ("the own point drops out", "δ(d/l) = n~ᵀ n~ δd/l")
    return ClosedForm(
        row,
        name_lines("K", _with_own_angles(_across(columns), of_own_angles)),
        rules,
        Plain(
            row,
            _with_own_angles(
                less_products(lines, (plain, [mul(CURVED, block) for block in plain])),
                of_own_angles,
            ),
            _plain_gamma(
                mul(transpose(D), add(RELATIVE["v"], RELATIVE["w"])),
                half_square_curvature(),
            ),
        ),
        _lines(),
        (_gamma(mul(transpose(D), RELATIVE["w"])),),
    )


def _across(columns: Blocks) -> tuple[Blocks, ...]:
    """Products of n~ d_q with each other, divided by l."""
    turned = [mul(skew(ALONG), column) for column in columns]
    vectors = [
        part if column.name[0] == "r" else block
        for part, block, column in zip(turned, name_blocks("V", turned), COLUMNS, strict=True)
    ]
    return tuple(tuple(mul(CURVED, transpose(u), v) for v in vectors) for u in vectors)


def _with_own_angles(
    blocks: tuple[Blocks, ...], of_own_angles: tuple[Blocks, ...]
) -> tuple[Blocks, ...]:
    """Second derivative with these blocks where it is by the angles of one body twice."""
    return tuple(
        tuple(
            of_angles if m == n and COLUMNS[m].name[0] != "r" else block
            for n, (block, of_angles) in enumerate(zip(*line, strict=True))
        )
        for m, line in enumerate(zip(blocks, of_own_angles, strict=True))
    )


def _length() -> Constraint:
    left = MatrixSymbol("C", 1, 1)
    d = point_offset()
    value, closed = mul(L, Identity(1)), _closed()
    return Constraint(
        name="length",
        kind="length",
        title="length, distance of two points",
        source="lecture 8.2, (8.8)",
        formula="C = |d|, d = r_j + A_j s′_j − r_i − A_i s′_i; where d = 0 the Jacobian is 0",
        unit="m",
        steps=(
            Step(MatrixSymbol("d", 3, 1), D.value, "vector between the points", "8.8"),
            Step(left, value, "its length", ""),
        ),
        value=value,
        components=(sympy.sqrt(dot(d, d)),),
        names=(D, *RATES),
        rule=OWN_POINT_DROPS,
        gamma=Step(
            MatrixSymbol("gamma", 1, 1),
            _gamma(BY_POINTS),
            "d·v_p = d·w_p = 0, k and z as above",
            "",
        ),
        closed=closed,
        at_pole=AT_POLE,
    )
