"""How entries are shown: on one line, as text, as data, typeset."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest

from kousoku.ledger import entries, find, prove
from kousoku.ledger.printing import as_data, as_text, count_lines, first_words, row
from kousoku.ledger.typesetting import in_words, is_balanced, sentence, typeset, verbatim

if TYPE_CHECKING:
    from collections.abc import Callable


def test_first_words_leave_out_fonts_and_layout_but_no_sign() -> None:
    printed = r"\begin{aligned} \delta\mathbf{a}^i &= \tilde{\mathbf{a}}'^i \\ \end{aligned}"
    assert first_words(printed, 40) == r"\delta a^i = \tilde{a}'^i"
    assert first_words(printed, 12) == r"\delta a^i…"


def test_a_row_names_document_key_and_verdict() -> None:
    assert row(find("7.19"))[:3] == ("lecture 7.1", "7.19", "misprint")


def test_the_counts_add_up() -> None:
    numbers = [[int(n) for n in re.findall(r" (\d+) ", line)] for line in count_lines(entries())]
    for total, *verdicts in numbers:
        assert sum(verdicts) == total
    assert sum(total for total, *_ in numbers[:-1]) == numbers[-1][0] == len(entries())


@pytest.mark.parametrize("key", ["7.1.9", "7.19"])
def test_text_of_an_entry(key: str, golden: Callable[[str], None]) -> None:
    golden(as_text(find(key), prove(find(key))) + "\n")


def test_text_of_an_entry_whose_proof_failed_says_so() -> None:
    assert as_text(find("7.19"), None).endswith("FAILED")


def test_data_of_an_entry_have_what_a_program_asks_for() -> None:
    proof = prove(find("7.13"))
    data = as_data(find("7.13"), proof)
    assert (data["equation"], data["aliases"]) == ("7.1.9", ["7.13"])
    assert (data["verdict"], data["document"]) == ("misprint", "001_9db7d55c2f1b4aef.txt")
    assert data["printed"] != data["corrected"]
    assert len(data["proof"].splitlines()) == len(proof.lines)


@pytest.mark.parametrize(
    ("printed", "body"),
    [
        (r"a = b \tag{29}", r"a = b \quad (29)"),
        (r"\begin{eqnarray} a &=& b\\ c &=& d\\ \end{eqnarray}",
         r"\begin{aligned} a &= b\\ c &= d\end{aligned}"),
        (r"a &=& cross(b) c", r"\begin{aligned} a &= \operatorname{cross}(b) c \end{aligned}"),
        (r"a = b \\ c = d \\", r"\begin{gathered} a = b \\ c = d \end{gathered}"),
    ],
)  # fmt: skip
def test_a_display_is_made_ready_for_math_mode(printed: str, body: str) -> None:
    assert typeset(printed) == body


@pytest.mark.parametrize(
    "printed", ["{a", "a}", r"\left( a", r"\begin{array} a", r"\end{array}{a}", "a^i^T", "a_i_j"]
)
def test_what_latex_would_refuse_is_not_typeset(printed: str) -> None:
    assert not is_balanced(printed)
    assert typeset(printed) == ""


def test_brackets_that_are_only_printed_need_no_partner() -> None:
    assert is_balanced(r"\{(x + u\} - (y + v))")


@pytest.mark.parametrize(
    ("text", "latex"),
    [
        ("ω′ & 50 %", r"$\omega$${}'$ \& 50 \%"),
        ("x̃ of r_A1, and δ_i", r"$\tilde{x}$ of $r_{A1}$, and $\delta_{i}$"),
        ("\u1e7d and が", r"$\tilde{v}$ and が"),
        ("mass_points.inertia", r"mass\_points.inertia"),
        ("12345678901234567", r"12345678\allowbreak 90123456\allowbreak 7"),
    ],
)
def test_plain_words_become_latex(text: str, latex: str) -> None:
    assert in_words(text) == latex


@pytest.mark.parametrize(
    ("text", "latex"),
    [
        (r"点  $P$  は \mathbf{x}_i^0 、", r"点 $P$ は $\mathbf{x}_i^0$ 、"),
        ("the sum over f_ij is missing", "the sum over $f_{ij}$ is missing"),
        ("the letter r_{Ai}^A stands", "the letter $r_{Ai}^A$ stands"),
        ("最大<sup>2)</sup>", "最大2)"),
    ],
)
def test_formulas_in_a_sentence_are_set_in_math_mode(text: str, latex: str) -> None:
    assert sentence(text) == latex


def test_long_lines_are_cut_between_words() -> None:
    assert verbatim("a b c d", width=3) == "a b\nc d"


def test_an_entry_shows_itself_in_a_notebook() -> None:
    assert repr(find("8.11")) == "<(8.11) of lecture 8.2: misprint>"
    shown = find("8.11")._repr_latex_()
    assert re.fullmatch(r"printed: \$\$.+\$\$ corrected: \$\$.+\$\$", shown, re.DOTALL)
    for entry in entries():
        words = ["printed: ", *["corrected: "][: bool(entry.corrected)]]
        assert all(word in entry._repr_latex_() for word in words)
        assert len(repr(entry)) < 80
