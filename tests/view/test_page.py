"""The page as text, stills, and the figure of a mechanism at rest."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec import structs

from kousoku.model.errors import SolveError
from kousoku.model.reading.read import read_scene
from kousoku.view import animate, draw_mechanism
from kousoku.view.picture import picture_of
from kousoku.view.stills import Camera, moving_svg, paths_seen
from tests.view.runs import arm, lever_crank, turning

SCENES = Path(__file__).parents[2] / "scenes"
HOSTILE = "</script><script>alert(1)</script><!--<img src=x onerror=alert(2)>&\u2028\"'"


def data_in(page: str) -> dict[str, Any]:
    found = re.search(r'<script id="scene" type="application/json">(.*?)</script>', page, re.S)
    assert found is not None
    data: dict[str, Any] = json.loads(found[1])
    return data


def test_the_page_holds_the_motion() -> None:
    """Unpacked as the script does, places and turns are those of the run to what is seen."""
    run = turning(rows=401)
    data = data_in(animate(run, arm()).html)
    start, step, frames = data["time"]
    numbers = np.frombuffer(base64.b64decode(data["motion"]), dtype="<i2").reshape(frames, 1, 7)
    angle = 2.0 * (start + step * np.arange(frames))
    turn = numbers[:, 0, 3:] / 32767
    assert np.abs(turn[:, 0] - np.cos(angle / 2)).max() < 2e-5
    assert np.abs(turn[:, 3] - np.sin(angle / 2)).max() < 2e-5
    forces = np.frombuffer(base64.b64decode(data["forces"]), dtype="<i2").reshape(frames, 1, 3)
    wanted = np.stack([-np.cos(angle), 10 - np.sin(angle), 0 * angle], axis=1)
    assert np.abs(forces[:, 0] * data["force"]["quantum"] - wanted).max() < 2e-3


def test_forces_are_in_newtons_whatever_the_unit() -> None:
    scene = read_scene(SCENES / "gear_train.toml")  # in mm
    rows = 3
    time = np.linspace(0.0, 1.0, rows)
    zero, still = np.zeros((rows, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (rows, 1))
    table = dict.fromkeys(scene.bodies, zero)
    run = turning(
        time=time,
        position=table,
        velocity=table,
        angular_velocity=table,
        orientation=dict.fromkeys(scene.bodies, still),
        force={"rack_guide": np.tile([0.0, 5000.0, np.nan], (rows, 1))},
    )
    data = data_in(animate(run, scene).html)
    forces = np.frombuffer(base64.b64decode(data["forces"]), dtype="<i2").reshape(-1, 3)
    assert forces[0, 1] * data["force"]["quantum"] == pytest.approx(5.0)  # kg mm/s² are mN
    assert data["force"]["unit"] == "N"
    assert data["loads"][0]["name"] == "rack_guide"


def test_names_of_strangers_end_no_element() -> None:
    page = animate(turning(), structs.replace(arm(), title=HOSTILE)).html
    assert page.count("<script") == page.count("</script>") == 2
    assert "<img" not in page and "<!--" not in page and "onerror=alert(2)>" not in page
    assert "&lt;/script&gt;" in page


def test_the_page_asks_for_nothing_outside_of_it() -> None:
    page = animate(turning(), arm()).html
    assert not re.search(r"https?:|//\w+\.|@import|url\(|\bfetch\(|XMLHttpRequest|import\(", page)
    assert "default-src 'none'" in page
    script = page.rsplit("<script>", 1)[1].split("</script>")[0]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in page


def test_the_same_run_gives_the_same_bytes() -> None:
    first, second = (animate(turning(), arm()) for _ in range(2))
    assert first.html == second.html
    assert first.still() == second.still()


def test_a_page_is_small() -> None:
    """Half of it is the script; a motion of two seconds is a few kB."""
    assert len(animate(turning(rows=1001), arm()).html.encode()) < 60_000


def test_an_animation_is_told_and_shown_in_a_cell(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("KOUSOKU_STILLS", raising=False)
    animation = animate(turning(), arm())
    assert repr(animation) == "<Animation of 'arm': 0 to 2 s, 1 body>"
    shown = animation._repr_html_()
    assert shown is not None
    found = re.fullmatch(r'<iframe srcdoc="([^"]*)" sandbox="allow-scripts"[^>]*></iframe>', shown)
    assert found is not None and html.unescape(found[1]) == animation.html
    assert animation._repr_svg_() is None
    monkeypatch.setenv("KOUSOKU_STILLS", "1")
    assert animation._repr_html_() is None
    assert animation._repr_svg_() == animation.still()


def test_files_are_written_by_their_suffix(tmp_path: Path) -> None:
    animation = animate(turning(), arm(), tmp_path / "arm.html")
    assert (tmp_path / "arm.html").read_text(encoding="utf-8") == animation.html
    animation.save(str(tmp_path / "arm.svg"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["arm.html", "arm.svg"]
    with pytest.raises(SolveError, match=r"wanted a file \*\.html or \*\.svg"):
        animation.save(tmp_path / "arm.gif")


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("arm.html/in_a_file.html", "there is no folder .*arm.html; make it first"),
        ("null\0.html", "cannot be written"),
    ],
)
def test_a_file_that_cannot_be_written_is_refused_in_our_own_words(
    tmp_path: Path, name: str, says: str
) -> None:
    animation = animate(turning(), arm(), tmp_path / "arm.html")
    with pytest.raises(SolveError, match=says):
        animation.save(tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == ["arm.html"]


def test_a_still_is_an_svg_of_one_moment() -> None:
    animation = animate(turning(), structs.replace(arm(), title=HOSTILE))
    root = ET.fromstring(animation.still())
    assert root.tag.endswith("svg")
    assert root[0].text == HOSTILE
    assert animation.still(0.0) != animation.still(1.0)
    assert "grid" in animation.still() and "[m]" in animation.still()


@pytest.mark.parametrize(
    ("time", "message"),
    [
        (99, "arm: time 99; wanted one from 0 to 2 s"),
        (-0.1, "arm: time -0.1; wanted one from 0 to 2 s"),
        (float("nan"), "arm: time nan; wanted one from 0 to 2 s"),
        ("x", "arm: time 'x'; wanted a number"),
    ],
)
def test_a_still_of_no_moment_of_the_run_is_refused(time: Any, message: str) -> None:
    with pytest.raises(SolveError, match=re.escape(message)):
        animate(turning(), arm()).still(time)


def test_a_path_of_many_turns_is_round_in_a_still() -> None:
    """Chords between 240 points of 48 turns would come as near to the middle as 0.8 of the arm."""
    picture = picture_of(turning(rows=1001, end=48 * np.pi), arm(), paths_of=[("bar", (0.5, 0, 0))])
    camera = Camera(picture, (1000.0, 800.0), 10.0)
    (stroke,) = paths_seen(picture, camera)
    middle, _ = camera.seen(np.zeros((1, 3)))
    radius = np.linalg.norm(0.5 * (stroke.points[1:] + stroke.points[:-1]) - middle, axis=1)
    assert np.ptp(radius) < 0.01 * radius.max()


def test_a_picture_that_moves_shows_one_frame_after_the_other(tmp_path: Path) -> None:
    place = tmp_path / "lever_crank.svg"
    animate(*lever_crank(), place)
    root = ET.fromstring(place.read_text(encoding="utf-8"))
    frames = [g for g in root if g.tag.endswith("}g") and (g.get("class") or "").startswith("f")]
    assert len(frames) == int(2 * np.pi * 15)
    assert [g.get("class") for g in frames].count("f") == 1  # what is seen where nothing moves
    assert len({ET.tostring(g[-1]) for g in frames}) > 1
    delays = [float((g.get("style") or "").split(":")[1].rstrip("s")) for g in frames]
    assert delays[0] == 0.0 and delays[1:] == sorted(delays[1:])
    assert len(place.read_bytes()) < 500_000


def test_a_picture_that_moves_is_no_larger_than_is_asked() -> None:
    picture = picture_of(*lever_crank())
    assert 40_000 < len(moving_svg(picture, largest=60_000).encode()) < 66_000


@pytest.mark.parametrize("name", ["loop", "stephenson_six_bar", "andrews_squeezer"])
def test_a_mechanism_at_rest_is_a_figure_with_its_names(name: str) -> None:
    figure = draw_mechanism(read_scene(SCENES / f"{name}.toml"))
    (axes,) = figure.axes
    texts = {text.get_text() for text in axes.texts}
    assert any(re.fullmatch(r"grid [\d.]+ \[\w+\]", text) for text in texts)
    assert len(axes.collections) > 20
    assert len(texts) > 6


def test_importing_the_view_needs_numpy_only() -> None:
    code = (
        "import kousoku.view, sys\n"
        "print(*{m.split('.')[0] for m in sys.modules} & "
        "{'sympy', 'mpmath', 'msgspec', 'matplotlib', 'jinja2', 'typer', 'rich'})"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == []
