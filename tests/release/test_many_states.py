"""Emitted kernels at many random states of machines; ``make stress`` asks for more."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from kousoku.runtime.report import LIMIT
from tests.codegen.test_states import STATES, worst

if TYPE_CHECKING:
    from tests.codegen.test_states import Derived, State

#: A matrix takes longer.
MANY, MANY_OF_A_MATRIX = 100, 20


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize(("kind", "output", "state"), STATES)
def test_many_states_of_machines(kind: str, output: str, state: State, derived: Derived) -> None:
    count = MANY_OF_A_MATRIX if output == "reaction_q" else MANY
    assert worst(kind, output, state, count, derived) <= LIMIT
