"""Where scenes come from, and where their solvers go."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from kousoku.cli.console import Target, checkout, generated_folder
from kousoku.model.errors import SceneError
from kousoku.model.read import read_scene

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kousoku.model.scene import Scene
    from kousoku.runtime.linkage import LinkageSolver


def read_planar_scene(path: Path) -> Scene:
    """Read and check a scene file that a solver can be generated from.

    Raises
    ------
    SceneError
        The file is not a valid scene, or one with bodies in space.
    """
    scene = read_scene(path)
    if scene.is_spatial:
        raise SceneError(
            "is a valid spatial scene, but solvers are generated for planar linkages only",
            file=str(path),
            key="bodies" if scene.bodies else "joints",
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


def solver_of(scene: Scene, target: Target) -> LinkageSolver:
    """Return the loaded solver of a scene, from the committed package where that is the same."""
    from kousoku.codegen.generate import check_tree, write_tree
    from kousoku.codegen.linkage import generate_scene
    from kousoku.model.cache import cache_folder
    from kousoku.runtime.linkage import load_scene

    tree = generate_scene(scene)
    committed = generated_folder() / scene.name
    if committed.is_dir() and not check_tree(committed, tree):
        return load_scene(committed, target=target.value)
    try:
        folder = cache_folder() / "scenes" / _digest(tree) / scene.name
        write_tree(folder, tree)
        return load_scene(folder, target=target.value)
    except OSError:  # a full or read-only cache: the folder is needed only until it is loaded
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place) / scene.name
            write_tree(folder, tree)
            return load_scene(folder, target=target.value)


def _digest(tree: Mapping[str, str]) -> str:
    import hashlib

    return hashlib.sha256("\0".join(tree.values()).encode()).hexdigest()[:32]
