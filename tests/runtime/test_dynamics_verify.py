"""Solvers of bodies are verified: what is right passes, and what is wrong is named."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import kousoku as ks
from kousoku.codegen.dynamics.checking import reference
from kousoku.codegen.dynamics.generate import generate_dynamics
from kousoku.codegen.generate import write_tree
from kousoku.model.errors import SolveError
from kousoku.model.files.compressed import content, stored
from kousoku.model.files.manifest import Manifest
from kousoku.model.reading.read import read_scene
from kousoku.runtime import notice, verify
from kousoku.runtime.dynamics import load_dynamics
from tests.runtime.conftest import unlist

if TYPE_CHECKING:
    from collections.abc import Callable

SCENES = Path(__file__).parents[2] / "scenes"
pytestmark = pytest.mark.usefixtures("warm_cache")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the heavy top, with all outputs and reference values."""
    outputs = ("accelerations", "reactions", "energies")
    tree = generate_dynamics(read_scene(SCENES / "heavy_top.toml"), outputs, references=True)
    folder = tmp_path_factory.mktemp("verified") / "heavy_top"
    write_tree(folder, tree)
    return folder


@pytest.fixture
def folder(whole: Path, tmp_path: Path) -> Path:
    """Copy of the folder that may be spoilt."""
    shutil.copytree(whole, tmp_path / "heavy_top")
    return tmp_path / "heavy_top"


def spoil(folder: Path, name: str, change: Callable[[str], str], *, honest: bool = True) -> None:
    """Change a file, and the digests in the manifest so that only its numbers tell."""
    text = content(name, (folder / name).read_bytes()).decode()
    changed = change(text)
    assert changed != text
    (folder / name).write_bytes(stored(name, changed))
    if not honest:
        return
    path = folder / "manifest.json"
    manifest = Manifest.from_json(path.read_text(encoding="utf-8"))
    digest = hashlib.sha256(changed.encode()).hexdigest()
    files = tuple((file, digest if file == name else old) for file, old in manifest.files)
    path.write_text(replace(manifest, files=files).to_json(), encoding="utf-8")


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.usefixtures("shipped_flags")
@pytest.mark.usefixtures("compiler")
def test_a_right_solver_is_verified_by_both_targets(whole: Path) -> None:
    report = verify(whole)

    assert report.ok
    assert report.notes == ()
    assert {row.way for row in report.rows} == {"C", "NumPy"}
    assert {"v_dot", "free", "reactions", "energies", "dq", "dv"} <= {r.output for r in report.rows}
    assert report.worst is not None
    assert 0.0 < report.worst.worst < 1.0
    json.dumps(report.to_dict())


@pytest.mark.parametrize("name", ["free_body", "gear_train", "lever_crank_bodies"])
def test_all_that_a_scene_computes_is_verified(tmp_path: Path, name: str) -> None:
    outputs = ("accelerations", "coordinates", "reactions", "energies")
    tree = generate_dynamics(read_scene(SCENES / f"{name}.toml"), outputs, references=True)
    write_tree(tmp_path / name, tree)
    report = verify(tmp_path / name, target="numpy")

    assert report.problems == report.notes == ()
    places = json.loads(tree["motion.json"])["places"]
    assert {row.output for row in report.rows if row.kernel == "solver"} == {
        name for name, (_, size) in places.items() if size
    }


@pytest.mark.parametrize("name", ["integrate/methods.h", "integrate/methods.py"])
def test_tables_that_the_manifest_does_not_list_are_named(folder: Path, name: str) -> None:
    unlist(folder, name)
    report = verify(folder, target="numpy")
    assert any(f"{name} is wanted, and its manifest does not list it" in p for p in report.problems)


@pytest.mark.usefixtures("compiler")
def test_a_flipped_sign_in_the_solver_is_named(folder: Path) -> None:
    def flip(text: str) -> str:
        last = list(re.finditer(r"const double \w+ = \S+( - )", text))[-1]
        return f"{text[: last.start(1)]} + {text[last.end(1) :]}"

    spoil(folder, "solver.c", flip)
    report = verify(folder, target="c")
    assert not report.ok
    assert "units off (limit 4)" in report.problems[0]
    assert verify(folder, target="numpy").ok


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.usefixtures("compiler")
def test_a_changed_constant_is_named(folder: Path) -> None:
    def change(text: str) -> str:
        number = next(x for x in re.findall(r"\d\.\d{6,}", text) if float(x))
        return (
            text.replace(number, number + "1", 1)
            if len(number) < 15
            else text.replace(number, number[:-3], 1)
        )

    spoil(folder, "solver.py", change)
    report = verify(folder)
    assert not report.ok
    assert any("by NumPy" in problem or "NumPy differ" in problem for problem in report.problems)


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.usefixtures("compiler")
def test_another_step_in_one_target_is_named(folder: Path) -> None:
    file = "integrate/stepper.h"
    before, after = (f"#define EARLIER_ERROR_EXPONENT {number}" for number in ("0.2", "0.3"))
    spoil(folder, file, lambda text: text.replace(before, after))
    (problem,) = [x for x in verify(folder).problems if "dop853" in x]
    assert "C and NumPy differ after 2 steps" in problem


