"""Kinds of one's own as types of joints: they move as shipped ones do, and are checked as these."""

from __future__ import annotations

import os
import pickle
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from sympy.matrices.immutable import ImmutableDenseMatrix

import kousoku as ks
from kousoku import loading
from kousoku.codegen import kernel_json
from kousoku.codegen.dynamics.generate import compose_scene
from kousoku.codegen.dynamics.operations.mechanics import frozen
from kousoku.codegen.dynamics.own_kinds import own_kind_of
from kousoku.model.errors import AssemblyError, DerivationError, LoadError, SceneError
from kousoku.model.files.quantity import Quantity
from kousoku.model.operations.arithmetic import EXACT
from kousoku.model.operations.interpret import evaluate
from kousoku.model.reading.builder import SceneBuilder
from kousoku.model.reading.read import scene_from_toml
from kousoku.model.records.own_kind import is_own, kind_name
from kousoku.own_kinds import own_kinds
from kousoku.runtime.dynamics import DynamicsSolver
from kousoku.symbolic.derivation import Derivation, DerivedOutput, Function
from kousoku.symbolic.matrices import elements, symbol

if TYPE_CHECKING:
    from pathlib import Path

    from kousoku.model.operations.kernel import Package
    from kousoku.model.records.scene import Scene
    from kousoku.runtime.library import Library

BODY_I, BODY_J = ks.body("i"), ks.body("j")
LENGTH = ks.number("length", "m")


@pytest.fixture(scope="module")
def slant() -> Derivation:
    """Two vectors at an angle."""
    return ks.derive("slant", C=BODY_I.axis().dot(BODY_J.axis()) - ks.number("cos_theta"))


@pytest.fixture(scope="module")
def restated() -> list[Derivation]:
    """Restate ``point``, ``distance`` and ``n1``."""
    d = (BODY_J.point() - BODY_I.point()).named("d")
    return [
        ks.derive("touch", C=BODY_J.point() - BODY_I.point()),
        ks.derive("stick", C=(d.dot(d) - LENGTH**2) / (2 * LENGTH)),
        ks.derive("square", C=BODY_I.axis().dot(BODY_J.axis())),
    ]


@pytest.fixture(scope="module")
def written(slant: Derivation, tmp_path_factory: pytest.TempPathFactory) -> Library:
    """Kernels of two vectors at an angle, in a folder."""
    return ks.kernels(slant, tmp_path_factory.mktemp("kinds") / "slant", target="numpy")


TOP = """
name = "top"
unit = "m"
gravity = [0, 0, -9.81]
outputs = ["positions", "velocities", "accelerations", "reactions", "energies"]
[bodies.top]
position = [0, 0, 0]
orientation = { axis = [1, 0, 0], angle = 0.6 }
mass = 1
center = [0, 0, 0.2]
inertia = { xx = 0.01, yy = 0.01, zz = 0.004 }
angular_velocity_b = [0, 0, 30]
[joints.foot]
type = "spherical"
bodies = ["ground", "top"]
at = [0, 0, 0]
[joints.tilt]
type = "slant"
bodies = ["ground", "top"]
"""
TILT = """a_i_b = [0, 0, 1]
a_j_b = [0, 0, 2]
cos_theta = 0.8253356149096783
"""

#: Two bodies whose own frames are neither at their centres of mass nor along principal axes.
BODIES = """
name = "pair"
unit = "cm"
gravity = [0, 0, -981]
outputs = ["positions", "velocities", "accelerations", "reactions", "energies"]
[bodies.one]
position = [10, 2, 3]
orientation = { axis = [1, 2, 1], angle = 0.6 }
mass = 1
center = [1, -2, 4]
inertia = { xx = 100, yy = 120, zz = 80, xy = 5, yz = -3, zx = 7 }
[bodies.two]
position = [30, 2, 3]
orientation = { axis = [0, 2, -1], angle = 0.3 }
mass = 2
center = [-1, 3, 4]
inertia = { xx = 100, yy = 120, zz = 80, xy = 5, yz = -3, zx = 7 }
"""
SHIPPED = (
    BODIES
    + """
[joints.foot]
type = "spherical"
bodies = ["ground", "one"]
points = [[10, 2, 3], [0, 0, 0]]
[joints.bar]
type = "rod"
bodies = ["one", "two"]
points = [[3, 1, -2], [-4, 0, 1]]
length = 14
[joints.level]
type = "perpendicular_axes"
bodies = ["one", "two"]
axes = [[1, 0, 0.2], [0, 2, 0]]
"""
)
OWN = (
    BODIES
    + """
[joints.foot]
type = "touch"
bodies = ["ground", "one"]
s_i_b = [10, 2, 3]
s_j_b = [0, 0, 0]
[joints.bar]
type = "stick"
bodies = ["one", "two"]
s_i_b = [3, 1, -2]
s_j_b = [-4, 0, 1]
length = 14
[joints.level]
type = "square"
bodies = ["one", "two"]
a_i_b = [1, 0, 0.2]
a_j_b = [0, 2, 0]
"""
)


