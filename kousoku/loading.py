"""Load a mechanism: its solver is generated and compiled once, and found by content ever after."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING

from kousoku.mechanism import Mechanism
from kousoku.model import version
from kousoku.model.errors import (
    AssemblyError,
    CacheError,
    CompilerError,
    LoadError,
    SceneError,
    TargetError,
)
from kousoku.model.files.cache import cache_folder, shrink, size_limit, touch, write_atomically
from kousoku.model.files.manifest import MANIFEST_FILE
from kousoku.own_kinds import own_kinds
from kousoku.progress import status_line
from kousoku.runtime.messages import shown
from kousoku.runtime.solver import load_solver

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from typing import Any

    from kousoku.model.reading.builder import SceneBuilder
    from kousoku.model.records.own_kind import OwnKind
    from kousoku.model.records.scene import Output, Scene
    from kousoku.own_kinds import Kind
    from kousoku.runtime.choice import Target
    from kousoku.runtime.solver import Solver

#: Parts of kousoku that decide what is generated.
SOURCES = ("codegen", "generated", "model", "runtime", "symbolic")
#: The text of a scene, beside the folder of its solver.
SCENE_FILE = "scene.toml"


def load(
    scene: str | Path | Mapping[str, Any] | Scene | SceneBuilder,
    *,
    outputs: Sequence[Output] | None = None,
    target: Target = "auto",
    kinds: Sequence[Kind] | None = None,
) -> Mechanism:
    """Load a mechanism: a linkage of nodes or a scene of bodies, with its solver.

    A solver is generated and compiled the first time, which takes about a second; it is found in
    the cache from then on, by the content of the scene.

    Parameters
    ----------
    scene : path, str, mapping, Scene or SceneBuilder
        A scene file, its text in TOML, its tables as :func:`tomllib.loads` gives them, or what was
        built.
    outputs : sequence of str, optional
        What to compute beside positions and velocities, such as ``"coordinates"``,
        ``"accelerations"``, ``"reactions"``, ``"energies"``; what the scene says unless given.
    target : {"auto", "c", "numpy"}
        What computes: C where a compiler can be had, else NumPy after saying so in one line.
    kinds : sequence of Derivation, Library or path, optional
        Kinds of one's own that are types of its joints: what :func:`kousoku.derive` or
        :func:`kousoku.kernels` gave, or a folder of kernels.

    Raises
    ------
    SceneError
        The scene is not valid; the message has all problems with their lines.
    AssemblyError
        Its bodies do not fit together near the positions that it gives.
    CompilerError
        The compiler refuses the source; with ``target="c"`` also if there is none.
    DerivationError
        One of the kinds is no constraint between two bodies, or its proof fails.

    Examples
    --------
    >>> import kousoku as ks
    >>> loop = ks.load("scenes/loop_free.toml")
    >>> run = loop.simulate(2, parameters={"mass": 2})
    """
    given = GivenScene.of(scene, own_kinds(kinds))
    chosen = None if outputs is None else _outputs_of(outputs)
    solver, text = opened(given, chosen, target)
    return Mechanism(solver, text, given.file, chosen)


@dataclass(frozen=True, slots=True)
class GivenScene:
    """A scene as it was given.

    Parameters
    ----------
    file : str
        The file that it was read from, empty where it is none.
    data : bytes
        Its content, by which the cache finds it.
    read : callable
        Returns the checked scene.
    """

    file: str
    data: bytes
    read: Callable[[], Scene]

    @classmethod
    def of(cls, scene: object, kinds: Mapping[str, OwnKind] | None = None) -> GivenScene:
        """Scene as it was given, not yet read.

        Parameters
        ----------
        scene : object
            What :func:`load` takes.
        kinds : mapping of str to OwnKind, optional
            Kinds of one's own that its joints may be of.

        Raises
        ------
        SceneError
            The file cannot be read, or what is given is no scene.
        """
        from kousoku.model.records.scene import Scene

        if hasattr(scene, "build"):
            scene = scene.build(kinds=kinds) if kinds else scene.build()
        if isinstance(scene, Scene):
            if kinds:
                from kousoku.model.reading.read import scene_from_toml

                scene = scene_from_toml(_text(scene), kinds=kinds)
            return cls("", _text(scene).encode(), partial(_checked, scene))
        if isinstance(scene, str) and ("\n" in scene or ("=" in scene and not _is_path(scene))):
            from kousoku.model.reading.read import scene_from_toml

            return cls("", _signature(scene, kinds), partial(scene_from_toml, scene, kinds=kinds))
        if isinstance(scene, str) and not scene.strip():
            raise SceneError(f"{scene!r} is no scene; wanted the path of a scene file, or its text")
        if isinstance(scene, str | os.PathLike):
            return cls._of_file(Path(scene), kinds)
        if hasattr(scene, "items"):
            from kousoku.model.reading.read import scene_from_dict

            built = scene_from_dict(scene, kinds=kinds)
            return cls("", _text(built).encode(), lambda: built)
        raise SceneError(
            f"{shown(scene)} is no scene; wanted the path of a scene file, its text, its tables, or"
            " what SceneBuilder builds"
        )

    @classmethod
    def _of_file(cls, path: Path, kinds: Mapping[str, OwnKind] | None) -> GivenScene:
        from kousoku.model.reading.read import scene_from_toml, scene_text

        with suppress(OSError):  # a name that is too long is refused where it is read
            if path.is_dir():
                raise SceneError("is a folder; wanted a scene file", file=str(path))
        text = scene_text(path)
        read = partial(scene_from_toml, text, file=str(path), kinds=kinds)
        return cls(str(path), _signature(text, kinds), read)


def _signature(text: str, kinds: Mapping[str, OwnKind] | None) -> bytes:
    """Content of a scene for the cache: its text, and the kinds of one's own that it may have."""
    names = [kind.kernels for kind in (kinds or {}).values()]
    return "\n".join([text, *(f"#kind {name}" for name in names)]).encode()


