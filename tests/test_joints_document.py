"""docs/joints.md says of each joint what the code does, and its pictures show the freedoms left."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from kousoku.model.elements.joints import COUPLINGS, JOINTS, NAMES
from kousoku.model.lowering.system import system_of
from kousoku.model.mechanics.constraints import COMBINATION, CONSTRAINTS
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import scene_from_toml

matplotlib = pytest.importorskip("matplotlib")

from kousoku.view.coupling_shapes import COUPLING_PICTURES  # noqa: E402
from kousoku.view.joint_plots import draw_joint  # noqa: E402
from kousoku.view.joint_shapes import JOINT_PICTURES, BoxShape, CylinderShape  # noqa: E402
from kousoku.view.plots import to_svg  # noqa: E402

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kousoku.model.mechanics.multibody import Instance, RelativeCoordinate, System
    from kousoku.view.joint_shapes import JointFreedom

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "docs" / "joints.md").read_text(encoding="utf-8")
SECTIONS = dict(re.findall(r"^## (\w+)\n(.*?)(?=^## |\Z)", TEXT, re.M | re.S))
BALL: dict[str, Any] = {"mass": 1.0, "inertia": {"xx": 1.0, "yy": 1.0, "zz": 1.0}}
HEAD = """
name = "two_bodies"
unit = "m"
[bodies.i]
position = [0, 0, 0]
mass = 1
[bodies.j]
position = [1, 0, 0]
mass = 1
"""


def two_bodies(joint: str) -> System:
    """Two bodies at the origin with a joint as it is drawn."""
    kind, shape = JOINTS[joint], JOINT_PICTURES[joint]
    keys: dict[str, Any] = {}
    if kind.has_point:
        keys["points"] = (shape.points[0], shape.points[-1])
    if kind.axes:
        keys["axes"] = (shape.axes[0][1], shape.axes[-1][1])
    keys |= {key: getattr(shape.freedoms[0], key) for key in kind.keys}
    builder = SceneBuilder("two", unit="m")
    for body in "ij":
        builder.body(body, position=(0, 0, 0), **BALL)
    return system_of(builder.joint("k", type=joint, bodies=("i", "j"), **keys).build())


def rows_of(joint: str) -> NDArray[np.float64]:
    """Columns of body j of the Jacobian of a joint."""
    system = two_bodies(joint)
    rows = []
    for instance in system.constraints:
        if instance.kind == COMBINATION:
            parts = [evaluated(system.coordinates[term.coordinate]) for term in instance.terms]
            factors = [term.factor for term in instance.terms]
            C, C_q = (
                sum(f * part[k] for f, part in zip(factors, parts, strict=True)) for k in (0, 1)
            )
            C = C + instance.offset
        else:
            C, C_q = evaluated(instance)
        np.testing.assert_allclose(C, 0.0, atol=1e-15)
        rows.append(np.reshape(C_q, (-1, 12))[:, 6:])
    return np.concatenate(rows)


def evaluated(instance: Instance | RelativeCoordinate) -> tuple[Any, Any]:
    """Value and Jacobian of an instance or a coordinate, both bodies at the origin."""
    state = {"r_i": np.zeros(3), "p_i": np.eye(4)[0], "r_j": np.zeros(3), "p_j": np.eye(4)[0]}
    module = importlib.import_module(f"kousoku.generated.kinds.{instance.kind}")
    given = state | {name: np.array(value) for name, value in instance.constants}
    given["length"] = given["length"][0] if "length" in given else None
    wanted = [quantity.name for quantity in module.constraint.manifest.inputs]
    C, C_q = module.constraint(*(given[name] for name in wanted))
    return C, C_q


def motion_of(freedom: JointFreedom) -> NDArray[np.float64]:
    """Velocity and angular velocity of body j, whose origin is the origin."""
    direction, at = np.array(freedom.direction), np.array(freedom.at)
    if freedom.kind == "shift":
        return np.concatenate([direction, np.zeros(3)])
    along = freedom.pitch / (2 * np.pi) * direction
    return np.concatenate([np.cross(at, direction) + along, direction])


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("joint", JOINTS)
def test_the_arrows_of_a_picture_are_the_freedoms_that_the_joint_leaves(joint: str) -> None:
    rows = rows_of(joint)
    assert np.linalg.matrix_rank(rows) == JOINTS[joint].rows
    motions = np.array([motion_of(freedom) for freedom in JOINT_PICTURES[joint].freedoms]).reshape(
        -1, 6
    )
    assert np.linalg.matrix_rank(motions) == len(motions) if len(motions) else True
    assert len(motions) == 6 - JOINTS[joint].rows
    np.testing.assert_allclose(rows @ motions.T, 0.0, atol=1e-14)


def counted(pairs: list[tuple[int, str]]) -> str:
    return ", ".join(f"{n} {word}{'s' * (n > 1)}" for n, word in pairs if n) or "none"


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("joint", JOINTS)
def test_the_table_says_what_the_code_does(joint: str) -> None:
    entry, rows = JOINTS[joint], rows_of(joint)
    drawn: list[str] = [freedom.kind for freedom in JOINT_PICTURES[joint].freedoms]
    words = {"shift": "displacement", "turn": "turn", "screw": "screw"}
    freedoms = counted([(drawn.count(kind), word) for kind, word in words.items()])
    forces = int(np.linalg.matrix_rank(rows[:, :3]))
    carries = counted([(forces, "force"), (entry.rows - forces, "torque")])
    aliases = ", ".join(f"`{alias}`" for alias in entry.aliases)
    kinds = ", ".join(part.kind for part in entry.parts)
    cells = (f"[`{joint}`](#{joint})", aliases, kinds, str(entry.rows), freedoms, carries)
    assert "| " + " | ".join(cells).replace("|  |", "| |") + " |" in TEXT


@pytest.mark.parametrize("joint", JOINTS)
def test_each_joint_has_a_section_with_its_picture_its_names_and_a_scene(joint: str) -> None:
    section, entry = SECTIONS[joint], JOINTS[joint]
    assert f"](joints/{joint}.svg)" in section
    assert entry.title in section.replace(section[:1], section[:1].lower()).lower()
    assert re.search(rf"^- {entry.rows} rows?:", section, re.M)
    assert all(f"`{alias}`" in section for alias in entry.aliases)
    (snippet,) = re.findall(r"```toml\n(.*?)```", section, re.S)
    system = system_of(scene_from_toml(HEAD + snippet))
    assert {instance.joint for instance in system.constraints} == {joint}
    assert NAMES[joint] == joint


@pytest.mark.parametrize("kind", CONSTRAINTS)
def test_the_table_of_kinds_counts_their_rows(kind: str) -> None:
    assert re.search(rf"^\| `{kind}` \| {CONSTRAINTS[kind].rows} \|", TEXT, re.M)


@pytest.mark.parametrize("name", COUPLINGS)
def test_couplings_are_in_their_table(name: str) -> None:
    aliases = ", ".join(f"`{alias}`" for alias in COUPLINGS[name].aliases)
    assert f"| `{name}` | {aliases} | linear_combination | {COUPLINGS[name].rows} |" in TEXT


def test_the_document_shows_the_joints_of_the_code_and_no_others() -> None:
    pictures = {path.stem for path in (ROOT / "docs" / "joints").iterdir()}
    assert set(JOINTS) == set(JOINT_PICTURES)
    assert pictures == set(JOINTS) | set(COUPLING_PICTURES)


def test_couplings_have_pictures_in_which_wheels_touch() -> None:
    assert set(COUPLING_PICTURES) == set(COUPLINGS)
    assert all(f"](joints/{name}.svg)" in TEXT for name in COUPLING_PICTURES)
    small, large = sorted(
        COUPLING_PICTURES["gear"].solids, key=lambda wheel: getattr(wheel, "radius", 0.0)
    )
    assert isinstance(small, CylinderShape) and isinstance(large, CylinderShape)
    assert large.start[0] - small.start[0] == pytest.approx(small.radius + large.radius)
    ratio = re.search(r'type = "gear"\n.*\nratio = (.*)\n', TEXT)
    assert ratio is not None and float(ratio[1]) == -small.radius / large.radius
    rack, pinion = COUPLING_PICTURES["rack_and_pinion"].solids
    assert isinstance(rack, BoxShape) and isinstance(pinion, CylinderShape)
    assert pinion.start[2] - pinion.radius == pytest.approx(rack.high[2])


def test_the_rope_of_the_linear_coupling_keeps_its_length() -> None:
    """Its strands touch the pulleys; the arrows, up to which both go, show the factors."""
    factors = re.search(r'type = "linear"\n.*\nfactors = \[(.*), (.*)\]\n', TEXT)
    assert factors is not None
    solids = [one for one in COUPLING_PICTURES["linear"].solids if isinstance(one, CylinderShape)]
    pulleys = [one for one in solids if one.radius > 0.3]
    strands = [one for one in solids if one.radius < 0.05]
    ends = {round(one.start[0] + s * one.radius, 9) for one in pulleys for s in (-1, 1)}
    assert sorted(one.start[0] for one in strands) == pytest.approx(sorted(ends))
    of_i, of_j = (freedom.size for freedom in COUPLING_PICTURES["linear"].freedoms)
    strands_of_j = sum(one.start[2] == pulleys[1].start[2] for one in strands)
    assert [1, strands_of_j] == [float(factor) for factor in factors.groups()] == [1, of_i / of_j]


@pytest.mark.parametrize("joint", [*JOINTS, *COUPLING_PICTURES])
def test_the_committed_picture_is_the_one_that_is_drawn(joint: str) -> None:
    committed = (ROOT / "docs" / "joints" / f"{joint}.svg").read_text(encoding="utf-8")
    drawn = to_svg(draw_joint((JOINT_PICTURES | COUPLING_PICTURES)[joint]))
    version = f"Matplotlib v{matplotlib.__version__},"
    if version in committed:
        assert drawn == committed
    else:  # another version writes the same shapes with other bytes
        assert drawn.count("<path") == committed.count("<path")
