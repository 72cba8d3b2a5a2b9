"""Places that scenes come from, and that their solvers go to."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kousoku.cli.console import checkout, generated_folder

if TYPE_CHECKING:
    from pathlib import Path


def committed_scenes() -> list[Path]:
    """Scene files of a checkout whose solvers are committed."""
    root = checkout()
    if root is None:
        return []
    scenes = sorted((root / "scenes").glob("*.toml"))
    return [path for path in scenes if (generated_folder() / path.stem).is_dir()]


def scene_folder(name: str) -> Path:
    """Default folder of a scene's solver: where it is committed, or the user's cache."""
    from kousoku.model.files.cache import cache_folder

    committed = generated_folder() / name
    if checkout() is not None and committed.is_dir():
        return committed
    return cache_folder() / "generated" / name
