"""Lecture 8.2, second half: parallel vectors, and which of three equations are kept."""

from __future__ import annotations

from functools import partial

from kousoku.ledger.checks import different, equal
from kousoku.ledger.entry import LECTURE_8_2, Check, Entry
from kousoku.ledger.priming import only_with
from kousoku.ledger.two_vectors import offset, primed, words
from kousoku.ledger.two_vectors_code import in_code, varied_in_code
from kousoku.ledger.two_vectors_rows import (
    blocks_with_minors,
    minors,
    only_where_largest,
    ranks,
    vanishing,
    without_bars,
)
from kousoku.model.rows import ROWS

_entry = partial(Entry, LECTURE_8_2)
_primes = partial(only_with, vocabulary=words, ways=primed)

_8_14 = (
    r"\mathbf{C}^{(p1)}(\mathbf{a}^i, \mathbf{a}^j) \stackrel{(2)}{\equiv} \tilde{\mathbf{a}}^i"
    r" \mathbf{a}^j \stackrel{(4.20)}{=} \mathbf{A}^{Oi} \tilde{\mathbf{a}}^i (\mathbf{A}^{Oj})^T"
    r" \mathbf{A}^{Oj} \mathbf{a}^j = \mathbf{0}"
)
_8_14_TRUE = (
    r"\mathbf{C}^{(p1)}(\mathbf{a}^i, \mathbf{a}^j) \stackrel{(2)}{\equiv} \tilde{\mathbf{a}}^i"
    r" \mathbf{a}^j \stackrel{(4.20)}{=} \mathbf{A}^{Oi} \tilde{\mathbf{a}}'^i (\mathbf{A}^{Oi})^T"
    r" \mathbf{A}^{Oj} \mathbf{a}'^j = \mathbf{0}"
)
_8_15 = (
    r"\begin{aligned} \delta \mathbf{C}^{(p1)}(\mathbf{a}^i, \mathbf{a}^j) &="
    r" \tilde{\mathbf{a}}^i \delta \mathbf{a}^j - \tilde{\mathbf{a}}^j \delta \mathbf{a}^i"
    r" \stackrel{(8.10)}{=} -\tilde{\mathbf{a}}^i \mathbf{A}^{Oj} \tilde{\mathbf{a}}^j"
    r" \delta \boldsymbol{\theta}^{Oj} + \tilde{\mathbf{a}}^j \mathbf{A}^{Oi}"
    r" \tilde{\mathbf{a}}^i \delta \boldsymbol{\theta}^{Oi} \\ &\stackrel{(4.20)}{=}"
    r" -\mathbf{A}^{Oi} \tilde{\mathbf{a}}^i (\mathbf{A}^{Oj})^T \mathbf{A}^{Oj}"
    r" \tilde{\mathbf{a}}^j \delta \boldsymbol{\theta}^{Oj} + \mathbf{A}^{Oj}"
    r" \tilde{\mathbf{a}}^j (\mathbf{A}^{Oi})^T \mathbf{A}^{Oi} \tilde{\mathbf{a}}^i"
    r" \delta \boldsymbol{\theta}^{Oi} = 0 \end{aligned}"
)
_8_15_TRUE = (
    r"\begin{aligned} \delta \mathbf{C}^{(p1)}(\mathbf{a}^i, \mathbf{a}^j) &="
    r" \tilde{\mathbf{a}}^i \delta \mathbf{a}^j - \tilde{\mathbf{a}}^j \delta \mathbf{a}^i"
    r" \stackrel{(8.10)}{=} -\tilde{\mathbf{a}}^i \mathbf{A}^{Oj} \tilde{\mathbf{a}}'^j"
    r" \delta \boldsymbol{\theta}'^{Oj} + \tilde{\mathbf{a}}^j \mathbf{A}^{Oi}"
    r" \tilde{\mathbf{a}}'^i \delta \boldsymbol{\theta}'^{Oi} \\ &\stackrel{(4.20)}{=}"
    r" -\mathbf{A}^{Oi} \tilde{\mathbf{a}}'^i (\mathbf{A}^{Oi})^T \mathbf{A}^{Oj}"
    r" \tilde{\mathbf{a}}'^j \delta \boldsymbol{\theta}'^{Oj} + \mathbf{A}^{Oj}"
    r" \tilde{\mathbf{a}}'^j (\mathbf{A}^{Oj})^T \mathbf{A}^{Oi} \tilde{\mathbf{a}}'^i"
    r" \delta \boldsymbol{\theta}'^{Oi} = \mathbf{0} \end{aligned}"
)
_8_16 = (
    r"\mathbf{C}^{(p2)}(\mathbf{a}^i, \mathbf{d}^{ij}) \stackrel{(2)}{\equiv}"
    r" \tilde{\mathbf{a}}^i \mathbf{d}^{ij} \stackrel{(4.20)}{=} \mathbf{A}^{Oi}"
    r" \tilde{\mathbf{a}}^i (\mathbf{A}^{Oj})^T (\mathbf{r}^j + \mathbf{A}^{Oj}"
    r" \mathbf{s}_j^{IB} - \mathbf{r}^i - \mathbf{A}^{Oi} \mathbf{s}_i^{IB}) = \mathbf{0}"
)
_8_16_TRUE = (
    r"\mathbf{C}^{(p2)}(\mathbf{a}^i, \mathbf{d}^{ij}) \stackrel{(2)}{\equiv}"
    r" \tilde{\mathbf{a}}^i \mathbf{d}^{ij} \stackrel{(4.20)}{=} \mathbf{A}^{Oi}"
    r" \tilde{\mathbf{a}}'^i (\mathbf{A}^{Oi})^T (\mathbf{r}^j + \mathbf{A}^{Oj}"
    r" \mathbf{s}_j'^{B} - \mathbf{r}^i - \mathbf{A}^{Oi} \mathbf{s}_i'^{B}) = \mathbf{0}"
)
_8_17 = (
    r"\begin{aligned} \delta \mathbf{C}^{(p2)}(\mathbf{a}^i, \mathbf{d}^{ij}) &="
    r" \tilde{\mathbf{a}}^i \delta \mathbf{d}^{ij} - \tilde{\mathbf{d}}^{ij} \delta \mathbf{a}^i"
    r" \\ &= \mathbf{A}^{Oi} \tilde{\mathbf{a}}^i (\mathbf{A}^{Oj})^T (\delta \mathbf{r}^j"
    r" - \mathbf{A}^{Oj} \tilde{\mathbf{s}}_j^{IB} \delta \boldsymbol{\theta}^{Oj}"
    r" - \delta \mathbf{r}^i + \mathbf{A}^{Oi} \tilde{\mathbf{s}}_i^{IB}"
    r" \delta \boldsymbol{\theta}^{Oi}) + \tilde{\mathbf{d}}^{ij} \mathbf{A}^{Oi}"
    r" \tilde{\mathbf{a}}^i \delta \boldsymbol{\theta}^{Oi} = 0 \end{aligned}"
)
_8_17_TRUE = (
    r"\begin{aligned} \delta \mathbf{C}^{(p2)}(\mathbf{a}^i, \mathbf{d}^{ij}) &="
    r" \tilde{\mathbf{a}}^i \delta \mathbf{d}^{ij} - \tilde{\mathbf{d}}^{ij} \delta \mathbf{a}^i"
    r" \\ &= \mathbf{A}^{Oi} \tilde{\mathbf{a}}'^i (\mathbf{A}^{Oi})^T (\delta \mathbf{r}^j"
    r" - \mathbf{A}^{Oj} \tilde{\mathbf{s}}_j'^{B} \delta \boldsymbol{\theta}'^{Oj}"
    r" - \delta \mathbf{r}^i + \mathbf{A}^{Oi} \tilde{\mathbf{s}}_i'^{B}"
    r" \delta \boldsymbol{\theta}'^{Oi}) + \tilde{\mathbf{d}}^{ij} \mathbf{A}^{Oi}"
    r" \tilde{\mathbf{a}}'^i \delta \boldsymbol{\theta}'^{Oi} = \mathbf{0} \end{aligned}"
)

