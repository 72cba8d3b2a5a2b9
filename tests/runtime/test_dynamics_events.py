"""Formulas that read the state: steps end where they switch, and where events are."""

from __future__ import annotations

import math
import pickle
import random
import re
import sys
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.errors import MotionError, SolveError
from kousoku.runtime.integrate.settings import Status
from tests.stress.force_laws import SHAFT

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.dynamics import DynamicsSolver

#: A cart that meets a wall as a spring: it takes 2e4 N/m/kg over half a metre.
WALL = """
name = "wall"
unit = "m"
outputs = ["energies"]
parameters = { at = 50.0, thick = 0.5, hold = 1e4, start = 0.0 }
[bodies]
cart = { position = [0, 0, 0], velocity = [10, 0, 0], boxes = [{ mass = 1, size = [1, 1, 1] }] }
[joints]
rail = { type = "prismatic", bodies = ["ground", "cart"], at = [0, 0, 0], axis = [1, 0, 0] }
[coordinates]
x = { joint = "rail" }
[forces]
wall = { type = "along", coordinate = "x", force = "-hold*max(0, 1 - abs(x - at)/thick)" }
"""
#: A ball that falls onto a spring, and what is told of it.
BALL = """
name = "ball"
unit = "m"
gravity = [0, 0, "-g"]
outputs = ["energies", "coordinates"]
parameters = { k = 1e5, g = 10.0, level = 0.0 }
[bodies]
ball = { point = true, position = [0, 0, 1], mass = 1 }
[coordinates]
z = { body = "ball", along = [0, 0, 1] }
[forces]
mat = { type = "along", coordinate = "z", force = "k*max(0, level - z)" }
[events]
down = { when = "z - level", direction = "falling" }
up = { when = "z - level", direction = "rising", action = "count" }
top = { when = "z_dot", direction = "falling" }
"""
#: A ball on the way up and down: a narrow hill of force along it.
HILL = """
name = "hill"
unit = "m"
parameters = { at = 5.0, width = 1e-3, force = 1.0 }
[bodies]
bead = { point = true, position = [0, 0, 0], velocity = [1, 0, 0], mass = 1 }
[coordinates]
x = { body = "bead", along = [1, 0, 0] }
[forces]
hill = { type = "along", coordinate = "x", force = "LAW" }
"""
#: A mass that oscillates as sin(t), and is told of where it passes a level twice in a step.
SWING = """
name = "swing"
unit = "m"
outputs = ["coordinates"]
parameters = { level = 0.9 }
[bodies]
bob = { point = true, position = [0, 0, 0], velocity = [1, 0, 0], mass = 1 }
[joints.line]
type = "point_on_line"
bodies = ["ground", "bob"]
points = [[0, 0, 0], [0, 0, 0]]
axes = [[1, 0, 0], [1, 0, 0]]
[coordinates]
x = { body = "bob", along = [1, 0, 0] }
[forces]
spring = { type = "along", coordinate = "x", force = "-x" }
[events]
rise = { when = "x - level", direction = "rising" }
fall = { when = "x - level", direction = "falling" }
any = { when = "x - level", action = "count" }
[events.late]
when = "t - 20 + 0*x"
action = "stop"
"""
WAYS: tuple[dict[str, Any], ...] = (
    {"method": "dop853"},
    {"method": "dopri5"},
    {"method": "dop853", "step": 0.0037},
    {"method": "dopri5", "step": 0.001},
)


@pytest.mark.parametrize("way", WAYS, ids=str)
def test_a_cart_comes_back_from_a_wall(solver_of: Callable[..., Any], way: dict[str, Any]) -> None:
    run = solver_of(WALL).simulate(10.0, samples=11, **way)
    inside = math.pi / math.sqrt(2e4)
    close = 1e-7 if "step" not in way else 1e-4
    assert run.velocity["cart"][-1, 0] == pytest.approx(-10.0, abs=close)
    assert run.position["cart"][-1, 0] == pytest.approx(
        49.5 - 10.0 * (10.0 - 4.95 - inside), abs=10.0 * close
    )
    assert run.ledger.trust.is_trusted or "step" in way


def test_no_wall_is_missed(solver_of: Callable[..., Any]) -> None:
    solver, random_ = solver_of(WALL), random.Random(5)
    for k in range(200):
        thick = 10.0 ** random_.uniform(-6.0, 0.0)
        at = random_.uniform(thick + 1.0, 90.0)
        energy = 10.0 ** random_.uniform(1.8, 4.0)  # of the whole wall, 50 J in the cart
        given = {"at": at, "thick": thick, "hold": 2.0 * energy / thick / 2.0}
        run = solver.simulate(
            10.0, samples=random_.choice((2, 101)), parameters=given, method=WAYS[k % 2]["method"]
        )
        # what a step may miss of a place [m] changes the speed by that times the frequency
        close = 2e-7 + 2e-9 * math.sqrt(given["hold"] / thick)
        assert run.velocity["cart"][-1, 0] == pytest.approx(-10.0, abs=close), given
        trust = run.ledger.trust
        assert trust.energy_error < 1e-6, given
        assert trust.is_trusted
        assert trust.limit == pytest.approx(1e-7)
        assert run.ledger.steps < 600


