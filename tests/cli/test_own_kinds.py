"""Commands take the folder of a kind of one's own beside a scene that has joints of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

import kousoku as ks

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    Run = Callable[..., tuple[int, str, str]]

SCENE = """
name = "held"
unit = "m"
[bodies.b]
position = [0, 0, 0]
mass = 1
inertia = { xx = 1, yy = 1, zz = 1 }
[joints.level]
type = "upright"
bodies = ["ground", "b"]
a_i_b = [1, 0, 0]
a_j_b = [0, 0.6, 0.8]
"""


@pytest.fixture(scope="module")
def kind(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("kinds") / "upright"
    upright = ks.derive("upright", C=ks.body("i").axis().dot(ks.body("j").axis()))
    ks.kernels(upright, folder, target="numpy")
    return folder


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "held.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


def test_a_scene_is_checked_and_explained_with_a_kind(run: Run, scene: Path, kind: Path) -> None:
    code, out, _ = run("check", scene)
    assert code == 2
    assert f"{scene}:9: joints.level.type: unknown joint 'upright'" in out
    code, out, _ = run("check", scene, "--kind", kind)
    assert (code, out) == (0, f"{scene}: 1 body, 1 joint; 5 degrees of freedom\n")
    code, out, _ = run("explain", scene, "--kind", kind)
    assert code == 0
    assert "of one's own: upright" in out


def test_a_solver_is_generated_with_a_kind_and_verified(
    run: Run, numpy_solver: None, scene: Path, kind: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "held"
    assert run("generate", scene, "--kind", kind, "--out", folder)[0] == 0
    assert run("generate", scene, "--kind", kind, "--out", folder, "--check")[0] == 0
    assert run("generate", scene, "--out", folder, "--check")[0] == 2
    code, out, _ = run("verify", folder, "--target", "numpy")
    assert code == 0
    assert "newton_euler" in out


def test_what_is_no_kind_is_one_line(run: Run, scene: Path, tmp_path: Path) -> None:
    code, _, err = run("simulate", scene, "--kind", tmp_path / "nothing")
    assert code == 2
    assert "is not a generated package" in err
    assert len(err.splitlines()) == 1