def read(text: str, *kinds: Any) -> Scene:
    return scene_from_toml(text, kinds=own_kinds(kinds))


def solver_of(mechanism: ks.Mechanism) -> DynamicsSolver:
    assert isinstance(mechanism.solver, DynamicsSolver)
    return mechanism.solver


def told(text: Any, *kinds: Any, error: type[Exception] = SceneError) -> str:
    """Message of what is wrong with a scene."""
    with pytest.raises(error) as caught:
        loading.generated(read(text, *kinds))
    return str(caught.value)


def steps_of(text: str, kinds: list[Any], target: Any) -> ks.Result:
    end, samples = (0.4, 101) if target == "c" else (0.02, 5)
    loaded = ks.load(text, kinds=kinds, target=target)
    return loaded.simulate(end, samples=samples, tolerance=1e-11)


def require_the_same_motion(kinds: list[Any], target: Any) -> None:
    mine, theirs = (steps_of(text, kinds, target) for text in (OWN, SHIPPED))
    assert mine.columns().keys() == theirs.columns().keys()
    for name in mine.columns():
        size = max(np.abs(theirs[name]).max(), 1.0)
        assert np.allclose(mine[name], theirs[name], rtol=0, atol=2e-9 * size), name
    total = mine["energy.kinetic"] + mine["energy.potential"]
    assert np.ptp(total) <= 1e-9 * np.abs(total).max()


@pytest.mark.usefixtures("compiler")
def test_kinds_that_restate_shipped_ones_move_as_these_do_in_c(restated: list[Derivation]) -> None:
    require_the_same_motion(restated, "c")


@pytest.mark.usefixtures("numpy_solver")
def test_kinds_that_restate_shipped_ones_move_as_these_do_in_numpy(
    restated: list[Derivation],
) -> None:
    require_the_same_motion(restated, "numpy")


@pytest.mark.usefixtures("compiler", "numpy_solver")
def test_a_solver_with_kinds_of_ones_own_is_verified(restated: list[Derivation]) -> None:
    # It knows the origin and the axes of the frame of body i, which are no principal ones.
    seen = BODY_I.A.T @ (BODY_J.point("t") - BODY_I.r)
    level = ks.derive("level", C=seen[0] - ks.number("h", "m"))
    text = OWN.replace("[joints.level]", '[joints.seen]\ntype = "level"\nbodies = ["one", "two"]\n')
    text = text.replace('type = "square"\nbodies = ["one", "two"]\n', "")
    text = text.replace("a_i_b = [1, 0, 0.2]\na_j_b = [0, 2, 0]", 't_j_b = [1, 2, 3]\nh = "2*k"')
    report = ks.verify(ks.load(f"{text}[parameters]\nk = 10\n", kinds=[*restated, level]))
    report.check()
    assert "newton_euler" in {row.kernel for row in report.rows}  # each body for itself


def test_what_follows_of_a_kind_is_checked_by_its_value_alone(slant: Derivation) -> None:
    (found,) = (frozen_own(kind) for kind in [slant])
    constraint, rates, *rest = found.kernels
    nu, _ = rates.results
    wrong = replace(found, kernels=(constraint, replace(rates, results=(nu, nu)), *rest))
    text = (TOP + TILT).replace("[0, 0, 30]", "[1, 2, 3]")
    scene = scene_from_toml(text, kinds={"slant": own_kind_of(wrong)})
    problems = ks.verify(ks.load(scene, target="numpy"), target="numpy").problems
    assert any(one.startswith("newton_euler: ") for one in problems)
    assert ks.verify(ks.load(text, kinds=[slant], target="numpy"), target="numpy").ok


