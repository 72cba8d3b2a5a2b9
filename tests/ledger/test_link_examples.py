"""Section 4 of Yamada and Tatsumi 1981: iterations counted, closed forms, Grashof's theorem."""

from __future__ import annotations

from dataclasses import replace

import mpmath
import pytest

from kousoku.ledger.documents import link_examples
from kousoku.ledger.documents.link_examples import counted_in, takes, takes_when_renewed
from kousoku.ledger.documents.link_iteration import DIVISIONS, run
from kousoku.ledger.proof import prove
from kousoku.ledger.reading import read
from kousoku.model.errors import LedgerError
from tests.ledger.changes import forms_near

pytestmark = pytest.mark.release

ENTRIES = {entry.equation: entry for entry in read(link_examples)}


def test_the_scheme_of_the_paper_takes_ten_and_eleven_corrections() -> None:
    """The paper reports 6 to 7; the project's own solver counts the same as here."""
    assert run("piston").corrections == (10,) * DIVISIONS
    assert run("lever").corrections == (11,) * DIVISIONS


def test_with_a_renewed_second_transfer_function_it_is_six_or_seven_passes() -> None:
    assert run("piston", renews=True).corrections == (5,) * DIVISIONS
    assert sorted(set(run("lever", renews=True).corrections)) == [5, 6]


@pytest.mark.parametrize("renews", [False, True])
@pytest.mark.parametrize("name", ["piston", "lever"])
def test_every_position_closes_and_the_turn_ends_where_it_began(name: str, renews: bool) -> None:
    done = run(name, renews=renews)
    assert len(done.states) == DIVISIONS + 1
    assert done.residual <= 1e-13
    first, last = done.states[0][0], done.states[-1][0]
    places = {"piston": 6, "lever": 8}[name]
    assert max(abs(a - b) for a, b in zip(first[:places], last[:places], strict=True)) < 1e-12


def test_the_iteration_does_not_depend_on_the_precision_that_other_code_sets() -> None:
    known = run("piston")
    run.cache_clear()
    with mpmath.workdps(5):
        assert run("piston") == known


@pytest.mark.parametrize(
    ("sentence", "numbers"),
    [("反復回数は6回~7回", (6, 7)), ("反復回数は10回であった", (10, 10))],
)
def test_a_sentence_states_its_numbers(sentence: str, numbers: tuple[int, int]) -> None:
    assert counted_in(sentence) == numbers


@pytest.mark.parametrize("name", ["piston", "lever"])
def test_the_corrected_sentence_is_the_one_that_is_compared(name: str) -> None:
    entry = ENTRIES[f"link-{name}-iterations"]
    assert counted_in(entry.corrected) == run(name).range != counted_in(entry.printed)
    check = entry.checks[0]
    assert check.statement.startswith("the corrected count")
    assert check.run() == f"{run(name).range[0]} at every step"


def test_a_sentence_with_other_numbers_is_refused() -> None:
    with pytest.raises(LedgerError, match="it takes 10 to 10"):
        takes("piston", "9回~10回", is_true=True)
    with pytest.raises(LedgerError, match="it takes 11 to 11"):
        takes("lever", "11回", is_true=False)
    with pytest.raises(LedgerError, match="5 to 5 corrections"):
        takes_when_renewed("piston", (6, 7))


@pytest.mark.parametrize("key", ["30", "31", "32"])
def test_no_sign_power_or_function_of_the_closed_forms_can_change(key: str) -> None:
    entry = ENTRIES[key]
    prove(entry)
    changes = (
        (" - ", " + "),
        (" + ", " - "),
        ("= -", "= "),
        (r"\cos", r"\sin"),
        (r"\sin", r"\cos"),
        ("l_1", "l_2"),
        ("^2", ""),
        ("^4", "^2"),
        (r"2\alpha", r"\alpha"),
    )
    for text in forms_near(entry.printed, changes):
        with pytest.raises(LedgerError):
            prove(replace(entry, printed=text))


@pytest.mark.parametrize(
    "text",
    [
        r"\begin{cases} l_1 + l_2 \leq l_3 + l_4 \\ l_2 + l_3 \leq l_1 + l_4 \end{cases}",
        r"l_3 + l_4 \leq l_1 + l_2",
        r"l_2 \leq l_3",
    ],
)
def test_other_inequalities_are_refused(text: str) -> None:
    with pytest.raises(LedgerError, match="may be greater"):
        prove(replace(ENTRIES["34"], printed=text))


def test_velocities_are_taken_at_the_position_that_was_reached() -> None:
    seen = str(prove(ENTRIES["link-agreement"]))
    assert [float(part.split()[-1]) < 1e-12 for part in seen.split("; ")] == [True] * 3
