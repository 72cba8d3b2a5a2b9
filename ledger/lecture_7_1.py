"""Lecture 7.1: the variation of the coordinate transformation matrix, and virtual rotation."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from sympy.matrices.expressions import MatrixSymbol, ZeroMatrix

from kousoku.ledger.entry import LECTURE_7_1, Check, Entry
from kousoku.ledger.parser import parse
from kousoku.ledger.proof import difference, different, equal, equality
from kousoku.ledger.rotation_words import DTHETA_B, OMEGA_B, P, in_code, in_steps, words
from kousoku.ledger.vocabulary import Vocabulary
from kousoku.model.errors import LedgerError
from kousoku.model.quantity import Quantity
from kousoku.symbolic.components import Flow, cross, half_turn
from kousoku.symbolic.matrices import elements, symbol

_entry = partial(Entry, LECTURE_7_1)


def _commutator() -> str:
    """Turn by a, then by b, and the other way round: the two differ by a turn about a × b."""
    a = Quantity("a", (3,), "rad", "first rotation")
    b = Quantity("b", (3,), "rad", "second rotation")
    p = elements(P)
    first, second = (Flow(dict(zip(p, half_turn(p, elements(x)), strict=True)), ()) for x in (a, b))
    apart = [first(second(e)) - second(first(e)) for e in p]
    about = half_turn(p, cross(elements(a), elements(b)))
    words = Vocabulary((P, a, b), {}, {"apart": apart, "about": about})
    seen = equality(words, MatrixSymbol("apart", 4, 1), MatrixSymbol("about", 4, 1))
    witness = difference(words, MatrixSymbol("about", 4, 1), ZeroMatrix(4, 1))
    if not witness:
        raise LedgerError("any two rotations commute")
    return f"{seen}; not zero: {witness}"


def _moving() -> Vocabulary:
    """Return the words with ω′ in place of δθ′."""
    swap = dict(zip(elements(DTHETA_B), elements(OMEGA_B), strict=True))
    known = words()
    given = {name: [x.xreplace(swap) for x in cells] for name, cells in known.given.items()}
    return replace(known, given=given).knowing({"δθ'^OB": symbol(OMEGA_B)})


def _rate_for_variation() -> str:
    return equality(_moving(), MatrixSymbol("δA", 3, 3), words().meanings["d/dt A^OB"])


def _sides_correspond() -> str:
    known = _moving()
    (varied,), (moved,) = parse(VARIATION), parse(POISSON)
    left, spatial, body = moved.sides[0], moved.sides[2], moved.sides[1]
    pairs = zip(varied.sides, (left, spatial, body), strict=True)
    return "; ".join(
        f"side {k}, {equality(known, known.value(one), known.value(other))}"
        for k, (one, other) in enumerate(pairs, 1)
    )


def _missing_number() -> str:
    """Look at the numbers around 7.1.9: only one is free there."""
    numbers = [e.equation for e in ENTRIES if e.equation.startswith("7.")]
    place = numbers.index("7.1.9")
    around = numbers[place - 1], numbers[place + 1]
    if around != ("7.12", "7.14") or "7.13" in numbers:
        raise LedgerError(f"7.1.9 stands between {around}")
    return "7.13"


def _numbers_in_order() -> str:
    free = _missing_number()
    return f"7.1.9 stands between 7.12 and 7.14; no equation is printed as ({free}), which is cited"


def _is_missing_number() -> str:
    if not DEFINITION.endswith(rf"\quad ({_missing_number()})"):
        raise LedgerError("the number is another one")
    return f"({_missing_number()}), the one that is missing between 7.12 and 7.14"


#: (7.1.9) with the number that it should have.
DEFINITION = (
    r"\delta \tilde{\boldsymbol{\theta}}^{OB}"
    r" \equiv \delta \mathbf{A}^{OB} (\mathbf{A}^{OB})^T \quad (7.13)"
)

#: (7.16), and (5.16) as it should read: its sides stand in the other order.
VARIATION = (
    r"\delta\mathbf{A}^{OB} \underset{(7.14)}{=} \tilde{\delta\theta}^{OB} \mathbf{A}^{OB}"
    r" = \mathbf{A}^{OB} \tilde{\delta\theta}'^{OB}"
)
POISSON = (
    r"\dot{\mathbf{A}}^{OB} = \mathbf{A}^{OB} \tilde{\boldsymbol{\omega}}'^{OB}"
    r" = \tilde{\boldsymbol{\omega}}^{OB} \mathbf{A}^{OB}"
)

ENTRIES: tuple[Entry, ...] = (
    _entry(
        "s-constant",
        "notation",
        r"点  $P$  は剛体  $B$  に固定されているとする。"
        r"  $\delta \mathbf{r}^P$  を点  $P$  の仮想変位とする。"
        r"  $\mathbf{s}^{IP}$  は不変である",
        r"点  $P$  は剛体  $B$  に固定されているとする。"
        r"  $\delta \mathbf{r}^P$  を点  $P$  の仮想変位とする。"
        r"  $\mathbf{s}'^{P}$  は不変である",
        "The prime of s′ is printed as I. In frame B the vector is constant; in frame O it is not.",
        refutation=(
            equal(
                "s without prime varies: δs = δA s′",
                words,
                r"\delta \mathbf{s}^P",
                r"\delta \mathbf{A}^{OB} \mathbf{s}'^P",
            ),
        ),
        checks=(
            equal(
                "with s′ constant, δr = δr of the origin + δA s′",
                words,
                r"\delta \mathbf{r}^P",
                r"\delta \mathbf{r}^B + \delta \mathbf{A}^{OB} \mathbf{s}'^P",
            ),
        ),
        is_sentence=True,
    ),
    _entry(
        "7.10",
        "notation",
        r"\delta \mathbf{r}^P = \delta \mathbf{r}^B + \delta \mathbf{s}^P ="
        r" \delta \mathbf{r}^B + \delta \mathbf{A}^{OB} \mathbf{s}^{IP}",
        r"\delta \mathbf{r}^P = \delta \mathbf{r}^B + \delta \mathbf{s}^P ="
        r" \delta \mathbf{r}^B + \delta \mathbf{A}^{OB} \mathbf{s}'^{P}",
        "The prime of s′ is printed as I.",
        vocabulary=words,
        checks=(in_steps("7.10", r"\delta \mathbf{r}^P"),),
    ),
    _entry(
        "variation-needed",
        "holds",
        r"式の変形を進めるためには $\delta \mathbf{A}^{OB}$  の計算が必要である",
        reason="The second term of (7.10) does not vanish, and δA is all in it that varies.",
        checks=(
            different(
                "without δA: δr of P is not that of the origin",
                words,
                r"\delta \mathbf{r}^P",
                r"\delta \mathbf{r}^B",
            ),
            equal(
                "with it nothing is left over",
                words,
                r"\delta \mathbf{r}^P - \delta \mathbf{A}^{OB} \mathbf{s}'^P",
                r"\delta \mathbf{r}^B",
            ),
        ),
        is_sentence=True,
    ),
    _entry(
        "orthogonality",
        "holds",
        r"\mathbf{A}^{OB} (\mathbf{A}^{OB})^T = \mathbf{I}_3",
        reason="The transformation matrix is orthogonal.",
        aliases=("4.3",),
        vocabulary=words,
        checks=(
            in_steps("4.3", r"\mathbf{I}_3"),
            in_code("orientation", "A", r"\mathbf{A}^{OB}"),
        ),
    ),
    _entry(
        "7.11",
        "holds",
        r"\mathbf{A}^{OB} (\delta \mathbf{A}^{OB})^T = -\delta \mathbf{A}^{OB} (\mathbf{A}^{OB})^T",
        vocabulary=words,
        checks=(in_steps("7.11", r"\mathbf{A}^{OB} (\delta \mathbf{A}^{OB})^T"),),
    ),
    _entry(
        "7.12",
        "holds",
        r"\mathbf{A}^{OB} (\delta \mathbf{A}^{OB})^T"
        r" = (\delta \mathbf{A}^{OB} (\mathbf{A}^{OB})^T)^T",
        vocabulary=words,
        checks=(in_steps("7.12", r"\mathbf{A}^{OB} (\delta \mathbf{A}^{OB})^T"),),
    ),
    _entry(
        "skew-symmetric",
        "holds",
        r"$\delta \mathbf{A}^{OB} (\mathbf{A}^{OB})^T$  はひずみ対称マトリックスである",
        reason="By (7.11) and (7.12) it is minus its own transpose.",
        checks=(
            equal(
                "δA Aᵀ = −(δA Aᵀ)ᵀ",
                words,
                r"\delta \mathbf{A}^{OB} (\mathbf{A}^{OB})^T",
                r"-(\delta \mathbf{A}^{OB} (\mathbf{A}^{OB})^T)^T",
            ),
        ),
        is_sentence=True,
    ),
    _entry(
        "7.1.9",
        "misprint",
        r"\delta \tilde{\boldsymbol{\theta}}^{OB}"
        r" \equiv \delta \mathbf{A}^{OB} (\mathbf{A}^{OB})^T",
        DEFINITION,
        "The formula is right, its number is not: it is (7.13), by which the lecture cites it.",
        aliases=("7.13",),
        vocabulary=words,
        refutation=(Check("the number as printed is out of order", _numbers_in_order),),
        checks=(
            Check("the corrected number", _is_missing_number),
            in_steps("7.13", r"\delta \tilde{\boldsymbol{\theta}}^{OB}"),
        ),
    ),
    _entry(
        "not-integrable",
        "holds",
        r"$\delta \boldsymbol{\theta}^{OB}$  は積分でき 図4.2 物体上の点  $P$ ないから、"
        r" $\theta^{OB}$  が存在する訳ではない",
        reason="No θ exists whose variation is δθ: two rotations in turn depend on their order.",
        checks=(Check("turning by a, then b, less b, then a, is ½ p∘(0, a × b)", _commutator),),
        is_sentence=True,
    ),
    _entry(
        "frame-of-rotation",
        "holds",
        r"これは 枠  $O$  の成分表示で表わされている",
        reason="δθ without a prime has components in frame O: a point moves by δθ × s there.",
        checks=(
            equal(
                "δs in frame O is δθ × s",
                words,
                r"\delta\mathbf{s}^P",
                r"\tilde{\delta\theta}^{OB} \mathbf{s}^P",
            ),
            different(
                "δs in frame O is not δθ′ × s",
                words,
                r"\delta\mathbf{s}^P",
                r"\tilde{\delta\theta}'^{OB} \mathbf{s}^P",
            ),
        ),
        is_sentence=True,
    ),
    _entry(
        "7.14",
        "holds",
        r"\delta\mathbf{A}^{OB} = \tilde{\delta\theta}^{OB} \mathbf{A}^{OB}",
        vocabulary=words,
        checks=(in_steps("7.14", r"\delta\mathbf{A}^{OB}"),),
    ),
    _entry(
        "7.15",
        "holds",
        r"\delta\theta^{OB} = \mathbf{A}^{OB} \delta\theta'^{OB}",
        vocabulary=words,
        checks=(
            in_steps("7.15", r"\delta\theta^{OB}"),
            in_code("virtual_rotation", "dtheta", r"\delta\theta^{OB}"),
        ),
    ),
    _entry(
        "tilde-turned",
        "holds",
        r"\tilde{\delta\theta}^{OB} = \left( \mathbf{A}^{OB} \delta\theta'^{OB} \right) \sim"
        r" \underset{(4.20)}{=} \mathbf{A}^{OB} \tilde{\delta\theta}'^{OB}"
        r" \left( \mathbf{A}^{OB} \right)^T",
        reason="The skew matrix of a turned vector; (4.20) states it for any vector.",
        aliases=("4.20",),
        vocabulary=words,
        checks=(in_steps("4.20", r"\tilde{\delta\theta}^{OB}"),),
    ),
    _entry(
        "7.16",
        "holds",
        VARIATION,
        vocabulary=words,
        checks=(
            in_steps("7.16", r"\delta\mathbf{A}^{OB}"),
            in_code("virtual_rotation", "dA", r"\delta\mathbf{A}^{OB}"),
        ),
    ),
    _entry(
        "poisson",
        "holds",
        r"この式は  $\mathbf{A}^{OB}$  の時間微分に関するポアソンの方程式(5.16) ([付]参照)"
        r"   と対応している",
        reason="With ω′ in place of δθ′ the sides of (7.16) are those of (5.16) as corrected, the"
        " second and the third exchanged.",
        checks=(Check("(7.16) with ω′ for δθ′ is (5.16)", _sides_correspond),),
        is_sentence=True,
    ),
    _entry(
        "variation-and-rate",
        "holds",
        r"変換マトリックスの変分は変換マトリックスの時間   微分に対応し、"
        r"仮想回転は角速度に対応している。",
        reason="With ω′ in place of δθ′, what is said of δA is said of dA/dt.",
        checks=(Check("δA with ω′ for δθ′ is dA/dt", _rate_for_variation),),
        is_sentence=True,
    ),
    _entry(
        "7.17",
        "holds",
        r"\tilde{\delta\theta}'^{OB} = \left( \mathbf{A}^{OB} \right)^T \delta\mathbf{A}^{OB}",
        vocabulary=words,
        checks=(in_steps("7.17", r"\tilde{\delta\theta}'^{OB}"),),
    ),
    _entry(
        "s-in-frame-O",
        "holds",
        r"\mathbf{s}^P = \mathbf{A}^{OB} \mathbf{s}'^P",
        reason="The vector to P in frame O turns with the body.",
        vocabulary=words,
    ),
    _entry(
        "7.18",
        "holds",
        r"\delta\mathbf{r}^P = \delta\mathbf{r}^B"
        r" + \tilde{\delta\theta}^{OB} \mathbf{A}^{OB} \mathbf{s}'^P"
        r" = \delta\mathbf{r}^B + \tilde{\delta\theta}^{OB} \mathbf{s}^P",
        vocabulary=words,
        checks=(in_steps("7.18", r"\delta\mathbf{r}^P"),),
    ),
    _entry(
        "7.19",
        "misprint",
        r"\delta\mathbf{r}^P = \delta\mathbf{r}^B"
        r" + \mathbf{A}^{OB} \tilde{\delta\theta}'^{OB} \mathbf{s}'^P"
        r" = \delta\mathbf{r}^B - \mathbf{A}^{OB} \tilde{\mathbf{s}}'^P \tilde{\delta\theta}^{OB}",
        r"\delta\mathbf{r}^P = \delta\mathbf{r}^B"
        r" + \mathbf{A}^{OB} \tilde{\delta\theta}'^{OB} \mathbf{s}'^P"
        r" = \delta\mathbf{r}^B - \mathbf{A}^{OB} \tilde{\mathbf{s}}'^P \delta\theta'^{OB}",
        "The last factor is the vector δθ′: printed are a tilde that makes it a matrix, and no"
        " prime.",
        vocabulary=words,
        checks=(
            in_code("virtual_displacement", "dr_P", r"\delta\mathbf{r}^P"),
            in_steps("7.19", r"\delta\mathbf{r}^P"),
        ),
    ),
    _entry(
        "7.20",
        "misprint",
        r"\delta\mathbf{s}^P = \delta\mathbf{A}^{OB} \mathbf{s}'^P"
        r" = \mathbf{A}^{OB} \tilde{\delta\theta}'^{OB} \mathbf{s}'^P"
        r" = -\mathbf{A}^{OB} \tilde{\mathbf{s}}'^P \tilde{\delta\theta}^{OB}",
        r"\delta\mathbf{s}^P = \delta\mathbf{A}^{OB} \mathbf{s}'^P"
        r" = \mathbf{A}^{OB} \tilde{\delta\theta}'^{OB} \mathbf{s}'^P"
        r" = -\mathbf{A}^{OB} \tilde{\mathbf{s}}'^P \delta\theta'^{OB}",
        "The last factor is the vector δθ′, as in (7.19).",
        vocabulary=words,
        checks=(in_steps("7.20", r"\delta\mathbf{s}^P"),),
    ),
    _entry(
        "4.28",
        "notation",
        r"\mathbf{r}^P = \mathbf{r}^B + \mathbf{s}^P"
        r" = \mathbf{r}^B + \mathbf{A}^{OB} \mathbf{s}^{P'}",
        r"\mathbf{r}^P = \mathbf{r}^B + \mathbf{s}^P"
        r" = \mathbf{r}^B + \mathbf{A}^{OB} \mathbf{s}'^{P}",
        "The prime belongs to s, not to the point P.",
        vocabulary=words,
        checks=(
            in_steps("4.28", r"\mathbf{r}^P"),
            in_code("point", "r_P", r"\mathbf{r}^P"),
        ),
    ),
    _entry(
        "5.16",
        "misprint",
        r"\dot{\mathbf{A}}^{OB} = \mathbf{A}^{OB} \tilde{\boldsymbol{\omega}}^{P'OB}"
        r" = \tilde{\boldsymbol{\omega}}^{OB} \mathbf{A}^{OB}",
        POISSON,
        "The P is an index that does not belong: the angular velocity is that of frame B against"
        " frame O, whatever the point; the prime belongs to ω.",
        vocabulary=words,
        checks=(in_code("orientation_rate", "A_dot", r"\dot{\mathbf{A}}^{OB}"),),
    ),
)