def frozen_own(kind: Derivation) -> Package:
    """Kernels of a kind as they were derived."""
    return kernel_json.load_frozen(own_kinds([kind])[kind.name].kernels)


def test_a_kind_that_is_stated_by_hand_may_hold_quotients_and_angles() -> None:
    kind = own_kind_of(replace(kernel_json.load_frozen("angle"), name="turn"))
    text = TOP.replace("slant", "turn").replace("[0, 0, 30]", "[1, 2, 3]")
    text += "a_i_b = [1, 0, 0]\nb_i_b = [0, 1, 0]\na_j_b = [1, 0.1, 0]\n"
    scene = scene_from_toml(text, kinds={"turn": kind})
    ks.verify(ks.load(scene, target="numpy"), target="numpy").check()


WRONG = {
    "no kinds": (TOP + TILT, "line 18: joints.tilt.type: unknown joint 'slant'; known here"),
    "missing": (TOP, "joints.tilt.a_i_b: is missing; a slant joint wants a list of 3 numbers"),
    "misspelled": (
        TOP + TILT.replace("cos_theta", "cos_tetha"),
        "joints.tilt.cos_tetha: unknown key; did you mean 'cos_theta'?",
    ),
    "of other joints": (
        TOP + TILT + "at = [0, 0, 0]",
        "joints.tilt.at: a slant joint has none; it has bodies, a_i_b, a_j_b, cos_theta",
    ),
    "no direction": (TOP + TILT.replace("[0, 0, 2]", "[0, 0, 0]"), "a_j_b: has zero length"),
    "no vector": (TOP + TILT.replace("[0, 0, 2]", "2"), "a_j_b: the number 2 stands where a list"),
    "no parameter": (
        TOP + "a_i_b = [0, 0, 1]\na_j_b = [0, 0, 1]\ncos_theta = 'k'",
        "joints.tilt.cos_theta: column 1: unknown name 'k'",
    ),
    "no coordinate": (
        TOP + TILT + "[coordinates]\nphi = { joint = 'tilt' }",
        "coordinates.phi.joint: tilt is a slant joint, which leaves free no angle",
    ),
    "nothing holds it": (
        TOP + TILT.replace("0.8253356149096783", "1"),
        "joints.tilt: C of slant has no Jacobian of its own where the scene starts",
    ),
    "a point": (
        TOP.replace("orientation = { axis = [1, 0, 0], angle = 0.6 }", "point = true")
        .replace("center = [0, 0, 0.2]\ninertia = { xx = 0.01, yy = 0.01, zz = 0.004 }", "")
        .replace("angular_velocity_b = [0, 0, 30]", "")
        + TILT,
        "joints.tilt.bodies[1]: top is a point, which has no orientation that a slant joint",
    ),
}


@pytest.mark.parametrize("sort", WRONG)
def test_what_is_wrong_in_a_joint_is_said(slant: Derivation, sort: str) -> None:
    text, message = WRONG[sort]
    assert message in told(text, *([] if sort == "no kinds" else [slant]))


def test_a_type_that_is_unknown_comes_with_a_hint() -> None:
    assert told(TOP + TILT).endswith(
        "; a kind of your own comes with kinds=[...], see docs/own_kind.md"
    )
    assert told((TOP + TILT).replace("slant", "hing")).endswith(
        "did you mean 'hinge'? A kind of your own comes with kinds=[...], see docs/own_kind.md"
    )


def test_an_angle_that_is_none_cannot_be_assembled(slant: Derivation) -> None:
    wrong = TOP + TILT.replace("0.8253356149096783", "1.5")
    assert "these stay open: joints.tilt by 0.5 rad" in told(wrong, slant, error=AssemblyError)


