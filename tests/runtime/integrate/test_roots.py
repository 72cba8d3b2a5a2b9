"""Times at which functions of the state take a side of zero in a step."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from kousoku.runtime.integrate import roots
from kousoku.runtime.integrate.roots import first_departure
from kousoku.runtime.integrate.search import TimeNode


@pytest.mark.parametrize(("before", "cut"), [(0.0, 2.5), (1e-9, 2.5), (-1e-9, math.inf)])
def test_what_is_near_zero_on_its_side_already_cuts_no_step(
    monkeypatch: pytest.MonkeyPatch, before: float, cut: float
) -> None:
    """What is left of zero by less than rounding is left at once, and no step is as short."""
    monkeypatch.setattr(roots, "time_of", lambda *_: 2.5)
    nothing = np.zeros((0, 2))
    near = TimeNode(2.0, nothing, np.array([before - 2e-9]), np.array([before + 2e-9]))
    left = TimeNode(3.0, nothing, np.array([-2e-2]), np.array([-1e-2]))
    search: Any = SimpleNamespace(
        state=SimpleNamespace(sides=np.zeros(1)),
        work=SimpleNamespace(scene=SimpleNamespace(events=(), n_poles=0)),
    )
    assert first_departure(near, left, search) == cut
