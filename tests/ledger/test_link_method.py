"""Section 3 of Yamada and Tatsumi 1981: the proofs see every part, prime, sign and factor."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import pytest
import sympy

from kousoku.ledger.documents import link_method
from kousoku.ledger.documents.link_element import code
from kousoku.ledger.documents.link_mechanisms import LEVER_CRANK, PISTON_CRANK, determinant
from kousoku.ledger.proof import prove
from kousoku.ledger.reading import read
from kousoku.model.errors import LedgerError
from tests.ledger.changes import forms_near, with_form

if TYPE_CHECKING:
    from kousoku.ledger.entry import Entry

pytestmark = pytest.mark.release

ENTRIES = {entry.equation: entry for entry in read(link_method)}
FORMULAS = [entry for entry in ENTRIES.values() if entry.vocabulary]
CHANGES = (
    ("+", "-"),
    (" -(", " ("),
    ("^1", "^2"),
    ("^2", "^1"),
    ("''", "'"),
    ("'", "''"),
    ("/2", ""),
    (r"\Delta\alpha", ""),
    (r"/\Delta\alpha", ""),
    (r"\dot{\alpha}", r"\ddot{\alpha}"),
    (r"\ddot{\alpha}", r"\dot{\alpha}"),
    (r"(d/d\alpha)", ""),
    (r"(d/d\alpha)", "(d/dt)"),
    ("^{-1}", ""),
    ("d^2", "d"),
)


@pytest.mark.parametrize("entry", FORMULAS, ids=lambda entry: entry.equation)
def test_no_part_prime_sign_or_factor_can_change(entry: Entry) -> None:
    plain = replace(entry, checks=())
    prove(plain)
    for text in forms_near(entry.true_form, CHANGES):
        with pytest.raises(LedgerError):
            prove(with_form(plain, text))


def test_the_printed_forms_do_not_fit() -> None:
    seen = {key: str(prove(ENTRIES[key])).splitlines()[0] for key in ("20", "23", "25", "28")}
    assert "(10, 4) and (6, 1)" in seen["20"]
    assert "(6, 10) and (4, 1)" in seen["23"]
    assert "shape (10, 1), the other (4, 1)" in seen["25"]
    assert "(10, 1), (6, 1)" in seen["28"]


def test_the_misplaced_superscript_is_notation_and_the_lost_index_is_not() -> None:
    assert {key: ENTRIES[key].verdict for key in ("25", "28", "link-known-second")} == {
        "25": "notation",
        "28": "misprint",
        "link-known-second": "notation",
    }
    with pytest.raises(LedgerError, match="in more than notation"):
        prove(replace(ENTRIES["28"], verdict="notation"))


@pytest.mark.parametrize(
    ("left", "key"),
    [
        ("u", "19"),
        ("x′", "19"),
        ("u_1", "21"),
        ("x′_1", "22"),
        ("x″_1", "23"),
        ("x_dot", "24"),
        ("x_ddot", "25"),
        ("x_adj", "26"),
        ("u^*", "27"),
        ("x′_new", "28"),
    ],
)
def test_a_proof_fails_where_the_code_derives_something_else(
    monkeypatch: pytest.MonkeyPatch, left: str, key: str
) -> None:
    prove(ENTRIES[key])
    true = code()
    steps = tuple(replace(s, right=-s.right) if str(s.left) == left else s for s in true.steps)
    monkeypatch.setattr(link_method, "code", lambda: replace(true, steps=steps))
    with pytest.raises(LedgerError, match=f"the code's step for {left}".replace("^*", r"\^\*")):
        prove(ENTRIES[key])


def test_the_step_that_substitutes_is_compared_multiplied_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    true = code()
    steps = tuple(replace(s, left=2 * s.left) if s.source == "20" else s for s in true.steps)
    monkeypatch.setattr(link_method, "code", lambda: replace(true, steps=steps))
    with pytest.raises(LedgerError, match="the code's step"):
        prove(ENTRIES["20"])


def test_the_motion_is_that_of_a_piston_crank() -> None:
    """At tan(α/2) = 2/3 and tan(β/2) = 1/3: sines 12/13 and 3/5, a crank of 3, a rod of 60/13."""
    x = link_method.motion(0).xreplace(link_method.NUMBERS)
    assert list(x[2:6, 0]) == [
        3 * sympy.Rational(5, 13),
        3 * sympy.Rational(12, 13),
        3 * sympy.Rational(5, 13) + sympy.Rational(60, 13) * sympy.Rational(4, 5),
        0,
    ]
    assert (x[4, 0] - x[2, 0]) ** 2 + x[3, 0] ** 2 == sympy.Rational(60, 13) ** 2


def test_each_mechanism_has_as_many_equations_as_unknowns() -> None:
    for mechanism, unknown in ((PISTON_CRANK, 6), (LEVER_CRANK, 12)):
        assert len(mechanism.unknown) == unknown == 3 * len(mechanism.links)
    without = replace(PISTON_CRANK, known={"u_1": "0", "v_1": "0", "ψ_11": "Δα"})
    with pytest.raises(LedgerError, match="6 equations for 7 unknowns"):
        determinant(without)


def test_each_correction_gains_one_power_of_the_step() -> None:
    assert link_method.crank_orders(3) == (3, 4, 5, 6)
