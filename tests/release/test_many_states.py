"""Emitted kernels at as many random states of machines as the defects were found with."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from kousoku.runtime.report import LIMIT
from tests.codegen.test_states import STATES, worst

if TYPE_CHECKING:
    from tests.codegen.test_states import Derived, State

MANY = 300


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize(("kind", "output", "state"), STATES)
def test_many_states_of_machines(kind: str, output: str, state: State, derived: Derived) -> None:
    assert worst(kind, output, state, MANY, derived) <= LIMIT