def _is_path(line: str) -> bool:
    """Whether a line names a file, such as ``mass=2.toml``, and is not TOML itself."""
    with suppress(OSError, ValueError):
        return line.endswith(".toml") or Path(line).exists()
    return False


def opened(given: GivenScene, outputs: Sequence[str] | None, target: Target) -> tuple[Solver, str]:
    """Solver of a scene, out of the cache or newly generated, and the scene's text.

    Raises
    ------
    SceneError, AssemblyError, CompilerError
        As of :func:`load`; the message names the file.
    """
    for is_last in (False, True):
        with cached_solver_folder(given, outputs, anew=is_last) as folder:
            try:
                text = (folder.parent / SCENE_FILE).read_text(encoding="utf-8")
                with status_line() as tell:
                    tell(f"compiling {folder.name}")
                    return load_solver(folder, target=target), text
            except OSError as error:  # somebody cleared the cache: once more
                if is_last:
                    reason = f"{folder} cannot be loaded: {error.strerror or error}"
                    raise CacheError(f"{reason}; load it again") from None
            except LoadError as error:  # the cache was damaged: once more, unless that is no cure
                if is_last or isinstance(error, (CompilerError, CacheError, TargetError)):
                    raise
    raise AssertionError


@contextmanager
def cached_solver_folder(
    given: GivenScene,
    outputs: Sequence[str] | None = None,
    *,
    references: bool = False,
    anew: bool = False,
) -> Iterator[Path]:
    """Folder of a scene's solver while it is open, in the cache or generated now.

    Parameters
    ----------
    given : GivenScene
        The scene.
    outputs : sequence of str, optional
        What is computed; what the scene says unless given.
    references : bool
        Whether it has the reference values that ``verify`` compares with.
    anew : bool
        Whether it is generated also if it is there.

    Raises
    ------
    SceneError, AssemblyError
        As of :func:`load`; the message names the file.
    CacheError
        Neither the cache nor a temporary folder can be written, or nobody can tell how large the
        cache may get.
    """
    limit = size_limit()
    options = json.dumps([outputs, references])
    by_bytes = cache_key(given.data, options)
    folder = None if anew else _cached_solver(_noted_key(by_bytes), options)
    if folder is not None:
        yield folder
        return
    with status_line() as tell, naming(given.file):
        tell(f"reading {given.file or 'the scene'}")
        scene = given.read()
        text = _text(scene)
        key = cache_key(text, options)
        folder = None if anew else _cached_solver(key, options)
        if folder is None:
            tell(f"generating {scene.name}")
            tree = generated(scene, outputs, references=references)
    if folder is not None:
        _note_key(by_bytes, key)
        yield folder
        return
    try:
        folder = _written(cache_folder() / "scenes" / key, scene.name, text, tree)
    except OSError as error:  # a full or read-only cache: it is needed only until it is loaded
        with ExitStack() as stack:
            try:
                temporary = stack.enter_context(tempfile.TemporaryDirectory())
                folder = _written(Path(temporary), scene.name, text, tree)
            except OSError as other:
                raise CacheError(
                    f"{scene.name}: cannot write the cache: {error}; nor a temporary folder:"
                    f" {other.strerror or other}; free some space or set KOUSOKU_CACHE to a folder"
                    " that can be written"
                ) from None
            yield folder
            return
    _note_key(by_bytes, key)
    yield folder
    with suppress(OSError):
        shrink(limit)