@pytest.mark.parametrize("way", WAYS[:2], ids=str)
@pytest.mark.parametrize("thick", [1e-6, 1e-4])
@pytest.mark.parametrize("inside", [0.0, 0.05])
def test_a_wall_where_a_cart_starts_takes_no_energy(
    solver_of: Callable[..., Any], way: dict[str, Any], thick: float, inside: float
) -> None:
    given = {"at": (1.0 - inside) * thick, "thick": thick, "hold": 2e3 / thick}
    run = solver_of(WALL).simulate(1.0, samples=2, parameters=given, **way)
    speed = math.sqrt(100.0 + 2e3 * inside**2)
    assert run.velocity["cart"][-1, 0] == pytest.approx(-speed, abs=1e-5)
    assert run.ledger.trust.energy_error < 1e-6
    assert run.ledger.trust.is_trusted


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize("way", WAYS[:2], ids=str)
def test_a_bead_that_starts_on_a_jump_loses_no_energy_there(
    solver_of: Callable[..., Any], target: str, way: dict[str, Any]
) -> None:
    solver = solver_of(HILL.replace("LAW", "-force*sign(x - at)"), target)
    for force in (0.1, 1.0, 10.0):
        run = solver.simulate(1.0 / force, samples=2, parameters={"at": 0.0, "force": force}, **way)
        assert run.velocity["bead"][-1, 0] == pytest.approx(0.0, abs=3e-9)  # else 1e-8
        assert run.position["bead"][-1, 0] == pytest.approx(0.5 / force, rel=3e-9)
    still = solver.simulate(1.0, samples=2, parameters={"at": 5.0}, **way)
    assert still.ledger.steps < 20  # it starts beside the jump


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_fixed_steps_are_shorter_over_a_narrow_hill(
    solver_of: Callable[..., Any], target: str
) -> None:
    solver = solver_of(HILL.replace("LAW", "force*exp(-((x - at)/width)^2)"), target)
    for way in WAYS[:2]:
        for width in (1e-6, 1e-3, 1.0):
            run = solver.simulate(10.0, samples=2, step=0.1, parameters={"width": width}, **way)
            speed = math.sqrt(1.0 + 2.0 * width * math.sqrt(math.pi))
            gained = run.velocity["bead"][-1, 0] - 1.0  # steps of a length have no error to keep
            assert gained == pytest.approx(speed - 1.0, rel=0.01)
            assert (run.ledger.steps > 100, run.ledger.unresolved) == (width < 1.0, 0)


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize(
    ("module", "name", "value"),
    [("step_end", "MOST_SHORTER", 0), ("variation", "FINEST", 1.0)],
)
def test_steps_that_are_not_made_shorter_over_a_narrow_hill_are_told(
    solver_of: Callable[..., Any],
    monkeypatch: pytest.MonkeyPatch,
    module: str,
    name: str,
    value: float,
) -> None:
    solver = solver_of(HILL.replace("LAW", "force*exp(-((x - at)/width)^2)"), "numpy")
    solver.simulate(0.1, samples=2)
    for own in [*sys.modules]:
        if re.fullmatch(rf"kousoku_hill\w*\.integrate\.{module}", own):
            monkeypatch.setattr(sys.modules[own], name, value)
    ledger = solver.simulate(10.0, samples=2, step=0.1).ledger
    assert ledger.unresolved >= 1
    assert "do not tell how formulas vary" in str(ledger)
    assert "a smaller step tells more" in str(ledger)
    assert "narrow forces may be passed over" in ledger.trust.why


def test_no_narrow_hill_is_missed(solver_of: Callable[..., Any]) -> None:
    laws = {
        "force*exp(-((x - at)/width)^2)": math.sqrt(math.pi),
        "force/(1 + ((x - at)/width)^2)^2": math.pi / 2.0,
    }
    random_ = random.Random(7)
    for law, area in laws.items():
        solver = solver_of(HILL.replace("LAW", law))
        for k in range(40):
            width = 10.0 ** random_.uniform(-6.0, -2.0)
            given = {"at": random_.uniform(1.0, 9.0), "width": width, "force": 0.1 / width}
            run = solver.simulate(10.0, samples=2, parameters=given, **WAYS[k % 2])
            speed = math.sqrt(1.0 + 2.0 * 0.1 * area)
            far = 2e-3 if "/" in law[5:6] else 1e-7  # its flanks reach beyond both ends
            assert run.velocity["bead"][-1, 0] == pytest.approx(speed, abs=far), given
            assert run.ledger.steps < 400


@pytest.mark.parametrize("way", WAYS, ids=str)
def test_events_of_free_fall_are_at_the_exact_times(
    solver_of: Callable[..., Any], way: dict[str, Any]
) -> None:
    solver, random_ = solver_of(BALL), random.Random(2)
    for _ in range(50):
        level, g = random_.uniform(-2.0, 0.9), random_.uniform(5.0, 15.0)
        given = {"level": level, "g": g, "k": 1e5}
        first = math.sqrt(2.0 * (1.0 - level) / g)
        run = solver.simulate(0.99 * first + 0.02, samples=3, parameters=given, **way)
        assert run.events["down"].time == pytest.approx([first], rel=1e-13)
        states = run.events["down"].states
        assert states.position["ball"][0, 2] == pytest.approx(level, abs=1e-13)
        assert states.velocity["ball"][0, 2] == pytest.approx(-g * first, rel=1e-13)


def test_a_ball_bounces_at_random_stiffness(solver_of: Callable[..., Any]) -> None:
    solver, random_ = solver_of(BALL), random.Random(4)
    for k in range(200):
        stiff, g = 10.0 ** random_.uniform(2.5, 9.0), 10.0
        fall = math.sqrt(2.0 / g)
        omega = math.sqrt(stiff)
        # z = -g/k + A cos(omega t + phase) in contact, from z = 0 with speed -g fall
        contact = 2.0 / omega * (math.pi - math.atan2(g * fall * omega, g))
        period = 2.0 * fall + contact
        run = solver.simulate(
            4.2 * period, samples=2, parameters={"k": stiff}, method=WAYS[k % 2]["method"]
        )
        wanted = [fall + n * period for n in range(4)]
        assert run.events["down"].time == pytest.approx(wanted, abs=2e-7), stiff
        assert run.events["top"].time == pytest.approx(
            [n * period for n in range(1, 5)], abs=2e-7
        ), stiff
        assert run.events["up"].count == 4
        assert len(run.events["up"].states) == 0
        assert run.ledger.energy_error < 1e-6


