"""Generated files: read and compared with their manifest, and taken along where a solver travels.

A pickled solver has them, and another machine writes and loads them.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kousoku.model.errors import CacheError, LoadError, printable
from kousoku.model.files.compressed import content, stored
from kousoku.model.files.manifest import (
    LINKAGE_LIBRARY,
    MANIFEST_FILE,
    MOTION_FILE,
    PLAIN,
    Manifest,
)
from kousoku.runtime.messages import shown

if TYPE_CHECKING:
    import types
    from collections.abc import Mapping


@dataclass(frozen=True, slots=True)
class Sources:
    """The files of a generated package.

    Parameters
    ----------
    folder : Path
        Folder that they were read from.
    manifest : Manifest
        What the package promises.
    files : mapping of str to bytes
        Name and content of each, compared with the manifest.
    """

    folder: Path
    manifest: Manifest
    files: Mapping[str, bytes]

    @classmethod
    def read(cls, folder: str | Path) -> Sources:
        """Sources of a folder, as they lie there.

        Raises
        ------
        LoadError
            It is no generated package, or a file of it is missing, edited or damaged.
        """
        folder = folder_of(folder)
        manifest = read_manifest(folder)
        return cls(folder, manifest, read_files(folder, manifest))

    @property
    def is_scene(self) -> bool:
        """Whether the files are the solver of a scene, and not a kind."""
        return MOTION_FILE in self.files

    @property
    def is_linkage(self) -> bool:
        """Whether the files are the solver of a linkage of nodes, by their names."""
        library = f"{LINKAGE_LIBRARY}/"
        return self.is_scene and any(name.startswith(library) for name in self.files)

    @property
    def data(self) -> dict[str, Any]:
        """Data of ``motion.json`` on the scene, empty where there is none."""
        data: dict[str, Any] = json.loads(self.files.get(MOTION_FILE, "{}"))
        return data

    def module(self, name: str) -> types.ModuleType:
        """Module of the package, such as ``solver.py``, that was emitted with the manifest.

        Raises
        ------
        LoadError
            The digest in the module is another one.
        """
        from kousoku.runtime.importing import import_source

        stated, folder = self.manifest, self.folder
        module = import_source(folder, self.files, name)
        digest = getattr(module, "DIGEST", None)
        if digest != stated.digest:
            raise LoadError(
                f"{folder / name} has the digest {digest}, the manifest beside it {stated.digest}:"
                f" they are of two packages\n{regenerated(stated)}"
            )
        return module

    def __reduce__(self) -> tuple[Any, ...]:
        return Sources, (self.folder, self.manifest, dict(self.files))

    def place(self) -> Path:
        """Folder with the files: the one they were read from, or one in the cache.

        Raises
        ------
        CacheError
            They are gone from where they lay, and cannot be written to the cache.
        """
        import hashlib

        from kousoku.model.files.cache import cache_folder, write_atomically

        if self._lie_in(self.folder):
            return self.folder
        text = self.manifest.to_json()
        key = hashlib.sha256(text.encode()).hexdigest()[:32]
        try:
            folder = cache_folder() / "sources" / key / self.manifest.package
            if not self._lie_in(folder):
                for name, data in self.files.items():
                    write_atomically(folder / name, stored(name, data.decode()))
                write_atomically(folder / MANIFEST_FILE, text.encode())
        except OSError as error:
            raise CacheError(
                f"{self.manifest.package}: {self.folder} no longer has its files, and the cache"
                f" cannot be written: {error.strerror or error}"
            ) from error
        return folder

    def placed(self) -> Sources:
        """Sources in a folder that has them, see :meth:`place`."""
        return replace(self, folder=self.place())

    def _lie_in(self, folder: Path) -> bool:
        try:
            return Sources.read(folder).manifest == self.manifest
        except LoadError:
            return False


def folder_of(path: object) -> Path:
    """Absolute path of a folder.

    Raises
    ------
    LoadError
        What is given is no path.
    """
    if not isinstance(path, str | os.PathLike):
        raise LoadError(f"{shown(path)} is no folder; wanted the path of one")
    if "\0" in str(path):
        raise LoadError(f"{shown(path)} is not the name of a folder: it has a null character")
    return Path(path).absolute()


def read_manifest(folder: Path) -> Manifest:
    """Manifest of a folder.

    Raises
    ------
    LoadError
        There is none, it cannot be read, or it was edited: its digest, which the sources name too,
        is over what it says.
    """
    path = folder / MANIFEST_FILE
    try:
        text = path.read_bytes().decode()
        manifest = Manifest.from_json(text)
        is_as_written = manifest.to_json() == text and manifest.stated() == manifest.digest
    except OSError as error:
        raise LoadError(f"{folder} is not a generated package: {error}") from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise LoadError(
            f"{path} is not a manifest of this version of kousoku: {shown(error)}"
        ) from None
    if not is_as_written:
        raise LoadError(
            f"{path} was edited: its digest is not over what it says\n{regenerated(manifest)}"
        )
    return manifest


def read_files(folder: Path, manifest: Manifest) -> dict[str, bytes]:
    """Files that a manifest lists, with what they hold, each compared with its digest.

    Raises
    ------
    LoadError
        Files are missing, edited or damaged; the message names each.
    """
    import hashlib

    files: dict[str, bytes] = {}
    problems = []
    for name, digest in manifest.files:
        if PLAIN.fullmatch(name) is None:
            raise LoadError(
                f"{folder / MANIFEST_FILE} lists {shown(name)}, which is not a plain file name"
            )
        try:
            files[name] = content(name, (folder / name).read_bytes())
        except OSError as error:
            problems.append(f"{folder / name} is missing ({error.strerror})")
            continue
        except ValueError as error:
            problems.append(f"{folder / name} is damaged: {error}")
            continue
        if hashlib.sha256(files[name]).hexdigest() != digest:
            problems.append(f"{folder / name} was edited: its SHA-256 is not the manifest's")
    if problems:
        raise LoadError("\n".join([*problems, regenerated(manifest)]))
    return files


def regenerated(manifest: Manifest) -> str:
    """Line that says by what command a package is generated again."""
    command = printable(str(manifest.regenerate))
    shortened = command if len(command) <= 200 else f"{command[:200]} …"
    return f"generate the package again: {shortened}"
