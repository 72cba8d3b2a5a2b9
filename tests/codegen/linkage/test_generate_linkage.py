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

from kousoku.codegen.emit import runtime_sources
from kousoku.codegen.generate import write_tree
from kousoku.codegen.linkage import emit as linkage_emit
from kousoku.codegen.linkage.assemble import assemble
from kousoku.codegen.linkage.emit import emit_linkage
from kousoku.codegen.linkage.generate import generate_linkage, layout_of, program_of
from kousoku.codegen.linkage.reference import reference_values
from kousoku.codegen.linkage.solution import positions_of
from kousoku.model.files.manifest import Manifest
from kousoku.model.operations.arithmetic import FLOAT
from kousoku.model.operations.graph import Op
from kousoku.model.operations.interpret import evaluate
from kousoku.model.reading.read import read_scene, scene_from_dict
from kousoku.runtime.kinematics.rows import OF_NODES
from kousoku.runtime.verify import verify

if TYPE_CHECKING:
    from kousoku.codegen.linkage.layout import WorkspaceLayout
    from kousoku.model.operations.kernel import Kernel
    from kousoku.model.records.scene import Scene

SCENES = Path(__file__).parents[3] / "scenes"
NAMES = ("piston_crank", "lever_crank", "five_bar", "watt_six_bar", "stephenson_six_bar")
#: A slider and two loops; the others are verified for a release.
ALWAYS = ("piston_crank", "watt_six_bar")


def layout(name: str) -> WorkspaceLayout:
    return layout_of(assemble(read_scene(SCENES / f"{name}.toml")))


def referred(made: WorkspaceLayout) -> str:
    """Text of the references of a linkage."""
    return reference_values(program_of(made), made, positions_of(made))


@cache
def files_of(name: str) -> dict[str, str]:
    return generate_linkage(read_scene(SCENES / f"{name}.toml"), references=True)


def kernels(name: str) -> dict[str, Kernel]:
    return {kernel.name: kernel for kernel in program_of(layout(name)).kernels}


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
    assert [quantity.name for quantity in position.inputs] == ["x0"]


@pytest.mark.parametrize("name", NAMES)
def test_matrix_is_the_derivative_of_the_residual(name: str) -> None:
    made = layout(name)
    motion = {k: list(map(float, v)) for k, v in positions_of(made)[3].motion.items()}
    here = [0.0] * made.size
    for region, numbers in motion.items():
        base = made.regions[region].base
        here[base : base + len(numbers)] = numbers
    first = made.regions["x"].base
    for number, block in enumerate(made.blocks):
        kernel = program_of(made).kernels[3 * number]
        n, step = len(block.unknowns), 1e-6 * made.assembly.scene.largest_length
        matrix = np.reshape(evaluate(kernel, {"x0": here}, FLOAT)["D"], (n, n))
        for column in range(n):
            ends = []
            for sign in (1, -1):
                moved = list(here)
                moved[first + column] += sign * step
                ends.append(np.array(evaluate(kernel, {"x0": moved}, FLOAT)["epsilon"]))
            np.testing.assert_allclose(
                matrix[:, column], (ends[0] - ends[1]) / (2 * step), rtol=1e-6, atol=1e-7
            )
        first += n


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize(
    "name",
    [x if x in ALWAYS else pytest.param(x, marks=pytest.mark.release) for x in NAMES],
)
def test_generated_folders_verify(tmp_path: Path, name: str) -> None:
    report = verify(write(tmp_path / name, files_of(name)))
    assert report.ok, report
    assert max(row.worst for row in report.rows) <= 4


@pytest.mark.parametrize("wrong", ["acceleration_2", "nodes"])
def test_references_find_a_kernel_that_is_composed_wrong(tmp_path: Path, wrong: str) -> None:
    made = layout("piston_crank")
    program = program_of(made)
    kernels = list(program.kernels)
    for k, kernel in enumerate(kernels):
        if kernel.name == wrong:
            results = tuple(tuple(max(n - 1, 0) for n in result) for result in kernel.results)
            kernels[k] = replace(kernel, results=results)
    more = {"reference.json.gz": referred(made)}
    files = emit_linkage(replace(program, kernels=tuple(kernels)), made, more)
    report = verify(write(tmp_path / "wrong", files), target="numpy")
    assert not report.ok
    assert {row.kernel for row in report.rows if row.worst > 4} == {wrong}


