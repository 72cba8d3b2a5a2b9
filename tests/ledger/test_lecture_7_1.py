"""Lecture 7.1: the code's steps are its equations, and what is corrected is what is proved."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest

from kousoku.ledger import entries, find
from kousoku.ledger.documents import lecture_7_1
from kousoku.ledger.documents.lecture_7_1 import is_missing_number
from kousoku.ledger.entry import LECTURE_7_1
from kousoku.ledger.proof import derived, prove
from kousoku.model.errors import LedgerError
from kousoku.symbolic import derive
from kousoku.symbolic.matrices import neg

if TYPE_CHECKING:
    from kousoku.symbolic.derivation import Step


def steps() -> list[tuple[int, str]]:
    """Place and equation of each step on the virtual rotation that cites one."""
    sources = [step.source for step in derive("rotation").steps]
    of_motion = sources.index("5.16")
    return [(k, key) for k in range(of_motion) for key in filter(None, sources[k].split(", "))]


def test_all_equations_of_the_lecture_are_steps_of_the_code() -> None:
    numbers = {find(key).equation for _, key in steps()}
    own = [e.equation for e in entries() if e.document == LECTURE_7_1]
    shown = {key for key in own if key[0] in "47"}
    assert numbers == shown | {"orthogonality", "tilde-turned"}


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(("place", "key"), steps())
def test_a_step_that_says_something_else_is_refused(
    monkeypatch: pytest.MonkeyPatch, place: int, key: str, side: str
) -> None:
    rotation = derive("rotation")

    def wrong(step: Step) -> Step:
        change: dict[str, Any] = {side: neg(getattr(step, side))}
        return replace(step, **change)

    changed = tuple(wrong(s) if k == place else s for k, s in enumerate(rotation.steps))
    monkeypatch.setattr(lecture_7_1, "derive", lambda _: replace(rotation, steps=changed))
    with pytest.raises(LedgerError, match="the code's steps that cite this"):
        prove(find(key))


@pytest.mark.parametrize(
    ("key", "output"),
    [("4.3", "A"), ("7.15", "dtheta"), ("7.16", "dA"), ("7.19", "dr_P"), ("5.16", "A_dot")],
)
def test_an_output_that_is_something_else_is_refused(
    monkeypatch: pytest.MonkeyPatch, key: str, output: str
) -> None:
    monkeypatch.setattr(lecture_7_1, "derived", lambda *names: neg(derived(*names)))
    with pytest.raises(LedgerError, match=rf"the code's rotation\.\w+ gives this as {output}: "):
        prove(find(key))


def test_another_number_is_not_the_one_that_is_missing() -> None:
    with pytest.raises(LedgerError, match="the number is another one"):
        is_missing_number(find("7.1.9").corrected.replace("7.13", "7.15"))


def test_the_equation_of_poisson_corresponds_side_by_side(monkeypatch: pytest.MonkeyPatch) -> None:
    assert str(prove(find("poisson"))).count("all 9 elements equal, identically") == 3
    printed = find("5.16").printed.replace("{P'OB}", "{OB}")  # ω in both, without its prime
    other = replace(find("5.16"), corrected=printed)
    monkeypatch.setattr(lecture_7_1, "find", lambda key: other if key == "5.16" else find(key))
    with pytest.raises(LedgerError, match="element"):
        prove(find("poisson"))
