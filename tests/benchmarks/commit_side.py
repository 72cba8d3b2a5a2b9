"""One of two commits that are compared: it measures what it is told, in a process of its own.

It runs with the other tree's kousoku as well as with this one's, ``python -P commit_side.py TREE``
with that tree in ``PYTHONPATH``, and asks nothing of it but its door. Each line of input is a
command in JSON, each line of output its answer.
"""

from __future__ import annotations

import json
import os
import struct
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

#: How a scene is moved, and how many rows a table of its motion has.
TOLERANCE, ROWS = 1e-8, 200
#: Evaluations that a kernel makes at once.
BATCH = 1000
#: The processor's time where that is fine enough.
IS_FINE = time.get_clock_info("process_time").resolution < 1e-6
CLOCK = time.process_time if IS_FINE else time.perf_counter
#: To explain more bodies takes minutes.
MOST_EXPLAINED = 150
#: Counts of a run by what is said of them.
COUNTS = {
    "evaluations": "derivatives",
    "factorisations": "factorisations",
    "corrections": "corrections",
    "steps": "steps",
}


class LoadedTree:
    """Modules that a tree has loaded, by name."""

    def __init__(self, tree: Path) -> None:
        import kousoku

        found = Path(kousoku.__file__).resolve()
        if not found.is_relative_to(tree.resolve()):
            raise RuntimeError(f"{found} is not of {tree}")
        self.kousoku: Any = kousoku
        self.tree = tree
        self.runs: dict[str, Callable[[], object]] = {}

    def answer(self, command: dict[str, Any]) -> dict[str, Any]:
        """Do what a command says; what this tree cannot do is said."""
        try:
            action = getattr(self, f"do_{command.pop('do')}")
            return dict(action(**command))
        except Exception as error:
            text = str(error).partition("\n")[0]
            return {"cannot": f"{type(error).__name__}: {text}"[:300]}

    def do_scene(
        self, name: str, file: str, end: float, counted: bool = False, cold: bool = False
    ) -> dict[str, Any]:
        """Load a scene; return what it can run, its counts, and where it is in the end."""
        if not hasattr(self.kousoku, "load"):
            return {"cannot": "older than kousoku.load"}
        start = time.perf_counter()
        mechanism = self.kousoku.load(file, target="c")
        loaded = time.perf_counter() - start
        if cold:
            return {"seconds": loaded}
        if not hasattr(mechanism.solver, "v"):  # a linkage of nodes
            self.runs[f"{name}: solve"] = mechanism.solve
            counts = self._sizes(name, mechanism) if counted else {}
            return {"runs": [f"{name}: solve"], "counts": counts, "end": []}
        run = mechanism.begin([end], checks=False, tolerance=TOLERANCE)

        def alone() -> None:
            run.restart()
            while run.advance(10**9, 10**6) > 0:
                pass

        def rows() -> object:
            return mechanism.simulate(end, samples=ROWS, tolerance=TOLERANCE)

        own = {f"{name}: C alone": alone, f"{name}: {ROWS} rows": rows}
        self.runs.update(own)
        more = self._counted(name, file, mechanism, end) if counted else {}
        return {"runs": list(own), "counts": {}, "end": [], **more}

    def _counted(self, name: str, file: str, mechanism: Any, end: float) -> dict[str, Any]:
        """Counts of a run, and where it ends in lengths of the scene."""
        result = mechanism.simulate(times=[end], tolerance=TOLERANCE)
        ledger = result.ledger
        counts = {
            what: float(getattr(ledger, key))
            for what, key in COUNTS.items()
            if hasattr(ledger, key)
        }
        if len(mechanism.solver.bodies) <= MOST_EXPLAINED:
            segments = self.kousoku.explain(file).as_data()["segments"]
            counts["operations"] = float(sum(segments.values()))
        length = mechanism.solver.length / mechanism.solver.unit
        places = np.concatenate([np.ravel(x[-1]) for x in result.position.values()]) / length
        return {"counts": counts | self._sizes(name, mechanism), "end": places.tolist()}

    def _sizes(self, name: str, mechanism: Any) -> dict[str, float]:
        """Bytes of the text in C, and of the machine code."""
        code = self._machine_code(Path(name).stem)
        if not hasattr(mechanism, "files"):  # an old commit
            return code
        c = [text for file, text in mechanism.files.items() if file.endswith((".c", ".h"))]
        return {"bytes in C": float(sum(map(len, c)))} | code

    def _machine_code(self, package: str) -> dict[str, float]:
        libraries = Path(os.environ["KOUSOKU_CACHE"]).glob(f"lib/{package}-*/*")
        sizes = [code_size(path.read_bytes()) for path in libraries if path.suffix != ".lock"]
        known = [size for size in sizes if size]
        return {"bytes of machine code": float(known[0])} if len(known) == 1 else {}

    def do_kernels(self, package: str, counted: bool = False) -> dict[str, Any]:
        """Load the kernels of a committed kind; return their operations and bytes.

        Of choices of rows, which are alike, the last is timed.
        """
        from kousoku.runtime import load, to_lanes

        library = load(self.tree / "generated" / "kinds" / package, target="c")
        counts: dict[str, float] = {}
        runs: dict[str, Callable[[], object]] = {}
        for kernel in library.manifest.kernels:
            counts[f"operations of {kernel.name}"] = float(sum(n for _, n in kernel.operations))
            if kernel.name.endswith(("_x", "_y")):
                continue
            own = library[kernel.name]
            rng = np.random.default_rng(1981)
            rows = [rng.normal(size=(BATCH, *q.shape)) for q in kernel.inputs]
            blocks = [to_lanes(array, own.lane_width) for array in rows]
            out = own.lanes(*blocks)
            one = own.bind(*(np.ascontiguousarray(array[0, ...]) for array in rows))
            runs[f"{package} {kernel.name}: lanes"] = _lanes(own, blocks, out)
            runs[f"{package} {kernel.name}: a call"] = one
        folder = library.folder
        counts["bytes in C"] = float(sum(len(p.read_bytes()) for p in folder.glob("*.c")))
        self.runs.update(runs)
        counts |= self._machine_code(package)
        return {"runs": list(runs), "counts": counts if counted else {}, "end": []}

    def do_time(self, what: str, count: int) -> dict[str, Any]:
        """Seconds of a call, of so many; some before them are not counted."""
        run = self.runs[what]
        for _ in range(count // 4 + 1):
            run()
        start = CLOCK()
        for _ in range(count):
            run()
        return {"seconds": (CLOCK() - start) / count}


def _lanes(kernel: Any, blocks: list[Any], out: Any) -> Callable[[], object]:
    return lambda: kernel.lanes(*blocks, out=out)


def code_size(data: bytes) -> int:
    """Bytes of the instructions in a shared library, 0 where it is none of ELF."""
    if data[:6] != b"\x7fELF\x02\x01":
        return 0
    (table,) = struct.unpack_from("<Q", data, 0x28)
    size, count = struct.unpack_from("<HH", data, 0x3A)
    total = 0
    for k in range(count):
        _, kind, flags = struct.unpack_from("<IIQ", data, table + k * size)
        (length,) = struct.unpack_from("<Q", data, table + k * size + 0x20)
        if kind == 1 and flags & 4:  # contents of the program, executable
            total += length
    return total


def main() -> None:
    """Answer commands until the input ends."""
    side = LoadedTree(Path(sys.argv[1]))
    for line in sys.stdin:
        print(json.dumps(side.answer(json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
