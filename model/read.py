"""Read scenes: TOML text, or the same tree from Python, becomes a checked :class:`Scene`."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import msgspec

from kousoku.model.errors import SceneError
from kousoku.model.scene import Scene


def read_scene(path: str | Path) -> Scene:
    """Read and check a scene file.

    Parameters
    ----------
    path : str or Path
        A TOML file in the format of ``docs/scenes.md``.

    Raises
    ------
    SceneError
        The file cannot be read, is not TOML, or does not describe a linkage that can be solved;
        the message names the file, the key, the reason and what was wanted.
    """
    file = str(path)
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError, ValueError) as error:
        raise SceneError(f"cannot be read: {error}", file=file) from error
    return scene_from_toml(text, file=file)


def scene_from_toml(text: str, *, file: str = "") -> Scene:
    """Read and check the text of a scene file; `file` is what messages name."""
    try:
        tree = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise SceneError(f"is not valid TOML: {error}", file=file) from error
    return scene_from_dict(tree, file=file)


def scene_from_dict(tree: dict[str, Any], *, file: str = "") -> Scene:
    """Check a tree of tables, as :func:`tomllib.loads` gives it."""
    try:
        return msgspec.convert(tree, Scene)
    except msgspec.ValidationError as error:
        problem, _, place = str(error).partition(" - at ")
        raise SceneError(problem, file=file, key=re.sub(r"[`$]\.?", "", place)) from error