_P1_CONDITION = (
    r"図8.2において、大きさが一定のベクトル  $\tilde{\mathbf{a}}^i$  と"
    r"  $\tilde{\mathbf{a}}^j$  が平行であるためには、これらのベクトルの外積が  $\mathbf{0}$"
)
_P2_CONDITION = (
    r"図8.2において、大きさが一定の  $\tilde{\mathbf{a}}^i$  と変化する"
    r"  $\tilde{\mathbf{d}}^{ij}$  が平行であるためには"
)
_ROWS = (
    r"このとき  $\mathbf{a}^i$  の三つの要素の絶対値  $a_x^i, a_y^i, a_z^i$  を比較し、"
    r"これらの中の最大値を方程式の項に含む二つの式を用いる"
)

#: |a × b|² + (a·b)² = |a|²|b|², and what it says of parallel vectors.
_LAGRANGE = equal(
    "|a × b|² = |a|²|b|² − (aᵀb)²: a × b = 0 says |aᵀb| = |a||b|, an angle of 0 or 180 degrees",
    words,
    r"(\tilde{\mathbf{a}}'^i \mathbf{a}'^j)^T \tilde{\mathbf{a}}'^i \mathbf{a}'^j",
    r"\mathbf{a}'^{iT} \mathbf{a}'^i \mathbf{a}'^{jT} \mathbf{a}'^j"
    r" - \mathbf{a}'^{iT} \mathbf{a}'^j \mathbf{a}'^{jT} \mathbf{a}'^i",
)
_ONE_DEPENDS = equal(
    "aᵀ(ã b) = 0 for any b: at most two of the three equations are independent",
    words,
    r"\mathbf{a}'^{iT} \tilde{\mathbf{a}}'^i \mathbf{a}'^j",
    r"0",
)


