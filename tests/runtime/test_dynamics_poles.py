"""Forces that are infinite somewhere: no motion leads through, and none is told that does."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest

from kousoku.model.errors import MotionError
from kousoku.model.reading.read import scene_from_toml
from kousoku.runtime.dynamics import load_dynamics

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from kousoku.runtime.integrate.motion import Motion

    Move = Callable[..., Motion]


CART = """
name = "cart"
unit = "m"
[bodies.cart]
position = [0, 0, 0]
velocity = [1, 0, 0]
boxes = [{{ mass = 1, size = [0.2, 0.2, 0.2] }}]
[joints]
rail = {{ type = "prismatic", bodies = ["ground", "cart"], at = [0, 0, 0], axis = [1, 0, 0] }}
[coordinates]
x = {{ joint = "rail" }}
[forces]
f = {{ type = "along", coordinate = "x", force = "{force}" }}
"""
LED = '[drivers]\nmotor = { coordinate = "x", value = "t" }\n'
POLES = [
    *("1e-9/(x - 5)", "-1e-9/(x - 5)", "1e-30/(x - 5)^3", "1e-9*(x - 5)^(-1)", "1e-30/(x - 5)^2"),
    *(
        "max(0, 1e-9/(x - 5))",
        "1e-9/(x*x - 25)",
        "1e-9/(exp(x) - exp(5))",
        "1e-9*sign(x - 5)/(x - 5)",
        "1e-9*tan(x - 3.43)",
    ),
]
HEALTHY = [
    *("sin(x - 5)/(x - 5)", "(x - 5)/abs(x - 5)", "1e-9*log(abs(x - 5))", "1e-3/sqrt(abs(x - 5))"),
    *(
        "(x - 5)*abs(x - 5)^(-1)",
        "1e-9/(x - 5)*(x - 5)",
        "1e-3*((x - 5)^2)^(-0.25)",
        "1e-3*exp(-1/(x - 5)^2)",
        "-1/(x - 5)^2",
        "tan(1.5*sin(x))",
    ),
]


@pytest.fixture
def run(backend: str, bodies_folder: Callable[..., Path]) -> Move:
    """Function that moves a cart by a force."""

    def move(force: str, more: str = "", **options: Any) -> Motion:
        scene = scene_from_toml(CART.format(force=force) + more)
        solver = load_dynamics(bodies_folder(scene, ()), target=cast("Any", backend))
        return solver.simulate(10.0, samples=11, **options)

    return move


@pytest.mark.parametrize("force", POLES)
@pytest.mark.parametrize("method", ["dopri5", "dop853"])
def test_a_run_ends_where_a_force_is_infinite(run: Move, force: str, method: str) -> None:
    with pytest.raises(MotionError, match=r"forces\.f is infinite right behind") as caught:
        run(force, method=method)
    wanted = 2 if "tan" in force else 5  # it is infinite at x = 1.86
    assert caught.value.result.time.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0][:wanted]


def test_a_driver_does_not_lead_through_such_a_place(run: Move) -> None:
    with pytest.raises(MotionError, match=r"forces\.f is infinite right behind"):
        run("1e-9/(x - 5.03)", LED, method="kinematics")


@pytest.mark.parametrize("force", HEALTHY)
@pytest.mark.parametrize("method", ["dopri5", "dop853"])
def test_what_has_a_value_or_a_finite_integral_is_passed(
    run: Move, force: str, method: str
) -> None:
    assert run(force, method=method).ledger.trust.is_trusted


@pytest.mark.parametrize("force", ["1e-9/(x - 5)", "sin(x - 5)/(x - 5)", "1e-9*tan(t - 3.43)"])
@pytest.mark.usefixtures("compiler", "numpy_solver")
def test_both_targets_come_as_far_with_the_same_bits(
    bodies_folder: Callable[..., Path], force: str
) -> None:
    folder, states = bodies_folder(scene_from_toml(CART.format(force=force)), ()), []
    for target in ("c", "numpy"):
        begun = load_dynamics(folder, target=target).begin(np.linspace(0.0, 10.0, 11))
        with suppress(MotionError):
            begun.finish()
        states.append(begun.state.copy())
    np.testing.assert_array_equal(states[0], states[1])
