"""Forces that jump where the motion passes: steps end right before, and lead over it at once."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.errors import MotionError
from tests.runtime.test_dynamics_distances import fall

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.dynamics import DynamicsSolver

#: A ball that is pulled towards y = 0, as strongly everywhere.
FALL = """
name = "fall"
unit = "m"
outputs = ["energies"]
[bodies]
ball = { point = true, position = [0, 1, 0], mass = 1 }
[coordinates]
y = { body = "ball", along = [0, 1, 0] }
[forces]
pull = { type = "along", coordinate = "y", force = "-sign(y)" }
"""
#: A bead that passes jumps of a force.
BEAD = """
name = "bead"
unit = "m"
outputs = ["energies"]
parameters = { near = 1e-8, strong = 1e4 }
[bodies]
bead = { point = true, position = [0, 0, 0], velocity = [2, 0, 0], mass = 1 }
[coordinates]
x = { body = "bead", along = [1, 0, 0] }
[forces]
push = { type = "along", coordinate = "x", force = "LAW" }
"""
METHODS = ["dopri5", "dop853"]


def off_by(run: Any) -> float:
    """Largest error of the ball's height in a run."""
    heights = [fall(time) for time in run.time.tolist()]
    return float(np.max(np.abs(run.position["ball"][:, 1] - heights)))


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-12])
def test_errors_of_jumps_that_are_passed_again_and_again_do_not_add_up(
    solver_of: Callable[..., DynamicsSolver], target: str, method: str, tolerance: float
) -> None:
    """Of 18 passages each had left an error of one sign: 4e-4 m at 1e-6, and 5e-6 m at 1e-9."""
    run = solver_of(FALL, target).simulate(50.0, samples=101, method=method, tolerance=tolerance)
    assert off_by(run) < max(1e-3 * tolerance, 1e-10)
    assert run.ledger.trust.is_trusted
    assert run.ledger.derivatives < (2500 if method == "dopri5" else 7000)


@pytest.mark.parametrize("method", METHODS)
def test_no_run_stops_at_an_arc_whose_jump_moves(
    solver_of: Callable[..., DynamicsSolver], method: str
) -> None:
    """Steps were halved before it, as before what is narrow, down to nothing: 80 of 200 stopped."""
    solver = solver_of(BEAD.replace("LAW", "0.3*atan(1/(x - near - 0.2*t))"))
    for k in range(20):
        given = {"near": 0.1 + 0.005 * k}
        run = solver.simulate(1.0, samples=2, method=method, parameters=given)
        exact = solver.simulate(1.0, samples=2, tolerance=1e-12, parameters=given)
        assert run.position["bead"][-1] == pytest.approx(exact.position["bead"][-1], abs=1e-7)
        assert run.ledger.trust.is_trusted


@pytest.mark.parametrize("method", METHODS)
def test_a_logarithm_without_a_value_stops_a_run(
    solver_of: Callable[..., DynamicsSolver], method: str
) -> None:
    """|x|·exp(−log(x)) is 1 as long as x is positive, and nothing behind; it was −1, trusted."""
    text = BEAD.replace("LAW", "abs(x)*exp(-log(x))").replace("[0, 0, 0], vel", "[0.2, 0, 0], vel")
    with pytest.raises(MotionError, match=r"forces\.push"):
        solver_of(text.replace("[2, 0, 0]", "[-1, 0, 0]")).simulate(1.5, samples=2, method=method)


