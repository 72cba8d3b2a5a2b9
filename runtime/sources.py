"""Generated files that travel: a pickled solver has them, another machine writes and loads them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from kousoku.model.compressed import stored
from kousoku.model.errors import CacheError, LoadError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from kousoku.model.manifest import Manifest


@dataclass(frozen=True, slots=True)
class Sources:
    """The files of a generated package.

    Parameters
    ----------
    folder : Path
        Where they lay.
    manifest : Manifest
        What the package promises.
    files : mapping of str to bytes
        Name and content of each, compared with the manifest.
    """

    folder: Path
    manifest: Manifest
    files: Mapping[str, bytes]

    def __reduce__(self) -> tuple[Any, ...]:
        return Sources, (self.folder, self.manifest, dict(self.files))

    def place(self) -> Path:
        """Folder that has them: where they lay, or one in the cache.

        Raises
        ------
        CacheError
            They are gone from where they lay, and cannot be written to the cache.
        """
        import hashlib

        from kousoku.model.cache import cache_folder, write_atomically

        if self._lie_in(self.folder):
            return self.folder
        text = self.manifest.to_json()
        key = hashlib.sha256(text.encode()).hexdigest()[:32]
        try:
            folder = cache_folder() / "sources" / key / self.manifest.package
            if not self._lie_in(folder):
                for name, data in self.files.items():
                    write_atomically(folder / name, stored(name, data.decode()))
                write_atomically(folder / "manifest.json", text.encode())
        except OSError as error:
            raise CacheError(
                f"{self.manifest.package}: {self.folder} no longer has its files, and the cache"
                f" cannot be written: {error.strerror or error}"
            ) from error
        return folder

    def _lie_in(self, folder: Path) -> bool:
        from kousoku.runtime.library import read_files, read_manifest

        try:
            return read_manifest(folder) == self.manifest and bool(
                read_files(folder, self.manifest)
            )
        except LoadError:
            return False
