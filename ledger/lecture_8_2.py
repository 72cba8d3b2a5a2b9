"""Lecture 8.2: constraints between two vectors. Here the points and the perpendicular vectors."""

from __future__ import annotations

from functools import partial

from kousoku.ledger.checks import different, equal
from kousoku.ledger.entry import LECTURE_8_2, Entry
from kousoku.ledger.priming import only_with
from kousoku.ledger.two_vectors import frames, offset, primed, words
from kousoku.ledger.two_vectors_code import in_code, varied_in_code
from kousoku.ledger.two_vectors_rows import at_zero_offset, counted
from kousoku.symbolic.pairs import D

_entry = partial(Entry, LECTURE_8_2)
_primes = partial(only_with, vocabulary=words, ways=primed)

#: |a × b|² + (a·b)² = |a|²|b|², for any two vectors.
_LAGRANGE = equal(
    "|a × b|² + (aᵀb)² = |a|²|b|²: aᵀb = 0 says |a × b| = |a||b|, a right angle",
    words,
    r"(\tilde{\mathbf{a}}'^i \mathbf{a}'^j)^T \tilde{\mathbf{a}}'^i \mathbf{a}'^j"
    r" + \mathbf{a}'^{iT} \mathbf{a}'^j \mathbf{a}'^{jT} \mathbf{a}'^i",
    r"\mathbf{a}'^{iT} \mathbf{a}'^i \mathbf{a}'^{jT} \mathbf{a}'^j",
)
_CONSTANT_SIZE = equal(
    "a vector fixed in body i keeps its size: aᵀδa = 0",
    words,
    r"\mathbf{a}^{iT} \delta\mathbf{a}^i",
    r"0",
)

