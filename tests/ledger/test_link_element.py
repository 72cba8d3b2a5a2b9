"""Section 2 of Yamada and Tatsumi 1981: the proofs see every sign, index and function."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from kousoku.ledger.documents import link_element
from kousoku.ledger.proof import prove
from kousoku.ledger.reading import read
from kousoku.model.errors import LedgerError
from tests.ledger.changes import forms_near, with_form

if TYPE_CHECKING:
    from collections.abc import Iterator

    from kousoku.ledger.entry import Entry
    from kousoku.symbolic.derivation import Derivation

pytestmark = pytest.mark.release

ENTRIES = {entry.equation: entry for entry in read(link_element)}
FORMULAS = [entry for entry in ENTRIES.values() if entry.vocabulary]
CHANGES = (
    ("+", "-"),
    ("-", "+"),
    ("\\cos", "\\sin"),
    ("\\sin", "\\cos"),
    ("{i1}", "{i2}"),
    ("{i2}", "{i1}"),
    ("^2", "^3"),
    ("l_i^0", "l_i"),
    ("\\beta_i^0", "\\beta_i"),
    ("x_", "y_"),
    ("T}", "}"),
)


@pytest.mark.parametrize("entry", FORMULAS, ids=lambda entry: entry.equation)
def test_no_sign_index_function_or_power_can_change(entry: Entry) -> None:
    for text in forms_near(entry.true_form, CHANGES):
        with pytest.raises(LedgerError):
            prove(with_form(entry, text))


def test_the_printed_position_hides_the_turn_of_the_ends() -> None:
    entry = ENTRIES["2"]
    with pytest.raises(LedgerError, match="element 3 of 6"):
        prove(replace(entry, verdict="holds", corrected="", refutation=()))
    assert "with β_i in its place ε2 = 0 for every displacement" in str(prove(entry))


def test_brackets_alone_are_notation() -> None:
    for key in ("9", "12", "13"):
        assert "closes the bracket" in str(prove(ENTRIES[key]))
        with pytest.raises(LedgerError, match="only in notation"):
            prove(replace(ENTRIES[key], verdict="misprint"))


def test_a_link_of_five_has_remainders_of_the_second_order() -> None:
    seen = str(prove(ENTRIES["14"]))
    assert "ε1 = 0 + 3/5 u_i2 + 8/125 u_i2²" in seen


@pytest.fixture
def forgetful() -> Iterator[None]:
    """Forget what was derived, before and after."""
    kept = (
        link_element.words,
        link_element.epsilon,
        link_element.expanded,
        link_element.differentiated,
        link_element.rigid,
    )
    for function in kept:
        function.cache_clear()
    yield
    for function in kept:
        function.cache_clear()


@pytest.mark.parametrize(
    ("left", "key"),
    [
        ("epsilon_1", "5"),
        ("epsilon_2", "6"),
        ("epsilon_3", "7"),
        ("length", "8"),
        ("beta_0", "10"),
        ("beta", "12"),
        ("δε_2", "14"),
        ("x", "link-displacement"),
    ],
)
@pytest.mark.usefixtures("forgetful")
def test_a_proof_fails_where_the_code_derives_something_else(
    monkeypatch: pytest.MonkeyPatch, left: str, key: str
) -> None:
    prove(ENTRIES[key])
    true = link_element.code()
    steps = tuple(replace(s, right=2 * s.right) if str(s.left) == left else s for s in true.steps)
    wrong: Derivation = replace(true, steps=steps)
    monkeypatch.setattr(link_element, "code", lambda: wrong)
    link_element.words.cache_clear()
    with pytest.raises(LedgerError):
        prove(ENTRIES[key])


def test_the_matrix_of_the_code_is_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    true = link_element.code()
    first, *rest = true.functions
    epsilon, matrix = first.outputs
    outputs = (epsilon, replace(matrix, expression=2 * matrix.expression))
    wrong = replace(true, functions=(replace(first, outputs=outputs), *rest))
    monkeypatch.setattr(link_element, "code", lambda: wrong)
    with pytest.raises(LedgerError, match="the code's D"):
        prove(ENTRIES["15"])
