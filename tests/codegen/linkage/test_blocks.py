"""The block-triangular form, and what is said of linkages that are not determined."""

from __future__ import annotations

from pathlib import Path

import pytest

from kousoku.codegen.linkage.assemble import Assembly, assemble
from kousoku.codegen.linkage.blocks import DiagonalBlock, live_blocks, triangular_blocks
from kousoku.model.errors import SceneError
from kousoku.model.planar import Input, Link, Node
from kousoku.model.read import read_scene
from kousoku.model.scene import Scene

SCENES = Path(__file__).parents[3] / "scenes"


def named(assembly: Assembly, blocks: tuple[DiagonalBlock, ...]) -> list[tuple[str, ...]]:
    return [tuple(assembly.coordinates[u].name for u in block.unknowns) for block in blocks]


def wanted(assembly: Assembly) -> list[int]:
    return [term.coordinate for _, x, y in assembly.nodes for term in (x, y)]


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("piston_crank", [("O2.x", "O2.y"), ("piston",)]),
        ("lever_crank", [("O2.x", "O2.y"), ("O3.x", "O3.y")]),
        ("five_bar", [("A.x", "A.y"), ("C.x", "C.y"), ("B.x", "B.y")]),
    ],
)
def test_mechanisms_fall_apart_into_dyads(name: str, parts: list[tuple[str, ...]]) -> None:
    assembly = assemble(read_scene(SCENES / f"{name}.toml"))
    live = live_blocks(assembly, triangular_blocks(assembly), wanted(assembly))
    assert named(assembly, live) == parts


def test_rotations_at_hinges_are_blocks_of_their_own_and_not_computed() -> None:
    assembly = assemble(read_scene(SCENES / "lever_crank.toml"))
    blocks = triangular_blocks(assembly)
    live = live_blocks(assembly, blocks, wanted(assembly))
    dropped = [block for block in blocks if block not in live]
    assert named(assembly, tuple(dropped)) == [
        ("l1@O2",),
        ("l2@O2",),
        ("l2@O3",),
        ("l3@O3",),
        ("l3@O4",),
    ]


def test_rotation_of_a_rigid_connection_is_computed() -> None:
    assembly = assemble(read_scene(SCENES / "watt_six_bar.toml"))
    live = live_blocks(assembly, triangular_blocks(assembly), wanted(assembly))
    assert ("r1@O3",) in named(assembly, live)


def test_every_block_comes_after_those_it_depends_on() -> None:
    assembly = assemble(read_scene(SCENES / "stephenson_six_bar.toml"))
    blocks = triangular_blocks(assembly)
    known: set[int] = set()
    for block in blocks:
        known.update(block.unknowns)
        for number, row in block.rows:
            places = ((0, 1, 3, 4), (0, 1, 2, 3, 4), (0, 1, 3, 4, 5))[row]
            needed = {assembly.elements[number].ends[place].coordinate for place in places}
            unknown = {n for n in needed if assembly.coordinates[n].role.value == "unknown"}
            assert unknown <= known
    assert sum(len(block.unknowns) for block in blocks) == sum(
        len(element.rows) for element in assembly.elements
    )


def grid(links: dict[str, Link], inputs: dict[str, Input]) -> Scene:
    nodes = {
        "O": Node(at=(0, 0), fixed=True),
        "P": Node(at=(4, 0), fixed=True),
        "A": Node(at=(0, 1)),
        "B": Node(at=(4, 1)),
    }
    return Scene(name="grid", unit="m", nodes=nodes, links=links, inputs=inputs)


LINKS = {
    "oa": Link(nodes=("O", "A"), length=1),
    "ab": Link(nodes=("A", "B"), length=4),
    "bp": Link(nodes=("B", "P"), length=1),
}
DRIVE = {"alpha": Input(link="oa", about="O")}


def test_free_nodes_are_named() -> None:
    with pytest.raises(SceneError, match="determined: B can still move; add 1 more input"):
        triangular_blocks(assemble(grid({k: LINKS[k] for k in ("oa", "ab")}, DRIVE)))


def test_links_that_hold_too_much_are_named() -> None:
    links = {**LINKS, "ob": Link(nodes=("O", "B"), length=17**0.5)}
    with pytest.raises(SceneError, match=r"links .*ob.* hold their nodes more than once; remove 1"):
        triangular_blocks(assemble(grid(links, DRIVE)))


def test_long_chains_need_no_recursion() -> None:
    """A tower of four-bars, each on the one before: blocks grow in number, not in size."""
    count = 1500
    nodes = {"O": Node(at=(0, 0), fixed=True), "N0": Node(at=(1, 0))}
    links = {"crank": Link(nodes=("O", "N0"), length=1)}
    for k in range(count):
        nodes[f"N{k + 1}"] = Node(at=(k + 2.0, 1.0))
        nodes[f"F{k}"] = Node(at=(k + 2.0, -3.0), fixed=True)
        links[f"rod{k}"] = Link(nodes=(f"N{k}", f"N{k + 1}"), length=1.5)
        links[f"rocker{k}"] = Link(nodes=(f"F{k}", f"N{k + 1}"), length=4)
    inputs = {"alpha": Input(link="crank", about="O")}
    assembly = assemble(Scene(name="tower", unit="m", nodes=nodes, links=links, inputs=inputs))
    live = live_blocks(assembly, triangular_blocks(assembly), wanted(assembly))
    assert [len(block.unknowns) for block in live] == [2] * (count + 1)
