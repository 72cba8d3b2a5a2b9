"""Tables of long motions: what is off after so many steps and turns."""

from __future__ import annotations

from typing import Any

import pytest

from kousoku.runtime.kinematics.moving import Linkage
from tests.stress import endurance

#: What they look at is no part of kousoku.
pytestmark = pytest.mark.release


def test_columns_are_the_whole_number_and_its_tenths() -> None:
    assert endurance.marks(1_000_000) == {f"1e{k}": 10**k for k in range(3, 7)}
    assert endurance.marks(20) == {"2e1": 20}
    assert endurance.marks(300) == {"3e2": 300}


def test_drift_and_energy_are_told_against_steps() -> None:
    tables = endurance.run("conservative n_four_bar 1 4000").tables
    drift = tables["drift of constraints, by steps (m)"]["n_four_bar, dop853 with 1e-09"]
    energy = tables["energy lost, by steps (of what moves)"]["n_four_bar, dop853 with 1e-09"]
    for cells in (drift, energy):
        values = [cells[column].value for column in ("4e2", "4e3")]
        assert 0.0 < values[0] <= values[1] < 1e-6


def test_a_linkage_makes_all_its_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    right, numbers = Linkage.rows, list[int]()

    def rows(self: Linkage, request: Any) -> Any:
        made = right(self, request)
        numbers.append(made.done)
        if made.done > endurance.DIVISIONS + 1:  # from turn 40 on it is beside its way
            made.position[40 * endurance.DIVISIONS :] += 1e-9
        return made

    assert endurance.run("linkage lever_crank 50").findings == []
    monkeypatch.setattr(Linkage, "rows", rows)
    outcome = endurance.run("linkage lever_crank 50")
    assert max(numbers) == 50 * endurance.DIVISIONS + 1
    titles = {finding.title.partition(" (")[0] for finding in outcome.findings}
    assert titles == {
        "a late turn of a linkage beside the first",
        "the last turn of a linkage, asked for alone",
    }
