"""Notebooks are committed with their outputs; here they run again and must say the same.

``pytest tests/release/test_notebooks.py --update-golden`` writes the outputs.
"""

from __future__ import annotations

import ast
import json
import re
import warnings
from pathlib import Path
from typing import Any

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

FOLDER = Path(__file__).parents[2] / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
#: What is compared; a picture only has to be there, its bytes depend on the version of matplotlib.
COMPARED = ("text/plain", "text/latex", "text/markdown")


def shown(notebook: Any) -> list[list[tuple[str, str]]]:
    """Outputs of each code cell, as (media type, text); a picture without its text."""
    cells = []
    for cell in notebook.cells:
        if cell.cell_type != "code":
            continue
        seen = []
        printed: list[str] = []  # Jupyter may cut what is printed into several outputs
        for output in cell.outputs:
            if output.output_type == "stream":
                if output.name == "stdout":  # stderr tells about the machine: no compiler here
                    printed.append(output.text)
                continue
            assert output.output_type != "error", output
            has_picture = any(media.startswith("image/") for media in output.data)
            for media, text in sorted(output.data.items()):
                if media.startswith("image/"):
                    seen.append((media, ""))
                elif media in COMPARED and not has_picture and text:
                    seen.append((media, text))
        cells.append([("stdout", "".join(printed)), *seen])
    return cells


def clean(notebook: Any) -> None:
    """Leave out what differs from run to run: times, ids of cells, the kernel's version."""
    notebook.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
    for number, cell in enumerate(notebook.cells):
        cell.metadata = {}
        cell["id"] = f"cell-{number}"
        if cell.cell_type == "code":
            # What goes to standard error tells about this machine, and what is empty has told what
            # was compiled.
            kept = [
                output
                for output in cell.outputs
                if output.get("name") != "stderr" and any(output.get("data", {"": "x"}).values())
            ]
            cell.outputs = joined(kept)


def joined(outputs: list[Any]) -> list[Any]:
    """Join what is printed in one cell: Jupyter cuts it where the clock says so."""
    found: list[Any] = []
    for output in outputs:
        last = found[-1] if found else None
        if output.output_type == "stream" and last and last.get("name") == output.name:
            last.text += output.text
        else:
            found.append(output)
    return found


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_shows_what_is_committed(
    path: Path, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The kernel gets it: a page would be no output to keep.
    monkeypatch.setenv("KOUSOKU_STILLS", "1")
    committed = nbformat.read(path, as_version=4)
    notebook = nbformat.read(path, as_version=4)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # those of Jupyter's own event loop
        nbclient.NotebookClient(
            notebook, timeout=300, resources={"metadata": {"path": str(FOLDER.parent)}}
        ).execute()
    if request.config.getoption("--update-golden"):
        clean(notebook)
        path.write_text(nbformat.writes(notebook) + "\n", encoding="utf-8", newline="\n")
        return
    assert shown(notebook) == shown(committed)


def test_progress_leaves_nothing_to_be_seen_in_a_cell() -> None:
    source = """from kousoku.progress import status_line
with status_line() as tell:
    tell("generating <loop>")
    tell("compiling <loop>")
"""
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(source)])
    lines: list[str] = []

    client = nbclient.NotebookClient(notebook, timeout=300)
    process = client.process_message

    def listen(message: Any, *arguments: Any) -> Any:
        lines.append(message["content"].get("data", {}).get("text/html", ""))
        return process(message, *arguments)

    client.process_message = listen
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # those of Jupyter's own event loop
        client.execute()
    told = ["<pre>generating &lt;loop&gt;</pre>", "<pre>compiling &lt;loop&gt;</pre>"]
    assert [line for line in lines if line] == told
    (output,) = notebook.cells[0].outputs
    assert output.data == {"text/plain": "", "text/html": ""}


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_holds_outputs_and_no_path_of_a_machine(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    code = [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
    assert any(cell["outputs"] for cell in code)
    assert "/home/" not in text and "/tmp/" not in text and "/Users/" not in text


def names_used(path: Path) -> list[str]:
    """Names that the code of a notebook imports, and the attributes that it reads."""
    cells = nbformat.read(path, as_version=4).cells
    source = "\n".join(cell.source for cell in cells if cell.cell_type == "code")
    names: list[str] = []
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Attribute(attr=name):
                names.append(name)
            case ast.ImportFrom(module=module, names=aliases):
                names += [*(module or "").split("."), *(alias.name for alias in aliases)]
            case ast.Import(names=aliases):
                names += [part for alias in aliases for part in alias.name.split(".")]
    return names


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*_ja.ipynb")), ids=lambda path: path.stem)
def test_a_japanese_notebook_has_the_cells_of_its_english_twin(path: Path) -> None:
    """The same code, and a text for each text, with as many exercises."""
    twin = path.with_stem(path.stem.removesuffix("_ja"))
    here, there = (nbformat.read(one, as_version=4).cells for one in (path, twin))
    assert [cell.cell_type for cell in here] == [cell.cell_type for cell in there]
    for own, other in zip(here, there, strict=True):
        if own.cell_type == "code":
            assert own.source == other.source
        else:
            assert re.search("[ぁ-ん]", own.source)
            assert own.source.count("**") == other.source.count("**")


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_uses_public_names_and_no_clock(path: Path) -> None:
    names = names_used(path)
    assert not [name for name in names if re.match(r"_(?!_)", name)]
    assert not {"time", "timeit", "datetime", "perf_counter"}.intersection(names)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_shows_formulas_and_pictures(path: Path) -> None:
    media = [kind for cell in shown(nbformat.read(path, as_version=4)) for kind, _ in cell]
    assert {"image/svg+xml", "text/latex"} <= set(media)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_picture_of_a_notebook_names_its_axes(path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    pictures = [o.data["image/svg+xml"] for o in outputs if "image/svg+xml" in o.get("data", {})]
    for number, picture in enumerate(pictures):
        text = "".join(picture)
        units = re.findall(r"\[[^\]<>]+\]", text)
        assert units, f"picture {number}: no axis has a unit, e.g. 'x [m]'"