@pytest.mark.parametrize("way", [*WAYS[:2], {"tolerance": 1e-4}, {"step": 0.9}], ids=str)
@pytest.mark.parametrize("level", [0.0, 0.3, 0.9, 0.99, 0.999, -0.9999])
def test_two_roots_in_a_step_are_found(
    solver_of: Callable[..., Any], way: dict[str, Any], level: float
) -> None:
    solver = solver_of(SWING)
    run = solver.simulate(30.0, samples=2, parameters={"level": level}, **way)
    rises = [math.asin(level) + 2 * math.pi * n for n in range(-1, 4)]
    falls = [math.pi - math.asin(level) + 2 * math.pi * n for n in range(-1, 4)]
    is_rough = bool({"tolerance", "step"} & {*way})
    if is_rough and abs(level) > 0.99:
        return  # so near the turn that the error of a step decides
    close = 0.02 if is_rough else 1e-6
    inside = [[t for t in times if 1e-9 < t < 20.0] for times in (rises, falls)]
    assert run.events["rise"].time == pytest.approx(inside[0], abs=close)
    assert run.events["fall"].time == pytest.approx(inside[1], abs=close)
    assert run.events["any"].count == sum(map(len, inside))


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_events_that_are_flat_at_zero_are_counted_once(
    solver_of: Callable[..., Any], target: Any
) -> None:
    text = WALL.replace("velocity = [10, 0, 0]", "velocity = [7, 0, 0]")
    text = text.replace("-hold*max(0, 1 - abs(x - at)/thick)", "-x")
    flat = '[events]\nflat = { when = "(x - 5)^3" }\nboth = { when = "x_dot*(x - 5)^3" }\n'
    solver = solver_of(text + flat, target)
    for method in ("dopri5", "dop853"):
        for tolerance in (1e-4, 1e-7, 1e-9) if target == "c" else (1e-4,):
            run = solver.simulate(20.0, samples=2, method=method, tolerance=tolerance)
            counts = run.events["flat"].count, run.events["both"].count
            assert counts == (7, 13), (method, tolerance)  # x = 7 sin(t), 5 is passed 7 times


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_an_event_that_is_zero_all_along_is_none(
    solver_of: Callable[..., Any], target: Any
) -> None:
    """Each step ended where rounding changed its side: a run did not end."""
    kept = '[events]\nkept = { when = "x_dot^2 + x^2 - 1" }\n'
    solver = solver_of(SWING[: SWING.index("[events]")].replace("parameters", "# ") + kept, target)
    for tolerance in (1e-6, 1e-9, 1e-12):
        run = solver.simulate(20.0, samples=2, tolerance=tolerance, most_steps=500)
        assert run.events["kept"].count == 0


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize("law", ["t", "2*sin(t)"])
def test_an_event_that_drivers_keep_at_zero_is_none(
    solver_of: Callable[..., Any], target: Any, law: str
) -> None:
    """The polynomial of a step is less exact than its ends: 771 events, and a run that stopped."""
    text = SWING[: SWING.index("[forces]")].replace("parameters", "# ")
    text += f'[drivers]\nd = {{ coordinate = "x", value = "{law}" }}\n'
    text += f'[events]\nkept = {{ when = "x - {law}" }}\nonce = {{ when = "x - 0.9" }}\n'
    for samples in (2, 31):
        run = solver_of(text, target).simulate(3.0, samples=samples, most_steps=200)
        assert run.events["kept"].count == 0
        assert run.events["once"].count == (1 if law == "t" else 2)


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize("driver", ["", 'd = { coordinate = "x", value = "t" }'])
@pytest.mark.parametrize(
    ("when", "count"), [("(x - 1)*(x - 2)", 2), ("sin(pi*x)", 3), ("sin(4*pi*x)", 13)]
)
def test_events_at_both_ends_of_a_step_are_counted(
    solver_of: Callable[..., Any], target: Any, driver: str, when: str, count: int
) -> None:
    """Steps end at rows and at events, between which others must not be taken for zero."""
    text = SWING[: SWING.index("[forces]")].replace("parameters", "# ")
    text += f"[drivers]\n{driver}\n" * bool(driver) + f'[events]\nany = {{ when = "{when}" }}\n'
    solver = solver_of(text, target)
    for method in ("kinematics" if driver else "dopri5", "dop853"):
        run = solver.simulate(times=[0.0, 1.0, 2.0, 3.3], method=method)
        assert run.events["any"].count == count


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize(
    ("when", "law", "samples", "at"),
    [
        ("x - 1 + 1e-6", "sin(t)", 11, [math.pi / 2 - 2**0.5 * 1e-3, math.pi / 2 + 2**0.5 * 1e-3]),
        ("x_dot + 1 - 1e-6", "sin(t)", 2, [math.pi - 2**0.5 * 1e-3, math.pi + 2**0.5 * 1e-3]),
        ("sin(pi*x)^3", "t", 2, [1.0, 2.0, 3.0, 4.0]),
        ("sin(pi*x)^3", "t", 6, [1.0, 2.0, 3.0, 4.0]),
        ("sin(x)*(1 - cos(x))", "2*pi*t", 11, [0.5 * k for k in range(1, 10)]),
        ("max(0, x - 1)*max(0, 4 - x)*cos(3*x)", "t", 2,
         [math.pi / 2, math.pi * 5 / 6, math.pi * 7 / 6]),
        ("tan(3*x)", "t", 2, [math.pi / 3, math.pi * 2 / 3, math.pi, math.pi * 4 / 3]),
        ("tan(pi*x - pi/2)", "t", 6, [0.5, 1.5, 2.5, 3.5, 4.5]),
        ("max(0, 0.1 - abs(x - 2.1))*(x - 2.1)", "", 6, [2.1]),
        ("max(0, t - 2)*max(0, 2.2 - t)*(x - 2.1)", "", 2, [2.1]),
        ("exp(-((x - 2)/0.01)^2)*(x - 2)", "", 2, [2.0]),
        ("max(0, sin(x) - 0.8) - max(0, -0.8 - sin(x))", "", 2, [math.pi + math.asin(0.8)]),
        ("sign(x - 2.3)*abs(x - 2.3)^(1/6)", "", 2, [2.3]),
        ("1/(1 + ((x - 2.1)/(0.002*(sin(3*x)^2 + cos(3*x)^2)))^2) - 0.5", "", 2, [2.098, 2.102]),
        ("1/(1 + ((t - 2.1)^5/(0.001*(t - 2.1)^4))^2) - 0.5", "", 2, [2.099, 2.101]),
        ("min(1/(t - 2)^2, 300) - 100", "", 2, [1.9, 2.1]),
        ("2*asin(sin(3*t)*cos(t)*1.8/(1.6 + sin(t)^2)) - 2", "", 2,
         [0.3363434981303218, 0.5248946400072664, 3.477936151720115, 3.6664872935970596]),
        ("(x - 1)*abs(x - 2.1)/(x - 1) - 0.3", "", 2, [1.8, 2.4]),
        ("(t - 1)*max(0, t - 2)/sin((t - 1)/9) - 18", "", 2, [3.96404108271334]),
    ],
)  # fmt: skip
def test_no_event_is_lost_where_polynomials_are_vague_or_formulas_flat(
    solver_of: Callable[..., Any], target: Any, when: str, law: str, samples: int, at: list[float]
) -> None:
    """Peaks of driven motions, poles, gates: 0 to half of them were found, or at other places."""
    text = SWING[: SWING.index("[forces]")].replace("parameters", "# ")
    text += f'[drivers]\nd = {{ coordinate = "x", value = "{law}" }}\n' * bool(law)
    solver = solver_of(text + f'[events]\nany = {{ when = "{when}" }}\n', target)
    run = solver.simulate(4.9, samples=samples)
    assert run.events["any"].time == pytest.approx(at, abs=1e-6)


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_an_event_that_is_zero_for_a_while_is_where_it_leaves_zero(
    solver_of: Callable[..., Any], target: Any
) -> None:
    """Trials thrown off by a wall "crossed" where the formula is zero: 4 events for 2."""
    text = SWING[: SWING.index("[forces]")].replace("parameters", "# ")
    text += '[forces]\nwall = { type = "along", coordinate = "x", force = "-1e5*max(0, x - 1)" }\n'
    text += '[events]\nband = { when = "max(0, 0.2 - x) - max(0, x - 0.8)" }\n'
    text += 'once = { when = "max(0, x - 0.5) - max(0, -x)" }\n'
    contact = math.pi / math.sqrt(1e5)
    for tolerance in (1e-4, 1e-9):
        run = solver_of(text, target).simulate(2.5, samples=101, tolerance=tolerance)
        known = 100.0 * tolerance
        assert run.events["band"].time == pytest.approx([0.8, 1.8 + contact], abs=known)
        assert run.events["once"].time == pytest.approx([2.0 + contact], abs=known)


