"""The table of kernels: each output of a kind, with the point of its largest error."""

from __future__ import annotations

import pytest

from tests.stress import kernels

#: What they look at is no part of kousoku.
pytestmark = pytest.mark.release


def test_each_output_of_a_kind_has_its_worst_point() -> None:
    outcome = kernels.run("states n1 3 1 0")
    rows = outcome.tables["worst (units)"]
    functions = (subject.components for subject in kernels.subjects("n1"))
    assert {*rows} == {f"n1, {output.name}" for one in functions for output in one.outputs}
    figure = outcome.figures[f"{kernels.STATES} (units)"]
    worst = max((cells[kernels.STATES] for cells in rows.values()), key=lambda one: one.value)
    assert worst.value == figure.value > 0.0
    assert "r_i=[" in worst.place or "a_i_b=[" in worst.place