def test_what_is_no_constraint_of_two_bodies_is_refused(slant: Derivation, tmp_path: Path) -> None:
    x = Quantity("x", (), "m", "a length")
    y = DerivedOutput(
        Quantity("y", (), "m", "that"), symbol(x), ImmutableDenseMatrix([elements(x)[0]])
    )
    function = Function("kernel", "title", "y = x", "this test", (x,), (y,))
    length = Derivation("own", "own", "title", "this test", (), (function,))
    apart = ks.derive("revolute", C=BODY_J.r - BODY_I.r)
    many = ks.derive("many", C=[BODY_J.r - BODY_I.r, BODY_J.r + BODY_I.r, BODY_J.r[0]])
    other = ks.derive("slant", C=BODY_I.axis().dot(BODY_J.axis()))
    refused: list[tuple[Any, str]] = [
        ([length], "own cannot be the type of a joint: it has no kernel constraint that gives C"),
        ([many], "C has shape (7,), and a joint has 1 to 6 rows"),
        ([apart], "revolute cannot be the type of a joint: 'revolute' is a type of joints that"),
        ([ks.derive("n1")], "'n1' is taken by a kind that kousoku ships"),
        ([slant, other], "two kinds are called slant"),
        (slant, "is no list; wanted one, such as kinds=[mine]"),
        ([3], "3 is no kind; wanted what kousoku.derive or kousoku.kernels gave"),
    ]
    for kinds, message in refused:
        with pytest.raises(DerivationError, match=re.escape(message)):
            ks.load(TOP + TILT, kinds=kinds)
    with pytest.raises(LoadError, match="is not a generated package"):
        ks.load(TOP + TILT, kinds=[tmp_path / "nothing"])


def test_a_kind_that_is_derived_again_with_a_change_is_another(slant: Derivation) -> None:
    below = ks.derive("slant", C=BODY_I.axis().dot(BODY_J.axis()) + ks.number("cos_theta"))
    again = ks.derive("slant", C=BODY_I.axis().dot(BODY_J.axis()) - ks.number("cos_theta"))
    first, second, third = (
        ks.load(TOP + TILT, kinds=[kind], target="numpy") for kind in (slant, below, again)
    )
    assert first.text == third.text != second.text
    # The axis of the top is cos 0.6 above, and as much below the ground.
    turns = [float(solver_of(one).q[3]) for one in (first, second, third)]
    assert np.allclose(np.abs(turns), np.cos([0.3, (np.pi - 0.6) / 2, 0.3]))


ALONE = """
import sys
sys.modules["sympy"] = None
import kousoku as ks
mechanism = ks.load({text!r}, kinds=[{folder!r}], target="numpy")
print(mechanism, ks.explain({text!r}, kinds=[{folder!r}]))
"""


