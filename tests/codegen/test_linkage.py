"""From a scene to its folder: what is composed, and that references find what is composed wrong."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from msgspec import structs

from kousoku.codegen import linkage_emit
from kousoku.codegen.emit import along
from kousoku.codegen.generate import write_tree
from kousoku.codegen.graph import Op
from kousoku.codegen.interpret import FLOAT, evaluate
from kousoku.codegen.kernel_json import load_frozen
from kousoku.codegen.linkage import Program, generate_scene, specialise
from kousoku.codegen.linkage_emit import emit_scene
from kousoku.codegen.linkage_reference import references
from kousoku.codegen.linkage_solution import places
from kousoku.model.assemble import assemble
from kousoku.model.manifest import Manifest
from kousoku.model.read import read_scene, scene_from_dict
from kousoku.runtime.verify import verify

if TYPE_CHECKING:
    from kousoku.codegen.kernel import Kernel

SCENES = Path(__file__).parents[2] / "scenes"
NAMES = ("piston_crank", "lever_crank", "five_bar", "watt_six_bar", "stephenson_six_bar")
#: A slider and two loops; the others are verified for a release.
ALWAYS = ("piston_crank", "watt_six_bar")


def program(name: str) -> Program:
    return specialise(assemble(read_scene(SCENES / f"{name}.toml")), load_frozen("link"))


@cache
def files_of(name: str) -> dict[str, str]:
    return generate_scene(read_scene(SCENES / f"{name}.toml"))


def kernels(name: str) -> dict[str, Kernel]:
    return {kernel.name: kernel for kernel in program(name).package.kernels}


def write(folder: Path, files: dict[str, str]) -> Path:
    write_tree(folder, files)
    return folder


def test_only_the_crank_needs_an_angle() -> None:
    functions = {Op.SIN, Op.COS, Op.ATAN2}
    with_angle = {
        name
        for name, kernel in kernels("lever_crank").items()
        if functions & set(kernel.operations)
    }
    assert with_angle == {"position_1"}


def test_constants_of_the_scene_are_bound() -> None:
    position = kernels("lever_crank")["position_2"]
    values = {float(node.value) for node in position.nodes if node.value is not None}
    assert {60.0, 80.0, 100.0} <= values
    assert [quantity.name for quantity in position.inputs] == ["known", "x"]


@pytest.mark.parametrize("name", NAMES)
def test_matrix_is_the_derivative_of_the_residual(name: str) -> None:
    made = program(name)
    motion = {k: list(map(float, v)) for k, v in places(made.layout)[3].motion.items()}
    for number, block in enumerate(made.layout.blocks):
        kernel = made.package.kernels[3 * number]
        n, step = len(block.unknowns), 1e-6 * made.layout.system.scene.largest_length
        here = {quantity.name: [0.0] * quantity.size for quantity in kernel.inputs}
        for coordinate, (argument, index) in made.layout.places_in(number).items():
            whole, where = made.layout.everywhere[coordinate]
            here[argument][index] = motion[whole][where]
        matrix = np.reshape(evaluate(kernel, here, FLOAT)["D"], (n, n))
        for column in range(n):
            ends = []
            for sign in (1, -1):
                moved = {**here, "x": list(here["x"])}
                moved["x"][column] += sign * step
                ends.append(np.array(evaluate(kernel, moved, FLOAT)["epsilon"]))
            np.testing.assert_allclose(
                matrix[:, column], (ends[0] - ends[1]) / (2 * step), rtol=1e-6, atol=1e-7
            )


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize(
    "name",
    [x if x in ALWAYS else pytest.param(x, marks=pytest.mark.release) for x in NAMES],
)
def test_generated_folders_verify(tmp_path: Path, name: str) -> None:
    scene = read_scene(SCENES / f"{name}.toml")
    report = verify(write(tmp_path / name, generate_scene(scene)))
    assert report.ok, report
    assert max(row.worst for row in report.rows) <= 4


def test_references_find_a_kernel_that_is_composed_wrong(tmp_path: Path) -> None:
    made = program("piston_crank")
    text = references(made.package, made.layout, places(made.layout))
    wrong = list(made.package.kernels)
    for k, kernel in enumerate(wrong):
        if kernel.name == "acceleration_2":
            results = tuple(tuple(node - 1 for node in result) for result in kernel.results)
            wrong[k] = replace(kernel, results=results)
    package = replace(made.package, kernels=tuple(wrong))
    files = emit_scene(package, made.solver, {"reference.json.gz": text})
    report = verify(write(tmp_path / "wrong", files), target="numpy")
    assert not report.ok
    assert {row.kernel for row in report.rows if row.worst > 4} == {"acceleration_2"}


def test_points_of_reference_lie_on_beside_and_off_the_way() -> None:
    made = program("piston_crank")
    data = json.loads(references(made.package, made.layout, places(made.layout)))
    labels = [point["label"] for point in data["kernels"][0]["points"]]
    assert sum(label.endswith("of the way") for label in labels) == 2 * 6
    assert any(label.startswith("near ") for label in labels)
    assert any(label.startswith("away from ") for label in labels)
    assert labels[-1] == "x[0] is nan"


def test_linkage_that_cannot_be_assembled_still_has_references() -> None:
    scene = read_scene(SCENES / "lever_crank.toml")
    links = {**scene.links, "l2": type(scene.links["l2"])(nodes=("O2", "O3"), length=5.0)}
    fields: dict[str, Any] = {name: getattr(scene, name) for name in scene.__struct_fields__}
    broken = type(scene)(**{**fields, "links": links})
    made = specialise(assemble(broken), load_frozen("link"))
    assert places(made.layout) == []
    data = json.loads(references(made.package, made.layout, places(made.layout)))
    assert all(kernel["points"] for kernel in data["kernels"])


def test_digest_covers_what_only_the_solver_knows() -> None:
    """Two scenes with the same kernels, whose cranks start apart, are not taken for each other."""
    made = program("piston_crank")
    moved = replace(made.solver, divisions=61)
    digests = {
        Manifest.from_json(emit_scene(made.package, view, {})["manifest.json"]).digest
        for view in (made.solver, moved)
    }
    assert len(digests) == 2


def test_folders_take_the_analysis_along_as_it_is() -> None:
    runtime = Path(linkage_emit.__file__).parents[1] / "runtime"
    made = program("piston_crank")
    files = emit_scene(made.package, made.solver, {})
    paths = [path for path in (runtime / "kinematics").iterdir() if path.suffix in {".h", ".py"}]
    paths += [runtime / name for name in linkage_emit.RESULT]
    names = {path.relative_to(runtime).as_posix() for path in paths}
    assert {name for name in files if "/" in name} == names
    for name in names:
        assert files[name] == (runtime / name).read_text(encoding="utf-8")


def test_digest_covers_the_analysis(monkeypatch: pytest.MonkeyPatch) -> None:
    made = program("piston_crank")
    before = emit_scene(made.package, made.solver, {})["manifest.json"]
    more = {"kinematics/new.h": "\n"}
    monkeypatch.setattr(linkage_emit, "along", lambda *names: along(*names) | more)
    after = emit_scene(made.package, made.solver, {})["manifest.json"]
    assert Manifest.from_json(before).digest != Manifest.from_json(after).digest


def test_same_scene_gives_the_same_bytes() -> None:
    scene = read_scene(SCENES / "five_bar.toml")
    assert generate_scene(scene) == generate_scene(scene)


@pytest.mark.parametrize(
    ("file", "right", "wrong"),
    [
        ("continuation.py", "first * rate, second * rate", "-first * rate, second * rate"),
        ("rows.h", "x_dot[i] = w->x1[i] * rate;", "x_dot[i] = -w->x1[i] * rate;"),
        ("rows.h", "+ w->x1[i] * rate_dot;", "- w->x1[i] * rate_dot;"),
        ("newton.h", "x[first + i] -= correction[i];", "x[first + i] += correction[i];"),
        ("solve.h", "run->start - run->start", "run->start + run->start"),
        ("continuation.h", "TWO_PI * ((double)(part", "-TWO_PI * ((double)(part"),
        ("solve.py", "else run.counted_inputs(division)", "else way.position.alpha"),
    ],
)
def test_verify_finds_a_flipped_sign_in_the_solver(
    tmp_path: Path, compiler: object, file: str, right: str, wrong: str
) -> None:
    """The kernels are right, and every digest fits: only the motion tells."""
    files = dict(files_of("lever_crank"))
    file = f"kinematics/{file}"
    assert right in files[file]
    files[file] = files[file].replace(right, wrong)
    old = Manifest.from_json(files["manifest.json"])
    digests = tuple(
        (name, hashlib.sha256(files[name].encode()).hexdigest()) for name, _ in old.files
    )
    files["manifest.json"] = replace(old, files=digests).to_json()
    report = verify(write(tmp_path / "lever_crank", files))
    assert not report.ok
    assert all("solver by" in problem for problem in report.problems)


@pytest.mark.parametrize(
    ("lengths", "start", "joints", "rows"),
    [
        pytest.param((3.53, 8.45, 8.71, 3.47), 1.75, ((-0.63, 3.47), (6.37, 8.21)), 8, id="stops"),
        pytest.param((5.15, 4.94, 5.17, 4.8), 2.63, ((-4.49, 2.52), (0.44, 2.78)), 11, id="turns"),
    ],
)
def test_references_go_as_far_as_the_crank(
    lengths: tuple[float, ...], start: float, joints: tuple[tuple[float, float], ...], rows: int
) -> None:
    """One crank stops where the links would soon close again; one passes close by such a place."""
    crank, coupler, rocker, frame = lengths
    tree = {
        "name": "crank",
        "unit": "m",
        "divisions": 10,
        "nodes": {
            "O1": {"at": (0, 0), "fixed": True},
            "O2": {"at": joints[0]},
            "O3": {"at": joints[1]},
            "O4": {"at": (frame, 0), "fixed": True},
        },
        "links": {
            "l1": {"nodes": ("O1", "O2"), "length": crank},
            "l2": {"nodes": ("O2", "O3"), "length": coupler},
            "l3": {"nodes": ("O3", "O4"), "length": rocker},
        },
        "inputs": {"alpha": {"link": "l1", "about": "O1", "from": start, "to": start + 0.01}},
    }
    scene = scene_from_dict(tree)
    turning = structs.replace(scene.inputs["alpha"], to=None, turns=1.0)  # closes or not
    scene = structs.replace(scene, inputs={"alpha": turning})
    made = specialise(assemble(scene), load_frozen("link"))
    assert [place.part for place in places(made.layout)] == [Fraction(k, 10) for k in range(rows)]