@pytest.mark.parametrize("step", [1.0, 0.5])
def test_steps_that_are_multiples_of_a_wave_lose_none_of_its_zeros(
    solver_of: Callable[..., Any], step: float
) -> None:
    """Asked at hundredths of a step, a wave of 100 zeros was taken for one that is zero."""
    text = SWING[: SWING.index("[forces]")].replace("parameters", "# ")
    solver = solver_of(text + '[events]\nany = { when = "sin(200*pi*x)" }\n', "c")
    assert solver.simulate(4.0025, samples=2, step=step).events["any"].count == 800


def test_a_run_that_an_event_ends_says_so(solver_of: Callable[..., Any]) -> None:
    run = solver_of(SWING).simulate(30.0, samples=31)
    assert run.stopped_by == "late"
    assert run.time[-1] == pytest.approx(20.0, abs=1e-13)
    assert len(run) == 22 or (len(run) == 21 and run.time[-2] == 19.0)
    assert not run.is_complete
    assert run.coordinate["x"][-1] == pytest.approx(math.sin(20.0), abs=1e-7)
    assert "ended at t = 20 s by events.late" in run.notes
    assert "ended at t = 20 s by events.late" in repr(run)
    assert run.summary()["stopped_by"] == "late"
    assert run.ledger.events["any"] == run.events["any"].count
    assert "events: rise 4, fall 3, any 7, late 1" in str(run.ledger)


def test_a_run_is_cut_at_events_with_the_same_bits(solver_of: Callable[..., Any]) -> None:
    solver = solver_of(SWING)
    whole = solver.begin(np.linspace(0.0, 30.0, 100))
    run = whole.finish()
    parts = solver.begin(np.linspace(0.0, 30.0, 100))
    statuses = []
    while True:
        statuses.append(parts.advance(1, 3))
        if statuses[-1] in {Status.GOOD, Status.STOPPED}:
            break
        parts = solver.resume(pickle.loads(pickle.dumps(parts.save())))
    again = parts.motion()
    assert Status.EVENT in statuses
    assert statuses[-1] == Status.STOPPED
    assert parts.advance() == Status.STOPPED
    assert np.array_equal(again.rows, run.rows)
    assert np.array_equal(again.told.rows, run.told.rows)
    assert again.told.counts == run.told.counts
    assert np.array_equal(parts.motion().told.rows, run.told.rows)
    restarted = whole.restart().finish()
    assert np.array_equal(restarted.told.rows, run.told.rows)


@pytest.mark.release
def test_both_targets_have_the_same_events_and_bits(solver_of: Callable[..., Any]) -> None:
    for text, given in (
        (WALL, {"thick": 0.3}),
        (BALL, {"k": 3e4}),
        (SWING, {"level": 0.99}),
        (HILL.replace("LAW", "force*exp(-((x - at)/width)^2)"), {"force": 1e3}),
    ):
        for way in (*WAYS[:2], {"step": 0.031}):
            runs = [
                solver_of(text, target=target).begin(
                    np.linspace(0.0, 8.0, 7), parameters=given, **way
                )
                for target in ("c", "numpy")
            ]
            for run in runs:
                run.finish()
            first, second = (run.save() for run in runs)
            assert np.array_equal(first.rows, second.rows)
            assert np.array_equal(first.state, second.state)
            assert np.array_equal(first.events, second.events)


#: A bob on a spring, in millimetres: steps look at one function and nothing else.
BOB = """
name = "bob"
unit = "mm"
[bodies]
bob = { point = true, position = [300, 0, 0], mass = 1 }
[coordinates]
x = { body = "bob", along = [1, 0, 0] }
[forces]
spring = { type = "along", coordinate = "x", force = "FORCE" }
[events]
passes = { when = "WHEN" }
"""


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize(
    ("force", "when", "count"),
    [
        ("-x - 1e-6*x^3", "x*(x - 100)", 6),
        ("1e-9*cos(t)", "x_dot", 0),  # so slow that rounding would decide
    ],
)
def test_both_targets_end_their_steps_at_a_single_event_with_the_same_bits(
    solver_of: Callable[..., Any], force: str, when: str, count: int
) -> None:
    text = BOB.replace("FORCE", force).replace("WHEN", when)
    first, second = (
        solver_of(text, target=target).begin([0.0, 9.0], tolerance=1e-6)
        for target in ("c", "numpy")
    )
    assert first.finish().ledger.events["passes"] == count
    second.finish()
    assert np.array_equal(first.save().state, second.save().state)


