"""Whatever a scene file holds, it gives a scene or a SceneError, and nothing else happens."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hypothesis import example, given, settings
from hypothesis import strategies as st

from kousoku.model.errors import MOST_SHOWN, SceneError
from kousoku.model.lowering.system import system_of
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import read_scene, scene_from_dict, scene_from_toml
from kousoku.model.records.scene import Scene

if TYPE_CHECKING:
    import pytest

ROOT = Path(__file__).parents[2]
TEXTS = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "scenes").glob("*.toml"))]
TREES = [tomllib.loads(text) for text in TEXTS]
NAMES = sorted({word for text in TEXTS for word in text.replace('"', " ").split()})

LEAVES = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.sampled_from([10**400, -(10**25), 2**62])
    | st.floats(allow_nan=True, allow_infinity=True)
    | st.sampled_from([5e-324, 1e-300, 1e49, -1e50, 1e308])
    | st.text(max_size=8)
    | st.sampled_from(NAMES)
    | st.dates()
)
TREE = st.recursive(
    LEAVES,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.sampled_from(NAMES) | st.text(max_size=4), inner, max_size=4)
    ),
    max_leaves=12,
)


def gives_scene_or_error(read: Any, source: object) -> None:
    """Check that one of the two comes, and that messages are one readable line each.

    A scene of bodies becomes a system, or is refused by such a message.
    """
    try:
        scene = read(source)
        assert isinstance(scene, Scene)
        if scene.is_spatial:
            system_of(scene)
    except SceneError as error:
        assert error.problem == error.problems[0].problem
        lines = str(error).split("\n")
        assert len(lines) == min(len(error.problems), MOST_SHOWN + 1)
        assert all(line.isprintable() and 0 < len(line) < 1000 for line in lines)


def places(tree: object, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths to all values of a tree."""
    found = [path] if path else []
    items = (
        tree.items()
        if isinstance(tree, dict)
        else enumerate(tree)
        if isinstance(tree, list)
        else ()
    )
    for key, value in items:
        found += places(value, (*path, key))
    return found


@settings(max_examples=100, deadline=None)
@given(st.data())
def test_a_scene_with_one_value_replaced(data: st.DataObject) -> None:
    tree: Any = copy.deepcopy(data.draw(st.sampled_from(TREES)))
    *path, last = data.draw(st.sampled_from(places(tree)))
    table = tree
    for key in path:
        table = table[key]
    table[last] = data.draw(TREE)
    gives_scene_or_error(scene_from_dict, tree)


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_a_scene_with_one_key_gone(data: st.DataObject) -> None:
    tree: Any = copy.deepcopy(data.draw(st.sampled_from(TREES)))
    *path, last = data.draw(st.sampled_from(places(tree)))
    table = tree
    for key in path:
        table = table[key]
    del table[last]
    gives_scene_or_error(scene_from_dict, tree)


@settings(max_examples=200, deadline=None)
@given(st.dictionaries(st.sampled_from([*TREES[0], "links", "rigid", "bodies"]), TREE))
def test_any_tree(tree: dict[str, object]) -> None:
    gives_scene_or_error(scene_from_dict, {"name": "x", "unit": "m"} | tree)


