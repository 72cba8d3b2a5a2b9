"""One body moves as the closed forms of its motion say, to the last digits.

Pendulum A01 of the IFToMM library of benchmark problems: φ = −2 asin(k cd(ωt, k²)) from the
vertical, k = sin(π/4), ω² = 9.81. Heavy top: definition of Brüls, Cardona and Arnold, Mechanism and
Machine Theory 48 (2012); Taylor series of order 30 with 32 digits, checked against the elliptic
functions of its height. Torque-free body: elliptic functions for the angular velocity, Taylor
series for the orientation, checked against the constant angular momentum.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.records.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver

    Mover = Callable[[str | Scene], DynamicsSolver]

#: t, x, y, ẋ, ẏ
PENDULUM = np.array(
    [
        (0.5, -0.391048791550546, -0.920369948785192, 3.91104800395555, -1.66173460754741),
        (3, 0.176651789922838, -0.984273409737893, 4.32536867453874, 0.7762925533434),
        (7, -0.99861877917548, -0.0525407829982987, -0.0533450728427387, 1.01390555064563),
        (10, -0.275087462576117, -0.961419205099125, 4.17559810095173, -1.19474905456048),
    ]
)
#: Centre of mass at 1 s and 2 s
TOP_CENTRES = (
    (0.173343964098386043, 0.640088592070568783, -0.748490791133581309),
    (-0.15041682274564176, -0.724165591636895651, -0.673022269560444096),
)
#: Euler parameters; then ω′₁ and ω′₃, while ω′₂ stays 150
TOP_TURNS = (
    (0.732943980679663718, -0.278285719337612679, 0.531824611334162618, -0.320176142736249281),
    (0.122947135041533467, -0.491079892550027015, 0.350430030343620962, -0.787986887550485669),
)
TOP_RATES = (
    (-0.822078101682704456, -5.92329134811733619),
    (0.122233219497394237, -5.85562458920545773),
)
#: At a time [s]: ω′ and the Euler parameters
Turning = dict[float, tuple[tuple[float, ...], tuple[float, ...]]]
FREE: Turning = {
    1: (
        (0.439875092142373005, 1.02786667584504308, 0.609231783119052629),
        (0.795789637277817041, 0.321372852481080977, 0.365723135416716387, 0.360117940556118198),
    ),
    10: (
        (0.471913952806154153, 1.01355671826833199, 0.617171715395623395),
        (
            0.729597833523539337,
            -0.0301176391584403532,
            -0.333812224756130421,
            -0.596111841630949676,
        ),
    ),
    20: (
        (-0.1185608183172012, 1.11172988282224186, 0.557989446626619869),
        (0.100908208415313747, -0.139704728646542354, -0.594022976081353469, -0.785771484692375011),
    ),
}
FLIPPING: Turning = {
    1: (
        (-0.00648847970338633336, 4.99999588996142463, 0.00383407393691777069),
        (-0.801143500512254317, 0.0001763400372251008, 0.598471822096493283, 0.0007339261993772459),
    ),
    3: (
        (-2.02146664094833057, 4.5731470148611091, 1.16709459491892756),
        (0.339186678385770877, -0.158822144525960857, 0.917750475529898703, 0.132143816648556185),
    ),
    10: (
        (4.51062712401165273, -2.15736968276889587, 2.60421191225993445),
        (0.20320052058628315, -0.670231878449195148, -0.492842339601163567, -0.516338266875870996),
    ),
}


@pytest.mark.parametrize(("scene", "body"), [("pendulum", "rod"), ("pendulum_on_a_rod", "mass")])
@pytest.mark.parametrize(("method", "tolerance"), [("dop853", 1e-15), ("dopri5", 1e-14)])
def test_the_pendulum_a01_swings_as_the_elliptic_functions(
    mover: Mover, scene: str, body: str, method: str, tolerance: float
) -> None:
    motion = mover(scene).simulate(times=PENDULUM[:, 0], tolerance=tolerance, method=method)
    assert motion.position[body][:, :2] == pytest.approx(PENDULUM[:, 1:3], rel=0, abs=1e-12)
    assert motion.velocity[body][:, :2] == pytest.approx(PENDULUM[:, 3:], rel=0, abs=5e-12)
    assert not motion.position[body][:, 2].any()


@pytest.mark.parametrize("samples", [3, 401])
def test_the_heavy_top_reaches_its_place_after_one_and_two_seconds(
    mover: Mover, samples: int
) -> None:
    """It does so where steps end, and between steps."""
    motion = mover("heavy_top").simulate(2, samples=samples, tolerance=3e-15)
    rows = [(samples - 1) // 2, samples - 1]
    turn = motion.orientation["top"][rows]
    assert turn * np.sign(turn[:, :1]) == pytest.approx(np.array(TOP_TURNS), rel=1e-12, abs=1e-12)
    centres = np.array(TOP_CENTRES)
    e0, e = turn[:, :1], turn[:, 1:]
    twice = 2 * np.cross(e, [0, 1, 0])
    assert [0, 1, 0] + e0 * twice + np.cross(e, twice) == pytest.approx(centres, rel=1e-12)
    rates = motion.angular_velocity["top"][rows]
    assert rates[:, ::2] == pytest.approx(np.array(TOP_RATES), rel=1e-12, abs=2e-11)
    assert rates[:, 1] == pytest.approx([150, 150], rel=1e-14)


@pytest.mark.parametrize(
    ("scene", "wanted", "method", "limits"),
    [
        pytest.param("free_body", FREE, "dop853", (1e-12, 1e-12, 1e-12), id="about no axis"),
        pytest.param("free_body", FREE, "dopri5", (1e-12, 1e-12, 1e-12), id="of order 5"),
        # an error grows by exp(2.9 t) near the intermediate axis, and rounding once in the flip
        # before shifts the next one: doubles are good for 2e-9. The weights of dop853, up to 5.8 of
        # either sign, make more of the rounding of its stages than those of dopri5, up to 0.65.
        pytest.param("flipping_body", FLIPPING, "dopri5", (1e-13, 1e-11, 2e-9), id="flipping"),
        pytest.param("flipping_body", FLIPPING, "dop853", (1e-13, 1e-12, 2e-8), id="flip, 8"),
    ],
)
def test_a_body_without_torque_turns_as_the_elliptic_functions(
    mover: Mover,
    scene: str,
    wanted: Turning,
    method: str,
    limits: tuple[float, ...],
) -> None:
    tolerance = {"dopri5": 1e-14, "dop853": 1e-15}[method]
    motion = mover(scene).simulate(
        times=list(wanted), tolerance=tolerance, method=method, checks=False
    )
    turns, rates = motion.orientation["brick"], motion.angular_velocity["brick"]
    for k, ((omega, turn), limit) in enumerate(zip(wanted.values(), limits, strict=True)):
        assert rates[k] == pytest.approx(omega, rel=0, abs=limit)
        sign = np.sign(turns[k] @ turn)
        assert sign * turns[k] == pytest.approx(turn, rel=0, abs=limit)
