"""A free body on a spring and damper moves as independent models of the ADAMS cases do.

Definitions: ``tsda_case02`` … ``tsda_case04`` of ``data/testing/joints`` of projectchrono/chrono,
commit 7689fbc0. 1 kg, gravity 9.80665 m/s² along −z, from rest, free length 2 m. In the first case
a spring of 100 N/m and a damper of 5 N s/m from the origin to the centre at (0, 2, 0); in the two
others the law is not linear, and the end is not the centre. The positions come from minimal
coordinates and multi-precision series, of the others from two methods that agree to 1e-10; what
ADAMS prints agrees with them to 3e-5 m.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.reading.read import scene_from_dict
from kousoku.runtime.integrate.euler_parameters import rotated

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.dynamics import DynamicsSolver

POSITIONS = {
    0.5: [0.0, 1.773547003577, -1.162132877054],
    1.0: [0.0, -0.597327430558, -2.189068610195],
    2.0: [0.0, -1.983834264865, -0.324760555785],
    3.0: [0.0, 1.553451759993, -1.561142220902],
    4.0: [0.0, 1.78500666335, -1.105278252823],
    5.0: [0.0, -1.945197850454, -0.767400995044],
}

LAW = "50*x + 10*abs(x)*x + 5*v"
#: At 1, 2 and 5 s, under the law above.
NONLINEAR = {
    "tsda_case03": (
        [-0.526661528112, 3.486916219535, -1.046425435487],
        [3.410454867323, -0.389567531354, 0.611572011753],
        [-1.444916900415, 4.419558576433, 1.322425552333],
    ),
    "tsda_case04": (
        [0.0, 2.100737814042, -3.87481503575],
        [0.0, -3.928275283974, -1.563022200493],
        [0.0, 3.974238758337, -0.585782004252],
    ),
}


def scene(unit: str = "m", factor: float = 1.0, **spring: Any) -> Any:
    """Case, its lengths in another unit."""
    own = {"stiffness": 100, "damping": 5, "free_length": 2 * factor} | spring
    inertia = {"xx": 0.04 * factor**2, "yy": 0.1 * factor**2, "zz": 0.1 * factor**2}
    tree = {
        "name": "bob",
        "unit": unit,
        "gravity": [0, 0, -9.80665 * factor],
        "bodies": {"bob": {"position": [0, 2 * factor, 0], "mass": 1, "inertia": inertia}},
        "forces": {
            "spring": {
                "type": "spring_damper",
                "bodies": ["ground", "bob"],
                "points": [[0, 0, 0], [0, 0, 0]],
                **{name: value for name, value in own.items() if value is not None},
            }
        },
    }
    return scene_from_dict(tree)


def nonlinear(case: str, unit: str, factor: float) -> dict[str, Any]:
    """Case whose spring is not linear, its lengths in another unit."""
    law = LAW if unit == "m" else "50*x + 10*abs(x)*x/1000 + 5*v"
    inertia = {"xx": 0.04 * factor**2, "yy": 0.1 * factor**2, "zz": 0.1 * factor**2}
    body: Any = {"mass": 1, "inertia": inertia}
    ends: list[list[float]]
    if case == "tsda_case03":
        body["position"], ends = [-1, 4, 3], [[1, 2, 3], [2, 0, 0]]
    else:
        body |= {"position": [0, 4 * factor, 0]}
        body["orientation"] = {"axis": [0, 0, 1], "angle": -np.pi / 2}
        ends = [[0, 0, 0], [2 * factor, 0, 0]]
    spring = {"type": "spring_damper", "bodies": ["ground", "bob"], "points": ends, "tension": law}
    tree = {"name": "bob", "unit": unit, "gravity": [0, 0, -9.80665 * factor]}
    return tree | {"bodies": {"bob": body}, "forces": {"spring": spring}}


@pytest.mark.parametrize(
    ("unit", "factor", "free"), [("m", 1.0, 2.0), ("mm", 1000.0, 2000.0), ("m", 1.0, None)]
)
def test_a_body_on_a_spring_moves_as_the_independent_model(
    mover: Callable[..., DynamicsSolver], unit: str, factor: float, free: float | None
) -> None:
    solver = mover(scene(unit, factor, free_length=free))
    motion = solver.simulate(times=[0.0, *POSITIONS], tolerance=1e-12)
    found = motion.position["bob"][1:] / factor
    np.testing.assert_allclose(found, list(POSITIONS.values()), rtol=0, atol=1e-11)
    assert motion.ledger.works["spring"] < -1.0
    assert motion.ledger.energy_error is not None
    assert motion.ledger.energy_error < 1e-10


@pytest.mark.parametrize(
    ("case", "unit", "factor"),
    [("tsda_case03", "m", 1.0), ("tsda_case04", "m", 1.0), ("tsda_case04", "mm", 1000.0)],
)
def test_a_spring_with_a_law_of_its_own_moves_as_the_independent_model(
    mover: Callable[..., DynamicsSolver], case: str, unit: str, factor: float
) -> None:
    found = scene_from_dict(nonlinear(case, unit, factor))
    motion = mover(found).simulate(times=[0.0, 1.0, 2.0, 5.0], tolerance=1e-12)
    positions = motion.position["bob"][1:] / factor
    np.testing.assert_allclose(positions, NONLINEAR[case], rtol=0, atol=1e-9)
    assert motion.ledger.energy_error is not None
    assert motion.ledger.energy_error < 1e-9


@pytest.mark.parametrize("case", ["tsda_case02", *NONLINEAR])
def test_a_body_on_a_spring_moves_as_adams_prints_it(
    mover: Callable[..., DynamicsSolver], adams_samples: dict[str, Any], case: str
) -> None:
    times = [0.0, *map(float, adams_samples[case])]
    motion = mover(f"adams/{case}").simulate(times=times, tolerance=1e-12)
    if case in NONLINEAR:
        positions = motion.position["body"][[times.index(t) for t in (1.0, 2.0, 5.0)]]
        np.testing.assert_allclose(positions, NONLINEAR[case], rtol=0, atol=1e-9)
    else:
        positions = motion.position["body"][1:]
        np.testing.assert_allclose(positions, list(POSITIONS.values()), rtol=0, atol=1e-11)
    for row, sample in enumerate(adams_samples[case].values(), 1):
        p, turning = (
            table["body"][[row]] for table in (motion.orientation, motion.angular_velocity)
        )
        found = {
            "Pos": (motion.position["body"][row], 5e-5),
            "Vel": (motion.velocity["body"][row], 5e-4),
            "Avel": (rotated(p.T, turning.T)[:, 0], 5e-4),
        }
        for key, (own, limit) in found.items():
            np.testing.assert_allclose(own, sample[key], rtol=0, atol=limit, err_msg=key)
        assert abs(p[0] @ np.array(sample["Quat"])) == pytest.approx(1.0, abs=1e-6)


def test_a_tension_may_depend_on_time(mover: Callable[..., DynamicsSolver]) -> None:
    tree: Any = {
        "name": "pulled",
        "unit": "m",
        "bodies": {"ball": {"position": [3, 0, 0], "point": True, "mass": 2}},
        "forces": {
            "rope": {
                "type": "spring_damper",
                "bodies": ["ground", "ball"],
                "points": [[0, 0, 0], [0, 0, 0]],
                "tension": "6*t",
            }
        },
    }
    motion = mover(scene_from_dict(tree)).simulate(times=[0.0, 1.0], tolerance=1e-12)
    np.testing.assert_allclose(motion.position["ball"][1], [2.5, 0, 0], rtol=0, atol=1e-11)


def test_a_spring_without_a_damper_keeps_the_energy(mover: Callable[..., DynamicsSolver]) -> None:
    motion = mover(scene(damping=None), outputs=("energies",)).simulate(2.0, tolerance=1e-10)
    assert motion.ledger.works == {}
    assert motion.ledger.energy_error is not None
    assert motion.ledger.energy_error < 1e-7
    assert np.ptp(motion.energy["kinetic"]) > 1.0


def test_a_constant_force_is_as_gravity(mover: Callable[..., DynamicsSolver]) -> None:
    tree: Any = {
        "name": "thrown",
        "unit": "m",
        "bodies": {"ball": {"position": [0, 0, 0], "point": True, "mass": 2}},
        "forces": {"push": {"type": "force", "body": "ball", "force": [3, 0, -1]}},
    }
    motion = mover(scene_from_dict(tree)).simulate(times=[0.0, 2.0])
    np.testing.assert_allclose(motion.position["ball"][1], [3.0, 0.0, -1.0], rtol=0, atol=1e-12)
    assert motion.ledger.energy_error == pytest.approx(0.0, abs=1e-12)


def test_the_work_of_each_force_is_told_apart_and_balances_the_energy(
    mover: Callable[..., DynamicsSolver],
) -> None:
    inertia = {"xx": 40.0, "yy": 90.0, "zz": 70.0}
    tree: Any = {
        "name": "pushed",
        "unit": "dm",
        "gravity": [0, 0, -98],
        "bodies": {"bar": {"position": [10, 0, 0], "mass": 2, "inertia": inertia}},
        "joints": {"ball": {"type": "ball", "bodies": ["ground", "bar"], "at": [0, 0, 0]}},
        "forces": {
            "damper": {
                "type": "spring_damper",
                "bodies": ["ground", "bar"],
                "points": [[0, 0, 20], [5, 1, 2]],
                "stiffness": 30,
                "damping": 4,
            },
            "rope": {
                "type": "spring_damper",
                "bodies": ["ground", "bar"],
                "points": [[0, 30, 0], [0, 1, 2]],
                "tension": "20*x + v",
            },
            "wind": {"type": "force", "body": "bar", "force": ["30*sin(3*t)", 0, 10]},
            "jet": {"type": "force", "body": "bar", "point": [1, 2, 0], "force_b": [0, 20, 7]},
            "motor": {"type": "torque", "body": "bar", "torque": [0, "300*t", 0]},
            "rotor": {"type": "torque", "body": "bar", "torque_b": [200, 0, "50*cos(t)"]},
            "weight": {"type": "force", "body": "bar", "force": [0, 0, -5]},
        },
    }
    motion = mover(scene_from_dict(tree), outputs=("energies",)).simulate(2.0, tolerance=1e-11)
    assert list(motion.work) == ["damper", "rope", "wind", "jet", "motor", "rotor"]
    assert all(np.abs(work).max() > 1.0 for work in motion.work.values())
    assert np.all(np.diff(motion.work["damper"]) < 0.0)
    change = motion.energy["total"] - motion.energy["total"][0]
    total = sum(motion.work.values())
    np.testing.assert_allclose(total, change, rtol=0, atol=1e-6)
    assert motion.ledger.energy_error == pytest.approx(
        np.abs(total - change).max() / 100, abs=1e-10
    )
    assert motion.ledger.works["motor"] == pytest.approx(motion.work["motor"][-1] / 100, rel=1e-15)


def test_a_torque_spins_a_free_body(mover: Callable[..., DynamicsSolver]) -> None:
    inertia = {"xx": 0.5, "yy": 0.5, "zz": 0.25}
    tree: Any = {
        "name": "wheel",
        "unit": "m",
        "bodies": {"wheel": {"position": [0, 0, 0], "mass": 2, "inertia": inertia}},
        "forces": {"motor": {"type": "torque", "body": "wheel", "torque_b": [0, 0, 2]}},
    }
    motion = mover(scene_from_dict(tree)).simulate(times=[0.0, 0.5])
    np.testing.assert_allclose(motion.angular_velocity["wheel"][1], [0, 0, 4], rtol=0, atol=1e-12)


def test_a_spring_whose_ends_coincide_has_no_force_and_no_torque(
    mover: Callable[..., DynamicsSolver],
) -> None:
    bodies: Any = {
        name: {"position": [x, 0, 0], "mass": 1, "inertia": {"xx": 1, "yy": 1.1, "zz": 1.2}}
        for name, x in (("one", 0), ("two", 1))
    }
    bodies["one"]["angular_velocity"] = [0.1, 0.2, 0.3]
    ends = {"bodies": ["one", "two"], "points": [[1, 0, 0], [0, 0, 0]]}
    spring = {"type": "spring_damper", **ends, "stiffness": 5, "free_length": 0.3}
    tree = {"name": "touching", "unit": "m", "bodies": bodies, "forces": {"spring": spring}}
    solver = mover(scene_from_dict(tree))
    freely = mover(scene_from_dict({**tree, "name": "apart", "forces": {}}))

    here, there = solver.evaluate(), freely.evaluate()

    np.testing.assert_allclose(here["v_dot"], there["v_dot"], rtol=0, atol=1e-15)
    assert here["energies"][1] == pytest.approx(0.5 * 5 * 0.3**2, rel=1e-15)
