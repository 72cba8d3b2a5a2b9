"""A derivation as one explores it: parts of it, components by name, values, and how it shows."""

from __future__ import annotations

import pickle
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np
import pytest
import sympy

from kousoku.generated.kinds.angle import kernels as angle
from kousoku.generated.kinds.length import kernels as length
from kousoku.generated.kinds.n2 import kernels as n2
from kousoku.model.errors import DerivationError
from kousoku.symbolic.kinds import KINDS

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.symbolic.derivation import Derivation

    Derived = Callable[[str], Derivation]

#: Of n1: body j is turned by 90° about z, with Euler parameters of norm √2.
TURNED = {"p_i": [1, 0, 0, 0], "a_i_b": [0, 1, 0], "p_j": [1, 0, 0, 1], "a_j_b": [1, 0, 0]}


@pytest.mark.parametrize("kind", KINDS)
def test_a_repr_has_at_most_ten_short_lines_that_name_every_output(
    derived: Derived, kind: str
) -> None:
    d = derived(kind)
    lines = repr(d).splitlines()
    assert len(lines) <= 10
    assert max(map(len, lines)) <= 102
    for function in d.functions[:6]:
        assert all(f"{output.quantity.name} (" in repr(d) for output in function.outputs)
    for part in (*d.steps, *d.functions, *d.outputs.values()):
        assert len(repr(part)) <= 102, part
        assert "\n" not in repr(part)


def test_a_part_is_a_derivation_that_shows_its_own_steps_under_their_numbers(
    derived: Derived,
) -> None:
    d = derived("n2")
    part = d[4:7]
    assert part.steps == d.steps[4:7] == tuple(part)
    assert len(part) == 3
    text = str(part)
    assert [line[:4] for line in text.splitlines() if line[3:4] == "."] == ["  5.", "  6.", "  7."]
    assert str(d[:7]).endswith(text.partition("\n\n")[2])
    assert str(part[1:2]) == str(d[5:6])
    assert "steps 5 to 7" in repr(part)
    assert part._repr_latex_().count("\\\\\n") == 2
    assert part._repr_latex_() in {d[4:7]._repr_latex_()}
    assert d[4] is d.steps[4]
    assert d[4]._repr_latex_() == d[4:5]._repr_latex_()
    assert part.C_q == d.C_q
    assert "no steps" in repr(d[:0])


def test_outputs_are_components_in_the_shapes_of_the_quantities(derived: Derived) -> None:
    d = derived("p2")
    assert d.C.shape == (2, 1)
    assert d.C_q.shape == (2, 12)
    assert d.reaction_q.shape == (12, 12)
    assert {"C", "C_q", "nu", "gamma"} <= set(dir(d))
    r_i, r_j = d.symbols["r_i"], d.symbols["r_j"]
    assert r_i.shape == (3, 1)
    # C holds d = r_j − … − r_i, so its derivatives by both are opposite, and are the Jacobian.
    assert (d.C.jacobian(r_j) + d.C.jacobian(r_i)).expand() == sympy.zeros(2, 3)
    assert (d.C.jacobian(r_j) - d.C_q[:, 6:9]).expand() == sympy.zeros(2, 3)
    assert derived("mass_points").mass == sum(derived("mass_points").symbols["m"])
    with pytest.raises(AttributeError, match="p2_z has no output 'D'; it has C, C_q, nu, gamma"):
        _ = d.D


def test_a_derivation_travels(derived: Derived) -> None:
    d = derived("n1")
    assert pickle.loads(pickle.dumps(d)) == d


def test_values_at_fractions_are_exact(derived: Derived) -> None:
    d = derived("n1")
    found = d.at(TURNED, a_i_b=[0, Fraction(1, 3), sympy.sqrt(2)])
    assert list(found) == ["C", "C_q"]
    # (0, 1/3, √2) · 2 (0, 1, 0): the Euler parameters of j have the norm √2.
    assert found["C"].tolist() == [sympy.Rational(2, 3)]
    assert found["C_q"].shape == (1, 12)