def test_the_folder_of_a_kind_is_enough(written: Library, tmp_path: Path) -> None:
    folder = shutil.copytree(written.folder, tmp_path / "slant")
    program = ALONE.format(text=TOP + TILT, folder=str(folder))
    environment = os.environ | {"KOUSOKU_CACHE": str(tmp_path / "cache")}
    found = subprocess.run(
        [sys.executable, "-c", program],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "2 degrees of freedom" in found.stdout, found.stderr
    (folder / kernel_json.GRAPH_FILE).unlink()
    with pytest.raises(LoadError, match=kernel_json.GRAPH_FILE):
        ks.load(TOP + TILT, kinds=[folder], target="numpy")


def test_kernels_are_kinds_too(slant: Derivation, written: Library) -> None:
    by_kernels = ks.load(TOP + TILT, kinds=[written], target="numpy")
    assert by_kernels.text == ks.load(TOP + TILT, kinds=[slant], target="numpy").text


def test_a_scene_goes_on_without_its_kinds(
    slant: Derivation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KOUSOKU_CACHE", str(tmp_path))
    first = ks.load(TOP + TILT, kinds=[slant], target="numpy")
    twin = pickle.loads(pickle.dumps(first))
    assert twin.scene.kinds == first.scene.kinds
    assert ks.load(twin.text, target="numpy").text == first.text
    monkeypatch.setattr(kernel_json, "_OWN", {})  # as in another process
    kernel_json.load_frozen.cache_clear()
    frozen.cache_clear()
    assert "2 degrees of freedom" in str(ks.explain(twin))
    kernel_json.load_frozen.cache_clear()
    frozen.cache_clear()
    monkeypatch.setattr(kernel_json, "_OWN", {})
    monkeypatch.setenv("KOUSOKU_CACHE", str(tmp_path / "empty"))
    with pytest.raises(LoadError, match=r"load the scene with them: kousoku.load\(scene, kinds=\["):
        ks.explain(twin)


def test_what_is_built_takes_kinds_when_it_is_loaded(slant: Derivation) -> None:
    keys: dict[str, Any] = {"a_i_b": [0, 0, 1], "a_j_b": [0, 0, 2], "cos_theta": 0.8253356149096783}
    built = (
        SceneBuilder("top", unit="m")
        .body(
            "top",
            position=(0, 0, 0),
            orientation={"axis": (1, 0, 0), "angle": 0.6},
            mass=1,
            inertia={"xx": 1, "yy": 1, "zz": 1},
        )
        .joint("foot", type="spherical", bodies=("ground", "top"), at=(0, 0, 0))
        .joint("tilt", type="slant", bodies=("ground", "top"), **keys)
    )
    with pytest.raises(SceneError, match="unknown joint 'slant'"):
        built.build()
    loaded = ks.load(built, kinds=[slant], outputs=["velocities"], target="numpy")
    assert loaded.scene.joints["tilt"].inputs == keys | {"a_i_b": (0, 0, 1), "a_j_b": (0, 0, 2)}
    again = ks.load(loaded.scene, kinds=[slant], outputs=["velocities"], target="numpy")
    assert again.text == loaded.text
    assert ks.load(built.build(kinds=loaded.scene.kinds), target="numpy").scene == loaded.scene


def two_bodies(x: float) -> str:
    """Two free bodies, the second at x, and the head of a joint of them."""
    bodies = "".join(
        f"[bodies.{name}]\nposition = [{x}, 0, 0]\nmass = 1\n"
        "inertia = { xx = 1, yy = 1, zz = 1 }\n"
        for name, x in (("a", 0.0), ("b", x))
    )
    return f'name = "two"\nunit = "m"\n{bodies}[joints.bar]\nbodies = ["a", "b"]\n'


def test_no_momentum_is_said_to_be_kept(restated: list[Derivation]) -> None:
    head = two_bodies(2.0)
    mine = f'{head}type = "stick"\ns_i_b = [0, 0, 0]\ns_j_b = [0, 0, 0]\nlength = 2\n'
    theirs = f'{head}type = "rod"\npoints = [[0, 0, 0], [0, 0, 0]]\nlength = 2\n'
    own, shipped = (compose_scene(read(text, *restated), ()).program for text in (mine, theirs))
    assert shipped.conserved and not own.conserved
    assert shipped.is_planar and own.is_planar


def test_a_plane_is_taken_only_where_nothing_ever_leads_out_of_it() -> None:
    d = BODY_J.r - BODY_I.r
    chance = ks.derive("chance", C=d[1] + d[0] * d[2] / ks.number("h", "m"))
    plain = ks.derive("plain", C=d[1] + d[0] * d[0] / ks.number("h", "m"))
    for kind, is_planar in ((chance, False), (plain, True)):
        # ∂C/∂z is zero where both bodies start, and of the first not where they go.
        text = f'{two_bodies(0.0)}type = "{kind.name}"\nh = 1\n'
        assert compose_scene(read(text, kind), ()).program.is_planar is is_planar


def test_rows_that_repeat_others_are_left_out(slant: Derivation) -> None:
    again = f'[joints.again]\ntype = "slant"\nbodies = ["ground", "top"]\n{TILT}'
    twice = ks.load(TOP + TILT + again, kinds=[slant], target="numpy")
    assert [name for name, _ in solver_of(twice).left_out] == ["tilt"]
    lines = str(ks.explain(twice))
    assert "tilt: row 0 of slant" in lines and "of one's own: slant" in lines
    parallel = ks.derive("aligned", C=BODY_I.axis().cross(BODY_J.axis()))
    text = TOP + "a_i_b = [1, 2, 3]\na_j_b = [0, 0, 1]\n"
    aligned = ks.load(text.replace("slant", "aligned"), kinds=[parallel], target="numpy")
    assert len(solver_of(aligned).left_out) == 1


SWEEP = """
name = "sweep"
unit = "m"
gravity = [0, 0, -9.81]
outputs = ["velocities", "accelerations", "reactions"]
[bodies.arm]
position = [0, 0, 0]
mass = 1
center = [0.1, 0.5, 0]
inertia = { xx = 0.1, yy = 0.05, zz = 0.12, xy = 0.01 }
angular_velocity = [6, 0, 0]
[bodies.wheel]
position = [0, 1, 0]
mass = 1
center = [0, 0.1, 0]
inertia = { xx = 0.02, yy = 0.03, zz = 0.02 }
velocity = [0, 0, 6]
angular_velocity = [6, 0, 0]
[joints]
shaft = { type = "revolute", bodies = ["ground", "arm"], at = [0, 0, 0], axis = [1, 0, 0] }
pin = { type = "spherical", bodies = ["arm", "wheel"], at = [0, 1, 0] }
"""


@pytest.mark.usefixtures("compiler", "numpy_solver")
def test_rows_of_one_joint_that_repeat_each_other_carry_nothing() -> None:
    kind = ks.derive("aligned", C=BODY_I.axis().cross(BODY_J.axis()))
    axes = "[0.3, 0.2, 1]"
    head = 'bodies = ["arm", "wheel"]'
    mine = f'{SWEEP}par = {{ type = "aligned", {head}, a_i_b = {axes}, a_j_b = {axes} }}\n'
    theirs = f"{{ type = 'parallel_axes', {head}, axes = [{axes}, {axes}] }}\n"
    both = f"{mine}twin = {theirs}"
    # The two rows that are kept at the start lose their rank on the way, and others take over.
    own, shipped, shared = (
        ks.load(text, kinds=[kind]).simulate(1.5, samples=31, tolerance=1e-11)
        for text in (mine, f"{SWEEP}par = {theirs}", both)
    )
    assert "factorisations of all rows" in str(own.ledger)
    for name in shipped.columns():
        assert np.allclose(own[name], shipped[name], rtol=0, atol=1e-8), name
    assert not any("not unique" in note for note in own.notes)
    assert any("not unique" in note and "joints.twin" in note for note in shared.notes)
    for name in ("par", "twin"):
        torque = 2 * shared.joint(name).torque
        assert np.allclose(torque, shipped.joint("par").torque, rtol=0, atol=1e-8)
    for text in (mine, both):
        ks.verify(ks.load(text, kinds=[kind])).check()


def test_they_move_as_drivers_say(restated: list[Derivation]) -> None:
    places = {"crank": 0, "rod": 1, "slider": 3}
    bodies = "".join(f"[bodies.{name}]\nposition = [{x}, 0, 0]\n" for name, x in places.items())
    text = f"""
name = "driven"
unit = "m"
{bodies}
[joints]
a = {{ type = "hinge", bodies = ["ground", "crank"], at = [0, 0, 0], axis = [0, 0, 1] }}
b = {{ type = "touch", bodies = ["crank", "rod"], s_i_b = [1, 0, 0], s_j_b = [0, 0, 0] }}
c = {{ type = "hinge", bodies = ["rod", "slider"], at = [3, 0, 0], axis = [0, 0, 1] }}
d = {{ type = "slider", bodies = ["ground", "slider"], at = [3, 0, 0], axis = [1, 0, 0] }}
[drivers.motor]
joint = "a"
value = "0.3 + t"
"""
    made = compose_scene(read(text, *restated), ())
    assert (made.degrees, made.program.is_planar) == (0, True)
    slider = made.system.bodies[2].r[0]
    assert slider == pytest.approx(np.cos(0.3) + (4 - np.sin(0.3) ** 2) ** 0.5, rel=1e-12)
    twin = (
        'twin = { type = "touch", bodies = ["crank", "rod"], s_i_b = [1, 0, 0], s_j_b = [0, 0, 0] }'
    )
    twice = text.replace("[drivers", f"{twin}\n[drivers", 1)
    rows = compose_scene(read(twice, *restated), ()).program.left_out
    assert len(rows) == 2  # in the plane, from both of the same kind


def test_bodies_are_not_joined_through_them_nor_put_onto_them(restated: list[Derivation]) -> None:
    system = compose_scene(read(OWN, *restated), ()).system
    own = [one for one in system.constraints if is_own(one.kind)]
    assert [kind_name(one.kind) for one in own] == ["touch", "stick", "square"]
    assert [body.name for body in system.bodies] == ["one", "two"]
    assert not compose_scene(read(OWN, *restated), ()).program.satisfied


def test_where_a_scene_stands_is_no_matter(restated: list[Derivation]) -> None:
    far = OWN.replace("position = [", "position = [100000")
    far = far.replace("s_i_b = [10, 2, 3]", "s_i_b = [10000010, 2, 3]")
    near, there = (compose_scene(read(text, *restated), ()) for text in (OWN, far))
    assert near.degrees == there.degrees == 7
    a, b = (found.system.bodies for found in (near, there))
    for one, other in zip(a, b, strict=True):
        assert np.allclose(np.subtract(other.r, one.r), [1e5, 0, 0], atol=1e-9)
        assert np.allclose(one.p, other.p, atol=1e-9)


def test_points_may_be_bodies_of_kinds_that_keep_no_orientation(restated: list[Derivation]) -> None:
    head = """
name = "bob"
unit = "m"
gravity = [0, 0, -9.81]
[bodies.bob]
point = true
position = [1, 0, 0]
velocity = [0, 1, 0]
mass = 1
[joints.bar]
bodies = ["ground", "bob"]
"""
    mine = f'{head}type = "stick"\ns_i_b = [0, 0, 0]\ns_j_b = [0, 0, 0]\nlength = 1\n'
    assert ks.verify(ks.load(mine, kinds=restated, target="numpy"), target="numpy").ok
    wrong = mine.replace("s_j_b = [0, 0, 0]", "s_j_b = [0, 0, 1]")
    assert "joints.bar.s_j_b: bob is a point; wanted [0, 0, 0]" in told(wrong, *restated)


@pytest.mark.usefixtures("compiler")
def test_a_run_is_drawn_kept_and_opened_again(restated: list[Derivation], tmp_path: Path) -> None:
    run = ks.load(OWN, kinds=restated).simulate(0.02, samples=5)
    assert "most at joints." in str(run.ledger)
    page = tmp_path / "pair.html"
    run.animate(page)
    assert page.stat().st_size > 1000
    run.save(tmp_path / "pair.npz")
    again = ks.open_run(tmp_path / "pair.npz")
    assert np.array_equal(again.joint("bar").force, run.joint("bar").force)
    again.animate(page)
    assert ks.load(OWN, kinds=restated)._repr_html_().startswith("<")


def test_frames_are_changed_exactly(restated: list[Derivation]) -> None:
    touch = next(kind for kind in restated if kind.name == "touch")
    raw = next(kernel for kernel in frozen_own(touch).kernels if kernel.name == "constraint")
    seen = frozen(own_kinds([touch])["touch"].kernels, "constraint")
    half = Fraction(1, 2)
    p = [half, half, half, half]
    r, origin, point, ones, zeros, turn, still = (
        [Fraction(x) for x in v]
        for v in (
            *([1, 2, 3], [4, 5, 6], [7, 8, 9], [1, 1, 1], [0, 0, 0]),
            *([0, 0, 0, 1], [1, 0, 0, 0]),
        )
    )
    state = {"r_i": zeros, "p_i": still, "r_j": r, "p_j": p}
    frames = {"origin_i": zeros, "frame_i": still, "origin_j": origin, "frame_j": turn}
    given = {"own:s_i_b": ones, "own:s_j_b": point}
    found = evaluate(seen, {**state, **frames, **given}, EXACT)["C"]
    # The half turn about z takes (7, 8, 9) to (−7, −8, 9), p takes (x, y, z) to (z, x, y).
    place = [1 + 15, 2 - 3, 3 - 3]
    assert [x + 1 for x in found] == place
    at_frame = {"r_j": [r[0] + 6, r[1] + 4, r[2] + 5], "p_j": [-half, half, -half, half]}
    same = {**state, **at_frame, "s_i_b": ones, "s_j_b": point}
    assert evaluate(raw, same, EXACT)["C"] == found
