"""δ on the matrix level: its rules, and what cannot be collected."""

from __future__ import annotations

import pytest
from sympy import Rational, atan2, exp, sqrt
from sympy.matrices.expressions import Identity, MatrixSymbol, ZeroMatrix
from sympy.matrices.immutable import ImmutableDenseMatrix

from kousoku.model.errors import DerivationError
from kousoku.symbolic.bodies import COLUMNS, DELTA, RATE, SYMBOLS, A
from kousoku.symbolic.matrices import (
    Divisor,
    Dot,
    NamedMatrix,
    OrientationMatrix,
    add,
    mul,
    neg,
    skew,
    transpose,
    vector,
)
from kousoku.symbolic.variation import Variation, abbreviate, coefficient, orthogonality, without

DR, DTHETA = COLUMNS[0].delta, COLUMNS[1].delta
R, A_I, S_I = SYMBOLS["r_i"], A["i"], SYMBOLS["s_i_b"]


def test_orientation_varies_by_the_rule_7_16() -> None:
    assert DELTA(A_I) == mul(A_I, skew(DTHETA))
    assert DELTA(transpose(A_I)) == neg(mul(skew(DTHETA), transpose(A_I)))


def test_point_varies_by_7_19_and_collects_to_its_blocks() -> None:
    change = DELTA(add(R, mul(A_I, S_I)))
    assert change == add(DR, mul(A_I, skew(DTHETA), S_I))
    assert coefficient(change, DR) == Identity(3)
    assert coefficient(change, DTHETA) == neg(mul(A_I, skew(S_I)))
    assert without(change, DR, DTHETA) == ZeroMatrix(3, 1)


def test_squared_norm_of_euler_parameters_is_constant() -> None:
    p = SYMBOLS["p_i"]
    assert DELTA(mul(Dot(p, p) ** 2, S_I)) == ZeroMatrix(3, 1)


def test_scalar_factor_varies_by_the_chain_rule() -> None:
    length = sqrt(Dot(R, R))
    change = add(mul(R, mul(1 / length, transpose(R), DR)), mul(length, DR))
    assert DELTA(mul(length, R)) == change
    angle = DELTA(mul(atan2(Dot(R, S_I), R[0, 0]), Identity(1)))
    first = ImmutableDenseMatrix([[1, 0, 0]])
    square = Divisor(Dot(R, S_I) ** 2 + R[0, 0] ** 2)
    slopes = mul(R[0, 0] / square, transpose(S_I), DR), mul(-Dot(R, S_I) / square, first, DR)
    assert set(angle.args) == set(slopes)


def test_scalar_factor_of_a_matrix_that_varies_is_refused() -> None:
    with pytest.raises(DerivationError, match="is not constant"):
        DELTA(mul(Dot(R, R), A_I))


def test_scalar_without_a_rule_is_refused_if_it_varies() -> None:
    with pytest.raises(DerivationError, match="no rule for exp"):
        DELTA(mul(exp(Dot(R, R)), S_I))


def test_number_is_transposed_to_bring_the_variation_to_the_right() -> None:
    b = vector("b")
    assert coefficient(DELTA(mul(transpose(R), b)), DR) == transpose(b)
    assert coefficient(DELTA(mul(transpose(R), R)), DR) == mul(2, transpose(R))


def test_two_rates_of_one_vector_give_a_second_derivative() -> None:
    omega, omega_dot = COLUMNS[1].velocity, COLUMNS[1].acceleration
    twice = RATE(RATE(mul(A_I, S_I)))
    spin = skew(omega)
    assert twice == add(mul(A_I, spin, spin, S_I), mul(A_I, skew(omega_dot), S_I))


def test_quadratic_term_is_refused() -> None:
    with pytest.raises(DerivationError, match="is not linear in"):
        coefficient(mul(skew(DR), mul(A_I, DR)), DR)


def test_matrix_that_holds_a_variation_at_its_left_is_refused() -> None:
    with pytest.raises(DerivationError, match="cannot be brought to the right"):
        coefficient(mul(DR, transpose(S_I), A_I), DR)


def test_unknown_node_is_refused_by_name() -> None:
    with pytest.raises(DerivationError, match="no rule for Inverse"):
        Variation({}, {})(A_I.inverse())


def test_orthogonality_holds_for_any_norm() -> None:
    p = SYMBOLS["p_i"]
    assert orthogonality(mul(transpose(A_I), A_I, S_I)) == mul(Dot(p, p) ** 2, S_I)
    assert orthogonality(mul(A_I, A["j"], S_I)) is None


def test_abbreviation_replaces_products_and_sums() -> None:
    product = NamedMatrix("w", mul(A_I, S_I))
    total = NamedMatrix("d", add(R, S_I))
    assert abbreviate(mul(2, skew(R), A_I, S_I), product) == mul(2, skew(R), product)
    assert abbreviate(mul(skew(R), add(R, S_I)), total) == mul(skew(R), total)


def test_builders_keep_the_written_order_and_collect_equal_terms() -> None:
    b, a = vector("b"), vector("a")
    assert add(b, a, b).args == (mul(2, b), a)
    assert add(b, neg(b)) == ZeroMatrix(3, 1)
    assert mul(Rational(1, 2), mul(2, Identity(3), b)) == b
    assert transpose(mul(OrientationMatrix(vector("p", 4)), skew(a), b)).shape == (1, 3)
    assert transpose(transpose(MatrixSymbol("X", 2, 3))) == MatrixSymbol("X", 2, 3)
