"""Lecture 8.2 is read as printed: no index, sign, transpose, tilde or prime of it can change."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest
import sympy
from sympy.matrices.expressions import BlockMatrix

from kousoku.ledger import entries
from kousoku.ledger.documents import lecture_8_2
from kousoku.ledger.documents.lecture_8_2 import (
    block_of_rotation,
    block_of_translation,
    counted,
    in_code,
    minors_are,
    primes,
    rank,
    satisfied,
    vanishing,
    varied_in_code,
)
from kousoku.ledger.documents.lecture_8_2_words import frames, offset, primed, words
from kousoku.ledger.entry import LECTURE_8_2
from kousoku.ledger.parser import parse
from kousoku.ledger.priming import readings
from kousoku.ledger.proof import difference, prove, refuted, value_of
from kousoku.model.errors import LedgerError
from kousoku.model.mechanics.parallel_rows import ROWS
from kousoku.symbolic.bodies import COMPONENTS
from kousoku.symbolic.matrices import neg
from tests.ledger.changes import forms_near

if TYPE_CHECKING:
    from kousoku.ledger.entry import Entry

pytestmark = pytest.mark.release

ENTRIES = {e.equation: e for e in entries() if e.document == LECTURE_8_2}
#: In its own frame the vectrix of O is the identity, and so is its transpose.
READ = [entry for key, entry in ENTRIES.items() if entry.vocabulary and key != "vectrix-O"]
CONSTRAINTS = {"n1": "8.9", "n2": "8.12", "p1": "8.14", "p2": "8.16"}
#: The code's packages of a constraint: of parallel vectors one for each axis.
PACKAGES = {
    "n1": ["n1"],
    "n2": ["n2"],
    "p1": ["p1_x", "p1_y", "p1_z"],
    "p2": ["p2_x", "p2_y", "p2_z"],
}
VARIATIONS = {"n1": "8.11", "n2": "8.13", "p1": "8.15", "p2": "8.17"}
CHANGES = (
    ("+", "-"),
    (" -", " +"),
    ("^T", ""),
    (r"\tilde", r"\vec"),
    ("'", ""),
    *((f"{mark}{one}", f"{mark}{other}") for mark in "^_" for one, other in ("ij", "ji")),
    *((f"{{{one}}}", f"{{{other}}}") for one, other in ("ij", "ji")),
    *((f"O{one}", f"O{other}") for one, other in ("ij", "ji")),
    *((f"{one}T}}", f"{other}T}}") for one, other in ("ij", "ji")),
)


def is_sound(formula: str, entry: Entry) -> bool:
    """Whether no two sides of a formula differ."""
    assert entry.vocabulary is not None
    try:
        refuted(formula, entry.vocabulary())
    except LedgerError as problem:
        assert "the printed form holds" in str(problem)
        return True
    return False


@pytest.mark.parametrize("entry", READ, ids=lambda entry: entry.equation)
def test_no_index_sign_tilde_transpose_or_prime_can_change(entry: Entry) -> None:
    form = entry.true_form
    start = min(form.index(relation) for relation in ("=", r"\equiv") if relation in form)
    texts = forms_near(form, CHANGES, start)  # behind the first relation
    assert texts
    assert is_sound(form, entry)
    assert [text for text in texts if is_sound(text, entry)] == []


def test_a_changed_formula_makes_its_proof_fail() -> None:
    for key, old, new in (
        ("8.11", r"\mathbf{a}^{jT} \delta", r"\mathbf{a}^{iT} \delta"),
        ("8.14", r"(\mathbf{A}^{Oi})^T", r"(\mathbf{A}^{Oj})^T"),
        ("8.17", r"+ \tilde{\mathbf{d}}", r"- \tilde{\mathbf{d}}"),
    ):
        entry = ENTRIES[key]
        assert old in entry.corrected
        with pytest.raises(LedgerError, match=r"^8\.1\d \(lecture 8\.2\): "):
            prove(replace(entry, corrected=entry.corrected.replace(old, new)))


@pytest.mark.parametrize("key", ["8.11", "8.14", "8.15", "8.16", "8.17"])
def test_a_misprint_is_not_put_right_by_primes(key: str) -> None:
    with pytest.raises(LedgerError, match="differ in more than notation"):
        prove(replace(ENTRIES[key], verdict="notation"))


@pytest.mark.parametrize("key", ["8.8", "8.9", "8.10", "8.12", "8.13"])
def test_what_lost_primes_alone_is_no_misprint(key: str) -> None:
    with pytest.raises(LedgerError, match="differ only in notation"):
        prove(replace(ENTRIES[key], verdict="misprint"))


# -- the code ------------------------------------------------------------------------------------


OF_BODY_I, OF_BODY_J = r"(\mathbf{A}^{Oi})^T", r"(\mathbf{A}^{Oj})^T"
#: The last of these in a corrected form, and what it is changed to.
LAST = {
    "8.9": (r"\mathbf{a}'^j", r"\mathbf{a}'^i"),
    "8.11": (r"\tilde{\mathbf{a}}'^{i}", r"\tilde{\mathbf{a}}'^{j}"),
    "8.12": (r"- \mathbf{A}^{Oi}", r"+ \mathbf{A}^{Oi}"),
    "8.13": (r"- \mathbf{d}^{ijT}", r"+ \mathbf{d}^{ijT}"),
    "8.14": (OF_BODY_I, OF_BODY_J),
    "8.15": (OF_BODY_J, OF_BODY_I),
    "8.16": (OF_BODY_I, OF_BODY_J),
    "8.17": (OF_BODY_I, OF_BODY_J),
}


@pytest.mark.parametrize("kind", CONSTRAINTS)
def test_the_code_differs_from_a_formula_that_is_changed(kind: str) -> None:
    for key, tie in ((CONSTRAINTS[kind], in_code), (VARIATIONS[kind], varied_in_code)):
        old, new = LAST[key]
        before, found, after = ENTRIES[key].corrected.rpartition(old)
        assert found
        for package in PACKAGES[kind]:
            with pytest.raises(LedgerError, match="at a rational point"):
                tie(package, before + new + after)


@pytest.mark.parametrize("kind", CONSTRAINTS)
def test_an_equation_fails_when_the_code_derives_another(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    true = lecture_8_2.outputs

    def turned(package: str) -> dict[str, Any]:
        found = dict(true(package))
        blocks = [found["C_q"].expression.blocks[0, k] for k in range(4)]
        blocks[3] = neg(blocks[3])
        found["C_q"] = replace(found["C_q"], expression=BlockMatrix([blocks]))
        found["C"] = replace(found["C"], expression=neg(found["C"].expression))
        return found

    monkeypatch.setattr(lecture_8_2, "outputs", turned)
    for key in (CONSTRAINTS[kind], VARIATIONS[kind]):
        ties = [check for check in ENTRIES[key].checks if check.statement.startswith("the code's")]
        assert len(ties) == len(PACKAGES[kind])
        for check in ties:
            with pytest.raises(LedgerError, match="at a rational point"):
                check.run()


def test_the_offset_in_place_of_a_position_means_the_same() -> None:
    names = ("d^ij", "δd^ij")
    formulas = (
        r"\mathbf{r}^j + \mathbf{s}_j^B - \mathbf{r}^i - \mathbf{s}_i^B",
        r"\delta\mathbf{r}^j + \delta\mathbf{s}_j^B - \delta\mathbf{r}^i - \delta\mathbf{s}_i^B",
    )
    for vocabulary in (words(), offset()):
        for name, formula in zip(names, formulas, strict=True):
            value = value_of(formula, vocabulary)
            assert difference(vocabulary, vocabulary.meanings[name], value) == ""


# -- primes --------------------------------------------------------------------------------------


def test_every_symbol_is_read_in_every_way() -> None:
    (statement,) = parse(r"\mathbf{A}^{Oi} \tilde{\mathbf{s}}_i^{IB} \delta\boldsymbol{\theta}^{i}")
    ways = [str(reading) for reading in readings(statement.sides[0], primed)]
    assert len(ways) == len(set(ways)) == 4
    assert not any("IB" in way for way in ways)


def test_a_wrong_count_of_ways_to_put_primes_is_refused() -> None:
    for count in (0, 2):
        with pytest.raises(LedgerError, match=f"1 of 4 ways to put primes agree, not {count}"):
            primes(count, 3, ENTRIES["8.9"].printed)


def test_primes_are_not_looked_for_where_the_lecture_has_none() -> None:
    (statement,) = parse(r"\vec a \times \vec b")
    with pytest.raises(LedgerError, match="primes are not looked for in Cross"):
        list(readings(statement.sides[0], primed))


def test_the_frames_at_the_points_are_not_those_of_the_bodies() -> None:
    value = {letter: value_of(rf"\mathbf{{{letter}}}^{{(i)}}", frames()) for letter in "eb"}
    assert difference(frames(), value["e"], value["b"])


# -- rows ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["p1", "p2"])
def test_any_two_rows_of_an_axis_without_zeros_are_independent(kind: str) -> None:
    state = satisfied(kind)
    assert [rank(kind, "i", state, rows) for rows in ROWS.values()] == [2, 2, 2]
    for factor in (-2, 1):
        assert rank(kind, "i", satisfied(kind, factor)) == 2
    assert rank("p2", "i", satisfied("p2", 0)) == 2  # d = 0


def test_a_wrong_count_of_rows_is_refused() -> None:
    with pytest.raises(LedgerError, match=r"the number of rows of p2_x is \(2, 1\), not \(3, 1\)"):
        counted("p2", 3)


def test_a_vector_that_does_not_matter_leaves_the_equations() -> None:
    with pytest.raises(LedgerError, match="C is "):
        vanishing("p2", "s^i")


def test_minors_of_another_power_are_refused() -> None:
    x, y, z = COMPONENTS["a_i_b"]
    skew = sympy.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    minors_are(skew, "x", sympy.S.One)
    with pytest.raises(LedgerError, match="a minor is "):
        minors_are(skew**3, "x", sympy.S.One)


@pytest.mark.parametrize("kind", ["p1", "p2"])
def test_the_rank_is_that_of_a_block_of_the_code(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    block = {"p1": block_of_rotation, "p2": block_of_translation}[kind]
    for package in PACKAGES[kind]:
        block(package)
    other = {"p1": "p2", "p2": "p1"}
    true = lecture_8_2.outputs
    monkeypatch.setattr(
        lecture_8_2, "outputs", lambda package: true(other[package[:2]] + package[2:])
    )
    for package in PACKAGES[kind]:
        with pytest.raises(LedgerError):
            block(package)