@pytest.mark.parametrize("step", [0.05, 0.3])
def test_steps_of_a_fixed_length_end_before_jumps(
    solver_of: Callable[..., DynamicsSolver], step: float
) -> None:
    run = solver_of(FALL).simulate(50.0, samples=101, method="dopri5", step=step)
    assert off_by(run) < 1e-7
    assert run.ledger.trust.is_trusted


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize("way", [{"tolerance": 1e-6}, {"tolerance": 1e-9}, {"step": 0.05}], ids=str)
def test_events_are_told_where_a_force_jumps(
    solver_of: Callable[..., DynamicsSolver], target: str, way: dict[str, Any]
) -> None:
    events = """[events]
there = { when = "y" }
before = { when = "y - 1e-9", action = "count" }
behind = { when = "y + 1e-5", action = "count" }
low = { when = "y + 0.75", direction = "rising", action = "stop" }
"""
    run = solver_of(FALL + events, target).simulate(20.0, samples=11, method="dopri5", **way)
    quarter = math.sqrt(2.0)
    assert run.stopped_by == "low"
    assert run.time[-1] == pytest.approx(2.0 * quarter + math.sqrt(0.5), abs=1e-9)
    assert [run.events[name].count for name in ("there", "before", "behind")] == [1, 1, 1]
    assert run.events["there"].time == pytest.approx([quarter], abs=1e-9)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("near", [1e-2, 1e-5, 1e-8])
def test_two_jumps_in_one_step_are_both_met(
    solver_of: Callable[..., DynamicsSolver], method: str, near: float
) -> None:
    law = "strong*(sign(x - 1) - sign(x - 1 - near))/2"
    solver = solver_of(BEAD.replace("LAW", law))
    given = {"near": near, "strong": 1e-4 / near}
    run = solver.simulate(20.0, samples=2, method=method, tolerance=1e-9, parameters=given)
    assert run.velocity["bead"][-1, 0] == pytest.approx(math.sqrt(4.0 + 2e-4), rel=2e-9)
    assert run.ledger.trust.is_trusted
    assert run.ledger.steps < 40


#: Strips that brake a bead which comes at 10 m/s: their places, widths and strengths.
STRIPS = [
    (48.87788701425917, 8.969049722832875e-05, 12818.682041262886),
    (47.27474840752924, 0.00019629634198124786, 5112.175093425653),
    (28.29637236269579, 0.00016292610414051512, 13173.10555805594),
    (24.07645021261374, 0.0010694523481605952, 3592.446759702387),
]


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("samples", [2, 101])
@pytest.mark.parametrize(("place", "near", "strong"), STRIPS)
def test_no_run_stops_behind_a_jump_over_which_a_step_has_led(
    solver_of: Callable[..., DynamicsSolver],
    place: float,
    near: float,
    strong: float,
    samples: int,
) -> None:
    """Its error made the next step too small, which was not tried: forces are smooth there."""
    law = "-strong*x_dot*(sign(x - place) + 1)*(sign(place + near - x) + 1)/4"
    text = BEAD.replace("LAW", law).replace("[2, 0, 0]", "[10, 0, 0]")
    text = text.replace("near = 1e-8", "place = 1.0, near = 1e-8")
    given = {"place": place, "near": near, "strong": strong}
    runs = [
        solver_of(text, target).simulate(
            10.0, samples=samples, method="dop853", tolerance=1e-12, parameters=given
        )
        for target in ("c", "numpy")
    ]
    assert np.array_equal(runs[0].rows, runs[1].rows)
    for run in runs:
        assert run.velocity["bead"][-1, 0] == pytest.approx(10.0 - strong * near, abs=1e-9)
        assert run.ledger.trust.is_trusted
        assert run.ledger.steps < 200


@pytest.mark.usefixtures("numpy_solver")
def test_both_targets_pass_jumps_with_the_same_bits(
    solver_of: Callable[..., DynamicsSolver],
) -> None:
    law = "-x - sign(x - 1) - 0.1*sign(x_dot + near*strong)"
    for text in (FALL, BEAD.replace("LAW", law)):
        for method in METHODS:
            runs = [
                solver_of(text, target).simulate(5.0, samples=3, method=method)
                for target in ("c", "numpy")
            ]
            assert np.array_equal(runs[0].rows, runs[1].rows)
            assert runs[0].ledger.derivatives == runs[1].ledger.derivatives


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
def test_friction_that_holds_for_a_while_takes_no_more_steps(
    solver_of: Callable[..., DynamicsSolver], tolerance: float
) -> None:
    """Steps over a jump that throws a bead back onto its belt would be as short as rounding."""
    law = "-sign(x_dot - 3)/2 + 0.3*sin(3*t) + 0*near*strong"
    run = solver_of(BEAD.replace("LAW", law)).simulate(
        5.0, samples=51, method="dopri5", tolerance=tolerance, most_steps=20_000
    )
    assert run.velocity["bead"][-1, 0] == pytest.approx(3.0, abs=10.0 * tolerance)
    assert run.ledger.trust.is_trusted


