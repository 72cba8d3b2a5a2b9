"""Linkages whose joints nearly hold more than once move as those do that hold exactly so."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.codegen.dynamics import choose
from kousoku.model.errors import SceneError, SolveError
from kousoku.model.reading.read import scene_from_dict
from kousoku.runtime.messages import shortly

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.model.records.scene import Scene

TURN = np.linalg.qr(np.array([[1.0, 0.4, 0.2], [0.3, -1.0, 0.7], [0.1, 0.5, 1.0]]))[0]
#: Corners and axes of the linkage of Bricard, along edges of a cube.
CORNERS = ((1, 0, 0), (1, 1, 0), (1, 1, 1), (0, 1, 1), (0, 0, 1), (0, 0, 0))
AXES = ((0, 0, 1), (1, 0, 0), (0, 1, 0)) * 2
Y = (0.0, -9.81, 0.0)


def bricard(digits: int) -> Scene:
    """Linkage of Bricard, turned, as one types it with so many digits."""

    def typed(x: Any) -> list[float]:
        return [round(float(component), digits) for component in TURN @ np.array(x)]

    names = ["ground", *(f"rod_{k}" for k in range(5)), "ground"]
    tree: dict[str, Any] = {"name": "bricard", "unit": "m", "gravity": typed(Y)}
    tree["bodies"] = {
        name: {
            "position": typed(a),
            "cylinders": [
                {"mass": 1, "radius": 0.05, "ends": [[0, 0, 0], typed(np.subtract(b, a))]}
            ],
        }
        for name, (a, b) in zip(names[1:], pairwise(CORNERS), strict=False)
    }
    tree["joints"] = {
        name: {"type": "revolute", "bodies": [*bodies], "at": typed(at), "axis": typed(axis)}
        for name, bodies, at, axis in zip("abcdef", pairwise(names), CORNERS, AXES, strict=True)
    }
    return scene_from_dict(tree)


def door(by: float | str, **more: Any) -> Scene:
    """Door on two hinges, the upper one aside and leaning by so much."""
    tree: dict[str, Any] = {"name": "door", "unit": "m", "gravity": [*Y], **more}
    tree["bodies"] = {
        "d": {
            "position": [0, 0, 0],
            "boxes": [{"mass": 5, "size": [1, 0.1, 2], "at": [0.5, 0, 0.5]}],
        }
    }
    tree["joints"] = {
        name: {"type": "revolute", "bodies": ["ground", "d"], "at": at, "axis": axis}
        for name, at, axis in (("h", [0, 0, 0], [0, 0, 1]), ("g", [by, 0, 1], [0, by, 1]))
    }
    return scene_from_dict(tree)


@pytest.mark.parametrize(("digits", "near"), [(4, 2e-2), (6, 2e-4)])
def test_linkage_of_bricard_turns_as_it_is_typed(
    mover: Callable[..., Any], digits: int, near: float
) -> None:
    exact = mover(bricard(16)).simulate(10.0, samples=11)
    typed = mover(bricard(digits)).simulate(10.0, samples=11)

    a, b = exact.columns(), typed.columns()
    assert max(np.abs(a[f"rod_{k}.y"] - b[f"rod_{k}.y"]).max() for k in range(5)) < near
    assert np.ptp(b["rod_4.y"]) > 0.3
    ledger = typed.ledger
    assert ledger.trust.is_trusted
    assert ledger.released == ()
    ((_, (metres, radians)),) = ledger.missed.items()
    assert 10.0**-digits / 100 < max(metres, radians) < 10.0 ** (1 - digits)
    assert f"redundant rows miss {shortly(ledger.trust.missed)}" in str(ledger.trust)
    assert any("redundant within closure_tolerance" in note for note in typed.notes)
    # of rows that are solved for nothing is left
    assert ledger.trust.constraints < 1e-12


@pytest.mark.parametrize("by", [1e-8, 1e-7, 1e-5])
def test_door_turns_on_hinges_that_are_nearly_in_line(mover: Callable[..., Any], by: float) -> None:
    outputs = ("accelerations", "reactions")
    exact, found = (mover(door(x), outputs).simulate(3.0, samples=4) for x in (0.0, by))

    a, b = exact.columns(), found.columns()
    assert a["d.alpha_z"][0] == pytest.approx(-14.678, abs=1e-3)
    for name in ("d.e0", "d.e3", "d.omega_z", "d.alpha_z"):
        assert b[name] == pytest.approx(a[name], abs=20 * by)
    for joint in "hg":
        assert found.force[joint] == pytest.approx(exact.force[joint], abs=1e3 * by)
    assert found.ledger.trust.is_trusted
    assert by < found.ledger.trust.missed < 5 * by


@pytest.mark.parametrize("by", [1.2e-3, 1e-2])
def test_door_that_is_shut_stays_and_says_so(mover: Callable[..., Any], by: float) -> None:
    shut = mover(door(by), ("accelerations", "reactions")).simulate(1.0, samples=2)

    assert "nothing can move: joints hold all bodies where they are" in shut.notes
    assert shut.ledger.trust.is_trusted
    columns = shut.columns()
    for name in columns:
        if name.startswith(("d.v", "d.omega", "d.alpha")):
            assert np.abs(columns[name]).max() < 1e-6
    assert all(np.isfinite(shut.force[joint]).all() for joint in "hg")


def test_what_space_refuses_of_a_plane_is_not_computed_and_told(
    mover: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object) -> None:
        raise SceneError("holds beyond joints.g no more than so much", key="joints.h")

    monkeypatch.setattr(choose, "_in_space", refused)
    shut = mover(door(0.0123), ("accelerations", "reactions")).simulate(1.0, samples=2)

    forces = np.array([shut.force[joint] for joint in "hg"])
    assert np.isfinite(forces[..., :2]).all()
    assert np.isnan(forces).any()
    (told,) = (note for note in shut.notes if "not computed, and NaN: what leads out" in note)
    assert "in space joints.h: holds beyond joints.g no more than" in told


@pytest.mark.parametrize(("by", "told"), [(1e-8, "redundant within"), (5e-3, "nothing can move")])
def test_notes_say_that_they_are_of_the_parameters_of_the_scene(
    mover: Callable[..., Any], by: float, told: str
) -> None:
    whole = mover(door(by)).simulate(0.1, samples=2)
    given = mover(door("by", parameters={"by": by})).simulate(0.1, samples=2)

    (one,) = (note for note in whole.notes if note.startswith(told))
    (other,) = (note for note in given.notes if note.startswith(told))
    assert ", with the parameters of the scene" in other
    assert ", with the parameters of the scene" not in one


def test_bars_in_line_are_refused_and_cannot_move(mover: Callable[..., Any]) -> None:
    tree: dict[str, Any] = {"name": "bars", "unit": "m", "gravity": [*Y]}
    rod = {"mass": 1, "radius": 0.05, "ends": [[0, 0, 0], [1, 0, 0]]}
    tree["bodies"] = {
        name: {"position": [x, 0, 0], "cylinders": [rod]} for name, x in (("a", 0), ("b", 1))
    }
    tree["joints"] = {
        name: {"type": "hinge", "bodies": [*bodies], "at": [x, 0, 0], "axis": [0, 0, 1]}
        for x, (name, *bodies) in enumerate(
            [("A", "ground", "a"), ("B", "a", "b"), ("C", "b", "ground")]
        )
    }
    with pytest.raises(SolveError, match="nothing can move"):
        mover(scene_from_dict(tree)).simulate(1.0)