@pytest.mark.usefixtures("numpy_solver")
def test_steps_of_kinematics_pass_an_event_just_behind_their_start(
    solver_of: Callable[..., Any],
) -> None:
    text = SHAFT.format(law="t", load="0") + '[events]\npasses = { when = "turn - 1e-10" }\n'
    first, second = (
        solver_of(text, target=target).begin([0.0, 1.0], tolerance=1e-12)
        for target in ("c", "numpy")
    )
    assert first.finish().ledger.events["passes"] == 1
    second.finish()
    assert np.array_equal(first.save().state, second.save().state)


#: A shaft that is led, what hits it, and where it is.
HIT = (
    SHAFT.format(law="2*t + sin(t)", load="1e3*max(0, 1 - abs(turn - 5)/1e-3)")
    + """
brush = { type = "along", coordinate = "turn", force = "1e3*exp(-((turn - 9)/1e-3)^2)" }
[events]
turned = { when = "sin(turn)", direction = "rising" }
slow = { when = "turn_dot - 2", direction = "falling", action = "count" }
enough = { when = "turn - 16", action = "stop" }
"""
)
#: A jump from a bridge: the rope acts once it is straight, by its own law.
JUMP = """
name = "jump"
unit = "cm"
gravity = [0, 0, -1000]
outputs = ["energies"]
parameters = { k = 100.0, rope = 200.0 }
[bodies]
man = { point = true, position = [0, 0, -1e-3], mass = 1 }
[forces.rope_law]
type = "spring_damper"
bodies = ["ground", "man"]
points = [[0, 0, 0], [0, 0, 0]]
free_length = "rope"
tension = "k*max(0, x)"
[coordinates]
z = { body = "man", along = [0, 0, 1] }
[events]
lowest = { when = "z_dot", direction = "rising" }
"""


@pytest.mark.parametrize("rows", [2, 100])
def test_drivers_lead_to_events_and_through_narrow_forces(
    solver_of: Callable[..., Any], rows: int
) -> None:
    run = solver_of(HIT).simulate(12.0, samples=rows)

    def when(turn: float) -> float:
        t = turn / 2.0
        for _ in range(60):
            t -= (2.0 * t + math.sin(t) - turn) / (2.0 + math.cos(t))
        return t

    assert run.method == "kinematics"
    assert run.stopped_by == "enough"
    assert run.time[-1] == pytest.approx(when(16.0), abs=1e-8)
    assert run.events["turned"].time == pytest.approx(
        [when(2 * math.pi * n) for n in (1, 2)], abs=1e-8
    )
    assert run.events["slow"].count == 1  # cos(t) falls through zero
    assert run.ledger.works["load"] == pytest.approx(1.0, rel=1e-4)
    assert run.ledger.works["brush"] == pytest.approx(math.sqrt(math.pi), rel=1e-4)


def test_a_rope_is_felt_where_it_is_straight(solver_of: Callable[..., Any]) -> None:
    solver = solver_of(JUMP)
    for k in range(40):
        stiff, rope = 10.0 ** random.Random(k).uniform(1.0, 7.0), random.Random(k).uniform(10, 300)
        run = solver.simulate(
            20.0, samples=2, parameters={"k": stiff, "rope": rope}, method=WAYS[k % 2]["method"]
        )
        # m g (rope + d) = k d^2/2, from 1e-5 m below the bridge; k is the same in any unit
        fall = (rope - 1e-3) / 100.0
        deep = (10.0 + math.sqrt(100.0 + 2.0 * stiff * 10.0 * fall)) / stiff
        lowest = run.events["lowest"].states.position["man"][:, 2]
        assert len(lowest) > 3
        assert lowest == pytest.approx(-(rope + 100.0 * deep), rel=1e-7)
        assert run.ledger.trust.is_trusted


def test_events_that_touch_or_stay_are_none(solver_of: Callable[..., Any]) -> None:
    text = SWING.replace(
        "[events]", '[events]\ntouch = { when = "1 + 1e-12 - x" }\nstays = { when = "x - x" }'
    )
    run = solver_of(text).simulate(19.0, samples=2)
    assert run.events["touch"].count == run.events["stays"].count == 0
    assert run.ledger.steps < 300
    still = BALL.replace("position = [0, 0, 1]", "position = [0, 0, 0]").replace("-g", "0*g")
    rest = solver_of(still).simulate(10.0, samples=2)
    assert sum(rest.ledger.events.values()) == 0
    assert rest.ledger.steps < 50


@pytest.mark.parametrize(
    ("when", "value"),
    [
        ("x_dot - level", lambda t, level: np.cos(t) - level),
        ("sin(40*x + 0.5)", lambda t, _: np.sin(40.0 * np.sin(t) + 0.5)),
        ("cos(11.7*t + 0.3) - 0.999", lambda t, _: np.cos(11.7 * t + 0.3) - 0.999),
    ],
    ids=["rate", "wave", "rare"],
)
def test_events_of_rates_and_of_many_roots_in_a_step(
    solver_of: Callable[..., Any], when: str, value: Callable[..., Any]
) -> None:
    more = f'often = {{ when = "{when}", action = "count" }}\n[events.late]'
    solver, random_ = solver_of(SWING.replace("[events.late]", more)), random.Random(1)
    t = np.linspace(0.0, 20.0, 200_001)
    for n in range(30):
        level = 1.0 - 10.0 ** random_.uniform(-5.0, -1.0)
        way = ({"step": 0.9}, {"method": "dopri5"}, {"method": "dop853"})[n % 3]
        run = solver.simulate(30.0, samples=2, parameters={"level": level}, **way)
        passes = np.count_nonzero(np.diff(np.sign(value(t, level))))
        assert run.events["often"].count == passes, level