def test_values_at_mpf_have_its_precision(derived: Derived) -> None:
    numbers = {"r_i": [0] * 3, "p_i": [1, 0, 0, 0], "s_i_b": [0] * 3, "s_j_b": [0] * 3}
    with mpmath.workdps(60):
        found = derived("length").at(numbers, p_j=[1, 0, 0, 0], r_j=[mpmath.mpf(1), 1, 0])
        assert abs(found["C"][0] - mpmath.sqrt(2)) < mpmath.mpf(10) ** -59
        assert isinstance(found["C"][0], mpmath.mpf)


@pytest.mark.parametrize(
    ("kind", "kernels"),
    [("n2", n2), ("angle", angle), ("length", length)],
    ids=["n2", "angle", "length"],
)
def test_values_at_floats_are_those_of_the_kernels(
    derived: Derived, kind: str, kernels: Any
) -> None:
    d = derived(kind)
    numbers = np.random.default_rng(7)
    given = {name: numbers.uniform(0.5, 1.5, q.shape) for name, q in d.inputs.items()}
    found = d.at(given)
    assert set(found) == set(d.outputs)
    for function in d.functions:
        arguments = [given[quantity.name] for quantity in function.inputs]
        for output, value in zip(
            function.outputs, getattr(kernels, function.name)(*arguments), strict=True
        ):
            mine = found[output.quantity.name]
            assert mine.dtype == np.float64
            assert mine.shape == value.shape
            assert np.allclose(mine, value, rtol=1e-12, atol=1e-12)


def test_a_pole_is_no_number(derived: Derived) -> None:
    one = {"p_i": [1.0, 0, 0, 0], "p_j": [1, 0, 0, 0], "r_i": [0, 0, 0], "r_j": [0, 0, 0]}
    found = derived("length").at(one, s_i_b=[0, 0, 0], s_j_b=[0, 0, 0])
    assert found["C"].tolist() == [0.0]
    assert np.isnan(found["C_q"]).any()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"p_k": [1, 0, 0, 0]}, r"n1.at: no input 'p_k': there are p_i, .*; did you mean 'p_"),
        (
            {"p_i": [1, 0]},
            r"n1.at: p_i has shape \(2,\); wanted \(4,\), Euler parameters of body i",
        ),
        ({"p_i": [[1], [2, 3]]}, r"p_i has .*; wanted \(4,\)"),
        ({"p_i": [1, 0, 0, "0"]}, "n1.at: p_i: '0' is not a finite real number; wanted a float"),
        ({"p_i": [1, 0, 0, True]}, "True is not a finite real number"),
        ({"p_i": [1, 0, 0, np.nan]}, "nan is not a finite real number"),
        ({"p_i": [1, 0, 0, sympy.Symbol("x")]}, "x is not a finite real number"),
        ({"omega_i_b": [0, 0, 1]}, "n1.at: nu, gamma cannot be had without omega_j_b"),
        ({"outputs": ["gamma"]}, "n1.at: gamma cannot be had without omega_i_b, omega_j_b"),
        ({"outputs": ["gama"]}, "n1.at: no output 'gama': there are .*; did you mean 'gamma'"),
    ],
)
def test_numbers_that_do_not_fit_are_refused_in_one_line(
    derived: Derived, change: dict[str, Any], message: str
) -> None:
    with pytest.raises(DerivationError, match=message) as caught:
        derived("n1").at(**{**TURNED, **change})
    assert "\n" not in str(caught.value)


def test_no_numbers_at_all_is_refused(derived: Derived) -> None:
    with pytest.raises(
        DerivationError, match="C, C_q cannot be had without p_i, a_i_b, p_j, a_j_b"
    ):
        derived("n1").at()


def test_a_proof_tells_what_it_proved(derived: Derived) -> None:
    assert derived("n1").prove() == {"steps": 5, "constraint": 13, "rates": 2, "reaction": 156}