_8_8 = (
    r"\mathbf{d}^{ij} = \mathbf{r}^j + \mathbf{A}^{Oj} \mathbf{s}_j^{IB}"
    r" - \mathbf{r}^i - \mathbf{A}^{Oi} \mathbf{s}_i^{IB}"
)
_KNOWN = (
    r"$\mathbf{A}^{Oi}$ ,  $\mathbf{A}^{Oj}$  はそれぞれ枠  $i$  から枠  $O$  へ、枠  $j$"
    r"  から枠  $O$  への座標変換マトリックス、 $\mathbf{s}_i^{IB}$ ,  $\mathbf{s}_j^{IB}$"
    r"  はそれぞれ  $\vec{\mathbf{s}}_i^B$ ,  $\vec{\mathbf{s}}_j^B$"
    r"  の枠  $i$ ,  $j$  の既知成分である。"
)
_8_9 = (
    r"C^{(n1)}(\mathbf{a}^i, \mathbf{a}^j) \equiv \mathbf{a}^{iT} \mathbf{a}^j"
    r" = \mathbf{a}^{iT} (\mathbf{A}^{Oi})^T \mathbf{A}^{Oj} \mathbf{a}^{j}"
    r" = \mathbf{a}^{iT} \mathbf{A}^{ij} \mathbf{a}^j = 0"
)
_8_9_TRUE = (
    r"C^{(n1)}(\mathbf{a}^i, \mathbf{a}^j) \stackrel{(1)}{\equiv} \mathbf{a}^{iT} \mathbf{a}^j"
    r" = \mathbf{a}'^{iT} (\mathbf{A}^{Oi})^T \mathbf{A}^{Oj} \mathbf{a}'^{j}"
    r" = \mathbf{a}'^{iT} \mathbf{A}^{ij} \mathbf{a}'^j = 0"
)
_8_10_I, _8_10_J = (
    rf"\delta \mathbf{{a}}^{b} = \delta \mathbf{{A}}^{{O{b}}} \mathbf{{a}}^{{{b}}}"
    rf" \stackrel{{(7.16)}}{{=}} -\mathbf{{A}}^{{O{b}}} \tilde{{\mathbf{{a}}}}^{{{b}}}"
    rf" \delta \boldsymbol{{\theta}}^{{{b}}}"
    for b in "ij"
)
_8_11 = (
    r"\begin{aligned} \delta C^{(n1)}(\mathbf{a}^i, \mathbf{a}^j) &= \mathbf{a}^{iT}"
    r" \delta \mathbf{a}^j + \mathbf{a}^{iT} \delta \mathbf{a}^i \\"
    r" &\stackrel{(8.10)}{=} -\left\{ \mathbf{a}^{iT} (\mathbf{A}^{Oj})^T \mathbf{A}^{Oj}"
    r" \tilde{\mathbf{a}}^{j} \delta \boldsymbol{\theta}^{j} + \mathbf{a}^{jT}"
    r" (\mathbf{A}^{Oi})^T \mathbf{A}^{Oi} \tilde{\mathbf{a}}^{i} \delta \boldsymbol{\theta}^{i}"
    r" \right\} = 0 \end{aligned}"
)
_8_11_TRUE = (
    r"\begin{aligned} \delta C^{(n1)}(\mathbf{a}^i, \mathbf{a}^j) &= \mathbf{a}^{iT}"
    r" \delta \mathbf{a}^j + \mathbf{a}^{jT} \delta \mathbf{a}^i \\"
    r" &\stackrel{(8.10)}{=} -\left\{ \mathbf{a}'^{iT} (\mathbf{A}^{Oi})^T \mathbf{A}^{Oj}"
    r" \tilde{\mathbf{a}}'^{j} \delta \boldsymbol{\theta}'^{j} + \mathbf{a}'^{jT}"
    r" (\mathbf{A}^{Oj})^T \mathbf{A}^{Oi} \tilde{\mathbf{a}}'^{i}"
    r" \delta \boldsymbol{\theta}'^{i} \right\} = 0 \end{aligned}"
)
_8_11_LINE_2_PRIMED = (
    r"-\left\{ \mathbf{a}'^{iT} (\mathbf{A}^{Oj})^T \mathbf{A}^{Oj} \tilde{\mathbf{a}}'^{j}"
    r" \delta \boldsymbol{\theta}'^{j} + \mathbf{a}'^{jT} (\mathbf{A}^{Oi})^T \mathbf{A}^{Oi}"
    r" \tilde{\mathbf{a}}'^{i} \delta \boldsymbol{\theta}'^{i} \right\}"
)
_8_12 = (
    r"C^{(n2)}(\mathbf{a}^i, \mathbf{d}^{ij}) \stackrel{(1)}{\equiv} \mathbf{a}^{iT}"
    r" \mathbf{d}^{ij} \stackrel{(8.8)}{=} \mathbf{a}^{iT} (\mathbf{A}^{Oi})^T (\mathbf{r}^j"
    r" + \mathbf{A}^{Oj} \mathbf{s}_j^{IB} - \mathbf{r}^i - \mathbf{A}^{Oi}"
    r" \mathbf{s}_i^{IB}) = 0"
)
_8_12_TRUE = (
    r"C^{(n2)}(\mathbf{a}^i, \mathbf{d}^{ij}) \stackrel{(1)}{\equiv} \mathbf{a}^{iT}"
    r" \mathbf{d}^{ij} \stackrel{(8.8)}{=} \mathbf{a}'^{iT} (\mathbf{A}^{Oi})^T (\mathbf{r}^j"
    r" + \mathbf{A}^{Oj} \mathbf{s}_j'^{B} - \mathbf{r}^i - \mathbf{A}^{Oi}"
    r" \mathbf{s}_i'^{B}) = 0"
)
_8_13 = (
    r"\begin{aligned} \delta \mathbf{C}^{(n2)}(\mathbf{a}^i, \mathbf{d}^{ij}) &= \mathbf{a}^{iT}"
    r" \delta \mathbf{d}^{ij} + \mathbf{d}^{ijT} \delta \mathbf{a}^i \\"
    r" &\stackrel{(7.16)}{\equiv} \mathbf{a}^{iT} (\mathbf{A}^{Oi})^T (\delta \mathbf{r}^j"
    r" - \mathbf{A}^{Oj} \tilde{\mathbf{s}}_j^{IB} \delta \boldsymbol{\theta}^{Oj}"
    r" - \delta \mathbf{r}^i + \mathbf{A}^{Oi} \tilde{\mathbf{s}}_i^{IB}"
    r" \delta \boldsymbol{\theta}^{Oi}) - \mathbf{d}^{ijT} \mathbf{A}^{Oi}"
    r" \tilde{\mathbf{a}}^i \delta \boldsymbol{\theta}^{Oi} = 0 \end{aligned}"
)
_8_13_TRUE = (
    r"\begin{aligned} \delta C^{(n2)}(\mathbf{a}^i, \mathbf{d}^{ij}) &= \mathbf{a}^{iT}"
    r" \delta \mathbf{d}^{ij} + \mathbf{d}^{ijT} \delta \mathbf{a}^i \\"
    r" &\stackrel{(7.16)}{\equiv} \mathbf{a}'^{iT} (\mathbf{A}^{Oi})^T (\delta \mathbf{r}^j"
    r" - \mathbf{A}^{Oj} \tilde{\mathbf{s}}_j'^{B} \delta \boldsymbol{\theta}'^{Oj}"
    r" - \delta \mathbf{r}^i + \mathbf{A}^{Oi} \tilde{\mathbf{s}}_i'^{B}"
    r" \delta \boldsymbol{\theta}'^{Oi}) - \mathbf{d}^{ijT} \mathbf{A}^{Oi}"
    r" \tilde{\mathbf{a}}'^i \delta \boldsymbol{\theta}'^{Oi} = 0 \end{aligned}"
)


