"""Where scenes come from, and where their solvers go."""

from __future__ import annotations

import tempfile
import time
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from kousoku.cli.console import Target, checkout, generated_folder
from kousoku.model.errors import AssemblyError, SceneError
from kousoku.model.read import located, read_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from kousoku.model.scene import Scene
    from kousoku.runtime.dynamics import DynamicsSolver
    from kousoku.runtime.linkage import LinkageSolver

Solver = TypeVar("Solver")


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


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Name the file, and the lines, of what is found wrong with a scene after it was read.

    Raises
    ------
    SceneError, AssemblyError
        As they were, but for that.
    """
    try:
        yield
    except (SceneError, AssemblyError) as error:
        raise located(error, path) from None


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


def as_committed(tree: dict[str, str]) -> dict[str, str]:
    """Return a package as it is committed: ``lanes.h`` stands once, in the runtime beside it."""
    from kousoku.codegen.generate import without
    from kousoku.runtime.library import LANES

    return without(tree, LANES.name)


def solver_of(scene: Scene, target: Target) -> LinkageSolver:
    """Return the loaded solver of a scene, from the committed package where that is the same."""
    from kousoku.codegen.linkage import generate_scene
    from kousoku.runtime.linkage import load_scene

    return _loaded(scene, generate_scene(scene), partial(load_scene, target=target.value))


def dynamics_of(
    scene: Scene, target: Target, outputs: Sequence[str] | None = None
) -> tuple[DynamicsSolver, dict[str, float]]:
    """Return the loaded solver of a scene of bodies, and what each phase took, in seconds."""
    from kousoku.codegen.dynamics.generate import generate_dynamics
    from kousoku.runtime.dynamics import load_dynamics

    begin = time.perf_counter()
    tree = generate_dynamics(scene, outputs)
    middle = time.perf_counter()
    solver = _loaded(scene, tree, partial(load_dynamics, target=target.value))
    return solver, {"generate": middle - begin, "compile and load": time.perf_counter() - middle}


def _loaded(scene: Scene, tree: dict[str, str], load: Callable[[Path], Solver]) -> Solver:
    """Load a scene's files from where they are committed, or from the cache."""
    from kousoku.codegen.generate import check_tree, write_tree
    from kousoku.model.cache import cache_folder

    committed = generated_folder() / scene.name
    if committed.is_dir() and not check_tree(committed, as_committed(tree)):
        return load(committed)
    try:
        folder = cache_folder() / "scenes" / _digest(tree) / scene.name
        write_tree(folder, tree)
        return load(folder)
    except OSError:  # a full or read-only cache: the folder is needed only until it is loaded
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place) / scene.name
            write_tree(folder, tree)
            return load(folder)


def _digest(tree: Mapping[str, str]) -> str:
    import hashlib

    return hashlib.sha256("\0".join(tree.values()).encode()).hexdigest()[:32]