def _varied_one_depends(kind: str) -> Check:
    return equal(
        "aᵀδC = −Cᵀδa, which is 0 where C = 0: nor are more than two variations",
        offset,
        rf"\mathbf{{a}}^{{iT}} \delta\mathbf{{C}}^{{({kind})}}",
        rf"-\mathbf{{C}}^{{({kind})T}} \delta\mathbf{{a}}^i",
    )


def _crossed(text: str, left: str, right: str) -> Check:
    return different(text, words, rf"{left} \times {right}", r"\mathbf{0}")


ENTRIES: tuple[Entry, ...] = (
    _entry(
        "p1-condition",
        "misprint",
        _P1_CONDITION,
        _P1_CONDITION.replace(r"\tilde", r"\vec"),
        "A tilde makes the skew matrix of a vector; parallel are the vectors, which have arrows."
        " Their cross product is 0 where, and only where, they are parallel, or one of them is 0.",
        refutation=(
            _crossed(
                "the cross product of what is printed",
                r"\tilde{\mathbf{a}}^i",
                r"\tilde{\mathbf{a}}^j",
            ),
        ),
        checks=(
            equal(
                "the cross product of the vectors is C",
                words,
                r"\vec{\mathbf{a}}^i \times \vec{\mathbf{a}}^j",
                r"\mathbf{C}^{(p1)}",
            ),
            _LAGRANGE,
            vanishing("p1", "a_i_b"),
            vanishing("p1", "a_j_b"),
        ),
        is_sentence=True,
    ),
    _entry(
        "8.14",
        "misprint",
        _8_14,
        _8_14_TRUE,
        "By (4.20) ã = A ã′ Aᵀ, with one A: the transposed matrix is that of body i. Primes are"
        " lost too.",
        vocabulary=words,
        refutation=(_primes(0, _8_14, 2),),
        checks=(_primes(1, _8_14_TRUE.replace("'", ""), 2), *in_code("p1", _8_14_TRUE)),
    ),
    _entry(
        "p1-rows",
        "holds",
        r"式は三つ得られるが、独立な二つの式を使用する。",
        reason="Of the three equations two are independent where they hold, and not fewer while"
        " neither vector is 0. Rows in frame O are three independent ones elsewhere; in the frame"
        " of i they stay two.",
        checks=(
            _ONE_DEPENDS,
            _varied_one_depends("p1"),
            *blocks_with_minors("p1"),
            *(minors(axis, 2) for axis in ROWS),
            ranks("p1"),
        ),
        is_sentence=True,
    ),
    _entry(
        "8.15",
        "misprint",
        _8_15,
        _8_15_TRUE,
        "In the second line both transposed matrices belong to the other body, as in (8.14)."
        " Primes are lost too.",
        vocabulary=words,
        refutation=(_primes(0, _8_15, 3),),
        checks=(
            _primes(1, _8_15, 1),
            _primes(1, _8_15, 2),
            _primes(1, _8_15_TRUE.replace("'", ""), 3),
            *varied_in_code("p1", _8_15_TRUE),
        ),
    ),
    _entry(
        "p2-condition",
        "misprint",
        _P2_CONDITION,
        _P2_CONDITION.replace(r"\tilde", r"\vec"),
        "A tilde makes the skew matrix of a vector; parallel are the vectors, which have arrows.",
        refutation=(
            _crossed(
                "the cross product of what is printed",
                r"\tilde{\mathbf{a}}^i",
                r"\tilde{\mathbf{d}}^{ij}",
            ),
        ),
        checks=(
            equal(
                "the cross product of the vectors is C",
                words,
                r"\vec{\mathbf{a}}^i \times \vec{\mathbf{d}}^{ij}",
                r"\mathbf{C}^{(p2)}",
            ),
            _LAGRANGE,
            vanishing("p2", "a_i_b"),
        ),
        is_sentence=True,
    ),
    _entry(
        "8.16",
        "misprint",
        _8_16,
        _8_16_TRUE,
        "The transposed matrix is that of body i, as in (8.14). Primes are lost too, that of s′ to"
        " an I.",
        vocabulary=offset,
        refutation=(_primes(0, _8_16, 2),),
        checks=(_primes(1, _8_16_TRUE.replace("'", ""), 2), *in_code("p2", _8_16_TRUE)),
    ),
    _entry(
        "p2-rows",
        "holds",
        r"式(8.16)の三つの式のうち独立な式は二つである。",
        reason="Two where they hold, d = 0 included, while a is not 0. Rows in frame O are three"
        " independent ones elsewhere; in the frame of i they stay two.",
        checks=(
            _ONE_DEPENDS,
            _varied_one_depends("p2"),
            *blocks_with_minors("p2"),
            *(minors(axis, 1) for axis in ROWS),
            ranks("p2"),
        ),
        is_sentence=True,
    ),
    _entry(
        "which-rows",
        "notation",
        _ROWS,
        _ROWS.replace("a_x^i, a_y^i, a_z^i", "|a_x^i|, |a_y^i|, |a_z^i|"),
        "The bars of the absolute values are lost. By aᵀc = 0 the row that is left out is −Σ"
        " (a_m/a_k) c_m of the two that are kept, and no factor is larger than 1. Rows and"
        " components belong to the same frame; in that of i the choice is made once.",
        refutation=(Check("the rule without absolute values", without_bars),),
        checks=(_ONE_DEPENDS, *(minors(axis, 1) for axis in ROWS), *only_where_largest()),
        is_sentence=True,
    ),
    _entry(
        "8.17",
        "misprint",
        _8_17,
        _8_17_TRUE,
        "The transposed matrix is that of body i, as in (8.14). Primes are lost too, that of s′ to"
        " an I.",
        vocabulary=offset,
        refutation=(_primes(0, _8_17, 2),),
        checks=(
            _primes(1, _8_17, 1),
            _primes(1, _8_17_TRUE.replace("'", ""), 2),
            *varied_in_code("p2", _8_17_TRUE),
        ),
    ),
)
