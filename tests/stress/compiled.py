"""A process that computes one thing and prints a digest of all bits.

``python -m tests.stress.compiled scene loop_free`` moves a committed scene; ``kind p2`` evaluates a
package at its references, ``random 7`` moves a random scene. The environment says with which
compiler.
"""

from __future__ import annotations

import hashlib
import os
import random
import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import numpy as np

import kousoku as ks
from kousoku.model.errors import KousokuError, LoadError, MotionError
from kousoku.runtime import toolchain
from kousoku.runtime.evaluate import evaluate, ways
from kousoku.runtime.library import load
from kousoku.runtime.reference import read_references
from kousoku.runtime.sources import Sources
from tests.random_scenes import random_scene
from tests.stress.journal import ROOT

if TYPE_CHECKING:
    from collections.abc import Iterator
    from contextlib import AbstractContextManager

SPOILT = "KOUSOKU_STRESS_FLAG"
"""A flag that takes the place of the one that forbids contraction: a fault that is planted."""
KINDS = ROOT / "generated" / "kinds"
END, ROWS, STEPS = 2.0, 21, 4000


def scene_of(sort: str, name: str) -> Any:
    """Scene, committed or random."""
    return (
        ROOT / "scenes" / f"{name}.toml" if sort == "scene" else random_scene(random.Random(name))
    )


def files_of(thing: str) -> dict[str, str] | None:
    """Sources in C of a thing; None where its random scene is refused."""
    sort, name = thing.split()
    if sort == "kind":
        folder = KINDS / name
        files = Sources.read(folder).files
        texts = {file: data.decode() for file, data in files.items()}
        texts["lanes.h"] = (ROOT / "runtime" / "lanes.h").read_text(encoding="utf-8")
    else:
        try:
            texts = ks.load(scene_of(sort, name)).files
        except KousokuError:
            return None
    return {file: text for file, text in texts.items() if file.endswith((".c", ".h"))}


def computed(sort: str, name: str) -> Iterator[np.ndarray[Any, Any]]:
    """All numbers of a thing."""
    if sort == "kind":
        folder = KINDS / name
        library, sources = load(folder, target="c"), Sources.read(folder)
        references = read_references(folder, sources.manifest, sources.files)
        for kernel in sources.manifest.kernels:
            for way in ways("c"):
                for one in evaluate(library[kernel.name], references[kernel.name], way):
                    yield one.values
        return
    scene = ks.load(scene_of(sort, name), target="c")
    try:
        result: Any = (
            scene.simulate(END, samples=ROWS, most_steps=STEPS)
            if scene.scene.is_spatial
            else scene.solve()
        )
    except MotionError as error:
        result = error.result
    for k in range(len(result)):
        yield from (np.asarray(part) for part in result.state(k))


@contextmanager
def contracting() -> Iterator[None]:
    """Compile products and sums into single instructions, here and in processes started here."""
    with patch.dict(os.environ, {SPOILT: "-ffp-contract=fast"}), spoilt():
        yield


def spoilt() -> AbstractContextManager[object]:
    """Compile with the flag of the environment in the place of the one that forbids contraction."""
    flag = os.environ.get(SPOILT, "-ffp-contract=off")
    flags = (flag if one == "-ffp-contract=off" else one for one in toolchain.FLAGS)
    return patch.object(toolchain, "FLAGS", tuple(flags))


def main() -> None:
    """Print the digest."""
    with spoilt():
        tell()


def tell() -> None:
    """Print the digest of what the command line names."""
    digest, count = hashlib.sha256(), 0
    try:
        for numbers in computed(*sys.argv[1:3]):
            values = np.where(np.isnan(numbers), np.nan, numbers)  # which NaN does not count
            digest.update(np.ascontiguousarray(values).tobytes())
            count += values.size
    except KousokuError as error:
        if sys.argv[1] != "random" or isinstance(error, LoadError):
            raise
        print(f"refused: {type(error).__name__}")
        return
    print(f"{count} numbers, {digest.hexdigest()[:16]}")


if __name__ == "__main__":
    main()