def test_a_code_that_another_call_returns_is_named(folder: Path) -> None:
    spoil(folder, "solver.h", lambda text: text.replace("PROJECTED = -2", "PROJECTED = -(2)"))
    (problem,) = verify(folder, target="numpy").problems
    assert problem.endswith("solver.h: NOT_PROJECTED is -(2), wanted -2")


def test_another_bit_of_a_doubt_is_named(folder: Path) -> None:
    spoil(folder, "solver.h", lambda text: text.replace("DOUBT_WORKS = 8", "DOUBT_WORKS = 4"))
    (problem,) = verify(folder, target="numpy").problems
    assert problem.endswith("solver.h: DOUBT_WORKS is 4, wanted 8")


def test_a_stale_file_is_named(folder: Path) -> None:
    spoil(folder, "motion.json", lambda text: text.replace(" ", "", 1), honest=False)
    report = verify(folder, target="numpy")
    assert not report.ok
    assert "motion.json" in report.problems[0]


def test_a_package_without_reference_values_says_so(tmp_path: Path) -> None:
    folder = tmp_path / "pendulum"
    write_tree(folder, generate_dynamics(read_scene(SCENES / "pendulum.toml"), ()))
    report = verify(folder, target="numpy")
    assert report.rows == ()
    assert "was generated without reference values" in report.notes[0]


def test_a_program_that_is_too_large_gets_none_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reference, "MOST_OPERATIONS", 20)
    folder = tmp_path / "pendulum"
    tree = generate_dynamics(read_scene(SCENES / "pendulum.toml"), (), references=True)
    write_tree(folder, tree)
    report = verify(folder, target="numpy")
    assert "operations are more than 20" in report.notes[0]


def test_a_reference_that_cannot_be_read_is_named(folder: Path) -> None:
    spoil(folder, "reference.json.gz", lambda text: text.replace('"points"', '"dots"'))
    (problem,) = verify(folder, target="numpy").problems
    assert "reference.json.gz cannot be read: KeyError('points')" in problem


@pytest.mark.usefixtures("numpy_solver")
@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize("target", ["c", "numpy"])
def test_a_solver_can_be_asked_for_accelerations_at_any_state(whole: Path, target: Any) -> None:
    solver = load_dynamics(whole, target=target)
    start, motion = solver.evaluate(), solver.simulate(0.1, samples=2, tolerance=1e-9)

    assert start["C_left_out"] == pytest.approx([0.0] * 3, abs=1e-14)
    np.testing.assert_allclose(
        start["v_dot"][3:], _principal(solver, motion.angular_acceleration["top"][0]), rtol=1e-9
    )
    assert start["C"].shape == (0,)  # all rows are of a joint that the body is put onto
    off = solver.evaluate(q=solver.q + 0.01)
    assert np.abs(off["C_left_out"]).max() > 1e-3
    assert solver.evaluate(q=off["q_moved"])["C_left_out"] == pytest.approx([0.0] * 3, abs=1e-14)
    fast = solver.evaluate(v=2.0 * solver.v)
    assert np.abs(fast["v_dot"] - start["v_dot"]).max() > 1.0
    with pytest.raises(SolveError, match=r"q has the shape \(3,\), wanted \(7,\)"):
        solver.evaluate(q=np.zeros(3))
    with pytest.raises(SolveError, match="must be finite"):
        solver.evaluate(v=np.full(6, np.nan))


def _principal(solver: Any, vector: Any) -> Any:
    """Vector of the user's frame in the principal frame of the only body."""
    w, *e = solver.bodies[0].axes_b
    return vector + 2.0 * (w * np.cross(e, vector) + np.cross(e, np.cross(e, vector)))


def test_verify_does_not_say_how_long_a_run_would_take(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(notice, "_said", set())
    assert ks.verify(SCENES / "loop_free.toml", target="numpy").ok
    assert not caplog.messages