def test_steps_that_are_far_too_long_end(solver_of: Callable[..., Any]) -> None:
    run = solver_of(BALL).simulate(
        8.0, samples=7, step=0.31, parameters={"k": 3e4}, most_steps=20_000
    )
    assert run.ledger.steps < 100
    assert not run.ledger.trust.is_trusted


#: A bead that moves evenly, x = t, and is told of what stands in the place of EVENTS.
EVEN = HILL[: HILL.index("[forces]")] + "[events]\n"


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_steps_go_on_from_one_root_of_a_fast_wave_to_the_next(
    solver_of: Callable[..., Any], target: str
) -> None:
    wave = 'wave = { when = "sin(force*t + at + 0*width)", action = "count" }'
    solver, random_ = solver_of(EVEN + wave, target), random.Random(1)
    for k in range(100 if target == "c" else 2):
        rate = 1000.0 if k < 2 else 10.0 ** random_.uniform(2.4, 5.0)
        phase = 0.0 if k < 2 else random_.uniform(0.0, 3.0)
        end, given = 300.5 * math.pi / rate, {"force": rate, "at": phase}
        run = solver.simulate(end, samples=3, parameters=given, **WAYS[k % 3])
        assert run.events["wave"].count == math.floor((rate * end + phase) / math.pi)


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize("way", [*WAYS[:2], {"step": 0.7}, {"tolerance": 1e-4}], ids=str)
def test_what_is_told_beside_the_end_of_a_run(
    solver_of: Callable[..., Any], target: str, way: dict[str, Any]
) -> None:
    more = """
before = { when = "x - 5 + 1e-10" }
end = { when = "x - at", action = "stop" }
same = { when = "2*(x - 5)" }
other_end = { when = "5 - x", action = "stop" }
often = { when = "3*x - 15", action = "count" }
behind = { when = "x - 5.0000000001 + 0*force*width" }
just_behind = { when = "x - 5 - 1e-13", action = "count" }
"""
    run = solver_of(EVEN + more, target).simulate(10.0, samples=3, **way)
    assert run.stopped_by == "end"
    counts = {name: one.count for name, one in run.events.items()}
    once = ("before", "end", "same", "other_end", "often")
    assert counts == {name: int(name in once) for name in counts}
    for name in ("end", "same", "other_end"):
        assert run.events[name].time == pytest.approx([5.0], rel=1e-14), name
    assert run.events["before"].time == pytest.approx([5.0 - 1e-10], rel=1e-14)
    assert run.time[-1] == run.events["end"].time[0]


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize("way", [*WAYS[:2], {"step": 0.7}, {"tolerance": 1e-4}], ids=str)
def test_a_sign_that_changes_by_a_jump_or_through_infinity_is_no_event(
    solver_of: Callable[..., Any], target: str, way: dict[str, Any]
) -> None:
    wanted = {
        "1/(x - at - 0.2) + 0*force*width": [],
        "1/(t - 5.7)": [],
        "tan(x)": [math.pi, 2.0 * math.pi, 3.0 * math.pi],
        "atan2(sin(t), cos(t))": [2.0 * math.pi],
        "sign(x - 3)": [],
        "x/(x^2 + 1) - 0.2": [(5.0 - math.sqrt(21.0)) / 2.0, (5.0 + math.sqrt(21.0)) / 2.0],
        "1/(x - 4) - 1": [5.0],
        "atan(1e8*(t - 6.5))/(t + 1)": [6.5],
    }
    events = "\n".join(f'e{k} = {{ when = "{when}" }}' for k, when in enumerate(wanted))
    run = solver_of(EVEN + events, target).simulate(10.0, samples=3, **way)
    for k, (when, times) in enumerate(wanted.items()):
        assert run.events[f"e{k}"].time == pytest.approx(times, rel=1e-13), when


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("way", WAYS[:2], ids=str)
def test_rounding_that_brings_back_over_a_jump_makes_no_event(
    solver_of: Callable[..., Any], way: dict[str, Any], tolerance: float
) -> None:
    """A step ends at the jump, and its state may be on either side of it."""
    wanted = {
        "1/x": [],
        "tan(2*x_dot)": [(k + 0.5) * math.pi for k in range(6)],
        "1/x_dot + 0*level": [],
    }
    for when, times in wanted.items():
        scene = SWING.partition("[events]")[0] + f'[events]\ne = {{ when = "{when}" }}\n'
        scene = scene.replace('"-x"', '"0*level - x"')
        start = {"x": 0.1, "x_dot": math.sqrt(0.99)}
        runs = [
            solver_of(scene, target).simulate(
                20.0 - math.asin(0.1), samples=3, initial=start, tolerance=tolerance, **way
            )
            for target in ("c", "numpy")
        ]
        for run in runs:
            found = run.events["e"].time + math.asin(0.1)
            assert found == pytest.approx(times, abs=20.0 * tolerance), when
        assert np.array_equal(runs[0].rows, runs[1].rows)


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("way", WAYS[:2], ids=str)
def test_a_root_that_is_written_out_is_met_as_the_absolute_value(
    solver_of: Callable[..., Any], way: dict[str, Any]
) -> None:
    laws = ("abs(x - at)", "sqrt(x^2 - 2*at*x + at^2)", "(9*x^2 - 18*at*x + 9*at^2)^(1/2)/3")
    runs = []
    for target in ("c", "numpy"):
        for law in laws:
            solver = solver_of(HILL.replace("LAW", f"force*{law} + 0*width"), target)
            run = solver.begin(
                np.linspace(0.0, 5.0, 3), parameters={"at": 1.25, "force": 1.0}, **way
            )
            motion = run.finish()
            assert motion.ledger.trust.is_trusted
            assert motion.ledger.unresolved == 0
            runs.append((run.save(), motion))
    for first, second in zip(runs[:3], runs[3:], strict=True):
        assert np.array_equal(first[0].rows, second[0].rows)
        assert np.array_equal(first[0].state, second[0].state)
    absolute, *roots = (motion for _, motion in runs[:3])
    for one in roots:
        np.testing.assert_allclose(one.rows, absolute.rows, rtol=0.0, atol=1e-8)
        assert one.ledger.steps < 200


