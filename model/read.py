"""Read scenes: TOML text, or the same tree from Python, becomes a checked :class:`Scene`."""

from __future__ import annotations

import tomllib
from pathlib import Path

from kousoku.model.decode import decode
from kousoku.model.errors import SceneError
from kousoku.model.scene import Scene
from kousoku.model.validate import check

LARGEST_FILE = 4 * 2**20
"""Bytes of the largest scene file that is read."""


def read_scene(path: str | Path) -> Scene:
    """Read and check a scene file.

    Parameters
    ----------
    path : str or Path
        A TOML file in the format of ``docs/scenes.md``.

    Raises
    ------
    SceneError
        The file cannot be read, is not TOML, or does not describe a mechanism that can be solved;
        the message names the file, the key, the reason and what was wanted.
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
        raise SceneError(f"cannot be read: {error.strerror}", file=file) from error
    except ValueError as error:
        raise SceneError(f"is not the name of a file: {error}", file=repr(file)) from error
    if len(data) > LARGEST_FILE:
        limit = LARGEST_FILE // 2**20
        raise SceneError(f"is too large: a scene file has at most {limit} MiB", file=file)
    return scene_from_toml(text, file=file)


def scene_from_toml(text: str, *, file: str = "") -> Scene:
    """Read and check the text of a scene file.

    Parameters
    ----------
    text : str
        TOML.
    file : str
        The file that messages name.
    """
    try:
        tree = tomllib.loads(text)
    except RecursionError:
        raise SceneError("is not a scene: its tables are nested too deeply", file=file) from None
    except ValueError as error:
        raise SceneError(f"is not valid TOML: {error}", file=file) from error
    return scene_from_dict(tree, file=file)


def scene_from_dict(tree: object, *, file: str = "") -> Scene:
    """Check a tree of tables, as :func:`tomllib.loads` gives it.

    Parameters
    ----------
    tree : object
        The tables of a scene; whatever is not a mapping of the right shape is refused.
    file : str
        The file that messages name.
    """
    try:
        scene = decode(tree, Scene)
        check(scene)
    except SceneError as error:
        raise SceneError(error.problem, file=file, key=error.key) from error.__cause__
    return scene
