"""The changes of momentum that a ledger tells."""

from __future__ import annotations

import json

from kousoku.runtime.momenta import ConservedPlaces, Momentum, momenta_of

ALONG = (1.0, 0.0, 0.0)


def test_changes_are_told_by_part_the_largest_of_all_directions() -> None:
    parts = [
        ConservedPlaces(("a", "b"), (ALONG, ALONG), (ALONG,)),
        ConservedPlaces(("c",), (ALONG,), ()),
        ConservedPlaces(("d",), (), (ALONG,)),
    ]
    found = momenta_of(parts, [1e-9, 3e-9, 2e-6, 4e-3, 5e-2])
    assert found == (
        Momentum(("a", "b"), 3e-9, 2e-6),
        Momentum(("c",), 4e-3, None),
        Momentum(("d",), None, 5e-2),
    )


def test_a_text_names_few_bodies_and_leaves_out_what_is_not_kept() -> None:
    assert str(Momentum(("a", "b"), 3e-9, 2e-6)) == (
        "momentum of a, b: largest change 3.0e-09 kg m/s, 2.0e-06 kg m²/s"
    )
    many = Momentum(("a", "b", "c", "d"), None, 2e-6)
    assert str(many) == "momentum of a, b, c, …: largest change 2.0e-06 kg m²/s"


def test_it_is_ready_for_json() -> None:
    data = Momentum(("a",), 1.0, None).as_data()
    assert json.loads(json.dumps(data)) == {
        "bodies": ["a"],
        "linear": 1.0,
        "angular": None,
        "about": "centre of mass",
    }


def test_what_motion_json_says_of_a_part_is_taken_over() -> None:
    data = {"bodies": ["a"], "linear": [[1, 0, 0]], "angular": [], "is_central": False}
    assert ConservedPlaces.from_data(data) == ConservedPlaces(("a",), ((1, 0, 0),), (), False)


def test_what_the_angular_momentum_is_about_is_told() -> None:
    (found,) = momenta_of([ConservedPlaces(("a",), (), (ALONG,), is_central=False)], [2e-6])
    assert str(found).endswith("2.0e-06 kg m²/s about a point of the ground")
    assert found.as_data()["about"] == "a point of the ground"
