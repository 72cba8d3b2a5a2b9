"""Functions whose roots a run looks for: what of a force is a kink, a jump, a distance."""

from __future__ import annotations

from typing import Any

import pytest

from kousoku.model.lowering.root_functions import root_functions_of
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.read import scene_from_dict

Tree = dict[str, Any]


@pytest.mark.parametrize(
    ("force", "count"),
    [
        *[
            ("-x/sqrt(x^2 + x_dot^2)", 1),
            ("x*(x*x + x_dot*x_dot)^(-1/2)", 1),
            ("atan2(x, x_dot)", 1),
        ],
        *[("exp(-log(x^2 + at*x_dot^2))", 1), ("x/sqrt(x^2/4 + x_dot^2)", 1)],
        *[
            ("x/sqrt(x^2 + x_dot^2 + 1e-12)", 0),
            ("sqrt(x^2)", 0),
            ("1/x", 0),
            ("(x^2 + x_dot^2)^2", 0),
        ],
        *[("1/sqrt(t^2 + at^2)", 0), ("1/sqrt(x)", 1), ("x/(1 + x^2)", 0), ("atan2(x, 1)", 0)],
    ],
)
def test_squares_of_distances_are_found_in_forces(bead: Tree, force: str, count: int) -> None:
    push = {"type": "along", "coordinate": "x", "force": force}
    functions = root_functions_of(system_of(scene_from_dict(bead | {"forces": {"push": push}}), ()))
    assert len(functions.distances) == count
    assert not functions.lengths


def test_lengths_count_along_which_a_force_acts_that_is_not_smooth(bead: Tree) -> None:
    ends = {"bodies": ["ground", "bead"], "points": [[0, 0, 0], [0, 0, 0]]}
    bead["coordinates"] |= {"way": ends, "other": ends}

    def counts(**force: object) -> int:
        system = system_of(scene_from_dict(bead | {"forces": {"push": force}}), ())
        return len(root_functions_of(system).lengths)

    spring = {"type": "spring_damper", **ends}
    assert counts(**spring, stiffness=1.0, free_length=0.0) == 0
    assert counts(**spring, stiffness=1.0, free_length=1.0) == 1
    assert counts(**spring, stiffness=1.0, free_length=0.0, damping=1.0) == 1
    assert counts(**spring, tension="x", free_length=1.0) == 1
    assert counts(type="along", coordinate="way", force="1") == 1
    assert counts(type="along", coordinate="way", force="other_dot") == 2
    assert counts(type="along", coordinate="x", force="1") == 0


@pytest.mark.parametrize(
    ("force", "count"),
    [
        ("sign(x)*at + max(x - 1, 0)", 1),
        ("sign(x - 1)*x_dot - sign(x_dot)", 2),
        ("(x - at)/abs(x - at) + x/sqrt(x^2)", 2),
        ("atan2(x, x_dot) + atan(1/(x - at))", 2),
        ("x*abs(x)/(exp(x) - 1)^2", 1),
        ("sign(t - 1)*x", 0),
        ("abs(x) + min(x, x_dot) - abs(x_dot)*x_dot", 0),
    ],
)
def test_functions_at_which_a_force_jumps_are_told_from_kinks(
    bead: Tree, force: str, count: int
) -> None:
    push = {"type": "along", "coordinate": "x", "force": force}
    functions = root_functions_of(system_of(scene_from_dict(bead | {"forces": {"push": push}}), ()))
    assert len(functions.breaks) == count
    assert set(functions.breaks).isdisjoint(functions.crossings)


@pytest.mark.parametrize(
    ("force", "crossings", "narrow"),
    [
        ("max(0, -x)", 1, 0),
        ("-3*abs(x_dot)*x_dot", 0, 0),
        ("-abs(x_dot)*x", 1, 0),
        ("-2*x^3 + at*x_dot", 0, 0),
        ("exp(-(x/at)^2) - sin(x)", 0, 2),
        ("x/at + sin(at)*x", 0, 0),
        ("min(t - 1, x)*at", 1, 0),
        ("-sqrt(x^2)", 1, 1),
        ("-sqrt(x^2 - 2*at*x + at^2)", 1, 1),
        ("-sqrt(x^2 + 2*x*x_dot + x_dot^2)", 1, 1),
        ("-sqrt(x^2 - 2*x + 2)", 0, 1),
        ("x_dot*(x*x)^(1/2) + (x^2)^(3/2)", 1, 2),
    ],
)
def test_what_of_a_force_is_looked_at(bead: Tree, force: str, crossings: int, narrow: int) -> None:
    push = {"type": "along", "coordinate": "x", "force": force}
    system = system_of(scene_from_dict(bead | {"forces": {"push": push}}), ())
    functions = root_functions_of(system)
    assert len(functions.crossings) == crossings
    assert len(functions.narrow) == narrow
    assert not functions.switches
    assert not functions.features
