"""Three mass points: nothing in a formula can change, and the code's derivation is tied to it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest

from kousoku.ledger import entries, find, proof
from kousoku.ledger.documents import mass_points
from kousoku.ledger.documents.mass_points import centred, in_step, one_point, words
from kousoku.ledger.entry import MASS_POINTS
from kousoku.ledger.proof import equal, prove, proved, refuted, unreadable
from kousoku.model.errors import LedgerError
from kousoku.symbolic import derive
from kousoku.symbolic.matrices import neg
from tests.ledger.changes import forms_near

if TYPE_CHECKING:
    from kousoku.ledger.entry import Entry
    from kousoku.symbolic.derivation import Derivation

pytestmark = pytest.mark.release

ENTRIES = [entry for entry in entries() if entry.document == MASS_POINTS]
BY_KEY = {entry.equation: entry for entry in ENTRIES}
FORMULAS = [entry for entry in ENTRIES if entry.vocabulary]
#: What a formula can lose or have wrong; each takes the proof away.
CHANGES = (
    ("+", "-"),
    ("-", "+"),
    ("=", "= 2 "),
    ("cross", ""),
    ("^T", ""),
    ("_{OA} ", "_{OA}^T "),
    ("M_A ", ""),
    ("_1", "_2"),
    ("_3", "_2"),
    ("A1", "A2"),
    ("AG", "A1"),
    ("_{ij}", "_{ik}"),
    (" E", ""),
)
#: Opposite forces at one point have opposite moments, in any direction.
STILL_TRUE = {r"\vec r_{A2} \times \vec f_{12} + \vec r_{A2} \times \vec f_{21} = 0"}
#: What is nothing is twice nothing, too.
TWICE_NOTHING = "= 2  0"


@pytest.mark.parametrize("entry", FORMULAS, ids=lambda entry: entry.equation)
def test_a_formula_with_anything_changed_is_refuted(entry: Entry) -> None:
    assert entry.vocabulary
    near = forms_near(entry.true_form, CHANGES)
    forms = [form for form in near if form not in STILL_TRUE and TWICE_NOTHING not in form]
    assert forms
    for form in forms:
        assert refuted(form, entry.vocabulary()), form


def test_the_misprints_of_the_document() -> None:
    assert [entry.equation for entry in ENTRIES if entry.verdict != "holds"] == [
        "cancelling-moments",
        "point-equation",
        "first-term",
        "collected-force-balance",
        "torque-definition",
        "point-equation-again",
        "summary-force-balance",
        "summary-torque-definition",
        "matrix-form",
        "reduced-matrix-form",
    ]
    assert {entry.verdict for entry in ENTRIES} == {"holds", "misprint"}


@pytest.mark.parametrize(
    ("key", "formula"),
    [
        ("point-equation", r"f_i^O + f_{ij}^O"),
        ("torque-definition", "C_{OA}"),
        ("collected-force-balance", "r_{AG}^A"),
        ("matrix-form", "M_A &"),
    ],
)
def test_what_is_wrong_stands_in_the_printed_form(key: str, formula: str) -> None:
    entry = BY_KEY[key]
    assert formula in entry.printed
    with pytest.raises(LedgerError):
        prove(replace(entry, verdict="holds", corrected="", refutation=()))
    with pytest.raises(LedgerError, match=r"the printed form holds|it can be formed"):
        prove(replace(entry, printed=entry.corrected, refutation=()))


def test_one_internal_force_is_not_enough_whichever_it_is() -> None:
    printed = BY_KEY["point-equation"].printed
    for only in ("f_{ij}^O", "f_{ik}^O"):
        assert "differ" in refuted(printed.replace("f_{ij}^O", only), one_point())


def test_moments_balance_only_with_the_corrected_torque() -> None:
    for key in ("moment-sum", "moment-balance", "summary-moment-balance"):
        (line,) = [x for x in prove(BY_KEY[key]).lines if x.statement.startswith("with N_A as")]
        assert line.result.startswith("at a rational point element 1 of 3 is ")


def test_the_newton_euler_form_takes_the_centre_of_mass() -> None:
    for key in ("newton-euler-force", "newton-euler-moment", "reduced-matrix-form"):
        form = BY_KEY[key].true_form
        assert proved(form, centred())
        with pytest.raises(LedgerError, match="element 1 of"):
            proved(form, words())


def negative(x: Any) -> Any:
    return neg(x) if getattr(x, "is_Matrix", False) else -x


def altered(package: str) -> Derivation:
    """Code's derivation with the sign of each output and each step turned."""
    derivation = derive(package)
    functions = tuple(
        replace(
            function,
            outputs=tuple(replace(o, expression=negative(o.expression)) for o in function.outputs),
        )
        for function in derivation.functions
    )
    steps = tuple(replace(step, right=negative(step.right)) for step in derivation.steps)
    return replace(derivation, functions=functions, steps=steps)


@pytest.mark.parametrize(
    "entry",
    [e for e in ENTRIES if any(check.statement.startswith("the code's") for check in e.checks)],
    ids=lambda entry: entry.equation,
)
def test_an_entry_fails_when_the_code_differs(
    entry: Entry, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (mass_points, proof):
        monkeypatch.setattr(module, "derive", altered)
    for check in entry.checks:
        if check.statement.startswith("the code's"):
            with pytest.raises(LedgerError, match=r"element|at a rational point"):
                check.run()


def test_every_quantity_that_the_code_derives_from_an_equation_is_compared_with_it() -> None:
    named = {
        (getattr(step.left, "name", ""), find(key).equation)
        for step in derive("mass_points").steps
        for key in filter(None, step.source.split(", "))
        if find(key).document == MASS_POINTS
    }
    of = {name: [key for left, key in sorted(named) if left == name] for name, _ in named}
    assert len(of) > 12
    for name, keys in of.items():
        statements = [check.statement for key in keys for check in BY_KEY[key].checks]
        ends = (f"mass_points end with this as {name}", f"newton_euler gives this as {name}")
        assert any(statement.endswith(ends) for statement in statements), name


def test_a_step_that_the_code_does_not_have_is_named() -> None:
    with pytest.raises(LedgerError, match="mass_points has no step about v_9"):
        in_step("mass_points", "v_9", "v_{OA}^O", words)


def test_a_formula_that_can_be_formed_is_not_taken_for_one_that_cannot() -> None:
    with pytest.raises(LedgerError, match="it can be formed"):
        unreadable(words, BY_KEY["torque-definition"].printed)


def test_internal_forces_are_central_and_external_ones_are_what_newton_leaves() -> None:
    """What the symbols mean, said once more in other words."""
    for seen in (
        equal(words, r"f_{12}^O + f_{21}^O", "0"),
        equal(words, r"cross(f_{13}^O) (r_{O1}^O - r_{O3}^O)", "0"),
        equal(words, r"m_2 a_{O2}^O", r"f_2^O + f_{21}^O + f_{23}^O"),
        equal(one_point, r"m_i a_{Oi}^O", r"f_i^O + f_{ij}^O + f_{ik}^O"),
    ):
        assert seen == "all 3 elements equal, identically"