@pytest.mark.parametrize("method", METHODS)
def test_friction_that_turns_round_is_passed(
    solver_of: Callable[..., DynamicsSolver], method: str
) -> None:
    """Each half-wave loses 0.025 m of its height: the spring is stronger than friction there."""
    law = "-4*x - 0.05*sign(x_dot) + 0*near*strong"
    run = solver_of(BEAD.replace("LAW", law)).simulate(
        20.0, samples=2, method=method, tolerance=1e-9
    )
    centre = -0.0125  # it starts at zero, with 2 m/s
    x, time = centre + math.hypot(centre, 1.0), math.atan2(1.0, -centre) / 2.0  # it stands there
    while time + math.pi / 2.0 < 20.0:
        centre = math.copysign(0.0125, x)
        x, time = 2.0 * centre - x, time + math.pi / 2.0
    centre = math.copysign(0.0125, x)
    wanted = centre + (x - centre) * math.cos(2.0 * (20.0 - time))
    assert run.position["bead"][-1, 0] == pytest.approx(wanted, abs=1e-8)


#: Two bodies that are hinged, and pulled by a third as the angle between them tells.
FAR_HINGE = """
name = "far_hinge"
unit = "m"
gravity = [0.0, 0.0, -9.81]
[bodies]
one = { position = [-0.25, 1.0, -0.75], orientation = { rotation_vector = [0, 3, 4] }, \
boxes = [{ mass = 1.8125, size = [0.4375, 0.484375, 0.953125] }], velocity = [0.5, -0.5, -1.0] }
two = { position = [-0.75, 0.25, -0.75], mass = 1.0, center = [0, 0.1, 0], \
inertia = { xx = 0.59375, yy = 0.7421875, zz = 0.4453125, about = [0.1, 0, 0] }, \
hold = ["orientation"] }
ball = { position = [0.75, -0.75, -0.25], point = true, mass = 0.96875 }
[joints]
hinge = { type = "hinge", bodies = ["one", "two"], at = [0.25, 0.0, 0.0], axis = [0, 0, 1], \
zero = [[-0.7671394197305109, 0.5415437986964646, 0.34384215097765153], [0.0, 1.0, 0.0]] }
[coordinates]
angle = { joint = "hinge" }
[forces]
spring = { type = "spring_damper", bodies = ["one", "ball"], \
points = [[0.0, 1.0, 0.0], [0, 0, 0]], stiffness = 20, damping = 0.5 }
pull = { type = "force", body = "ball", \
force = ["-0.5*sign(angle_dot)*sqrt(abs(angle))", 0.0, "sin(5*t)"] }
"""
FAR = 1e6


@pytest.mark.usefixtures("numpy_solver")
def test_rounding_far_from_the_origin_is_no_crossing(
    solver_of: Callable[..., DynamicsSolver],
) -> None:
    """Angles of joints are rounded as positions are: at t = 0.109 s steps became 1e-12 s long."""
    text = FAR_HINGE
    for x in ("-0.25, 1", "-0.75, 0.25", "0.75, -0.75", "0.25, 0.0, 0.0]"):
        own = x.split(",")[0]
        text = text.replace(f"[{x}", f"[{float(own) + FAR}{x.removeprefix(own)}", 1)
    near = solver_of(FAR_HINGE).simulate(0.25, samples=2, tolerance=1e-11)
    far = [
        solver_of(text, target).simulate(0.25, samples=2, tolerance=2.0**-32, most_steps=300)
        for target in ("c", "numpy")
    ]
    moved = far[0].position["ball"][-1] - [FAR, 0.0, 0.0]
    assert moved == pytest.approx(near.position["ball"][-1], abs=1e-7)
    assert np.array_equal(far[0].rows, far[1].rows)
    assert far[0].ledger.derivatives == far[1].ledger.derivatives
