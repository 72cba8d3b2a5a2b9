"""A constraint of one's own, stated in the lecture's vectors."""

from __future__ import annotations

import pickle
from fractions import Fraction
from typing import Any, cast

import numpy as np
import pytest
import sympy

from kousoku.deriving import body, derive, number
from kousoku.model.errors import DerivationError
from kousoku.symbolic.printing import show

#: Any type, so that mistakes reach the messages.
BI: Any = body("i")
BJ: Any = body("j")
D = BJ.point() - BI.point()
COSINE: Any = number("cos_theta")


@pytest.mark.parametrize(
    ("kind", "C"),
    [
        ("n1", BI.axis().dot(BJ.axis())),
        ("n2", BI.axis().dot(D)),
        ("n2", BI.a_b.dot((BI.A.T @ D).named("y"))),
        ("n2", -(BI.point() - BJ.point()).dot(BI.axis())),
        ("point", D),
        ("point", [D[0], D[1], D[2]]),
        ("p1", [BI.a_b.cross(BI.A.T @ BJ.axis())[k] for k in (0, 1)]),
        ("distance", (D.dot(D) - number("length", "m") ** 2) / (2 * number("length", "m"))),
        ("distance", (D.dot(D) / number("length", "m") - number("length", "m")) * Fraction(1, 2)),
    ],
)
def test_what_kousoku_has_is_the_same_stated_by_oneself(kind: str, C: Any) -> None:
    shipped, own = derive(kind), derive("own", C=C)
    numbers = np.random.default_rng(3)
    whole = {
        name: [Fraction(int(n), 4) for n in numbers.integers(1, 9, q.size)]
        for name, q in {**shipped.inputs, **own.inputs}.items()
    }
    given = {n: x if q.shape else x[0] for n, q in shipped.inputs.items() for x in [whole[n]]}
    mine = {n: x if q.shape else x[0] for n, q in own.inputs.items() for x in [whole[n]]}
    wanted, found = shipped.at(given), own.at(mine)
    assert wanted.keys() == found.keys()
    for name, value in wanted.items():
        assert (value == found[name]).all(), name


def test_it_is_derived_in_steps_and_proved() -> None:
    d = derive("slant", C=BI.axis().dot(BJ.axis()) - COSINE, title="two axes at an angle")
    assert d.title == "slant, two axes at an angle"
    assert d.functions[0].formula == "C = a_i^T a_j − cos_θ"
    assert [show(step.left) for step in d[:4]] == ["a_i", "a_j", "C", "C"]
    assert [q for q in d.functions[0].inputs if q.name == "cos_theta"] == [*COSINE.inputs]
    assert d.prove()["constraint"] == 13


def test_numbers_may_be_multiplied() -> None:
    product = BI.axis().dot(BJ.axis()) * BI.axis("b").dot(BJ.axis())
    d = derive("product", C=[product - 1, 2 * BI.axis().dot(BJ.axis("c"))])
    assert set(d.inputs) >= {"a_i_b", "b_i_b", "a_j_b", "c_j_b"}
    given = {name: [Fraction(k + 1, 3) for k in range(q.size)] for name, q in d.inputs.items()}
    found = d.at(given)
    # The Jacobian is the derivative of C along ½ p∘(0, δθ′), here of body i about its axis z.
    p, rate = d.symbols["p_i"], sympy.Matrix([-given["p_i"][3], given["p_i"][2]])
    rate = sympy.Matrix([*rate, -given["p_i"][1], given["p_i"][0]]) / 2
    values = {
        s: x
        for name, symbols in d.symbols.items()
        for s, x in zip(symbols, given[name], strict=True)
    }
    slope = (d.C.jacobian(p) * rate).subs(values)
    assert list(slope) == list(found["C_q"][:, 5])


