"""The README and the pages that it leads to tell the truth: programs and commands run here.

They print what stands there; ``…`` is what differs from machine to machine. Links lead on.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

import kousoku as ks
from kousoku.cli import main
from kousoku.symbolic import KINDS

if TYPE_CHECKING:
    from kousoku.runtime.toolchain import Toolchain

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [*sorted(ROOT.glob("*.md")), *sorted(DOCS.glob("*.md"))]
LEVER = ROOT / "generated" / "lever_crank"


def read(path: Path) -> str:
    return path.read_text(encoding="utf-8")


README = read(ROOT / "README.md")
LINKAGES = read(DOCS / "linkages.md")


def blocks(text: str, language: str) -> list[tuple[str, str]]:
    """Fenced blocks of a language, each with the text block that follows it."""
    fence = rf"```{language}\n(.*?)```\n(?:\n```text\n(.*?)```)?"
    return [(code, shown) for code, shown in re.findall(fence, text, re.DOTALL)]


def shown_commands(*pages: str) -> list[tuple[str, str]]:
    """Commands of pages that show what they print, and what that is."""
    found = []
    for page in pages:
        text = read(DOCS / page)
        found += re.findall(r"```text\n\$ kousoku (.*?)\n(.*?)```", text, re.DOTALL)
    return found


@pytest.fixture
def clone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Stand in a folder that has what a clone has, and may be written to."""
    shutil.copytree(ROOT / "scenes", tmp_path / "scenes")
    (tmp_path / "generated").symlink_to(ROOT / "generated", target_is_directory=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_first_screen_installs_moves_and_tells_the_limits() -> None:
    first = "\n".join(README.splitlines()[:60])
    for wanted in ("pip install .", "ks.load(", ".animate(", "Not (yet)", "make demo", "make test"):
        assert wanted in first
    assert len(README.splitlines()) <= 150


@pytest.mark.parametrize("text", [README, LINKAGES], ids=["README", "linkages"])
@pytest.mark.usefixtures("compiler")
def test_the_python_example_prints_what_stands_below_it(text: str, clone: Path) -> None:
    ((code, shown),) = blocks(text, "python")
    assert len(code.splitlines()) <= 15
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=clone
    )
    assert run.stdout == shown
    assert (clone / "loop.html").is_file() is ("loop.html" in code)


def test_the_japanese_readme_has_the_same_programs() -> None:
    japanese = read(ROOT / "README.ja.md")
    for language in ("python", "toml", "sh", "text"):
        assert without_comments(japanese, language) == without_comments(README, language)


def without_comments(text: str, language: str) -> list[str]:
    """Blocks of a language; what stands behind ``#`` may be in another one."""
    return [re.sub(r" *# .*", "", code) for code, _ in blocks(text, language)]


COMMANDS = re.findall(r"^kousoku (.*?)(?: *#.*)?$", blocks(README, "sh")[-1][0], re.MULTILINE)


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.usefixtures("compiler")
def test_the_commands_of_the_readme_work_as_typed(command: str, clone: Path) -> None:
    with pytest.raises(SystemExit) as end:
        main(shlex.split(command))
    assert end.value.code in {None, 0}
    for name in re.findall(r"--out (\S+)", command):
        assert (clone / name).is_file()