def generated(
    scene: Scene, outputs: Sequence[str] | None = None, *, references: bool = False
) -> dict[str, str]:
    """Folder of a scene's solver, file name and text.

    Raises
    ------
    SceneError, AssemblyError
        As of :func:`load`.
    """
    from kousoku.model.validation.unused import output_problem

    for output in outputs or ():
        if problem := output_problem(scene, output):
            raise SceneError(f"outputs: {output}: {problem}")
    if scene.is_spatial:
        from kousoku.codegen.dynamics.generate import generate_dynamics

        return generate_dynamics(scene, outputs, references=references)
    import msgspec

    from kousoku.codegen.linkage.generate import generate_linkage

    reduced = scene if outputs is None else msgspec.structs.replace(scene, outputs=tuple(outputs))
    return generate_linkage(reduced, references=references)


def _written(shelf: Path, name: str, text: str, tree: Mapping[str, str]) -> Path:
    """Write a solver, then the text of its scene: with it the folder is complete."""
    from kousoku.codegen.generate import write_tree

    write_tree(shelf / name, tree)
    write_atomically(shelf / SCENE_FILE, text.encode())
    return shelf / name


def _cached_solver(key: str, options: str) -> Path | None:
    """Folder of the solver that the cache holds under a key, with its own scene."""
    try:
        shelf = cache_folder() / "scenes" / key
        if not key or cache_key((shelf / SCENE_FILE).read_bytes(), options) != key:
            return None
        folder = next((path.parent for path in shelf.glob(f"*/{MANIFEST_FILE}")), None)
    except OSError:
        return None
    touch(shelf)
    return folder


@cache
def stamp() -> str:
    """Digest of kousoku itself: its version, and names, sizes and times of its files.

    In a checkout the version stays while the generator changes.
    """
    entries = [version.__version__]
    root = Path(version.__file__).parents[1]  # of all sub-packages, installed or not
    for source_root in (root / part for part in SOURCES):
        for folder, subfolders, names in os.walk(source_root):
            subfolders[:] = sorted(name for name in subfolders if name != "__pycache__")
            for name in sorted(names):
                with suppress(OSError):
                    status = (Path(folder) / name).stat()
                    entries.append(f"{name} {status.st_size} {status.st_mtime_ns}")
    return hashlib.sha256("\n".join(entries).encode()).hexdigest()


def cache_key(*parts: str | bytes) -> str:
    """Key of the files that this kousoku makes of some parts."""
    digest = hashlib.sha256(stamp().encode())
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        digest.update(b"%d " % len(data))
        digest.update(data)
    return digest.hexdigest()[:32]


def _note_key(digest: str, key: str) -> None:
    """Note the key of the scene with the content of a digest."""
    with suppress(OSError):
        write_atomically(cache_folder() / "found" / digest, key.encode())


def _noted_key(digest: str) -> str:
    """Noted key of the scene with the content of a digest, empty if there is none."""
    try:
        path = cache_folder() / "found" / digest
        key = path.read_text(encoding="ascii")
    except (OSError, ValueError):
        return ""
    touch(path)
    return key


def _checked(scene: Scene) -> Scene:
    """Scene that was put together by hand, when it is read: it may not have been checked."""
    from kousoku.model.validation.validate import check

    check(scene)
    return scene


def _text(scene: Scene) -> str:
    from kousoku.model.reading.write import to_toml

    return to_toml(scene)


def _outputs_of(outputs: object) -> list[str]:
    """Names of outputs as a list, also of a single name."""
    if isinstance(outputs, str):
        return [outputs]
    if isinstance(outputs, list | tuple) and all(isinstance(name, str) for name in outputs):
        return list(outputs)
    raise SceneError(f"outputs {shown(outputs)}; wanted a list of names such as 'reactions'")


@contextmanager
def naming(file: str | Path) -> Iterator[None]:
    """Name the file, and the lines, of problems that are found in a scene after it was read.

    Raises
    ------
    SceneError, AssemblyError
        As they were, but for that.
    """
    try:
        yield
    except (SceneError, AssemblyError) as error:
        from kousoku.model.reading.read import located

        raise (located(error, file) if file else error) from None