@pytest.mark.parametrize(
    ("state", "message"),
    [
        (lambda: body(cast(Any, "k")), "no body 'k': a constraint is between bodies 'i' and 'j'"),
        (lambda: D.dot(BI.axis()) + COSINE, r"a_i is in m and cos_θ in -; they cannot be added"),
        (lambda: derive("own", C=D.dot(D)), r"own: C holds .* in m\^2; wanted a length in m or"),
        (
            lambda: BI.a_b.dot(BJ.axis()),
            "a'_i is multiplied by a_j: components in frame i and in ",
        ),
        (
            lambda: BI.A @ BJ.a_b,
            "A of body i takes components in frame i; those of a'_j are in",
        ),
        (lambda: BI.A.T @ BI.a_b, "A.T of body i takes components in frame O; those of a'_i"),
        (
            lambda: BI.axis() * BJ.axis(),
            "a_i is multiplied by a_j, of type Vector; wanted a number",
        ),
        (
            lambda: BI.axis().dot(3),
            "a_i is multiplied by 3, of type int; wanted a vector, made of",
        ),
        (
            lambda: COSINE + 0.1,
            "to cos_θ is added 0.1, of type float; wanted a number: an",
        ),
        (lambda: COSINE + True, "to cos_θ is added True, of type bool"),
        (lambda: COSINE + "x", "to cos_θ is added 'x', of type str"),
        (lambda: COSINE + np.ones(3), r"to cos_θ is added array\(.*, of type ndarray"),
        (
            lambda: COSINE / BI.axis().dot(BJ.axis()),
            "is divided by a_i.T a_j; wanted a constant",
        ),
        (lambda: COSINE / 0, "is divided by 0; wanted a constant that is not zero"),
        (lambda: COSINE**-1, "the power -1 of cos_θ: wanted a positive integer"),
        (lambda: number("x", cast(Any, "kg")), "x: unit 'kg'; wanted one of -, rad, m"),
        (lambda: number("two words"), "'two words' is not a name"),
        (lambda: number("r_i", "m"), "r_i is position of body i, frame O, of shape"),
        (lambda: BI.fixed("s", "-"), "s_i_b is point fixed in body i, frame of i, of shape"),
        (lambda: number("c", "m") / number("c"), r"c is there twice, as given c \[m\] and as"),
        (lambda: derive("own", C=[]), "own: C holds nothing; wanted a length"),
        (
            lambda: derive("own", C=cast(Any, "a_i.a_j")),
            "C holds 'a_i.a_j', of type str; wanted a",
        ),
        (lambda: derive("own", C=[D, COSINE]), "C holds .* in m, cos_θ in -; wanted"),
        (lambda: derive("own", C=D * BI.axis().dot(BJ.axis())), "with a factor that varies"),
        (lambda: derive("own", C=COSINE), "own: row 0 of C constrains nothing"),
        (lambda: derive("own", C=(D - D).dot(BI.axis())), "own: row 0 of C constrains nothing"),
        (
            lambda: derive("own", C=[BI.axis().dot(BJ.axis()), BI.axis().dot(BI.axis("b"))]),
            "own: row 1 of C constrains nothing: its row of C_q is zero",
        ),
    ],
)
def test_a_mistake_gets_one_clear_message(state: Any, message: str) -> None:
    with pytest.raises(DerivationError, match=message) as caught:
        state()
    assert "\n" not in str(caught.value)


def test_a_component_that_is_not_there_is_no_index() -> None:
    with pytest.raises(IndexError, match="components 0, 1 and 2; there is no 3"):
        _ = D[3]


def test_what_a_body_has_not_is_told_with_what_it_has() -> None:
    with pytest.raises(AttributeError, match=r"body j has no omega_b: there are r, A, .* ω′ and"):
        _ = BJ.omega_b
    assert pickle.loads(pickle.dumps(BJ)) == BJ
    assert not hasattr(BJ, "__deepcopy__")


def test_vectors_show_as_formulas() -> None:
    assert repr(BI.axis().dot(BJ.axis()) - COSINE) == "<Number a_i^T a_j − cos_θ [-]>"
    assert repr(BI.A @ BI.s_b) == "<Vector A_i s'_i [m]>"
    assert (BI.A @ BI.s_b)._repr_latex_().startswith(r"$\mathbf{A}")
