"""The scene record: frozen, with design values where the user left them out."""

from __future__ import annotations

import subprocess
import sys
from math import pi
from typing import Any

import pytest

from kousoku.model.records.planar import Link, Node, Rigid
from kousoku.model.records.scene import Scene


@pytest.fixture
def corner() -> Scene:
    """Right angle of three links at B, and a frame link."""
    nodes = {
        "A": Node(at=(0.0, 0.0), fixed=True),
        "B": Node(at=(3.0, 0.0)),
        "C": Node(at=(3.0, 4.0)),
        "D": Node(at=(9.0, 0.0), fixed=True),
    }
    links = {
        "ab": Link(nodes=("A", "B"), length=2.5),
        "bc": Link(nodes=("B", "C")),
        "bd": Link(nodes=("D", "B")),
        "ad": Link(nodes=("A", "D")),
    }
    rigid = {
        "given": Rigid(at="B", links=("bc", "ab"), angle=1.5),
        "drawn": Rigid(at="B", links=("bd", "bc", "ab")),
    }
    return Scene(name="corner", unit="mm", nodes=nodes, links=links, rigid=rigid)


def test_a_scene_does_not_change(corner: Scene) -> None:
    changing: Any = corner
    with pytest.raises(AttributeError, match="immutable"):
        changing.name = "other"
    with pytest.raises(TypeError, match="does not support item assignment"):
        changing.nodes["A"] = Node(at=(1.0, 1.0))


def test_a_length_is_the_distance_of_the_nodes_unless_it_is_given(corner: Scene) -> None:
    assert corner.length("ab") == 2.5
    assert corner.length("bc") == 4
    assert corner.largest_length == 9


def test_an_angle_is_that_of_the_drawing_unless_it_is_given(corner: Scene) -> None:
    assert corner.rigid_angle("given", "bc") == 0
    assert corner.rigid_angle("given", "ab") == 1.5
    assert corner.rigid_angle("drawn", "bd") == 0
    assert corner.rigid_angle("drawn", "bc") == pi / 2
    assert corner.rigid_angle("drawn", "ab") == pi


def test_the_limit_of_the_residual_is_a_few_last_digits_of_the_largest_length(
    corner: Scene,
) -> None:
    assert corner.residual_limit == 8 * 2**-52 * 9


def test_a_link_between_fixed_nodes_is_ground(corner: Scene) -> None:
    assert [name for name in corner.links if corner.is_ground(name)] == ["ad"]


def test_a_link_knows_its_other_end() -> None:
    link = Link(nodes=("A", "B"))
    assert (link.other("A"), link.other("B")) == ("B", "A")


def imported_by(module: str) -> set[str]:
    """Modules that a fresh interpreter has imported after one import."""
    code = f"import sys, {module}; print('\\n'.join(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


@pytest.mark.parametrize("name", ["files.quantity", "files.manifest", "errors", "files.cache"])
def test_what_the_runtime_shares_needs_no_parser(name: str) -> None:
    assert not {"msgspec", "tomllib", "sympy"} & imported_by(f"kousoku.model.{name}")


def test_reading_a_scene_starts_no_algebra() -> None:
    assert not {"sympy", "mpmath", "jinja2"} & imported_by("kousoku.model.reading.read")
