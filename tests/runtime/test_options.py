"""Options that are no numbers are refused by name, not by an error of Python."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.errors import SolveError
from kousoku.model.families import chain
from kousoku.runtime.dynamics import load_dynamics

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"end": "3"}, "end '3'; wanted a number"),
        ({"end": 1.0, "samples": 2.5}, "samples 2.5; wanted a whole number"),
        ({"end": 1.0, "tolerance": "1e-9"}, "tolerance '1e-9'; wanted a number"),
        ({"end": 1.0, "largest_step": None}, "largest step None; wanted a number"),
        ({"end": 1.0, "step": True}, "step True; wanted a number"),
        ({"end": 1.0, "most_steps": 2.5}, "most steps 2.5; wanted a whole number"),
        ({"times": "soon"}, "times 'soon'; wanted a row of numbers"),
    ],
)
def test_what_is_no_number_is_refused_by_name(
    bodies_folder: Callable[..., Path], options: dict[str, Any], message: str
) -> None:
    solver = load_dynamics(bodies_folder(chain(2), ()), target="numpy")
    with pytest.raises(SolveError, match=message):
        solver.simulate(**options)


def test_numbers_of_numpy_are_numbers(bodies_folder: Callable[..., Path]) -> None:
    solver = load_dynamics(bodies_folder(chain(2), ()), target="numpy")
    count: Any = np.int64(2)
    motion = solver.simulate(np.float64(0.01), samples=count, tolerance=np.float32(1e-3))
    assert len(motion) == 2
