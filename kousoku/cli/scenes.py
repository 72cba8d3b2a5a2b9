"""Where scenes come from, and where their solvers go."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.cli.console import checkout, generated_folder
from kousoku.model.errors import SceneError
from kousoku.model.read import read_scene

if TYPE_CHECKING:
    from pathlib import Path

    from kousoku.model.scene import Scene


def read_spatial_scene(path: Path) -> Scene:
    """Read and check a scene file of bodies.

    Raises
    ------
    SceneError
        The file is not a valid scene, or a planar linkage.
    """
    scene = read_scene(path)
    if not scene.is_spatial:
        raise SceneError(
            "is a linkage whose inputs are prescribed; wanted bodies and joints, or: kousoku solve",
            file=str(path),
            key="nodes",
        )
    return scene


def committed_scenes() -> list[Path]:
    """Return the scene files of a checkout whose solvers are committed."""
    root = checkout()
    if root is None:
        return []
    scenes = sorted((root / "scenes").glob("*.toml"))
    return [path for path in scenes if (generated_folder() / path.stem).is_dir()]


def scene_folder(name: str) -> Path:
    """Return where a scene's solver goes by default: where it is committed, or the user's cache."""
    from kousoku.model.cache import cache_folder

    committed = generated_folder() / name
    if checkout() is not None and committed.is_dir():
        return committed
    return cache_folder() / "generated" / name
