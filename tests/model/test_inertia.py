"""Dynamics wants a mass, and a moment of inertia about every axis that a body may turn about."""

from __future__ import annotations

from typing import Any

import pytest

from kousoku.model.errors import SceneError
from kousoku.model.families import chain, n_four_bar
from kousoku.model.inertia import require_inertia
from kousoku.model.read import scene_from_dict
from kousoku.model.system import system_of


def one_body(**keys: Any) -> Any:
    """Return the system of a free body."""
    tree = {"name": "one", "unit": "m", "bodies": {"b": {"position": [0, 0, 0], **keys}}}
    return system_of(scene_from_dict(tree))


def test_a_body_without_mass_is_refused_by_name() -> None:
    with pytest.raises(SceneError, match=r"bodies\.b\.mass: is missing; dynamics wants a mass"):
        require_inertia(one_body(), is_planar=True)


def test_a_rod_without_thickness_moves_in_its_plane_only() -> None:
    system = system_of(n_four_bar(1))
    require_inertia(system, is_planar=True)
    with pytest.raises(SceneError, match=r"bodies\.crank_0: .* about its second principal axis"):
        require_inertia(system, is_planar=False)


def test_a_mass_point_that_may_turn_is_refused_and_a_point_is_not() -> None:
    with pytest.raises(SceneError, match="first and second and third principal axis"):
        require_inertia(one_body(mass=1), is_planar=False)
    require_inertia(one_body(mass=1, point=True), is_planar=False)


def test_bodies_with_extent_are_accepted() -> None:
    require_inertia(system_of(chain(2)), is_planar=False)
