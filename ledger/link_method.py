"""Yamada and Tatsumi 1981, section 3: transfer functions and the iteration, (17) to (28)."""

from __future__ import annotations

from functools import partial

from kousoku.ledger import link_motion as motion
from kousoku.ledger import link_steps as steps
from kousoku.ledger.entry import LINK_PAPER, Check, Entry
from kousoku.ledger.link_checks import numbers
from kousoku.ledger.link_motion import words

_entry = partial(Entry, LINK_PAPER)

PARTED = r"\mathbf{u} = [L^1] \mathbf{u}^1 + [L^2] \mathbf{u}^2"
#: What (19) says of derivatives by α.
PARTED_SLOPE = r"\mathbf{x}' = [L^1] \mathbf{x}'^1 + [L^2] \mathbf{x}'^2"
SUBSTITUTED = r"[D^0]([L^1] \mathbf{u}^1 + [L^2] \mathbf{u}^2) = \mathbf{0}"
SOLVED = r"\mathbf{u}^1 = -([D^0][L^1])^{-1}[D^0][L^2] \mathbf{u}^2"
FIRST = r"\mathbf{x}'^1 = -([D^0][L^1])^{-1}[D^0][L^2] \mathbf{x}'^2"
SECOND = r"\mathbf{x}''^1 = -([D^0][L^1])^{-1}((d/d\alpha)[D^0])_{ref.} \mathbf{x}'"
VELOCITY = (
    r"\dot{\mathbf{x}} = d\mathbf{x}/dt = (d\mathbf{x}/d\alpha)(d\alpha/dt)"
    r" = \mathbf{x}' \dot{\alpha}"
)
ACCELERATION = (
    r"\begin{aligned} \ddot{\mathbf{x}} &= d^2\mathbf{x}/dt^2 = (d/dt)(\mathbf{x}' \dot{\alpha}) \\"
    r" &= (d\mathbf{x}'/dt) \dot{\alpha} + \mathbf{x}' \ddot{\alpha}"
    r" = \mathbf{x}'' \dot{\alpha}^2 + \mathbf{x}' \ddot{\alpha} \end{aligned}"
)
PREDICTED = (
    r"\mathbf{x}_{adj.} = \mathbf{x}_{ref.} + \Delta\alpha \mathbf{x}'"
    r" + (\Delta\alpha)^2 \mathbf{x}''/2"
)
CORRECTION = r"\mathbf{u}^* = -([D^0][L^1])^{-1} \zeta"
RENEWED = r"\mathbf{x}' \leftarrow \mathbf{x}' + [L^1] \mathbf{u}^*/\Delta\alpha"