def _primed(half: str) -> str:
    """Return one half of (8.10) with its primes."""
    for body in "ij":
        for letter in (r"\mathbf{a}", r"\tilde{\mathbf{a}}", r"\boldsymbol{\theta}"):
            half = half.replace(f"{letter}^{{{body}}}", f"{letter}'^{{{body}}}")
    return half


def _vectrix(slug: str, letter: str, frame: str) -> Entry:
    base = r"\vec{\mathbf{%s}}_%s^{(%s)}"
    cells = r" \quad ".join(base % (letter, x, frame) for x in "xyz")
    return _entry(
        f"vectrix-{slug}",
        "holds",
        rf"\mathbf{{{letter}}}^{{({frame})}} = [{cells}]^T",
        reason="A vectrix is the column of a frame's base vectors; their components are its rows.",
        vocabulary=frames,
    )


def _in_two_frames(body: str) -> Entry:
    printed = (
        rf"\vec{{\mathbf{{a}}}}^{body} = \mathbf{{e}}^{{(O)T}} \mathbf{{a}}^{body}"
        rf" = \mathbf{{e}}^{{({body})T}} \mathbf{{a}}^{body}"
    )
    return _entry(
        f"a-{body}-in-two-frames",
        "notation",
        printed,
        printed[: -len(f"^{body}")] + f"'^{body}",
        f"With the base vectors of frame {body} go the components in that frame, a′.",
        vocabulary=frames,
    )


def _turned(body: str) -> Entry:
    left = rf"\mathbf{{a}}^{body} = \mathbf{{A}}^{{O{body}}} \mathbf{{a}}"
    printed = f"{left}^{{{body}}}"
    return _entry(
        f"a-{body}-turned",
        "notation",
        printed,
        f"{left}'^{{{body}}}",
        "The prime of a′ is lost; without it a would be on the axis of A.",
        vocabulary=words,
        checks=(_primes(1, printed, 1),),
    )


