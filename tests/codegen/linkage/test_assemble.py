"""Assembling: numbered coordinates, what is shared, what is known, what is dropped."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

from kousoku.codegen.linkage.assemble import Assembly, Role, assemble
from kousoku.model.reading.read import read_scene
from kousoku.model.records.planar import Input, Link, Node, Rigid, Slider
from kousoku.model.records.scene import Scene

SCENES = Path(__file__).parents[3] / "scenes"


def assembled(name: str) -> Assembly:
    return assemble(read_scene(SCENES / f"{name}.toml"))


def names(made: Assembly, role: Role) -> list[str]:
    return [coordinate.name for coordinate in made.coordinates if coordinate.role is role]


def scene(**parts: object) -> Scene:
    """Scene of one fixed node O and two links O-A, A-B, unchecked."""
    given: dict[str, object] = {
        "nodes": {"O": Node(at=(0, 0), fixed=True), "A": Node(at=(2, 0)), "B": Node(at=(2, 1))},
        "links": {"oa": Link(nodes=("O", "A"), length=2), "ab": Link(nodes=("A", "B"), length=1)},
        "inputs": {"alpha": Input(link="oa", about="O")},
    }
    fields: dict[str, Any] = given | parts
    return Scene(name="made", unit="m", **fields)


def test_piston_crank_has_the_coordinates_of_equation_29() -> None:
    made = assembled("piston_crank")
    assert names(made, Role.FIXED) == ["O1.x", "O1.y"]
    assert names(made, Role.INPUT) == ["alpha"]
    assert names(made, Role.UNKNOWN) == ["O2.x", "O2.y", "piston", "l1@O2", "l2@O2", "l2@O3"]
    assert [element.rows for element in made.elements] == [(0, 1, 2), (0, 1, 2)]
    assert made.notes == ("O3.x and O3.y merged: slider piston",)


def test_lever_crank_drops_its_frame_link() -> None:
    made = assembled("lever_crank")
    assert [element.name for element in made.elements] == ["l1", "l2", "l3"]
    assert "l4 dropped: both of its nodes are fixed" in made.notes
    unknown = names(made, Role.UNKNOWN)
    assert len(unknown) == sum(len(element.rows) for element in made.elements) == 9


def test_rigid_connection_shares_one_rotation() -> None:
    made = assembled("watt_six_bar")
    assert "rotations of r1, r2 at O3 merged: rigid connection" in made.notes
    shared = {
        element.name: element.ends[2] for element in made.elements if element.name in {"r1", "r2"}
    }
    assert shared["r1"].coordinate == shared["r2"].coordinate
    assert shared["r2"].offset - shared["r1"].offset == Fraction(-1.2)


def test_end_with_a_shared_or_prescribed_rotation_comes_first() -> None:
    made = assemble(
        scene(
            links={
                "oa": Link(nodes=("A", "O"), length=2),
                "ab": Link(nodes=("A", "B"), length=1),
            }
        )
    )
    assert made.elements[0].nodes == ("O", "A")
    assert made.elements[1].nodes == ("A", "B")


def test_slider_is_one_coordinate_along_a_unit_vector() -> None:
    made = assemble(scene(sliders={"s": Slider(node="B", through=(1, 1), direction=(-3, 4))}))
    _, x, y = made.nodes[2]
    assert x.coordinate == y.coordinate
    assert (x.factor, x.offset) == (Fraction(-3, 5), Fraction(1))
    assert (y.factor, y.offset) == (Fraction(4, 5), Fraction(1))
    assert made.coordinates[x.coordinate].start == Fraction(-3, 5)


def test_rotation_moves_as_far_as_its_link_is_long() -> None:
    made = assemble(scene())
    scales = {c.name: c.scale for c in made.coordinates}
    assert scales["alpha"] == 2
    assert scales["A.x"] == 1


def test_input_turns_the_rigid_body_it_is_given_on() -> None:
    """The prescribed link is the one whose angle is the coordinate."""
    links = {"ob": Link(nodes=("O", "B"), length=1), "oa": Link(nodes=("O", "A"), length=2)}
    rigid = {"r": Rigid(at="O", links=("ob", "oa"), angle=0.5)}
    made = assemble(scene(links=links, rigid=rigid))
    first = {element.name: element.ends[2] for element in made.elements}
    assert first["oa"].offset == 0
    assert first["ob"].offset == Fraction(-0.5)
    assert made.coordinates[first["oa"].coordinate].name == "alpha"
