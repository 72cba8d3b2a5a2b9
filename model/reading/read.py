"""Read scenes: TOML text, or the same tree from Python, becomes a checked :class:`Scene`."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from kousoku.model.errors import AssemblyError, Problem, SceneError
from kousoku.model.expressions.design_numbers import read_formulas
from kousoku.model.reading.decode import decode_parts
from kousoku.model.reading.lines import deep_key_line, each_key_line
from kousoku.model.reading.not_toml import toml_problem
from kousoku.model.records.dotted_keys import dotted
from kousoku.model.records.own_kind import OwnKinds
from kousoku.model.records.problems import Problems
from kousoku.model.records.scene import Scene
from kousoku.model.text import nearest
from kousoku.model.validation.validate import check_parts

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kousoku.model.records.own_kind import OwnKind

LARGEST_FILE = 8 * 2**20
"""Bytes of the largest scene file that is read."""


DEEPEST_KEY = 32
"""Parts of the longest key; a parser takes hours for one of a hundred thousand."""


def read_scene(path: str | Path, *, kinds: Mapping[str, OwnKind] | None = None) -> Scene:
    """Read and check a scene file.

    Parameters
    ----------
    path : str or Path
        A TOML file in the format of ``docs/scenes.md``.
    kinds : mapping of str to OwnKind, optional
        Kinds of one's own that joints may be of, by name.

    Raises
    ------
    SceneError
        The file cannot be read, is not TOML, or does not describe a mechanism that can be solved;
        the message names the file, the key, the reason and what was wanted.
    """
    return scene_from_toml(scene_text(path), file=str(path), kinds=kinds)


def scene_text(path: str | Path) -> str:
    """Text of a scene file.

    Raises
    ------
    SceneError
        It cannot be read, is too large, or is no text.
    """
    file = str(path)
    try:
        with Path(path).open("rb") as stream:
            data = stream.read(LARGEST_FILE + 1)
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise SceneError(f"is not UTF-8 text (at line {line})", file=file) from None
    except OSError as error:
        raise SceneError(
            f"cannot be read: {error.strerror}{_near_scene(path)}", file=file
        ) from error
    except ValueError as error:
        raise SceneError(f"is not the name of a file: {error}", file=repr(file)) from error
    if len(data) > LARGEST_FILE:
        limit = LARGEST_FILE // 2**20
        raise SceneError(f"is too large: a scene file has at most {limit} MiB", file=file)
    return text


def _near_scene(path: str | Path) -> str:
    """Question for the scene file in the folder whose name is nearest, if there is one."""
    path = Path(path)
    try:
        scenes = [] if path.exists() else [file.name for file in path.parent.glob("*.toml")]
    except OSError:
        return ""
    near = nearest(path.name, scenes)
    return f"; did you mean {str(path.with_name(near))!r}?" if near else ""


def scene_from_toml(
    text: str, *, file: str = "", kinds: Mapping[str, OwnKind] | None = None
) -> Scene:
    """Read and check the text of a scene file.

    Parameters
    ----------
    text : str
        TOML.
    file : str
        The file that messages name.
    kinds : mapping of str to OwnKind, optional
        Kinds of one's own that joints may be of, by name.
    """
    if line := deep_key_line(text, DEEPEST_KEY):
        problem = Problem(f"has a key of more than {DEEPEST_KEY} parts", line=line)
        raise SceneError.of([problem], file=file)
    try:
        tree = tomllib.loads(text)
    except RecursionError:
        raise SceneError("is not a scene: its tables are nested too deeply", file=file) from None
    except ValueError as error:
        raise SceneError.of([toml_problem(error, text)], file=file) from error
    return _checked_scene(tree, text, file, kinds)


def scene_from_dict(
    tree: object, *, file: str = "", kinds: Mapping[str, OwnKind] | None = None
) -> Scene:
    """Check a tree of tables, as :func:`tomllib.loads` gives it.

    Parameters
    ----------
    tree : object
        The tables of a scene; whatever is not a mapping of the right shape is refused. NumPy's
        numbers and arrays, and SymPy's with its expressions, stand for Python's.
    file : str
        The file that messages name.
    kinds : mapping of str to OwnKind, optional
        Kinds of one's own that joints may be of, by name.

    Raises
    ------
    SceneError
        All problems that are found, each with its dotted key.
    """
    return _checked_scene(tree, "", file, kinds)


def located(error: SceneError | AssemblyError, path: str | Path) -> SceneError | AssemblyError:
    """Error of a scene that was read, with the name of its file and the lines.

    Parameters
    ----------
    error : SceneError or AssemblyError
        The problems that were found in the scene after it was read.
    path : str or Path
        The file that it was read from.
    """
    if isinstance(error, SceneError) and error.file:
        return error
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (OSError, ValueError):  # it is gone, or no longer a text
        text = ""
    if isinstance(error, SceneError):
        return SceneError.of(_with_lines(error.problems, text), file=str(path))
    lines = _key_lines(text)
    inputs = {f"drivers.{key[7:]}": lines[key] for key in lines if key.startswith("inputs.")}
    return error.at(str(path), inputs | lines)


def _checked_scene(
    tree: object, text: str, file: str, kinds: Mapping[str, OwnKind] | None
) -> Scene:
    problems = Problems({**_written_kinds(tree), **(kinds or {})})
    try:
        scene = decode_parts(tree, Scene, {"name": "unnamed", "unit": "m"}, problems)
    except SceneError as error:
        raise SceneError.of(error.problems, file=file) from None
    assert isinstance(tree, Mapping)  # else nothing could be decoded
    types = {joint.type for joint in scene.joints.values()}
    own_kinds = {name: kind for name, kind in problems.kinds.items() if name in types}
    scene = msgspec.structs.replace(scene, kinds=own_kinds)
    if problems.has_formulas:
        scene = read_formulas(scene, problems)
    check_parts(scene, problems, list(tree))
    if problems.found:
        raise SceneError.of(_with_lines(problems.found, text), file=file)
    return scene


def _written_kinds(tree: object) -> dict[str, OwnKind]:
    """Kinds of one's own in the table ``kinds``, which the text of a mechanism has.

    Problems with them are found where the scene is decoded.
    """
    if not isinstance(tree, Mapping) or "kinds" not in tree:
        return {}
    return dict(decode_parts({"kinds": tree["kinds"]}, OwnKinds, {}, Problems()).kinds)


def _with_lines(problems: Sequence[Problem], text: str) -> Sequence[Problem]:
    """Problems with their lines, in the order of the text; problems of the whole file come first.

    A key that is not written has the line of the table around it.
    """
    if not text:
        return problems
    lines = _key_lines(text, [problem.place or problem.key for problem in problems])
    located_problems = [
        replace(problem, line=_nearest_line(lines, problem.place or problem.key))
        for problem in problems
    ]
    return sorted(located_problems, key=lambda problem: problem.line)


def _key_lines(text: str, wanted: Sequence[str] = ()) -> dict[str, int]:
    """Line of each dotted key; if keys are wanted, of the text up to the last of them."""
    lines: dict[str, int] = {}
    missing = set(wanted)
    for path, line in each_key_line(text):
        key = dotted(path)
        lines.setdefault(key, line)
        if key in missing:
            missing.remove(key)
            if not missing:
                break
    return lines


def _nearest_line(lines: Mapping[str, int], key: str) -> int:
    """Line of a key, or of the nearest table around it that stands in the file."""
    while key and key not in lines:
        key = key[: max(key.rfind("."), key.rfind("["), 0)]
    return lines.get(key, 0)
