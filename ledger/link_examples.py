"""Yamada and Tatsumi 1981, section 4: the two mechanisms, (29) to (34)."""

from __future__ import annotations

from functools import partial

from kousoku.ledger import link_exact as exact
from kousoku.ledger import link_matrices as matrices
from kousoku.ledger import link_steps as steps
from kousoku.ledger.entry import LINK_PAPER, Check, Entry
from kousoku.ledger.link_assembly import are_faults, are_rows_of, lever, piston
from kousoku.ledger.link_checks import numbers

_entry = partial(Entry, LINK_PAPER)

PISTON_COUNT = (
    r"またリンクの長さは $l_1=1$ cm, $l_2=2$ cm とし, "
    r"解の収束までの反復回数は各ステップにおいて6回~7回であった."
)
LEVER_COUNT = r"反復回数は, 各ステップにおいて6回~7回であった."
#: As they should read.
PISTON_TRUE = PISTON_COUNT.replace("6回~7回", "10回")
LEVER_TRUE = LEVER_COUNT.replace("6回~7回", "11回")
BESIDE = "the {} count beside that of the corrections, with 30 digits"
RENEWED = (
    " Only if x″ is computed anew by (23) in each pass too, and the passes are counted instead of"
    " the corrections, it is"
)

ENTRIES: tuple[Entry, ...] = (
    _entry(
        "link-piston-residual",
        "holds",
        r"計算はクラック回転角1周分に対し, 分割数を60として行い, "
        r"残差は 1.0×10^{-13} cm 以下になるまで, 計算を繰り返した.",
        reason="The iteration as corrected gets there at every one of the 60 positions.",
        checks=(
            numbers("the piston crank, with 30 digits", exact.steps_end_small("piston")),
            numbers("its unknowns are determined", steps.pistons_freedom),
        ),
        is_sentence=True,
    ),
    _entry(
        "link-piston-iterations",
        "misprint",
        PISTON_COUNT,
        PISTON_TRUE,
        "With (26) to (28), D and x″ those of the reference position, every step takes 10"
        f" corrections.{RENEWED} 6 at every step.",
        refutation=(
            Check(BESIDE.format("printed"), exact.takes("piston", PISTON_COUNT, is_true=False)),
        ),
        checks=(
            Check(
                BESIDE.format("corrected"),
                exact.takes("piston", PISTON_TRUE, is_true=True),
            ),
            Check("with x″ renewed", exact.takes_when_renewed("piston", (6, 6))),
        ),
        is_sentence=True,
    ),
    _entry(
        "link-piston-rates",
        "holds",
        r"図5は $\dot{\alpha}=1$ rad/sec, $\ddot{\alpha}=0$ rad/sec²として"
        r"得られた計算の結果を示している.",
        reason="Velocity and acceleration are the transfer functions then, by (24) and (25).",
        checks=(Check("with these rates", exact.rates_are_slopes),),
        is_sentence=True,
    ),
    _entry(
        "link-agreement",
        "holds",
        r"次のように与えられる厳密解¹⁾との一致は良好である.",
        reason="With x′ and x″ taken by (22) and (23) at the position that the iteration reached.",
        checks=(numbers("at all positions, with 30 digits", exact.agrees),),
        is_sentence=True,
    ),
    _entry(
        "30",
        "holds",
        exact.POSITION,
        reason="On the side x > 0, and for a crank that is shorter than the rod.",
        vocabulary=exact.words,
        checks=(Check("the rod closes", exact.closes),),
    ),
    _entry(
        "31",
        "holds",
        exact.VELOCITY,
        reason="For dα/dt = 1: the derivative of (30) by α.",
        vocabulary=exact.words,
    ),
    _entry(
        "32",
        "holds",
        exact.ACCELERATION,
        reason="For dα/dt = 1 and d²α/dt² = 0: the second derivative of (30) by α.",
        vocabulary=exact.words,
    ),
    _entry(
        "link-lever-residual",
        "holds",
        r"この場合も, 1周の分割数は60で, "
        r"残差は 1.0×10^{-13} cm 以下になるまで計算している.",
        reason="The iteration as corrected gets there at every one of the 60 positions.",
        checks=(
            numbers("the lever crank, with 30 digits", exact.steps_end_small("lever")),
            numbers("its unknowns are determined", steps.levers_freedom),
        ),
        is_sentence=True,
    ),
    _entry(
        "link-lever-iterations",
        "misprint",
        LEVER_COUNT,
        LEVER_TRUE,
        "With (26) to (28), D and x″ those of the reference position, every step takes 11"
        f" corrections.{RENEWED} 6 to 7.",
        refutation=(
            Check(BESIDE.format("printed"), exact.takes("lever", LEVER_COUNT, is_true=False)),
        ),
        checks=(
            Check(
                BESIDE.format("corrected"),
                exact.takes("lever", LEVER_TRUE, is_true=True),
            ),
            Check("with x″ renewed", exact.takes_when_renewed("lever", (6, 7))),
        ),
        is_sentence=True,
    ),
    _entry(
        "29",
        "misprint",
        matrices.PISTON_CRANK_PRINTED,
        matrices.PISTON_CRANK,
        "The piston crank has two links and six equations: rows 7 to 12 are those of links 3 and 4"
        " in (33), under the wrong displacements. v3 is known, as the slider stays on the x axis;"
        " without it 7 unknowns are left. And there are six zeros on the right, not ten.",
        vocabulary=piston,
        refutation=(
            are_faults(
                matrices.PISTON_CRANK_PRINTED,
                piston,
                "v_3 is 0, printed as unknown",
                "rows 7 to 12 are of no link of this mechanism",
                "10 zeros for 12 rows",
            ),
            are_rows_of(matrices.PISTON_CRANK_PRINTED, matrices.LEVER_CRANK_PRINTED, 7),
        ),
    ),
    _entry(
        "33",
        "misprint",
        matrices.LEVER_CRANK_PRINTED,
        matrices.LEVER_CRANK,
        "The second part of the matrix has 7 columns, 15 in all for 16 displacements: the column of"
        " ψ42 is lost, and both lengths l4 stand one column too far left. There are twelve zeros on"
        " the right, not sixteen. All other elements, and the four known displacements, are right.",
        vocabulary=lever,
        refutation=(
            are_faults(
                matrices.LEVER_CRANK_PRINTED,
                lever,
                "15 columns for 16 displacements",
                "row 11 has l_4^0 under ψ_32, wanted l_4^0 under ψ_41",
                "row 12 has -l_4^0 under ψ_41, wanted -l_4^0 under ψ_42",
                "16 zeros for 12 rows",
            ),
        ),
    ),
    _entry(
        "link-lever-rates",
        "holds",
        r"また、 $\dot{\alpha}=1 \text{ rad/sec}$, $\ddot{\alpha}=0 \text{ rad/sec}^2$"
        r" として得られた結果を図7, 図8に示している。",
        reason="Velocity and acceleration are the transfer functions then, by (24) and (25).",
        checks=(Check("with these rates", exact.rates_are_slopes),),
        is_sentence=True,
    ),
    _entry(
        "link-grashof",
        "holds",
        r"なお、この例題では $l_1 \sim l_4$ に対して次のように Grashof の定理²⁾に従う"
        r"関係が成立していなければならない。",
        reason="For a crank that is not longer than the frame it is necessary and sufficient for a"
        " full turn. With equality the links come into one line, where (21) has no solution; a"
        " crank that is longer than the frame can turn although it fails.",
        checks=(
            numbers("what coupler and lever must reach", exact.full_turn),
            numbers("the example", exact.is_strict),
            numbers("a frame that is the shortest link", exact.without_it),
        ),
        is_sentence=True,
    ),
    _entry(
        "34",
        "holds",
        exact.GRASHOF,
        reason="Grashof's theorem: all three hold if and only if l1 is the shortest link and, with"
        " the longest, not longer than the other two together.",
        vocabulary=exact.turning,
        checks=(numbers("what coupler and lever must reach", exact.full_turn),),
    ),
)