ENTRIES: tuple[Entry, ...] = (
    _entry(
        "17",
        "holds",
        r"[D^0] \mathbf{u} = \mathbf{0}",
        reason="Links share the displacements of the nodes at which they meet; each gives its three"
        " rows. To the first order, as (16).",
        vocabulary=words,
        checks=(Check("the motion is rigid", steps.rod_keeps_its_length),),
    ),
    _entry(
        "link-one-independent",
        "holds",
        r"ここでは、1自由度のみが独立であるようなリンク機構を考えることとし、"
        r"独立変数を α (通常はクランクの回転角をとる) として",
        reason="The crank's angle alone is prescribed, so that derivatives by it say all.",
        checks=(Check("of the piston crank's known coordinates", steps.rod_keeps_its_length),),
        is_sentence=True,
    ),
    _entry(
        "link-first-transfer",
        "holds",
        r"\mathbf{x}' = d\mathbf{x}/d\alpha",
        reason="A definition.",
        vocabulary=motion.definitions,
    ),
    _entry(
        "link-second-transfer",
        "holds",
        r"\mathbf{x}'' = d^2\mathbf{x}/d\alpha^2",
        reason="A definition.",
        vocabulary=motion.definitions,
    ),
    _entry(
        "link-known-and-unknown",
        "holds",
        r"次に \mathbf{u}_i を未知部分 (添字1で表す) と既知部分 (添字2で表す) に分け、"
        r"それぞれに結合した行列 $[L_i^1]$ 、 $[L_i^2]$ を導入する。",
        reason="L1 and L2 put the unknown and the known numbers in their places; together they are"
        " the columns of the unit matrix.",
        checks=(numbers("of the piston crank", steps.parts_are_complementary),),
        is_sentence=True,
    ),
    _entry(
        "18",
        "holds",
        r"\mathbf{u}_i = [L_i^1] \mathbf{u}_i^1 + [L_i^2] \mathbf{u}_i^2",
        reason="Shown for the rod, of whose six displacements v3 is known.",
        vocabulary=motion.parted,
    ),
    _entry(
        "19",
        "holds",
        PARTED,
        vocabulary=motion.parted,
        checks=(steps.in_code("u", PARTED), steps.in_code("x′", PARTED_SLOPE)),
    ),
    _entry(
        "20",
        "misprint",
        r"[D^0]([L^2] \mathbf{u}^1 + [L^2] \mathbf{u}^2) = \mathbf{0}",
        SUBSTITUTED,
        "L2 stands twice: the unknown part belongs to L1, as in (19).",
        vocabulary=words,
        checks=(Check("the code's step", steps.is_substituted(SUBSTITUTED)),),
    ),
    _entry(
        "21",
        "holds",
        SOLVED,
        reason="Where D L1 is square and regular: the known displacements must be as many as make"
        " it square, and at a dead point it has no inverse.",
        vocabulary=words,
        checks=(steps.in_code("u_1", SOLVED),),
    ),
    _entry(
        "link-replacement-unknown",
        "misprint",
        r"\mathbf{u}^1/d\alpha = d\mathbf{x}^1/d\alpha = d\mathbf{x}^1/d\alpha = \mathbf{x}'^1",
        r"d\mathbf{u}^1/d\alpha = d\mathbf{x}^1/d\alpha = \mathbf{x}'^1",
        "The d of du is lost, and the term after it stands twice: u over dα is no derivative.",
        vocabulary=words,
    ),
    _entry(
        "link-replacement-known",
        "misprint",
        r"\mathbf{u}^2/d\alpha = d\mathbf{x}^2/d\alpha = d\mathbf{x}^2/d\alpha = \mathbf{x}'^2",
        r"d\mathbf{u}^2/d\alpha = d\mathbf{x}^2/d\alpha = \mathbf{x}'^2",
        "The d of du is lost, and the term after it stands twice, as for the unknown part.",
        vocabulary=words,
    ),
    _entry(
        "22",
        "holds",
        FIRST,
        reason="Exact at every position where the links are rigid, not to the first order only.",
        vocabulary=words,
        checks=(steps.in_code("x′_1", FIRST),),
    ),
    _entry(
        "link-known-second",
        "notation",
        r"\mathbf{x}_2'' = \mathbf{0}",
        r"\mathbf{x}''^2 = \mathbf{0}",
        "The 2 of the known part is a superscript; a subscript counts the elements, and element 2"
        " has a second transfer function that is not zero.",
        vocabulary=words,
    ),
    _entry(
        "23",
        "misprint",
        r"\mathbf{x}''^1 = -([D^0][L^1])^{-1}((d/d\alpha)[D^0]) \text{ref. } \mathbf{x}'^2",
        SECOND,
        "The derivative of D multiplies the whole x′, not its known part: D′ x′ + D x″ = 0. With"
        " x′² the shapes do not fit, and with L2 x′² the accelerations are wrong.",
        vocabulary=words,
        checks=(
            Check("differentiating (22) by α", steps.is_derivative_of_first(FIRST)),
            numbers("with the known part alone", steps.without_unknowns),
            steps.in_code("x″_1", SECOND),
        ),
    ),
    _entry("24", "holds", VELOCITY, vocabulary=words, checks=(steps.in_code("x_dot", VELOCITY),)),
    _entry(
        "25",
        "notation",
        ACCELERATION.replace(r"d^2\mathbf{x}/", r"d\mathbf{x}^2/"),
        ACCELERATION,
        "The superscript 2 of the second derivative belongs to the d: x² is the known part.",
        vocabulary=words,
        checks=(steps.in_code("x_ddot", ACCELERATION),),
    ),
    _entry(
        "26",
        "holds",
        PREDICTED,
        reason="An approximation whose remainder is of the third order in Δα.",
        vocabulary=words,
        checks=(
            numbers("the remainder is of order 3 exactly", steps.third_order),
            steps.in_code("x_adj", PREDICTED),
        ),
    ),
    _entry(
        "link-residual",
        "holds",
        r"式(26)より算出される $\mathbf{x}_{adj.}$ は近似値のため式(5)~式(7)に代入すると、"
        r" ϵ の中の未知の成分に零からの残差を生ずる",
        reason="The residual is of the third order in Δα, like the remainder of (26).",
        checks=(numbers("of the crank", steps.leaves_a_residual),),
        is_sentence=True,
    ),
    _entry(
        "27",
        "holds",
        CORRECTION,
        reason="One step of Newton's method, in the unknown coordinates alone and with the matrix"
        " of the reference position.",
        vocabulary=words,
        checks=(steps.in_code("u^*", CORRECTION),),
    ),
    _entry(
        "link-iteration",
        "holds",
        r"こうして残差がある程度以下になるまで、次式の置き換えを用いて反復計算する。",
        reason="The iteration converges, but slowly: with the matrix of the reference position each"
        " correction gains one power of Δα.",
        checks=(numbers("before and after three corrections", steps.gains_one_order),),
        is_sentence=True,
    ),
    _entry(
        "28",
        "misprint",
        r"\mathbf{x}' \leftarrow \mathbf{x}' + \mathbf{u}^*/\Delta\alpha",
        RENEWED,
        "x′ has all coordinates and u* the unknown ones only: L1 is missing. What x′ becomes leads"
        " to the adjacent position by (26); it is no longer dx/dα.",
        vocabulary=words,
        checks=(
            numbers(
                "x′ grows by Δα²/6 times the third derivative, and higher terms",
                steps.slope_changes,
            ),
            steps.in_code("x′_new", RENEWED),
        ),
    ),
)
