"""Andrews' squeezer mechanism moves as its energy says, to the last digits.

Seven bodies with one degree of freedom: positions are closed forms of the angle of the crank, and
T + V − M (β − β₀) = V₀ leaves one quadrature. The numbers here come from it, computed with 30
digits and checked with a Taylor integration of the angle to 4e-14. The solution that the test set
for initial value problems publishes for 0.03 s differs by 7e-11 in β and up to 3e-8 in its rates.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.dynamics import DynamicsSolver

BODIES = ("crank", "coupler", "triangle", "upper_arm", "upper", "lower_arm", "lower")
#: By scene the angle of the crank at the start; by time F, G and H, rates of all bodies, T + V.
VARIANTS: dict[str, tuple[float, dict[float, tuple[list[list[float]], list[float], float]]]] = {
    "andrews_squeezer": (
        -0.06171389001427645,
        {
            0.015: (
                [
                    [0.005665434415839381, -0.00411130792812004],
                    [-0.034116134777435865, 0.01668466482907669],
                    [-0.03193357085678528, -0.016438946988173008],
                ],
                [
                    441.70199325525175,
                    66.34249612637855,
                    46.63421226488486,
                    82.53000583235836,
                    -9.501516255917409,
                    -58.34089346470385,
                    33.69062862357192,
                ],
                1.6244621392818692,
            ),
            0.03: (
                [
                    [-0.00696303942704684, -0.0007183884307192215],
                    [-0.03471521904988391, 0.017758093872270467],
                    [-0.034681333564428374, -0.02223939761003774],
                ],
                [
                    1139.9203022591057,
                    -284.4589929184336,
                    11.032911910623476,
                    19.86694401987033,
                    0.5735699148297546,
                    -18.970194955791296,
                    0.3231791492492789,
                ],
                1.9595884069722127,
            ),
        },
    ),
    "andrews_squeezer_a03": (
        -0.062,
        {
            0.03: (
                [
                    [-0.0069702607817680355, -0.0006445654614904946],
                    [-0.034715126790852285, 0.017757934373031203],
                    [-0.03468138514365873, -0.022239487130114297],
                ],
                [
                    1140.1039755504728,
                    -284.68629649072363,
                    8.018019090535049,
                    14.438719922653366,
                    0.41744980760802686,
                    -13.788345339406161,
                    0.2329247756391779,
                ],
                1.9592481420757406,
            ),
            0.05: (
                [
                    [-0.0051589852501886975, 0.004731265284079456],
                    [-0.03474813759087442, 0.01781489619261509],
                    [-0.0344992609990549, -0.021920010327427897],
                ],
                [
                    1140.9427334471088,
                    -188.23814563928576,
                    -191.91026311679315,
                    -334.9549805787806,
                    1.1194367971686126,
                    295.50931041590417,
                    -40.56510696004506,
                ],
                2.5537486217487566,
            ),
        },
    ),
}
#: The longest link, and the fastest rate.
LENGTH, RATE = 0.04, 1140.0


@pytest.fixture(params=VARIANTS)
def squeezer(
    request: pytest.FixtureRequest, mover: Callable[..., DynamicsSolver]
) -> tuple[str, DynamicsSolver]:
    """Scene, started as in the test set or as in the library of benchmarks."""
    return request.param, mover(request.param, outputs=("energies",))


def test_the_scene_starts_as_defined(squeezer: tuple[str, DynamicsSolver]) -> None:
    name, solver = squeezer
    motion = solver.simulate(times=[0.0])
    crank, coupler = (motion.orientation[body][0] for body in ("crank", "coupler"))
    assert 2 * np.arctan2(crank[3], crank[0]) == pytest.approx(VARIANTS[name][0], abs=1e-15)
    if name == "andrews_squeezer":
        np.testing.assert_allclose(coupler, crank, atol=1e-14)


def test_the_squeezer_moves_as_its_energy_says(squeezer: tuple[str, DynamicsSolver]) -> None:
    name, solver = squeezer
    _, table = VARIANTS[name]
    motion = solver.simulate(times=[0.0, *table], tolerance=1e-14)
    for k, (points, rates, energy) in enumerate(table.values(), 1):
        for body, place in zip(("coupler", "upper_arm", "lower_arm"), points, strict=True):
            np.testing.assert_allclose(
                motion.position[body][k], [*place, 0.0], rtol=0, atol=1e-12 * LENGTH
            )
        found = [motion.angular_velocity[body][k, 2] for body in BODIES]
        np.testing.assert_allclose(found, rates, rtol=0, atol=2e-12 * RATE)
        assert motion.energy["total"][k] == pytest.approx(energy, rel=1e-12)


def test_the_ledger_counts_the_work_of_the_torque(squeezer: tuple[str, DynamicsSolver]) -> None:
    motion = squeezer[1].simulate(0.03, tolerance=1e-12)
    total = motion.energy["total"]
    assert abs(total[-1] - total[0]) > 0.1
    np.testing.assert_allclose(motion.work["motor"], total - total[0], rtol=0, atol=1e-9)
    assert motion.ledger.energy_error is not None
    assert motion.ledger.energy_error < 1e-9
    assert motion.ledger.works == {"motor": motion.work["motor"][-1]}
    assert "work done at the end: motor" in str(motion.ledger)


def test_no_tolerance_errs_by_far_more_than_it_asks_for(
    mover: Callable[..., DynamicsSolver],
) -> None:
    """With one freedom the error along the constraints may vanish by accident: the step then grows.

    Half of what is normal to them counts, too.
    """
    solver = mover("andrews_squeezer")
    points = VARIANTS["andrews_squeezer"][1][0.03][0]
    for tolerance in np.logspace(-6, -11, 21).tolist():
        motion = solver.simulate(times=[0.03], tolerance=tolerance, method="dop853")
        found = [motion.position[body][0, :2] for body in ("coupler", "upper_arm", "lower_arm")]
        error = np.abs(np.subtract(found, points)).max() / LENGTH
        assert error < 5 * tolerance, (tolerance, error)
        assert motion.ledger.derivatives < 95 * tolerance**-0.12