@settings(max_examples=300, deadline=None)
@given(st.data())
def test_a_driven_scene_with_any_coordinates_couplings_and_drivers(data: st.DataObject) -> None:
    tree: Any = tomllib.loads((ROOT / "scenes" / "gear_train.toml").read_text(encoding="utf-8"))
    names = st.sampled_from([*tree["joints"], *tree["coordinates"], *tree["bodies"], "ground"])
    pair = st.lists(names, min_size=2, max_size=2)
    number = st.sampled_from([0, 1, -2.5, 1e-49])
    vector = st.lists(number, min_size=3, max_size=3)
    formula = number | st.sampled_from(["t", "speed*t", "abs(t)", "1/t", "wheel_angle", "exp(t)^t"])
    keys = {
        **dict.fromkeys(["joint", "body", "coordinate"], names),
        **dict.fromkeys(["bodies", "joints", "coordinates"], pair),
        **dict.fromkeys(["ratio", "radius", "pitch", "near"], number),
        **dict.fromkeys(["along", "point", "at", "axis"], vector),
        **dict.fromkeys(["points", "axes", "zero"], st.lists(vector, min_size=2, max_size=2)),
        "factors": st.lists(number, min_size=2, max_size=2),
        "of": st.sampled_from(["angle", "displacement"]),
        "hold": st.booleans(),
        **dict.fromkeys(["value", "stiffness", "damping", "moment", "force"], formula),
        "path": st.lists(formula, min_size=3, max_size=3),
        "type": st.sampled_from(["gear", "rack", "linear", "screw", "cv", "hinge", "cylindrical"]),
    }
    tree["forces"] = {"spring": {"type": "friction", "joint": "wheel_axle", "damping": 2}}
    for table, known in ALLOWED.items():
        name = data.draw(st.sampled_from([*tree[table], "another"]))
        chosen = data.draw(st.lists(st.sampled_from(known), max_size=4, unique=True))
        changed = {key: data.draw(keys[key]) for key in chosen}
        tree[table][name] = {**tree[table].get(name, {}), **changed}
    if data.draw(st.booleans()):
        tree["forces"]["spring"]["type"] = data.draw(st.sampled_from(FORCES))
    gives_scene_or_error(scene_from_dict, tree)


FORCES = ["along", "rotational_spring_damper", "bushing", "torque", "spring_damper"]

ALLOWED = {
    "joints": [
        "type",
        "bodies",
        "joints",
        "ratio",
        "radius",
        "pitch",
        "coordinates",
        "factors",
        "at",
        "axis",
        "points",
        "axes",
        "zero",
    ],
    "coordinates": ["joint", "of", "bodies", "points", "body", "point", "along", "near", "hold"],
    "drivers": ["coordinate", "joint", "of", "value", "body", "point", "path"],
    "forces": ["joint", "coordinate", "of", "stiffness", "damping", "moment", "force", "bodies"],
}
"""Keys of the tables of a driven scene."""


@settings(max_examples=200, deadline=None)
@given(
    st.text()
    | st.sampled_from(TEXTS).flatmap(
        lambda text: st.integers(0, len(text)).map(lambda end: text[:end])
    )
)
def test_any_text(text: str) -> None:
    gives_scene_or_error(scene_from_toml, text)


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_a_scene_file_with_one_part_overwritten(data: st.DataObject) -> None:
    text = data.draw(st.sampled_from(TEXTS))
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(start + 6, len(text))))
    patch = data.draw(
        st.text(max_size=6) | st.sampled_from(["nan", "1e400", "''", "[[", "=", "\0"])
    )
    gives_scene_or_error(scene_from_toml, text[:start] + patch + text[end:])


@settings(max_examples=100, deadline=None)
@given(data=st.binary(max_size=200))
def test_any_bytes(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "any.toml"
    path.write_bytes(data)
    gives_scene_or_error(read_scene, path)


coordinates = st.floats(-100, 100)


@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.tuples(coordinates, coordinates, st.booleans()), min_size=2, max_size=6),
    st.sets(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=1, max_size=9),
    st.lists(st.integers(0, 8), max_size=3),
)
@example(  # a triangle whose sides stand, without a crank
    [(2.0, 0.0, True), (0.0, 1.0, True), (0.0, 0.0, True), (1.0, 0.0, False), (0.0, 0.0, True)],
    {(2, 3), (0, 3), (1, 4)},
    [],
)
def test_any_linkage(
    nodes: list[tuple[float, float, bool]], pairs: set[tuple[int, int]], driven: list[int]
) -> None:
    builder = SceneBuilder("random_linkage", unit="m")
    for number, (x, y, fixed) in enumerate(nodes):
        builder.node(f"n{number}", at=(x, y), fixed=fixed)
    links = sorted(pairs)
    for number, (first, second) in enumerate(links):
        builder.link(f"l{number}", f"n{first}", f"n{second}")
    for number, link in enumerate(driven):
        about = f"n{links[link % len(links)][0]}"
        builder.input(f"i{number}", link=f"l{link % len(links)}", about=about)
    gives_scene_or_error(lambda made: made.build(), builder)
