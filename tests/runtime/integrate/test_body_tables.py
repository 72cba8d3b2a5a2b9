"""Rows become tables of bodies: in their frames, and the same however many are taken together."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from kousoku.runtime.integrate import body_tables as module
from kousoku.runtime.integrate.body_tables import (
    body_tables,
    solver_state,
    written_sizes,
    written_state,
)

TURNED = (0.5, 0.5, 0.5, 0.5)  # x to y, y to z, z to x
STILL = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))


def body(name: str, **places: Any) -> Any:
    given = {"r": (0, 1, 2), "p": (3, 4, 5, 6), "v": (0, 1, 2), "omega_b": (3, 4, 5)}
    own = {"origin_b": STILL[0], "axes_b": STILL[1]}
    return SimpleNamespace(name=name, **given | own | places)


def rows(count: int = 1) -> tuple[Any, Any, Any]:
    """Body at (1, 2, 3), turned, and turning about the x of its principal frame."""
    q = np.tile([1.0, 2.0, 3.0, *TURNED], (count, 1))
    v = np.tile([0.1, 0.2, 0.3, 2.0, 0.0, 0.0], (count, 1))
    v_dot = np.tile([1.0, 1.0, 1.0, 0.0, 0.0, 3.0], (count, 1))
    return q, v, v_dot


def test_the_frame_of_the_user_moves_with_the_principal_frame() -> None:
    """Its origin at 1 m along y′, its axes turned: ω′ = 2 x′ moves it along z′, which is x."""
    found = body_tables([body("b", origin_b=(0.0, 1.0, 0.0), axes_b=TURNED)], *rows(), unit=0.5)

    assert found["position"]["b"].tolist() == [[2.0, 4.0, 8.0]]
    assert found["velocity"]["b"].tolist() == [[2 * 2.1, 0.4, 0.6]]
    assert found["orientation"]["b"].tolist() == [[-0.5, 0.5, 0.5, 0.5]]
    assert found["angular_velocity"]["b"].tolist() == [[0.0, 0.0, 2.0]]
    assert found["angular_acceleration"]["b"].tolist() == [[0.0, 3.0, 0.0]]
    # α × s = −3 x′, which is −3 y; ω × (ω × s) = −4 y′, which is −4 z
    assert found["acceleration"]["b"].tolist() == [[2.0, 2 * (1 - 3.0), 2 * (1 - 4.0)]]


def test_what_stands_still_is_made_of_numbers() -> None:
    ground = body("b", r=STILL[0], p=STILL[1], v=STILL[0], omega_b=STILL[0], origin_b=(3.0, 0, 1.0))
    found = body_tables([ground], *rows(2), unit=1.0)

    assert found["position"]["b"].tolist() == [[3.0, 0.0, 1.0]] * 2
    assert not any(found[name]["b"].any() for name in ("velocity", "acceleration"))


def test_a_point_has_no_orientation_and_bodies_keep_their_order() -> None:
    point = body("point", p=(), omega_b=())
    found = body_tables([body("a"), point, body("z")], *rows(), unit=1.0)

    assert list(found["position"]) == ["a", "point", "z"]
    assert list(found["orientation"]) == ["a", "z"]
    assert found["acceleration"]["point"].tolist() == [[1.0, 1.0, 1.0]]


def test_accelerations_are_there_where_they_are_wanted() -> None:
    q, v, _ = rows()
    assert set(body_tables([body("a")], q, v, None, 1.0)) == {
        *("position", "velocity", "orientation", "angular_velocity"),
    }


@pytest.mark.parametrize("together", [1, 5, 6, 1000])
def test_bodies_that_are_taken_together_do_not_change_each_other(
    together: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(3)
    q, v, v_dot = rng.normal(size=(3, 14)), rng.normal(size=(3, 12)), rng.normal(size=(3, 12))
    second = {"r": (7, 8, 9), "p": (10, 11, 12, 13), "v": (6, 7, 8), "omega_b": (9, 10, 11)}
    bodies = [body("a"), body("b", **second, origin_b=(1.0, 2.0, 3.0)), body("c", p=(), omega_b=())]
    alone = [body_tables([one], q, v, v_dot, 1.0) for one in bodies]
    monkeypatch.setattr(module, "TOGETHER", together)
    found = body_tables(bodies, q, v, v_dot, 1.0)

    for one, table in zip(bodies, alone, strict=True):
        for name, values in table.items():
            np.testing.assert_array_equal(found[name][one.name], values[one.name])


def test_a_state_as_written_leads_back_to_that_of_the_solver() -> None:
    """Bodies with an origin and axes of their own, a point, one that stands still in a plane."""
    rng = np.random.default_rng(7)
    q, v = rng.normal(size=(18, 1))[:, 0], rng.normal(size=15)
    for first in (0, 7):
        q[first + 3 : first + 7] /= np.linalg.norm(q[first + 3 : first + 7])
    second = {"r": (7, 8, 9), "p": (10, 11, 12, 13), "v": (6, 7, 8), "omega_b": (9, 10, 11)}
    bodies = [
        body("a", origin_b=(1.0, 2.0, 3.0), axes_b=TURNED),
        body("point", r=(14, 15, 0.5), v=(12, 13, 0.0), p=(), omega_b=()),
        body("b", **second, origin_b=(-1.0, 0.0, 0.25)),
    ]
    written = written_state(bodies, q, v, 0.01)
    there = solver_state(bodies, *written, 0.01, (np.where(np.arange(18) < 14, q + 0.1, q), v))

    assert [len(x) for x in written] == [17, 15] == list(written_sizes(bodies))
    assert written[0][7:10].tolist() == [q[14] / 0.01, q[15] / 0.01, 50.0]
    assert there[0] == pytest.approx(q, abs=1e-14)
    assert there[1] == pytest.approx(v, abs=1e-14)
