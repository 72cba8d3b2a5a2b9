"""The block-triangular form."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from kousoku.codegen.linkage.assemble import Assembly, Role, assemble
from kousoku.codegen.linkage.blocks import DiagonalBlock, live_blocks, triangular_blocks
from kousoku.model.errors import SceneError
from kousoku.model.reading.read import read_scene
from kousoku.model.records.planar import Input, Link, Node, Rigid, Slider
from kousoku.model.records.scene import Scene
from kousoku.model.validation.validate import check

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


def drawn(draw: random.Random) -> Scene:
    """Random linkage, unchecked: parts of it may be free or held twice.

    Nodes hang on two others, or on one other and an angle, or slide on a line.
    """
    nodes = {"O": Node(at=(0, 0), fixed=True), "P": Node(at=(draw.uniform(1, 9), 0), fixed=True)}
    links: dict[str, Link] = {}
    sliders: dict[str, Slider] = {}
    rigid: dict[str, Rigid] = {}
    inputs: dict[str, Input] = {}
    for k in range(draw.randrange(1, 7)):
        name, (one, two) = f"N{k}", draw.sample(sorted(nodes), 2)
        at_one = [x for x, link in links.items() if one in link.nodes]
        nodes[name] = Node(at=(draw.uniform(-9, 9), draw.uniform(-9, 9)))
        links[f"a{k}"] = Link(nodes=(one, name))
        way = draw.choice(["link", "link", "input", "slider", "rigid"])
        if way == "link":
            links[f"b{k}"] = Link(nodes=(two, name) if draw.random() < 0.5 else (name, two))
        elif way == "input":
            inputs[f"i{k}"] = Input(link=f"a{k}", about=draw.choice([one, name]), to=0.001)
        elif way == "slider":
            sliders[f"s{k}"] = Slider(node=name, through=(0, 1), direction=(draw.uniform(1, 2), 1))
        elif at_one:
            rigid[f"r{k}"] = Rigid(at=one, links=(draw.choice(at_one), f"a{k}"))
    if draw.random() < 0.3:
        one, two = draw.sample(sorted(nodes), 2)
        links[draw.choice(sorted(links))] = Link(nodes=(one, two))
    return Scene(
        name="x", unit="m", nodes=nodes, links=links, sliders=sliders, rigid=rigid, inputs=inputs
    )


def test_what_inputs_determine_has_blocks() -> None:
    """Where as many rows are independent as there are unknowns, all are matched."""
    draw, count = random.Random(1981), 0
    for _ in range(800):
        scene = drawn(draw)
        try:
            check(scene)
        except SceneError:
            continue
        assembly, count = assemble(scene), count + 1
        assert sum(len(block.unknowns) for block in triangular_blocks(assembly)) == sum(
            coordinate.role is Role.UNKNOWN for coordinate in assembly.coordinates
        )
    assert count > 100


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
