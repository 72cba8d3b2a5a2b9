"""Folds: functions that undo each other but for a kink or a jump."""

from __future__ import annotations

import math

import pytest

from kousoku.model.errors import SceneError
from kousoku.model.expressions.folds import without_folds
from kousoku.model.expressions.parser import parse_expression
from kousoku.model.expressions.values import value_of
from kousoku.model.operations.expression import apply, symbol
from kousoku.model.operations.graph import Op
from kousoku.model.reading.read import scene_from_toml

#: Quotients of powers that are sign(t).
JUMPS = (
    *("t*abs(t)/t^2", "t^3/sqrt(t^6)", "t^3/abs(t)^3", "abs(t)^3/t^3", "t/abs(t^3)*t^2"),
    *("t^2/(t*abs(t))", "t*(t^2)^(-0.5)", "t^2/sqrt(t^2)/t", "t*abs(t)^1.5/(t^2)^1.25"),
    *("t*exp(-0.5*log(t^2))", "t*exp(-log(abs(t)))", "t/exp(0.5*log(t^2))"),
)
FOLDS = (
    *("asin(sin(t))", "asin(cos(2*t))", "acos(cos(t))", "acos(sin(t - 1))", "3*asin(sin(t))^2 + t"),
    *(
        "(t-1)/abs(t-1)",
        "-2*(t-1)/abs(t-1)",
        "abs(t-1)/(t-1)",
        "(t-1)/sqrt((t-1)^2)",
        "t*(t-1)/abs(t-1)",
        "2*t/abs(2*t)",
        "(t-1)/abs(1-t)",
        "(2*t-1)/sqrt((1-2*t)^2)",
    ),
    *JUMPS,
)


@pytest.mark.parametrize("text", FOLDS)
def test_formulas_without_folds_have_the_same_values(text: str) -> None:
    formula = parse_expression(text, ("t",))
    unfolded, folds = without_folds(formula)
    assert unfolded != formula
    assert folds
    for k in range(200):
        values = {"t": 0.0371 * k - 3.0}
        size = 1e-7 if "asin" in text or "acos" in text else 1e-14  # near its ends asin has half
        wanted = value_of(formula, values)
        assert value_of(unfolded, values) == pytest.approx(wanted, rel=0, abs=size * math.pi)


@pytest.mark.parametrize(
    "text",
    [
        *("asin(sin(t)/2)", "acos(t/9)", "t/abs(t - 1)", "(t-1)/abs(t-2)", "sin(t)/t", "2*t"),
        *("t/abs(t)^3", "t^2/abs(t)^2", "t^3/t^2", "t*exp(log(t))", "t*sqrt(t)/abs(t - 1)"),
        *("abs(t)*exp(-log(t))", "exp(log(t) - 2*log(abs(t)))", "atan(1/(t^2 + 1))", "atan(t)"),
    ],
)
def test_other_formulas_stay_as_they_are(text: str) -> None:
    formula = parse_expression(text, ("t",))
    unfolded, folds = without_folds(formula)
    assert unfolded is formula
    assert not folds


@pytest.mark.parametrize("text", JUMPS)
def test_quotients_of_powers_are_the_sign_of_what_cancels(text: str) -> None:
    unfolded, folds = without_folds(parse_expression(text, ("t",)))
    assert unfolded == apply(Op.SIGN, symbol("t"))
    assert unfolded in folds


@pytest.mark.parametrize("text", ["a*atan(1/(t - 1))", "atan(-a/t)", "atan(2/(a - t))"])
def test_arcs_of_quotients_are_a_jump_and_a_smooth_part(text: str) -> None:
    formula = parse_expression(text, ("t", "a"))
    unfolded, folds = without_folds(formula, {"a"})
    assert any(one.op is Op.SIGN for one in folds)
    for k in range(200):
        values = {"t": 0.0371 * k - 3.0, "a": -0.7}
        wanted = value_of(formula, values)
        assert value_of(unfolded, values) == pytest.approx(wanted, rel=0, abs=1e-15)
    assert without_folds(parse_expression("atan(a/t)", ("t", "a")))[1] == {}  # a varies


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("t*abs(t)/t", "abs(t)"),
        ("abs(t)^3/t^2", "abs(t)"),
        ("t^4/(t*abs(t)^2)", "t"),
        ("(t-1)*abs(t-1)/(t^2-2*t+1)", "sign(t-1)"),
    ],
)
def test_quotients_of_powers_keep_the_kink_that_is_left(text: str, wanted: str) -> None:
    unfolded, _ = without_folds(parse_expression(text, ("t",)))
    assert unfolded == parse_expression(wanted, ("t",))


@pytest.mark.parametrize(
    ("law", "what"),
    [
        ("asin(sin(t))", "asin"),
        ("2*asin(sin(t))^3", "asin"),
        ("(t-5)/abs(t-5)", "a quotient"),
        ("(t-5)*abs(t-5)/(t-5)^2", "a quotient"),
    ],
)
def test_drivers_with_a_fold_are_refused(law: str, what: str) -> None:
    """They led no further where the argument of asin comes to its end, without a reason."""
    with pytest.raises(SceneError, match=rf"drivers\.motor\.value: {what} has a kink, where"):
        scene_from_toml(
            'name = "shaft"\nunit = "m"\n[bodies]\nshaft = { position = [0, 0, 0] }\n[joints]\n'
            'axle = { type = "hinge", bodies = ["ground", "shaft"], at = [0, 0, 0],'
            ' axis = [0, 0, 1] }\n[coordinates]\nturn = { joint = "axle" }\n[drivers]\n'
            f'motor = {{ coordinate = "turn", value = "{law}" }}\n'
        )