def test_points_of_reference_lie_on_beside_and_off_the_way() -> None:
    data = json.loads(referred(layout("piston_crank")))
    labels = [point["label"] for point in data["points"]]
    assert sum(label.endswith("of the way") for label in labels) == 2 * 6
    assert any(label.startswith("near ") for label in labels)
    assert any(label.startswith("away from ") for label in labels)
    assert labels[-2:] == ["x[0] is nan", "x[2] is nan"]
    segments = [list(point["outputs"]) for point in data["points"][-2:]]
    assert segments == [[f"{x}_{k}" for x in OF_NODES] for k in (1, 2)]


def test_linkage_that_cannot_be_assembled_still_has_references() -> None:
    scene = read_scene(SCENES / "lever_crank.toml")
    links = {**scene.links, "l2": type(scene.links["l2"])(nodes=("O2", "O3"), length=5.0)}
    fields: dict[str, Any] = {name: getattr(scene, name) for name in scene.__struct_fields__}
    broken = type(scene)(**{**fields, "links": links})
    made = layout_of(assemble(broken))
    assert positions_of(made) == []
    data = json.loads(referred(made))
    assert data["points"] and data["solution"]["rows"] == []


def test_digest_covers_what_only_the_solver_knows() -> None:
    """Two scenes with the same segments, of other divisions, are not taken for each other."""
    scene = read_scene(SCENES / "piston_crank.toml")
    digests = {digest_of(one) for one in (scene, structs.replace(scene, divisions=61))}
    assert len(digests) == 2


def digest_of(scene: Scene) -> str:
    return Manifest.from_json(generate_linkage(scene)["manifest.json"]).digest


def test_folders_take_the_analysis_along_as_it_is() -> None:
    runtime = Path(linkage_emit.__file__).parents[2] / "runtime"
    files = generate_linkage(read_scene(SCENES / "piston_crank.toml"))
    paths = [path for path in (runtime / "kinematics").iterdir() if path.suffix in {".h", ".py"}]
    paths += [runtime / name for name in linkage_emit.SHARED]
    names = {path.relative_to(runtime).as_posix() for path in paths}
    assert {name for name in files if "/" in name} == names
    for name in names:
        assert files[name] == (runtime / name).read_text(encoding="utf-8")


def test_digest_covers_the_analysis(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = read_scene(SCENES / "piston_crank.toml")
    before = digest_of(scene)
    more = {"kinematics/new.h": "\n"}
    monkeypatch.setattr(
        linkage_emit, "runtime_sources", lambda *names: runtime_sources(*names) | more
    )
    assert digest_of(scene) != before


def test_same_scene_gives_the_same_bytes() -> None:
    scene = read_scene(SCENES / "five_bar.toml")
    assert generate_linkage(scene) == generate_linkage(scene)


@pytest.mark.parametrize(
    ("file", "right", "wrong"),
    [
        ("continuation.py", "first * rate, second * rate", "-first * rate, second * rate"),
        ("continuation.h", "x_dot[i] = w->x1[i] * rate;", "x_dot[i] = -w->x1[i] * rate;"),
        ("continuation.h", "+ w->x1[i] * rate_dot;", "- w->x1[i] * rate_dot;"),
        ("approach.h", "way.origin[i] = to[i];", "way.origin[i] = -to[i];"),
        ("approach.py", "target.tolist()", "(-target).tolist()"),
        ("newton.h", "            x[i] -= correction[i];", "            x[i] += correction[i];"),
        ("solve.h", "run->start - run->start", "run->start + run->start"),
        ("continuation.h", "TWO_PI * ((double)(part", "-TWO_PI * ((double)(part"),
        ("solve.py", "else run.counted_inputs(division)", "else path.position.alpha"),
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
    found = positions_of(layout_of(assemble(scene)))
    assert [place.part for place in found] == [Fraction(k, 10) for k in range(rows)]