#: Formulas, and the time from which they have no value, 0 where they have none at the start.
LOST = {
    "(x - x)/(x_dot - 1)": 0.0,
    "x/(t - t)": 0.0,
    "sqrt(x - 5)": 0.0,
    "asin(x - 5)": 0.0,
    "log(x - 5)": 0.0,
    "1/x": 0.0,
    "sqrt(5 - x)": 5.0,
    "asin(x/4) - 0.3": 4.0,
    "log(7 - t) + 0*x": 7.0,
    "acos(t/6)": 6.0,
    "sqrt((x - 3)*(x - 3.2)) - 1": 3.0,
    "x_dot*(7.5 - x)^0.7": 7.5,
    "x*sqrt((x - 3)*(x - 3.0002)) - 1": 3.0,
}


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize("when", LOST)
def test_a_run_does_not_go_on_where_an_event_has_no_value(
    solver_of: Callable[..., Any], when: str, target: str
) -> None:
    text = EVEN + f'other = {{ when = "x - 2" }}\nlost = {{ when = "{when}" }}'
    solver = solver_of(text + '\nno = { when = "x - 20 + 0*(at + width + force)" }', target)
    for way in (*WAYS[:2], {"step": 0.7}) if target == "c" else WAYS[:1]:
        if not LOST[when]:
            with pytest.raises(SolveError, match=r"events\.lost: .* has no finite value where the"):
                solver.simulate(10.0, samples=3, most_steps=200, **way)
            continue
        with pytest.raises(MotionError, match=r"events\.lost: .* has no finite value from") as stop:
            solver.simulate(10.0, samples=101, most_steps=200, **way)
        assert re.escape(when) in re.escape(str(stop.value))
        run = stop.value.result
        assert run.time[-1] == pytest.approx(math.floor(10.0 * LOST[when]) / 10.0, abs=0.1001)
        reached = float(str(stop.value).split("at t = ")[1].split(" s:")[0])
        assert reached == pytest.approx(LOST[when], abs=1e-8)
        assert run.events["other"].count == 1
        # before that it has one
        assert solver.simulate(0.99 * LOST[when], samples=3, **way).ledger.trust.is_trusted


@pytest.mark.usefixtures("numpy_solver")
def test_both_targets_stop_where_an_event_has_no_value_with_the_same_bits(
    solver_of: Callable[..., Any],
) -> None:
    text = SWING.replace("[events]", '[events]\nlost = { when = "sqrt(level - x) - 3" }')
    for way in (*WAYS[:2], {"step": 0.31}):
        runs = []
        for target in ("c", "numpy"):
            run = solver_of(text, target=target).begin(np.linspace(0.0, 8.0, 7), **way)
            with pytest.raises(MotionError, match=r"events\.lost"):
                run.finish()
            runs.append(run)
        first, second = (run.save() for run in runs)
        assert runs[0].time == pytest.approx(math.asin(0.9), abs=1e-6 if "step" not in way else 0.1)
        assert np.array_equal(first.rows, second.rows)
        assert np.array_equal(first.state, second.state)


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_events_go_on_beside_a_single_instant_without_a_value(
    solver_of: Callable[..., Any], target: str
) -> None:
    events = """
wave = { when = "sin(x - 5)/(x - 5) - 0.5" }
there = { when = "x - 5" }
touches = { when = "sqrt(1 - cos(x + 0.1)) - 0.5" }
edge = { when = "sqrt(x) - 1 + 0*(at + width + force)" }
corner = { when = "atan2(x, t) - 2" }
last = { when = "sqrt(49 - (x - 3)^2) - 6.5" }
"""
    run = solver_of(EVEN + events, target).simulate(10.0, samples=3, most_steps=300)
    half = 1.8954942670339809  # sin(x) = x/2
    assert run.events["wave"].time == pytest.approx([5.0 - half, 5.0 + half], rel=1e-12)
    wanted = [math.acos(0.75), 2.0 * math.pi - math.acos(0.75), 2.0 * math.pi + math.acos(0.75)]
    assert run.events["touches"].time + 0.1 == pytest.approx(wanted, rel=1e-12)
    assert run.events["edge"].time == pytest.approx([1.0], rel=1e-12)
    far = math.sqrt(49.0 - 6.5**2)
    assert run.events["last"].time == pytest.approx([3.0 - far, 3.0 + far], rel=1e-12)


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_an_event_ends_a_run_where_another_loses_its_value(
    solver_of: Callable[..., Any], target: str
) -> None:
    events = 'lost = { when = "sqrt(5 - x) + 0*(at + width + force)" }\n'
    events += 'end = { when = "x - 5", action = "stop" }'
    for way in WAYS[:2]:
        run = solver_of(EVEN + events, target).simulate(10.0, samples=3, most_steps=200, **way)
        assert run.stopped_by == "end"


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_drivers_lead_to_where_an_event_has_no_value(
    solver_of: Callable[..., Any], target: str
) -> None:
    text = SHAFT.format(law="t", load="0") + '[events]\nlost = { when = "log(3 - turn)" }\n'
    with pytest.raises(MotionError, match=r"at t = 3 s: events\.lost"):
        solver_of(text, target).simulate(5.0, samples=2, most_steps=500)


def test_initial_values_lead_away_from_where_an_event_has_no_value(
    solver_of: Callable[..., Any],
) -> None:
    solver = solver_of(SWING.replace("[events]", '[events]\ndeep = { when = "log(x) + 1" }'))
    with pytest.raises(SolveError, match=r"events\.deep"):
        solver.simulate(0.1, samples=2)
    run = solver.simulate(0.1, samples=2, initial={"x": 0.5})
    assert run.ledger.trust.is_trusted


