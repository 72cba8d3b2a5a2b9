"""What moves coordinates least: by the inertia that each velocity has of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from kousoku.runtime.integrate.body_tables import BodyPlaces
from kousoku.runtime.integrate.initial_coordinates import Leader, Start

#: Of each direction of a point; nothing moves where the last one leads.
MASSES = np.array([0.25, 4.0, 0.0])
SLOPES = np.array([[2.0, 3.0, 5.0]])


@pytest.fixture
def leader() -> Leader:
    """Leader of a point with three masses, and of a sum of its coordinates."""

    def evaluate(q: Any, v: Any) -> dict[str, Any]:
        return {
            "coordinates": np.concatenate([SLOPES @ q, SLOPES @ v]),
            "energies": np.array([0.5 * float(MASSES @ (v * v)), 0.0]),
            "dv": np.zeros(3),
            "q_dot": v,
            "q_moved": q,
        }

    point = BodyPlaces("point", (0, 1, 2), (), (0, 1, 2), (), (0.0,) * 3, (1.0, 0.0, 0.0, 0.0))
    return Leader(
        Start(
            evaluate=evaluate,
            q=np.zeros(3),
            v=np.zeros(3),
            bodies=[point],
            coordinates={"sum": (0, 1, 1.0)},
            rows=(),
            works=(),
            length=1.0,
            unit=1.0,
        )
    )


def test_the_least_motion_of_a_coordinate_is_by_masses(leader: Leader) -> None:
    """M⁻¹Jᵀ, with 1 for what has no mass."""
    found = leader.jacobian(np.array([0.1, 0.2, 0.3]))
    np.testing.assert_array_equal(found.J, SLOPES)
    np.testing.assert_allclose(found.free, [[8.0, 0.75, 5.0]], rtol=1e-15)
    np.testing.assert_array_equal(found.motions, found.free)
