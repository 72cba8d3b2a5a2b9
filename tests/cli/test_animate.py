"""``kousoku animate``: the page it writes, and what it refuses."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from kousoku.mechanism import Mechanism
from kousoku.runtime.dynamics import DynamicsSolver

if TYPE_CHECKING:
    from collections.abc import Callable

    from kousoku.runtime.integrate.motion import Motion
    from kousoku.runtime.toolchain import Toolchain

    Run = Callable[..., tuple[int, str, str]]

SCENES = Path(__file__).parents[2] / "scenes"
LINKAGE = SCENES / "lever_crank.toml"
BODY = SCENES / "pendulum.toml"


def test_a_linkage_needs_no_time(run: Run, tmp_path: Path) -> None:
    place = tmp_path / "x.html"
    code, out, err = run("animate", LINKAGE, "--target", "numpy", "--out", place)
    assert (code, err) == (0, "")
    size = place.stat().st_size
    assert out == f"wrote {place}, {size / 1000:.0f} kB\n"
    assert "Lever crank" in place.read_text(encoding="utf-8")


def test_the_page_stands_beside_where_the_command_is_called(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("animate", LINKAGE, "--target", "numpy")[0] == 0
    assert [path.name for path in tmp_path.iterdir()] == ["lever_crank.html"]


def test_bodies_move_to_the_end(run: Run, tmp_path: Path, compiler: Toolchain) -> None:
    assert compiler is not None
    pages = [tmp_path / name for name in ("one.html", "again.html", "longer.html")]
    for page, end in zip(pages, ("1", "1", "2"), strict=True):
        code, _, err = run("animate", BODY, "--end", end, "--path-of", "rod", "--out", page)
        assert (code, err) == (0, "")
    texts = [page.read_bytes() for page in pages]
    assert texts[0] == texts[1] != texts[2]


@pytest.mark.usefixtures("compiler")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([BODY], "a last time is wanted: --end SECONDS; or give the scene a duration\n"),
        ([LINKAGE, "--set", "k=2"], "a linkage has no parameters"),
        ([LINKAGE, "--initial", "alpha=1"], "inputs say where a linkage starts"),
        ([BODY, "--end", "1", "--set", "k=2"], "no parameter 'k': its formulas have none\n"),
        ([LINKAGE, "--out", "x.gif"], "the name must end in .html or .svg"),
        ([LINKAGE, "--out", "nowhere/x.html"], "there is no folder nowhere; make it first"),
        ([LINKAGE, "--target", "numpy", "--speed", "0"], "wanted a positive number"),
        ([LINKAGE, "--target", "numpy", "--path-of", "O9"], "no body or joint 'O9': there are"),
    ],
)
def test_what_cannot_be_shown_is_one_line(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    code, out, err = run("animate", *arguments)
    assert (code, out) == (2, "")
    assert message in err and err.count("\n") == 1
    assert not list(tmp_path.iterdir())


SINC = """
name = "sinc"
unit = "m"
outputs = ["accelerations"]
[bodies]
b = { position = [0, 0, 0], point = true, mass = 1 }
[forces]
f = { type = "force", body = "b", force = ["sin(t - 0.5)/(t - 0.5)", 0, 0] }
"""


@pytest.mark.usefixtures("compiler")
def test_a_motion_that_cannot_be_trusted_is_shown_and_told(run: Run, tmp_path: Path) -> None:
    scene, page = tmp_path / "sinc.toml", tmp_path / "x.html"
    scene.write_text(SINC, encoding="utf-8")
    code, out, err = run("animate", scene, "--end", "1", "--out", page)
    assert code == 3 and out.startswith("wrote ") and page.exists()
    assert "not trusted: numbers of rows are not finite" in err


@pytest.mark.usefixtures("interrupts", "compiler")
@pytest.mark.parametrize("begun", [True, False])
def test_an_interrupt_shows_what_was_reached(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, begun: bool
) -> None:
    simulate = DynamicsSolver.simulate

    def pressed(solver: DynamicsSolver, end: float | None, **options: Any) -> Motion:
        if not begun:
            end, options["times"] = None, [10.0, 20.0]
        options["progress"] = lambda *_: signal.raise_signal(signal.SIGINT)
        return simulate(solver, end, **options)

    monkeypatch.setattr(DynamicsSolver, "simulate", pressed)
    page = tmp_path / "x.html"
    code, out, err = run("animate", BODY, "--end", "100", "--out", page)
    assert code == 130
    assert err.startswith(f"kousoku: {BODY}: stopped at t = ") and err.count("\n") == 1
    assert (page.exists(), out.startswith(f"wrote {page}, ")) == (begun, begun)


@pytest.mark.parametrize(
    "option", [("--path-of", "O9"), ("--speed", "0"), ("--path-of", "O3", "--path-of", "b")]
)
def test_what_cannot_be_shown_is_told_before_it_moves(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, option: tuple[str, ...]
) -> None:
    monkeypatch.setattr(Mechanism, "solve", None)
    code, _, err = run(
        "animate", LINKAGE, "--target", "numpy", *option, "--out", tmp_path / "x.svg"
    )
    assert code == 2 and err.count("\n") == 1 and "Traceback" not in err


def test_a_saved_run_takes_no_options_of_a_motion(run: Run, tmp_path: Path) -> None:
    saved = tmp_path / "run.npz"
    assert run("solve", LINKAGE, "--target", "numpy", "--out", saved)[0] == 0
    for option in (["--end", "1"], ["--set", "k=2"], ["--initial", "alpha=1"]):
        code, out, err = run("animate", saved, *option, "--out", tmp_path / "x.html")
        assert (code, out) == (2, "")
        assert "are for scenes; this run is over" in err
    assert [path.name for path in tmp_path.iterdir()] == ["run.npz"]
