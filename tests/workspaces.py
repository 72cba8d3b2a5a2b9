"""States that tests write to a program's workspace, and what they read there body by body."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

if TYPE_CHECKING:
    from kousoku.codegen.dynamics.recording.interpreter import ProgramInterpreter


def put(workspace: ProgramInterpreter, state: dict[str, Any]) -> None:
    """Write a state to where the program wants it."""
    for name in ("r", "p", "v", "omega_b"):
        for body, values in zip(workspace.program.bodies, state[name], strict=True):
            for place, value in zip(getattr(body, name), values, strict=True):
                if place.slot >= 0:
                    workspace.values[place.slot] = float(value)
                else:
                    assert place.value == pytest.approx(value, abs=1e-15)


def by_body(workspace: ProgramInterpreter, region: str) -> Any:
    """Elements of a region in the order of v, (n, 6), zeros where there is no coordinate."""
    program = workspace.program
    offset = program.region(region).base - program.region("v").base
    return np.array(
        [
            [
                workspace.values[place.slot + offset] if place.slot >= 0 else 0.0
                for place in (*body.v, *body.omega_b)
            ]
            for body in program.bodies
        ]
    )