SPEEDS = """
name = "speeds"
unit = "m"
outputs = ["energies"]
parameters = { near = 1e-5, high = 0.0 }
[bodies.cart]
point = true
position = [0, 0, 0]
mass = 1
[coordinates]
x = { body = "cart", along = [1, 0, 0] }
[forces.engine]
type = "along"
coordinate = "x"
force = "10 - high*max(0, 1 - abs(x - 8)/near)"
[events]
speed = { when = "abs(x_dot - 5) - near" }
time = { when = "abs(t - 0.777) - near" }
"""


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize("way", WAYS[:2], ids=str)
def test_what_is_seen_first_does_not_hide_what_is_seen_behind_it(
    solver_of: Callable[..., Any], target: str, way: dict[str, Any]
) -> None:
    """Bounds of the second function were overwritten in C by a look at the first."""
    solver = solver_of(SPEEDS, target)
    for near, tolerance in ((1e-5, 1e-6), (1.07e-5, 1e-6), (7.7e-9, 1e-9), (1.4013168e-3, 1e-4)):
        options = {**way, "tolerance": tolerance, "parameters": {"near": near}}
        run = solver.simulate(2.0, samples=2, **options)
        for name, at, apart in (("speed", 0.5, 0.1 * near), ("time", 0.777, near)):
            assert run.events[name].count == 2
            wanted = [at - apart, at + apart]
            assert run.events[name].time == pytest.approx(wanted, rel=1e-12)
    thrown = {"near": 1e-5, "high": 1e8}
    run = solver.simulate(2.0, samples=2, **way, parameters=thrown)
    assert run.position["cart"][-1, 0] < 8.0  # a wall behind a window of a speed


CARS = """
name = "cars"
unit = "m"
outputs = ["energies"]
[bodies.a]
position = [0, 0, 0]
velocity = [10, 0, 0]
mass = 1
point = true
[bodies.b]
position = [30, 0, 0]
mass = 3
point = true
[parameters]
radius = 1.0
hard = 1e5
[forces.bumper]
type = "spring_damper"
bodies = ["a", "b"]
points = [[0, 0, 0], [0, 0, 0]]
free_length = "radius"
tension = "-hard*max(0, -x)"
"""
ROOT = """
name = "root"
unit = "m"
outputs = ["energies"]
[bodies.b]
position = [1, 0, 0]
mass = 1
point = true
[coordinates]
x = { body = "b", along = [1, 0, 0] }
[forces.f]
type = "along"
coordinate = "x"
force = "-sign(x)*sqrt(abs(x))"
"""


@pytest.mark.parametrize("way", WAYS[:2], ids=str)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-6, 1e-9])
def test_bodies_that_touch_by_their_distance_do_not_pass_through_each_other(
    solver_of: Callable[..., Any], way: dict[str, Any], tolerance: float
) -> None:
    """Only stages that do not count at the end of a step may meet the contact.

    They throw the polynomial off: no root is in it, or one right at its start, step after step.
    """
    solver, random_ = solver_of(CARS), random.Random(3)
    for _ in range(40):
        given = {"radius": random_.uniform(0.1, 3.0), "hard": 10.0 ** random_.uniform(3.0, 8.0)}
        options = {**way, "tolerance": tolerance}
        run = solver.simulate(5.3, samples=2, parameters=given, **options)
        ends = [run.velocity[name][-1, 0] for name in "ab"]
        assert ends == pytest.approx([-5.0, 5.0], abs=3e3 * tolerance), given
        assert run.ledger.trust.is_trusted
        assert run.ledger.steps < 1000, given


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.parametrize("target", ["c", "numpy"])
@pytest.mark.parametrize("way", WAYS[:2], ids=str)
def test_forces_that_begin_as_a_root_do_not_stop_a_body(
    solver_of: Callable[..., Any], target: str, way: dict[str, Any]
) -> None:
    run = solver_of(ROOT, target).simulate(10.0, samples=101, **way)
    x, v = run.position["b"][:, 0], run.velocity["b"][:, 0]
    assert v**2 / 2 + 2 / 3 * abs(x) ** 1.5 == pytest.approx(2 / 3, abs=1e-5)
    assert np.ptp(x) > 1.9
    assert run.ledger.trust.is_trusted
    assert run.ledger.steps < 300


@pytest.mark.parametrize(
    ("law", "counts"),
    [
        ("-0.5*sign(x_dot)", (1, 1, 0)),
        ("-0.8*sign(x_dot) - 0.3*x", (1, 1, 0)),
        ("-0.25*sign(x_dot) - 0.3*x", (2, 1, 1)),  # turns round before it comes to rest
    ],
)
@pytest.mark.parametrize("method", ["dop853", "dopri5"])
def test_body_that_dry_friction_holds_comes_to_rest_once(
    solver_of: Callable[[str], DynamicsSolver], law: str, counts: tuple[int, ...], method: str
) -> None:
    """Its rate went through zero in both directions some hundred times where it was held."""
    events = '[events]\nrest = { when = "x_dot" }\n'
    for direction in ("falling", "rising"):
        events += f'{direction} = {{ when = "x_dot", direction = "{direction}" }}\n'
    solver = solver_of(HILL.replace("LAW", law) + events)
    with pytest.raises(MotionError) as stop:
        solver.simulate(9.0, samples=2, method=method, most_steps=900)
    found = stop.value.result.events
    assert tuple(found[name].count for name in ("rest", "falling", "rising")) == counts


@pytest.mark.parametrize(
    ("law", "speed"),
    [
        ("asin(sin(t))", 1.0 + (math.pi / 2) ** 2 - 0.5 * (10.0 - 3.0 * math.pi) ** 2),
        ("(t - 5)/abs(t - 5)", 1.0),
        ("acos(cos(2*t))", None),
    ],
)
def test_forces_that_fold_are_followed_over_their_kinks(
    solver_of: Callable[[str], DynamicsSolver], law: str, speed: float | None
) -> None:
    """A run made a million steps, or was not trusted, though its velocities were right."""
    motion = solver_of(HILL.replace("LAW", law)).simulate(10.0, samples=2)
    assert motion.ledger.trust
    assert motion.ledger.steps < 100
    if speed is None:
        times = np.linspace(0.0, 10.0, 2_000_001)
        speed = 1.0 + float(np.trapezoid(np.arccos(np.cos(2.0 * times)), times))
    assert motion.velocity["bead"][-1, 0] == pytest.approx(speed, abs=1e-9)