@pytest.mark.parametrize(("command", "shown"), shown_commands("first_steps.md", "linkages.md"))
@pytest.mark.usefixtures("compiler", "clone")
def test_the_documents_show_what_commands_print(
    command: str, shown: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(shlex.split(command))
    pattern = re.escape(shown).replace("…", ".*?")
    assert re.fullmatch(pattern, capsys.readouterr().out, re.DOTALL)


def program(folder: Path) -> tuple[Path, str]:
    """Lay out the C program beside the solver's files; return it and what it prints."""
    ((code, shown),) = blocks(LINKAGES, "c")
    assert len(code.splitlines()) <= 30
    for name in ("solver.c", "solver.h"):
        shutil.copy(LEVER / name, folder / name)
    shutil.copytree(LEVER / "kinematics", folder / "kinematics")
    source = folder / "main.c"
    source.write_text(code, encoding="utf-8")
    return source, shown


def numbers(text: str) -> np.ndarray:
    return np.array([[float(word) for word in line.split()] for line in text.splitlines()])


@pytest.mark.parametrize("flags", [(), ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror")])
def test_the_c_program_compiles_and_solves_the_lever_crank(
    compiler: Toolchain, tmp_path: Path, flags: tuple[str, ...]
) -> None:
    source, shown = program(tmp_path)
    command = [*compiler.command, *flags, source.name, "solver.c", "-lm", "-o", "solve"]
    built = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (built.returncode, built.stderr) == (0, "")
    run = subprocess.run([tmp_path / "solve"], capture_output=True, text=True, check=True)
    np.testing.assert_allclose(numbers(run.stdout), numbers(shown), rtol=0, atol=2e-9)


def test_the_c_program_compiles_as_cpp(compiler: Toolchain, tmp_path: Path) -> None:
    cpp = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    if cpp is None:
        pytest.skip("no C++ compiler here")
    source, shown = program(tmp_path)
    source.rename(tmp_path / "main.cpp")
    for command in (
        [*compiler.command, "-c", "solver.c"],
        [cpp, "-Wall", "-Wextra", "-Werror", "main.cpp", "solver.o", "-lm", "-o", "solve"],
    ):
        subprocess.run(command, cwd=tmp_path, check=True)
    run = subprocess.run([tmp_path / "solve"], capture_output=True, text=True, check=True)
    np.testing.assert_allclose(numbers(run.stdout), numbers(shown), rtol=0, atol=2e-9)


@pytest.mark.usefixtures("compiler")
def test_the_driven_loop_closes_and_its_motor_lifts_the_bodies() -> None:
    """With the crank at α and the rocker at φ the ends of the coupler stay √10 m apart."""
    ((code, _),) = blocks(README, "toml")
    assert len(code.splitlines()) <= 20
    scene = ROOT / "scenes" / "loop.toml"
    assert ks.load(code).scene == ks.load(scene).scene
    run = ks.load(scene).simulate(2, samples=21, parameters={"speed": 2.0})
    alpha, phi = 2.0 * run.time, run["rocking"]
    crank = np.array([0 * alpha, np.cos(alpha), np.sin(alpha)])
    rocker = np.array([3 - 2 * np.sin(phi), 2 * np.cos(phi), 0 * phi])
    assert np.abs(np.sum((crank - rocker) ** 2, axis=0) - 10).max() < 1e-13
    assert np.abs(phi).max() > 0.6
    torque = run.driver("motor").torque[0]
    assert torque == pytest.approx([9.81 * (2 / 2 + 3 / 2), 0, 0], abs=1e-9)


TAUGHT = [
    *PAGES,
    *ROOT.glob("docs/examples/*"),
    *ROOT.glob("notebooks/*.ipynb"),
    *ROOT.rglob("scenes/**/*.toml"),
]
DEEP = re.compile(r"from kousoku(?:\.\w+)+ import|import kousoku\.\w")


def test_what_teaches_imports_the_door_alone() -> None:
    assert {path.suffix for path in TAUGHT} == {".md", ".py", ".c", ".ipynb", ".toml"}
    assert not [str(path.relative_to(ROOT)) for path in TAUGHT if DEEP.search(read(path))]
    names = {x for path in TAUGHT for x in re.findall(r"from kousoku import (\w+)", read(path))}
    names |= {x for path in TAUGHT for x in re.findall(r"\bks\.(\w+)", read(path))}
    assert "load" in names <= {*ks.__all__}


@pytest.mark.parametrize(
    "line", ["from kousoku.view.plots import to_svg", "import kousoku.model.reading.read"]
)
def test_a_deep_import_is_seen(line: str) -> None:
    assert DEEP.search(line)
    assert not DEEP.search("import kousoku as ks; from kousoku import load")


def test_the_table_of_kinds_is_complete() -> None:
    rows = re.findall(r"^\| `(\w+)`", read(DOCS / "kinds.md"), re.MULTILINE)
    assert rows == list(KINDS)


def anchors(path: Path) -> set[str]:
    """Anchors of a page's headings, as GitHub makes them."""
    prose = re.sub(r"```.*?```", "", read(path), flags=re.DOTALL)
    headings = re.findall(r"^#+ +(.*?) *$", prose, re.MULTILINE)
    plain = [re.sub(r"[^\w\- ]", "", heading.lower()) for heading in headings]
    return {heading.replace(" ", "-") for heading in plain}


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_every_link_inside_the_project_leads_somewhere(path: Path) -> None:
    prose = re.sub(r"```.*?```|\$[^$\n]*\$", "", read(path), flags=re.DOTALL)
    for target, anchor in re.findall(r"\]\(([^)#]*)#?([^)]*)\)", prose):
        if "://" in target:
            continue
        page = path.parent / target if target else path
        assert page.exists(), target
        if anchor and page.suffix == ".md":
            assert anchor in anchors(page), f"{target}#{anchor}"


def test_the_steps_of_ci_are_targets_of_the_makefile_and_tasks() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    ci = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    steps = re.findall(r"^step ([a-z-]+)", ci, re.MULTILINE)
    targets = [
        name
        for _, names in re.findall(r"^(TASKS|TESTED) := (.*)$", makefile, re.MULTILINE)
        for name in names.split()
    ]
    usage = subprocess.run(
        [sys.executable, ROOT / "tasks.py", "--help"], capture_output=True, text=True, check=True
    ).stderr
    tasks = re.findall(r"^  (\S+)", usage, re.MULTILINE)
    assert {"quick", "test", "release-test", "stress"} <= {*steps} <= {*tasks}
    assert {"demo", "notebook"} <= {*tasks}
    assert sorted(targets) == sorted(tasks)


@pytest.mark.skipif(os.name != "posix", reason="a group of processes gets Ctrl-C")
def test_a_command_that_is_cut_puts_things_in_order_before_its_task_ends() -> None:
    """Ctrl-C reaches both: a task that ended at once would end what it began, too."""
    command = (
        "import signal, sys, time\n"
        "def order(signum, frame):\n"
        "    time.sleep(1)\n"
        "    print('in order', flush=True)\n"
        "    sys.exit(7)\n"
        "signal.signal(signal.SIGINT, order)\n"
        "print('ready', flush=True)\n"
        "time.sleep(60)\n"
    )
    script = (
        "import sys, tasks\n"
        "tasks.PYTHON = sys.executable\n"
        f"sys.exit(tasks.run(('-c', {command!r}), []))\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", script],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    for line in process.stdout:
        if line == "ready\n":
            break
    os.killpg(process.pid, signal.SIGINT)
    said = process.communicate(timeout=30)[0]
    assert said == "in order\n"
    assert process.returncode == 7
