"""The kinds that are coordinates: angles all the way round, lengths, and what couples them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.generated.kinds import angle, distance, length, linear_combination
from kousoku.runtime import load

if TYPE_CHECKING:
    from numpy.typing import NDArray

pytestmark = pytest.mark.usefixtures("compiler")

X, Y, Z = np.eye(3)
AT_REST = np.array([1.0, 0.0, 0.0, 0.0])
EPS = np.finfo(float).eps
#: All quadrants, their borders, the neighbours of half a turn, and angles near zero.
ANGLES = [
    *(k * math.pi / 4 for k in range(-3, 5)),
    *(sign * (math.pi - d) for sign in (-1, 1) for d in (1e-3, 1e-9, 4e-16)),
    *(sign * d for sign in (-1, 1) for d in (1e-3, 1e-9, 1e-15, 1e-160)),
    *(-3.0, -2.0, -1.0, 1.0, 2.0, 3.0),
]


def turned(t: float, axis: NDArray[np.float64] = Z) -> NDArray[np.float64]:
    return np.concatenate([[math.cos(t / 2)], math.sin(t / 2) * axis])


def after(p: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Turn q in the frame that p has turned."""
    vector = p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *vector])


def rotated(p: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    e = p[1:]
    return np.asarray((p[0] ** 2 - e @ e) * v + 2 * e * (e @ v) + 2 * p[0] * np.cross(e, v))


def wrapped(t: float) -> float:
    return math.remainder(t, 2 * math.pi)


@pytest.mark.parametrize("t", ANGLES)
def test_angle_is_right_in_every_quadrant_and_near_its_ends(t: float) -> None:
    for p_j in (turned(t), -turned(t), 3.0 * turned(t)):
        value, _ = angle.constraint(p_i=AT_REST, a_i_b=X, p_j=p_j, a_j_b=X, b_i_b=Y)
        assert abs(value[0] - t) <= 2 * EPS * abs(t)


def test_angle_of_half_a_turn_is_plus_pi() -> None:
    half = np.array([0.0, 0.0, 0.0, 1.0])
    value, _ = angle.constraint(p_i=AT_REST, a_i_b=X, p_j=half, a_j_b=X, b_i_b=Y)
    assert value[0] == math.pi


@pytest.mark.parametrize("t", ANGLES)
def test_angle_in_the_plane_is_twice_the_difference_of_the_half_angles(t: float) -> None:
    p_i, p_j = turned(0.7), turned(0.7 + t)
    value, _ = angle.constraint(p_i=p_i, a_i_b=X, p_j=p_j, a_j_b=X, b_i_b=Y)
    planar = 2 * (math.atan2(p_j[3], p_j[0]) - math.atan2(p_i[3], p_i[0]))
    assert abs(wrapped(value[0] - planar)) <= 8 * EPS


@pytest.mark.parametrize("t", ANGLES)
def test_angle_about_any_axis_has_that_axis_as_its_jacobian(t: float) -> None:
    axis = np.array([2.0, -3.0, 6.0]) / 7
    a = np.array([3.0, 2.0, 0.0]) / math.sqrt(13.0)
    b = np.cross(axis, a)
    p_i = np.array([2.0, 4.0, 5.0, 6.0]) / 9
    p_j = after(p_i, turned(t, axis))
    value, jacobian = angle.constraint(p_i=p_i, a_i_b=a, p_j=p_j, a_j_b=a, b_i_b=b)
    assert abs(wrapped(value[0] - t)) <= 8 * EPS
    wanted = np.concatenate([np.zeros(3), -axis, np.zeros(3), axis])
    np.testing.assert_allclose(jacobian[0], wanted, rtol=0, atol=16 * EPS)


def test_angle_of_a_hinge_has_no_gamma_however_the_bodies_turn() -> None:
    axis, a = np.array([2.0, -3.0, 6.0]) / 7, np.array([3.0, 2.0, 0.0]) / math.sqrt(13.0)
    p_i = np.array([2.0, 4.0, 5.0, 6.0]) / 9
    omega_i = np.array([3.0, -1.0, 2.0])
    for t in (0.3, 2.0, -2.5):
        q = turned(t, axis)
        omega_j = rotated(q * [1, -1, -1, -1], omega_i + 5.0 * axis)
        _, gamma = angle.rates(
            p_i=p_i, a_i_b=a, p_j=after(p_i, q), a_j_b=a, b_i_b=np.cross(axis, a),
            omega_i_b=omega_i, omega_j_b=omega_j,
        )  # fmt: skip
        assert abs(gamma[0]) <= 200 * EPS


def test_angle_of_bodies_that_turn_together_keeps_every_digit_of_its_gamma() -> None:
    omega = np.array([1e9, -2e9, 3e9])
    slow: dict[str, Any] = {"p_i": AT_REST, "a_i_b": X, "p_j": AT_REST, "a_j_b": X, "b_i_b": Y}
    _, gamma = angle.rates(**slow, omega_i_b=omega, omega_j_b=omega)
    assert gamma[0] == 0.0
    _, gamma = angle.rates(**slow, omega_i_b=omega, omega_j_b=omega + Y)
    # −γ is the rate of the turning of j seen from i, (Ω × ω_i)·z with Ω along y.
    assert gamma[0] == pytest.approx(1e9, rel=4 * EPS)


def test_there_is_no_angle_along_the_axis_and_no_direction_of_no_length() -> None:
    value, jacobian = angle.constraint(p_i=AT_REST, a_i_b=X, p_j=AT_REST, a_j_b=Z, b_i_b=Y)
    assert value[0] == 0.0
    assert not jacobian.any()
    points: dict[str, Any] = {
        "r_i": X,
        "p_i": AT_REST,
        "s_i_b": Y,
        "r_j": Y,
        "p_j": AT_REST,
        "s_j_b": X,
    }
    value, jacobian = length.constraint(**points)
    assert value[0] == 0.0
    assert not jacobian.any()


def test_no_length_has_no_direction_and_a_small_one_the_one_that_it_has(backend: str) -> None:
    target: Any = backend
    kernels = load(Path(length.__file__).parent, target=target)
    places: dict[str, Any] = {"r_i": X, "p_i": AT_REST, "s_i_b": Y, "p_j": AT_REST, "s_j_b": X}
    speeds: dict[str, Any] = {"v_i": X, "omega_i_b": Z, "v_j": 3 * Y, "omega_j_b": X + Y}
    together = {**places, "r_j": Y}
    assert kernels.constraint(**together)[0].tolist() == [0.0]
    assert not kernels.constraint(**together)[1].any()
    assert not kernels.reaction(**together, lam=[5.0])[0].any()
    assert [x.tolist() for x in kernels.rates(**together, **speeds)] == [[0.0], [-math.inf]]
    at_rest = {name: 0.0 * speed for name, speed in speeds.items()}
    assert [x.tolist() for x in kernels.rates(**together, **at_rest)] == [[0.0], [0.0]]

    start: dict[str, Any] = dict.fromkeys(("r_i", "s_i_b", "s_j_b"), np.zeros(3))
    turned_ends: dict[str, Any] = {"p_i": AT_REST, "p_j": AT_REST}
    for size in (1e-153, 1e-15, 1.0):
        value, jacobian = kernels.constraint(**start, **turned_ends, r_j=size * Y)
        assert value.tolist() == [size]
        assert jacobian[0, 6:9].tolist() == [0.0, 1.0, 0.0]


def test_length_of_a_rod_is_what_distance_keeps() -> None:
    stream = np.random.default_rng(4)
    points: dict[str, Any] = {
        name: stream.normal(size=3) for name in ("r_i", "s_i_b", "r_j", "s_j_b")
    }
    points |= {name: stream.normal(size=4) for name in ("p_i", "p_j")}
    for name in ("p_i", "p_j"):
        points[name] /= np.linalg.norm(points[name])
    spins: dict[str, Any] = {
        name: stream.normal(size=3) for name in ("v_i", "omega_i_b", "v_j", "omega_j_b")
    }
    value, row = length.constraint(**points)
    ends = [points[f"r_{k}"] + rotated(points[f"p_{k}"], points[f"s_{k}_b"]) for k in "ij"]
    assert value[0] == pytest.approx(np.linalg.norm(ends[1] - ends[0]), rel=4 * EPS)
    none, same = distance.constraint(**points, length=value[0])
    assert abs(none[0]) <= 4 * EPS * value[0]
    np.testing.assert_allclose(row, same, rtol=0, atol=8 * EPS * np.abs(same).max())
    velocity = np.concatenate([spins[name] for name in ("v_i", "omega_i_b", "v_j", "omega_j_b")])
    rate = float(row[0] @ velocity)
    (_, gamma), (_, kept) = (
        length.rates(**points, **spins),
        distance.rates(**points, length=value[0], **spins),
    )
    assert gamma[0] == pytest.approx(kept[0] + rate**2 / value[0], rel=1e-13)


def test_combination_of_two_angles_is_a_gear_that_a_law_turns() -> None:
    factors: dict[str, Any] = {"c_1": 2.0, "c_2": -3.0}
    rows: dict[str, Any] = {"J_1": np.arange(12.0)[None], "J_2": np.ones((1, 12))}
    value, row = linear_combination.constraint(
        **factors, c_0=0.5, u_1=[1.0], u_2=[0.25], **rows, f=[1.75]
    )
    assert value[0] == 2.0 * 1.0 - 3.0 * 0.25 + 0.5 - 1.75
    np.testing.assert_array_equal(row[0], [*(2.0 * np.arange(12.0)), *(-3.0 * np.ones(12))])
    nu, gamma = linear_combination.rates(
        **factors, gamma_1=[4.0], gamma_2=[5.0], f_dot=[6.0], f_ddot=[7.0]
    )
    assert nu[0] == 6.0
    assert gamma[0] == 2.0 * 4.0 - 3.0 * 5.0 + 7.0
    reaction = linear_combination.reaction(**factors, **rows, lam=[10.0])
    np.testing.assert_array_equal(np.ravel(reaction), 10.0 * row[0])