ENTRIES: tuple[Entry, ...] = (
    _entry(
        "points-of-bodies",
        "holds",
        r"$B_i$  は物体  $i$  に、 $B_j$  は物体  $j$  に固定されているとする。",
        reason="What (8.13) and (8.17) rest on: s′ is constant, and s varies with A alone.",
        checks=tuple(
            equal(
                f"δs = δA s′ in body {b}",
                words,
                rf"\delta\mathbf{{s}}_{b}^B",
                rf"\delta\mathbf{{A}}^{{O{b}}} \mathbf{{s}}_{b}'^{{B}}",
            )
            for b in "ij"
        ),
        is_sentence=True,
    ),
    _entry(
        "8.7",
        "holds",
        r"\vec{d}^{ij} = \vec{r}^j + \vec{s}_j^B - (\vec{r}^i + \vec{s}_i^B)",
        reason="The position of B_j minus that of B_i.",
        vocabulary=words,
        checks=(
            equal(
                "in components of frame i too",
                words,
                r"(\mathbf{A}^{Oi})^T \vec{d}^{ij}",
                r"(\mathbf{A}^{Oi})^T \vec{r}^j + (\mathbf{A}^{Oi})^T \vec{s}_j^B"
                r" - ((\mathbf{A}^{Oi})^T \vec{r}^i + \mathbf{s}_i'^{B})",
            ),
        ),
    ),
    _entry(
        "8.8",
        "notation",
        _8_8,
        _8_8.replace("^{IB}", "'^{B}"),
        "The prime of s′ is printed as I.",
        vocabulary=words,
        checks=(
            _primes(1, _8_8, 1),
            equal("the code's d is this", words, lambda: D, r"\mathbf{d}^{ij}"),
        ),
    ),
    _entry(
        "known-components",
        "notation",
        _KNOWN,
        _KNOWN.replace("^{IB}", "'^{B}"),
        "The prime of s′ is printed as I. Known are the components in the frame of the body, which"
        " are constant; those in frame O vary.",
        refutation=(
            different(
                "s without a prime is not constant",
                words,
                r"\delta\mathbf{s}_i^B",
                r"\delta\mathbf{s}_i'^B",
            ),
        ),
        checks=tuple(
            equal(
                f"A^O{b} turns components in frame {b} into those in frame O",
                words,
                rf"\mathbf{{A}}^{{O{b}}} \mathbf{{s}}_{b}'^{{B}}",
                rf"\vec{{\mathbf{{s}}}}_{b}^B",
            )
            for b in "ij"
        ),
        is_sentence=True,
    ),
    _vectrix("O", "e", "O"),
    _vectrix("i", "e", "i"),
    _vectrix("j", "e", "j"),
    _vectrix("B-i", "b", "i"),
    _vectrix("B-j", "b", "j"),
    _in_two_frames("i"),
    _in_two_frames("j"),
    _entry(
        "n1-condition",
        "holds",
        r"図8.2に示す二つの物体  $i$ ,  $j$  にうめ込まれた大きさが一定の二つのベクトル",
        reason="Two such vectors are perpendicular where, and only where, (8.9) holds.",
        checks=(_LAGRANGE, _CONSTANT_SIZE),
        is_sentence=True,
    ),
    _entry(
        "8.9",
        "notation",
        _8_9,
        _8_9_TRUE,
        "Behind A belong components in the frames of the bodies: primes are lost. So is the (1)"
        " above ≡, which counts the constraints and which (8.12) has.",
        vocabulary=words,
        checks=(_primes(1, _8_9, 2), _primes(1, _8_9, 3), *in_code("n1", _8_9_TRUE)),
    ),
    _entry(
        "constraint-count",
        "holds",
        r"$\equiv$  の上の ( ) 内の数値は拘束式の数を示している。",
        reason="The numbers are those of independent rows: (8.14) and (8.16) have three rows, of"
        " which two are independent. Above the ≡ of (8.9) the number is lost, and the (7.16) above"
        " that of (8.13) is a reference.",
        checks=(counted("n1", 1), counted("n2", 1), counted("p1", 2), counted("p2", 2)),
        is_sentence=True,
    ),
    _entry(
        "A-ij",
        "holds",
        r"\mathbf{A}^{ij} = (\mathbf{A}^{Oi})^T \mathbf{A}^{Oj}",
        reason="From frame j to frame O, and on to frame i.",
        aliases=("6.29",),
        vocabulary=words,
        checks=(
            equal(
                "turned from frame j to frame i, a^j has the components that it has from frame O",
                words,
                r"\mathbf{A}^{ij} \mathbf{a}'^j",
                r"(\mathbf{A}^{Oi})^T \vec{a}^j",
            ),
        ),
    ),
    _turned("i"),
    _turned("j"),
    _entry(
        "8.10",
        "notation",
        rf"{_8_10_I}, \quad {_8_10_J}",
        rf"{_primed(_8_10_I)}, \quad {_primed(_8_10_J)}",
        "Primes are lost, of δθ too: behind A stand components in the frame of the body. δθ^i is"
        " what (8.13) calls δθ^Oi.",
        vocabulary=words,
        checks=tuple(_primes(1, half, side) for half in (_8_10_I, _8_10_J) for side in (1, 2)),
    ),
    _entry(
        "8.11",
        "misprint",
        _8_11,
        _8_11_TRUE,
        "Two errors, besides lost primes. The second term is a^jT δa^i; a^iT δa^i is always 0. And"
        " the transposed matrices of the second line are exchanged.",
        vocabulary=words,
        refutation=(
            _primes(0, _8_11, 1),
            equal(
                "the second term as printed is always 0",
                words,
                r"\mathbf{a}^{iT}\delta\mathbf{a}^i",
                "0",
            ),
            different(
                "the second line as printed, with the primes that (8.10) gives",
                words,
                r"\delta C^{(n1)}",
                _8_11_LINE_2_PRIMED,
            ),
        ),
        checks=(
            _primes(1, _8_11, 2),
            equal(
                "that one has no prime at all: in frame O, δa = −ã δθ, and AᵀA = I changes nothing",
                words,
                r"\delta\mathbf{a}^j",
                r"-(\mathbf{A}^{Oj})^T \mathbf{A}^{Oj} \tilde{\mathbf{a}}^{j}"
                r" \delta \boldsymbol{\theta}^{j}",
            ),
            _primes(1, _8_11_TRUE.replace("'", ""), 2),
            *varied_in_code("n1", _8_11_TRUE),
        ),
    ),
    _entry(
        "n2-condition",
        "holds",
        r"図8.2に示す物体  $i$  に埋め込まれた大きさが一定のベクトル  $\vec{\mathbf{a}}^i$"
        r"  と、大きさが変化する点間ベクトル  $\vec{\mathbf{d}}^{ij}$  が垂直であるための条件",
        reason="They are perpendicular where, and where d is not 0 only where, (8.12) holds.",
        checks=(
            _LAGRANGE,
            _CONSTANT_SIZE,
            different(
                "the size of d varies: dᵀδd is not 0",
                words,
                r"\mathbf{d}^{ijT} \delta\mathbf{d}^{ij}",
                r"0",
            ),
        ),
        is_sentence=True,
    ),
    _entry(
        "8.12",
        "notation",
        _8_12,
        _8_12_TRUE,
        "Primes are lost, that of s′ to an I.",
        vocabulary=offset,
        checks=(_primes(1, _8_12, 2), *in_code("n2", _8_12_TRUE)),
    ),
    _entry(
        "n2-zero-offset",
        "misprint",
        r"$\mathbf{d}^{ij} = \mathbf{0}$  のとき、この式は成り立たない。",
        r"$\mathbf{d}^{ij} = \mathbf{0}$  のとき、この式は成り立つが、垂直の条件を表さない。",
        "The equation holds there, since aᵀ0 = 0, and its Jacobian keeps rank 1. What fails is its"
        " meaning: 0 has no direction, so that no attitude is excluded.",
        refutation=at_zero_offset()[:1],
        checks=at_zero_offset()[1:],
        is_sentence=True,
    ),
    _entry(
        "8.13",
        "notation",
        _8_13,
        _8_13_TRUE,
        "Primes are lost, that of s′ to an I; the bold C is one number. The second relation is"
        " printed ≡: it is an identity in all δ, not a definition.",
        vocabulary=offset,
        checks=(
            _primes(1, _8_13, 1),
            _primes(1, _8_13, 2),
            equal(
                "δd, differentiated",
                words,
                r"\delta\mathbf{d}^{ij}",
                r"\delta\mathbf{r}^j - \mathbf{A}^{Oj} \tilde{\mathbf{s}}_j'^{B}"
                r" \delta\boldsymbol{\theta}'^{Oj} - \delta\mathbf{r}^i + \mathbf{A}^{Oi}"
                r" \tilde{\mathbf{s}}_i'^{B} \delta\boldsymbol{\theta}'^{Oi}",
            ),
            *varied_in_code("n2", _8_13_TRUE),
        ),
    ),
)
